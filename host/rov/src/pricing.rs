//! What a plan takes in a current: the energies of its actions, and what waiting clusters draw to hold against the water.
//!
//! ```text
//! E = ∫ P(τ) dt,   τ = M ν̇' + C(ν')ν' + D(ν')ν' + g(level),   ν' = (Rᵀ(v − c), ω)       (15), (7) in the frame that drifts with c
//! ν̇' = (Rᵀa − ω × Rᵀ(v − c), ω̇)
//! ```
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | v, a, ω | velocity, acceleration and yaw rate of the reference | world m/s, m/s²; rad/s |
//! | c | the current | world, m/s |
//! | P | least power of a wrench, by the plan's law | W |
//!
//! Way, speeds and order stay as they were planned: the search takes the water for still. Waiting clusters are balanced in the current
//! ([`balance_in`]): through every move, or, where moves overlap, from one departure or arrival to the next, in equal shares of those under way.
//!
//! Assumptions and limits: c is steady and the same everywhere.

use nalgebra::{UnitQuaternion, Vector3};
use reconfiguration::plan::{Action, ActionKind, Holding, Manner, Move, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Rules, is_still};
use reconfiguration::vehicle::Vehicle;
use thiserror::Error;

use super::balance::balance_in;
use super::guidance::reference::{Reference, ReferenceTrajectory};
use super::power::{self, PowerError, PowerLaw};
use super::propulsion::{Propulsion, PropulsionError, Steady};

/// Pause between two looks at an action, s. *Assumed*: power changes by a few per cent meanwhile at most.
const STEP_S: f64 = 0.02;

