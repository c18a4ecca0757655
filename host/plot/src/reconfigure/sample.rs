//! Made-up reconfigurations for the tests of the pictures: robots that follow their paths with a wobble, at forces and
//! powers that fit a BlueROV.

use std::f64::consts::PI;

use quantity::wrap_rad;
use reconfiguration::plan::{Action, ActionKind, Criterion, Holding, Manner, Move, Placed, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::Vehicle;
use record::reconfigure::{Record, RobotSample, Sample};

/// A robot's index, its slot, and the corners between its start and that slot.
pub type Way<'w> = (usize, usize, &'w [[f64; 3]]);

const DT_S: f64 = 0.05;

/// Acceleration at the ends of an action, m/s² or rad/s².
fn ramp(kind: ActionKind) -> f64 {
    if kind == ActionKind::Turn { 4.0 } else { 0.6 }
}

/// T to I on the far side of the tool, by the two criteria of the paper and by Flotilla's own rules.
pub fn far() -> [Record; 3] {
    let problem = problem(
        "t-to-i-far",
        &[[0.0, -0.33, 0.0], [0.0, 0.33, 0.0], [-0.483, 0.0, 0.0], [-0.966, 0.0, 0.0]],
        &[[0.483, 0.0, 0.0], [0.966, 0.0, 0.0], [1.449, 0.0, 0.0], [1.932, 0.0, 0.0]],
    );
    let energy: [Way<'_>; 4] = [
        (1, 0, &[[0.24, 0.62, 0.0], [0.483, 0.42, 0.0]]),
        (0, 1, &[[0.36, -0.86, 0.0]]),
        (3, 2, &[[-0.48, 0.86, 0.0], [0.72, 0.93, 0.0]]),
        (2, 3, &[[0.0, -0.80, 0.0], [1.45, -0.80, 0.0]]),
    ];
    let euclidean: [Way<'_>; 4] = [
        (0, 0, &[[0.12, -0.60, 0.0], [0.36, -0.54, 0.0], [0.483, -0.40, 0.0]]),
        (3, 1, &[[-0.97, 0.42, 0.0], [-0.60, 1.02, 0.0], [0.36, 1.02, 0.0], [0.97, 0.60, 0.0]]),
        (1, 2, &[[0.24, 0.86, 0.0], [1.33, 0.80, 0.0]]),
        (2, 3, &[[-0.30, -0.66, 0.0], [0.12, -0.80, 0.0], [1.69, -0.80, 0.0]]),
    ];
    [
        record(&problem, Criterion::Energy, Manner::Paper, &energy),
        record(&problem, Criterion::Euclidean, Manner::Paper, &euclidean),
        record(&problem, Criterion::Energy, Manner::Best, &energy),
    ]
}

/// T to I in the layer below.
pub fn below() -> [Record; 2] {
    let mut problem = problem(
        "t-to-i-below",
        &[[-0.483, 0.0, 0.0], [-0.966, -0.33, 0.0], [-0.966, 0.0, 0.0], [-0.966, 0.33, 0.0]],
        &[[0.0, 0.0, 0.267], [0.483, 0.0, 0.267], [0.966, 0.0, 0.267], [1.449, 0.0, 0.267]],
    );
    problem.robots[1].capabilities.push("camera".to_owned());
    let ways: [Way<'_>; 4] = [
        (1, 0, &[[-0.72, -0.9, 0.13], [-0.12, -0.8, 0.267]]),
        (3, 1, &[[-0.4, 0.9, 0.13], [0.3, 0.8, 0.267]]),
        (2, 2, &[[-0.97, 0.1, -0.4], [0.3, 0.4, -0.6], [1.0, 0.1, -0.2]]),
        (0, 3, &[[-0.4, 0.0, -0.7], [1.1, 0.0, -0.7], [1.449, 0.0, -0.1]]),
    ];
    [
        record(&problem, Criterion::Energy, Manner::Paper, &ways),
        record(&problem, Criterion::Energy, Manner::Best, &ways),
    ]
}

