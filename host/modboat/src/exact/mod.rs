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
//! In the order of a decision: stay where the tails rest; else turn to other rest poses; near the border of the envelope swing in
//! step, wherever that starts ([`together`]), or as Algorithm 1 does, so that the error is never greater than its; where a tail rests
//! in a neighbour's reach and any module must be able to miss the plan, out of there first ([`leaving`]); else the cycle before once
//! more; else hold. With `travel_weight` a small error is taken for not turning. Outside the envelope, the farthest wrench in the
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
//! | [`asked`] | what is looked for, and what turning costs |
//! | [`approach`] | the way from here to there |
//! | [`merit`] | what rest poses are worth for what may come next |
//! | [`search`] | staying where the tails rest |
//! | [`turning`] | turning to other rest poses, or to the cycles of Algorithm 1 |
//! | [`together`] | swinging in step, near the border of the envelope |
//! | [`leaving`] | out of the neighbours' reach, so that any module may miss it |

pub mod allocation;
pub mod approach;
pub mod asked;
pub mod choice;
pub mod law;
pub mod leaving;
pub mod merit;
pub mod neighbours;
pub mod orientation;
pub mod rest;
pub mod search;
pub mod together;
pub mod turning;

use crate::buffers::Buffers;
use crate::envelope::{Envelope, ON_BORDER};
use crate::motion::{Swing, Turn, Wrench};
use crate::plan::{Outcome, Plan};
use crate::planner_config::LossTolerance;
use crate::setting::{Approach, Presence, Setting};
use leaving::Leaving;
use search::{Found, Search};

/// Halvings of the interval in which the farthest wrench in a direction is looked for.
const HALVINGS: usize = 6;

/// With no more relative error than this a cycle that any module may stop in is not improved on. *Assumed.*
const GOOD_ERROR: f64 = 0.05;

/// Beyond so many modules Algorithm 1 is not asked for the farthest wrench of a direction, which takes it several times.
const FIELD_MODULES: usize = 100;

