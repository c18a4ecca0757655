//! The fleet time that the clock gives out: a line, and on the way to it a line that is up to 500 ppm steeper or flatter.
//!
//! ```text
//! fleet(local) = local + offset + rate·age + sgn(rest)·min(500 ppm·age, |rest|),   age = local − from ≥ 0
//! ```
//!
//! One sum is rounded down, in units of 2⁻³² µs, so that no two roundings can meet and turn the time back by 1 µs.
//!
//! The time is asked some times a tick, on processors that multiply 64 bits in several steps and check them in many. None
//! of the products needs a check: |age| ≤ 2⁴⁰ µs, rates are below 2²²·2⁻³² (1000 ppm) and |rest| ≤ 2²⁹ µs, so that all stay
//! below 2⁶², and their sums below 2⁶³.

use super::estimate::DRIFT_MAX_PPB;
use super::exact::{along, ppb_q32};

/// The most that is slewed, beyond the drift: 500 ppm. *Assumed*, as adjtime(3) does.
pub(super) const SLEW_PPB: i32 = 500_000;

const SLEW_Q32: i64 = ppb_q32(SLEW_PPB);

/// The longest rest, nine minutes: to slew it would take twelve days.
const REST_MAX_US: i64 = 1 << 29;

/// The line of fleet time over own time that the clock gives out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output {
    from_us: u64,
    offset_us: i64,
    rate_q32: i64,
    rest_us: i64,
}

impl Output {
    /// On the line through `offset_us` at `at_us` at once.
    pub(super) fn at_once(at_us: u64, offset_us: i64, drift_ppb: i32) -> Self {
        Self { from_us: at_us, offset_us, rate_q32: rate_q32(drift_ppb), rest_us: 0 }
    }

    /// From where it is at `at_us` towards that line.
    pub(super) fn slewed(&self, at_us: u64, offset_us: i64, drift_ppb: i32) -> Self {
        let told_us = self.offset_us(at_us);
        let rest_us = offset_us.saturating_sub(told_us).clamp(-REST_MAX_US, REST_MAX_US);
        Self { from_us: at_us, offset_us: told_us, rate_q32: rate_q32(drift_ppb), rest_us }
    }

    /// Fleet clock less own clock, as told at `local_us`.
    pub(super) fn offset_us(&self, local_us: u64) -> i64 {
        let age_us = along(self.from_us, local_us);
        let drifted_q32 = age_us.wrapping_mul(self.rate_q32);
        self.offset_us.saturating_add(drifted_q32.wrapping_add(self.slewed_q32(age_us)) >> 32)
    }

    /// What is still to be slewed at `local_us`.
    pub(super) fn rest_us(&self, local_us: u64) -> i64 {
        self.rest_us.saturating_sub(self.slewed_q32(along(self.from_us, local_us)) >> 32)
    }

    fn slewed_q32(&self, age_us: i64) -> i64 {
        if self.rest_us == 0 {
            return 0;
        }
        let most_q32 = age_us.max(0).wrapping_mul(SLEW_Q32);
        self.rest_us.wrapping_mul(1 << 32).clamp(most_q32.saturating_neg(), most_q32)
    }
}

/// The drift as a multiple of 2⁻³².
fn rate_q32(drift_ppb: i32) -> i64 {
    ppb_q32(drift_ppb.clamp(-DRIFT_MAX_PPB, DRIFT_MAX_PPB))
}
