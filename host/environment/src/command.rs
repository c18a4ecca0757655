//! What all modules do in one step: a turn of every tail by one law of time, then one period.
//!
//! A step takes its turns' time, t_trans of the longest, and the period; no time where no tail turns. That is how a plan's own
//! transition is timed, so that a policy that lets tails start where they rest gains what a planner gains.

use std::f64::consts::TAU;

use modboat::motion::{self, Swing, Turn, Wrench};
use modboat::parameters::Parameters;
use modboat::plan::{Outcome, Plan};
use modboat::transition::STILL_RAD;
use protocol::time::Duration;
use protocol::units::Radians;
use protocol::{ModboatCycle, Motion, TransitionLaw};
use quantity::wrap_rad;

use crate::layout::PER_MODULE;

/// From this share of its bound on, the third number of a module's action is a way.
const WAY: f64 = 0.5;

/// See the module's documentation.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// Each module's swing; an amplitude of zero rests at the centreline.
    pub cycle: Vec<Swing>,
    /// Each module's turn before it.
    pub turns: Vec<Turn>,
    /// How long the turns take.
    pub transition: Duration,
    /// The fleet's law of time.
    pub law: TransitionLaw,
    /// How long the swing takes.
    pub period: Duration,
}

impl Default for Command {
    fn default() -> Self {
        Self {
            cycle: Vec::new(),
            turns: Vec::new(),
            transition: Duration(0),
            law: TransitionLaw::ConstantSpeed,
            period: Duration(0),
        }
    }
}

impl Command {
    /// Every tail rests where it is, for a period.
    pub fn rest(&mut self, tails_rad: &[f64], parameters: &Parameters) {
        self.begin(parameters);
        for &tail_rad in tails_rad {
            self.cycle.push(Swing { centerline_rad: tail_rad, amplitude_rad: 0.0 });
            self.turns.push(Turn { from_rad: tail_rad, to_rad: tail_rad });
        }
    }

    /// What an action of kind `swing` says, from where the tails rest, rad.
    pub fn take_swings(&mut self, action: &[f64], tails_rad: &[f64], parameters: &Parameters) {
        self.begin(parameters);
        let (least, most) = (parameters.amplitude_min_rad, parameters.amplitude_max_rad);
        for (numbers, &tail_rad) in action.chunks_exact(PER_MODULE).zip(tails_rad) {
            let &[centerline_rad, amplitude_rad, way] = numbers else { continue };
            let amplitude_rad = match amplitude_rad.abs() {
                none if none < 0.5 * least => 0.0,
                size => size.clamp(least, most).copysign(amplitude_rad),
            };
            let swing = Swing { centerline_rad: wrap_rad(centerline_rad), amplitude_rad };
            let mut rotation_rad = wrap_rad(swing.start_rad() - tail_rad);
            if rotation_rad.abs() < STILL_RAD {
                rotation_rad = 0.0;
            } else if way > WAY && rotation_rad < 0.0 {
                rotation_rad += TAU;
            } else if way < -WAY && rotation_rad > 0.0 {
                rotation_rad -= TAU;
            }
            self.cycle.push(swing);
            self.turns.push(Turn { from_rad: tail_rad, to_rad: tail_rad + rotation_rad });
        }
        let longest_rad = self.turns.iter().map(|turn| turn.rotation_rad().abs()).fold(0.0, f64::max);
        if longest_rad > 0.0 {
            self.time(parameters.transition_times_s(longest_rad));
        }
    }

    /// The cycle of a plan made for these tails. Of a transition in two steps it is the first alone, and a rest after it.
    pub fn take_plan(&mut self, plan: &Plan, tails_rad: &[f64], parameters: &Parameters) {
        let step = plan.step_times[0];
        match (&plan.via_rad, &plan.transition) {
            _ if plan.outcome == Outcome::Held || plan.cycle.len() != tails_rad.len() => {
                self.rest(tails_rad, parameters);
            }
            (Some(via_rad), Some(_)) => {
                self.rest(tails_rad, parameters);
                for ((swing, turn), &to_rad) in self.cycle.iter_mut().zip(&mut self.turns).zip(via_rad) {
                    (swing.centerline_rad, turn.to_rad) = (to_rad, to_rad);
                }
                self.time((step.duration_s, step.ramp_s));
            }
            (_, transition) => {
                self.rest(tails_rad, parameters);
                self.cycle.clone_from(&plan.cycle);
                if let Some(turns) = transition {
                    self.turns.clone_from(turns);
                    self.time((step.duration_s, step.ramp_s));
                }
            }
        }
    }

    /// The action of kind `swing` that says the same.
    pub fn write_swings(&self, action: &mut [f64]) {
        for ((numbers, swing), turn) in action.chunks_exact_mut(PER_MODULE).zip(&self.cycle).zip(&self.turns)
        {
            let rotation_rad = turn.rotation_rad();
            let way = if rotation_rad.abs() < STILL_RAD { 0.0 } else { rotation_rad.signum() };
            numbers.copy_from_slice(&[wrap_rad(swing.centerline_rad), swing.amplitude_rad, way]);
        }
    }