/// Eight robots in a row that line up abreast, in the order of their numbers.
pub fn eight() -> Record {
    let starts: Vec<[f64; 3]> = (0..8).map(|n| [-0.483 * f64::from(n + 1), 0.0, 0.0]).collect();
    let slots: Vec<[f64; 3]> = (0..8).map(|n| [0.483, 0.33 * f64::from(n), 0.0]).collect();
    let vias: Vec<[[f64; 3]; 1]> = (0..8).map(|n| [[0.0, 1.2 + 0.33 * f64::from(n), 0.0]]).collect();
    let ways: Vec<Way<'_>> = (0..8).map(|n| (n, n, &vias[n][..])).collect();
    record(&problem("eight", &starts, &slots), Criterion::Energy, Manner::Paper, &ways)
}

fn problem(name: &str, starts: &[[f64; 3]], slots: &[[f64; 3]]) -> Problem {
    let vehicle = |name| Vehicle::built_in(name).expect("a vehicle");
    let pose = |[x, y, z]: [f64; 3]| Pose::from([x, y, z, 0.0]);
    Problem {
        name: name.to_owned(),
        description: "four BlueROV1 carry a 20 N tool and line up ahead of it".to_owned(),
        vehicles: vec![vehicle("bluerov1"), vehicle("tool-20n")],
        robots: (1..)
            .zip(starts)
            .map(|(id, &at)| Robot { id, vehicle: 0, start: pose(at), capabilities: Vec::new() })
            .collect(),
        tools: vec![Tool { vehicle: 1, pose: Pose::default() }],
        slots: slots.iter().map(|&at| Slot { pose: pose(at), requires: Vec::new() }).collect(),
        rules: Rules::default(),
        bounds: None,
    }
}

/// What a robot does on its way: (action, how long it takes when executed).
fn actions(problem: &Problem, manner: Manner, way: Way<'_>, mut t_s: f64) -> Vec<(Action, f64)> {
    let (robot, slot, via) = way;
    let (start, goal) = (problem.robots[robot].start, problem.slots[slot].pose);
    let corners: Vec<[f64; 3]> = via.iter().copied().chain([goal.position_m]).collect();
    let mut at = start;
    let mut done = Vec::new();
    let mut act = |kind, at: &mut Pose, to: Pose, size: f64, speed: f64| {
        if size < 1e-9 {
            return;
        }
        let (acceleration, ramp_s) = match manner {
            Manner::Paper => (None, 0.0),
            Manner::Best => (Some(ramp(kind)), speed / ramp(kind)),
        };
        let duration_s = size / speed + ramp_s;
        let power_w = if kind == ActionKind::Turn { 2.2 } else { 60.0 * speed.powi(2) };
        let energy_j = power_w * duration_s;
        let action = Action { kind, start_s: t_s, duration_s, from: *at, to, speed, acceleration, energy_j };
        t_s += duration_s;
        *at = to;
        done.push((action, size / speed + speed / ramp(kind)));
    };
    let speed = if manner == Manner::Paper { 0.311 } else { 0.24 };
    for corner in corners {
        let step: [f64; 3] = std::array::from_fn(|k| corner[k] - at.position_m[k]);
        let length_m = step.iter().map(|v| v * v).sum::<f64>().sqrt();
        if manner == Manner::Paper && step[0].hypot(step[1]) > 0.02 {
            let heading = Pose { yaw_rad: step[1].atan2(step[0]), ..at };
            let turn = wrap_rad(heading.yaw_rad - at.yaw_rad).abs();
            act(ActionKind::Turn, &mut at, heading, turn, 1.31);
        }
        let there = Pose { position_m: corner, ..at };
        act(ActionKind::Leg, &mut at, there, length_m, speed);
    }
    let turn = wrap_rad(goal.yaw_rad - at.yaw_rad).abs();
    act(ActionKind::Turn, &mut at, goal, turn, 1.31);
    done
}

