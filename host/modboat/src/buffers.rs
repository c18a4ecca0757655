//! Buffers of plans: what one decision no longer needs, the next one takes, so that a planner that is warm allocates nothing.
//!
//! Cycles, turns and poses are handed from the search to the plan, and with it to the caller. What a search discards and what the
//! caller's last plan held comes back here.

use super::motion::{Swing, Turn};
use super::plan::Plan;
use super::way::Approach;

/// Buffers of each kind kept at most: more than one decision holds at a time.
const SPARE: usize = 8;

/// Spare buffers, each for all modules of one structure.
#[derive(Debug)]
pub struct Buffers {
    modules: usize,
    swings: Vec<Vec<Swing>>,
    turns: Vec<Vec<Turn>>,
    poses_rad: Vec<Vec<f64>>,
}

impl Buffers {
    /// Buffers for plans of so many modules.
    #[must_use]
    pub fn new(modules: usize) -> Self {
        Self { modules, swings: spare(modules), turns: spare(modules), poses_rad: spare(modules) }
    }

    /// A cycle of these swings, in a buffer used before if there is one.
    pub fn cycle(&mut self, swings: impl IntoIterator<Item = Swing>) -> Vec<Swing> {
        filled(&mut self.swings, swings)
    }

    /// The turns of a transition, in a buffer used before if there is one.
    pub fn turns(&mut self, turns: impl IntoIterator<Item = Turn>) -> Vec<Turn> {
        filled(&mut self.turns, turns)
    }

    /// The poses between the two steps of a transition, rad.
    pub fn poses_rad(&mut self, poses_rad: impl IntoIterator<Item = f64>) -> Vec<f64> {
        filled(&mut self.poses_rad, poses_rad)
    }

    /// Takes back a cycle and the way to it.
    pub fn keep(&mut self, cycle: Vec<Swing>, approach: Option<Approach>) {
        keep(&mut self.swings, cycle);
        if let Some(Approach { turns, via_rad, .. }) = approach {
            self.keep_way(Some(turns), via_rad);
        }
    }

    /// Takes back turns, and the poses between.
    pub fn keep_way(&mut self, turns: Option<Vec<Turn>>, via_rad: Option<Vec<f64>>) {
        if let Some(turns) = turns {
            keep(&mut self.turns, turns);
        }
        if let Some(via_rad) = via_rad {
            keep(&mut self.poses_rad, via_rad);
        }
    }

    /// Takes back all that a plan holds.
    pub fn keep_plan(&mut self, plan: Plan) {
        keep(&mut self.swings, plan.cycle);
        self.keep_way(plan.transition, plan.via_rad);
    }
}

/// A clone has buffers of its own: copies of empty ones would have no room.
impl Clone for Buffers {
    fn clone(&self) -> Self {
        Self::new(self.modules)
    }
}

fn spare<T>(modules: usize) -> Vec<Vec<T>> {
    (0..SPARE).map(|_| Vec::with_capacity(modules)).collect()
}

fn filled<T>(spare: &mut Vec<Vec<T>>, values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut list = spare.pop().unwrap_or_default();
    list.clear();
    list.extend(values);
    list
}

fn keep<T>(spare: &mut Vec<Vec<T>>, list: Vec<T>) {
    if spare.len() < SPARE && list.capacity() > 0 {
        spare.push(list);
    }
}
