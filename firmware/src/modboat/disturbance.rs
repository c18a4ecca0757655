//! The servo's disturbance observer: angle, speed and load of the tail, from the encoder and the drive that was put out.
//!
//! ```text
//! φ̇ = ω,   ω̇ = (ω₀·d + w − ω)/τ_m,   ẇ = 0          the motor as modelled, w: whatever the model lacks, as a speed
//!
//! x̂ₖ = x̂(predicted from x̂ₖ₋₁, dₖ₋₁) + L·wrap(φₖ − φ̂(predicted))
//! L = Δt·(3p − 1/τ_m,  3p² − (3p − 1/τ_m)/τ_m,  p³·τ_m)      three poles at −p
//! ```
//!
//! An extended-state observer (J. Han, "From PID to Active Disturbance Rejection Control", IEEE Trans. Ind. Electron. 56(3),
//! 2009). w stands for the water's drag on the tail, a battery that is not at its nominal voltage, and constants of the motor that
//! differ from those configured; the servo subtracts it. Speed comes without the lag of a filter.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | φ, ω | tail angle and speed | rad, rad/s |
//! | w | disturbance, as the no-load speed it takes away; at most [`DISTURBANCE_SHARE`] of ω₀ | rad/s |
//! | d | drive over the last interval | 1 |
//! | p | poles: [`POLES_PER_S`], fewer where the interval Δt is long | 1/s |
//!
//! Assumptions and limits: called once every Δt with the drive that really went out. After a gap, or where the tail is more
//! than [`LOST_RAD`] from where it was expected, it begins again from the measurement.

use protocol::time::Duration;
use protocol::units::{Radians, RadiansPerSecond};

use crate::modboat::reference::{limit, wrap};

/// Poles p of the observer, 1/s. *Assumed*: five times the servo's own bandwidth; what the resolution of a
/// 12-bit encoder at 1 kHz turns into noise stays below 1 rad/s.
pub const POLES_PER_S: f32 = 300.0;

/// Greatest p·Δt: beyond it the sampled observer differs from the continuous one.
const POLES_INTERVAL_MAX: f32 = 0.5;

/// Greatest |w| as a share of ω₀. *Assumed*: the motor may be 30 % weaker than configured; a blocked tail asks for no more.
pub const DISTURBANCE_SHARE: f32 = 0.4;

/// Greatest difference between prediction and measurement that is followed, rad.
pub const LOST_RAD: f32 = 0.3;

/// What is known of the tail.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Speed ω, rad/s.
    pub rate_rad_s: f32,
    /// Disturbance w, rad/s.
    pub disturbance_rad_s: f32,
}

/// The observer: immutable coefficients, and the state since it began.
#[derive(Clone, Debug)]
pub struct DisturbanceObserver {
    no_load_rad_s: f32,
    interval_s: f32,
    /// 1 − exp(−Δt/τ_m).
    decay: f32,
    gains: [f32; 3],
    disturbance_max_rad_s: f32,
    /// φ̂ in (−π, π] and what is known besides; nothing before the first measurement.
    state: Option<(f32, Known)>,
}

impl DisturbanceObserver {
    /// For a motor with these constants, looked at every `interval`.
    #[must_use]
    pub fn new(no_load_speed: RadiansPerSecond, time_constant_s: f32, interval: Duration) -> Self {
        let interval_s = interval.as_secs_f32();
        let poles_per_s = POLES_PER_S.min(POLES_INTERVAL_MAX / interval_s);
        let per_time_constant = 1.0 / time_constant_s;
        let first = 3.0 * poles_per_s - per_time_constant;
        let second = 3.0 * poles_per_s * poles_per_s - first * per_time_constant;
        let third = poles_per_s * poles_per_s * poles_per_s * time_constant_s;
        Self {
            no_load_rad_s: no_load_speed.0,
            interval_s,
            decay: 1.0 - libm::expf(-interval_s / time_constant_s),
            gains: [interval_s * first, interval_s * second, interval_s * third],
            disturbance_max_rad_s: DISTURBANCE_SHARE * no_load_speed.0,
            state: None,
        }
    }