/// A plan along those ways, and its execution.
pub fn record(problem: &Problem, criterion: Criterion, manner: Manner, ways: &[Way<'_>]) -> Record {
    let mut moves = Vec::new();
    let mut samples = Vec::new();
    let mut poses: Vec<Pose> = problem.robots.iter().map(|r| r.start).collect();
    let mut arrived = vec![false; poses.len()];
    let (mut planned_s, mut t_s) = (0.0, 0.0);
    for (number, &way) in ways.iter().enumerate() {
        let (robot, slot, via) = way;
        let start = problem.robots[robot].start.position_m;
        let goal = problem.slots[slot].pose;
        let doings = actions(problem, manner, way, planned_s);
        let duration_s = doings.iter().map(|(a, _)| a.duration_s).sum::<f64>();
        let balance_w = 1.2 + 0.3 * number as f64;
        for (action, executed_s) in &doings {
            for step in 0..(executed_s / DT_S).ceil() as usize {
                let into_s = step as f64 * DT_S;
                let (pose, nu, tau) = swim(action, *executed_s, into_s, t_s);
                poses[robot] = pose;
                let robots = (0..poses.len())
                    .map(|i| {
                        let mut state = resting(poses[i], balance_w / (poses.len() - 1).max(1) as f64);
                        if i == robot {
                            state = moving(pose, nu, tau);
                            state.reference = Some(action.to);
                        }
                        state.arrived = arrived[i];
                        state
                    })
                    .collect();
                let ripple = 0.01 * (3.0 * t_s).sin();
                let restoring_nm = [0.0, -0.6 + ripple];
                samples.push(Sample { t_s, moving: Some(number), restoring_nm, robots });
                t_s += DT_S;
            }
        }
        poses[robot] = goal;
        arrived[robot] = true;
        moves.push(Move {
            robot: problem.robots[robot].id,
            slot: Some(slot),
            to: None,
            path: [start].into_iter().chain(via.iter().copied()).chain([goal.position_m]).collect(),
            start_s: planned_s,
            duration_s,
            energy_navigate_j: doings.iter().map(|(a, _)| a.energy_j).sum(),
            energy_balance_j: balance_w * duration_s,
            balance_w,
            balance: vec![Holding { robot: problem.robots[robot].id, thrusts_n: vec![0.0; 6] }],
            actions: doings.into_iter().map(|(action, _)| action).collect(),
        });
        planned_s += duration_s;
    }
    let robots =
        (0..poses.len()).map(|i| RobotSample { arrived: arrived[i], ..resting(poses[i], 0.3) }).collect();
    samples.push(Sample { t_s, moving: None, restoring_nm: [0.0, -0.6], robots });
    let sum = |of: fn(&Move) -> f64| moves.iter().map(of).sum::<f64>();
    let (navigate_j, balance_j) = (sum(|m| m.energy_navigate_j), sum(|m| m.energy_balance_j));
    let plan = Plan {
        problem: problem.name.clone(),
        criterion,
        manner,
        robots: problem.robots.iter().map(|r| Placed { id: r.id, start: r.start }).collect(),
        slots: problem.slots.iter().map(|s| s.pose).collect(),
        moves,
        intervals: Vec::new(),
        energy_navigate_j: navigate_j,
        energy_balance_j: balance_j,
        energy_total_j: navigate_j + balance_j,
        time_s: planned_s,
        lower_bound_j: None,
        gap: None,
        proved: None,
    };
    Record { problem: problem.clone(), plan, samples }
}

/// Pose, velocity and wrench `into_s` seconds into an action with ramps up and down.
fn swim(action: &Action, whole_s: f64, into_s: f64, t_s: f64) -> (Pose, [f64; 6], [f64; 6]) {
    let ramp = ramp(action.kind);
    let ramp_s = (action.speed / ramp).min(0.5 * whole_s);
    let (rate, slope) = if into_s < ramp_s {
        (into_s * ramp, ramp)
    } else if into_s > whole_s - ramp_s {
        ((whole_s - into_s).max(0.0) * ramp, -ramp)
    } else {
        (action.speed, 0.0)
    };
    // A smooth step from 0 to 1 is near enough to the integral of those ramps.
    let share = 0.5 - 0.5 * (PI * (into_s / whole_s).clamp(0.0, 1.0)).cos();
    let side_m = 0.02 * (PI * share).sin() * (0.8 * t_s).sin();
    let turn = wrap_rad(action.to.yaw_rad - action.from.yaw_rad);
    let yaw_rad = action.from.yaw_rad + share * turn + 0.02 * (PI * share).sin() * (2.0 * t_s).cos();
    let step: [f64; 3] = std::array::from_fn(|k| action.to.position_m[k] - action.from.position_m[k]);
    let length = step.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-9);
    let mut position_m: [f64; 3] = std::array::from_fn(|k| action.from.position_m[k] + share * step[k]);
    position_m[0] -= side_m * step[1] / length;
    position_m[1] += side_m * step[0] / length;
    let (sin, cos) = yaw_rad.sin_cos();
    let ahead = [(step[0] * cos + step[1] * sin) / length, (step[1] * cos - step[0] * sin) / length];
    let mut nu = [0.0; 6];
    if action.kind == ActionKind::Turn {
        nu[5] = rate * turn.signum();
    } else {
        (nu[0], nu[1], nu[2]) = (rate * ahead[0], rate * ahead[1], rate * step[2] / length);
        nu[5] = 0.04 * (2.0 * t_s).sin();
    }
    let mut tau = [0.0; 6];
    tau[0] = (4.03 + 18.18 * nu[0].abs()) * nu[0]
        + if action.kind == ActionKind::Leg { 9.1 * slope * ahead[0] } else { 0.0 };
    tau[1] = (6.22 + 21.66 * nu[1].abs()) * nu[1];
    tau[2] = (5.18 + 36.99 * nu[2].abs()) * nu[2];
    let spin = if action.kind == ActionKind::Turn { 0.22 * slope * turn.signum() } else { 0.0 };
    tau[5] = spin + (0.07 + 0.227 * nu[5].abs()) * nu[5] + 0.01 * (9.0 * t_s).sin();
    (Pose { position_m, yaw_rad }, nu, tau)
}

