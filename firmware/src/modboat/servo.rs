//! The tail servo: from where the tail should be and where it is to a drive of the motor, at a fixed rate.
//!
//! The motor, as modelled:  φ̈ = (ω₀·d + w − φ̇)/τ_m,   I = I_stall·(d − φ̇/ω₀)
//!
//! The law inverts it, adds feedback on angle and rate, and takes away the disturbance w that its
//! [observer](crate::modboat::disturbance) finds:
//!
//! ω₀·d = clamp(φ̇_ref + k_p·e, ±ω_max) + (τ_m + Δt/2)·φ̈_ref + k_d·(φ̇_ref − φ̇) − w,   e = wrap(φ_ref − φ)
//!
//! |ω₀·d − φ̇| ≤ ω₀·f·I_max/I_stall   (the current limit),   |d| ≤ 1
//!
//! | symbol | meaning | default | unit |
//! |---|---|---|---|
//! | d | drive, share of the supply, counter-clockwise positive | | 1 |
//! | ω₀ | no-load speed | 18, *assumed* | rad/s |
//! | τ_m | mechanical time constant | 0.02, *assumed* | s |
//! | Δt | interval of the loop; a drive acts half of it later on the mean | 0.001 | s |
//! | k_p | position gain | 60, *assumed* | 1/s |
//! | k_d | rate gain | 1.2, *assumed* | 1 |
//! | ω_max | speed the position error may ask for | 15, *assumed* | rad/s |
//! | I_stall, I_max | stall current and current limit | 1.8, 1.2, *assumed* | A |
//! | f | fold-back from measured current, 0.1..1; 1 without a sensor | | 1 |
//!
//! The error obeys τ_m·ë + (1 + k_d)·ė + k_p·e = 0: with the defaults 55 rad/s, damping 1.0.
//!
//! Assumptions and limits: the model's current limit needs no sensor, but trusts ω₀ and the measured rate, which lags 4 ms. Water drag, a sagging
//! battery and a motor off its nominal constants are disturbances; cogging and stall heating are not modelled. A reference whose
//! rate steps by Δφ̇, as at both ends of a transition at constant speed, is left by about Δφ̇²/(2·600 rad/s²), as the current limit
//! allows 600 rad/s²; one that starts and ends at rest is not. What is left of the error is measured over the whole spread of
//! motors in the host's `sim::tracking`. The error is taken the shorter way round: a tail held back by more than half a turn comes
//! back the other way, and reports `lagging` long before.

use core::fmt;

use protocol::configuration::ServoConstants;
use protocol::units::{Amperes, Radians, RadiansPerSecond};

use crate::modboat::disturbance::DisturbanceObserver;
use crate::modboat::reference::{Reference, limit, wrap};

/// A sensor of the motor current, if the board has one.
pub trait CurrentSense {
    /// What can go wrong in reading it.
    type Error;

    /// The motor current; its sign does not matter. `None`: no sensor.
    ///
    /// # Errors
    /// Whatever the converter reports. The servo then relies on the model.
    fn current(&mut self) -> Result<Option<Amperes>, Self::Error>;
}

/// A board without a current sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoSense;

impl CurrentSense for NoSense {
    type Error = core::convert::Infallible;

    fn current(&mut self) -> Result<Option<Amperes>, Self::Error> {
        Ok(None)
    }
}

/// A servo parameter that no motor can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoError {
    /// The field's name.
    pub key: &'static str,
    /// What it was set to, in `unit`.
    pub value: f32,
    /// The unit of `value`.
    pub unit: &'static str,
}

impl fmt::Display for ServoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, value, unit } = self;
        write!(f, "{key} = {value} {unit}: must be a finite number greater than zero")
    }
}

impl core::error::Error for ServoError {}

/// What one tick decided.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Drive in −1..1, counter-clockwise positive.
    pub drive: f32,
    /// Position error e in (−π, π], rad.
    pub error_rad: f32,
    /// True if the current limit, or the supply, cut the drive.
    pub limited: bool,
    /// True if the error exceeds the following error of the parameters.
    pub lagging: bool,
}

