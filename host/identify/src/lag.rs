//! How late tails follow their plans.
//!
//! Of each cycle that a module swam, φ_planned(t) = φ₀ + A·cos(2π(t − t₀)/T), and what it reported: the delay that fits best is
//!
//! ```text
//! h = −Σ φ̇_planned·(φ − φ_planned) / Σ φ̇_planned²                                                  (i12)
//! ```
//!
//! to first order in h, twice over. The mean over cycles is told, with its standard error from their spread. Motor, servo and the module's
//! clock are all in it.

use std::f64::consts::TAU;

use super::data::Recording;

/// A delay longer than this is no lag of a motor: the module did not swim that cycle, s.
const LAG_MAX_S: f64 = 0.2;

/// Mean lag and its standard error, s; `None` with fewer than three cycles.
#[must_use]
pub(crate) fn lag(recordings: &[Recording], place: usize) -> Option<(f64, f64)> {
    let cycles = || recordings.iter().flat_map(|log| log.cycles.iter().map(move |cycle| (log, cycle)));
    let lags: Vec<f64> = cycles()
        .filter_map(|(log, cycle)| {
            let swing = cycle.swings.get(place).filter(|swing| swing.amplitude_rad != 0.0)?;
            let from = log.tails.partition_point(|tails| tails.t_s < cycle.start_s);
            let to = log.tails.partition_point(|tails| tails.t_s <= cycle.start_s + cycle.period_s);
            let reports = log.tails.get(from..to).filter(|reports| reports.len() > 8)?;
            let omega = TAU / cycle.period_s;
            let mut lag_s = 0.0;
            for _ in 0..2 {
                let (mut by, mut square) = (0.0, 0.0);
                for report in reports {
                    let phase = omega * (report.t_s - cycle.start_s - lag_s);
                    // Before its start the tail rests where the cycle begins.
                    let (sin, cos) = phase.max(0.0).sin_cos();
                    let planned_rad = swing.centerline_rad + swing.amplitude_rad * cos;
                    let rate_rad_s = -swing.amplitude_rad * omega * sin;
                    let turns = TAU * ((report.angle_rad.get(place)? - planned_rad) / TAU).round();
                    let off_rad = report.angle_rad.get(place)? - turns - planned_rad;
                    by -= rate_rad_s * off_rad;
                    square += rate_rad_s * rate_rad_s;
                }
                lag_s += by / square.max(1e-9);
            }
            Some(lag_s).filter(|lag_s| lag_s.abs() < LAG_MAX_S)
        })
        .collect();
    let count = lags.len() as f64;
    if lags.len() < 3 {
        return None;
    }
    let mean_s = lags.iter().sum::<f64>() / count;
    let spread = lags.iter().map(|lag_s| (lag_s - mean_s).powi(2)).sum::<f64>() / (count - 1.0);
    Some((mean_s, (spread / count).sqrt()))
}

#[cfg(test)]
mod tests {
    use modboat::motion::Swing;

    use super::super::data::{Cycle, Tails};
    use super::*;

    #[test]
    fn a_delayed_waveform_is_as_late_as_it_is() {
        for late_s in [0.0, 0.013, 0.06] {
            let swing = Swing { centerline_rad: 7.0, amplitude_rad: -1.7 };
            let cycle = |start_s| Cycle { start_s, period_s: 1.5, swings: vec![swing] };
            let tails = (0..400).map(|step| {
                let t_s = f64::from(step) * 0.02;
                let phase = TAU / 1.5 * (t_s - late_s).max(0.0);
                // As a module counts: from −π to π.
                let angle = 7.0 - TAU - 1.7 * phase.cos();
                Tails { t_s, angle_rad: vec![angle], rate_rad_s: vec![0.0] }
            });
            let log = Recording {
                tails: tails.collect(),
                cycles: [0.0, 1.5, 3.0, 4.5].map(cycle).to_vec(),
                ..Recording::default()
            };
            let (lag_s, error_s) = lag(&[log], 0).expect("four cycles");
            assert!((lag_s - late_s).abs() < 1e-3 && error_s < 1e-3, "{lag_s} for {late_s}");
        }
        assert_eq!(lag(&[Recording::default()], 0), None);
    }
}
