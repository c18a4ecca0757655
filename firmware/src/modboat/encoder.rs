//! The encoder: from the counts of an absolute encoder to the pose, the turns and the rate of the tail.
//!
//! φ = 2π·(n − n₀)/N,   φ̇ₖ = φ̇ₖ₋₁ + α·(Δφₖ/Δt − φ̇ₖ₋₁),   α = 1 − exp(−2π·f_c·Δt)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | n, N | reading, readings per turn | count |
//! | n₀ | reading at which the tail points along x_S (found on the bench, kept in the configuration) | count |
//! | Δφₖ | change since the last reading, the shorter way round | rad |
//! | f_c | bandwidth of the rate: 40 Hz, a lag of 4 ms | Hz |
//!
//! A 12-bit encoder at 1 kHz resolves 1.5 rad/s in one difference; the filter leaves some 0.5 rad/s of that.
//!
//! A reading more than a quarter turn from the last one is not believed at once: no motor turns 1500 rad/s.
//! After [`SUSPECTS`] such readings that agree with one another the counter moves over, without counting the
//! jump into the rate (a slipped magnet, a brown-out). Readings outside 0..N are never believed.
//!
//! Assumptions and limits: called at a fixed interval Δt. Whole turns and the reading within the turn are kept as
//! integers, so the angle never loses precision; turns saturate at 2³¹. Encoders of up to 2³⁰ readings.

use core::f32::consts::{PI, TAU};

use protocol::configuration::EncoderMounting;
use protocol::time::Duration;
use protocol::units::{Radians, RadiansPerSecond};

/// An absolute encoder on the motor axis.
pub trait Encoder {
    /// What can go wrong in reading it.
    type Error;

    /// Readings per turn, N.
    const COUNTS_PER_TURN: u32;

    /// The reading within the turn, in 0..N.
    ///
    /// # Errors
    /// Whatever the bus reports. The servo rides through single failures.
    fn counts(&mut self) -> Result<u32, Self::Error>;

    /// False while it works and does not know yet where in the turn it is; [`counts`](Self::counts) fails until then.
    fn is_homed(&self) -> bool {
        true
    }

    /// Whether its index came elsewhere than the count expects it, since this was asked last. It is not homed then.
    fn take_index_fault(&mut self) -> bool {
        false
    }

    /// Told in every tick before the tail is driven: whether it rests where it is held, so that an encoder that counts may keep its zero
    /// over a reset; see [`kept_zero`](crate::modboat::kept_zero). One that is absolute has nothing to keep.
    fn keep_zero(&mut self, _resting: bool) {}
}

/// Consecutive readings that must agree before a jump is believed.
pub const SUSPECTS: u8 = 3;

/// Bandwidth f_c of the rate estimate, Hz.
pub const RATE_BANDWIDTH_HZ: f32 = 40.0;

/// Most readings per turn that are told apart; an encoder said to have more has its upper ones rejected.
const COUNTS_MAX: i32 = 1 << 30;

/// What became of one reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// It moved the pose.
    Taken,
    /// It was not believed; the pose is the last good one.
    Rejected,
    /// The jump was confirmed; the pose moved over.
    MovedOver,
}

/// Pose, turns and rate, from one reading after another.
#[derive(Clone, Debug)]
pub struct TurnCounter {
    /// N, at most 2³⁰, so that sums of two positions fit.
    counts_per_turn: i32,
    /// n₀ in 0..N.
    zero_counts: i32,
    reversed: bool,
    radians_per_count: f32,
    /// rad/s of one count per interval.
    rate_per_count_rad_s: f32,
    alpha: f32,
    turns: i32,
    /// Reading from n₀ on, counter-clockwise, in 0..N; nothing before the first.
    position: Option<i32>,
    suspect: i32,
    suspects: u8,
    rate_rad_s: f32,
    rejected: u32,
}