/// Least fold-back: enough current remains to feel the motor move again.
const FOLD_MIN: f32 = 0.1;

/// Time in which a full fold-back recovers, s.
const FOLD_RECOVERY_S: f32 = 0.5;

/// The servo: immutable coefficients, the disturbance observer with the drive it is told next, and the fold-back.
#[derive(Clone, Debug)]
pub struct TailServo {
    no_load_rad_s: f32,
    per_no_load_s_rad: f32,
    /// τ_m + Δt/2, s.
    lead_s: f32,
    position_gain_per_s: f32,
    rate_gain: f32,
    speed_max_rad_s: f32,
    /// ω₀·I_max/I_stall, rad/s.
    window_rad_s: f32,
    current_max_a: f32,
    following_error_max_rad: f32,
    fold_step: f32,
    fold: f32,
    observer: DisturbanceObserver,
    drive: f32,
}

impl TailServo {
    /// Works out the coefficients.
    ///
    /// # Errors
    /// [`ServoError`] for the first parameter that is not a finite number greater than zero.
    pub fn new(parameters: &ServoConstants) -> Result<Self, ServoError> {
        let p = parameters;
        for (key, value, unit) in [
            ("no_load_speed", p.no_load_speed.0, "rad/s"),
            ("time_constant_s", p.time_constant_s, "s"),
            ("position_gain_per_s", p.position_gain_per_s, "1/s"),
            ("rate_gain", p.rate_gain, "1"),
            ("speed_max", p.speed_max.0, "rad/s"),
            ("stall_current", p.stall_current.0, "A"),
            ("current_max", p.current_max.0, "A"),
            ("following_error_max", p.following_error_max.0, "rad"),
            ("interval", p.interval.as_secs_f32(), "s"),
        ] {
            if !value.is_finite() || value <= 0.0 {
                return Err(ServoError { key, value, unit });
            }
        }
        Ok(Self {
            no_load_rad_s: p.no_load_speed.0,
            per_no_load_s_rad: 1.0 / p.no_load_speed.0,
            lead_s: p.time_constant_s + 0.5 * p.interval.as_secs_f32(),
            position_gain_per_s: p.position_gain_per_s,
            rate_gain: p.rate_gain,
            speed_max_rad_s: p.speed_max.0,
            window_rad_s: p.no_load_speed.0 * (p.current_max.0 / p.stall_current.0),
            current_max_a: p.current_max.0,
            following_error_max_rad: p.following_error_max.0,
            fold_step: p.interval.as_secs_f32() / FOLD_RECOVERY_S,
            fold: 1.0,
            observer: DisturbanceObserver::new(p.no_load_speed, p.time_constant_s, p.interval),
            drive: 0.0,
        })
    }

    /// One tick: where the tail should be, where it is (any number of turns), how fast it turns, and the measured
    /// current if there is one. Input that is not finite gives a drive of zero.
    pub fn tick(
        &mut self,
        reference: &Reference,
        pose: Radians,
        rate: RadiansPerSecond,
        current: Option<Amperes>,
    ) -> Command {
        let known = self.observer.update(pose, rate, self.drive);
        self.drive = 0.0;
        // e = wrap(φ_ref − φ)
        let error_rad = wrap(reference.angle_rad - pose.0);
        // ω₀·d = clamp(φ̇_ref + k_p·e, ±ω_max) + (τ_m + Δt/2)·φ̈_ref + k_d·(φ̇_ref − φ̇) − w
        let speed_rad_s = reference.rate_rad_s + self.position_gain_per_s * error_rad;
        let wanted_rad_s = limit(speed_rad_s, -self.speed_max_rad_s, self.speed_max_rad_s)
            + self.lead_s * reference.acceleration_rad_s2
            + self.rate_gain * (reference.rate_rad_s - known.rate_rad_s)
            - known.disturbance_rad_s;
        // The clamps would turn NaN into full drive, and huge numbers become NaN on the way.
        let sound =
            reference.is_finite() && rate.is_finite() && error_rad.is_finite() && wanted_rad_s.is_finite();
        if !sound {
            return Command { limited: true, lagging: true, ..Command::default() };
        }
        // |ω₀·d − φ̇| ≤ ω₀·f·I_max/I_stall, |d| ≤ 1
        let window_rad_s = self.window_rad_s * self.fold_back(current);
        let allowed_rad_s = limit(
            limit(wanted_rad_s, rate.0 - window_rad_s, rate.0 + window_rad_s),
            -self.no_load_rad_s,
            self.no_load_rad_s,
        );
        let drive = limit(allowed_rad_s * self.per_no_load_s_rad, -1.0, 1.0);
        self.drive = drive;
        Command {
            drive,
            error_rad,
            limited: libm::fabsf(allowed_rad_s - wanted_rad_s) > 0.0,
            lagging: libm::fabsf(error_rad) > self.following_error_max_rad,
        }
    }

