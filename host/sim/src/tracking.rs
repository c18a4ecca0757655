//! Tracking error of a tail: the firmware's servo on simulated motors, by phase of the motion; and where a tail stops that loses its
//! power.
//!
//! The planner keeps tails apart for every pair of errors up to these ([`Tracking`]), so they are measured and not guessed: the
//! servo of the firmware crate, told the nominal constants, drives the motor of `plant` with every combination of the extremes of
//! its spread. Encoder resolution, the 1 ms tick, the torque limit and the water's drag on the tail are in it; the module's clock
//! is not, and is added by [`Tracking`]'s user.
//!
//! | phase | motions tried |
//! |---|---|
//! | swing | the least and the greatest amplitude, from rest and straight after a transition |
//! | transition | turns of 0.02 to 2π rad, each at the planner's law of time |
//! | rest | after each of them, from its end on |
//!
//! At every tick of a motion the power is taken away in thought ([`Stops`]).

use std::f64::consts::TAU;

use firmware::modboat::cycle::{Phase, SwimCycle};
use firmware::modboat::motor::Bridge;
use firmware::modboat::reference::wrap;
use firmware::modboat::servo::ServoError;
use firmware::modboat::tail::Tail;
use firmware::modboat::waveform::Waveform;
use modboat::parameters::Parameters;
use protocol::TransitionLaw;
use protocol::configuration::EncoderMounting;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;

use super::module::{ModuleError, TICK, servo_for};
#[cfg(test)]
use super::motor::SPREAD_MAX;
use super::motor::{MotorParameters, SimMotor};

/// Turns that are tried, rad.
const TURNS_RAD: [f64; 7] = [0.02, 0.1, 0.4, 1.0, 2.2, 4.0, TAU - 1e-3];
/// How long a tail is watched at rest after each motion, s.
const REST_S: f64 = 0.3;

/// Longest period that is tried, s.
const PERIOD_MAX_S: f64 = 5.0;

/// Tracking error in one phase of the motion, rad: its greatest value and its root mean square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// The greatest.
    pub greatest_rad: f64,
    square_rad2: f64,
    ticks: u32,
}

impl Off {
    /// Takes in one error, rad.
    pub fn add(&mut self, error_rad: f64) {
        self.greatest_rad = self.greatest_rad.max(error_rad.abs());
        self.square_rad2 += error_rad * error_rad;
        self.ticks += 1;
    }

    /// Takes in what another has seen.
    pub fn join(&mut self, other: &Self) {
        self.greatest_rad = self.greatest_rad.max(other.greatest_rad);
        self.square_rad2 += other.square_rad2;
        self.ticks += other.ticks;
    }

    /// Root mean square, rad; zero before the first.
    #[must_use]
    pub fn rms_rad(&self) -> f64 {
        (self.square_rad2 / f64::from(self.ticks.max(1))).sqrt()
    }
}

/// How far beyond the end of its motion a tail comes to rest that loses its power in it, rad: the greatest over all instants of the
/// motion, the servo's error included. Infinite where the tail coasts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stops {
    /// Beyond either end of a swing.
    pub past_swing_rad: f64,
    /// Beyond the end of a transition.
    pub past_turn_rad: f64,
}

impl Stops {
    /// In the turn by `turn_rad` to `to_rad`.
    fn turn(&mut self, to_rad: f64, turn_rad: f64, at_rad: f64) {
        if turn_rad != 0.0 {
            self.past_turn_rad = self.past_turn_rad.max((at_rad - to_rad) * turn_rad.signum());
        }
    }

    /// In the swing that starts at `start_rad`.
    fn swing(&mut self, start_rad: f64, amplitude_rad: f64, at_rad: f64) {
        if amplitude_rad != 0.0 {
            let off_rad = (at_rad - (start_rad - amplitude_rad)).abs();
            self.past_swing_rad = self.past_swing_rad.max(off_rad - amplitude_rad.abs());
        }
    }
}

