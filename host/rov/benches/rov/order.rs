//! The order of moves of four, six and eight robots, row to row beside it, to the proof or 2 000 moves priced.

use std::hint::black_box;

use criterion::Criterion as Bench;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;
use rov::order::{InTurn, Patience};
use rov::planner::{OrderRule, Request, plan_with};
use rov::power::PowerLaw;

/// A row of robots to the same row, 3 m aside.
fn rows(robots: u16) -> Problem {
    let pose = |n: u16, y: f64| Pose::from([0.483 * f64::from(n), y, 5.0, 0.0]);
    let robot = |n: u16| Robot { id: n + 1, vehicle: 0, start: pose(n, 0.0), capabilities: Vec::new() };
    Problem {
        name: "rows".to_owned(),
        description: String::new(),
        vehicles: vec![Vehicle::built_in("bluerov1").expect("it comes with the program")],
        robots: (0..robots).map(robot).collect(),
        tools: Vec::new(),
        slots: (0..robots).map(|n| Slot { pose: pose(n, 3.0), requires: Vec::new() }).collect(),
        rules: Rules::default(),
        bounds: None,
    }
}

/// The lines.
pub fn order(bench: &mut Bench) {
    let mut group = bench.benchmark_group("order of moves, row to row");
    group.sample_size(10);
    for robots in [4, 6, 8] {
        let problem = rows(robots);
        let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
        let request =
            Request { criterion: Criterion::Energy, manner: Manner::Best, order: OrderRule::Exact, law };
        group.bench_function(format!("{robots} robots"), |b| {
            b.iter(|| {
                plan_with(black_box(&problem), &request, &InTurn, &mut Patience(2_000)).expect("a plan")
            });
        });
    }
    group.finish();
}
