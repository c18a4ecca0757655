//! Instants on the two clocks of a motion capture: the host's and the server's.
//!
//! Both are whole nanoseconds, so that a frame's time survives every conversion. The host's clock starts with the program and never
//! jumps. The server's starts wherever its maker chose (boot, start of capture, 1970) and may jump; [`crate::clock`] maps one to the
//! other.

use std::time::Duration;

/// Nanoseconds in a second.
const NANOS: f64 = 1e9;

/// An instant on the host's monotonic clock, from the program's start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct HostInstant(pub Duration);

impl HostInstant {
    /// Seconds from the program's start.
    pub fn seconds(self) -> f64 {
        self.0.as_secs_f64()
    }

    /// From seconds; what is negative or no number counts as zero.
    pub fn from_seconds(seconds: f64) -> Self {
        Self(Duration::try_from_secs_f64(seconds).unwrap_or_default())
    }

    /// The instant `later` after this one.
    pub fn after(self, later: Duration) -> Self {
        Self(self.0.saturating_add(later))
    }

    /// How long ago `earlier` was; zero if it lies ahead.
    pub fn since(self, earlier: Self) -> Duration {
        self.0.saturating_sub(earlier.0)
    }
}

/// An instant on the server's clock, ns from its own zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct ServerInstant(pub i64);

impl ServerInstant {
    /// Seconds from the clock's zero.
    #[expect(clippy::cast_precision_loss, reason = "a microsecond is lost after 100 days in seconds")]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / NANOS
    }

    /// From seconds, to the nearest nanosecond.
    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds * NANOS).round() as i64)
    }

    /// Seconds from `earlier` to this instant, of either sign.
    #[expect(clippy::cast_precision_loss, reason = "differences of instants are small")]
    pub fn seconds_since(self, earlier: Self) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 / NANOS
    }

    /// From ticks of a clock with `frequency_hz` ticks a second, rounded down; the largest instant if it does not fit.
    pub fn from_ticks(ticks: u64, frequency_hz: u64) -> Self {
        let nanos = u128::from(ticks) * 1_000_000_000 / u128::from(frequency_hz.max(1));
        Self(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    /// Ticks of a clock with `frequency_hz` ticks a second, rounded to the nearest; zero for instants before the clock's zero.
    pub fn ticks(self, frequency_hz: u64) -> u64 {
        let nanos = u128::try_from(self.0).unwrap_or_default();
        u64::try_from((nanos * u128::from(frequency_hz) + 500_000_000) / 1_000_000_000).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_ten_megahertz_are_hundreds_of_nanoseconds() {
        let instant = ServerInstant(1_416_497_730_518 * 100);
        assert_eq!(instant.ticks(10_000_000), 1_416_497_730_518);
        assert_eq!(ServerInstant::from_ticks(1_416_497_730_518, 10_000_000), instant);
    }

    #[test]
    fn extreme_ticks_and_frequencies_do_not_overflow() {
        assert_eq!(ServerInstant::from_ticks(u64::MAX, 0), ServerInstant(i64::MAX));
        assert_eq!(ServerInstant::from_ticks(u64::MAX, u64::MAX), ServerInstant(1_000_000_000));
        assert_eq!(ServerInstant(-5).ticks(u64::MAX), 0);
        assert_eq!(ServerInstant(i64::MAX).ticks(u64::MAX), u64::MAX);
    }
}
