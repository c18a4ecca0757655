//! Constraints that keep a plan safe beside tails of unknown angle, and when modules lose power in mid-motion.
//!
//! Both come down to one question: does a tail stay out of a neighbour's reach all the way? A tail at angle φ can touch that of a
//! neighbour only within ±reach of the direction towards it, wherever the other one is ([`Reach`]). So
//!
//! - beside a module with unknown tail angle, its neighbours keep out of its reach;
//! - of two neighbours that move, one keeps out of the other's reach: then either may stop anywhere, as one does that loses its
//!   power, and the other goes on. Each shared side belongs to one of the two while a cycle lasts. A module may stop in
//!   one cycle and its neighbours begin the next before the host knows, so a side changes hands only over a cycle in which
//!   neither uses it.
//!
//! A tail that loses its power goes on. The firmware's board shorts the motor in reset, so that it is braked by its own winding,
//! φ̈ = −φ̇/τ_m, and stops after ω·τ_m where a planned motion at −α stops after ω²/2α. So it can come to rest beyond the end of
//! what was planned: of a transition by up to ατ_m²/2, of a swing by A·(√(1 + (2πτ_m/T)²) − 1), and what the servo is off
//! comes on top. Everything a tail passes is therefore continued by [`stop_past_turn_rad`](crate::parameters::Parameters::stop_past_turn_rad) beyond the end of each
//! turn, and by [`stop_past_swing_rad`](crate::parameters::Parameters::stop_past_swing_rad) beyond both ends of a swing; that it stops anywhere short of there is in it.
//! Of a pair of which one rests, the other one, so continued, is held against the resting tail by the exact geometry.
//!
//! Assumptions and limits: sufficient, not necessary (the region in which two tails collide is smaller than the square about it).
//! Of the cycle before, the swing is taken into account, the transition is not. At constant speed, of which nothing is known, a
//! tail that turns may stop anywhere.

use std::f64::consts::TAU;

use super::{Case, Setting, swim_ends, turn_ends};
use crate::motion::Swing;
use crate::pairs::Pair;
use crate::planner_config::{LawOfTime, LossTolerance};
use crate::transition::STILL_RAD;
use crate::tube::Tube;
use crate::way::Steps;

/// The least and the greatest angle that a tail passes or comes to rest at, rad, unwrapped; equal to the bit where it stays.
type Span = [f64; 2];

/// Participation of a module in a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Participation {
    /// It executes its setpoints.
    #[default]
    Active,
    /// It stays at this angle, rad: its tail is within reach of one with unknown angle.
    Held(f64),
    /// Its tail angle is unknown: its neighbours keep out of its reach altogether.
    Unknown,
}

impl Setting {
    /// Whether all modules are active.
    #[must_use]
    pub fn all_active(&self) -> bool {
        self.participation.iter().all(|participation| *participation == Participation::Active)
    }

    /// Whether a tail angle of the pair is unknown.
    #[must_use]
    pub fn is_unknown(&self, pair: &Pair) -> bool {
        [pair.i, pair.j].iter().any(|&module| self.participation[module] == Participation::Unknown)
    }

    /// Whether beside an unknown tail the other one of the pair may move all the way from → to, given for both: never within
    /// the unknown one's reach. A tail that does not move may be anywhere.
    #[must_use]
    pub fn keeps_out(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        let reach = &self.reaches[pair.offset];
        [pair.j, pair.i].into_iter().enumerate().all(|(end, other)| {
            self.participation[other] != Participation::Unknown
                || rests(from_rad[end], to_rad[end])
                || reach.clears_along(end, from_rad[end], to_rad[end])
        })
    }

    /// How far beyond the ends of a swing a tail can come to rest, more than e_s, which reaches and tubes hold already, rad.
    fn past_swing_rad(&self) -> f64 {
        (self.parameters.stop_past_swing_rad - self.parameters.tracking_error_rad).max(0.0)
    }

    /// The same of the end of a turn.
    fn past_turn_rad(&self) -> f64 {
        match self.config.law() {
            LawOfTime::RestToRest => {
                (self.parameters.stop_past_turn_rad - self.parameters.tracking_error_rad).max(0.0)
            }
            LawOfTime::ConstantSpeed => TAU,
        }
    }

    /// Where a tail can be in this swing, and where it can stop.
    fn swung(&self, swing: Swing) -> Span {
        let (start_rad, far_rad) = (swing.start_rad(), swing.start_rad() - 2.0 * swing.amplitude_rad);
        if swing.amplitude_rad == 0.0 {
            return [start_rad; 2];
        }
        let past_rad = self.past_swing_rad();
        [start_rad.min(far_rad) - past_rad, start_rad.max(far_rad) + past_rad]
    }