/// What a servo leaves of an error, by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracking {
    /// At rest, from the end of a motion on.
    pub rest: Off,
    /// In a swing.
    pub swing: Off,
    /// In a transition.
    pub transition: Off,
    /// Where it stops that loses its power.
    pub stops: Stops,
}

impl Tracking {
    /// Measures it over all extremes of the motor's spread, for the cycles and transitions of `modboat`.
    ///
    /// # Errors
    /// [`ModuleError`] for a motor that cannot be.
    pub fn measure(motor: &MotorParameters, modboat: &Parameters) -> Result<Self, ModuleError> {
        let mut tracking = Self::default();
        let corners = if motor.spread > 0.0 { 16 } else { 1 };
        for corner in 0..corners {
            let shares = std::array::from_fn(|k| if corner >> k & 1 == 0 { -1.0 } else { 1.0 });
            tracking.follow(motor, &motor.differing(shares), modboat)?;
        }
        Ok(tracking)
    }

    /// What is known without measuring: motors like the default, within their greatest spread, with cycles that ask no more of
    /// them. The value stands in for a measurement that a test repeats.
    #[must_use]
    pub fn known(motor: &MotorParameters, modboat: &Parameters) -> Option<Self> {
        let usual = MotorParameters {
            spread: motor.spread,
            encoder_offset_rad: motor.encoder_offset_rad,
            ..MotorParameters::default()
        };
        let default = Parameters::default();
        let no_more = modboat.period_s >= default.period_s
            && modboat.amplitude_max_rad <= default.amplitude_max_rad
            && modboat.tail_speed_max_rad_s <= default.tail_speed_max_rad_s
            && modboat.tail_acceleration_max_rad_s2 <= default.tail_acceleration_max_rad_s2;
        let kept = Off { greatest_rad: default.tracking_error_rad, ..Off::default() };
        let stops =
            Stops { past_swing_rad: default.stop_past_swing_rad, past_turn_rad: default.stop_past_turn_rad };
        (usual == *motor && no_more).then_some(Self { rest: kept, swing: kept, transition: kept, stops })
    }

    /// The greatest error of all phases, rad, and in which it is.
    #[must_use]
    pub fn greatest(&self) -> (&'static str, f64) {
        [("at rest", self.rest), ("in a swing", self.swing), ("in a transition", self.transition)]
            .map(|(phase, off)| (phase, off.greatest_rad))
            .into_iter()
            .fold(("at rest", 0.0), |most, own| if own.1 > most.1 { own } else { most })
    }

