//! Several robots under way at once: from a plan whose moves follow each other to one whose moves overlap.
//!
//! | file | what |
//! |---|---|
//! | `track` | where a robot is at every instant |
//! | `meeting` | whether two robots keep clear of each other at every instant |
//! | `timetable` | which start times are possible together, and what balances meanwhile |
//! | `pace` | the same way at another speed |
//! | `search` | order, start times and speeds |
//!
//! Routes stay as they are; what changes is when each begins, and how fast it is swum. The waiting robots balance once,
//! however many are under way:
//!
//! ```text
//! E = Σ ∫ P_e ds/v + ∫ P_bal(t) dt        minimise E + w T,   E ≤ E of the plan given          (17)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | P_bal(t) | what the robots that wait at t draw to balance | W |
//! | T | when the last robot has arrived | s |
//! | w | what a second is worth | J/s |
//!
//! At every instant the conditions of a single move hold for every robot under way: (19) towards every other robot,
//! resting or moving, outside its dock zones; hulls that do not overlap anywhere; every waiting cluster balanced, no tool
//! alone.
//!
//! **Hand-over.** A robot's share of the balance passes to the others before it lets go: undocking takes at least
//! [`HAND_OVER_S`](super::docking::HAND_OVER_S), in plans that are given without it too.
//!
//! Assumptions and limits: robots do not wait on their way; routes are those that were found for one robot after the
//! other; the search is a heuristic, its result is checked and never above the plan it was given.

use reconfiguration::plan::Plan;
use reconfiguration::problem::Problem;

use super::planner::PlanError;
use super::power::PowerLaw;

mod meeting;
mod pace;
mod search;
mod timetable;
mod track;

/// The plan with its moves overlapping, at the least E + w·T that is found: `weight_w` is w, J/s. The plan itself where
/// nothing better is found.
///
/// # Errors
/// [`PlanError`] for robots that cannot be costed.
pub fn overlapped(problem: &Problem, plan: &Plan, law: &PowerLaw, weight_w: f64) -> Result<Plan, PlanError> {
    search::Search::new(problem, plan, law)?.best(weight_w)
}

#[cfg(test)]
mod tests;
