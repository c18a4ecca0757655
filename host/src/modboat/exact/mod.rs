//! The exact planner: the demanded wrench met to rounding, by cycles that start where the last ended.
//!
//! Every cycle starts and ends at a rest pose pᵢ = φ₀ᵢ + Aᵢ that is out of the neighbours' reach ([`rest`]). That has three
//! consequences:
//!
//! - the next cycle, φ₀' + A' = p, needs no transition: one free parameter per module is left, and three numbers to hit
//!   ([`allocation`]);
//! - anybody may miss a cycle: who holds its last pose is in nobody's way;
//! - where tails must turn after all ([`orientation`] says whereto), there is always a way ([`approach`]), in two steps if not
//!   in one.
//!
//! In the order of a decision: stay where the tails rest; else turn to other rest poses; else the cycle before once more;
//! else hold. With `travel_weight` a small error is taken for not turning. Outside the envelope, the farthest wrench in the
//! direction of the demand is looked for.
//!
//! Modules without any free pose (long tails, neighbours on all sides) rest on the diagonals, and every pair is looked at with
//! both moving, only i, only j ([`neighbours`]).
//!
//! | file | what |
//! |---|---|
//! | [`rest`] | rest poses out of everybody's reach |
//! | [`law`] | what a module can push from a rest pose |
//! | [`neighbours`] | which cycles go together |
//! | [`allocation`] | amplitudes for a wrench: coordinate descent, Newton's method |
//! | [`orientation`] | rest poses for a wrench and those about it |
//! | [`approach`] | the way from here to there |
//! | [`merit`] | what rest poses are worth for what may come next |
//! | [`search`] | staying where the tails rest |
//! | [`turning`] | turning to other rest poses |

pub mod allocation;
pub mod approach;
pub mod law;
pub mod merit;
pub mod neighbours;
pub mod orientation;
pub mod rest;
pub mod search;
pub mod turning;

use crate::modboat::envelope::Envelope;
use crate::modboat::motion::{Swing, Wrench};
use crate::modboat::plan::{Outcome, Plan};
use crate::modboat::planner_config::LossTolerance;
use crate::modboat::setting::{Approach, Presence, Setting};
use search::{Found, Search};

/// Halvings of the interval in which the farthest wrench in a direction is looked for.
const HALVINGS: usize = 6;

/// With no more relative error than this a cycle that any module may stop in is taken before one without error. *Assumed.*
const GOOD_ERROR: f64 = 0.05;

/// Algorithm 1 is asked for help for so many modules at most: beyond, it takes too long.
const FIELD_MODULES: usize = 100;

/// Plans for one structure.
#[derive(Clone, Debug)]
pub struct ExactPlanner {
    setting: Setting,
    envelope: Envelope,
    search: Search,
    /// Whether every module has a free pose: then a plan that meets the demand is loss tolerant too.
    all_free: bool,
}

