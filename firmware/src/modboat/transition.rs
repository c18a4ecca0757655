//! The rotation between two swim cycles: in the direction its sign says, over the whole transition time, by one law of time
//! that all modules share.
//!
//! φ(t) = φ_to − Δφ·(1 − s(t)),  t ∈ [0, t_trans]
//!
//! | law | s(t) | peak speed | acceleration |
//! |---|---|---|---|
//! | constant speed | t/t_trans | Δφ/t_trans | a jump of speed at both ends |
//! | rest to rest | t²/2tᵣ(t_trans − tᵣ), then (t − tᵣ/2)/(t_trans − tᵣ), then 1 − (t_trans − t)²/2tᵣ(t_trans − tᵣ) | Δφ/(t_trans − tᵣ) | peak speed/tᵣ |
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Δφ | rotation, counter-clockwise positive; may exceed half a turn | rad |
//! | φ_to | pose it arrives at: φ₀ + A of the swim cycle that follows | rad |
//! | t_trans, tᵣ | its duration, and the length of each ramp | µs |
//!
//! The paper (§II-E) turns at constant speed. A motor cannot follow its jumps of speed, and leaves the straight segment of
//! phase space that the planner keeps free. s is the same for every module, so the segment is the same under any law.
//!
//! It is described by its end and not by its beginning, so that it meets the swim cycle exactly, and what is
//! lost to rounding is lost at the beginning, where the schedule compares poses with a tolerance.
//!
//! Assumptions and limits: a ramp of zero is constant speed, one beyond half of the duration is cut to that
//! ([`limits`](crate::modboat::limits) refuses it before). A duration of zero means to be there already. Any number gives a defined
//! result.

use protocol::TransitionLaw;
use protocol::time::Duration;
use protocol::units::Radians;

use crate::modboat::reference::{Reference, wrap};

/// A rotation by one law of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    rotation_rad: f32,
    duration: Duration,
    /// φ_to in (−π, π], rad.
    to_rad: f32,
    /// What the law asks for, and what of it fits: at most half of the duration; 0 for constant speed.
    asked_ramp: Duration,
    ramp: Duration,
    /// Δφ/(t_trans − tᵣ), rad/s; 0 for a duration of zero.
    peak_rad_s: f32,
    /// Peak speed over tᵣ, rad/s²; 0 for constant speed.
    acceleration_rad_s2: f32,
}

impl Transition {
    /// Arrives at `to` after `duration`, having turned by `rotation`.
    #[must_use]
    pub fn arriving_at(to: Radians, rotation: Radians, duration: Duration, law: TransitionLaw) -> Self {
        let asked_ramp = match law {
            TransitionLaw::ConstantSpeed => Duration(0),
            TransitionLaw::RestToRest { ramp } => ramp,
        };
        let ramp = Duration(asked_ramp.0.min(duration.0 >> 1));
        let over = Duration(duration.0.saturating_sub(ramp.0)).as_secs_f32();
        let peak_rad_s = if duration.0 == 0 { 0.0 } else { rotation.0 / over };
        let acceleration_rad_s2 = if ramp.0 == 0 { 0.0 } else { peak_rad_s / ramp.as_secs_f32() };
        Self {
            rotation_rad: rotation.0,
            duration,
            to_rad: wrap(to.0),
            asked_ramp,
            ramp,
            peak_rad_s,
            acceleration_rad_s2,
        }
    }

    /// Sets out from `from` and turns by `rotation` within `duration`.
    #[must_use]
    pub fn from(from: Radians, rotation: Radians, duration: Duration, law: TransitionLaw) -> Self {
        Self::arriving_at(Radians(wrap(from.0) + rotation.0), rotation, duration, law)
    }

    /// Signed rotation Δφ.
    #[must_use]
    pub const fn rotation(&self) -> Radians {
        Radians(self.rotation_rad)
    }

