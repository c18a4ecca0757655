//! Ways to spoil a plan of ROVs that was good: each breaks a condition that a judge must name.
//!
//! Some spoil one number; the ways *through a body* and *out of the water* are whole plans, consistent in times,
//! durations and energies, with nothing wrong but where the robot swims.

use judge::Condition;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt};
use reconfiguration::plan::{Action, ActionKind, Manner, Move, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use rov::conditions::Conditions;

/// One way to spoil a plan.
pub struct Spoiler {
    /// What it does.
    pub name: &'static str,
    /// What a judge must find, among others.
    pub breaks: Condition,
    /// Does it, or says that this plan offers no occasion.
    pub spoil: fn(&Problem, &mut Plan, &mut ChaCha8Rng) -> Option<()>,
}

/// All of them.
pub const SPOILERS: [Spoiler; 20] = [
    Spoiler { name: "another slot", breaks: Condition::V1, spoil: another_slot },
    Spoiler { name: "another robot", breaks: Condition::V1, spoil: another_robot },
    Spoiler { name: "an unknown robot", breaks: Condition::Identity, spoil: unknown_robot },
    Spoiler { name: "a move left out", breaks: Condition::Energy, spoil: left_out },
    Spoiler { name: "a move made twice", breaks: Condition::V5, spoil: twice },
    Spoiler { name: "two at a time", breaks: Condition::V1, spoil: two_at_a_time },
    Spoiler { name: "a pause", breaks: Condition::Timing, spoil: pause },
    Spoiler { name: "an action cut short", breaks: Condition::Kinematics, spoil: cut_short },
    Spoiler { name: "too fast", breaks: Condition::Kinematics, spoil: too_fast },
    Spoiler { name: "another acceleration", breaks: Condition::Kinematics, spoil: acceleration },
    Spoiler { name: "a jump", breaks: Condition::Continuity, spoil: jump },
    Spoiler { name: "a corner more in the path", breaks: Condition::Continuity, spoil: corner },
    Spoiler { name: "beside the slot", breaks: Condition::V1, spoil: beside },
    Spoiler { name: "askew in the slot", breaks: Condition::V1, spoil: askew },
    Spoiler { name: "undocked on the way", breaks: Condition::V5, spoil: undocked },
    Spoiler { name: "a thrust more", breaks: Condition::V6, spoil: thrust },
    Spoiler { name: "energy glossed over", breaks: Condition::Energy, spoil: energy },
    Spoiler { name: "not a number", breaks: Condition::Number, spoil: not_a_number },
    Spoiler { name: "through a body", breaks: Condition::V3, spoil: through_a_body },
    Spoiler { name: "out of the water", breaks: Condition::Bounds, spoil: out_of_the_water },
];

fn pick(count: usize, rng: &mut impl Rng) -> Option<usize> {
    (count > 0).then(|| rng.random_range(0..count))
}

fn a_move<'a>(plan: &'a mut Plan, rng: &mut impl Rng) -> Option<&'a mut Move> {
    let index = pick(plan.moves.len(), rng)?;
    plan.moves.get_mut(index)
}

fn a_leg<'a>(plan: &'a mut Plan, rng: &mut impl Rng) -> Option<&'a mut Action> {
    let own = a_move(plan, rng)?;
    let legs: Vec<&mut Action> = own.actions.iter_mut().filter(|a| a.kind == ActionKind::Leg).collect();
    let index = pick(legs.len(), rng)?;
    legs.into_iter().nth(index)
}

fn another_slot(problem: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let others: Vec<usize> = (0..problem.slots.len()).filter(|&slot| Some(slot) != own.slot).collect();
    own.slot = Some(others[pick(others.len(), rng)?]);
    Some(())
}

fn another_robot(problem: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let others: Vec<u16> =
        problem.robots.iter().map(|robot| robot.id).filter(|&id| id != own.robot).collect();
    own.robot = others[pick(others.len(), rng)?];
    Some(())
}

fn unknown_robot(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    a_move(plan, rng)?.robot = 999;
    Some(())
}

fn left_out(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let index = pick(plan.moves.len(), rng)?;
    plan.moves.remove(index);
    Some(())
}

fn twice(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let again = a_move(plan, rng)?.clone();
    plan.moves.push(again);
    lay(plan);
    Some(())
}

fn two_at_a_time(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let index = pick(plan.moves.len(), rng)?;
    for own in &mut plan.moves[index..] {
        own.start_s -= 1.0;
        own.actions.iter_mut().for_each(|action| action.start_s -= 1.0);
    }
    plan.time_s -= 1.0;
    Some(())
}

fn pause(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let index = pick(own.actions.len(), rng)?;
    own.actions[index..].iter_mut().for_each(|action| action.start_s += 0.5);
    Some(())
}

fn cut_short(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    a_leg(plan, rng)?.duration_s *= 0.95;
    lay(plan);
    Some(())
}

fn too_fast(problem: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    a_leg(plan, rng)?.speed = 2.0 * problem.rules.speeds_m_s[1].max(problem.rules.speed_m_s);
    Some(())
}

/// More than there is, or none where there must be one.
fn acceleration(problem: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let manner = plan.manner;
    let more = Some(2.0 * problem.rules.acceleration_m_s2);
    a_leg(plan, rng)?.acceleration = if manner == Manner::Best && rng.random_bool(0.5) { None } else { more };
    Some(())
}

fn jump(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let index = 1 + pick(own.actions.len().checked_sub(1)?, rng)?;
    own.actions[index].from.position_m[rng.random_range(0..3)] += 0.01;
    Some(())
}

fn corner(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let index = 1 + pick(own.path.len().checked_sub(1)?, rng)?;
    let [x, y, z] = own.path[index];
    own.path.insert(index, [x + 0.1, y + 0.2, z - 0.3]);
    Some(())
}

