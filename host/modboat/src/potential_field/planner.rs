//! The paper's planner as a whole: from a demanded wrench and the tails' present angles to one decision.
//!
//! 1. Algorithm 1 finds collision-free cycles near the demand (see [`potential_field`](super)).
//! 2. The transition solver looks for a way from the present angles into each (see
//!    [`transition`]). Among the cycles that meet the goal the least tail travel decides, beyond
//!    it the error.
//! 3. Whatever is about to be returned is examined with the exact tail geometry (see
//!    [`Case::examine`](crate::setting::Case::examine)); what fails is discarded.

use std::sync::Arc;

use super::{Candidate, PotentialField};
use crate::buffers::Buffers;
use crate::distance_table::{DistanceTable, LOOK_UP_RAD};
use crate::motion::{Swing, Wrench, ends};
use crate::pairs::Pair;
use crate::plan::{Outcome, Plan, Previous};
use crate::setting::{Approach, Case, Setting, Span, swim_ends};
use crate::transition::solver::Solver;
use crate::transition::{self, Transition};

/// The potential-field planner of one structure.
#[derive(Clone, Debug)]
pub struct FieldPlanner {
    setting: Setting,
    /// What the search looks distances up in, if not the collision regions.
    table: Option<Arc<DistanceTable>>,
    field: PotentialField,
    solver: Solver,
    buffers: Buffers,
    /// Cycles that meet the goal and can be reached, the least travel first.
    within: Vec<Reached>,
    /// Where each module can have stopped in the decision before.
    stopped: Vec<Span>,
}

/// A candidate's cycle, and the way into it; none from unknown angles.
#[derive(Clone, Debug)]
struct Reached {
    cycle: Vec<Swing>,
    approach: Option<Approach>,
    travel_rad: f64,
}

impl FieldPlanner {
    /// A planner that searches by the collision regions until it is given a table.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        let Setting { cells, positions_m, pairs, parameters, config, .. } = &setting;
        let field = PotentialField::new(cells, positions_m, pairs, parameters, config);
        let (solver, buffers) = (Solver::with_room(pairs), Buffers::new(cells.len()));
        let within = Vec::with_capacity(config.candidates);
        let stopped = Vec::with_capacity(setting.cells.len());
        Self { setting, table: None, field, solver, buffers, within, stopped }
    }

    /// The same planner, searching by the table of these very parameters.
    #[must_use]
    pub fn with_table(mut self, table: Arc<DistanceTable>) -> Self {
        self.table = Some(table);
        self
    }

    /// See [`Planner::plan_into`](crate::planner::Planner::plan_into).
    pub fn plan_into(
        &mut self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<Previous<'_>>,
        plan: &mut Plan,
    ) {
        self.buffers.keep_plan(std::mem::take(plan));
        let mut stopped = std::mem::take(&mut self.stopped);
        let before = self.setting.stopped(previous, &mut stopped).then_some(stopped.as_slice());
        let previous = previous.map(|previous| previous.cycle);
        let found = self.search(demand, tails, previous, before);
        let Self { setting, buffers, .. } = self;
        let case = Case { before, ..setting.as_configured() };
        *plan = found
            .or_else(|| case.repeat(demand, tails?, previous?, buffers))
            .unwrap_or_else(|| case.hold(demand, tails, previous, buffers));
        self.stopped = stopped;
    }

    fn search(
        &mut self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
        before: Option<&[Span]>,
    ) -> Option<Plan> {
        let Self { setting, table, field, solver, buffers, within, .. } = self;
        let case = Case { before, ..setting.as_configured() };
        let setting = &*setting;
        let goal_n = field.goal_n(demand);
        let candidates = solve(setting, table.as_deref(), field, demand, previous);
        // What was looked up is made sure of.
        let is_sure = |c: &&Candidate| table.is_none() || keeps_margin(setting, &c.cycle);
        // They come best first. Among those that meet the goal the least travel decides; beyond it, the error.
        let (meeting, beyond) = candidates.split_at(candidates.partition_point(|c| c.error_n <= goal_n));
        for candidate in meeting.iter().filter(is_sure) {
            if let Some(reached) = reach(setting, solver, buffers, candidate, tails) {
                let travel_rad = reached.travel_rad;
                let place = within.partition_point(|other| other.travel_rad.total_cmp(&travel_rad).is_le());
                within.insert(place, reached);
            }
        }
        // The exact check is the dearest step: it comes last, and for the first that passes it alone.
        let mut plan = None;
        for Reached { cycle, approach, .. } in within.drain(..) {
            if plan.is_none() {
                plan = case.examine(Outcome::Planned, cycle, approach, tails, demand, buffers);
            } else {
                buffers.keep(cycle, approach);
            }
        }
        plan.or_else(|| {
            beyond.iter().filter(is_sure).find_map(|candidate| {
                let Reached { cycle, approach, .. } = reach(setting, solver, buffers, candidate, tails)?;
                case.examine(Outcome::Planned, cycle, approach, tails, demand, buffers)
            })
        })
    }
}

/// Cycles near the demand, best first. By a table they are collision-free but for its error.
fn solve<'f>(
    setting: &Setting,
    table: Option<&DistanceTable>,
    field: &'f mut PotentialField,
    demand: Wrench,
    previous: Option<&[Swing]>,
) -> &'f [Candidate] {
    let Some(table) = table else {
        let swim = |offset: usize, i: Swing, j: Swing, margin_rad: f64| {
            setting.distance.along_bounded(offset, ends(i, j), margin_rad)
        };
        return field.solve(demand, previous, &swim);
    };
    let swim = |offset: usize, i: Swing, j: Swing, _margin_rad: f64| table.swim(offset, i, j) - LOOK_UP_RAD;
    field.solve(demand, previous, &swim)
}

/// Whether all pairs keep the margin in a cycle.
fn keeps_margin(setting: &Setting, cycle: &[Swing]) -> bool {
    let Setting { distance, config, pairs, .. } = setting;
    let keeps = |pair: &Pair| {
        let [from, to] = swim_ends(cycle, pair);
        distance.clear(pair.offset, from, to, config.margin_rad)
    };
    pairs.all().iter().all(keeps)
}

/// A candidate with the way into it that has the least travel, if there is one; without a way from unknown angles.
fn reach(
    setting: &Setting,
    solver: &mut Solver,
    buffers: &mut Buffers,
    candidate: &Candidate,
    tails: Option<&[f64]>,
) -> Option<Reached> {
    let Some(tails) = tails else {
        let cycle = buffers.cycle(candidate.cycle.iter().copied());
        return Some(Reached { cycle, approach: None, travel_rad: 0.0 });
    };
    let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| setting.may_turn(offset, from, to);
    let (pairs, limit_rad) = (&setting.pairs, setting.rotation_max_rad());
    let mut transition = Transition { turns: buffers.turns([]), ..Transition::default() };
    if !transition::solve(solver, pairs, tails, &candidate.cycle, limit_rad, clear, &mut transition) {
        buffers.keep_way(Some(transition.turns), None);
        return None;
    }
    let Transition { turns, negated, travel_rad, .. } = transition;
    let signed =
        |&swing: &Swing| if negated { Swing { amplitude_rad: -swing.amplitude_rad, ..swing } } else { swing };
    let cycle = buffers.cycle(candidate.cycle.iter().map(signed));
    Some(Reached { cycle, approach: Some(setting.one_step(turns)), travel_rad })
}

#[cfg(test)]
mod tests;
