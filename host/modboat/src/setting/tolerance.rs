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
//! Assumptions and limits: sufficient, not necessary (the region in which two tails collide is smaller than the square about it).
//! A module that stops is braked, and does not leave what it was to sweep: the firmware's board shorts the motor in reset.
//! Of the cycle before, the swing is taken into account, the transition is not.

use super::{Case, Setting, swim_ends, turn_ends};
use crate::motion::Swing;
use crate::pairs::Pair;
use crate::planner_config::LossTolerance;
use crate::transition::STILL_RAD;
use crate::way::Steps;

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
        (self.participation[pair.j] != Participation::Unknown
            || rests(from_rad[0], to_rad[0])
            || reach.clears_i_along(from_rad[0], to_rad[0]))
            && (self.participation[pair.i] != Participation::Unknown
                || rests(from_rad[1], to_rad[1])
                || reach.clears_j_along(from_rad[1], to_rad[1]))
    }

    /// Whether of a pair that moves from → to one keeps out of the other's reach; of two of which one rests nothing is asked.
    fn one_keeps_out(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        let reach = &self.reaches[pair.offset];
        rests(from_rad[0], to_rad[0])
            || rests(from_rad[1], to_rad[1])
            || reach.clears_i_along(from_rad[0], to_rad[0])
            || reach.clears_j_along(from_rad[1], to_rad[1])
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
    /// Whether a pair may move from → to, as far as power is concerned: always, unless plans are to be tolerant of that.
    #[must_use]
    pub fn may_stop(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        self.tolerance != LossTolerance::Power || self.stops_clear(pair, from_rad, to_rad)
    }

    /// Whether of a pair that moves from → to one may stop anywhere while the other goes on: in this motion, or in the cycle before
    /// while the other one is in this motion already.
    fn stops_clear(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        // From where to where a tail swings in the cycle before, rad.
        let span = |swing: &Swing| [swing.start_rad(), swing.start_rad() - 2.0 * swing.amplitude_rad];
        let before = self.before.and_then(|cycle| Some((span(cycle.get(pair.i)?), span(cycle.get(pair.j)?))));
        self.one_keeps_out(pair, from_rad, to_rad)
            && before.is_none_or(|(i, j)| {
                self.one_keeps_out(pair, [from_rad[0], j[0]], [to_rad[0], j[1]])
                    && self.one_keeps_out(pair, [i[0], from_rad[1]], [i[1], to_rad[1]])
            })
    }

    /// Whether in all of a plan any module may stop anywhere: one that stops in the transition stands there in the swim.
    pub(super) fn all_stop_clear(&self, steps: Steps<'_>, cycle: &[Swing]) -> bool {
        // Everything a tail passes, unwrapped: the swim goes on from where the transition ends.
        let passed = |module: usize| {
            let Swing { amplitude_rad, .. } = cycle[module];
            let mut span_rad = [0.0_f64; 2];
            let start_rad = cycle[module].start_rad();
            let mut pass = |rad: f64| span_rad = [span_rad[0].min(rad), span_rad[1].max(rad)];
            pass(-2.0 * amplitude_rad);
            let mut back_rad = 0.0;
            for turn in steps.iter().rev().map(|step| step.turn(module)) {
                back_rad -= turn.rotation_rad();
                pass(back_rad);
            }
            span_rad.map(|rad| start_rad + rad)
        };
        self.pairs.all().iter().all(|pair| {
            let (i, j) = (passed(pair.i), passed(pair.j));
            self.is_unknown(pair) || self.stops_clear(pair, [i[0], j[0]], [i[1], j[1]])
        })
    }
}

/// Equal to the bit: a tail that stays is given the same angle twice.
fn rests(from_rad: f64, to_rad: f64) -> bool {
    from_rad.to_bits() == to_rad.to_bits()
}