/// Plans for one structure.
#[derive(Clone, Debug)]
pub struct ExactPlanner {
    setting: Setting,
    envelope: Envelope,
    search: Search,
    leaving: Leaving,
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
        let leaving = Leaving::new(&setting);
        Self { all_free: search.all_free(), setting, envelope, search, leaving }
    }

    /// See [`Planner::plan_into`](crate::planner::Planner::plan_into).
    pub fn plan_into(
        &mut self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
        plan: &mut Plan,
    ) {
        self.discard(std::mem::take(plan));
        self.setting.mind(previous);
        *plan = self.plan_as_asked(demand, tails, previous);
        let power = self.setting.config.loss_tolerant == LossTolerance::Power;
        if power && !(is_tolerant(plan) && (is_good(plan) || is_leaving(plan))) {
            self.make_power_tolerant(plan, demand, tails, previous);
        }
    }

    /// Where what any module may stop in does not do what was demanded: the most of it that can be done all the same.
    ///
    /// A side changes hands only over a cycle in which one of the two does not use it. Where that keeps most of a demand from being
    /// met, nothing moves for a cycle. Only where a tail rests in a neighbour's reach and there is no way out that any module may
    /// stop in, one is taken that any may miss, or none.
    fn make_power_tolerant(
        &mut self,
        plan: &mut Plan,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
    ) {
        let in_reach = tails.is_some_and(|tails| !self.search.may_stay(tails));
        let share = self.farthest(demand, 1.0, tails, previous);
        if let Some(part) = share.and_then(|found| self.examine(found, tails, demand)) {
            let better = !is_tolerant(plan) || part.error < plan.error;
            self.discard(if better { std::mem::replace(plan, part) } else { part });
        }
        let moved = previous.is_some_and(|cycle| cycle.iter().any(|swing| swing.amplitude_rad != 0.0));
        if moved && (!is_tolerant(plan) || plan.error > GOOD_ERROR) {
            self.setting.mind(None);
            let free = self.plan_as_asked(demand, tails, previous);
            self.setting.mind(previous);
            let pauses = !is_tolerant(plan) || is_tolerant(&free) && free.error < 0.5 * plan.error;
            self.discard(free);
            if pauses {
                self.discard(std::mem::take(plan));
                *plan = self.pause(demand, tails).unwrap_or_else(|| self.hold(demand, tails, previous));
                return;
            }
        }
        if is_tolerant(plan) || !in_reach {
            return;
        }
        for tolerance in [LossTolerance::Require, LossTolerance::Prefer] {
            self.discard(std::mem::take(plan));
            self.setting.config.loss_tolerant = tolerance;
            *plan = self.plan_as_asked(demand, tails, previous);
            self.setting.config.loss_tolerant = LossTolerance::Power;
            if plan.outcome == Outcome::Planned {
                break;
            }
        }
    }

    /// A cycle in which nothing moves.
    fn pause(&mut self, demand: Wrench, tails: Option<&[f64]>) -> Option<Plan> {
        let rest = |&tail_rad: &f64| Swing { centerline_rad: tail_rad, amplitude_rad: 0.0 };
        let stay = |&tail_rad: &f64| Turn { from_rad: tail_rad, to_rad: tail_rad };
        let buffers = &mut self.search.buffers;
        let approach = self.setting.one_step(buffers.turns(tails?.iter().map(stay)));
        let cycle = buffers.cycle(tails?.iter().map(rest));
        self.examine(Found { cycle, approach: Some(approach), error: 1.0, met: false }, tails, demand)
    }

    fn hold(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        self.setting.hold(demand, tails, previous, &mut self.search.buffers)
    }

    fn repeat(&mut self, demand: Wrench, tails: &[f64], previous: &[Swing]) -> Option<Plan> {
        self.setting.repeat(demand, tails, previous, &mut self.search.buffers)
    }

    fn discard(&mut self, plan: Plan) {
        self.search.buffers.keep_plan(plan);
    }

    fn plan_as_asked(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let known = tails.is_none_or(|tails| tails.iter().all(|tail| tail.is_finite()));
        // Neither what is no number nor what has no square is a demand.
        if !(known && demand.weighted_norm(self.setting.config.weights).is_finite()) {
            return self.hold(demand, tails, previous);
        }
        // No way leads out of a contact: nothing is looked for.
        if tails.is_some_and(|tails| !self.search.may_stay(tails)) {
            let held = self.hold(demand, tails, previous);
            if held.clearance_m <= 0.0 {
                return held;
            }
            self.discard(held);
        }
        let mut found = self.solve(demand, tails, previous, usize::MAX);
        let mut outside_envelope = false;
        if !found.as_ref().is_some_and(|found| found.met) {
            let gauge = self.envelope.gauge(demand);
            outside_envelope = gauge > 1.0;
            if outside_envelope
                && gauge.is_finite()
                && let Some(farthest) = self.farthest(demand, 1.0 / gauge, tails, previous)
            {
                farthest.replace(&mut found, &mut self.search.buffers);
            }
        }
        let plan = found
            .and_then(|found| self.examine(found, tails, demand))
            .or_else(|| self.leave(tails?, demand))
            .or_else(|| self.repeat(demand, tails?, previous?))
            .unwrap_or_else(|| self.hold(demand, tails, previous));
        Plan { outside_envelope, ..plan }
    }

    /// The plan that comes of what was found, if no two tails touch in it and it is as tolerant as it must be.
    fn examine(&mut self, found: Found, tails: Option<&[f64]>, demand: Wrench) -> Option<Plan> {
        let Self { setting, search, .. } = self;
        let Found { cycle, approach, .. } = found;
        let plan = setting.examine(Outcome::Planned, cycle, approach, tails, demand, &mut search.buffers)?;
        if is_kept(setting, plan.loss_tolerant, plan.power_tolerant, tails) {
            return Some(plan);
        }
        self.discard(plan);
        None
    }

    /// Where a plan that any module may miss is required and a tail rests in a neighbour's reach: out of it first.
    fn leave(&mut self, tails: &[f64], demand: Wrench) -> Option<Plan> {
        if !self.setting.config.loss_tolerant.is_required() {
            return None;
        }
        [false, true].into_iter().find_map(|slow| {
            let Self { setting, search, leaving, .. } = &mut *self;
            let (cycle, approach) = leaving.find(setting, &search.rest, tails, slow, &mut search.buffers)?;
            let found = Found { cycle, approach: Some(approach), error: 1.0, met: false };
            self.examine(found, Some(tails), demand)
        })
    }

    /// The best found for one demand: met if it can be, else the nearest. Of more than `field_modules` modules Algorithm 1 is
    /// not asked.
    fn solve(
        &mut self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
        field_modules: usize,
    ) -> Option<Found> {
        // Between free poses whatever is clear is loss tolerant.
        let free = self.all_free && tails.is_none_or(|tails| self.search.may_stay(tails));
        let tolerances: &[bool] = match self.setting.config.loss_tolerant {
            LossTolerance::Off => &[false],
            LossTolerance::Require | LossTolerance::Power => &[true],
            LossTolerance::Prefer if free => &[true],
            LossTolerance::Prefer => &[true, false],
        };
        let Self { setting, search, envelope, .. } = self;
        let mut best = Cheapest { setting, tails, found: None, price: f64::INFINITY };
        let mut done = false;
        for &loss_tolerant in tolerances {
            if done {
                break;
            }
            done = tails.is_some_and(|tails| {
                let found = search.stay(setting, demand, tails, previous, loss_tolerant);
                best.offer(found, &mut search.buffers)
            });
            done = done || {
                let found = search.turn(setting, demand, tails, loss_tolerant);
                best.offer(found, &mut search.buffers)
            };
        }
        let met = best.found.as_ref().is_some_and(|found| found.met);
        let required = setting.config.loss_tolerant.is_required();
        // What the envelope does not hold cannot be met: see `farthest`.
        if !(done || met || required) && setting.all_take_part() && envelope.gauge(demand) <= ON_BORDER {
            let found = search.turn_together(setting, envelope, demand, tails);
            if !best.offer(found, &mut search.buffers) && setting.cells.len() <= field_modules {
                let found = search.turn_by_field(setting, demand, tails, previous);
                best.offer(found, &mut search.buffers);
            }
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
            match self.solve(wanted, tails, previous, FIELD_MODULES) {
                Some(found) if found.met => {
                    low = middle;
                    found.replace(&mut best, &mut self.search.buffers);
                }
                unmet => {
                    high = middle;
                    unmet.into_iter().for_each(|found| found.discard(&mut self.search.buffers));
                }
            }
        }
        best
    }
}

