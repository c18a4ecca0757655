//! The swim cycle of one tail: one period of a cosine about a centerline.
//!
//! φ(t) = φ₀ + A·cos(2πt/T),  t ∈ [0, T]                                               (1)
//!
//! Z. Qiao, G. Knizhnik, M. Yim, "Holonomic Control of Arbitrary Configurations of Docked Modboats". It starts
//! and ends at rest at the pose φ₀ + A, so it is evaluated from there: φ = (φ₀ + A) − A·(1 − cos(2πt/T)).
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | φ₀ | centerline, counter-clockwise from x_S | rad |
//! | A | amplitude; its sign chooses the end the swing starts from; 0: the tail rests at φ₀ | rad |
//! | T | period | µs |
//! | t | time since the start of the swing | µs |
//!
//! Assumptions and limits: any number is taken here and gives a defined result; what a tail may be asked to do
//! is decided in [`limits`](crate::modboat::limits). A period of zero rests.

use core::f32::consts::TAU;

use protocol::time::Duration;
use protocol::units::Radians;

use crate::modboat::reference::{Reference, sin_cos_turns, wrap};

/// Waveform (1), with its coefficients worked out once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waveform {
    centerline_rad: f32,
    amplitude_rad: f32,
    period: Duration,
    /// φ₀ + A in (−π, π], rad.
    start_rad: f32,
    /// 2π/T, rad/s; 0 for a period of zero.
    omega_rad_s: f32,
}

impl Waveform {
    /// From φ₀, A and T.
    #[must_use]
    pub fn new(centerline: Radians, amplitude: Radians, period: Duration) -> Self {
        let omega_rad_s = if period.0 == 0 { 0.0 } else { TAU / period.as_secs_f32() };
        Self {
            centerline_rad: centerline.0,
            amplitude_rad: amplitude.0,
            period,
            // Wrapped first: a centerline many turns out must not cost the sum its last digits.
            start_rad: wrap(wrap(centerline.0) + amplitude.0),
            omega_rad_s,
        }
    }

    /// Centerline φ₀ as it was given.
    #[must_use]
    pub const fn centerline(&self) -> Radians {
        Radians(self.centerline_rad)
    }

    /// Amplitude A.
    #[must_use]
    pub const fn amplitude(&self) -> Radians {
        Radians(self.amplitude_rad)
    }

    /// Period T.
    #[must_use]
    pub const fn period(&self) -> Duration {
        self.period
    }

    /// The pose φ₀ + A at which it starts and ends, in (−π, π].
    #[must_use]
    pub const fn start_pose(&self) -> Radians {
        Radians(self.start_rad)
    }

    /// Greatest speed 2π|A|/T, rad/s.
    #[must_use]
    pub fn peak_speed_rad_s(&self) -> f32 {
        libm::fabsf(self.amplitude_rad) * self.omega_rad_s
    }

    /// Angle, rate and acceleration `elapsed` after the start; from T on it rests at φ₀ + A.
    #[must_use]
    pub fn reference(&self, elapsed: Duration) -> Reference {
        if elapsed >= self.period {
            return Reference::at_rest(self.start_rad);
        }
        let (sin, cos) = sin_cos_turns(elapsed.as_secs_f32() / self.period.as_secs_f32());
        let (a_rad, w_rad_s) = (self.amplitude_rad, self.omega_rad_s);
        Reference {
            // φ = φ₀ + A·cos(2πt/T)                                                      (1)
            angle_rad: self.start_rad - a_rad * (1.0 - cos),
            // φ̇ = −A·(2π/T)·sin(2πt/T)
            rate_rad_s: -a_rad * w_rad_s * sin,
            // φ̈ = −A·(2π/T)²·cos(2πt/T)
            acceleration_rad_s2: -a_rad * w_rad_s * w_rad_s * cos,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD: Duration = Duration(1_500_000);

    #[test]
    fn quarter_points_are_hand_worked() {
        let wave = Waveform::new(Radians(-0.5), Radians(1.2), PERIOD);
        let omega = TAU / 1.5;
        for (t_us, angle, rate, acceleration) in [
            (0, 0.7, 0.0, -1.2 * omega * omega),
            (375_000, -0.5, -1.2 * omega, 0.0),
            (750_000, -1.7, 0.0, 1.2 * omega * omega),
            (1_125_000, -0.5, 1.2 * omega, 0.0),
        ] {
            let at = wave.reference(Duration(t_us));
            assert!((at.angle_rad - angle).abs() < 1e-5, "{t_us} µs: {at:?}");
            assert!((at.rate_rad_s - rate).abs() < 1e-5, "{t_us} µs: {at:?}");
            assert!((at.acceleration_rad_s2 - acceleration).abs() < 1e-4, "{t_us} µs: {at:?}");
        }
    }

    #[test]
    fn rests_at_its_end_pose_from_the_period_on() {
        let wave = Waveform::new(Radians(3.0), Radians(2.0), PERIOD);
        for t_us in [1_500_000, 1_500_001, u32::MAX] {
            assert_eq!(wave.reference(Duration(t_us)), Reference::at_rest(wave.start_pose().0));
        }
        assert!((f64::from(wave.start_pose().0) - (5.0 - core::f64::consts::TAU)).abs() < 1e-6);
        let no_time = Waveform::new(Radians(1.0), Radians(1.0), Duration(0));
        assert_eq!(no_time.reference(Duration(0)), Reference::at_rest(2.0));
    }

    proptest! {
        /// Rate and acceleration are the derivatives of the angle, by central differences in double precision.
        #[test]
        fn agrees_with_the_printed_law(
            centerline in -300.0_f32..300.0, amplitude in -2.6_f32..2.6, t_us in 0_u32..1_500_000,
        ) {
            let at = Waveform::new(Radians(centerline), Radians(amplitude), PERIOD).reference(Duration(t_us));
            let law = |t_s: f64| {
                f64::from(centerline) + f64::from(amplitude) * (core::f64::consts::TAU * t_s / 1.5).cos()
            };
            let (t_s, h_s) = (f64::from(t_us) * 1e-6, 1e-4);
            let turns = (f64::from(at.angle_rad) - law(t_s)) / core::f64::consts::TAU;
            prop_assert!((turns - turns.round()).abs() < 1e-6);
            let rate = (law(t_s + h_s) - law(t_s - h_s)) / (2.0 * h_s);
            prop_assert!((f64::from(at.rate_rad_s) - rate).abs() < 1e-4);
            let acceleration = (law(t_s + h_s) - 2.0 * law(t_s) + law(t_s - h_s)) / (h_s * h_s);
            prop_assert!((f64::from(at.acceleration_rad_s2) - acceleration).abs() < 1e-2);
        }

        #[test]
        fn takes_any_numbers(bits in any::<[u32; 2]>(), period in any::<u32>(), t_us in any::<u32>()) {
            let [centerline, amplitude] = bits.map(|b| Radians(f32::from_bits(b)));
            let _ = Waveform::new(centerline, amplitude, Duration(period)).reference(Duration(t_us));
        }
    }
}
