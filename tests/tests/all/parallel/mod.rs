//! Parallel moves: random problems before the judge, what they save, and plans spoilt in time.

use judge::{Condition, verify};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use reconfiguration::plan::{Criterion, Manner, Plan};
use reconfiguration::problem::Problem;
use rov::parallel::overlapped;
use rov::planner::{OrderRule, PlanError, Request, plan};
use rov::power::PowerLaw;
use tests::figures::mean;
use tests::reconfigure::{Kind, problem};
use tests::seeds::on_all_cores;
use tests::shifted::{Shifted, shifted};

mod executed;

/// What a second is worth where time is what counts, J/s.
pub const TIME_W: f64 = 1e3;

/// A random problem with its plan of one robot after the other; `None` for a dead end of the order.
pub fn one_by_one(seed: u64) -> Option<(Problem, Plan, PowerLaw)> {
    let mut rng = ChaCha8Rng::seed_from_u64(4000 + seed);
    let mut problem = problem(Kind::random(&mut rng), &mut rng);
    // A grid that docked poses lie on, and that is quickly searched.
    problem.rules.grid_divisions = [1, 1, 1];
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
    let (criterion, manner, order) = (Criterion::Energy, Manner::Best, OrderRule::Paper);
    let request = Request { criterion, manner, order, law: law.clone() };
    match plan(&problem, &request) {
        Ok(planned) => Some((problem, planned.plan, law)),
        Err(PlanError::DeadEnd { .. }) => None,
        Err(error) => panic!("seed {seed}: {error}"),
    }
}

fn judged(problem: &Problem, plan: &Plan, what: &str) {
    let found = verify(problem, plan);
    assert!(found.is_empty(), "{what}: {}", found.iter().map(|v| format!("\n  {v}")).collect::<String>());
}

#[test]
fn over_fifty_random_problems_time_is_saved_and_no_energy_spent() {
    const SEEDS: u64 = 50;
    let results = on_all_cores(0..SEEDS, |seed| {
        let (problem, plan, law) = one_by_one(seed)?;
        let [by_time, by_energy] =
            [TIME_W, 0.0].map(|weight_w| overlapped(&problem, &plan, &law, weight_w).expect("robots"));
        let what = format!("seed {seed}, {} robots, {} tools", problem.robots.len(), problem.tools.len());
        for together in [&by_time, &by_energy] {
            judged(&problem, together, &what);
            assert!(together.energy_total_j <= plan.energy_total_j * (1.0 + 1e-6), "{what}");
        }
        assert!(by_time.time_s <= plan.time_s * (1.0 + 1e-9), "{what}");
        // Of nearly equal energies the quicker is taken.
        assert!(by_energy.energy_total_j <= by_time.energy_total_j * (1.0 + 1e-3), "{what}");
        let share = by_time.time_s / plan.time_s;
        let saved = by_energy.energy_total_j / plan.energy_total_j;
        println!(
            "{what}: {} moves, {:.1} J in {:.1} s; by time {:.1} J in {:.1} s, {share:.3}; by energy {:.1} J in {:.1} s, {saved:.3}",
            plan.moves.len(),
            plan.energy_total_j,
            plan.time_s,
            by_time.energy_total_j,
            by_time.time_s,
            by_energy.energy_total_j,
            by_energy.time_s
        );
        Some((share, saved))
    });
    let results: Vec<(f64, f64)> = results.into_iter().flatten().collect();
    let (share, saved) =
        (mean(results.iter().map(|(share, _)| *share)), mean(results.iter().map(|(_, saved)| *saved)));
    println!(
        "{} plans: {share:.3} of the time; {saved:.3} of the energy where that is what counts",
        results.len()
    );
    assert!(results.len() as u64 >= SEEDS - 2, "{} plans", results.len());
    assert!(share <= 0.6, "{share} of the time of one robot after the other");
}

/// Start times shifted and actions slowed down at random, all times and sums in order: a plan that passes keeps every pair of robots apart
/// in fine samples of it, one that is refused does not.
#[test]
fn plans_shifted_in_time_are_refused_where_robots_meet_and_pass_where_not() {
    const SEEDS: u64 = 24;
    let results = on_all_cores(0..SEEDS, |seed| {
        let Some((problem, plan, law)) = one_by_one(seed) else { return [0; 3] };
        let together = overlapped(&problem, &plan, &law, TIME_W).expect("robots");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut refused, mut passed, mut unbalanced) = (0, 0, 0);
        if !together.is_parallel() {
            return [0; 3];
        }
        for case in 0..12 {
            let Some(Shifted { plan, margin_m, balanced }) = shifted(&problem, &together, &law, &mut rng)
            else {
                continue;
            };
            let found = verify(&problem, &plan);
            let what = format!("seed {seed}, case {case}: margin {margin_m:.4} m, {found:?}");
            let names: Vec<Condition> = found.iter().map(|violation| violation.condition).collect();
            assert!(
                names.iter().all(|name| matches!(name, Condition::V3 | Condition::V4 | Condition::V6)),
                "{what}"
            );
            // Samples and the judge may differ by what robots move between two looks.
            if margin_m < -0.01 {
                refused += 1;
                assert!(names.contains(&Condition::V3), "{what}");
            } else if margin_m > 0.01 {
                passed += usize::from(balanced);
                assert!(!names.contains(&Condition::V3), "{what}");
            }
            unbalanced += usize::from(!balanced);
            assert_eq!(balanced, !names.iter().any(|name| *name != Condition::V3), "{what}");
        }
        [refused, passed, unbalanced]
    });
    let sum = |k: usize| results.iter().map(|counts| counts[k]).sum::<usize>();
    let (refused, passed, unbalanced) = (sum(0), sum(1), sum(2));
    println!("{refused} refused for clearance, {passed} pass, {unbalanced} cannot be balanced");
    assert!(refused + passed + unbalanced >= 100 && refused >= 30 && passed >= 10);
}
