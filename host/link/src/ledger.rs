//! Ledger of one module: what was sent to it and what came back.
//!
//! Datagrams are counted by [`protocol::ledger`], whose sums are exact. Here are the cycles that they carry, and how long
//! an answer takes.

use protocol::time::Duration;
use serde::Serialize;

/// Cycles of one module, as the host sees them. `cycles = acknowledged + late + refused + unanswered`, plus one while
/// a cycle is still open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Ledger {
    /// Cycles dispatched to it.
    pub cycles: u64,
    /// Times a cycle or its commit was sent again.
    pub resent: u64,
    /// Cycles it took.
    pub acknowledged: u64,
    /// Cycles that came after their start: it refused them for that.
    pub late: u64,
    /// Cycles it refused for another reason.
    pub refused: u64,
    /// Cycles without an answer when they started (an ROV's: when their lease ended) or a newer one took their place; also
    /// those that were prepared, and not committed because another module was not.
    pub unanswered: u64,
}

impl Ledger {
    /// Cycles whose fate is not decided yet.
    #[must_use]
    pub fn open(&self) -> u64 {
        self.cycles - self.acknowledged - self.late - self.refused - self.unanswered
    }
}

/// Durations by size: each bucket is a fifth longer than the one before, from 50 µs to some minutes.
#[derive(Clone, Debug)]
pub struct Durations {
    buckets: [u32; Self::BUCKETS],
    count: u64,
    max_us: u32,
}

impl Default for Durations {
    fn default() -> Self {
        Self { buckets: [0; Self::BUCKETS], count: 0, max_us: 0 }
    }
}

/// Some quantiles of durations, ms; each at most a fifth too large.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// How many durations there are.
    pub count: u64,
    /// Half are no longer.
    pub p50_ms: f64,
    /// Nine of ten are no longer.
    pub p90_ms: f64,
    /// 99 of 100 are no longer.
    pub p99_ms: f64,
    /// The longest, exactly.
    pub max_ms: f64,
}

impl Durations {
    const BUCKETS: usize = 84;
    const LEAST_US: f64 = 50.0;
    const GROWTH: f64 = 1.2;

    /// Adds one.
    pub fn add(&mut self, duration: Duration) {
        let ratio = f64::from(duration.0) / Self::LEAST_US;
        let bucket = ratio.max(1.0).log(Self::GROWTH).ceil() as usize;
        self.buckets[bucket.min(Self::BUCKETS - 1)] += 1;
        self.count += 1;
        self.max_us = self.max_us.max(duration.0);
    }

    /// Their quantiles.
    #[must_use]
    pub fn quantiles(&self) -> Quantiles {
        let max_ms = f64::from(self.max_us) * 1e-3;
        let quantile = |share: f64| {
            let wanted = (share * self.count as f64).ceil() as u64;
            let mut seen = 0;
            let bucket = self.buckets.iter().position(|&count| {
                seen += u64::from(count);
                seen >= wanted.max(1)
            });
            let upper = |bucket| 1e-3 * Self::LEAST_US * Self::GROWTH.powi(bucket as i32);
            bucket.map_or(0.0, |bucket| upper(bucket).min(max_ms))
        };
        let [p50_ms, p90_ms, p99_ms] = [0.5, 0.9, 0.99].map(quantile);
        Quantiles { count: self.count, p50_ms, p90_ms, p99_ms, max_ms }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_a_fifth() {
        assert_eq!(Durations::default().quantiles(), Quantiles::default());
        let mut durations = Durations::default();
        for ms in 1..=1000 {
            durations.add(Duration(ms * 1000));
        }
        let quantiles = durations.quantiles();
        assert_eq!(quantiles.count, 1000);
        for (got, exact) in [
            (quantiles.p50_ms, 500.0),
            (quantiles.p90_ms, 900.0),
            (quantiles.p99_ms, 990.0),
            (quantiles.max_ms, 1000.0),
        ] {
            assert!((exact..=1.2 * exact).contains(&got), "{got} for {exact}");
        }
        durations.add(Duration(u32::MAX));
        durations.add(Duration(0));
        assert!((durations.quantiles().max_ms - 4_294_967.295).abs() < 1e-6);
    }
}
