//! Which goal configuration does a task at least energy: the paper's last future direction, "generating optimal
//! configurations to meet task specific requirements".
//!
//! | file | what |
//! |---|---|
//! | `growth` | connected configurations of the robots at hand around the tools, at multiples of 90° |
//! | `fitness` | which of them do the task, and the least that getting there can cost |
//! | `choice` | plans to those, until none that is left can be cheaper |
//! | `progress` | how far the search has come; what ends it before its time |
//!
//! ```text
//! E(goal) ≥ Σ over robots of the least J/m · distance, cheapest assignment of robots to places, and of one to a service that is still open
//! ```
//!
//! Configurations grow robot by robot, face to face, from the tools (without any, from the first robot's place). Those
//! that do the task and can be balanced are ranked by that lower bound; plans are made for the best of them in that
//! order, and the one of least energy is taken. A plan is given up once its order's bound is above the best plan's energy. No configuration
//! behind the last one tried can be cheaper once its bound is: then, if those tried were proved or given up so and no growth was cut
//! short, the result is the best there is. Otherwise the least of those bounds says how far from the best it can be.
//!
//! Assumptions and limits: at most [`KEPT`] configurations of a size are grown on, the cheapest by the bound; robots keep
//! to right angles with what they grow from.

use reconfiguration::problem::{Problem, Slot};
use reconfiguration::task::Task;
use thiserror::Error;

use super::order::{InTurn, MOST, Workers};
use super::planner::{PlanError, Planned, Request};
use super::power::limits_n;

pub use self::progress::{Endless, GoalProgress, Search};

mod choice;
mod fitness;
mod growth;
mod progress;

/// Configurations of a size that are grown on.
pub const KEPT: usize = 3000;
/// Plans that are made at most.
pub const TRIED: usize = 100;

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
    /// No configuration of right angles, in any order of moves by these routes, costs less, J; `None` where some were left out.
    pub bound_j: Option<f64>,
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

/// The goal of least energy for a task, one look after the other. The problem's own slots do not count.
///
/// # Errors
/// [`MorphologyError`].
pub fn goal(problem: &Problem, task: &Task, request: &Request) -> Result<Found, MorphologyError> {
    goal_with(problem, task, request, &InTurn, &mut Endless)
}

/// The same, until it is proved least, [`TRIED`] configurations were planned for, or `progress` ends the search. The result is the same for any
/// number of workers.
///
/// # Errors
/// [`MorphologyError`].
pub fn goal_with(
    problem: &Problem,
    task: &Task,
    request: &Request,
    workers: &dyn Workers,
    progress: &mut dyn GoalProgress,
) -> Result<Found, MorphologyError> {
    for service in &task.services {
        if !problem.robots.iter().any(|robot| robot.capabilities.contains(&service.capability)) {
            return Err(MorphologyError::Incapable { capability: service.capability.clone() });
        }
    }
    let robots = problem.robots.len();
    if robots > MOST {
        return Err(PlanError::TooMany { count: robots }.into());
    }
    let limits_n = limits_n(problem.rules.battery_v).map_err(PlanError::from)?;
    let judge = fitness::Fitness::new(problem, task, &request.law, limits_n)?;
    let (grown, mut cut) =
        growth::grown(problem, task, &|places: &[growth::Place]| judge.bound_j(places), workers, progress);
    let search = |configurations| Search { placed: robots, robots, configurations, ..Search::default() };
    let mut refused = fitness::Refused::default();
    let mut fit: Vec<(f64, Vec<Slot>)> = Vec::new();
    let judged = progress::each(
        &grown,
        workers,
        |places| judge.slots(places),
        |_| progress.report(&search(grown.len())),
    );
    cut |= judged.len() < grown.len();
    for found in judged {
        match found {
            Ok(slots) => fit.push(slots),
            Err(why) => refused.count(why),
        }
    }
    if fit.is_empty() {
        return Err(MorphologyError::Unfit { grown: grown.len(), why: refused.to_string() });
    }
    fit.sort_by(|a, b| a.0.total_cmp(&b.0));
    let found = choice::cheapest((problem, request), &fit, workers, progress, search(fit.len()))?;
    // What was left out on the way may have been cheaper, but nothing costs less than no move at all.
    let stays = found.planned.plan.energy_total_j <= 0.0;
    let (proved, bound_j) = (stays || found.proved && !cut, found.bound_j.filter(|_| stays || !cut));
    Ok(Found { proved, bound_j, ..found })
}

#[cfg(test)]
mod tests;
