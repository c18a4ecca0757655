//! Two robots one behind the other, by hand, under way together.

use std::collections::BTreeSet;

use reconfiguration::plan::{Action, ActionKind, Criterion, Interval, Manner, Move, Placed, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;

use super::super::Condition;
use super::super::tests::{broken, shift};

/// One behind the other, docked end to end, to go 4 m ahead.
fn problem() -> Problem {
    let robot = |id: u16, x: f64| Robot {
        id,
        vehicle: 0,
        start: Pose::from([x, 0.0, 0.0, 0.0]),
        capabilities: Vec::new(),
    };
    let slot = |x: f64| Slot { pose: Pose::from([x, 0.0, 0.0, 0.0]), requires: Vec::new() };
    Problem {
        name: "two".to_owned(),
        description: String::new(),
        vehicles: vec![Vehicle::built_in("bluerov1").expect("built in")],
        robots: vec![robot(1, 0.0), robot(2, 0.483)],
        tools: Vec::new(),
        slots: vec![slot(4.0), slot(4.483)],
        rules: Rules::default(),
        bounds: None,
    }
}

/// Both go straight to their slots; the second, which is ahead, `late_s` after the first.
fn plan(problem: &Problem, late_s: f64) -> Plan {
    let mut moves: Vec<Move> = [(0, 0, 0.0), (1, 1, late_s)]
        .into_iter()
        .map(|(robot, slot, start_s)| {
            let (from, to) = (problem.robots[robot].start, problem.slots[slot].pose);
            let squares: f64 = (0..3).map(|k| (to.position_m[k] - from.position_m[k]).powi(2)).sum();
            let (way_m, speed, a) = (squares.sqrt(), 0.3, 0.2);
            let mut now_s = start_s;
            let actions: Vec<Action> =
                [(ActionKind::Undock, from, from), (ActionKind::Leg, from, to), (ActionKind::Dock, to, to)]
                    .into_iter()
                    .map(|(kind, from, to)| {
                        let leg = kind == ActionKind::Leg;
                        let duration_s = if leg { way_m / speed + speed / a } else { 0.0 };
                        let speed = if leg { speed } else { 0.0 };
                        let acceleration = leg.then_some(a);
                        let start_s = now_s;
                        now_s += duration_s;
                        Action { kind, start_s, duration_s, from, to, speed, acceleration, energy_j: 1.0 }
                    })
                    .collect();
            Move {
                robot: problem.robots[robot].id,
                slot: Some(slot),
                to: None,
                path: vec![from.position_m, to.position_m],
                start_s,
                duration_s: now_s - start_s,
                energy_navigate_j: 3.0,
                energy_balance_j: 0.0,
                balance_w: 0.0,
                balance: Vec::new(),
                actions,
            }
        })
        .collect();
    moves.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    let mut cuts: Vec<f64> =
        moves.iter().flat_map(|own| [own.start_s, own.start_s + own.duration_s]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let interval = |cut: &[f64]| Interval {
        start_s: cut[0],
        duration_s: cut[1] - cut[0],
        balance_w: 0.0,
        balance: Vec::new(),
    };
    Plan {
        problem: problem.name.clone(),
        criterion: Criterion::Energy,
        manner: Manner::Best,
        robots: problem.robots.iter().map(|robot| Placed { id: robot.id, start: robot.start }).collect(),
        slots: problem.slots.iter().map(|slot| slot.pose).collect(),
        intervals: cuts.windows(2).map(interval).collect(),
        time_s: cuts.last().copied().unwrap_or_default(),
        moves,
        energy_navigate_j: 6.0,
        energy_balance_j: 0.0,
        energy_total_j: 6.0,
        lower_bound_j: None,
        gap: None,
        proved: None,
    }
}

/// The whole plan later.
fn shift_all(plan: &mut Plan, by_s: f64) {
    plan.moves.iter_mut().for_each(|own| shift(own, by_s));
    plan.intervals.iter_mut().for_each(|interval| interval.start_s += by_s);
    plan.time_s += by_s;
}

/// In the open they keep d = 0.7245 m, docked they are 0.483 m apart: at 0.3 m/s the one behind may follow 0.8 s later and a ramp.
#[test]
fn the_clearance_of_robots_under_way_is_judged_in_time() {
    let problem = problem();
    for (late_s, kept) in [(-4.0, true), (-1.5, true), (-0.3, false), (0.0, false), (2.0, false)] {
        let mut plan = plan(&problem, late_s);
        // Time begins with the first of them.
        let first_s = plan.moves[0].start_s;
        shift_all(&mut plan, -first_s);
        let (conditions, told) = broken(&problem, &plan);
        let expected = if kept { BTreeSet::new() } else { BTreeSet::from([Condition::V3]) };
        assert_eq!(conditions, expected, "{late_s} s late:\n{told}");
    }
}

#[test]
fn what_is_wrong_in_time_is_named() {
    use Condition::{Energy, Timing, V1, V3};
    let problem = problem();
    let good = || {
        let mut plan = plan(&problem, -4.0);
        shift_all(&mut plan, 4.0);
        plan
    };
    assert_eq!(broken(&problem, &good()).1, "");
    type Spoil = fn(&mut Plan);
    let spoilt: &[(&str, Spoil, &[Condition])] = &[
        ("before time", |plan| shift_all(plan, -1.0), &[Timing]),
        (
            "a move begins within an interval",
            |plan| {
                let own = &mut plan.moves[1];
                shift(own, 0.5);
                let (last, end_s) = (plan.intervals.len() - 1, own.start_s + own.duration_s);
                plan.intervals[last].duration_s = end_s - plan.intervals[last].start_s;
                plan.time_s = end_s;
            },
            &[Timing],
        ),
        ("an interval is left out", |plan| drop(plan.intervals.remove(1)), &[Timing]),
        ("the end is another", |plan| plan.time_s += 1.0, &[Timing]),
        ("balance for nothing", |plan| plan.intervals[1].balance_w = 3.0, &[Energy]),
        ("by the paper's rules", |plan| plan.manner = Manner::Paper, &[V1]),
        ("a robot twice at once", |plan| plan.moves[1].robot = plan.moves[0].robot, &[V1, Condition::V5]),
        ("the order is another", |plan| plan.moves.swap(0, 1), &[Timing]),
        ("both at once", |plan| shift(&mut plan.moves[1], -3.9), &[Timing, V3]),
    ];
    for (what, spoil, expected) in spoilt {
        let mut plan = good();
        spoil(&mut plan);
        let (conditions, told) = broken(&problem, &plan);
        assert!(expected.iter().all(|condition| conditions.contains(condition)), "{what}:\n{told}");
    }
}
