//! How far the search for a goal has come, and how it is ended before its time.

use std::ops::ControlFlow;
use std::sync::OnceLock;

use super::super::order::Workers;

/// Configurations that are looked at between two reports.
const BATCH: usize = 64;

/// How far a search has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Search {
    /// Robots that configurations are being grown of; all of them when plans are made.
    pub placed: usize,
    /// Robots.
    pub robots: usize,
    /// Configurations of so many robots so far; those that do the task when plans are made.
    pub configurations: usize,
    /// Plans that were asked for.
    pub tried: usize,
    /// Energy of the best plan, J.
    pub best_j: Option<f64>,
    /// No other configuration costs less, J.
    pub bound_j: f64,
}

impl Search {
    /// Whether plans are made: configurations are all grown.
    #[must_use]
    pub const fn plans(&self) -> bool {
        self.tried > 0
    }
}

/// Hears how the search for a goal gets on, and may end it. A clock, if there is one, is here.
pub trait GoalProgress {
    /// Called after every batch of configurations, and of moves priced. A break while configurations are grown leaves out the dearest and goes on;
    /// later, the best plan known is taken.
    fn report(&mut self, search: &Search) -> ControlFlow<()>;
}

/// Never ends a search.
#[derive(Clone, Copy, Debug)]
pub struct Endless;

impl GoalProgress for Endless {
    fn report(&mut self, _: &Search) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// What `job` makes of each of the items, in their order: of all, or of those before `goes_on` broke off. Batches are alike for any number of
/// workers, and so are the results.
pub(super) fn each<T: Sync, R: Send + Sync>(
    items: &[T],
    workers: &dyn Workers,
    job: impl Fn(&T) -> R + Sync,
    mut goes_on: impl FnMut(usize) -> ControlFlow<()>,
) -> Vec<R> {
    let mut results = Vec::with_capacity(items.len());
    for batch in items.chunks(BATCH) {
        let made: Vec<OnceLock<R>> = batch.iter().map(|_| OnceLock::new()).collect();
        workers.run(batch.len(), &|index| {
            // Each number comes once.
            let _ = made[index].set(job(&batch[index]));
        });
        results.extend(made.into_iter().filter_map(OnceLock::into_inner));
        if goes_on(results.len()).is_break() {
            break;
        }
    }
    results
}
