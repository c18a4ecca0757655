//! The setting of a planner: one structure with its parameters, and the examination that every plan passes.
//!
//! The examination uses the exact tail geometry ([`Tail`](super::tail::Tail)), which shares nothing with the collision
//! regions that planners search by: a plan in which two tails touch is no plan.

use std::ops::Deref;
use std::sync::Arc;

use super::buffers::Buffers;
use super::distance::DistanceToCollision;
use super::motion::{self, StepTime, Swing, Turn, Wrench, ends};
use super::pairs::{Pair, Pairs};
use super::parameters::Parameters;
use super::plan::{Outcome, Plan};
use super::planner_config::{LawOfTime, LossTolerance, PlannerConfig};
use super::region::DEPTH_RAD;
use super::structure::Structure;
use super::transition::STILL_RAD;
use super::tube::{SLOW_RAD_S, Tube};
use quantity::wrap_rad;

/// A cycle "starts where the tails are" if none is further away than this, rad.
const THERE_RAD: f64 = 0.1;

/// A pair that rests nearer to a collision than a transition's margin may come no nearer than this share of it.
const REST_SHARE: f64 = 0.9;

/// The slow tube is a box: its corner is this many times as far away as its side.
const NARROW_SHARE: f64 = std::f64::consts::SQRT_2;

use crate::way::{Step, Steps};
use clearance::Clearance;

pub use crate::way::Approach;
pub use reach::Reach;
pub use tolerance::{Participation, Span};

mod clearance;
mod held;
mod reach;
mod tolerance;

/// What the examination of a plan in which no two tails touch finds; the fields are those of [`Plan`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "as in the plan")]
pub struct Judged {
    pub clearance_m: f64,
    pub guarantee_m: Option<f64>,
    pub loss_tolerant: bool,
    pub power_tolerant: bool,
}

/// A structure of modules, its neighbours, and where their tails collide.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The modules.
    pub parameters: Parameters,
    /// Settings of the planners.
    pub config: PlannerConfig,
    /// Lattice cells by module.
    pub cells: Vec<[i32; 2]>,
    /// Module centres in S by module, m.
    pub positions_m: Vec<[f64; 2]>,
    /// Pairs of modules with tails that can touch.
    pub pairs: Pairs,
    /// Where they do.
    pub distance: Arc<DistanceToCollision>,
    /// By offset: the direction from a module to that neighbour, and the greatest angle off it at which a tail can still
    /// touch the neighbour's, rad.
    pub reaches: Vec<Reach>,
    /// Each module's participation.
    pub participation: Vec<Participation>,
}

/// A setting, and what is asked of one plan in it.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// The setting.
    pub setting: &'a Setting,
    /// Loss tolerance asked of the plan.
    pub tolerance: LossTolerance,
    /// Where each module can have stopped in the decision that still runs, by module: its neighbours begin the plan before the host
    /// knows. `None` where that does not constrain the plan.
    pub before: Option<&'a [Span]>,
}

impl Deref for Case<'_> {
    type Target = Setting;

    fn deref(&self) -> &Setting {
        self.setting
    }
}

impl Setting {
    /// Of one structure; `distance` holds the collision regions of these very `parameters`.
    #[must_use]
    pub fn new(
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
        Self {
            parameters: parameters.clone(),
            config: config.clone(),
            cells: structure.cells().to_vec(),
            positions_m: structure.positions_m(parameters.pitch_m),
            pairs,
            reaches: distance.offsets().iter().map(|&offset| Reach::new(&distance, offset)).collect(),
            distance,
            participation: vec![Participation::Active; structure.len()],
        }
    }

    /// The same with a participation for each module; without this all are active.
    #[must_use]
    pub fn with_participation(mut self, participation: Vec<Participation>) -> Self {
        debug_assert_eq!(participation.len(), self.cells.len(), "one for each module");
        self.participation = participation;
        self
    }