fn beside(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let last = a_move(plan, rng)?.actions.last_mut()?;
    last.to.position_m[rng.random_range(0..3)] += 0.02;
    Some(())
}

fn askew(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    a_move(plan, rng)?.actions.last_mut()?.to.yaw_rad += 0.05;
    Some(())
}

fn undocked(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let index = 1 + pick(own.actions.len().checked_sub(1)?, rng)?;
    let Action { from, start_s, .. } = own.actions[index];
    let free = own.actions.iter().find(|action| action.kind == ActionKind::Undock)?.clone();
    own.actions.insert(index, Action { from, to: from, start_s, duration_s: 0.0, ..free });
    Some(())
}

fn thrust(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let own = a_move(plan, rng)?;
    let index = pick(own.balance.len(), rng)?;
    let thrusts_n = &mut own.balance[index].thrusts_n;
    let thruster = pick(thrusts_n.len(), rng)?;
    thrusts_n[thruster] += 0.1;
    Some(())
}

fn energy(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    match rng.random_range(0..4) {
        0 => plan.energy_total_j *= 0.99,
        1 => plan.energy_navigate_j *= 1.01,
        2 => a_move(plan, rng)?.energy_navigate_j *= 0.99,
        _ => a_leg(plan, rng)?.energy_j *= -1.0,
    }
    Some(())
}

fn not_a_number(_: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    match rng.random_range(0..4) {
        0 => plan.time_s = f64::NAN,
        1 => a_move(plan, rng)?.balance_w = f64::INFINITY,
        2 => a_leg(plan, rng)?.speed = f64::NAN,
        _ => a_leg(plan, rng)?.to.position_m[2] = f64::NAN,
    }
    Some(())
}

fn through_a_body(problem: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let index = pick(plan.moves.len(), rng)?;
    // A robot that has not moved yet, or a tool.
    let waiting =
        problem.robots.iter().filter(|robot| !plan.moves[..=index].iter().any(|own| own.robot == robot.id));
    let bodies = waiting.map(|robot| robot.start).chain(problem.tools.iter().map(|tool| tool.pose));
    let bodies: Vec<Pose> = bodies.collect();
    let body = bodies[pick(bodies.len(), rng)?];
    by_way_of(problem, plan, index, body.position_m)
}

fn out_of_the_water(problem: &Problem, plan: &mut Plan, rng: &mut ChaCha8Rng) -> Option<()> {
    let index = pick(plan.moves.len(), rng)?;
    let [low, high] = problem.bounds_m();
    let mut at_m = plan.moves[index].path[0];
    let axis = rng.random_range(0..3);
    // Water that is not given is as large as the judge takes it, at most twice as wide as what is around everything.
    let out_m = if problem.rules.bounds_m.is_some() {
        0.0
    } else {
        2.0 * (0..3).map(|k| (high[k] - low[k]).powi(2)).sum::<f64>().sqrt()
    };
    at_m[axis] = if rng.random_bool(0.5) { low[axis] - out_m } else { high[axis] + out_m };
    by_way_of(problem, plan, index, at_m)
}

/// Start, a place, slot: two legs at the heading of the start, a turn at the end; otherwise all in order.
fn by_way_of(problem: &Problem, plan: &mut Plan, index: usize, at_m: [f64; 3]) -> Option<()> {
    let (manner, rules) = (plan.manner, &problem.rules);
    let own = plan.moves.get_mut(index)?;
    let (first, last) = (own.actions.first()?.clone(), own.actions.last()?.clone());
    let (start, slot) = (first.from, last.to);
    let there = Pose { position_m: at_m, ..start };
    let arrived = Pose { position_m: slot.position_m, ..start };
    let action = |kind, from: Pose, to: Pose, way: f64, limits: [f64; 2]| {
        let [speed, a] = limits;
        let acceleration = (manner == Manner::Best).then_some(a);
        let duration_s = match acceleration {
            _ if way <= 0.0 => 0.0,
            None => way / speed,
            Some(a) if speed * speed > a * way => 2.0 * (way / a).sqrt(),
            Some(a) => way / speed + speed / a,
        };
        Action { kind, start_s: 0.0, duration_s, from, to, speed, acceleration, energy_j: 1.0 }
    };
    let leg = |from: Pose, to: Pose| {
        let squares: f64 = (0..3).map(|k| (to.position_m[k] - from.position_m[k]).powi(2)).sum();
        let speed = rules.speeds_m_s[1].min(rules.speed_m_s);
        action(ActionKind::Leg, from, to, squares.sqrt(), [speed, rules.acceleration_m_s2])
    };
    own.path = vec![start.position_m, at_m, slot.position_m];
    own.actions = vec![first, leg(start, there), leg(there, arrived)];
    let turned = slot.yaw_rad - start.yaw_rad;
    let turned = turned.sin().atan2(turned.cos()).abs();
    if turned > 1e-9 {
        let limits = [rules.yaw_rates_rad_s[1].min(rules.yaw_rate_rad_s), rules.yaw_acceleration_rad_s2];
        own.actions.push(action(ActionKind::Turn, arrived, slot, turned, limits));
    }
    own.actions.push(last);
    lay(plan);
    Some(())
}

/// Moves and actions one after the other without a gap, and all sums right.
fn lay(plan: &mut Plan) {
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
    plan.time_s = now_s;
    plan.energy_navigate_j = plan.moves.iter().map(|own| own.energy_navigate_j).sum();
    plan.energy_balance_j = plan.moves.iter().map(|own| own.energy_balance_j).sum();
    plan.energy_total_j = plan.energy_navigate_j + plan.energy_balance_j;
}
