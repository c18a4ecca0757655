//! Whether robots that wait have to stay one cluster: how many plans fall apart where the rule is off, and none where it is
//! on.

use judge::{Condition, verify};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::problem::Problem;
use rov::planner::{OrderRule, PlanError, Planned, Request, plan};
use rov::power::PowerLaw;
use tests::reconfigure::{Kind, problem};
use tests::seeds::on_all_cores;

fn planned(problem: &Problem) -> Result<Planned, PlanError> {
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
    let (criterion, manner, order) = (Criterion::Energy, Manner::Paper, OrderRule::Exact);
    plan(problem, &Request { criterion, manner, order, law })
}

#[test]
fn what_waits_falls_apart_only_where_the_rule_allows_it() {
    const SEEDS: u64 = 24;
    let results = on_all_cores(0..SEEDS, |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(3000 + seed);
        let kind = Kind { robots: 4, tool: seed & 1 == 0, spatial: seed & 2 == 0 };
        let mut free = problem(kind, &mut rng);
        free.rules.grid_divisions = [1, 1, 1];
        let mut bound = free.clone();
        bound.rules.one_cluster = true;
        let (loose, held) = (planned(&free), planned(&bound));
        // Judged by the other rule, a plan that falls apart is named.
        let parts = loose.as_ref().ok().map(|planned| {
            assert!(verify(&free, &planned.plan).is_empty(), "seed {seed}");
            let found = verify(&bound, &planned.plan);
            assert!(found.iter().all(|v| v.condition == Condition::Connection), "seed {seed}: {found:?}");
            !found.is_empty()
        });
        if let Ok(held) = &held {
            let found = verify(&bound, &held.plan);
            assert!(found.is_empty(), "seed {seed}: {found:?}");
            let loose = loose.as_ref().expect("what keeps the rule needs none");
            assert!(
                loose.cost <= held.cost * (1.0 + 1e-9),
                "seed {seed}: {} above {}",
                loose.cost,
                held.cost
            );
        }
        (parts, held.is_ok())
    });
    let plans = results.iter().filter(|result| result.0.is_some()).count();
    let apart = results.iter().filter(|result| result.0 == Some(true)).count();
    let kept = results.iter().filter(|result| result.1).count();
    println!("{plans} plans of {SEEDS}, {apart} of them wait in several clusters; {kept} keep one cluster");
    assert!(plans > 20 && apart > 0 && kept > 0, "{plans} plans, {apart} apart, {kept} kept");
}
