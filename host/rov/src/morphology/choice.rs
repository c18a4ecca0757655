//! Plans to the configurations that do the task, the cheapest by their bound first, until none that is left can be cheaper.

use std::ops::ControlFlow;

use reconfiguration::problem::{Problem, Slot};

use super::super::order::{Known, Progress, Workers};
use super::super::planner::{PATIENCE, PlanError, Planned, Request, plan_with};
use super::fitness::with_slots;
use super::progress::{GoalProgress, Search};
use super::{Found, MorphologyError, TRIED};

/// The goal whose plan takes the least energy, of configurations in the order of their bounds, J.
pub(super) fn cheapest(
    (problem, request): (&Problem, &Request),
    fit: &[(f64, Vec<Slot>)],
    workers: &dyn Workers,
    progress: &mut dyn GoalProgress,
    mut search: Search,
) -> Result<Found, MorphologyError> {
    let mut best: Option<(Problem, Planned)> = None;
    // The least that one of those cost that were tried in vain, or whose plan is not proved least.
    let (mut passed_j, mut last) = (f64::INFINITY, None);
    let mut stopped = false;
    while search.tried < fit.len().min(TRIED) && !stopped {
        let (bound_j, slots) = &fit[search.tried];
        let most_j = search.best_j.unwrap_or(f64::INFINITY);
        if *bound_j >= most_j {
            break;
        }
        search.tried += 1;
        search.bound_j = passed_j.min(*bound_j);
        let goal = with_slots(problem, slots.clone());
        let mut watch = Watch { progress, search, most_j, floor_j: *bound_j, stopped: false };
        let made = plan_with(&goal, request, workers, &mut watch);
        let Watch { floor_j, stopped: ended, .. } = watch;
        stopped = ended;
        match made {
            Ok(planned) => {
                let (energy_j, proved) = (planned.plan.energy_total_j, planned.proved);
                // Another order to the same goal may be cheaper, down to its bound.
                let least_j = if proved { energy_j } else { planned.bound.max(*bound_j) };
                passed_j = passed_j.min(least_j);
                if energy_j < most_j {
                    search.best_j = Some(energy_j);
                    best = Some((goal, planned));
                }
            }
            // What its bound said was dear enough, or the search was ended.
            Err(PlanError::OutOfPatience { priced }) => {
                passed_j = passed_j.min(floor_j);
                last = Some(PlanError::OutOfPatience { priced });
            }
            Err(error) => last = Some(error),
        }
    }
    let left_j = fit.get(search.tried).map_or(f64::INFINITY, |(bound_j, _)| *bound_j);
    let Search { configurations, tried, .. } = search;
    match (best, last) {
        (Some((problem, planned)), _) => {
            let energy_j = planned.plan.energy_total_j;
            let bound_j = passed_j.min(left_j).min(energy_j);
            Ok(Found {
                problem,
                planned,
                configurations,
                tried,
                bound_j: Some(bound_j),
                proved: bound_j >= energy_j,
            })
        }
        (None, Some(last)) => Err(MorphologyError::Unreachable { tried, last }),
        (None, None) => {
            Err(MorphologyError::Unreachable { tried, last: PlanError::OutOfPatience { priced: 0 } })
        }
    }
}

/// Ends the search for an order to one goal when it can no longer be the cheapest, and passes on what is known.
struct Watch<'a> {
    progress: &'a mut dyn GoalProgress,
    search: Search,
    /// What the best goal so far costs, J.
    most_j: f64,
    /// What this one costs at least, J.
    floor_j: f64,
    stopped: bool,
}

impl Progress for Watch<'_> {
    fn report(&mut self, known: &Known) -> ControlFlow<()> {
        self.floor_j = self.floor_j.max(known.bound);
        self.stopped |= self.progress.report(&self.search).is_break();
        if self.stopped || self.floor_j >= self.most_j || known.priced >= PATIENCE {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}