    /// A plan in it as the configuration asks, whatever runs before.
    #[must_use]
    pub fn as_configured(&self) -> Case<'_> {
        Case { setting: self, tolerance: self.config.loss_tolerant, before: None }
    }

    /// The greatest |rotation| within `transition_s`, rad.
    #[must_use]
    pub fn rotation_max_rad(&self) -> f64 {
        self.parameters.tail_speed_max_rad_s * self.parameters.transition_s
    }

    /// Whether two neighbours at that offset index may turn from `from_rad` to `to_rad` together, in the usual time.
    #[must_use]
    pub fn may_turn(&self, offset: usize, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        match self.config.law() {
            LawOfTime::RestToRest => {
                let moves = [0, 1].map(|k| (to_rad[k] - from_rad[k]).abs() >= STILL_RAD);
                self.distance.tube_clear(Tube::of(moves), offset, from_rad, to_rad)
            }
            LawOfTime::ConstantSpeed => {
                let margin_rad = self.config.transition_margin_rad;
                self.distance.clear(offset, from_rad, to_rad, margin_rad)
                    || self.may_leave(offset, from_rad, to_rad, margin_rad)
            }
        }
    }

    /// Whether they may do so slowly, from a place too narrow for the usual tube.
    #[must_use]
    pub fn may_turn_slowly(&self, offset: usize, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        self.config.law() == LawOfTime::RestToRest
            && (self.distance.tube_clear(Tube::Slow, offset, from_rad, to_rad)
                || self.may_leave(
                    offset,
                    from_rad,
                    to_rad,
                    NARROW_SHARE * self.distance.errors().of(Tube::Slow),
                ))
    }

    /// Tails that stopped nearer to each other than `margin_rad` must be able to part: hardly nearer on the way.
    fn may_leave(&self, offset: usize, from_rad: [f64; 2], to_rad: [f64; 2], margin_rad: f64) -> bool {
        let rest_rad = self.distance.along(offset, from_rad, from_rad);
        rest_rad > 0.0
            && rest_rad < margin_rad
            && self.distance.clear(offset, from_rad, to_rad, REST_SHARE * rest_rad)
    }

    /// Whether two neighbours of which these move keep free of each other in a swim cycle.
    #[must_use]
    pub fn may_swim(&self, offset: usize, moves: [bool; 2], [from_rad, to_rad]: [[f64; 2]; 2]) -> bool {
        let (distance, margin_rad) = (&self.distance, self.config.swim_margin_rad);
        let tube = Tube::of(moves);
        // A motion whose margin is more than the half diagonal of the tube's box has its tube free.
        let beyond = |e_rad: f64| margin_rad >= std::f64::consts::SQRT_2 * (e_rad + DEPTH_RAD);
        distance.clear(offset, from_rad, to_rad, margin_rad)
            && (self.config.law() == LawOfTime::ConstantSpeed
                || beyond(distance.errors().of(tube))
                || distance.tube_clear(tube, offset, from_rad, to_rad))
    }

    /// Times of one step in which the longest rotation is `longest_rad`.
    #[must_use]
    pub fn step_time(&self, longest_rad: f64, slow: bool) -> StepTime {
        match self.config.law() {
            LawOfTime::RestToRest => {
                let (duration_s, ramp_s) = self.parameters.transition_times_s(longest_rad);
                // Slower by a common factor: the speed in that proportion, the acceleration in its square.
                let longer =
                    if slow { (self.parameters.transition_speed_rad_s() / SLOW_RAD_S).max(1.0) } else { 1.0 };
                StepTime { duration_s: longer * duration_s, ramp_s: longer * ramp_s }
            }
            LawOfTime::ConstantSpeed => StepTime { duration_s: self.parameters.transition_s, ramp_s: 0.0 },
        }
    }

    /// These turns in one step, in the usual time.
    #[must_use]
    pub fn one_step(&self, turns: Vec<Turn>) -> Approach {
        let longest_rad = turns.iter().map(|turn| turn.rotation_rad().abs()).fold(0.0, f64::max);
        let times = [self.step_time(longest_rad, false), StepTime::default()];
        Approach { turns, via_rad: None, times, slow: false }
    }

    /// The wrench of a cycle by (7).
    #[must_use]
    pub fn wrench(&self, cycle: &[Swing]) -> Wrench {
        motion::wrench(cycle, &self.parameters, &self.positions_m)
    }

    /// ‖w∘(F_des − F)‖ / ‖w∘F_des‖; for a zero demand ‖w∘F‖, N.
    #[must_use]
    pub fn error(&self, demand: Wrench, wrench: Wrench) -> f64 {
        let error_n = (demand - wrench).weighted_norm(self.config.weights);
        let norm_n = demand.weighted_norm(self.config.weights);
        if norm_n == 0.0 { error_n } else { error_n / norm_n }
    }
}

