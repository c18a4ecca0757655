//! The judge on a plan written by hand, good and spoilt.

mod edge;

use std::collections::BTreeSet;

use reconfiguration::body;
use reconfiguration::plan::{Action, ActionKind, Criterion, Holding, Placed};
use reconfiguration::problem::{Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::Thruster;
use rov::conditions::Conditions;

use super::*;

const TOP_M: f64 = -0.8;

/// Two pairs of upright thrusters, 0.1 m before and behind the centre.
fn hull(name: &str, mass_kg: f64, thrusters: bool) -> Vehicle {
    let thruster = |x: f64| Thruster {
        position_m: [x, 0.0, 0.0],
        direction: [0.0, 0.0, 1.0],
        reversed: false,
        failed: false,
    };
    Vehicle {
        name: name.to_owned(),
        box_m: [0.4, 0.3, 0.2],
        body: body::Body {
            mass_kg,
            weight_n: mass_kg * body::GRAVITY_M_S2,
            buoyancy_n: mass_kg * body::GRAVITY_M_S2,
            r_g_m: [0.0; 3],
            r_b_m: [0.0; 3],
            inertia_kg_m2: [1.0; 3],
            added_mass: [0.0; 6],
            linear_damping: [0.0; 6],
            quadratic_damping: [0.0; 6],
        },
        thrusters: if thrusters { [0.1, -0.1, 0.1, -0.1].map(thruster).to_vec() } else { Vec::new() },
        connectors: Vec::new(),
        capabilities: Vec::new(),
    }
}

/// A tool of 20 N, centre of gravity 3 cm ahead; robot 1 behind it, robot 2 to its right. Goal: before it, to its left.
fn problem() -> Problem {
    let robot = |id, start: [f64; 4]| Robot { id, vehicle: 0, start: start.into(), capabilities: Vec::new() };
    let slot = |pose: [f64; 4]| Slot { pose: pose.into(), requires: Vec::new() };
    let mut tool = hull("tool", 20.0 / 9.806_65, false);
    tool.body.r_g_m[0] = 0.03;
    Problem {
        name: "by hand".to_owned(),
        description: String::new(),
        vehicles: vec![hull("robot", 3.0, true), tool],
        robots: vec![robot(1, [-0.4, 0.0, 0.0, 0.0]), robot(2, [0.0, 0.3, 0.0, 0.0])],
        tools: vec![Tool { vehicle: 1, pose: Pose::default() }],
        slots: vec![slot([0.4, 0.0, 0.0, 0.0]), slot([0.0, -0.3, 0.0, 0.0])],
        rules: Rules { undock_s: 1.0, dock_s: 2.0, ..Rules::default() },
        bounds: None,
    }
}

/// How a robot of the plan by hand goes: up, turning on the way if it likes, over and down.
#[derive(Clone, Copy)]
struct Way {
    robot: u16,
    slot: usize,
    top_m: f64,
    /// Turn by a radian before (false) or after (true) going up, and back on the other side.
    turn: Option<bool>,
}

const WAYS: [Way; 2] = [
    Way { robot: 1, slot: 0, top_m: TOP_M, turn: None },
    Way { robot: 2, slot: 1, top_m: TOP_M, turn: Some(true) },
];

/// From rest to rest, by the rules of [`Rules`]; the same by hand as in the table of the module.
fn action(manner: Manner, kind: ActionKind, from: Pose, to: Pose) -> Action {
    let (speed, a) = if kind == ActionKind::Turn { (0.8, 1.0) } else { (0.3, 0.2) };
    let way = if kind == ActionKind::Turn { 1.0 } else { distance_m(from.position_m, to.position_m) };
    let duration_s = match (kind, manner) {
        (ActionKind::Undock, _) => 1.0,
        (ActionKind::Dock, _) => 2.0,
        (_, Manner::Paper) => way / speed,
        _ if way == 0.0 => 0.0,
        _ if way < speed * speed / a => 2.0 * f64::sqrt(way / a),
        _ => way / speed + speed / a,
    };
    let acceleration = (manner == Manner::Best).then_some(a);
    Action { kind, start_s: 0.0, duration_s, from, to, speed, acceleration, energy_j: 5.0 }
}

fn plan(problem: &Problem, manner: Manner, ways: &[Way]) -> Plan {
    let mut at: Vec<(u16, Pose)> = problem.robots.iter().map(|robot| (robot.id, robot.start)).collect();
    let mut moves = Vec::new();
    for way in ways {
        let own = at.iter().position(|(id, _)| *id == way.robot).expect("a robot");
        let (start, slot) = (at[own].1, problem.slots[way.slot].pose);
        let over =
            |pose: Pose| Pose { position_m: [pose.position_m[0], pose.position_m[1], way.top_m], ..pose };
        let turned = |pose: Pose| Pose { yaw_rad: pose.yaw_rad + 1.0, ..pose };
        use ActionKind::{Dock, Leg, Turn, Undock};
        let up = over(start);
        let steps = match way.turn {
            None => vec![(Undock, start), (Leg, up), (Leg, over(slot)), (Leg, slot), (Dock, slot)],
            Some(true) => vec![
                (Undock, start),
                (Leg, up),
                (Turn, turned(up)),
                (Leg, turned(over(slot))),
                (Turn, over(slot)),
                (Leg, slot),
                (Dock, slot),
            ],
            Some(false) => vec![
                (Undock, start),
                (Turn, turned(start)),
                (Leg, turned(up)),
                (Leg, turned(over(slot))),
                (Turn, over(slot)),
                (Leg, slot),
                (Dock, slot),
            ],
        };
        let mut here = start;
        let mut actions = Vec::new();
        for (kind, to) in steps {
            actions.push(action(manner, kind, here, to));
            here = to;
        }
        // 0.6 N·m nose down by the tool: 3 N down behind, 3 N up before.
        let waiting = at.iter().map(|(id, _)| *id).filter(|id| *id != way.robot);
        let balance = waiting.take(1).map(|robot| Holding { robot, thrusts_n: vec![-3.0, 3.0, 0.0, 0.0] });
        moves.push(Move {
            robot: way.robot,
            slot: Some(way.slot),
            to: None,
            path: vec![start, up, over(slot), slot].into_iter().map(|pose| pose.position_m).collect(),
            start_s: 0.0,
            duration_s: 0.0,
            energy_navigate_j: 0.0,
            energy_balance_j: 0.0,
            balance_w: 1.5,
            balance: balance.collect(),
            actions,
        });
        at[own].1 = slot;
    }
    let robots = problem.robots.iter().map(|robot| Placed { id: robot.id, start: robot.start }).collect();
    let mut plan = Plan {
        problem: problem.name.clone(),
        criterion: Criterion::Energy,
        manner,
        robots,
        slots: problem.slots.iter().map(|slot| slot.pose).collect(),
        moves,
        intervals: Vec::new(),
        energy_navigate_j: 0.0,
        energy_balance_j: 0.0,
        energy_total_j: 0.0,
        time_s: 0.0,
        lower_bound_j: None,
        gap: None,
        proved: None,
    };
    account(&mut plan);
    plan
}

/// Times and sums from durations, energies of actions and powers.
fn account(plan: &mut Plan) {
    let mut now_s = 0.0;
    for own in &mut plan.moves {
        own.start_s = now_s;
        for action in &mut own.actions {
            action.start_s = now_s;
            now_s += action.duration_s;
        }
        own.duration_s = now_s - own.start_s;
        own.energy_navigate_j = own.actions.iter().map(|action| action.energy_j).sum();
        own.energy_balance_j = own.balance_w * own.duration_s;
    }
    plan.energy_navigate_j = plan.moves.iter().map(|own| own.energy_navigate_j).sum();
    plan.energy_balance_j = plan.moves.iter().map(|own| own.energy_balance_j).sum();
    plan.energy_total_j = plan.energy_navigate_j + plan.energy_balance_j;
    plan.time_s = now_s;
}

pub(crate) fn shift(own: &mut Move, by_s: f64) {
    own.start_s += by_s;
    own.actions.iter_mut().for_each(|action| action.start_s += by_s);
}

pub(crate) fn broken(problem: &Problem, plan: &Plan) -> (BTreeSet<Condition>, String) {
    let found = verify(problem, plan);
    let told: Vec<String> = found.iter().map(ToString::to_string).collect();
    (found.into_iter().map(|violation| violation.condition).collect(), told.join("\n"))
}

#[test]
fn the_plan_by_hand_keeps_every_condition() {
    let problem = problem();
    problem.check().expect("a sound problem");
    let best = plan(&problem, Manner::Best, &WAYS);
    assert_eq!(broken(&problem, &best).1, "");
    assert_eq!(note(&best), None);
    // Up 0.8 m: 0.8/0.3 + 0.3/0.2 s; a radian: 1/0.8 + 0.8 s; undock and dock.
    assert!((best.moves[0].duration_s - (3.0 * (0.8 / 0.3 + 1.5) + 3.0)).abs() < 1e-12);
    // By the paper's rules a hull may turn where it is docked, and that is said.
    let ways = [Way { turn: Some(false), ..WAYS[0] }, WAYS[1]];
    let paper = plan(&problem, Manner::Paper, &ways);
    assert_eq!(broken(&problem, &paper).1, "");
    assert!(note(&paper).is_some());
}

/// A centimetre less than (19) asks is seen, a centimetre more is not.
#[test]
fn clearance_is_kept_to_the_centimetre() {
    let problem = problem();
    // d = 1.5·0.4 m, right above the tool.
    for (top_m, kept) in [(-0.61, true), (-0.59, false)] {
        let plan = plan(&problem, Manner::Best, &[Way { top_m, ..WAYS[0] }, WAYS[1]]);
        let (conditions, told) = broken(&problem, &plan);
        assert_eq!(conditions.is_empty(), kept, "{told}");
        assert!(kept || told.contains("clearance to tool 1 0.590 m at least, 0.600 m"), "{told}");
    }
}

#[test]
fn every_spoilt_plan_is_rejected_for_the_right_reason() {
    use Condition::*;
    type Spoil = fn(&mut Problem) -> Plan;
    fn good(problem: &Problem) -> Plan {
        plan(problem, Manner::Best, &WAYS)
    }
    let spoilt: &[(&str, Spoil, &[Condition])] = &[
        ("another problem", |p| Plan { problem: "other".to_owned(), ..good(p) }, &[Identity]),
        (
            "start moved",
            |p| {
                let mut plan = good(p);
                plan.robots[0].start.position_m[0] += 0.1;
                plan
            },
            &[Identity],
        ),
        (
            "sets out from elsewhere",
            |p| {
                let plan = good(p);
                p.robots[0].start.position_m[2] = 0.01;
                let robots = vec![Placed { id: 1, start: p.robots[0].start }, plan.robots[1].clone()];
                Plan { robots, ..plan }
            },
            &[V1],
        ),
        (
            "slots swapped",
            |p| {
                let mut plan = good(p);
                (plan.moves[0].slot, plan.moves[1].slot) = (Some(1), Some(0));
                plan
            },
            &[V1, V3],
        ),
        (
            "no such slot",
            |p| {
                let mut plan = good(p);
                plan.moves[1].slot = Some(2);
                plan
            },
            &[Identity],
        ),
        (
            "corner moved into a box",
            |p| plan(p, Manner::Best, &[Way { top_m: -0.15, ..WAYS[0] }, WAYS[1]]),
            &[V3],
        ),
        (
            "outside the water",
            // The water ends 1.2 m above the boxes, at −1.3 m; the box reaches 0.1 m above its centre.
            |p| plan(p, Manner::Best, &[WAYS[0], Way { top_m: -1.21, ..WAYS[1] }]),
            &[Bounds],
        ),
        (
            "two movers at once",
            |p| {
                let mut plan = good(p);
                shift(&mut plan.moves[1], -1.0);
                plan.time_s -= 1.0;
                plan
            },
            &[V1],
        ),
        (
            "a pause between moves",
            |p| {
                let mut plan = good(p);
                shift(&mut plan.moves[1], 1.0);
                plan.time_s += 1.0;
                plan
            },
            &[Timing],
        ),
        (
            "a robot jumps",
            |p| {
                let mut plan = good(p);
                plan.moves[0].actions.remove(2);
                account(&mut plan);
                plan
            },
            &[Continuity],
        ),
        (
            "a corner of the path is another",
            |p| {
                let mut plan = good(p);
                plan.moves[0].path[1][2] -= 0.1;
                plan
            },
            &[Continuity],
        ),
        (
            "tool abandoned",
            |p| {
                p.robots[1].start = [-0.8, 0.0, 0.0, 0.0].into();
                good(p)
            },
            &[V4, V6],
        ),
        (
            "capability ignored",
            |p| {
                p.slots[1].requires.push("sonar".to_owned());
                p.robots[0].capabilities.push("sonar".to_owned());
                good(p)
            },
            &[V2],
        ),
        ("a robot moves twice", |p| plan(p, Manner::Best, &[WAYS[0], WAYS[1], WAYS[0]]), &[V5]),
        (
            "undocking under way",
            |p| {
                let mut plan = good(p);
                let actions = &mut plan.moves[0].actions;
                let mut undock = actions.remove(0);
                (undock.from, undock.to) = (actions[0].to, actions[0].to);
                actions.insert(1, undock);
                account(&mut plan);
                plan
            },
            &[V5],
        ),
        (
            "balance missing",
            |p| {
                let mut plan = good(p);
                plan.moves[0].balance.clear();
                plan
            },
            &[V6],
        ),
        (
            "balance a little off",
            |p| {
                let mut plan = good(p);
                plan.moves[0].balance[0].thrusts_n[0] *= 1.0 + 1e-5;
                plan
            },
            &[V6],
        ),
        (
            "the mover balances too",
            |p| {
                let mut plan = good(p);
                plan.moves[0].balance.push(Holding { robot: 1, thrusts_n: vec![0.0; 4] });
                plan
            },
            &[V6],
        ),
        (
            "balance beyond the limits",
            |p| {
                let mut plan = good(p);
                plan.moves[1].balance[0].thrusts_n = vec![-38.0, 55.0, 35.0, -52.0];
                plan
            },
            &[Thrusters],
        ),
        (
            "duration wrong",
            |p| {
                let mut plan = good(p);
                plan.moves[0].actions[1].duration_s += 0.01;
                account(&mut plan);
                plan
            },
            &[Kinematics],
        ),
        (
            "faster to speed than the rules allow",
            |p| {
                let mut plan = good(p);
                let leg = &mut plan.moves[0].actions[1];
                leg.acceleration = Some(0.4);
                leg.duration_s = 0.8 / 0.3 + 0.3 / 0.4;
                account(&mut plan);
                plan
            },
            &[Kinematics],
        ),
        (
            "faster than the rules allow",
            |p| {
                let mut plan = good(p);
                let leg = &mut plan.moves[0].actions[1];
                leg.speed = 0.6;
                leg.duration_s = 2.0 * f64::sqrt(0.8 / 0.2);
                account(&mut plan);
                plan
            },
            &[Kinematics],
        ),
        (
            "docking takes no time",
            |p| {
                let mut plan = good(p);
                plan.moves[0].actions[4].duration_s = 0.0;
                account(&mut plan);
                plan
            },
            &[Kinematics],
        ),
        (
            "heading changed on a leg",
            |p| {
                let mut plan = good(p);
                plan.moves[1].actions[3].to.yaw_rad = 0.9;
                plan.moves[1].actions[4].from.yaw_rad = 0.9;
                plan
            },
            &[Kinematics],
        ),
        (
            "times do not follow",
            |p| {
                let mut plan = good(p);
                plan.moves[0].actions[2].start_s += 0.5;
                plan
            },
            &[Timing],
        ),
        ("sum wrong", |p| Plan { energy_total_j: 1.0, ..good(p) }, &[Energy]),
        (
            "energy gained",
            |p| {
                let mut plan = good(p);
                plan.moves[0].actions[1].energy_j = -5.0;
                account(&mut plan);
                plan
            },
            &[Energy],
        ),
        (
            "turned while docked",
            |p| plan(p, Manner::Best, &[Way { turn: Some(false), ..WAYS[0] }, WAYS[1]]),
            &[V3],
        ),
        ("slot taken twice", |p| plan(p, Manner::Best, &[WAYS[0], Way { slot: 0, ..WAYS[1] }]), &[V1, V3]),
        ("a robot left behind", |p| plan(p, Manner::Best, &WAYS[..1]), &[V1]),
        (
            "what is reached falls apart",
            |p| {
                p.slots[1].pose.position_m[1] = -0.35;
                good(p)
            },
            &[Connection],
        ),
        (
            "not a number",
            |p| {
                let mut plan = good(p);
                plan.moves[1].actions[1].to.position_m[0] = f64::NAN;
                plan
            },
            &[Number],
        ),
    ];
    for (what, spoil, expected) in spoilt {
        let mut problem = problem();
        let plan = spoil(&mut problem);
        let (conditions, told) = broken(&problem, &plan);
        let expected: BTreeSet<Condition> = expected.iter().copied().collect();
        assert_eq!(conditions, expected, "{what}:\n{told}");
    }
}