impl TurnCounter {
    /// For an encoder of `counts_per_turn`, mounted so, read once every `interval`.
    #[must_use]
    pub fn new(counts_per_turn: u32, mounting: EncoderMounting, interval: Duration) -> Self {
        let counts_per_turn = i32::try_from(counts_per_turn).unwrap_or(i32::MAX).clamp(1, COUNTS_MAX);
        let zero_counts =
            i64::from(mounting.zero_counts).checked_rem(i64::from(counts_per_turn)).unwrap_or(0);
        let interval_s = Duration(interval.0.max(1)).as_secs_f32();
        let radians_per_count = TAU / count_to_f32(counts_per_turn);
        Self {
            counts_per_turn,
            zero_counts: i32::try_from(zero_counts).unwrap_or(0),
            reversed: mounting.reversed,
            radians_per_count,
            rate_per_count_rad_s: radians_per_count / interval_s,
            // α = 1 − exp(−2π·f_c·Δt)
            alpha: 1.0 - libm::expf(-TAU * RATE_BANDWIDTH_HZ * interval_s),
            turns: 0,
            position: None,
            suspect: 0,
            suspects: 0,
            rate_rad_s: 0.0,
            rejected: 0,
        }
    }

    /// Takes one reading in.
    pub fn update(&mut self, counts: u32) -> Reading {
        let Some(counts) = i32::try_from(counts).ok().filter(|counts| *counts < self.counts_per_turn) else {
            self.suspects = 0;
            return self.reject();
        };
        let offset = if self.reversed {
            self.zero_counts.saturating_sub(counts)
        } else {
            counts.saturating_sub(self.zero_counts)
        };
        let position = self.within_turn(offset);
        let Some(last) = self.position else {
            self.position = Some(position);
            return Reading::Taken;
        };
        let delta = self.shorter_way(last, position);
        if self.is_plausible(delta) {
            self.suspects = 0;
            self.advance(last, delta);
            // φ̇ₖ = φ̇ₖ₋₁ + α·(Δφₖ/Δt − φ̇ₖ₋₁)
            let raw_rad_s = count_to_f32(delta) * self.rate_per_count_rad_s;
            self.rate_rad_s += self.alpha * (raw_rad_s - self.rate_rad_s);
            return Reading::Taken;
        }
        let agrees = self.suspects > 0 && self.is_plausible(self.shorter_way(self.suspect, position));
        self.suspects = if agrees { self.suspects.saturating_add(1) } else { 1 };
        self.suspect = position;
        if self.suspects < SUSPECTS {
            return self.reject();
        }
        self.suspects = 0;
        self.advance(last, delta);
        Reading::MovedOver
    }

    /// Counts a reading that failed on the bus; the pose stays.
    pub fn missed(&mut self) {
        self.reject();
    }

    /// The pose φ in (−π, π]; nothing before the first reading.
    #[must_use]
    pub fn pose(&self) -> Option<Radians> {
        let position = self.position?;
        let counts = if position > self.counts_per_turn >> 1 {
            position.saturating_sub(self.counts_per_turn)
        } else {
            position
        };
        // φ = 2π·(n − n₀)/N
        let angle_rad = count_to_f32(counts) * self.radians_per_count;
        // Rounding may leave it one step outside.
        Some(Radians(if angle_rad > PI { PI } else { angle_rad }))
    }

    /// Whole turns since the first reading: how often the tail passed x_S counter-clockwise, less clockwise.
    #[must_use]
    pub const fn turns(&self) -> i32 {
        self.turns
    }

    /// Angle with the turns in it, for plots and telemetry; coarser the more turns it has made.
    #[must_use]
    pub fn unwrapped(&self) -> Option<Radians> {
        let within_rad = count_to_f32(self.position?) * self.radians_per_count;
        Some(Radians(count_to_f32(self.turns) * TAU + within_rad))
    }

