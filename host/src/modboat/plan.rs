//! The planner as a whole: from a demanded wrench and the tails' present angles to one decision, a transition and a
//! swim cycle for every module.
//!
//! 1. Algorithm 1 finds collision-free cycles near the demand (see [`potential_field`](super::potential_field)).
//! 2. The transition solver looks for a way from the present angles into each (see
//!    [`transition`]). Among the cycles that meet the goal the least tail travel decides, beyond
//!    it the error.
//! 3. Whatever is about to be returned is checked with the exact tail geometry, which shares nothing with the
//!    collision regions; what fails is discarded.
//!
//! There is always an answer. If no cycle can be reached, the one before is done again, if it starts where the
//! tails are; if that will not do either, everybody holds still.
//!
//! A plan is *loss tolerant* if nobody collides when any subset of the modules never hears of it and stays as it is.
//! Collisions are between two modules, so that it suffices to look at each pair with both moving, only i, only j.

use std::sync::Arc;

use super::distance::DistanceToCollision;
use super::motion::{Swing, Turn, Wrench};
use super::pairs::{Pair, Pairs};
use super::parameters::Parameters;
use super::planner_config::{DistanceSource, PlannerConfig};
use super::potential_field::{Candidate, PotentialField};
use super::structure::Structure;
use super::table::{LOOK_UP_RAD, Table};
use super::transition::{self, Transition};
use crate::quantity::wrap_rad;

/// A cycle "starts where the tails are" if none is further away than this, rad.
const THERE_RAD: f64 = 0.1;

/// A pair that rests nearer to a collision than a transition's margin may come no nearer than this share of it.
const REST_SHARE: f64 = 0.9;

/// What kind of decision a plan is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A cycle made for the demand.
    Planned,
    /// The cycle before once more.
    Repeated,
    /// Nothing moves.
    Held,
}

impl Outcome {
    /// `planned`, `repeated` or `held`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Planned => "planned",
            Self::Repeated => "repeated",
            Self::Held => "held",
        }
    }
}

/// One decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What kind of decision it is.
    pub outcome: Outcome,
    /// Each module's swim cycle.
    pub cycle: Vec<Swing>,
    /// Each module's rotation before it; `None` if nobody needs one, or if the tails' angles are not known.
    pub transition: Option<Vec<Turn>>,
    /// The wrench of the cycle by (7).
    pub wrench: Wrench,
    /// ‖w∘(F_des − F)‖ / ‖w∘F_des‖; for a zero demand ‖w∘F‖, N.
    pub error: f64,
    /// Σ |rotation| of the transition, rad.
    pub travel_rad: f64,
    /// Least distance between the surfaces of two tails over transition and cycle, m; +∞ if no two tails can meet.
    pub clearance_m: f64,
    /// True if any subset of the modules may miss the plan and stay as it is; false with unknown angles.
    pub loss_tolerant: bool,
}

/// Plans for one structure.
#[derive(Clone, Debug)]
pub struct Planner {
    parameters: Parameters,
    config: PlannerConfig,
    cells: Vec<[i32; 2]>,
    positions_m: Vec<[f64; 2]>,
    pairs: Pairs,
    distance: Arc<DistanceToCollision>,
    /// What the search looks distances up in, if not the collision regions.
    table: Option<Arc<Table>>,
    field: PotentialField,
}

impl Planner {
    /// A planner for one structure. Works out the collision regions, and generates the table if the search is to use it;
    /// for many structures of the same modules see [`Self::with_distance`] and [`Self::with_table`].
    #[must_use]
    pub fn new(structure: &Structure, parameters: &Parameters, config: &PlannerConfig) -> Self {
        let distance = Arc::new(DistanceToCollision::new(parameters));
        let planner = Self::with_distance(structure, parameters, config, distance);
        match config.distance {
            DistanceSource::Direct => planner,
            DistanceSource::Table => planner.with_table(Arc::new(Table::generate(parameters, &|_, _| {}))),
        }
    }