    /// Follows one chain of motions with one motor.
    fn follow(
        &mut self,
        nominal: &MotorParameters,
        real: &MotorParameters,
        modboat: &Parameters,
    ) -> Result<(), ModuleError> {
        // Anywhere but at a whole reading.
        let mut from_rad = 0.3333;
        let (mut motor, pins) = SimMotor::new(real, from_rad)?;
        let bridge = Bridge::new(pins.pwm, pins.in1, pins.in2);
        let mounting = EncoderMounting { zero_counts: real.encoder_offset_counts(), reversed: false };
        let mut tail =
            Tail::new(pins.sensors.clone(), mounting, pins.sensors, bridge, &servo_for(nominal, modboat))
                .map_err(|error: ServoError| ModuleError::Servo(error))?;
        // A slower swing is the easier one to follow.
        let period = span(modboat.period_s.min(PERIOD_MAX_S));
        let (least_rad, greatest_rad) = (modboat.amplitude_min_rad, modboat.amplitude_max_rad);
        let swings = [greatest_rad, -greatest_rad, least_rad, 0.0];
        // A tick does not fall on the start of a motion: the fleet's time and the module's are not in step.
        let mut now = FleetInstant(137);
        for (k, &turn_rad) in TURNS_RAD.iter().chain(&[0.0]).enumerate() {
            let turn_rad = if k % 2 == 0 { turn_rad } else { -turn_rad };
            for amplitude_rad in swings {
                let (transition_s, ramp_s) = modboat.transition_times_s(turn_rad);
                let law = TransitionLaw::RestToRest { ramp: span(ramp_s) };
                let to_rad = from_rad + turn_rad;
                // The motor counts turns, a pose at the end of a cycle does not.
                let laps_rad = TAU * ((motor.angle_rad() - from_rad) / TAU).round();
                let waveform = Waveform::new(
                    Radians((to_rad - amplitude_rad) as f32),
                    Radians(amplitude_rad as f32),
                    period,
                );
                let rotation = Radians(turn_rad as f32);
                let cycle = SwimCycle::new(1, now, rotation, (span(transition_s), law), waveform);
                let end = cycle.end().after(span(REST_S));
                while now < end {
                    // The simulated pins cannot fail.
                    let _ = tail.tick(&cycle.reference(now));
                    motor.step(f64::from(TICK.as_secs_f32()));
                    now = now.after(TICK);
                    let error_rad = wrap(cycle.reference(now).angle_rad - wrap(motor.angle_rad() as f32));
                    let off = match cycle.phase(now) {
                        Phase::Waiting | Phase::Done => &mut self.rest,
                        Phase::Turning => &mut self.transition,
                        Phase::Swimming if amplitude_rad == 0.0 => &mut self.rest,
                        Phase::Swimming => &mut self.swing,
                    };
                    off.add(f64::from(error_rad));
                    let at_rad = motor.stops_at_rad().unwrap_or(f64::INFINITY) - laps_rad;
                    match cycle.phase(now) {
                        Phase::Turning => self.stops.turn(to_rad, turn_rad, at_rad),
                        Phase::Swimming => self.stops.swing(to_rad, amplitude_rad, at_rad),
                        Phase::Waiting | Phase::Done => {}
                    }
                }
                from_rad = f64::from(cycle.end_pose().0);
                now = now.after(Duration(211));
            }
        }
        Ok(())
    }
}