    /// Filtered rate φ̇.
    #[must_use]
    pub const fn rate(&self) -> RadiansPerSecond {
        RadiansPerSecond(self.rate_rad_s)
    }

    /// Readings that failed or were not believed, saturating.
    #[must_use]
    pub const fn rejected(&self) -> u32 {
        self.rejected
    }

    /// The reading n₀ that makes the present pose zero: on the bench, with the tail held along x_S. Only returned,
    /// to be stored; this counter goes on with the one it was made with.
    #[must_use]
    pub fn zero_here(&self) -> Option<u32> {
        let position = self.position?;
        let signed = if self.reversed { position.saturating_neg() } else { position };
        u32::try_from(self.within_turn(self.zero_counts.saturating_add(signed))).ok()
    }

    fn reject(&mut self) -> Reading {
        self.rejected = self.rejected.saturating_add(1);
        Reading::Rejected
    }

    /// The same position in 0..N, of one less than a turn outside. Cheaper than a remainder.
    const fn within_turn(&self, counts: i32) -> i32 {
        if counts < 0 {
            counts.saturating_add(self.counts_per_turn)
        } else if counts >= self.counts_per_turn {
            counts.saturating_sub(self.counts_per_turn)
        } else {
            counts
        }
    }

    /// The shorter way from one position to another, −N/2 < Δ ≤ N/2.
    const fn shorter_way(&self, from: i32, to: i32) -> i32 {
        let ahead = self.within_turn(to.saturating_sub(from));
        if ahead > self.counts_per_turn >> 1 { ahead.saturating_sub(self.counts_per_turn) } else { ahead }
    }

    /// |Δ| ≤ N/4.
    const fn is_plausible(&self, delta: i32) -> bool {
        delta.saturating_abs() <= self.counts_per_turn >> 2
    }

    fn advance(&mut self, last: i32, delta: i32) {
        let sum = last.saturating_add(delta);
        let carried = if sum < 0 {
            -1
        } else if sum >= self.counts_per_turn {
            1
        } else {
            0
        };
        self.turns = self.turns.saturating_add(carried);
        self.position = Some(self.within_turn(sum));
    }
}

