//! The order of moves and the assignment of robots to slots: the paper's rule, and the least sum over all of them.
//!
//! The cost of a move depends on which robots rest where, not on how that came about, and not on which of several equal
//! robots rests in a place. So a [`State`] is the kind of robot in every place, and the least total cost is a shortest
//! path over states.
//!
//! | part | where |
//! |---|---|
//! | states and hops between places | [`layout`] |
//! | the paper's rule: least g + h next | [`paper`] |
//! | what is still to be paid at least | [`remaining`], by [`assignment`] and [`extra`] |
//! | a first order at once, better ones later, and a bound that rises | [`search`] |
//!
//! The search is anytime: it tells after every few moves priced the best order known and a lower bound of all orders, and
//! it can be stopped then. Moves are priced in batches of [`DESKS`], whatever the number of workers, so the result does
//! not depend on that number.
//!
//! Assumptions and limits: at most [`MOST`] robots and slots. A bound must not exceed the cost it bounds.

use std::ops::ControlFlow;

pub mod assignment;
mod beam;
pub mod extra;
mod finder;
pub mod layout;
pub mod paper;
pub mod remaining;
pub mod search;

pub use finder::Finder;
pub use layout::{Hop, Layout, MOST, State};

/// Moves of one batch; each is priced at a desk of its own.
pub const DESKS: usize = 8;

/// Costs of moves, and lower bounds of them: what an order is chosen by. Costs in J or m, not negative.
pub trait MoveCosts: Sync {
    /// Robots, slots and parking places.
    fn layout(&self) -> &Layout;
    /// Lower bound of what a robot of a kind that rests at `from` pays until it rests at `to`, in whatever state and by
    /// way of whatever other place; `None` where it may not rest there (v2).
    fn bound(&self, from: usize, kind: u8, to: usize) -> Option<f64>;
    /// Lower bound of a hop where the state is known; `None` if it is known to be impossible.
    fn bound_from(&self, state: &State, hop: Hop) -> Option<f64>;
    /// What a hop costs, or that it costs more than `most`. Two calls at once are for different desks, below [`DESKS`].
    fn cost(&self, desk: usize, state: &State, hop: Hop, most: f64) -> Answer;
    /// Called after every batch of hops that were priced: what was found at one desk may be used at the others.
    fn share(&self) {}
    /// Whether [`bound_from`](Self::bound_from) knows more than [`bound`](Self::bound) does.
    fn depends_on_state(&self) -> bool;
    /// What is paid above the bounds because of others, where that is worked out; `goes_on` may end that.
    fn extra(
        &self,
        workers: &dyn Workers,
        goes_on: &mut GoesOn<'_>,
    ) -> ControlFlow<(), Option<extra::Extra>> {
        let _ = (workers, goes_on);
        ControlFlow::Continue(None)
    }
    /// Whether filled slots (bit k: slot k) are part of a goal that may be reached.
    fn may_fill(&self, filled: u32) -> bool;
    /// Whether these slots can be filled first without a dead end to be feared. Beams keep to it where it can be kept.
    fn stays_open(&self, filled: u32) -> bool {
        let _ = filled;
        true
    }
}

/// What became of a hop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// Its price; infinite if it is impossible.
    Price(f64),
    /// It costs at least this, more than was asked for.
    AtLeast(f64),
}

/// An order of moves and an assignment of robots to slots.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// The moves.
    pub moves: Vec<Hop>,
    /// Their sum.
    pub cost: f64,
}

/// How far a search has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Cost of the best order known.
    pub best: Option<f64>,
    /// No order costs less.
    pub bound: f64,
    /// How many moves were priced.
    pub priced: usize,
}

impl Known {
    /// How much dearer than the least the best order can be, as a share of the least: 0 is proved least. `None` while there
    /// is no order, or no bound above zero.
    #[must_use]
    pub fn gap(&self) -> Option<f64> {
        let best = self.best?;
        if best <= self.bound {
            return Some(0.0);
        }
        (self.bound > 0.0).then(|| best / self.bound - 1.0)
    }
}

/// Hears how a search gets on, and may end it. A clock, if there is one, is here.
pub trait Progress {
    /// Called after every batch of moves priced.
    fn report(&mut self, known: &Known) -> ControlFlow<()>;
}

/// Asked now and then by what takes long: whether to go on.
pub type GoesOn<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

/// Ends a search after so many moves priced.
#[derive(Clone, Copy, Debug)]
pub struct Patience(pub usize);

impl Progress for Patience {
    fn report(&mut self, known: &Known) -> ControlFlow<()> {
        if known.priced >= self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Does several jobs: in turn, or at the same time where the caller has threads.
pub trait Workers: Sync {
    /// Calls `job` once with every number below `jobs` and returns when all are done.
    fn run(&self, jobs: usize, job: &(dyn Fn(usize) + Sync));
}

/// One job after the other.
#[derive(Clone, Copy, Debug)]
pub struct InTurn;

impl Workers for InTurn {
    fn run(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).for_each(job);
    }
}

#[cfg(test)]
mod tests;