/// Why a plan has no price in a current.
#[derive(Debug, Error)]
pub enum PricingError {
    /// A robot or its power.
    #[error(transparent)]
    Propulsion(#[from] PropulsionError),
    /// No limits of thrust.
    #[error(transparent)]
    Power(#[from] PowerError),
    /// The current is too strong.
    #[error("{when}: {who} cannot hold against the current of [rules] current_m_s")]
    TooStrong {
        /// In which move or interval, from 1.
        when: String,
        /// Which robot, or the waiting cluster.
        who: String,
    },
}

/// Prices `plan` in the current of the problem's rules; in still water it stays as it is.
///
/// # Errors
/// [`PricingError`].
pub fn price(problem: &Problem, plan: &mut Plan, law: &PowerLaw) -> Result<(), PricingError> {
    let current_m_s = problem.rules.current_m_s;
    if is_still(&current_m_s) {
        return Ok(());
    }
    let limits_n = power::limits_n(problem.rules.battery_v)?;
    let steady = match plan.manner {
        Manner::Paper => Steady::Published,
        Manner::Best => Steady::Whole,
    };
    for (index, own) in plan.moves.iter_mut().enumerate() {
        let Some(robot) = problem.robots.iter().find(|robot| robot.id == own.robot) else { continue };
        let Some(vehicle) = problem.vehicles.get(robot.vehicle) else { continue };
        let propulsion = Propulsion::new(vehicle, law.clone(), &problem.rules, steady)?;
        for action in &mut own.actions {
            action.energy_j =
                action_j(&propulsion, action, &problem.rules).ok_or_else(|| PricingError::TooStrong {
                    when: format!("move {}", index + 1),
                    who: format!("robot {}", own.robot),
                })?;
        }
        own.energy_navigate_j = own.actions.iter().map(|action| action.energy_j).sum();
    }
    let moves = plan.moves.clone();
    let held = |(waiting, power_w): (&mut Vec<Holding>, &mut f64), now_s: f64, when: String| {
        let (robots, bodies) = resting(problem, &moves, now_s);
        let balance = balance_in(current_m_s, &bodies, law, limits_n, &problem.rules)
            .map_err(|_| PricingError::TooStrong { when, who: "the waiting cluster".to_owned() })?;
        *power_w = balance.power_w;
        let holding = robots.into_iter().zip(balance.thrusts_n);
        *waiting = holding.map(|(robot, thrusts_n)| Holding { robot, thrusts_n }).collect();
        Ok::<(), PricingError>(())
    };
    if plan.is_parallel() {
        plan.moves.iter_mut().for_each(|own| own.energy_balance_j = 0.0);
        for (index, span) in plan.intervals.iter_mut().enumerate() {
            let middle_s = span.start_s + 0.5 * span.duration_s;
            held((&mut span.balance, &mut span.balance_w), middle_s, format!("interval {}", index + 1))?;
            let under_way = || plan.moves.iter().filter(|own| is_under_way(own, middle_s));
            let share_j = span.balance_w * span.duration_s / under_way().count().max(1) as f64;
            for own in plan.moves.iter_mut().filter(|own| is_under_way(own, middle_s)) {
                own.energy_balance_j += share_j;
            }
        }
        for own in &mut plan.moves {
            own.balance_w = if own.duration_s > 0.0 { own.energy_balance_j / own.duration_s } else { 0.0 };
        }
    } else {
        for (index, own) in plan.moves.iter_mut().enumerate() {
            let middle_s = own.start_s + 0.5 * own.duration_s;
            held((&mut own.balance, &mut own.balance_w), middle_s, format!("move {}", index + 1))?;
            own.energy_balance_j = own.balance_w * own.duration_s;
        }
    }
    let sum = |of: fn(&Move) -> f64| plan.moves.iter().map(of).sum::<f64>();
    (plan.energy_navigate_j, plan.energy_balance_j) =
        (sum(|own| own.energy_navigate_j), sum(|own| own.energy_balance_j));
    plan.energy_total_j = plan.energy_navigate_j + plan.energy_balance_j;
    Ok(())
}

fn is_under_way(own: &Move, now_s: f64) -> bool {
    own.start_s < now_s && now_s < own.start_s + own.duration_s
}

/// Robots that wait at a time of the plan, and all bodies that do: those robots, then tools.
fn resting<'a>(problem: &'a Problem, moves: &[Move], now_s: f64) -> (Vec<u16>, Vec<(Pose, &'a Vehicle)>) {
    let (mut robots, mut bodies) = (Vec::new(), Vec::new());
    for robot in &problem.robots {
        let mut own = moves.iter().filter(|own| own.robot == robot.id);
        let Some(vehicle) = problem.vehicles.get(robot.vehicle) else { continue };
        if own.clone().any(|own| is_under_way(own, now_s)) {
            continue;
        }
        let last = own.rfind(|own| own.start_s + own.duration_s <= now_s);
        let end = last.and_then(|own| own.actions.last()).map(|action| action.to);
        robots.push(robot.id);
        bodies.push((end.unwrap_or(robot.start), vehicle));
    }
    let tools = problem.tools.iter();
    bodies.extend(tools.filter_map(|tool| Some((tool.pose, problem.vehicles.get(tool.vehicle)?))));
    (robots, bodies)
}

/// What an action takes as it is planned, J; `None` beyond the thrusters' limits. A robot that lets go is held by the others.
fn action_j(propulsion: &Propulsion, action: &Action, rules: &Rules) -> Option<f64> {
    let accelerated = ReferenceTrajectory::new(action, rules);
    let (duration_s, current_m_s) = (action.duration_s, rules.current_m_s);
    match (action.kind, action.acceleration) {
        (ActionKind::Undock, _) => Some(action.energy_j),
        (ActionKind::Leg | ActionKind::Turn, None) => {
            energy_j(propulsion, duration_s, current_m_s, |t_s| at_constant_speed(action, t_s))
        }
        _ => energy_j(propulsion, duration_s, current_m_s, |t_s| accelerated.at(t_s)),
    }
}

/// What a robot takes that follows a reference for `duration_s`, J; `None` beyond the thrusters' limits.
#[must_use]
pub fn energy_j(
    propulsion: &Propulsion,
    duration_s: f64,
    current_m_s: [f64; 3],
    reference: impl Fn(f64) -> Reference,
) -> Option<f64> {
    let steps = (duration_s / STEP_S).ceil().clamp(1.0, 1e6);
    let step_s = duration_s / steps;
    let mut energy_j = 0.0;
    for step in 0..steps as u32 {
        let now = reference((f64::from(step) + 0.5) * step_s);
        let level = UnitQuaternion::from_euler_angles(0.0, 0.0, now.pose.yaw_rad);
        // ν' = (Rᵀ(v − c), ω),  ν̇' = (Rᵀa − ω × Rᵀ(v − c), ω̇)
        let through = Vector3::from(now.velocity_m_s) - Vector3::from(current_m_s);
        let v = level.inverse_transform_vector(&through);
        let omega = Vector3::new(0.0, 0.0, now.yaw_rate_rad_s);
        let a = level.inverse_transform_vector(&now.acceleration_m_s2.into()) - omega.cross(&v);
        let nu_dot = [a.x, a.y, a.z, 0.0, 0.0, now.yaw_acceleration_rad_s2];
        energy_j += propulsion.power_w(&[v.x, v.y, v.z, 0.0, 0.0, omega.z], &nu_dot)? * step_s;
    }
    Some(energy_j)
}

/// The paper's: full speed from end to end.
fn at_constant_speed(action: &Action, t_s: f64) -> Reference {
    let (from, to) = (action.from, action.to);
    let per_s = if action.duration_s > 0.0 { 1.0 / action.duration_s } else { 0.0 };
    let yaw_rate_rad_s = quantity::wrap_rad(to.yaw_rad - from.yaw_rad) * per_s;
    Reference {
        pose: Pose { yaw_rad: from.yaw_rad + yaw_rate_rad_s * t_s, ..from },
        velocity_m_s: [0, 1, 2].map(|k| (to.position_m[k] - from.position_m[k]) * per_s),
        yaw_rate_rad_s,
        ..Reference::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn propulsion() -> Propulsion {
        let vehicle = Vehicle::built_in("bluerov1").expect("built in");
        let law = PowerLaw::fitted(16.0).expect("in the table");
        Propulsion::new(&vehicle, law, &Rules::default(), Steady::Whole).expect("six degrees of freedom")
    }

    /// 2 m along x at heading `yaw_rad`.
    fn leg(yaw_rad: f64, acceleration: Option<f64>) -> Action {
        let (from, to) = (Pose::from([0.0, 0.0, 0.0, yaw_rad]), Pose::from([2.0, 0.0, 0.0, yaw_rad]));
        let speed = 0.3;
        let duration_s = 2.0 / speed + acceleration.map_or(0.0, |a| speed / a);
        let kind = ActionKind::Leg;
        Action { kind, start_s: 0.0, duration_s, from, to, speed, acceleration, energy_j: 0.0 }
    }

    /// In still water it is what the planner counts by quadrature.
    #[test]
    fn in_still_water_a_leg_takes_what_the_planner_counts() {
        for (acceleration, yaw) in [(Some(0.2), 0.0_f64), (None, 0.0), (Some(0.1), 0.7)] {
            let direction = [yaw.cos(), -yaw.sin(), 0.0];
            let counted = propulsion().leg(direction, 2.0, 0.3, acceleration).expect("in reach").energy_j;
            let rules = Rules::default();
            let priced = action_j(&propulsion(), &leg(yaw, acceleration), &rules).expect("in reach");
            assert!((priced / counted - 1.0).abs() < 2e-3, "{acceleration:?}: {priced} J, {counted} J");
        }
    }

    /// At constant speed only the velocity through the water counts: 0.25 m/s with the current of 0.05 m/s, 0.35 m/s against it.
    #[test]
    fn the_velocity_through_the_water_is_paid_for() {
        for (current, through) in [(0.05, 0.25), (-0.05, 0.35)] {
            let rules = Rules { current_m_s: [current, 0.0, 0.0], ..Rules::default() };
            let nu = [through, 0.0, 0.0, 0.0, 0.0, 0.0];
            let expected = propulsion().power_w(&nu, &[0.0; 6]).expect("in reach") * 2.0 / 0.3;
            let priced = action_j(&propulsion(), &leg(0.0, None), &rules).expect("in reach");
            assert!((priced / expected - 1.0).abs() < 1e-9, "{current} m/s: {priced} J, {expected} J");
        }
        let rules = Rules { current_m_s: [-9.0, 0.0, 0.0], ..Rules::default() };
        assert_eq!(action_j(&propulsion(), &leg(0.0, None), &rules), None);
    }
}
