//! A remote tail: its angle between the reports that come over the radio.
//!
//! Shown [`DELAY`] late, so that two reports usually stand around the instant asked for; between them the angle
//! is the cubic that has both angles and both rates. Later than the last report it rests where that left it.

use std::collections::VecDeque;

use protocol::Telemetry;
use protocol::time::{Duration, FleetInstant};

use super::TailState;

/// How late the water feels a remote tail: three reports at 100 Hz.
pub const DELAY: Duration = Duration(30_000);

#[derive(Clone, Copy, Debug)]
struct Report {
    at: FleetInstant,
    angle_rad: f64,
    rate_rad_s: f64,
}

/// One remote tail.
#[derive(Clone, Debug)]
pub struct RemoteTail {
    inertia_kg_m2: f64,
    reports: VecDeque<Report>,
    /// Reports of before are not joined to later ones.
    forgotten: FleetInstant,
}

impl RemoteTail {
    /// A tail with the given moment of inertia, not heard of yet.
    #[must_use]
    pub fn new(inertia_kg_m2: f64) -> Self {
        Self { inertia_kg_m2, reports: VecDeque::new(), forgotten: FleetInstant(0) }
    }

    /// Nothing was heard until `now`: it is not known how the tail came to where the next report finds it.
    pub fn forget(&mut self, now: FleetInstant) {
        self.forgotten = now;
    }

    /// Takes in a report. Its own time counts; that of its arrival stands in while the module has no fleet time.
    pub fn report(&mut self, telemetry: &Telemetry, arrival: FleetInstant) {
        let at = if telemetry.at == FleetInstant(0) { arrival } else { telemetry.at };
        if self.reports.back().is_some_and(|last| at <= last.at) {
            return;
        }
        if self.reports.back().is_some_and(|last| last.at < self.forgotten) {
            self.reports.clear();
        }
        let (angle_rad, rate_rad_s) = (f64::from(telemetry.tail.0), f64::from(telemetry.rate.0));
        self.reports.push_back(Report { at, angle_rad, rate_rad_s });
        if self.reports.len() > 32 {
            self.reports.pop_front();
        }
    }

    /// The tail at `now` less [`DELAY`].
    #[must_use]
    pub fn state(&mut self, now: FleetInstant) -> TailState {
        let at = FleetInstant(now.0.saturating_sub(u64::from(DELAY.0)));
        while self.reports.get(1).is_some_and(|second| second.at <= at) {
            self.reports.pop_front();
        }
        let at_rest =
            |angle_rad| TailState { angle_rad, inertia_kg_m2: self.inertia_kg_m2, ..TailState::default() };
        match (self.reports.front(), self.reports.get(1)) {
            (Some(before), Some(after)) if before.at <= at => {
                let span_s = after.at.as_secs_f64() - before.at.as_secs_f64();
                let s = (at.as_secs_f64() - before.at.as_secs_f64()) / span_s;
                // Cubic Hermite: h(s) = φ₀ + s·m₀ + s²(3Δ − 2m₀ − m₁) + s³(m₀ + m₁ − 2Δ), m = rate·span
                let delta = after.angle_rad - before.angle_rad;
                let (m0, m1) = (before.rate_rad_s * span_s, after.rate_rad_s * span_s);
                let (c2, c3) = (3.0 * delta - 2.0 * m0 - m1, m0 + m1 - 2.0 * delta);
                TailState {
                    angle_rad: before.angle_rad + s * (m0 + s * (c2 + s * c3)),
                    rate_rad_s: (m0 + s * (2.0 * c2 + s * 3.0 * c3)) / span_s,
                    acceleration_rad_s2: (2.0 * c2 + 6.0 * s * c3) / (span_s * span_s),
                    inertia_kg_m2: self.inertia_kg_m2,
                }
            }
            (Some(only), _) => at_rest(only.angle_rad),
            (None, _) => at_rest(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use protocol::units::{Amperes, Radians, RadiansPerSecond, Volts};
    use protocol::{Faults, ModuleState};

    use super::*;

    fn report(at_us: u64, tail: f64, rate: f64) -> Telemetry {
        Telemetry {
            at: FleetInstant(at_us),
            state: ModuleState::Executing,
            cycle: 1,
            tail: Radians(tail as f32),
            rate: RadiansPerSecond(rate as f32),
            current: Amperes(0.0),
            battery: Volts(7.4),
            faults: Faults::default(),
        }
    }

    /// Two reports beside a gap are two angles, and no motion between them; what came from before it was read late.
    #[test]
    fn nothing_is_drawn_through_a_gap() {
        let mut tail = RemoteTail::new(1e-4);
        for ms in [100, 110, 120] {
            tail.report(&report(ms * 1000, 1.0, 4.0), FleetInstant(ms * 1000));
        }
        let gap_ends = FleetInstant(15_000_000);
        tail.forget(gap_ends);
        tail.report(&report(700_000, 1.5, 4.0), gap_ends);
        tail.report(&report(15_010_000, -2.0, 0.0), FleetInstant(15_011_000));
        for ms in 15_011..15_100 {
            let state = tail.state(FleetInstant(ms * 1000));
            assert!((state.angle_rad + 2.0).abs() < 1e-6 && state.rate_rad_s == 0.0, "{state:?} at {ms} ms");
        }
        // From there on it is followed as before.
        tail.report(&report(15_110_000, -1.9, 0.0), FleetInstant(15_111_000));
        let between_rad = tail.state(FleetInstant(15_090_000)).angle_rad;
        assert!((between_rad + 1.95).abs() < 1e-6, "{between_rad}");
    }

    #[test]
    fn follows_a_swing_between_reports_ten_milliseconds_apart() {
        let omega = std::f64::consts::TAU / 1.5;
        let truth = |t_s: f64| 2.6 * (omega * t_s).cos();
        let mut tail = RemoteTail::new(1e-4);
        let (mut worst_rad, mut worst_rad_s) = (0.0_f64, 0.0_f64);
        for ms in 1..1500_u64 {
            let t_s = ms as f64 * 1e-3;
            if ms % 10 == 1 {
                tail.report(
                    &report(ms * 1000, truth(t_s), -2.6 * omega * (omega * t_s).sin()),
                    FleetInstant(ms * 1000),
                );
            }
            let state = tail.state(FleetInstant(ms * 1000));
            if ms > 50 {
                let then_s = t_s - 0.03;
                worst_rad = worst_rad.max((state.angle_rad - truth(then_s)).abs());
                worst_rad_s =
                    worst_rad_s.max((state.rate_rad_s + 2.6 * omega * (omega * then_s).sin()).abs());
            }
        }
        assert!(worst_rad < 1e-4 && worst_rad_s < 0.01, "{worst_rad} rad, {worst_rad_s} rad/s");
    }

    #[test]
    fn rests_where_it_was_last_seen() {
        let mut tail = RemoteTail::new(1e-4);
        assert!(tail.state(FleetInstant(5)).angle_rad.abs() < 1e-12);
        tail.report(&report(1_000_000, 1.25, 9.0), FleetInstant(1_000_000));
        tail.report(&report(900_000, 7.0, 9.0), FleetInstant(1_000_001));
        let state = tail.state(FleetInstant(9_000_000));
        assert!((state.angle_rad - 1.25).abs() < 1e-12 && state.rate_rad_s == 0.0);
    }
}