    /// A planner with the collision regions of these very `parameters`, worked out before. It searches by them until it is
    /// given a table.
    #[must_use]
    pub fn with_distance(
        structure: &Structure,
        parameters: &Parameters,
        config: &PlannerConfig,
        distance: Arc<DistanceToCollision>,
    ) -> Self {
        let pairs = Pairs::new(
            structure.len(),
            distance.offsets().iter().enumerate().flat_map(|(offset, &cells)| {
                structure.neighbours(cells).map(move |(i, j)| Pair { i, j, offset })
            }),
        );
        let cells = structure.cells().to_vec();
        let positions_m = structure.positions_m(parameters.pitch_m);
        let field = PotentialField::new(&cells, &positions_m, &pairs, parameters, config);
        Self {
            parameters: parameters.clone(),
            config: config.clone(),
            cells,
            positions_m,
            pairs,
            distance,
            table: None,
            field,
        }
    }

    /// The same planner, searching by the table of these very parameters.
    #[must_use]
    pub fn with_table(mut self, table: Arc<Table>) -> Self {
        self.table = Some(table);
        self
    }

    /// The decision for `demand`. `tails` are the present angles (rad, may be unwrapped), `previous` the cycle before.
    /// Either counts as unknown if its length is not the number of modules.
    ///
    /// With unknown angles there is no transition, and a cycle that is held is at the end of the previous one, or at
    /// zero.
    pub fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let tails = tails.filter(|t| t.len() == self.cells.len());
        let previous = previous.filter(|p| p.len() == self.cells.len());
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
            .find_map(|(cycle, transition)| self.checked(Outcome::Planned, cycle, transition, tails, demand))
            .or_else(|| self.repeat(demand, tails?, previous?))
            .unwrap_or_else(|| self.hold(demand, tails, previous))
    }

    /// Collision-free cycles near the demand, best first.
    fn candidates(&mut self, demand: Wrench, previous: Option<&[Swing]>) -> Vec<Candidate> {
        let (distance, config) = (&self.distance, &self.config);
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
        candidates.retain(|c| self.pairs.all().iter().all(|pair| keeps_margin(&c.cycle, pair)));
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
        let limit_rad = self.parameters.tail_speed_max_rad_s * self.parameters.transition_s;
        let (distance, margin_rad) = (&self.distance, self.config.transition_margin_rad);
        let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| {
            if distance.clear(offset, from, to, margin_rad) {
                return true;
            }
            // A servo that stopped a little inside the margin must be able to leave it.
            let rest_rad = distance.along(offset, from, from);
            rest_rad > 0.0 && rest_rad < margin_rad && distance.clear(offset, from, to, REST_SHARE * rest_rad)
        };
        transition::solve(&self.pairs, &self.cells, tails, cycle, limit_rad, clear)
    }

    /// The previous cycle once more, as it was.
    fn repeat(&self, demand: Wrench, tails: &[f64], previous: &[Swing]) -> Option<Plan> {
        let near_rad = THERE_RAD.min(self.parameters.tail_speed_max_rad_s * self.parameters.transition_s);
        let there = |(tail, swing): (&f64, &Swing)| wrap_rad(swing.start_rad() - tail).abs() <= near_rad;
        if !tails.iter().zip(previous).all(there) {
            return None;
        }
        let turns: Vec<Turn> = tails
            .iter()
            .zip(previous)
            .map(|(&from_rad, swing)| {
                let rotation_rad = wrap_rad(swing.start_rad() - from_rad);
                let still = rotation_rad.abs() < transition::STILL_RAD;
                Turn { from_rad, to_rad: if still { from_rad } else { from_rad + rotation_rad } }
            })
            .collect();
        let travel_rad = turns.iter().map(|turn| turn.rotation_rad().abs()).sum();
        let transition = Transition { turns, negated: false, travel_rad, exact: true };
        self.checked(Outcome::Repeated, previous.to_vec(), Some(transition), Some(tails), demand)
    }

    fn hold(&self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let rest_rad = |module: usize| match (tails, previous) {
            (Some(tails), _) => tails[module],
            (None, Some(previous)) => previous[module].start_rad(),
            (None, None) => 0.0,
        };
        let cycle: Vec<Swing> = (0..self.cells.len())
            .map(|module| Swing { centerline_rad: rest_rad(module), amplitude_rad: 0.0 })
            .collect();
        let clearance_m = self.clearance_m(f64::INFINITY, |pair| swim_ends(&cycle, pair));
        let norm_n = demand.weighted_norm(self.config.weights);
        Plan {
            outcome: Outcome::Held,
            transition: None,
            wrench: Wrench::default(),
            error: if norm_n == 0.0 { 0.0 } else { 1.0 },
            travel_rad: 0.0,
            clearance_m,
            loss_tolerant: tails.is_some() && clearance_m > 0.0,
            cycle,
        }
    }

    /// The plan if no two tails touch in it by the exact test.
    fn checked(
        &self,
        outcome: Outcome,
        cycle: Vec<Swing>,
        transition: Option<Transition>,
        tails: Option<&[f64]>,
        demand: Wrench,
    ) -> Option<Plan> {
        let mut clearance_m = self.clearance_m(f64::INFINITY, |pair| swim_ends(&cycle, pair));
        if let Some(transition) = &transition {
            clearance_m = self.clearance_m(clearance_m, |pair| turn_ends(&transition.turns, pair));
        }
        // Not "≤ 0": a NaN is no clearance either.
        if clearance_m.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let loss_tolerant = match (&transition, tails) {
            (Some(transition), Some(tails)) => self.loss_tolerant(&transition.turns, &cycle, tails),
            _ => false,
        };
        let wrench = cycle
            .iter()
            .zip(&self.positions_m)
            .fold(Wrench::default(), |sum, (swing, &at)| sum + swing.wrench(&self.parameters, at));
        let error_n = (demand - wrench).weighted_norm(self.config.weights);
        let norm_n = demand.weighted_norm(self.config.weights);
        Some(Plan {
            outcome,
            cycle,
            wrench,
            error: if norm_n == 0.0 { error_n } else { error_n / norm_n },
            travel_rad: travel_rad(&transition),
            transition: transition.filter(|t| !t.is_still()).map(|t| t.turns),
            clearance_m,
            loss_tolerant,
        })
    }

    /// The lesser of `known_m` and the least clearance of any pair along the motion that `ends` gives it, m.
    fn clearance_m(&self, known_m: f64, ends: impl Fn(&Pair) -> [[f64; 2]; 2]) -> f64 {
        let (tail, offsets) = (self.distance.tail(), self.distance.offsets());
        self.pairs.all().iter().fold(known_m, |least_m, pair| {
            let [from, to] = ends(pair);
            tail.least_along_m(offsets[pair.offset], from, to, least_m)
        })
    }

    /// Whether each pair stays clear with only i moving, and with only j; both moving is known to be.
    fn loss_tolerant(&self, turns: &[Turn], cycle: &[Swing], tails: &[f64]) -> bool {
        let (tail, offsets) = (self.distance.tail(), self.distance.offsets());
        self.pairs.all().iter().all(|pair| {
            let rest = [tails[pair.i], tails[pair.j]];
            [turn_ends(turns, pair), swim_ends(cycle, pair)].iter().all(|[from, to]| {
                let offset = offsets[pair.offset];
                !tail.collides_along(offset, [from[0], rest[1]], [to[0], rest[1]])
                    && !tail.collides_along(offset, [rest[0], from[1]], [rest[0], to[1]])
            })
        })
    }
}

/// Σ |rotation| of a transition, if there is one, rad.
fn travel_rad(transition: &Option<Transition>) -> f64 {
    transition.as_ref().map_or(0.0, |transition| transition.travel_rad)
}

/// Both ends of a swim cycle of two modules in their phase space (φᵢ, φⱼ).
fn ends(i: Swing, j: Swing) -> [[f64; 2]; 2] {
    let far = |swing: Swing| swing.centerline_rad - swing.amplitude_rad;
    [[i.start_rad(), j.start_rad()], [far(i), far(j)]]
}

fn swim_ends(cycle: &[Swing], pair: &Pair) -> [[f64; 2]; 2] {
    ends(cycle[pair.i], cycle[pair.j])
}

fn turn_ends(turns: &[Turn], pair: &Pair) -> [[f64; 2]; 2] {
    let (i, j) = (turns[pair.i], turns[pair.j]);
    [[i.from_rad, j.from_rad], [i.to_rad, j.to_rad]]
}

#[cfg(test)]
mod tests;
