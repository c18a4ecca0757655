//! The exact planner: the demanded wrench met to rounding, by cycles that start where the last ended.
//!
//! Every cycle starts and ends at a rest pose pᵢ = φ₀ᵢ + Aᵢ that is out of the neighbours' reach ([`rest`]). That has three
//! consequences:
//!
//! - the next cycle, φ₀' + A' = p, needs no transition: one free parameter per module is left, and three numbers to hit
//!   ([`allocation`]);
//! - any module may miss a cycle: one that holds its last pose is in no other's way;
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
//! | [`rest`] | rest poses out of every neighbour's reach |
//! | [`law`] | what a module can push from a rest pose |
//! | [`neighbours`] | which cycles go together |
//! | [`allocation`] | amplitudes for a wrench: coordinate descent, Newton's method |
//! | [`orientation`] | rest poses for a wrench and those about it |
//! | [`asked`] | what is looked for, and what turning costs |
//! | [`approach`] | the way from here to there |
//! | [`cheapest`] | the cheapest of what was found |
//! | [`quiet`] | cycles that turn the structure little |
//! | [`wobble`] | how far a cycle turns the structure to and fro |
//! | [`merit`] | what rest poses are worth for what may come next |
//! | [`search`] | staying where the tails rest |
//! | [`turning`] | turning to other rest poses, or to the cycles of Algorithm 1 |
//! | [`together`] | swinging in step, near the border of the envelope |
//! | [`leaving`] | out of the neighbours' reach, so that any module may miss it |

pub mod allocation;
pub mod approach;
pub mod asked;
pub mod cheapest;
pub mod choice;
pub mod law;
pub mod leaving;
pub mod merit;
pub mod neighbours;
pub mod orientation;
pub mod quiet;
pub mod rest;
pub mod search;
pub mod together;
pub mod turning;
pub mod wobble;

use crate::envelope::{Envelope, ON_BORDER};
use crate::motion::{Swing, Turn, Wrench};
use crate::plan::{Outcome, Plan, Previous};
use crate::planner_config::LossTolerance;
use crate::setting::{Case, Participation, Setting, Span};
use cheapest::{Cheapest, is_kept};
use choice::SMALL;
use leaving::Leaving;
use search::{CycleCandidate, Search, Staying};

/// Halvings of the interval in which the farthest wrench in a direction is looked for.
const HALVINGS: usize = 6;

/// With no more relative error than this a cycle that any module may stop in is not improved on. *Assumed.*
const GOOD_ERROR: f64 = 0.05;

/// Beyond so many modules Algorithm 1 is not asked for the farthest wrench of a direction, which takes it several times.
const FIELD_MODULES: usize = 100;

/// One request for a plan.
#[derive(Clone, Copy)]
struct Request<'a> {
    demand: Wrench,
    tails: Option<&'a [f64]>,
    /// The cycle before.
    previous: Option<&'a [Swing]>,
    /// From which amplitudes the search begins where tails stay.
    near: Option<&'a [Swing]>,
    tolerance: LossTolerance,
    /// See [`Case::before`].
    before: Option<&'a [Span]>,
}

impl<'a> Request<'a> {
    fn case(&self, setting: &'a Setting) -> Case<'a> {
        Case { setting, tolerance: self.tolerance, before: self.before }
    }
}

/// The exact planner of one structure.
#[derive(Clone, Debug)]
pub struct ExactPlanner {
    setting: Setting,
    envelope: Envelope,
    search: Search,
    leaving: Leaving,
    /// Whether every module has a free pose: then a plan that meets the demand is loss tolerant too.
    all_free: bool,
    /// Whether one transition is worth cycles that any module may stop in.
    settled: bool,
    /// The swim for which tails left their neighbours' reach; none once it has begun.
    aimed: Vec<Swing>,
    /// Where tails would best turn to, rad.
    wanted: Vec<f64>,
    /// Where each module can have stopped in the decision before.
    stopped: Vec<Span>,
}

impl ExactPlanner {
    /// A planner for the structure of `setting`.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        let active = setting.positions_m.iter().zip(&setting.participation).enumerate();
        let active = active.filter(|(_, (_, participation))| **participation == Participation::Active);
        let active = active.map(|(place, (at, _))| (*at, setting.parameters.share(place)));
        let envelope = Envelope::of(&active.collect::<Vec<_>>(), &setting.parameters);
        let search = Search::new(&setting);
        let leaving = Leaving::new(&setting);
        Self {
            all_free: search.all_free(),
            settled: false,
            aimed: Vec::new(),
            wanted: Vec::with_capacity(setting.cells.len()),
            stopped: Vec::with_capacity(setting.cells.len()),
            setting,
            envelope,
            search,
            leaving,
        }
    }