    /// What goes over the wire to module `index`.
    #[must_use]
    pub fn motion(&self, index: usize) -> Option<Motion> {
        let (swing, turn) = (self.cycle.get(index)?, self.turns.get(index)?);
        Some(Motion::Modboat(ModboatCycle {
            rotation: Radians(turn.rotation_rad() as f32),
            centerline: Radians(swing.centerline_rad as f32),
            amplitude: Radians(swing.amplitude_rad as f32),
            transition: self.transition,
            period: self.period,
            law: self.law,
        }))
    }

    /// The mean wrench of the swings by (7), for modules at `positions_m` in S.
    #[must_use]
    pub fn wrench(&self, parameters: &Parameters, positions_m: &[[f64; 2]]) -> Wrench {
        motion::wrench(&self.cycle, parameters, positions_m)
    }

    /// All of it.
    #[must_use]
    pub fn length(&self) -> Duration {
        Duration(self.transition.0 + self.period.0)
    }

    fn begin(&mut self, parameters: &Parameters) {
        self.cycle.clear();
        self.turns.clear();
        (self.transition, self.law) = (Duration(0), TransitionLaw::ConstantSpeed);
        self.period = span(parameters.period_s);
    }

    /// The turns take this long, with ramps of this length; a ramp of zero is constant speed.
    fn time(&mut self, (duration_s, ramp_s): (f64, f64)) {
        self.transition = span(duration_s);
        self.law = match span(ramp_s) {
            Duration(0) => TransitionLaw::ConstantSpeed,
            // Both are rounded to the microsecond: the ramp must not exceed half of the step.
            ramp => TransitionLaw::RestToRest { ramp: Duration(ramp.0.min(self.transition.0 / 2)) },
        };
    }
}

/// To the microsecond.
pub(crate) fn span(seconds: f64) -> Duration {
    Duration((seconds * 1e6).round() as u32)
}

/// In seconds, for sums.
pub(crate) fn seconds(span: Duration) -> f64 {
    f64::from(span.0) * 1e-6
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn taken(action: &[f64], tails_rad: &[f64]) -> Command {
        let mut command = Command::default();
        command.take_swings(action, tails_rad, &Parameters::default());
        command
    }

    #[test]
    fn an_action_says_swing_and_way() {
        // From 0 to φ₀ + A = 1.5 + 1.0 = 2.5 rad: the shorter way, and both ways.
        for (way, rotation_rad) in [(0.0, 2.5), (1.0, 2.5), (-1.0, 2.5 - TAU), (0.4, 2.5), (-0.4, 2.5)] {
            let command = taken(&[1.5, 1.0, way], &[0.0]);
            assert_eq!(command.cycle, [Swing { centerline_rad: 1.5, amplitude_rad: 1.0 }]);
            assert!((command.turns[0].rotation_rad() - rotation_rad).abs() < 1e-12, "{way}");
            // Δφ/v + v/α with v = 10.4 rad/s and α = 200 rad/s².
            let expected_s = rotation_rad.abs() / 10.4 + 10.4 / 200.0;
            assert_eq!(command.transition, span(expected_s));
        }
    }

    #[test]
    fn tails_that_start_where_they_rest_take_no_time_to_turn() {
        let command = taken(&[-0.3, 1.1, 1.0, FRAC_PI_2, 0.0, -1.0], &[0.8, FRAC_PI_2]);
        assert_eq!((command.transition, command.length()), (Duration(0), Duration(1_500_000)));
        assert!(command.turns.iter().all(|turn| turn.rotation_rad() == 0.0));
        assert_eq!(command.cycle[1], Swing { centerline_rad: FRAC_PI_2, amplitude_rad: 0.0 });
    }

    #[test]
    fn amplitudes_are_brought_into_what_a_module_takes() {
        for (asked, given) in [(0.44, 0.0), (0.46, 0.9), (-0.5, -0.9), (9.0, 2.6), (-9.0, -2.6), (1.7, 1.7)] {
            let swing = taken(&[0.0, asked, 0.0], &[0.0]).cycle[0];
            assert_eq!(swing, Swing { centerline_rad: 0.0, amplitude_rad: given }, "{asked}");
        }
    }

    #[test]
    fn what_is_written_is_taken_as_the_same() {
        let tails_rad = [0.4, -2.9, PI];
        let command = taken(&[0.3, 1.2, -1.0, -3.0, -2.1, 1.0, 0.6, 0.0, 0.0], &tails_rad);
        let mut action = [f64::NAN; 9];
        command.write_swings(&mut action);
        let again = taken(&action, &tails_rad);
        assert_eq!(again, command);
    }
}
