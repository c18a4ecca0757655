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
//! Of the decision before, the whole counts, its transition, both steps of it, as well as its swing ([`Previous`]): a module that lost
//! its power in the turn stands somewhere on the turn.
//!
//! Assumptions and limits: sufficient, not necessary (the region in which two tails collide is smaller than the square about it).
//! At constant speed, of which nothing is known, a tail that turns may stop anywhere.

use std::f64::consts::TAU;

use super::{Case, Setting, swim_ends, turn_ends};
use crate::motion::Swing;
use crate::pairs::Pair;
use crate::plan::Previous;
use crate::planner_config::{LawOfTime, LossTolerance};
use crate::transition::STILL_RAD;
use crate::tube::Tube;
use crate::way::Steps;

/// The least and the greatest angle that a tail passes or comes to rest at, rad, unwrapped; equal to the bit where it stays.
pub type Span = [f64; 2];

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

    /// Where a tail can be in all of a plan, and where it can stop, unwrapped: the swim goes on from where the transition ends.
    fn passed(&self, steps: Steps<'_>, cycle: &[Swing], module: usize) -> Span {
        let [mut least_rad, mut most_rad] = self.swung(cycle[module]);
        let mut end_rad = cycle[module].start_rad();
        for turn in steps.iter().rev().map(|step| step.turn(module)) {
            let from_rad = end_rad - turn.rotation_rad();
            let [low_rad, high_rad] = self.turned(from_rad, end_rad);
            (least_rad, most_rad) = (least_rad.min(low_rad), most_rad.max(high_rad));
            end_rad = from_rad;
        }
        [least_rad, most_rad]
    }

    /// Writes where each module can have stopped in the decision before. False, and nothing written, where none can have: there was
    /// none, or it is over.
    pub(crate) fn stopped(&self, previous: Option<Previous<'_>>, spans: &mut Vec<Span>) -> bool {
        spans.clear();
        let Some(previous) = previous.filter(|previous| !previous.is_over) else { return false };
        spans.extend(
            (0..self.cells.len()).map(|module| self.passed(previous.steps(), previous.cycle, module)),
        );
        true
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

    /// Whether of a pair that passes `spans` one may stop anywhere while the other goes on: in this motion, or in the decision before
    /// while the other one is in this motion already.
    fn stops_clear(&self, pair: &Pair, spans: [Span; 2]) -> bool {
        self.one_keeps_out(pair, spans)
            && self.before.is_none_or(|before| {
                self.one_keeps_out(pair, [spans[0], before[pair.j]])
                    && self.one_keeps_out(pair, [before[pair.i], spans[1]])
            })
    }

    /// Whether in all of a plan any module may stop anywhere: one that stops in the transition stands there in the swim.
    pub(super) fn all_stop_clear(&self, steps: Steps<'_>, cycle: &[Swing]) -> bool {
        self.pairs.all().iter().all(|pair| {
            let spans = [pair.i, pair.j].map(|module| self.passed(steps, cycle, module));
            if self.is_unknown(pair) {
                let [least_rad, most_rad] = [0, 1].map(|bound: usize| spans.map(|span| span[bound]));
                return self.keeps_out(pair, least_rad, most_rad);
            }
            self.stops_clear(pair, spans)
        })
    }
}