    /// See [`Planner::forget`](crate::planner::Planner::forget).
    pub fn forget(&mut self) {
        self.settled = false;
        self.aimed.clear();
    }

    /// See [`Planner::plan_into`](crate::planner::Planner::plan_into).
    pub fn plan_into(
        &mut self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<Previous<'_>>,
        plan: &mut Plan,
    ) {
        self.discard(std::mem::take(plan));
        let tolerance = self.setting.config.loss_tolerant;
        let mut stopped = std::mem::take(&mut self.stopped);
        let before = self.setting.stopped(previous, &mut stopped).then_some(stopped.as_slice());
        let previous = previous.map(|previous| previous.cycle);
        let aimed = std::mem::take(&mut self.aimed);
        let begins = previous.is_some_and(|cycle| cycle.len() == aimed.len() && !moves(cycle));
        let near = if begins { Some(aimed.as_slice()) } else { previous };
        let request = Request { demand, tails, previous, near, tolerance, before };
        *plan = self.plan_as_asked(request);
        let power = tolerance == LossTolerance::Power;
        if power && !(is_tolerant(plan) && (is_good(plan) || is_leaving(plan))) {
            self.make_power_tolerant(plan, request);
        }
        self.stopped = stopped;
    }

    /// See [`Planner::leave_into`](crate::planner::Planner::leave_into).
    pub fn leave_into(&mut self, demand: Wrench, tails: &[f64], plan: &mut Plan) -> bool {
        if self.setting.config.loss_tolerant == LossTolerance::Off || self.search.may_stay(tails) {
            return false;
        }
        let known = Some(tails);
        let mut request = Request {
            demand,
            tails: known,
            previous: None,
            near: None,
            tolerance: LossTolerance::Prefer,
            before: None,
        };
        // To where the swim that follows would best begin.
        let aimed = self.plan_as_asked(request);
        let planned = aimed.outcome == Outcome::Planned;
        let wanted = planned.then(|| aimed.cycle.iter().map(|swing| swing.start_rad()).collect::<Vec<f64>>());
        self.aimed.clear();
        self.aimed.extend(aimed.cycle.iter().copied());
        self.discard(aimed);
        request.demand = Wrench::default();
        let found = [LossTolerance::Power, LossTolerance::Require]
            .into_iter()
            .find_map(|tolerance| self.leave(Request { tolerance, ..request }, wanted.as_deref()));
        let left = found.is_some();
        if let Some(found) = found {
            self.discard(std::mem::replace(plan, found));
        }
        left
    }

    /// See [`Planner::settle`](crate::planner::Planner::settle).
    pub fn settle(&mut self, settled: bool) {
        self.settled = settled;
    }

    /// Where what any module may stop in does not do what was demanded: the most of it that can be done all the same.
    ///
    /// A side changes hands only over a cycle in which one of the two does not use it. Where that keeps most of a demand from being
    /// met, nothing moves for a cycle. Only where a tail rests in a neighbour's reach and there is no way out that any module may
    /// stop in, one is taken that any may miss, or none.
    fn make_power_tolerant(&mut self, plan: &mut Plan, request: Request<'_>) {
        let in_reach = request.tails.is_some_and(|tails| !self.search.may_stay(tails));
        let share = self.farthest(request, 1.0);
        if let Some(part) = share.and_then(|found| self.examine(found, request)) {
            let better = !is_tolerant(plan) || part.error < plan.error;
            self.discard(if better { std::mem::replace(plan, part) } else { part });
        }
        let moved = request.before.is_some_and(|spans| spans.iter().any(|[least, most]| least < most));
        if moved && (!is_tolerant(plan) || plan.error > GOOD_ERROR) {
            let free = self.plan_as_asked(Request { before: None, ..request });
            let pauses = !is_tolerant(plan) || is_tolerant(&free) && free.error < 0.5 * plan.error;
            self.discard(free);
            if pauses {
                self.discard(std::mem::take(plan));
                *plan = self.pause(request).unwrap_or_else(|| self.hold(request));
                return;
            }
        }
        let swam = request.previous.is_some_and(moves);
        if swam
            && is_tolerant(plan)
            && plan.error > GOOD_ERROR
            && let Some(turned) = self.turn_over(request, plan.error)
        {
            self.discard(std::mem::replace(plan, turned));
            return;
        }
        if is_tolerant(plan) || !in_reach {
            return;
        }
        for tolerance in [LossTolerance::Require, LossTolerance::Prefer] {
            self.discard(std::mem::take(plan));
            *plan = self.plan_as_asked(Request { tolerance, ..request });
            if plan.outcome == Outcome::Planned {
                break;
            }
        }
    }