/// Whether a plan is as tolerant as it must be.
fn is_kept(setting: &Setting, loss_tolerant: bool, power_tolerant: bool, tails: Option<&[f64]>) -> bool {
    // With unknown angles no module could have stayed anywhere.
    let asked = setting.config.loss_tolerant;
    let required = asked.is_required() && tails.is_some();
    loss_tolerant && (power_tolerant || asked != LossTolerance::Power) || !required
}

/// Whether a plan moves something, and any module may stop in it.
fn is_tolerant(plan: &Plan) -> bool {
    plan.outcome == Outcome::Planned && plan.power_tolerant
}

/// Whether a plan does what was demanded, or as much of it as can be.
fn is_good(plan: &Plan) -> bool {
    plan.outcome == Outcome::Planned && (plan.error <= GOOD_ERROR || plan.outside_envelope)
}

/// Whether a plan does nothing but turn tails out of their neighbours' reach, and any module may miss it.
fn is_leaving(plan: &Plan) -> bool {
    let rests = |swing: &Swing| swing.amplitude_rad == 0.0;
    plan.loss_tolerant && plan.transition.is_some() && plan.cycle.iter().all(rests)
}

/// The cheapest of what is offered: relative error, and the time of the transition by `travel_weight`.
struct Cheapest<'a> {
    setting: &'a Setting,
    tails: Option<&'a [f64]>,
    found: Option<Found>,
    price: f64,
}

impl Cheapest<'_> {
    /// What the search asks of each motion holds of each: a tail that stops in the transition stands there in the swim too. So where
    /// any module may lose its power, the whole is judged.
    fn is_kept(&self, found: &Found) -> bool {
        let Self { setting, tails, .. } = *self;
        setting.config.loss_tolerant != LossTolerance::Power
            || setting
                .judge(&found.cycle, found.approach.as_ref(), tails)
                .is_some_and(|judged| is_kept(setting, judged.loss_tolerant, judged.power_tolerant, tails))
    }

    /// True if nothing much better can come.
    fn offer(&mut self, found: Option<Found>, buffers: &mut Buffers) -> bool {
        let Some(found) = found else { return false };
        if !self.is_kept(&found) {
            found.discard(buffers);
            return false;
        }
        let weight = self.setting.config.travel_weight;
        let transition_s = found.approach.as_ref().map_or(0.0, Approach::transition_s);
        let error = if found.met { 0.0 } else { found.error };
        let price = error + weight * transition_s / self.setting.parameters.period_s;
        if price < self.price {
            self.price = price;
            found.replace(&mut self.found, buffers);
        } else {
            found.discard(buffers);
        }
        price <= weight
    }
}

#[cfg(test)]
mod tests;