    /// The same in a turn: beyond its end, as it starts from rest.
    fn turned(&self, from_rad: f64, to_rad: f64) -> Span {
        if rests(from_rad, to_rad) {
            return [from_rad; 2];
        }
        let end_rad = to_rad + self.past_turn_rad().copysign(to_rad - from_rad);
        [from_rad.min(end_rad), from_rad.max(end_rad)]
    }

    /// Whether of a pair that passes `spans` either may stop anywhere: one keeps out of the other's reach; of two of which one
    /// rests, the other passes it clear.
    fn one_keeps_out(&self, pair: &Pair, spans: [Span; 2]) -> bool {
        let reach = &self.reaches[pair.offset];
        let [from_rad, to_rad] = [0, 1].map(|bound: usize| spans.map(|span| span[bound]));
        let still = [0, 1].map(|end: usize| rests(from_rad[end], to_rad[end]));
        still == [true, true]
            || (0..2).any(|end| reach.clears_along(end, from_rad[end], to_rad[end]))
            || still.contains(&true) && self.distance.tube_clear(Tube::One, pair.offset, from_rad, to_rad)
    }

    /// Whether modules that are not active rest, and the active ones keep out of reach of tails with unknown angle.
    pub(super) fn respects_participation(&self, steps: Steps<'_>, cycle: &[Swing]) -> bool {
        let idle = |module: usize| {
            self.participation[module] == Participation::Active
                || cycle[module].amplitude_rad == 0.0
                    && steps.iter().all(|step| step.turn(module).rotation_rad().abs() < STILL_RAD)
        };
        (0..cycle.len()).all(idle)
            && self.pairs.all().iter().filter(|pair| self.is_unknown(pair)).all(|pair| {
                let mut motions =
                    steps.iter().map(|step| turn_ends(step, pair)).chain([swim_ends(cycle, pair)]);
                motions.all(|[from, to]| self.keeps_out(pair, from, to))
            })
    }
}

impl Case<'_> {
    /// Whether a pair may turn from → to, as far as power is concerned: always, unless plans are to be tolerant of that.
    #[must_use]
    pub fn may_stop_turning(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        self.tolerance != LossTolerance::Power
            || self.stops_clear(pair, [0, 1].map(|end| self.turned(from_rad[end], to_rad[end])))
    }

    /// The same of a pair that swings so.
    #[must_use]
    pub fn may_stop_swinging(&self, pair: &Pair, swings: [Swing; 2]) -> bool {
        self.tolerance != LossTolerance::Power
            || self.stops_clear(pair, swings.map(|swing| self.swung(swing)))
    }

    /// Whether of a pair that passes `spans` one may stop anywhere while the other goes on: in this motion, or in the cycle before
    /// while the other one is in this motion already.
    fn stops_clear(&self, pair: &Pair, spans: [Span; 2]) -> bool {
        let before = self
            .before
            .and_then(|cycle| Some((self.swung(*cycle.get(pair.i)?), self.swung(*cycle.get(pair.j)?))));
        self.one_keeps_out(pair, spans)
            && before.is_none_or(|(i, j)| {
                self.one_keeps_out(pair, [spans[0], j]) && self.one_keeps_out(pair, [i, spans[1]])
            })
    }

    /// Whether in all of a plan any module may stop anywhere: one that stops in the transition stands there in the swim.
    pub(super) fn all_stop_clear(&self, steps: Steps<'_>, cycle: &[Swing]) -> bool {
        // Everything a tail passes, unwrapped: the swim goes on from where the transition ends.
        let passed = |module: usize| {
            let [mut least_rad, mut most_rad] = self.swung(cycle[module]);
            let mut end_rad = cycle[module].start_rad();
            for turn in steps.iter().rev().map(|step| step.turn(module)) {
                let from_rad = end_rad - turn.rotation_rad();
                let [low_rad, high_rad] = self.turned(from_rad, end_rad);
                (least_rad, most_rad) = (least_rad.min(low_rad), most_rad.max(high_rad));
                end_rad = from_rad;
            }
            [least_rad, most_rad]
        };
        self.pairs
            .all()
            .iter()
            .all(|pair| self.is_unknown(pair) || self.stops_clear(pair, [pair.i, pair.j].map(passed)))
    }
}

/// Equal to the bit: a tail that stays is given the same angle twice.
fn rests(from_rad: f64, to_rad: f64) -> bool {
    from_rad.to_bits() == to_rad.to_bits()
}