    /// Where cycles that any module may stop in give little of a demand from where the tails rest, and much more from elsewhere: turns to
    /// there, and no swim.
    fn turn_over(&mut self, request: Request<'_>, error: f64) -> Option<Plan> {
        let anywhere = Request { tails: None, previous: None, near: None, before: None, ..request };
        let aimed = self.plan_as_asked(anywhere);
        let mut wanted = std::mem::take(&mut self.wanted);
        wanted.clear();
        wanted.extend(aimed.cycle.iter().map(|swing| swing.start_rad()));
        let better = aimed.outcome == Outcome::Planned && aimed.error < 0.5 * error;
        self.discard(aimed);
        let found = better.then(|| self.leave(request, Some(&wanted))).flatten();
        self.wanted = wanted;
        found
    }

    /// A cycle in which nothing moves.
    fn pause(&mut self, request: Request<'_>) -> Option<Plan> {
        let tails = request.tails?;
        let rest = |&tail_rad: &f64| Swing { centerline_rad: tail_rad, amplitude_rad: 0.0 };
        let stay = |&tail_rad: &f64| Turn { from_rad: tail_rad, to_rad: tail_rad };
        let buffers = &mut self.search.buffers;
        let approach = self.setting.one_step(buffers.turns(tails.iter().map(stay)));
        let cycle = buffers.cycle(tails.iter().map(rest));
        self.examine(CycleCandidate { cycle, approach: Some(approach), error: 1.0, met: false }, request)
    }

    fn hold(&mut self, request: Request<'_>) -> Plan {
        let Request { demand, tails, previous, .. } = request;
        request.case(&self.setting).hold(demand, tails, previous, &mut self.search.buffers)
    }

    fn repeat(&mut self, request: Request<'_>) -> Option<Plan> {
        let Request { demand, tails, previous, .. } = request;
        request.case(&self.setting).repeat(demand, tails?, previous?, &mut self.search.buffers)
    }

    fn discard(&mut self, plan: Plan) {
        self.search.buffers.keep_plan(plan);
    }

    fn plan_as_asked(&mut self, request: Request<'_>) -> Plan {
        let Request { demand, tails, .. } = request;
        let known = tails.is_none_or(|tails| tails.iter().all(|tail| tail.is_finite()));
        // Neither what is no number nor what has no square is a demand.
        if !(known && demand.weighted_norm(self.setting.config.weights).is_finite()) {
            return self.hold(request);
        }
        // No way leads out of a contact: nothing is looked for.
        if tails.is_some_and(|tails| !self.search.may_stay(tails)) {
            let held = self.hold(request);
            if held.clearance_m <= 0.0 {
                return held;
            }
            self.discard(held);
        }
        let mut found = self.solve(request, usize::MAX);
        let mut outside_envelope = false;
        if !found.as_ref().is_some_and(|found| found.met) {
            let gauge = self.envelope.gauge(demand);
            outside_envelope = gauge > 1.0;
            if outside_envelope
                && gauge.is_finite()
                && let Some(farthest) = self.farthest(request, 1.0 / gauge)
            {
                farthest.replace(&mut found, &mut self.search.buffers);
            }
        }
        let plan = found
            .and_then(|found| self.examine(found, request))
            .or_else(|| self.leave(request, None))
            .or_else(|| self.repeat(request))
            .unwrap_or_else(|| self.hold(request));
        Plan { outside_envelope, ..plan }
    }

    /// The plan that comes of what was found, if no two tails touch in it and it is as tolerant as it must be.
    fn examine(&mut self, found: CycleCandidate, request: Request<'_>) -> Option<Plan> {
        let Self { setting, search, .. } = self;
        let (case, Request { demand, tails, .. }) = (request.case(setting), request);
        let CycleCandidate { cycle, approach, .. } = found;
        let plan = case.examine(Outcome::Planned, cycle, approach, tails, demand, &mut search.buffers)?;
        if is_kept(case.tolerance, plan.loss_tolerant, plan.power_tolerant, tails) {
            return Some(plan);
        }
        self.discard(plan);
        None
    }

    /// Where a plan that any module may miss is required and a tail rests in a neighbour's reach: out of it first.
    fn leave(&mut self, request: Request<'_>, wanted: Option<&[f64]>) -> Option<Plan> {
        let tails = request.tails.filter(|_| request.tolerance.is_required())?;
        [false, true].into_iter().find_map(|slow| {
            let Self { setting, search, leaving, .. } = &mut *self;
            let case = request.case(setting);
            let (cycle, approach) =
                leaving.find(case, &search.rest, tails, wanted, slow, &mut search.buffers)?;
            let found = CycleCandidate { cycle, approach: Some(approach), error: 1.0, met: false };
            self.examine(found, request)
        })
    }