fn moving(pose: Pose, nu: [f64; 6], tau: [f64; 6]) -> RobotSample {
    let turn_n = tau[5] / 0.218;
    let thrusts_n =
        vec![0.5 * tau[0] - turn_n, 0.5 * tau[0] + turn_n, tau[2] / 3.0, tau[2] / 3.0, tau[2] / 3.0, -tau[1]];
    thrusting(pose, nu, tau, thrusts_n)
}

fn resting(pose: Pose, power_w: f64) -> RobotSample {
    let mut state = thrusting(pose, [0.0; 6], [0.0; 6], vec![0.0, 0.0, 0.3, 0.3, -0.6, 0.0]);
    state.power_w = power_w;
    state
}

fn thrusting(pose: Pose, nu: [f64; 6], tau: [f64; 6], thrusts_n: Vec<f64>) -> RobotSample {
    let [x, y, z] = pose.position_m;
    let pulse = |f: &f64| {
        if f.abs() < 0.02 { 1500.0 } else { 1500.0 + f.signum() * (28.0 + 24.0 * f.abs().powf(0.7)) }
    };
    RobotSample {
        eta: [x, y, z, 0.0, 0.0, pose.yaw_rad],
        nu,
        tau,
        pulses_us: thrusts_n.iter().map(pulse).collect(),
        power_w: thrusts_n.iter().map(|f| 0.8 * f.abs().powf(1.56)).sum(),
        thrusts_n,
        reference: None,
        arrived: false,
    }
}