    /// The tail is not driven until the next tick: what was observed is forgotten.
    pub const fn forget(&mut self) {
        self.observer.forget();
        self.drive = 0.0;
    }

    /// f: cut in proportion when the measured current exceeds I_max, and given back over half a second.
    fn fold_back(&mut self, current: Option<Amperes>) -> f32 {
        let magnitude_a = current.map_or(0.0, |current| libm::fabsf(current.0));
        self.fold = if magnitude_a <= self.current_max_a {
            limit(self.fold + self.fold_step, 0.0, 1.0)
        } else {
            // A sensor that says NaN gives the least.
            let cut = self.fold * (self.current_max_a / magnitude_a);
            if cut > FOLD_MIN { cut } else { FOLD_MIN }
        };
        self.fold
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use protocol::time::Duration;

    fn servo() -> TailServo {
        TailServo::new(&ServoConstants::default()).unwrap()
    }

    fn reference(angle_rad: f32, rate_rad_s: f32, acceleration_rad_s2: f32) -> Reference {
        Reference { angle_rad, rate_rad_s, acceleration_rad_s2 }
    }

    #[test]
    fn the_law_is_hand_worked() {
        let command = servo().tick(&reference(1.02, 4.0, -30.0), Radians(1.0), RadiansPerSecond(3.5), None);
        // 4 + 60·0.02 + 0.0205·(−30) + 1.2·(4 − 3.5) = 5.185
        assert!((command.drive - 5.185 / 18.0).abs() < 1e-5, "{command:?}");
        assert!((command.error_rad - 0.02).abs() < 1e-6 && !command.limited && !command.lagging);
    }

    #[test]
    fn the_error_is_taken_the_shorter_way_round() {
        let command = servo().tick(&Reference::at_rest(-3.1), Radians(3.1), RadiansPerSecond(0.0), None);
        assert!((f64::from(command.error_rad) - (core::f64::consts::TAU - 6.2)).abs() < 1e-6, "{command:?}");
        assert!(command.drive > 0.0);
    }

    #[test]
    fn speed_and_current_are_limited() {
        // Far off and at rest: 15 rad/s asked for, the current limit allows 18·1.2/1.8 = 12.
        let command = servo().tick(&Reference::at_rest(2.0), Radians(0.0), RadiansPerSecond(0.0), None);
        assert!((command.drive - 12.0 / 18.0).abs() < 1e-6 && command.limited && command.lagging);
        // Far off at 6 rad/s: 15 − 1.2·6 = 7.8.
        let command = servo().tick(&Reference::at_rest(2.0), Radians(0.0), RadiansPerSecond(6.0), None);
        assert!((command.drive - 7.8 / 18.0).abs() < 1e-6 && !command.limited);
    }

    #[test]
    fn measured_current_folds_the_limit_back_and_gives_it_back() {
        let mut servo = servo();
        let mut drive = |current: f32| {
            servo
                .tick(&Reference::at_rest(2.0), Radians(0.0), RadiansPerSecond(0.0), Some(Amperes(current)))
                .drive
        };
        assert!((drive(-1.2) - 12.0 / 18.0).abs() < 1e-6);
        assert!((drive(-2.4) - 6.0 / 18.0).abs() < 1e-6, "twice the limit: half of it");
        assert!((drive(1.0) - 12.0 / 18.0 * 0.502).abs() < 1e-5, "2 ms of 1 s later");
        for _ in 0..250 {
            drive(1.0);
        }
        assert!((drive(1.0) - 12.0 / 18.0).abs() < 1e-6);
        for bad in [f32::NAN, f32::INFINITY] {
            assert!((drive(bad) - 1.2 / 18.0).abs() < 1e-6);
        }
    }

    #[test]
    fn no_drive_from_nonsense() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            for (at, pose, rate) in [
                (reference(bad, 0.0, 0.0), 0.0, 0.0),
                (reference(1.0, -bad, bad), 0.0, -bad),
                (reference(1.0, 0.0, bad), 0.0, bad),
                (reference(-bad, 0.0, 0.0), bad, 0.0),
                (reference(1.0, 0.0, 0.0), bad, 0.0),
            ] {
                let command = servo().tick(&at, Radians(pose), RadiansPerSecond(rate), None);
                assert!(command.drive.abs() <= 1.0);
                if !bad.is_finite() {
                    assert!(command.drive == 0.0 && command.lagging, "{at:?} {pose} {rate}");
                }
            }
        }
    }

    #[test]
    fn refuses_parameters_no_motor_has() {
        let usual = ServoConstants::default();
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let error = TailServo::new(&ServoConstants { time_constant_s: bad, ..usual }).unwrap_err();
            assert_eq!((error.key, error.unit), ("time_constant_s", "s"));
            let error = TailServo::new(&ServoConstants { current_max: Amperes(bad), ..usual }).unwrap_err();
            assert_eq!((error.key, error.unit), ("current_max", "A"));
        }
        let error = TailServo::new(&ServoConstants { interval: Duration(0), ..usual }).unwrap_err();
        assert_eq!(std::format!("{error}"), "interval = 0 s: must be a finite number greater than zero");
    }

    proptest! {
        /// Below the no-load speed the model's current never exceeds the limit, whatever is asked.
        #[test]
        fn modelled_current_is_within_its_limit(
            angle in -10.0_f32..10.0, rate_ref in -50.0_f32..50.0, acceleration in -5e3_f32..5e3,
            pose in -10.0_f32..10.0, rate in -18.0_f32..18.0,
        ) {
            let at = reference(angle, rate_ref, acceleration);
            let drive = servo().tick(&at, Radians(pose), RadiansPerSecond(rate), None).drive;
            prop_assert!(drive.abs() <= 1.0);
            // I = I_stall·(d − φ̇/ω₀)
            let current_a = 1.8 * (drive - rate / 18.0);
            prop_assert!(current_a.abs() <= 1.2 + 1e-5, "{current_a} A");
        }

        #[test]
        fn takes_any_numbers(bits in any::<[u32; 6]>(), parameters in any::<[u32; 8]>()) {
            let [a, b, c, d, e, f] = bits.map(f32::from_bits);
            let at = reference(a, b, c);
            let command = servo().tick(&at, Radians(d), RadiansPerSecond(e), Some(Amperes(f)));
            prop_assert!(command.drive.abs() <= 1.0);
            let [a, b, c, d, e, f, g, h] = parameters.map(f32::from_bits);
            let odd = ServoConstants {
                no_load_speed: RadiansPerSecond(a),
                time_constant_s: b,
                position_gain_per_s: c,
                rate_gain: d,
                speed_max: RadiansPerSecond(e),
                stall_current: Amperes(f),
                current_max: Amperes(g),
                following_error_max: Radians(h),
                following_error_time: Duration(50_000),
                interval: Duration(1000),
            };
            if let Ok(mut servo) = TailServo::new(&odd) {
                let command = servo.tick(&at, Radians(0.0), RadiansPerSecond(0.0), None);
                prop_assert!(command.drive.abs() <= 1.0);
            }
        }
    }
}