#[cfg_attr(
    not(test),
    expect(clippy::cast_precision_loss, reason = "exact up to 2^24; encoders have 2^20 counts at most")
)]
fn count_to_f32(counts: i32) -> f32 {
    counts as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modboat::reference::wrap;
    use proptest::prelude::*;

    const TICK: Duration = Duration(1000);

    fn counter(zero_counts: u32, reversed: bool) -> TurnCounter {
        TurnCounter::new(4096, EncoderMounting { zero_counts, reversed }, TICK)
    }

    #[test]
    fn zero_is_where_the_tail_points_along_x() {
        let mut straight = counter(1000, false);
        assert_eq!(straight.pose(), None);
        straight.update(1000);
        assert_eq!(straight.pose(), Some(Radians(0.0)));
        straight.update(2024);
        assert!((straight.pose().unwrap().0 - TAU / 4.0).abs() < 1e-6);
        assert_eq!(straight.zero_here(), Some(2024));

        let mut reversed = counter(1000, true);
        reversed.update(2000);
        assert!((reversed.pose().unwrap().0 + TAU * 1000.0 / 4096.0).abs() < 1e-6);
        assert_eq!(reversed.zero_here(), Some(2000));
    }

    #[test]
    fn a_jump_is_counted_and_not_believed_at_once() {
        let mut counter = counter(0, false);
        for counts in [100, 110, 120] {
            assert_eq!(counter.update(counts), Reading::Taken);
        }
        let (pose, rate) = (counter.pose(), counter.rate());
        assert_eq!(counter.update(3000), Reading::Rejected);
        assert_eq!((counter.pose(), counter.rate()), (pose, rate));
        assert_eq!(counter.update(130), Reading::Taken);
        assert_eq!(counter.rejected(), 1);
        // Readings that do not agree with one another are never believed.
        for counts in [1500, 2700, 1500, 2700, 1500, 2700] {
            assert_eq!(counter.update(counts), Reading::Rejected);
        }
        // Neither are readings no encoder gives.
        for _ in 0..5 {
            assert_eq!(counter.update(4096), Reading::Rejected);
        }
        let rate = counter.rate();
        assert_eq!(counter.update(2100), Reading::Rejected);
        assert_eq!(counter.update(2105), Reading::Rejected);
        assert_eq!(counter.update(2110), Reading::MovedOver);
        assert_eq!(counter.rate(), rate, "the jump is no speed");
        assert!((counter.unwrapped().unwrap().0 - TAU * 2110.0 / 4096.0).abs() < 1e-5);
        assert_eq!(counter.rejected(), 14);
        counter.missed();
        assert_eq!(counter.rejected(), 15);
    }

    #[test]
    fn rate_settles_on_a_steady_speed() {
        let mut counter = counter(0, false);
        // 7 counts a millisecond.
        for tick in 0..200_u32 {
            counter.update(tick * 7 % 4096);
        }
        let expected_rad_s = 7.0 * TAU / 4096.0 * 1000.0;
        assert!((counter.rate().0 - expected_rad_s).abs() < 1e-3, "{:?}", counter.rate());
        // After 4 ms (one time constant of 40 Hz) of standing still, 1/e of it is left.
        for _ in 0..4 {
            counter.update(199 * 7);
        }
        let left = counter.rate().0 / expected_rad_s;
        assert!((left - (-TAU * 40.0 * 0.004_f32).exp()).abs() < 1e-3, "{left}");
    }

    proptest! {
        /// A walk in steps below a quarter turn: turns and pose against plain integers.
        #[test]
        fn counts_turns_across_the_seam(
            bits in 4_u32..20, zero in any::<u32>(), reversed in any::<bool>(),
            steps in proptest::collection::vec(-0.249_f64..0.249, 1..200),
        ) {
            let counts_per_turn = 1_i64 << bits;
            let zero = zero % (1 << bits);
            let mounting = EncoderMounting { zero_counts: zero, reversed };
            let mut counter = TurnCounter::new(1 << bits, mounting, TICK);
            let mut position = 0_i64;
            for step in steps.into_iter().map(|s| (s * counts_per_turn as f64) as i64) {
                let signed = if reversed { -position } else { position };
                let raw = (signed + i64::from(zero)).rem_euclid(counts_per_turn);
                prop_assert_eq!(counter.update(u32::try_from(raw).unwrap()), Reading::Taken);
                prop_assert_eq!(i64::from(counter.turns()), position.div_euclid(counts_per_turn));
                let expected_rad = position as f64 / counts_per_turn as f64 * core::f64::consts::TAU;
                let unwrapped_rad = f64::from(counter.unwrapped().unwrap().0);
                prop_assert!((unwrapped_rad - expected_rad).abs() < 1e-4);
                let pose_rad = counter.pose().unwrap().0;
                prop_assert!(pose_rad > -PI && pose_rad <= PI);
                prop_assert!(f64::from(wrap(pose_rad - wrap(expected_rad as f32))).abs() < 1e-4);
                position += step;
            }
        }

        #[test]
        fn takes_any_readings(
            counts_per_turn in any::<u32>(), zero_counts in any::<u32>(), reversed in any::<bool>(),
            interval in any::<u32>(), readings in proptest::collection::vec(any::<u32>(), 1..50),
        ) {
            let mounting = EncoderMounting { zero_counts, reversed };
            let mut counter = TurnCounter::new(counts_per_turn, mounting, Duration(interval));
            for reading in readings {
                counter.update(reading);
                counter.update(reading.checked_rem(counts_per_turn).unwrap_or(0));
                prop_assert!(counter.rate().is_finite());
                let _ = (counter.pose(), counter.unwrapped(), counter.zero_here());
            }
        }
    }
}
