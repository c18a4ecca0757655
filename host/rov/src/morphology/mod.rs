//! Which goal configuration does a task at least energy: the paper's last future direction, "generating optimal
//! configurations to meet task specific requirements".
//!
//! | file | what |
//! |---|---|
//! | `growth` | connected configurations of the robots at hand around the tools, at multiples of 90° |
//! | `fitness` | which of them do the task, and the least that getting there can cost |
//!
//! ```text
//! E(goal) ≥ Σ over robots of the least J/m · distance, cheapest assignment of robots to places, and of one to a service that is still open
//! ```
//!
//! Configurations grow robot by robot, face to face, from the tools (without any, from the first robot's place). Those
//! that do the task and can be balanced are ranked by that lower bound; plans are made for the best of them in that
//! order, and the one of least energy is taken. No configuration behind the last one tried can be cheaper once its bound
//! is above the best plan's energy: then, and if no growth was cut short, the result is the best there is.
//!
//! Assumptions and limits: at most [`KEPT`] configurations of a size are grown on, the cheapest by the bound; robots keep
//! to right angles with what they grow from.

use reconfiguration::problem::{Problem, Slot};
use reconfiguration::task::Task;
use thiserror::Error;

use super::order::MOST;
use super::planner::{PlanError, Planned, Request, plan};
use super::power::limits_n;

mod fitness;
mod growth;

/// Configurations of a size that are grown on.
pub const KEPT: usize = 3000;
/// Plans that are made at most.
pub const TRIED: usize = 8;

/// A goal that does the task, and the plan to it.
#[derive(Clone, Debug)]
pub struct Found {
    /// The problem, with the goal's slots.
    pub problem: Problem,
    /// The plan.
    pub planned: Planned,
    /// How many configurations do the task.
    pub configurations: usize,
    /// How many of them plans were asked for.
    pub tried: usize,
    /// Whether no other configuration of right angles can be cheaper.
    pub proved: bool,
}

/// Why there is no goal.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MorphologyError {
    /// No robot has a capability that is asked for.
    #[error("no robot brings {capability:?}")]
    Incapable { capability: String },
    /// Nothing that was grown does the task.
    #[error("none of the {grown} configurations of all robots does the task: {why}")]
    Unfit { grown: usize, why: String },
    /// Configurations there are, and no plan to one.
    #[error("no plan to any of the {tried} configurations tried: {last}")]
    Unreachable { tried: usize, last: PlanError },
    /// The robots cannot be planned for.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// The goal of least energy for a task. The problem's own slots do not count.
///
/// # Errors
/// [`MorphologyError`].
pub fn goal(problem: &Problem, task: &Task, request: &Request) -> Result<Found, MorphologyError> {
    for service in &task.services {
        if !problem.robots.iter().any(|robot| robot.capabilities.contains(&service.capability)) {
            return Err(MorphologyError::Incapable { capability: service.capability.clone() });
        }
    }
    let count = problem.robots.len();
    if count > MOST {
        return Err(PlanError::TooMany { count }.into());
    }
    let limits_n = limits_n(problem.rules.battery_v).map_err(PlanError::from)?;
    let judge = fitness::Fitness::new(problem, task, &request.law, limits_n)?;
    let (grown, cut) = growth::grown(problem, task, |places| judge.bound_j(places));
    let count = grown.len();
    let mut refused = fitness::Refused::default();
    let mut fit: Vec<(f64, Vec<Slot>)> =
        grown.into_iter().filter_map(|places| judge.slots(&places, &mut refused)).collect();
    if fit.is_empty() {
        return Err(MorphologyError::Unfit { grown: count, why: refused.to_string() });
    }
    fit.sort_by(|a, b| a.0.total_cmp(&b.0));
    let configurations = fit.len();
    let mut best: Option<Found> = None;
    let (mut tried, mut last, mut proved) = (0, None, false);
    for (bound_j, slots) in fit {
        if best.as_ref().is_some_and(|found| bound_j >= found.planned.plan.energy_total_j) {
            proved = !cut;
            break;
        }
        if tried == TRIED {
            break;
        }
        tried += 1;
        let goal = fitness::with_slots(problem, slots);
        match plan(&goal, request) {
            Ok(planned) => {
                let energy_j = planned.plan.energy_total_j;
                if best.as_ref().is_none_or(|found| energy_j < found.planned.plan.energy_total_j) {
                    best = Some(Found { problem: goal, planned, configurations, tried, proved: false });
                }
            }
            Err(error) => last = Some(error),
        }
    }
    match (best, last) {
        (Some(found), _) => Ok(Found { tried, proved: proved || (tried == configurations && !cut), ..found }),
        (None, Some(last)) => Err(MorphologyError::Unreachable { tried, last }),
        (None, None) => Err(MorphologyError::Unfit { grown: count, why: refused.to_string() }),
    }
}

#[cfg(test)]
mod tests;