    /// Duration t_trans.
    #[must_use]
    pub const fn duration(&self) -> Duration {
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

    /// Length of each ramp as the law asks for it; 0 for constant speed.
    #[must_use]
    pub const fn asked_ramp(&self) -> Duration {
        self.asked_ramp
    }

    /// Its greatest speed |Δφ|/(t_trans − tᵣ), rad/s; 0 for a duration of zero.
    #[must_use]
    pub fn peak_speed_rad_s(&self) -> f32 {
        libm::fabsf(self.peak_rad_s)
    }

    /// The steps of its speed at both ends, rad/s: none with ramps.
    #[must_use]
    pub fn speed_step_rad_s(&self) -> f32 {
        if self.ramp.0 == 0 { self.peak_speed_rad_s() } else { 0.0 }
    }

    /// Angle, rate and acceleration `elapsed` after the start; from t_trans on it rests at the end pose.
    #[must_use]
    pub fn reference(&self, elapsed: Duration) -> Reference {
        // Whole microseconds first: nothing is rounded until a small number is left.
        let remaining = Duration(self.duration.0.saturating_sub(elapsed.0));
        if remaining.0 == 0 {
            return Reference::at_rest(self.to_rad);
        }
        let (peak_rad_s, acceleration_rad_s2) = (self.peak_rad_s, self.acceleration_rad_s2);
        if elapsed < self.ramp {
            // φ = φ_to − Δφ + ½·α·t²
            let t_s = elapsed.as_secs_f32();
            let rate_rad_s = acceleration_rad_s2 * t_s;
            let angle_rad = self.to_rad - self.rotation_rad + 0.5 * rate_rad_s * t_s;
            Reference { angle_rad, rate_rad_s, acceleration_rad_s2 }
        } else if remaining < self.ramp {
            // φ = φ_to − ½·α·(t_trans − t)²
            let left_s = remaining.as_secs_f32();
            let rate_rad_s = acceleration_rad_s2 * left_s;
            let angle_rad = self.to_rad - 0.5 * rate_rad_s * left_s;
            Reference { angle_rad, rate_rad_s, acceleration_rad_s2: -acceleration_rad_s2 }
        } else {
            // φ = φ_to − φ̇·(t_trans − t − tᵣ/2)
            let left_s = remaining.as_secs_f32() - 0.5 * self.ramp.as_secs_f32();
            let angle_rad = self.to_rad - peak_rad_s * left_s;
            Reference { angle_rad, rate_rad_s: peak_rad_s, acceleration_rad_s2: 0.0 }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SMOOTH: TransitionLaw = TransitionLaw::RestToRest { ramp: Duration(50_000) };

    #[test]
    fn turns_either_way_at_one_speed() {
        for rotation in [3.0_f32, -3.0] {
            let turn = Transition::from(
                Radians(0.25),
                Radians(rotation),
                Duration(500_000),
                TransitionLaw::ConstantSpeed,
            );
            assert!((turn.start_pose().0 - 0.25).abs() < 1e-6);
            let mut last = turn.reference(Duration(0));
            let set_out = last;
            for t_us in (10_000..500_000).step_by(10_000) {
                let at = turn.reference(Duration(t_us));
                assert!((at.rate_rad_s - rotation / 0.5).abs() < 1e-5);
                assert!((at.angle_rad - last.angle_rad - rotation / 50.0).abs() < 2e-6);
                last = at;
            }
            let arrived = turn.reference(Duration(500_000));
            assert_eq!(arrived, Reference::at_rest(turn.end_pose().0));
            // Unwrapped within the transition: a long way round is a long way round.
            assert!((arrived.angle_rad - set_out.angle_rad - rotation).abs() < 1e-6);
        }
    }

    #[test]
    fn ramps_are_hand_worked() {
        // 4.5 rad in 0.5 s with ramps of 50 ms: 10 rad/s at 200 rad/s², 0.25 rad on each ramp.
        let turn = Transition::from(Radians(-1.0), Radians(4.5), Duration(500_000), SMOOTH);
        assert!((turn.peak_speed_rad_s() - 10.0).abs() < 1e-5);
        for (t_us, angle, rate, acceleration) in [
            (0, -1.0, 0.0, 200.0),
            (25_000, -0.9375, 5.0, 200.0),
            (50_000, -0.75, 10.0, 0.0),
            (250_000, 1.25, 10.0, 0.0),
            (475_000, 3.4375, 5.0, -200.0),
        ] {
            let at = turn.reference(Duration(t_us));
            assert!(wrap(at.angle_rad - angle).abs() < 2e-6, "{t_us} µs: {at:?}");
            assert!((at.rate_rad_s - rate).abs() < 1e-4, "{t_us} µs: {at:?}");
            assert!((at.acceleration_rad_s2 - acceleration).abs() < 1e-2, "{t_us} µs: {at:?}");
        }
        assert_eq!(turn.reference(Duration(500_000)), Reference::at_rest(turn.end_pose().0));
    }

    /// A ramp beyond half of the time is cut to half: never faster than twice the mean speed.
    #[test]
    fn a_ramp_is_at_most_half_of_the_time() {
        let law = TransitionLaw::RestToRest { ramp: Duration(u32::MAX) };
        let turn = Transition::from(Radians(0.0), Radians(1.0), Duration(200_000), law);
        assert!((turn.peak_speed_rad_s() - 10.0).abs() < 1e-5);
        assert!((turn.reference(Duration(100_000)).angle_rad - 0.5).abs() < 1e-6);
    }

    #[test]
    fn takes_the_long_way_round() {
        let turn = Transition::from(Radians(3.0), Radians(-6.0), Duration(1_000_000), SMOOTH);
        let half = turn.reference(Duration(500_000));
        assert!(wrap(half.angle_rad).abs() < 1e-6, "half of −6 rad from 3 rad is 0: {half:?}");
        assert!((turn.end_pose().0 + 3.0).abs() < 1e-6);
    }

    #[test]
    fn no_time_is_already_there() {
        let turn = Transition::arriving_at(Radians(1.0), Radians(0.0), Duration(0), SMOOTH);
        assert_eq!(turn.reference(Duration(0)), Reference::at_rest(1.0));
        assert_eq!(turn.start_pose(), Radians(1.0));
    }

    proptest! {
        /// Two tails that share a law stay on the straight segment of their phase space.
        #[test]
        fn a_common_law_keeps_the_segment(
            rotations in prop::array::uniform2(-6.0_f32..6.0), duration in 1_000_u32..1_000_000,
            ramp in 0_u32..600_000, share in 0.0_f32..1.0,
        ) {
            let law = TransitionLaw::RestToRest { ramp: Duration(ramp) };
            let elapsed = Duration((share * duration as f32) as u32);
            let gone = rotations.map(|rotation| {
                let turn = Transition::arriving_at(Radians(0.0), Radians(rotation), Duration(duration), law);
                1.0 + turn.reference(elapsed).angle_rad / rotation
            });
            let near_zero = rotations.iter().any(|rotation| rotation.abs() < 0.1);
            prop_assert!(near_zero || (gone[0] - gone[1]).abs() < 1e-5, "{gone:?}");
        }

        /// Rate and acceleration are the derivatives of the angle, by differences in double precision; no step of speed anywhere.
        #[test]
        fn rest_to_rest_is_smooth(rotation in -6.0_f32..6.0, ramp in 5_000_u32..250_000, t_us in 0_u32..499_000) {
            let law = TransitionLaw::RestToRest { ramp: Duration(ramp) };
            let turn = Transition::arriving_at(Radians(0.0), Radians(rotation), Duration(500_000), law);
            let [now, then] = [t_us, t_us + 1_000].map(|t_us| turn.reference(Duration(t_us)));
            let mean_rad_s = f64::from(then.angle_rad - now.angle_rad) * 1e3;
            let fastest = f64::from(turn.peak_speed_rad_s()) / (f64::from(ramp) * 1e-6) * 1e-3;
            prop_assert!((mean_rad_s - f64::from(now.rate_rad_s)).abs() < fastest + 2e-3);
            prop_assert!(f64::from((then.rate_rad_s - now.rate_rad_s).abs()) < 1.01 * fastest + 1e-3);
        }

        #[test]
        fn takes_any_numbers(
            bits in any::<[u32; 2]>(), duration in any::<u32>(), ramp in any::<u32>(), t_us in any::<u32>(),
        ) {
            let [to, rotation] = bits.map(|b| Radians(f32::from_bits(b)));
            let law = TransitionLaw::RestToRest { ramp: Duration(ramp) };
            let turn = Transition::arriving_at(to, rotation, Duration(duration), law);
            let _ = (turn.reference(Duration(t_us)), turn.start_pose());
        }
    }
}