    /// The best found for one demand: met if it can be, else the nearest. Of more than `field_modules` modules Algorithm 1 is
    /// not asked.
    fn solve(&mut self, request: Request<'_>, field_modules: usize) -> Option<CycleCandidate> {
        let Request { demand, tails, previous, near, .. } = request;
        // Between free poses whatever is clear is loss tolerant.
        let free = self.all_free && tails.is_none_or(|tails| self.search.may_stay(tails));
        let tolerances: &[bool] = match request.tolerance {
            LossTolerance::Off => &[false],
            LossTolerance::Require | LossTolerance::Power => &[true],
            LossTolerance::Prefer if free => &[true],
            LossTolerance::Prefer => &[true, false],
        };
        let few = self.setting.cells.len() < SMALL;
        if request.tolerance == LossTolerance::Prefer
            && free
            && self.settled
            && few
            && let Some(tails) = tails
            && let Some(previous) = previous
            && let Some(found) =
                self.search.keep_still(request.case(&self.setting), demand, (tails, near), previous)
        {
            return Some(found);
        }
        if request.tolerance == LossTolerance::Prefer
            && free
            && let Some(found) = self.solve_stoppable(request)
        {
            return Some(found);
        }
        let Self { setting, search, envelope, .. } = self;
        let case = request.case(setting);
        let mut best = Cheapest { case, tails, found: None, price: f64::INFINITY };
        let mut done = false;
        for &loss_tolerant in tolerances {
            if done {
                break;
            }
            done = tails.is_some_and(|tails| {
                let found = search.stay(case, demand, tails, near, loss_tolerant, Staying::Searched);
                best.offer(found, &mut search.buffers)
            });
            done = done || {
                let found = search.turn(case, demand, tails, loss_tolerant);
                best.offer(found, &mut search.buffers)
            };
        }
        let met = best.found.as_ref().is_some_and(|found| found.met);
        let required = request.tolerance.is_required();
        // What the envelope does not hold cannot be met: see `farthest`.
        if !(done || met || required) && case.all_active() && envelope.gauge(demand) <= ON_BORDER {
            let found = search.turn_together(case, envelope, demand, tails);
            if !best.offer(found, &mut search.buffers) && case.cells.len() <= field_modules {
                let found = search.turn_by_field(case, demand, tails, previous);
                best.offer(found, &mut search.buffers);
            }
        }
        best.found
    }

    /// What meets the demand, with cycles that any module may stop in: by going on as before; once the demand has settled, also from
    /// other rest poses.
    ///
    /// The cycle before is left out of account: how sides change hands decides whether this very plan is tolerant, and it says so; that
    /// each has one owner makes the next ones so.
    fn solve_stoppable(&mut self, request: Request<'_>) -> Option<CycleCandidate> {
        let Self { setting, search, settled, .. } = self;
        let (Request { demand, near, .. }, tails) = (request, request.tails?);
        let case = Case { setting, tolerance: LossTolerance::Power, before: None };
        if let Some(found) = search.stay(case, demand, tails, near, true, Staying::Continued) {
            if found.met {
                return Some(found);
            }
            found.discard(&mut search.buffers);
        }
        // Three modules yaw to and fro against amplitudes that do not cancel, from some rest poses much more than from others: they
        // keep theirs.
        if !*settled || tails.len() < SMALL {
            return None;
        }
        let best = Cheapest { case, tails: request.tails, found: None, price: f64::INFINITY };
        let is_kept = |found: &CycleCandidate| found.met && best.is_kept(found);
        if let Some(found) = search.stay(case, demand, tails, near, true, Staying::Searched) {
            if is_kept(&found) {
                return Some(found);
            }
            found.discard(&mut search.buffers);
        }
        let found = search.turn(case, demand, request.tails, true)?;
        if is_kept(&found) {
            return Some(found);
        }
        found.discard(&mut search.buffers);
        None
    }

    /// The farthest wrench in the direction of the demand, up to `share` of it, that is met.
    fn farthest(&mut self, request: Request<'_>, share: f64) -> Option<CycleCandidate> {
        let (mut low, mut high, mut best) = (0.0, share, None);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let components = request.demand.to_array().map(|component| middle * component);
            let wanted = Request { demand: Wrench::from_array(components), ..request };
            match self.solve(wanted, FIELD_MODULES) {
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

fn moves(cycle: &[Swing]) -> bool {
    cycle.iter().any(|swing| swing.amplitude_rad != 0.0)
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
    plan.loss_tolerant && plan.transition.is_some() && !moves(&plan.cycle)
}

#[cfg(test)]
mod tests;
