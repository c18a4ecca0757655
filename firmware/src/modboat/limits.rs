//! Limits of a tail. A cycle that asks for more is refused whole, before it is scheduled.
//!
//! ω_peak = 2π|A|/T ≤ ω_max,   |Δφ|/(t_trans − tᵣ) ≤ ω_max,   tᵣ ≤ t_trans/2
//!
//! The module checks for itself and does not trust the host's planner to have done so.
//!
//! Assumptions and limits: speeds are compared with one part in 10⁴ to spare, for the rounding of `f64` to `f32` and to
//! whole microseconds on the wire. Collisions with neighbours are the planner's business: a module knows only
//! its own tail.

use core::fmt;

use protocol::configuration::TailLimits;
use protocol::time::Duration;
use protocol::units::{Radians, RadiansPerSecond};

use crate::modboat::cycle::SwimCycle;

/// Room for rounding when speeds are compared: one part in 10⁴.
const ROUNDING: f32 = 1.0 + 1e-4;

/// The first limit a cycle breaks, with the value that breaks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Violation {
    /// Centerline φ₀ is not finite or too far out.
    Centerline(Radians),
    /// |A| is not finite or out of range, and not zero.
    Amplitude(Radians),
    /// Rotation Δφ is not finite or too far.
    Rotation(Radians),
    /// Period T is out of range.
    Period(Duration),
    /// Transition time t_trans is too long.
    TransitionTime(Duration),
    /// A rotation that is to take no time.
    RotationWithoutTime(Radians),
    /// Peak speed 2π|A|/T of the waveform is too high.
    WaveformSpeed(RadiansPerSecond),
    /// The ramp tᵣ of the transition exceeds half of its time.
    Ramp(Duration),
    /// Greatest speed |Δφ|/(t_trans − tᵣ) of the transition is too high.
    TransitionSpeed(RadiansPerSecond),
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Centerline(v) => write!(f, "centerline of {} rad is out of range", v.0),
            Self::Amplitude(v) => write!(f, "amplitude of {} rad is out of range", v.0),
            Self::Rotation(v) => write!(f, "rotation of {} rad is out of range", v.0),
            Self::Period(v) => write!(f, "period of {} µs is out of range", v.0),
            Self::TransitionTime(v) => write!(f, "transition time of {} µs is too long", v.0),
            Self::RotationWithoutTime(v) => write!(f, "rotation of {} rad in no time", v.0),
            Self::WaveformSpeed(v) => write!(f, "waveform speed of {} rad/s is too high", v.0),
            Self::Ramp(v) => write!(f, "ramp of {} µs exceeds half of the transition", v.0),
            Self::TransitionSpeed(v) => write!(f, "transition speed of {} rad/s is too high", v.0),
        }
    }
}

impl core::error::Error for Violation {}

/// Accepts a cycle that keeps every one of `limits`.
///
/// # Errors
/// The first [`Violation`]. NaN keeps no limit, and no limit that is NaN is kept.
pub fn check(limits: &TailLimits, cycle: &SwimCycle) -> Result<(), Violation> {
    let (waveform, transition) = (cycle.waveform(), cycle.transition());

    let centerline = waveform.centerline();
    if !within(centerline.0, limits.centerline_max.0) {
        return Err(Violation::Centerline(centerline));
    }
    let amplitude = waveform.amplitude();
    let magnitude_rad = libm::fabsf(amplitude.0);
    let swims = magnitude_rad > 0.0;
    let in_range = magnitude_rad >= limits.amplitude_min.0 && magnitude_rad <= limits.amplitude_max.0;
    if amplitude.0.is_nan() || (swims && !in_range) {
        return Err(Violation::Amplitude(amplitude));
    }
    let rotation = transition.rotation();
    if !within(rotation.0, limits.rotation_max.0) {
        return Err(Violation::Rotation(rotation));
    }
    let period = waveform.period();
    if period < limits.period_min || period > limits.period_max || period.0 == 0 {
        return Err(Violation::Period(period));
    }
    let duration = transition.duration();
    if duration > limits.transition_max {
        return Err(Violation::TransitionTime(duration));
    }
    if duration.0 == 0 && libm::fabsf(rotation.0) > 0.0 {
        return Err(Violation::RotationWithoutTime(rotation));
    }
    // ω_peak = 2π|A|/T ≤ ω_max
    if !within(waveform.peak_speed_rad_s(), limits.speed_max.0 * ROUNDING) {
        return Err(Violation::WaveformSpeed(RadiansPerSecond(waveform.peak_speed_rad_s())));
    }
    let ramp = transition.asked_ramp();
    if ramp.0 > duration.0 >> 1 {
        return Err(Violation::Ramp(ramp));
    }
    // |Δφ|/(t_trans − tᵣ) ≤ ω_max
    if !within(transition.peak_speed_rad_s(), limits.speed_max.0 * ROUNDING) {
        return Err(Violation::TransitionSpeed(RadiansPerSecond(transition.peak_speed_rad_s())));
    }
    Ok(())
}