fn span(seconds: f64) -> Duration {
    Duration((seconds * 1e6).round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::ENCODER_COUNTS;
    use protocol::configuration::ServoConstants;

    /// The table of `host/docs/planner.md`, and what plans rely on: modules keep within [`Parameters::tracking_error_rad`] over the
    /// whole spread that a scenario may have.
    #[test]
    fn the_default_error_is_kept_over_the_whole_spread() {
        let modboat = Parameters::default();
        println!("spread   at rest: RMS, most   swing: RMS, most   transition: RMS, most, rad");
        for spread in [0.0, 0.1, SPREAD_MAX] {
            let motor = MotorParameters { spread, ..MotorParameters::default() };
            let tracking = Tracking::measure(&motor, &modboat).expect("a motor");
            let shown = [tracking.rest, tracking.swing, tracking.transition]
                .map(|off| format!("{:.4}, {:.4}", off.rms_rad(), off.greatest_rad));
            println!("  {spread:.1}    {}     {}     {}", shown[0], shown[1], shown[2]);
            println!("         without power past the end: {:?}", tracking.stops);
            let most_rad = tracking.greatest().1;
            assert!(most_rad <= modboat.tracking_error_rad, "spread {spread}: {tracking:?}");
            // With something in hand for what the model lacks, and not so much that the figure means nothing.
            if spread == SPREAD_MAX {
                assert!((0.5..0.8).contains(&(most_rad / modboat.tracking_error_rad)), "{most_rad} rad");
            }
            // What plans take to be swept by a tail that loses its power, at any instant of its motion.
            let Stops { past_swing_rad, past_turn_rad } = tracking.stops;
            let shares =
                [past_swing_rad / modboat.stop_past_swing_rad, past_turn_rad / modboat.stop_past_turn_rad];
            assert!(shares.iter().all(|share| *share <= 1.0), "spread {spread}: {:?}", tracking.stops);
            if spread == SPREAD_MAX {
                assert!(shares.iter().all(|share| *share > 0.9), "{shares:?}");
            }
            assert_eq!(
                Tracking::known(&motor, &modboat)
                    .map(|known| known.greatest().1 <= modboat.tracking_error_rad),
                Some(true)
            );
        }
    }

    /// Where the bound at which a module stops itself meets the tube that plans keep free: with one reading of the encoder it is inside, and what a servo
    /// keeps with every motor of the spread is inside of that. So is the bound of a module whose file says nothing else.
    #[test]
    fn the_bound_of_the_module_is_inside_the_tube_of_the_planner() {
        let modboat = Parameters::default();
        let motor = MotorParameters { spread: SPREAD_MAX, ..MotorParameters::default() };
        let most_rad = Tracking::measure(&motor, &modboat).expect("a motor").greatest().1;
        let reading_rad = TAU / f64::from(ENCODER_COUNTS);
        for servo in [servo_for(&motor, &modboat), ServoConstants::default()] {
            let bound_rad = f64::from(servo.following_error_max.0);
            println!(
                "a servo keeps {most_rad:.4} rad, a module stops at {bound_rad:.4}, plans keep {:.4} free",
                modboat.tracking_error_rad
            );
            assert!(bound_rad + reading_rad <= modboat.tracking_error_rad + 1e-6, "{bound_rad} rad");
            assert!(most_rad + reading_rad <= bound_rad, "{most_rad} of {bound_rad} rad");
        }
    }

    /// Every motor within the spread is as good as those at its extremes.
    #[test]
    fn the_extremes_are_the_worst_motors() {
        let modboat = Parameters::default();
        let nominal = MotorParameters { spread: SPREAD_MAX, ..MotorParameters::default() };
        for seed in 0..20 {
            let mut tracking = Tracking::default();
            tracking.follow(&nominal, &nominal.drawn(seed), &modboat).expect("a motor");
            assert!(tracking.greatest().1 <= modboat.tracking_error_rad, "seed {seed}: {tracking:?}");
            let Stops { past_swing_rad, past_turn_rad } = tracking.stops;
            assert!(past_swing_rad <= modboat.stop_past_swing_rad, "seed {seed}: {tracking:?}");
            assert!(past_turn_rad <= modboat.stop_past_turn_rad, "seed {seed}: {tracking:?}");
        }
    }

    /// Against hand-worked numbers: a shorted winding takes ω·τ, less what the water takes; an open one never stops.
    #[test]
    fn a_tail_without_power_goes_on_for_its_speed_times_the_time_constant() {
        let no_drag = MotorParameters { tail_drag_n_m_s2: 0.0, ..MotorParameters::default() };
        let (mut motor, pins) = SimMotor::new(&no_drag, 0.0).expect("a motor");
        let mut bridge = Bridge::new(pins.pwm, pins.in1, pins.in2);
        bridge.drive(0.5).expect("infallible");
        (0..1000).for_each(|_| motor.step(1e-3));
        let past_rad = motor.stops_at_rad().expect("braked") - motor.angle_rad();
        assert!((past_rad - motor.rate_rad_s() * 0.02).abs() < 1e-3, "{past_rad} rad");
        let coasting = MotorParameters { reset_brakes: false, ..no_drag };
        assert_eq!(SimMotor::new(&coasting, 0.0).expect("a motor").0.stops_at_rad(), None);
        let stops = Tracking::measure(&coasting, &Parameters::default()).expect("a motor").stops;
        assert!(stops.past_turn_rad.is_infinite() && stops.past_swing_rad.is_infinite());
    }

    #[test]
    fn a_weak_motor_strays_and_is_measured() {
        let modboat = Parameters::default();
        let weak = MotorParameters { acceleration_max_rad_s2: 60.0, ..MotorParameters::default() };
        assert_eq!(Tracking::known(&weak, &modboat), None);
        let (phase, most_rad) = Tracking::measure(&weak, &modboat).expect("a motor").greatest();
        assert!(most_rad > 5.0 * modboat.tracking_error_rad, "{most_rad} rad {phase}");
    }
}
