//! The mean pose over a span of time, from poses that come at any times.

use std::collections::VecDeque;

use quantity::wrap_rad;

use crate::observer::Fix;

/// Poses are kept for so many periods.
const PERIODS: f64 = 4.0;
/// A span with a longer gap has no mean, as a share of the period. *Assumed*: the wobble is followed well enough between two poses.
const GAP: f64 = 0.15;

/// Poses of the last periods.
#[derive(Clone, Debug)]
pub(super) struct Means {
    period_s: f64,
    /// (t, x, y, Θ), s, m and rad, Θ unwrapped.
    poses: VecDeque<[f64; 4]>,
}

impl Means {
    pub(super) fn new(period_s: f64) -> Self {
        Self { period_s, poses: VecDeque::new() }
    }

    /// Takes a fix; one from the past, or that is no number, is ignored.
    pub(super) fn update(&mut self, fix: &Fix) {
        let Fix { t_s, position_m: [x_m, y_m], heading_rad } = *fix;
        if ![t_s, x_m, y_m, heading_rad].iter().all(|value| value.is_finite()) || t_s <= self.newest_s() {
            return;
        }
        let before_rad = self.poses.back().map_or(heading_rad, |last| last[3]);
        self.poses.push_back([t_s, x_m, y_m, before_rad + wrap_rad(heading_rad - before_rad)]);
        while self.poses.front().is_some_and(|first| first[0] < t_s - PERIODS * self.period_s) {
            self.poses.pop_front();
        }
    }

    /// When the newest pose was true, s.
    pub(super) fn newest_s(&self) -> f64 {
        self.poses.back().map_or(f64::NEG_INFINITY, |last| last[0])
    }

    /// Mean of (x, y, Θ) from `from_s` to `to_s`, straight between poses. `None` where there is a gap.
    pub(super) fn over(&self, from_s: f64, to_s: f64) -> Option<[f64; 3]> {
        let (mut sum, mut covered_s) = ([0.0; 3], 0.0);
        for (one, other) in self.poses.iter().zip(self.poses.iter().skip(1)) {
            let (start_s, end_s) = (one[0].max(from_s), other[0].min(to_s));
            if end_s <= start_s {
                continue;
            }
            let span_s = other[0] - one[0];
            if span_s > GAP * self.period_s {
                return None;
            }
            let share = (0.5 * (start_s + end_s) - one[0]) / span_s;
            for (axis, sum) in sum.iter_mut().enumerate() {
                let [before, after] = [one[axis + 1], other[axis + 1]];
                *sum += (end_s - start_s) * (before + share * (after - before));
            }
            covered_s += end_s - start_s;
        }
        (covered_s > (to_s - from_s) * (1.0 - 1e-6)).then(|| sum.map(|sum| sum / covered_s))
    }
}