/// |value| ≤ bound and finite. False for NaN on either side.
fn within(value: f32, bound: f32) -> bool {
    value.is_finite() && libm::fabsf(value) <= bound
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modboat::waveform::Waveform;
    use core::f32::consts::TAU;
    use proptest::prelude::*;
    use protocol::time::FleetInstant;

    fn check(
        centerline: f32,
        amplitude: f32,
        rotation: f32,
        t_trans: u32,
        period: u32,
    ) -> Result<(), Violation> {
        let waveform = Waveform::new(Radians(centerline), Radians(amplitude), Duration(period));
        let cycle = SwimCycle::new(
            1,
            FleetInstant(0),
            Radians(rotation),
            (Duration(t_trans), protocol::TransitionLaw::ConstantSpeed),
            waveform,
        );
        super::check(&TailLimits::default(), &cycle)
    }

    #[test]
    fn accepts_the_whole_range_with_its_ends() {
        for amplitude in [0.0, -0.0, 0.9, -0.9, 2.6, -2.6] {
            assert_eq!(check(1.0, amplitude, 0.0, 0, 1_500_000), Ok(()), "{amplitude}");
        }
        // A whole turn in 0.5 s is 12.57 rad/s.
        assert_eq!(check(0.0, 1.0, -TAU, 500_000, 1_500_000), Ok(()));
        // The speed limit itself, rounded.
        assert_eq!(check(0.0, 1.0, 6.5, 500_000, 1_500_000), Ok(()));
    }

    #[test]
    fn refuses_each_by_name_and_value() {
        let t = 1_500_000;
        assert_eq!(check(1001.0, 1.0, 0.0, 0, t), Err(Violation::Centerline(Radians(1001.0))));
        assert_eq!(check(0.0, 0.89, 0.0, 0, t), Err(Violation::Amplitude(Radians(0.89))));
        assert_eq!(check(0.0, -2.61, 0.0, 0, t), Err(Violation::Amplitude(Radians(-2.61))));
        assert_eq!(check(0.0, 1.0, 13.0, 9_000_000, t), Err(Violation::Rotation(Radians(13.0))));
        assert_eq!(check(0.0, 1.0, 0.0, 0, 0), Err(Violation::Period(Duration(0))));
        assert_eq!(check(0.0, 1.0, 0.0, 0, 10_000_001), Err(Violation::Period(Duration(10_000_001))));
        assert_eq!(check(0.0, 1.0, 0.1, 10_000_001, t), Err(Violation::TransitionTime(Duration(10_000_001))));
        assert_eq!(check(0.0, 1.0, 0.01, 0, t), Err(Violation::RotationWithoutTime(Radians(0.01))));
        assert!(matches!(check(0.0, 2.6, 0.0, 0, 1_250_000),
            Err(Violation::WaveformSpeed(v)) if (v.0 - 13.069).abs() < 1e-3));
        assert!(matches!(check(0.0, 1.0, -6.51, 500_000, t),
            Err(Violation::TransitionSpeed(v)) if (v.0 - 13.02).abs() < 1e-3));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(matches!(check(bad, 1.0, 0.0, 0, t), Err(Violation::Centerline(_))));
            assert!(matches!(check(0.0, bad, 0.0, 0, t), Err(Violation::Amplitude(_))));
            assert!(matches!(check(0.0, 1.0, bad, 500_000, t), Err(Violation::Rotation(_))));
        }
    }

    proptest! {
        /// Whatever passes gives a finite reference within the speed limit at every instant.
        #[test]
        fn what_passes_is_slow_enough(
            bits in any::<[u32; 3]>(), spans in any::<[u32; 2]>(), usual in any::<bool>(),
            c in -9.0_f32..9.0, a in -3.0_f32..3.0, r in -9.0_f32..9.0, now in 0_u64..20_000_000,
        ) {
            let [c, a, r] = if usual { [c, a, r] } else { bits.map(f32::from_bits) };
            let [t_trans, period] = if usual { spans.map(|s| s % 12_000_000) } else { spans };
            if check(c, a, r, t_trans, period).is_ok() {
                let waveform = Waveform::new(Radians(c), Radians(a), Duration(period));
                let cycle = SwimCycle::new(1, FleetInstant(0), Radians(r), (Duration(t_trans), protocol::TransitionLaw::ConstantSpeed), waveform);
                let at = cycle.reference(FleetInstant(now));
                prop_assert!(at.is_finite());
                prop_assert!(at.rate_rad_s.abs() <= 13.0 * 1.001);
            }
        }
    }
}
