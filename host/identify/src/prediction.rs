//! What constants foretell: motion over the next [`HORIZON_S`] from tail angles alone, beside the one that was measured.
//!
//! From a state that the filter has, poses are predicted on with no fix taken in. Velocity is the way over one period of the tails,
//! divided by it, so that neither noise nor the wobble of a stroke counts: east and north turned into S, and the turn.

use serde::Serialize;

use super::binning::BIN_S;
use super::constants::{Layout, Values};
use super::filter::{Motion, State, errors};
use super::log::Prepared;
use super::model::Swimming;

/// How far ahead, s.
pub const HORIZON_S: f64 = 20.0;
/// Pause between two starts, s.
const EVERY_S: f64 = 5.0;

/// Velocities over one period: sway and surge, m/s, yaw, rad/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Foretold {
    /// Middle of the period, s.
    pub t_s: f64,
    /// As measured.
    pub measured: [f64; 3],
    /// As predicted.
    pub predicted: [f64; 3],
    /// From which start, from 0.
    pub start: usize,
}

/// Predictions over the bins from `from` on of one log.
pub(crate) fn foretold(
    prepared: &Prepared,
    theta: &[f64],
    layout: Layout,
    log: usize,
    from: usize,
    period_s: f64,
) -> Vec<Foretold> {
    let values = Values::new(theta, layout, log);
    let instants = prepared.instants(values.latency_s);
    let bins = &prepared.bins;
    let mut states: Vec<Option<State>> = vec![None; bins.len()];
    let mut keep = |index: usize, state: &State| states[index] = Some(*state);
    let impulses = prepared.impulses(&values, &instants);
    let motion = Swimming { values: &values, impulses: &impulses };
    errors(bins, &motion, &mut keep);
    let (window, stride, horizon) =
        (whole(period_s / BIN_S), whole(EVERY_S / BIN_S), whole(HORIZON_S / BIN_S));
    let mut found = Vec::new();
    for (number, begin) in (from..bins.len().saturating_sub(horizon)).step_by(stride).enumerate() {
        let span = &bins[begin..=begin + horizon];
        if span.iter().skip(1).any(|bin| bin.begins) {
            continue;
        }
        let Some(mut state) = states[begin] else { continue };
        let mut poses = vec![[state[0], state[1], state[2]]];
        for index in begin + 1..=begin + horizon {
            let span_s = bins[index].t_s - bins[index - 1].t_s;
            state = motion.step(&state, None, motion.halves(index, span_s), span_s);
            poses.push([state[0], state[1], state[2]]);
        }
        for low in (0..horizon - window).step_by(window) {
            let high = low + window;
            let span_s = span[high].t_s - span[low].t_s;
            let rate = |a: [f64; 3], b: [f64; 3]| {
                let way = [0, 1, 2].map(|axis| (b[axis] - a[axis]) / span_s);
                let (sin, cos) = (0.5 * (span[low].pose[2] + span[high].pose[2])).sin_cos();
                [sin * way[0] - cos * way[1], cos * way[0] + sin * way[1], way[2]]
            };
            found.push(Foretold {
                t_s: 0.5 * (span[low].t_s + span[high].t_s),
                measured: rate(span[low].pose, span[high].pose),
                predicted: rate(poses[low], poses[high]),
                start: number,
            });
        }
    }
    found
}

fn whole(count: f64) -> usize {
    count.round().max(1.0) as usize
}

/// How well the future was foretold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Prediction {
    /// Data that constants were not fitted to, s.
    pub held_back_s: f64,
    /// Predictions that were made.
    pub starts: usize,
    /// Root mean square of the velocity that was measured there, m/s.
    pub speed_rms_m_s: f64,
    /// That of its error, m/s.
    pub velocity_error_rms_m_s: f64,
    /// The second over the first.
    pub velocity_error: f64,
    /// Root mean square of the yaw rate that was measured, rad/s.
    pub yaw_rate_rms_rad_s: f64,
    /// That of its error, rad/s.
    pub yaw_rate_error_rms_rad_s: f64,
}

impl Prediction {
    /// Of these.
    pub(crate) fn of(foretold: &[Foretold], held_back_s: f64) -> Self {
        let count = foretold.len().max(1) as f64;
        let mean = |of: &dyn Fn(&Foretold) -> f64| (foretold.iter().map(of).sum::<f64>() / count).sqrt();
        let speed = mean(&|f| f.measured[0].powi(2) + f.measured[1].powi(2));
        let error =
            mean(&|f| (f.measured[0] - f.predicted[0]).powi(2) + (f.measured[1] - f.predicted[1]).powi(2));
        let mut starts: Vec<usize> = foretold.iter().map(|f| f.start).collect();
        starts.dedup();
        Self {
            held_back_s,
            starts: starts.len(),
            speed_rms_m_s: speed,
            velocity_error_rms_m_s: error,
            velocity_error: if speed > 0.0 { error / speed } else { 0.0 },
            yaw_rate_rms_rad_s: mean(&|f| f.measured[2].powi(2)),
            yaw_rate_error_rms_rad_s: mean(&|f| (f.measured[2] - f.predicted[2]).powi(2)),
        }
    }
}