/// Equal to the bit: a tail that stays is given the same angle twice.
fn rests(from_rad: f64, to_rad: f64) -> bool {
    from_rad.to_bits() == to_rad.to_bits()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_4, PI};
    use std::sync::Arc;

    use super::*;
    use crate::distance::DistanceToCollision;
    use crate::motion::Turn;
    use crate::parameters::Parameters;
    use crate::planner_config::PlannerConfig;
    use crate::setting::Approach;
    use crate::structure::Structure;

    /// Two side by side, the left one with this way to its swing; whether either may stop anywhere.
    fn stops_clear(parameters: &Parameters, from_rad: f64, cycle: [Swing; 2]) -> bool {
        let structure = Structure::from_word("2x1").expect("two modules");
        let distance = Arc::new(DistanceToCollision::new(parameters));
        let setting = Setting::new(&structure, parameters, &PlannerConfig::default(), distance);
        let stay = |rad: f64| Turn { from_rad: rad, to_rad: rad };
        let turns = vec![Turn { from_rad, to_rad: cycle[0].start_rad() }, stay(cycle[1].start_rad())];
        let approach = setting.one_step(turns);
        let steps = if approach.is_still() { Steps::default() } else { Approach::steps(&approach) };
        setting.as_configured().all_stop_clear(steps, &cycle)
    }

    fn swing(start_rad: f64, amplitude_rad: f64) -> Swing {
        Swing { centerline_rad: start_rad - amplitude_rad, amplitude_rad }
    }

    /// Seen in a storm: a tail turned from −1.255 to −0.782 in a tenth of a second, lost its power on the way and came to rest at −0.738, within
    /// its neighbour's reach. Its swing is on the other side, so that nothing of it but what is beyond the end of the turn counts.
    #[test]
    fn a_tail_that_stops_beyond_the_end_of_a_turn_is_in_its_neighbours_way() {
        let parameters = Parameters::default();
        let kept = parameters.tracking_error_rad;
        let stops_short =
            Parameters { stop_past_turn_rad: kept, stop_past_swing_rad: kept, ..parameters.clone() };
        let (end_rad, turns_from_rad) = (-0.782, -1.255);
        let own = swing(end_rad, 0.9);
        let free_rad = PI - FRAC_PI_4;
        // The neighbour swings through all of what the left one can reach; or away from it; or it rests, out of reach or within it.
        let through = swing(free_rad, -0.9);
        assert!(stops_clear(&stops_short, turns_from_rad, [own, through]));
        assert!(!stops_clear(&parameters, turns_from_rad, [own, through]));
        assert!(stops_clear(&parameters, turns_from_rad, [own, swing(free_rad, 0.9)]));
        assert!(stops_clear(&parameters, turns_from_rad, [own, swing(free_rad, 0.0)]));
        // From a diagonal a swing alone goes no further than it may, and the turn away from the neighbour neither.
        let from_diagonal = swing(-FRAC_PI_4, 0.9);
        assert!(stops_clear(&parameters, -FRAC_PI_4, [from_diagonal, through]));
        assert!(stops_clear(&parameters, -FRAC_PI_4, [swing(turns_from_rad, 0.9), through]));
        // A tail that may stop anywhere keeps clear of nothing that moves.
        let coasts = Parameters { stop_past_turn_rad: 7.0, stop_past_swing_rad: 7.0, ..parameters };
        assert!(!stops_clear(&coasts, -FRAC_PI_4, [from_diagonal, through]));
        assert!(stops_clear(&coasts, -FRAC_PI_4, [from_diagonal, swing(free_rad, 0.0)]));
    }

    /// Against the geometry of a resting tail within reach: what the other one passes must be clear, what it coasts to as well.
    #[test]
    fn a_tail_that_rests_in_reach_is_passed_clear_or_not() {
        let parameters = Parameters::default();
        let kept = parameters.tracking_error_rad;
        let stops_short =
            Parameters { stop_past_turn_rad: kept, stop_past_swing_rad: kept, ..parameters.clone() };
        let distance = DistanceToCollision::new(&parameters);
        let still_rad = PI - 0.5;
        // Where the left tail first comes near the resting one, from below, less a little.
        let touches = |rad: f64| {
            distance.offsets().iter().position(|offset| *offset == [1, 0]).is_none_or(|offset| {
                !distance.tube_clear(Tube::One, offset, [-1.2, still_rad], [rad, still_rad])
            })
        };
        let at_rad =
            (0..3000).map(|k| -1.2 + f64::from(k) * 1e-3).find(|&rad| touches(rad)).expect("they touch");
        let cycle = [swing(at_rad - 0.02, 0.0), swing(still_rad, 0.0)];
        assert!(stops_clear(&stops_short, -1.2, cycle), "{at_rad}");
        assert!(!stops_clear(&parameters, -1.2, cycle), "{at_rad}");
    }
}
