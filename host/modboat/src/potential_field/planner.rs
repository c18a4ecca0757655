//! The paper's planner as a whole: from a demanded wrench and the tails' present angles to one decision.
//!
//! 1. Algorithm 1 finds collision-free cycles near the demand (see [`potential_field`](super)).
//! 2. The transition solver looks for a way from the present angles into each (see
//!    [`transition`]). Among the cycles that meet the goal the least tail travel decides, beyond
//!    it the error.
//! 3. Whatever is about to be returned is examined with the exact tail geometry (see
//!    [`Setting::examine`]); what fails is discarded.

use std::sync::Arc;

use super::{Candidate, PotentialField};
use crate::motion::{Swing, Wrench};
use crate::pairs::Pair;
use crate::plan::{Outcome, Plan};
use crate::setting::{Setting, ends, swim_ends};
use crate::table::{LOOK_UP_RAD, Table};
use crate::transition::{self, Transition};

/// Plans for one structure.
#[derive(Clone, Debug)]
pub struct FieldPlanner {
    setting: Setting,
    /// What the search looks distances up in, if not the collision regions.
    table: Option<Arc<Table>>,
    field: PotentialField,
}

impl FieldPlanner {
    /// Searches by the collision regions until it is given a table.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        let Setting { cells, positions_m, pairs, parameters, config, .. } = &setting;
        let field = PotentialField::new(cells, positions_m, pairs, parameters, config);
        Self { setting, table: None, field }
    }

    /// The same planner, searching by the table of these very parameters.
    #[must_use]
    pub fn with_table(mut self, table: Arc<Table>) -> Self {
        self.table = Some(table);
        self
    }

    /// See [`Planner::plan`](crate::planner::Planner::plan).
    pub fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let goal_n = self.field.goal_n(demand);
        let mut candidates = self.candidates(demand, previous);
        // They come best first. Among those that meet the goal the least travel decides; beyond it, the error.
        let beyond = candidates.split_off(candidates.partition_point(|c| c.error_n <= goal_n));
        let mut within: Vec<_> =
            candidates.into_iter().filter_map(|candidate| self.reach(candidate, tails)).collect();
        within.sort_by(|a, b| travel_rad(&a.1).total_cmp(&travel_rad(&b.1)));
        let beyond = beyond.into_iter().filter_map(|candidate| self.reach(candidate, tails));
        // The exact check is the dearest step: it comes last, and for the first that passes it alone.
        (within.into_iter().chain(beyond))
            .find_map(|(cycle, transition)| {
                let approach = transition.map(|transition| self.setting.one_step(transition.turns));
                self.setting.examine(Outcome::Planned, cycle, approach, tails, demand)
            })
            .or_else(|| self.setting.repeat(demand, tails?, previous?))
            .unwrap_or_else(|| self.setting.hold(demand, tails, previous))
    }

    /// Collision-free cycles near the demand, best first.
    fn candidates(&mut self, demand: Wrench, previous: Option<&[Swing]>) -> Vec<Candidate> {
        let Setting { distance, config, pairs, .. } = &self.setting;
        let Some(table) = &self.table else {
            let swim = |offset: usize, i: Swing, j: Swing, margin_rad: f64| {
                let [from, to] = ends(i, j);
                distance.along_bounded(offset, from, to, margin_rad)
            };
            return self.field.solve(demand, previous, &swim).to_vec();
        };
        let swim = |offset: usize, i: Swing, j: Swing, _margin_rad: f64| {
            let held_rad =
                table.swim(offset, i.centerline_rad, i.amplitude_rad, j.centerline_rad, j.amplitude_rad);
            held_rad - LOOK_UP_RAD
        };
        let mut candidates = self.field.solve(demand, previous, &swim).to_vec();
        // What was looked up is made sure of.
        let keeps_margin = |cycle: &[Swing], pair: &Pair| {
            let [from, to] = swim_ends(cycle, pair);
            distance.clear(pair.offset, from, to, config.margin_rad)
        };
        candidates.retain(|c| pairs.all().iter().all(|pair| keeps_margin(&c.cycle, pair)));
        candidates
    }

    /// A candidate's cycle with the transition into it, if there is one; no transition from unknown angles.
    fn reach(&self, candidate: Candidate, tails: Option<&[f64]>) -> Option<(Vec<Swing>, Option<Transition>)> {
        let mut cycle = candidate.cycle;
        let Some(tails) = tails else { return Some((cycle, None)) };
        let transition = self.transition(tails, &cycle)?;
        if transition.negated {
            cycle.iter_mut().for_each(|swing| swing.amplitude_rad = -swing.amplitude_rad);
        }
        Some((cycle, Some(transition)))
    }

    /// The transition with the least travel from `tails` into `cycle`.
    fn transition(&self, tails: &[f64], cycle: &[Swing]) -> Option<Transition> {
        let Setting { pairs, cells, .. } = &self.setting;
        let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| self.setting.may_turn(offset, from, to);
        transition::solve(pairs, cells, tails, cycle, self.setting.rotation_max_rad(), clear)
    }
}

/// Σ |rotation| of a transition, if there is one, rad.
fn travel_rad(transition: &Option<Transition>) -> f64 {
    transition.as_ref().map_or(0.0, |transition| transition.travel_rad)
}

#[cfg(test)]
mod tests;