    /// Takes in the pose measured now and the drive since the last one; `rate` is believed where it has to begin.
    pub fn update(&mut self, pose: Radians, rate: RadiansPerSecond, drive: f32) -> Known {
        let begin = Known { rate_rad_s: rate.0, disturbance_rad_s: 0.0 };
        let (angle_rad, known) = self.state.unwrap_or((pose.0, begin));
        // Predicted: the speed decays towards ω₀·d + w.
        let driven_rad_s = self.no_load_rad_s * drive + known.disturbance_rad_s;
        let rate_rad_s = if self.state.is_some() {
            known.rate_rad_s + self.decay * (driven_rad_s - known.rate_rad_s)
        } else {
            rate.0
        };
        let moved_rad =
            if self.state.is_some() { 0.5 * (known.rate_rad_s + rate_rad_s) * self.interval_s } else { 0.0 };
        let off_rad = wrap(pose.0 - angle_rad - moved_rad);
        let [to_angle, to_rate, to_disturbance] = self.gains;
        let limit_rad_s = self.disturbance_max_rad_s;
        let next = Known {
            rate_rad_s: rate_rad_s + to_rate * off_rad,
            disturbance_rad_s: limit(
                known.disturbance_rad_s + to_disturbance * off_rad,
                -limit_rad_s,
                limit_rad_s,
            ),
        };
        let angle_rad = wrap(angle_rad + moved_rad + to_angle * off_rad);
        let sound =
            angle_rad.is_finite() && next.rate_rad_s.is_finite() && next.disturbance_rad_s.is_finite();
        if !sound || libm::fabsf(off_rad) > LOST_RAD {
            self.state = pose.is_finite().then_some((pose.0, begin)).filter(|_| rate.is_finite());
            return begin;
        }
        self.state = Some((angle_rad, next));
        next
    }

    /// Forgets everything: the tail was not driven by what it is told next.
    pub const fn forget(&mut self) {
        self.state = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration(1_000);
    const NO_LOAD: RadiansPerSecond = RadiansPerSecond(18.0);

    /// The modelled motor with a load, integrated in steps of 10 µs; its angle is read in `resolution_rad`.
    fn run(ticks: usize, load_rad_s: f64, resolution_rad: f64, drive: impl Fn(f64) -> f32) -> (Known, f64) {
        let mut observer = DisturbanceObserver::new(NO_LOAD, 0.02, MS);
        let (mut angle, mut rate, mut last, mut known) = (0.3_f64, 0.0_f64, 0.0_f32, Known::default());
        for tick in 0..ticks {
            let read = (angle / resolution_rad).round() * resolution_rad;
            known = observer.update(Radians(wrap(read as f32)), RadiansPerSecond(0.0), last);
            last = drive(tick as f64 * 1e-3);
            for _ in 0..100 {
                rate += 1e-5 * (18.0 * f64::from(last) + load_rad_s - rate) / 0.02;
                angle += 1e-5 * rate;
            }
        }
        (known, rate)
    }

    #[test]
    fn speed_and_load_of_the_modelled_motor_are_found() {
        for load in [-4.0, 0.0, 3.0] {
            let (known, rate) = run(300, load, 1e-6, |_| 0.5);
            assert!((f64::from(known.rate_rad_s) - rate).abs() < 0.1, "{known:?} for {rate} rad/s");
            assert!((f64::from(known.disturbance_rad_s) - load).abs() < 0.1, "{known:?} for {load} rad/s");
        }
    }

    /// With 4096 readings a turn, at any phase of a swing.
    #[test]
    fn a_12_bit_encoder_leaves_little_noise() {
        for ticks in 500..700 {
            let (known, rate) =
                run(ticks, -2.0, core::f64::consts::TAU / 4096.0, |t| 0.5 * libm::sin(8.0 * t) as f32);
            assert!((f64::from(known.rate_rad_s) - rate).abs() < 0.6, "{ticks}: {known:?} for {rate} rad/s");
            assert!((f64::from(known.disturbance_rad_s) + 2.0).abs() < 1.2, "{ticks}: {known:?}");
        }
    }

    #[test]
    fn the_load_is_limited_and_a_jump_begins_again() {
        let mut observer = DisturbanceObserver::new(NO_LOAD, 0.02, MS);
        let mut known = Known::default();
        for _ in 0..1_000 {
            known = observer.update(Radians(1.0), RadiansPerSecond(0.0), 1.0);
        }
        assert!(
            known.disturbance_rad_s.abs() <= DISTURBANCE_SHARE * 18.0 + 1e-6,
            "a blocked tail: {known:?}"
        );
        let known = observer.update(Radians(2.0), RadiansPerSecond(5.0), 0.0);
        assert_eq!(known, Known { rate_rad_s: 5.0, disturbance_rad_s: 0.0 });
    }

    #[test]
    fn takes_any_numbers_and_recovers() {
        let mut observer = DisturbanceObserver::new(NO_LOAD, 0.02, MS);
        for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
            let _ = observer.update(Radians(bad), RadiansPerSecond(bad), bad);
            for _ in 0..3 {
                let _ = observer.update(Radians(0.5), RadiansPerSecond(0.0), 0.0);
            }
            let known = observer.update(Radians(0.5), RadiansPerSecond(0.0), 0.0);
            assert!(
                known.rate_rad_s.abs() < 1e-3 && known.disturbance_rad_s.abs() < 1e-3,
                "{bad}: {known:?}"
            );
        }
    }
}