impl Case<'_> {
    /// The plan, if no two tails touch in it by the exact test. `tails` are the present angles, `approach` the way from
    /// there, both `None` where they are not known.
    #[must_use]
    pub fn examine(
        &self,
        outcome: Outcome,
        cycle: Vec<Swing>,
        approach: Option<Approach>,
        tails: Option<&[f64]>,
        demand: Wrench,
        buffers: &mut Buffers,
    ) -> Option<Plan> {
        let Some(Judged { clearance_m, guarantee_m, loss_tolerant, power_tolerant }) =
            self.judge(&cycle, approach.as_ref(), tails)
        else {
            buffers.keep(cycle, approach);
            return None;
        };
        let wrench = self.wrench(&cycle);
        let mut plan = Plan {
            outcome,
            error: self.error(demand, wrench),
            cycle,
            wrench,
            clearance_m,
            guarantee_m,
            loss_tolerant,
            power_tolerant,
            ..Plan::default()
        };
        match approach {
            Some(approach) if !approach.is_still() => {
                (plan.travel_rad, plan.transition_s) = (approach.travel_rad(), approach.transition_s());
                (plan.transition, plan.via_rad, plan.step_times) =
                    (Some(approach.turns), approach.via_rad, approach.times);
            }
            Some(Approach { turns, via_rad, .. }) => buffers.keep_way(Some(turns), via_rad),
            None => {}
        }
        Some(plan)
    }

    /// What the examination finds; `None` if two tails touch.
    #[must_use]
    pub fn judge(
        &self,
        cycle: &[Swing],
        approach: Option<&Approach>,
        tails: Option<&[f64]>,
    ) -> Option<Judged> {
        let steps = approach.filter(|a| !a.is_still()).map_or_else(Steps::default, Approach::steps);
        if !self.respects_participation(steps, cycle) {
            return None;
        }
        let slow = approach.is_some_and(|approach| approach.slow);
        let Clearance { planned_m: clearance_m, kept_m } = self.clearance(steps, slow, cycle);
        // Out of a place too narrow for any tube the plan itself has to do. Not "≤ 0": a NaN is no clearance either.
        let least_m = kept_m.filter(|_| !slow).unwrap_or(clearance_m).min(clearance_m);
        if least_m.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let loss_tolerant = tails.is_some_and(|tails| self.loss_tolerant(steps, cycle, tails));
        let power_tolerant = loss_tolerant && self.all_stop_clear(steps, cycle);
        let guarantee_m = kept_m.filter(|_| tails.is_some());
        Some(Judged { clearance_m, guarantee_m, loss_tolerant, power_tolerant })
    }

    /// The previous cycle once more, as it was, if the tails are where it starts.
    #[must_use]
    pub fn repeat(
        &self,
        demand: Wrench,
        tails: &[f64],
        previous: &[Swing],
        buffers: &mut Buffers,
    ) -> Option<Plan> {
        let near_rad = THERE_RAD.min(self.rotation_max_rad());
        let there = |(tail, swing): (&f64, &Swing)| wrap_rad(swing.start_rad() - tail).abs() <= near_rad;
        if !tails.iter().zip(previous).all(there) {
            return None;
        }
        let turns = buffers.turns(tails.iter().zip(previous).map(|(&from_rad, swing)| {
            let rotation_rad = wrap_rad(swing.start_rad() - from_rad);
            let still = rotation_rad.abs() < STILL_RAD;
            Turn { from_rad, to_rad: if still { from_rad } else { from_rad + rotation_rad } }
        }));
        let cycle = buffers.cycle(previous.iter().copied());
        let approach = Some(self.one_step(turns));
        self.examine(Outcome::Repeated, cycle, approach, Some(tails), demand, buffers)
    }

    /// A plan in which no module moves: tails at the present angles, or at the end of the previous cycle, or at zero.
    #[must_use]
    pub fn hold(
        &self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<&[Swing]>,
        buffers: &mut Buffers,
    ) -> Plan {
        let rest_rad = |module: usize| match (tails, previous) {
            (Some(tails), _) => tails[module],
            (None, Some(previous)) => previous[module].start_rad(),
            (None, None) => 0.0,
        };
        let rests = |module: usize| Swing { centerline_rad: rest_rad(module), amplitude_rad: 0.0 };
        let cycle = buffers.cycle((0..self.cells.len()).map(rests));
        let Clearance { planned_m: clearance_m, kept_m } = self.clearance(Steps::default(), false, &cycle);
        let guarantee_m = kept_m.filter(|_| tails.is_some());
        Plan {
            cycle,
            error: if demand == Wrench::default() { 0.0 } else { 1.0 },
            clearance_m,
            guarantee_m,
            loss_tolerant: tails.is_some() && clearance_m > 0.0,
            power_tolerant: tails.is_some() && clearance_m > 0.0,
            reason: Some(self.why_held(demand, tails, guarantee_m)),
            ..Plan::default()
        }
    }
}

/// Both ends of a pair's swim cycle in phase space (φᵢ, φⱼ).
#[must_use]
pub fn swim_ends(cycle: &[Swing], pair: &Pair) -> [[f64; 2]; 2] {
    ends(cycle[pair.i], cycle[pair.j])
}

fn turn_ends(step: Step<'_>, pair: &Pair) -> [[f64; 2]; 2] {
    let (i, j) = (step.turn(pair.i), step.turn(pair.j));
    [[i.from_rad, j.from_rad], [i.to_rad, j.to_rad]]
}
