//! Offset and drift known from the exchanges so far, and their uncertainty.
//!
//! ```text
//! o_low − 300 ppm·age ≤ offset ≤ o_high + 300 ppm·age                  always
//! |offset − estimate| ≤ u + u′·age + ½·w·age²                          in 99 % of the time, for symmetric delays
//! ```
//!
//! with w = 1 ppm/min (*assumed*) for the temperature. The bounds are carried on from exchange to exchange:
//! o_high ← min(o_high + 300 ppm·Δt, t2 − t1), and so o_low.

use super::blocks::{Block, Sight};
use super::estimate::DRIFT_MAX_PPB;
use super::exact::{along, drifted_us, micros, seconds, whole};
use super::output::Output;

/// w: 1 ppm per minute. *Assumed.*
const WANDER_PPM_S: f32 = 1.0 / 60.0;

/// What no exchange tells, of half a turn of two loops at 1 kHz: one may always just miss what the other just meets.
const POLL_US: f32 = 450.0;

/// An exchange that is better than four uncertainties and 1 ms allow was not on the same clock.
const SURPRISE: f32 = 4.0;
const SURPRISE_US: f32 = 1_000.0;

/// Offset, drift and uncertainty at the last exchange. Times are of the own clock, offsets fleet clock less own clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// t4 of the last exchange. All that follows holds at this time.
    pub at_us: u64,
    /// t1 of the last exchange.
    pub request_us: u64,
    /// o_high, o_low
    pub bounds_us: [i64; 2],
    /// The estimate.
    pub offset_us: i64,
    pub drift_ppb: i32,
    /// u, u′: infinite if nothing is known of the delays.
    pub unsure_us: f32,
    pub unsure_ppm: f32,
    /// Least t2 − t1 and greatest t3 − t4 to be expected.
    pub edges_us: [i64; 2],
    pub output: Output,
}

impl Known {
    /// From one exchange alone; the output goes on from where it is if there is one.
    pub(super) fn of(sights: &Block, from: Option<&Output>) -> Self {
        let bounds_us = [sights.forward.offset_us, sights.backward.offset_us];
        let (offset_us, at_us) = (middle_us(bounds_us), sights.backward.at_us);
        let output = match from {
            Some(output) => output.slewed(at_us, offset_us, 0),
            None => Output::at_once(at_us, offset_us, 0),
        };
        Self {
            at_us,
            request_us: sights.forward.at_us,
            bounds_us,
            offset_us,
            drift_ppb: 0,
            unsure_us: f32::INFINITY,
            unsure_ppm: 0.0,
            edges_us: bounds_us,
            output,
        }
    }

    /// All but the output, at a later time.
    pub(super) fn later(&self, at_us: u64) -> Self {
        let drifted_us = drifted_us(along(self.at_us, at_us), self.drift_ppb);
        Self {
            at_us,
            bounds_us: self.bounds_us(at_us),
            offset_us: self.offset_us.saturating_add(drifted_us),
            unsure_us: self.unsure_us(at_us),
            edges_us: self.edges_us.map(|edge_us| edge_us.saturating_add(drifted_us)),
            ..*self
        }
    }

    /// 99 % bound of the estimate.
    pub(super) fn unsure_us(&self, local_us: u64) -> f32 {
        let age_s = seconds(along(self.at_us, local_us).saturating_abs());
        self.unsure_us + self.unsure_ppm * age_s + 0.5 * WANDER_PPM_S * age_s * age_s
    }

    /// Bounds of the offset.
    fn bounds_us(&self, local_us: u64) -> [i64; 2] {
        let drifted_us =
            drifted_us(along(self.at_us, local_us).saturating_abs(), DRIFT_MAX_PPB).saturating_add(1);
        let [high_us, low_us] = self.bounds_us;
        [high_us.saturating_add(drifted_us), low_us.saturating_sub(drifted_us)]
    }

    /// The most that the output can be wrong.
    pub(super) fn hard_us(&self, local_us: u64) -> i64 {
        let [high_us, low_us] = self.bounds_us(local_us);
        let told_us = self.output.offset_us(local_us);
        high_us.saturating_sub(told_us).max(told_us.saturating_sub(low_us)).max(0).saturating_add(1)
    }

    /// The most that the output is likely to be wrong.
    pub(super) fn uncertainty_us(&self, local_us: u64) -> i64 {
        let unsure_us = self.unsure_us(local_us);
        let likely_us = whole(libm::sqrtf(unsure_us * unsure_us + POLL_US * POLL_US)).saturating_add(1);
        likely_us.saturating_add(self.output.rest_us(local_us).saturating_abs()).min(self.hard_us(local_us))
    }

    /// True if an exchange is so much better than the ones before that it cannot have been on the same clock.
    pub(super) fn is_surprised_by(&self, sights: &Block) -> bool {
        let drifted = |sight: &Sight| drifted_us(along(self.at_us, sight.at_us), self.drift_ppb);
        let (forward, backward) = (&sights.forward, &sights.backward);
        let [high_us, low_us] = self.edges_us;
        let below_us = high_us.saturating_add(drifted(forward)).saturating_sub(forward.offset_us);
        let above_us = backward.offset_us.saturating_sub(low_us.saturating_add(drifted(backward)));
        micros(below_us.max(above_us)) > SURPRISE * self.unsure_us(backward.at_us) + SURPRISE_US
    }
}

/// Between two bounds.
pub(super) fn middle_us([high_us, low_us]: [i64; 2]) -> i64 {
    low_us.saturating_add(high_us.saturating_sub(low_us) >> 1)
}