impl ExactPlanner {
    /// For one structure.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        let takes = setting.positions_m.iter().zip(&setting.presence);
        let takes = takes.filter(|(_, presence)| **presence == Presence::Takes).map(|(at, _)| *at);
        let envelope = Envelope::new(&takes.collect::<Vec<_>>(), &setting.parameters);
        let search = Search::new(&setting);
        Self { all_free: search.all_free(), setting, envelope, search }
    }

    /// See [`Planner::plan`](crate::modboat::planner::Planner::plan).
    pub fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let asked = self.setting.config.loss_tolerant;
        // Power tolerance is had where it can be: rather a cycle that everybody may miss than the wrong way. And where a tail rests in
        // a neighbour's reach (at the start, or after its module lost its power there) there may be no way out that everybody may
        // miss: then one that nobody may.
        let in_reach = tails.is_some_and(|tails| !self.search.may_stay(tails));
        let power = asked == LossTolerance::Power;
        let less = [
            // Safe in itself, if not beside who may have stopped in the cycle before.
            power.then_some(LossTolerance::Power),
            power.then_some(LossTolerance::Require),
            (power && in_reach).then_some(LossTolerance::Prefer),
        ];
        self.setting.mind(previous);
        let mut plan = self.plan_as_asked(demand, tails, previous);
        for tolerance in less.into_iter().flatten() {
            if is_good(&plan) {
                break;
            }
            self.setting.mind(None);
            self.setting.config.loss_tolerant = tolerance;
            let mut other = self.plan_as_asked(demand, tails, previous);
            self.setting.mind(previous);
            other.power_tolerant = other.loss_tolerant && self.setting.is_power_tolerant(&other);
            if is_good(&other) || other.error < plan.error {
                plan = other;
            }
        }
        self.setting.config.loss_tolerant = asked;
        plan
    }

    fn plan_as_asked(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let known = tails.is_none_or(|tails| tails.iter().all(|tail| tail.is_finite()));
        // Neither what is no number nor what has no square is a demand.
        if !(known && demand.weighted_norm(self.setting.config.weights).is_finite()) {
            return self.setting.hold(demand, tails, previous);
        }
        let mut found = self.solve(demand, tails, previous);
        let mut outside_envelope = false;
        if !found.as_ref().is_some_and(|found| found.met) {
            let gauge = self.envelope.gauge(demand);
            outside_envelope = gauge > 1.0;
            if outside_envelope && gauge.is_finite() {
                found = self.farthest(demand, 1.0 / gauge, tails, previous).or(found);
            }
        }
        found
            .and_then(|found| self.examine(found, tails, demand))
            .or_else(|| self.setting.repeat(demand, tails?, previous?))
            .map(|plan| Plan { outside_envelope, ..plan })
            .unwrap_or_else(|| Plan { outside_envelope, ..self.setting.hold(demand, tails, previous) })
    }

    fn examine(&self, found: Found, tails: Option<&[f64]>, demand: Wrench) -> Option<Plan> {
        let plan = self.setting.examine(Outcome::Planned, found.cycle, found.approach, tails, demand)?;
        // With unknown angles there is nobody who could have stayed anywhere.
        let asked = self.setting.config.loss_tolerant;
        let required = asked.is_required() && tails.is_some();
        let kept = plan.loss_tolerant && (plan.power_tolerant || asked != LossTolerance::Power);
        (kept || !required).then_some(plan)
    }

    /// The best found for one demand: met if it can be, else the nearest.
    fn solve(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Option<Found> {
        // Between free poses whatever is clear is loss tolerant.
        let free = self.all_free && tails.is_none_or(|tails| self.search.may_stay(tails));
        let tolerances: &[bool] = match self.setting.config.loss_tolerant {
            LossTolerance::Off => &[false],
            LossTolerance::Require | LossTolerance::Power => &[true],
            LossTolerance::Prefer if free => &[true],
            LossTolerance::Prefer => &[true, false],
        };
        let Self { setting, search, .. } = self;
        let mut best = Cheapest { setting, found: None, price: f64::INFINITY };
        let mut done = false;
        for &loss_tolerant in tolerances {
            if done {
                break;
            }
            done = tails.is_some_and(|tails| {
                best.offer(search.stay(setting, demand, tails, previous, loss_tolerant))
            });
            done = done || best.offer(search.turn(setting, demand, tails, loss_tolerant));
        }
        let met = best.found.as_ref().is_some_and(|found| found.met);
        let required = setting.config.loss_tolerant.is_required();
        if !(done || met || required) && setting.all_take_part() && setting.cells.len() <= FIELD_MODULES {
            best.offer(search.turn_by_field(setting, demand, tails, previous));
        }
        best.found
    }

    /// The farthest wrench in the direction of `demand`, up to `share` of it, that is met.
    fn farthest(
        &mut self,
        demand: Wrench,
        share: f64,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
    ) -> Option<Found> {
        let (mut low, mut high, mut best) = (0.0, share, None);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let wanted = Wrench::from_array(demand.to_array().map(|component| middle * component));
            match self.solve(wanted, tails, previous).filter(|found| found.met) {
                Some(found) => (low, best) = (middle, Some(found)),
                None => high = middle,
            }
        }
        best
    }
}

/// Whether a plan does what was demanded, or as much of it as can be.
fn is_good(plan: &Plan) -> bool {
    plan.outcome == Outcome::Planned && (plan.error <= GOOD_ERROR || plan.outside_envelope)
}

/// The cheapest of what is offered: relative error, and the time of the transition by `travel_weight`.
struct Cheapest<'a> {
    setting: &'a Setting,
    found: Option<Found>,
    price: f64,
}

impl Cheapest<'_> {
    /// True if nothing much better can come.
    fn offer(&mut self, found: Option<Found>) -> bool {
        let Some(found) = found else { return false };
        let weight = self.setting.config.travel_weight;
        let transition_s = found.approach.as_ref().map_or(0.0, Approach::transition_s);
        let error = if found.met { 0.0 } else { found.error };
        let price = error + weight * transition_s / self.setting.parameters.period_s;
        if price < self.price {
            (self.found, self.price) = (Some(found), price);
        }
        price <= weight
    }
}

#[cfg(test)]
mod tests;
