//! The rotation between two swim cycles: at constant speed, in the direction its sign says, over the whole
//! transition time (§II-E of the Modboat paper: transitions "occur at a constant speed").
//!
//! φ(t) = φ_to − Δφ·(1 − t/t_trans),  t ∈ [0, t_trans]
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Δφ | rotation, counter-clockwise positive; may exceed half a turn | rad |
//! | φ_to | pose it arrives at: φ₀ + A of the swim cycle that follows | rad |
//! | t_trans | its duration | µs |
//!
//! It is described by its end and not by its beginning, so that it meets the swim cycle exactly, and what is
//! lost to rounding is lost at the beginning, where the schedule compares poses with a tolerance.
//!
//! Assumptions and limits: the rate steps at both ends, as the paper has it; a motor follows within its
//! acceleration. A duration of zero means to be there already. Any number gives a defined result.

use protocol::units::{MicrosSpan, Radians};

use crate::reference::{Reference, wrap};

/// A rotation at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    rotation_rad: f32,
    duration: MicrosSpan,
    /// φ_to in (−π, π], rad.
    to_rad: f32,
    /// Δφ/t_trans, rad/s; 0 for a duration of zero.
    rate_rad_s: f32,
}

impl Transition {
    /// Arrives at `to` after `duration`, having turned by `rotation`.
    #[must_use]
    pub fn arriving_at(to: Radians, rotation: Radians, duration: MicrosSpan) -> Self {
        let rate_rad_s = if duration.0 == 0 { 0.0 } else { rotation.0 / duration.as_secs_f32() };
        Self { rotation_rad: rotation.0, duration, to_rad: wrap(to.0), rate_rad_s }
    }

    /// Sets out from `from` and turns by `rotation` within `duration`.
    #[must_use]
    pub fn from(from: Radians, rotation: Radians, duration: MicrosSpan) -> Self {
        Self::arriving_at(Radians(wrap(from.0) + rotation.0), rotation, duration)
    }

    /// Signed rotation Δφ.
    #[must_use]
    pub const fn rotation(&self) -> Radians {
        Radians(self.rotation_rad)
    }

    /// Duration t_trans.
    #[must_use]
    pub const fn duration(&self) -> MicrosSpan {
        self.duration
    }

    /// The pose it sets out from, in (−π, π].
    #[must_use]
    pub fn start_pose(&self) -> Radians {
        Radians(wrap(self.to_rad - self.rotation_rad))
    }

    /// The pose it arrives at, in (−π, π].
    #[must_use]
    pub const fn end_pose(&self) -> Radians {
        Radians(self.to_rad)
    }

    /// Its one speed |Δφ|/t_trans, rad/s; 0 for a duration of zero.
    #[must_use]
    pub fn speed_rad_s(&self) -> f32 {
        libm::fabsf(self.rate_rad_s)
    }

    /// Angle and rate `elapsed` after the start; from t_trans on it rests at the end pose.
    #[must_use]
    pub fn reference(&self, elapsed: MicrosSpan) -> Reference {
        // Whole microseconds first: nothing is rounded until a small number is left.
        let remaining = MicrosSpan(self.duration.0.saturating_sub(elapsed.0));
        if remaining.0 == 0 {
            return Reference::at_rest(self.to_rad);
        }
        Reference {
            // φ = φ_to − Δφ·(1 − t/t_trans)
            angle_rad: self.to_rad - self.rate_rad_s * remaining.as_secs_f32(),
            rate_rad_s: self.rate_rad_s,
            acceleration_rad_s2: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn turns_either_way_at_one_speed() {
        for rotation in [3.0_f32, -3.0] {
            let turn = Transition::from(Radians(0.25), Radians(rotation), MicrosSpan(500_000));
            assert!((turn.start_pose().0 - 0.25).abs() < 1e-6);
            let mut last = turn.reference(MicrosSpan(0));
            let set_out = last;
            for t_us in (10_000..500_000).step_by(10_000) {
                let at = turn.reference(MicrosSpan(t_us));
                assert!((at.rate_rad_s - rotation / 0.5).abs() < 1e-5);
                assert!((at.angle_rad - last.angle_rad - rotation / 50.0).abs() < 2e-6);
                last = at;
            }
            let arrived = turn.reference(MicrosSpan(500_000));
            assert_eq!(arrived, Reference::at_rest(turn.end_pose().0));
            // Unwrapped within the transition: a long way round is a long way round.
            assert!((arrived.angle_rad - set_out.angle_rad - rotation).abs() < 1e-6);
        }
    }

    #[test]
    fn takes_the_long_way_round() {
        let turn = Transition::from(Radians(3.0), Radians(-6.0), MicrosSpan(1_000_000));
        let half = turn.reference(MicrosSpan(500_000));
        assert!(wrap(half.angle_rad).abs() < 1e-6, "half of −6 rad from 3 rad is 0: {half:?}");
        assert!((turn.end_pose().0 + 3.0).abs() < 1e-6);
    }

    #[test]
    fn no_time_is_already_there() {
        let turn = Transition::arriving_at(Radians(1.0), Radians(0.0), MicrosSpan(0));
        assert_eq!(turn.reference(MicrosSpan(0)), Reference::at_rest(1.0));
        assert_eq!(turn.start_pose(), Radians(1.0));
    }

    proptest! {
        #[test]
        fn takes_any_numbers(bits in any::<[u32; 2]>(), duration in any::<u32>(), t_us in any::<u32>()) {
            let [to, rotation] = bits.map(|b| Radians(f32::from_bits(b)));
            let turn = Transition::arriving_at(to, rotation, MicrosSpan(duration));
            let _ = (turn.reference(MicrosSpan(t_us)), turn.start_pose());
        }
    }
}
