//! What an execution costs, and how near it stays to the plan.
//!
//! ```text
//! E = ∫ Σ P(F) dt        F: thrusts as the water feels them, P: the law of power of the plan, and the measured table
//! ```
//!
//! What the mover's thrusters draw from the beginning of its move until it holds in its slot is to navigate, what all
//! others draw is to balance. While a mover hands over its share of the balance it is the mover already.

use reconfiguration::plan::{ActionKind, Move, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, is_still};
use reconfiguration::vehicle::Vehicle;
use rov::configuration::LevelBox;
use rov::dynamics::State;
use rov::guidance::reference::ReferenceTrajectory;
use rov::power::PowerLaw;
use rov::pricing;
use rov::propulsion::{Expense, Propulsion, PropulsionError, Steady};
use sim::rov::basin::Misfit;

use super::conductor::{Followed, HAND_OVER_S};
use super::summary::{Energy, MoveFigures};

/// See the module's documentation.
pub struct Accounts {
    law: PowerLaw,
    table: PowerLaw,
    moves: Vec<MoveFigures>,
}

impl Accounts {
    /// Nothing spent yet; costs by `law`.
    ///
    /// # Errors
    /// [`PropulsionError`] for a voltage outside the table, or a robot that cannot be costed.
    pub fn new(problem: &Problem, plan: &Plan, law: &PowerLaw) -> Result<Self, PropulsionError> {
        let table = PowerLaw::table(problem.rules.battery_v)?;
        let moves = plan.moves.iter().map(|planned| {
            Ok(MoveFigures {
                robot: planned.robot,
                slot: planned.slot,
                planned: Energy::new(planned.energy_navigate_j, planned.energy_balance_j, planned.duration_s),
                expected: expected(problem, planned, law)?,
                executed: Energy::default(),
                by_table: Energy::default(),
                cross_track_m: 0.0,
                least_gap_m: None,
                end_m: None,
                end_rad: None,
            })
        });
        Ok(Self { law: law.clone(), table, moves: moves.collect::<Result<_, PropulsionError>>()? })
    }

    /// Power of thrusts by the law of the plan, W.
    #[must_use]
    pub fn power_w(&self, thrusts_n: &[f64]) -> f64 {
        thrusts_n.iter().map(|&thrust_n| self.law.power_w(thrust_n)).sum()
    }

    /// `dt_s` of the moves under way, each with its robot, with the thrusts of all robots. Of what the others draw each move has
    /// an equal share.
    pub fn spend(&mut self, dt_s: f64, moving: &[(usize, usize)], thrusts_n: &[impl AsRef<[f64]>]) {
        for &(number, mover) in moving {
            let Some(figures) = self.moves.get_mut(number) else { continue };
            for (law, energy) in [(&self.law, &mut figures.executed), (&self.table, &mut figures.by_table)] {
                let (mut navigate_j, mut balance_j) = (energy.navigate_j, energy.balance_j);
                for (robot, thrusts_n) in thrusts_n.iter().enumerate() {
                    let drawn_j =
                        dt_s * thrusts_n.as_ref().iter().map(|&thrust_n| law.power_w(thrust_n)).sum::<f64>();
                    if robot == mover {
                        navigate_j += drawn_j;
                    } else if moving.iter().all(|(_, other)| *other != robot) {
                        balance_j += drawn_j / moving.len() as f64;
                    }
                }
                *energy = Energy::new(navigate_j, balance_j, energy.time_s + dt_s);
            }
        }
    }

    /// Where the movers are beside their paths, and how near to the others (states of all bodies).
    pub fn look(&mut self, followed: &[Followed<'_>], states: &[State], bodies: &[&Vehicle]) {
        let around = |body: usize| {
            let eta = states[body].eta();
            LevelBox::around(Pose::from([eta[0], eta[1], eta[2], eta[5]]), bodies[body])
        };
        for &Followed { number, robot: mover, reference, trajectory } in followed {
            let Some(figures) = self.moves.get_mut(number).filter(|_| reference.is_some()) else { continue };
            let beside_m = trajectory.cross_track_m(states[mover].position_m.into());
            figures.cross_track_m = figures.cross_track_m.max(beside_m);
            let own = around(mover);
            let others = (0..bodies.len()).filter(|&body| body != mover);
            let gap_m = others.map(|body| own.gap_m(&around(body))).reduce(f64::min);
            figures.least_gap_m = figures.least_gap_m.into_iter().chain(gap_m).reduce(f64::min);
        }
    }

    /// The move `number` has ended, drawn in from so far.
    pub fn end(&mut self, number: usize, misfit: &Misfit) {
        if let Some(figures) = self.moves.get_mut(number) {
            (figures.end_m, figures.end_rad) = (Some(misfit.position_m), Some(misfit.angle_rad));
        }
    }

    /// The moves that were begun.
    pub fn moves(&self) -> impl Iterator<Item = &MoveFigures> {
        self.moves.iter().filter(|figures| figures.executed.time_s > 0.0)
    }
}

/// What a move's actions take when they begin and end at rest, in the current that is expected.
fn expected(problem: &Problem, planned: &Move, law: &PowerLaw) -> Result<Energy, PropulsionError> {
    let rules = &problem.rules;
    let robot = problem.robots.iter().find(|robot| robot.id == planned.robot);
    let Some(vehicle) = robot.and_then(|robot| problem.vehicles.get(robot.vehicle)) else {
        return Ok(Energy::default());
    };
    let propulsion = Propulsion::new(vehicle, law.clone(), rules, Steady::Whole)?;
    let (mut energy_j, mut time_s) = (0.0, 0.0);
    for action in &planned.actions {
        let trajectory = ReferenceTrajectory::new(action, rules);
        let way_m: [f64; 3] = std::array::from_fn(|k| action.to.position_m[k] - action.from.position_m[k]);
        let length_m = way_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        let angle_rad = quantity::wrap_rad(action.to.yaw_rad - action.from.yaw_rad);
        let flows = !is_still(&rules.current_m_s);
        let expense = match action.kind {
            ActionKind::Leg | ActionKind::Turn if flows => {
                let duration_s = trajectory.duration_s();
                let energy_j =
                    pricing::energy_j(&propulsion, duration_s, rules.current_m_s, |t_s| trajectory.at(t_s));
                energy_j.map(|energy_j| Expense { duration_s, energy_j, ..Expense::default() })
            }
            ActionKind::Leg if length_m > 0.0 => {
                let (sin, cos) = action.from.yaw_rad.sin_cos();
                let [x, y, z] = way_m.map(|x| x / length_m);
                let direction = [cos * x + sin * y, cos * y - sin * x, z];
                let acceleration = action.acceleration.unwrap_or(rules.acceleration_m_s2);
                propulsion.leg(direction, length_m, action.speed, Some(acceleration))
            }
            ActionKind::Turn => {
                let acceleration = action.acceleration.unwrap_or(rules.yaw_acceleration_rad_s2);
                propulsion.turn(angle_rad, action.speed, Some(acceleration))
            }
            _ => None,
        };
        energy_j += expense.map_or(action.energy_j, |expense| expense.energy_j);
        time_s += match action.kind {
            ActionKind::Undock => trajectory.duration_s().max(HAND_OVER_S),
            _ => trajectory.duration_s(),
        };
    }
    Ok(Energy::new(energy_j, planned.balance_w * time_s, time_s))
}
