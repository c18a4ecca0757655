//! By hand: what overlaps, what balances then, and what does not pay.

use reconfiguration::plan::Criterion;
use reconfiguration::plan::Manner;
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::Vehicle;

use super::super::planner::{OrderRule, Request, plan};
use super::*;

fn problem(starts: &[[f64; 4]], slots: &[[f64; 4]], tool: Option<[f64; 4]>) -> Problem {
    let vehicles = ["bluerov1", "tool-20n"].map(|name| Vehicle::built_in(name).expect("built in")).to_vec();
    let robot = |(index, pose): (usize, &[f64; 4])| Robot {
        id: index as u16 + 1,
        vehicle: 0,
        start: Pose::from(*pose),
        capabilities: Vec::new(),
    };
    Problem {
        name: "by hand".to_owned(),
        description: String::new(),
        vehicles,
        robots: starts.iter().enumerate().map(robot).collect(),
        tools: tool.map(|pose| Tool { vehicle: 1, pose: pose.into() }).into_iter().collect(),
        slots: slots.iter().map(|pose| Slot { pose: Pose::from(*pose), requires: Vec::new() }).collect(),
        rules: Rules { grid_divisions: [1, 1, 1], ..Rules::default() },
        bounds: None,
    }
}

fn both(problem: &Problem, weight_w: f64) -> (Plan, Plan) {
    let law = PowerLaw::fitted(16.0).expect("in the table");
    let request = Request {
        criterion: Criterion::Energy,
        manner: Manner::Best,
        order: OrderRule::Exact,
        law: law.clone(),
    };
    let one_by_one = plan(problem, &request).expect("planned").plan;
    let together = overlapped(problem, &one_by_one, &law, weight_w).expect("robots");
    (one_by_one, together)
}

const L: f64 = 0.483;
const W: f64 = 0.33;

/// Four in a row with nothing to balance: they leave almost together, and take no more energy.
#[test]
fn robots_that_have_nothing_to_balance_leave_together() {
    let row = |x: f64| [0.0, 1.0, 2.0, 3.0].map(|k| [x, k * W, 0.0, 0.0]);
    let (one_by_one, together) = both(&problem(&row(0.0), &row(6.0 * L), None), 1e3);
    println!(
        "{:.1} s, {:.1} J; {:.1} s, {:.1} J",
        one_by_one.time_s, one_by_one.energy_total_j, together.time_s, together.energy_total_j
    );
    assert!(together.is_parallel() && !one_by_one.is_parallel());
    assert!(together.time_s < 0.6 * one_by_one.time_s, "{} s of {} s", together.time_s, one_by_one.time_s);
    assert!(together.energy_total_j <= one_by_one.energy_total_j * (1.0 + 1e-9));
    let end_s: f64 = together.intervals.iter().map(|interval| interval.duration_s).sum();
    assert!((end_s - together.time_s).abs() < 1e-9);
    let shares: f64 = together.moves.iter().map(|own| own.energy_balance_j).sum();
    let drawn: f64 = together.intervals.iter().map(|i| i.duration_s * i.balance_w).sum();
    assert!((shares - drawn).abs() < 1e-9);
}

/// With a tool to balance one robot at least stays, and what a second costs is paid once.
#[test]
fn a_tool_is_never_left_alone_and_balance_is_shared() {
    let starts = [[-L, 0.0, 0.0, 0.0], [L, 0.0, 0.0, 0.0], [0.0, W, 0.0, 0.0], [0.0, -W, 0.0, 0.0]];
    let slots =
        [[0.0, W, 0.0, 0.0], [0.0, -W, 0.0, 0.0], [0.0, 2.0 * W, 0.0, 0.0], [0.0, -2.0 * W, 0.0, 0.0]];
    let (one_by_one, together) = both(&problem(&starts, &slots, Some([0.0; 4])), 0.0);
    println!(
        "{:.1} s, {:.1} J; {:.1} s, {:.1} J",
        one_by_one.time_s, one_by_one.energy_total_j, together.time_s, together.energy_total_j
    );
    assert!(together.energy_total_j <= one_by_one.energy_total_j);
    assert!(
        together.intervals.iter().all(|interval| !interval.balance.is_empty() && interval.balance_w > 0.0)
    );
    // The same again is the same.
    assert_eq!(both(&problem(&starts, &slots, Some([0.0; 4])), 0.0).1, together);
}
