//! Stall detection: a motor that is driven and does not follow, as something holds the tail.
//!
//! Stalled once |d| ≥ d_min and |φ̇| ≤ φ̇_max and |φ_ref − φ| ≥ e_min for the hold-off
//!
//! | symbol | meaning | default | unit |
//! |---|---|---|---|
//! | d_min | drive that moves a free tail | 0.3, *assumed* | 1 |
//! | φ̇_max | rate of a tail that does not move | 0.5, *assumed* | rad/s |
//! | e_min | position error that a steady load does not leave | 0.15, *assumed* | rad |
//! | | hold-off | 0.35, *assumed* | s |
//!
//! The reference sweeps past a blocked tail, and where it comes nearest the servo does not push: of all swings and all
//! places of the block (the test below), the one that is pushed shortest is 2.6 rad about 1.6 rad from its middle, 0.43 s at a
//! time. The hold-off lies below that, so two swings are always enough to notice; and far above the 63 ms for which
//! a tail that turns back at the end of the least swing is slower than φ̇_max.
//!
//! Assumptions and limits: the servo's current limit lets a held motor have a drive of I_max/I_stall, 0.67 with its
//! defaults; a fold-back by a sensor that shows twice the current of the model leaves 0.33. A blind tail is not driven
//! and so not stalled. Input that is not a number is not a stall.

use protocol::time::{Duration, LocalInstant};
use protocol::units::{Radians, RadiansPerSecond};

use super::lasting::Lasting;

/// When a motor is stalled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StallLimits {
    /// d_min, share of the supply, 0 to 1.
    pub drive_min: f32,
    /// e_min.
    pub error_min: Radians,
    /// φ̇_max.
    pub rate_max: RadiansPerSecond,
    /// How long all that must be so.
    pub hold_off: Duration,
}

impl Default for StallLimits {
    fn default() -> Self {
        Self {
            drive_min: 0.3,
            error_min: Radians(0.15),
            rate_max: RadiansPerSecond(0.5),
            hold_off: Duration(350_000),
        }
    }
}

/// Detects a motor that is driven and does not follow.
#[derive(Clone, Debug)]
pub struct StallWatch {
    limits: StallLimits,
    held: Lasting,
}

impl StallWatch {
    /// Of a motor that is free.
    #[must_use]
    pub const fn new(limits: StallLimits) -> Self {
        Self { limits, held: Lasting::new() }
    }

    /// Takes one tick of the servo at `now`, own clock: drive, position error e, measured rate. Whether it is stalled.
    pub fn update(&mut self, now: LocalInstant, drive: f32, error: Radians, rate: RadiansPerSecond) -> bool {
        let StallLimits { drive_min, error_min, rate_max, hold_off } = self.limits;
        let held = libm::fabsf(drive) >= drive_min
            && libm::fabsf(rate.0) <= rate_max.0
            && libm::fabsf(error.0) >= error_min.0;
        self.held.update(now, held, hold_off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modboat::reference::wrap;
    use core::f32::consts::TAU;

    /// Whether so many ticks of 1 ms, from `from_ms` on, end in a stall.
    fn ticks(
        watch: &mut StallWatch,
        from_ms: u64,
        count: u64,
        (drive, error, rate): (f32, f32, f32),
    ) -> bool {
        (from_ms..from_ms + count).fold(false, |_, now_ms| {
            watch.update(LocalInstant(now_ms * 1000), drive, Radians(error), RadiansPerSecond(rate))
        })
    }

    #[test]
    fn a_held_tail_is_noticed_after_the_hold_off() {
        for held in [(0.67, 0.5, 0.0), (-0.67, -0.5, 0.1), (0.3, -0.15, -0.5)] {
            let mut watch = StallWatch::new(StallLimits::default());
            assert!(!ticks(&mut watch, 0, 350, held), "{held:?}");
            assert!(ticks(&mut watch, 350, 1, held), "{held:?}");
        }
    }

    #[test]
    fn all_three_are_needed_and_a_break_restarts_it() {
        let held = (1.0, 1.0, 0.0);
        for other in [(0.29, 1.0, 0.0), (1.0, 0.14, 0.0), (1.0, 1.0, 0.51), (f32::NAN, 1.0, 0.0)] {
            let mut watch = StallWatch::new(StallLimits::default());
            assert!(!ticks(&mut watch, 0, 10_000, other), "{other:?}");
            assert!(!ticks(&mut watch, 10_000, 350, held));
            assert!(!ticks(&mut watch, 10_350, 1, other), "{other:?}");
            assert!(!ticks(&mut watch, 10_351, 350, held));
            assert!(ticks(&mut watch, 10_701, 1, held));
        }
    }

    #[test]
    fn what_is_not_a_number_is_no_stall() {
        let mut watch = StallWatch::new(StallLimits::default());
        for input in [(1.0, f32::NAN, 0.0), (1.0, 1.0, f32::NAN), (f32::NAN, f32::NAN, f32::NAN)] {
            assert!(!ticks(&mut watch, 0, 2000, input));
        }
        assert!(ticks(&mut watch, 2000, 351, (f32::INFINITY, f32::NEG_INFINITY, 0.0)));
    }

    /// A tail blocked anywhere within any swing, pushed by the servo's law.
    #[test]
    fn two_swings_against_a_block_are_enough() {
        let swings = [0.9_f32, 1.3, 1.7, 2.1, 2.6].into_iter().flat_map(|size| [size, -size]);
        for (amplitude, share) in swings.flat_map(|a| (-10..=10_i8).map(move |k| (a, f32::from(k) / 10.0))) {
            let mut watch = StallWatch::new(StallLimits::default());
            let stalled = (0..3000_u64).any(|now_ms| {
                let phase = TAU / 1.5 * (now_ms as f32 * 1e-3);
                let rate_ref = -amplitude * (TAU / 1.5) * libm::sinf(phase);
                let error = wrap(amplitude * (libm::cosf(phase) - share));
                let speed = (rate_ref + 60.0 * error).clamp(-15.0, 15.0) + 1.2 * rate_ref;
                let drive = (speed / 18.0).clamp(-0.67, 0.67);
                watch.update(LocalInstant(now_ms * 1000), drive, Radians(error), RadiansPerSecond(0.0))
            });
            assert!(stalled, "A = {amplitude} rad, blocked at {share} of it");
        }
    }
}
