//! Reconfigurations at any heading before the judge, by both manners and both criteria. `FLOTILLA_TURNED` sets how many problems.

use std::f64::consts::FRAC_PI_2;

use judge::verify;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;
use rov::conditions::Conditions;
use rov::planner::{OrderRule, PlanError, Planned, Request, plan};
use rov::power::PowerLaw;
use tests::seeds::{number, on_all_cores};
use tests::turned::problem;

const SEEDS: u64 = 8;
/// Where the paper's rule leads nowhere, all orders of so many robots are searched.
const SEARCHED: usize = 4;
const WAYS: [(Manner, Criterion); 4] = [
    (Manner::Best, Criterion::Energy),
    (Manner::Best, Criterion::Euclidean),
    (Manner::Paper, Criterion::Energy),
    (Manner::Paper, Criterion::Euclidean),
];

fn planned(
    problem: &Problem,
    (manner, criterion): (Manner, Criterion),
    order: OrderRule,
) -> Result<Planned, PlanError> {
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
    plan(problem, &Request { criterion, manner, order, law })
}

fn judged(problem: &Problem, planned: &Planned, what: &str) {
    let found = verify(problem, &planned.plan);
    assert!(found.is_empty(), "{what}: {}", found.iter().map(|v| format!("\n  {v}")).collect::<String>());
}

#[test]
fn plans_at_any_heading_pass_the_judge() {
    let seeds = number("FLOTILLA_TURNED").unwrap_or(SEEDS);
    let results = on_all_cores(0..seeds, |seed| {
        let problem = problem(&mut ChaCha8Rng::seed_from_u64(seed));
        WAYS.map(|way| {
            let what = format!("seed {seed}, {}, {way:?}", problem.description);
            let result = match planned(&problem, way, OrderRule::Paper) {
                Err(PlanError::DeadEnd { .. }) if problem.robots.len() <= SEARCHED => {
                    planned(&problem, way, OrderRule::Exact)
                }
                result => result,
            };
            match result {
                Ok(planned) => {
                    judged(&problem, &planned, &what);
                    true
                }
                Err(PlanError::DeadEnd { .. } | PlanError::Unreachable { .. }) => false,
                Err(error) => panic!("{what}: {error}"),
            }
        })
    });
    let mut plans = [0.0; WAYS.len()];
    for result in &results {
        for (plans, is_plan) in plans.iter_mut().zip(result) {
            *plans += f64::from(u8::from(*is_plan)) / results.len() as f64;
        }
    }
    println!("{seeds} problems; shares with a plan, all of which pass: {plans:.2?} by {WAYS:?}");
    // Slots at any heading do not lie on the paper's grid: between two neighbours there is often no way in along its edges.
    assert!(plans[0] >= 0.7 && plans[1] >= 0.7 && plans[2] >= 0.2 && plans[3] >= 0.2, "{plans:.2?}");
}

/// Two robots in line go to two slots side by side, a quarter turn away.
#[test]
fn two_robots_that_turn_pass_the_judge() {
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    let start = |id: u16| [f64::from(id - 1) * 0.483, 0.0, 5.0, 0.0].into();
    let slot = |y: f64| Slot { pose: [3.0, y, 5.0, FRAC_PI_2].into(), requires: Vec::new() };
    let problem = Problem {
        name: "min2".to_owned(),
        description: String::new(),
        vehicles: vec![robot],
        robots: [1, 2]
            .map(|id| Robot { id, vehicle: 0, start: start(id), capabilities: Vec::new() })
            .to_vec(),
        tools: Vec::new(),
        slots: vec![slot(0.0), slot(0.483)],
        rules: Rules::default(),
        bounds: None,
    };
    problem.check().expect("a sound problem");
    for way in WAYS {
        for order in [OrderRule::Paper, OrderRule::Exact] {
            let planned = planned(&problem, way, order).expect("a plan");
            judged(&problem, &planned, &format!("{way:?}, {order:?}"));
            assert_eq!(planned.plan.moves.len(), 2);
        }
    }
}
