//! What constants foretell of swims that they were not fitted to: motion over the next [`HORIZON_S`] from thrusts alone.

use super::super::binning::BIN_S;
use super::super::filter::{Motion, State, errors};
use super::constants::{DELAY_UNIT, Layout, Values};
use super::data::Prepared;
use super::model::Swimming;
use super::outcome::{Foretold, Prediction};

/// How far ahead, s. *Assumed*: a swim from slot to slot is hardly ever longer than a few times that.
pub(crate) const HORIZON_S: f64 = 5.0;
/// Pause between two starts, s.
const EVERY_S: f64 = 2.0;
/// Velocities are ways over this time, divided by it, s.
const WINDOW_S: f64 = 1.0;

/// Predictions over the bins from `from` on of one log; starts are counted from `number`.
pub(crate) fn foretold(
    prepared: &Prepared,
    columns: &[[f64; 4]],
    theta: &[f64],
    layout: Layout,
    log: usize,
    from: usize,
    number: usize,
) -> Vec<Foretold> {
    let values = Values::new(theta, layout, log);
    let halves_n = prepared.halves(layout.thrusters, DELAY_UNIT * theta[layout.delay(log)]);
    let motion = Swimming { values: &values, columns, halves_n: &halves_n, tilts: &prepared.tilts };
    let bins = &prepared.bins;
    let mut states: Vec<Option<State>> = vec![None; bins.len()];
    errors(bins, &motion, &mut |index: usize, state: &State| states[index] = Some(*state));
    let whole = |span_s: f64| (span_s / BIN_S).round() as usize;
    let (window, horizon) = (whole(WINDOW_S), whole(HORIZON_S));
    let mut found = Vec::new();
    let mut starts = number;
    for begin in (from..bins.len().saturating_sub(horizon)).step_by(whole(EVERY_S)) {
        let span = &bins[begin..=begin + horizon];
        let Some(mut state) = states[begin].filter(|_| !span.iter().skip(1).any(|bin| bin.begins)) else {
            continue;
        };
        let mut poses = vec![[state[0], state[1], state[2], state[3]]];
        for index in begin + 1..=begin + horizon {
            let span_s = bins[index].t_s - bins[index - 1].t_s;
            state = motion.step(&state, None, motion.halves(index, span_s), span_s);
            poses.push([state[0], state[1], state[2], state[3]]);
        }
        for low in (0..=horizon - window).step_by(window) {
            let high = low + window;
            let span_s = span[high].t_s - span[low].t_s;
            let rate = |a: [f64; 4], b: [f64; 4]| {
                let [n, e, d, r] = [0, 1, 2, 3].map(|axis| (b[axis] - a[axis]) / span_s);
                let (sin, cos) = (0.5 * (span[low].pose[3] + span[high].pose[3])).sin_cos();
                [cos * n + sin * e, cos * e - sin * n, d, r]
            };
            found.push(Foretold {
                t_s: 0.5 * (span[low].t_s + span[high].t_s),
                measured: rate(span[low].pose, span[high].pose),
                predicted: rate(poses[low], poses[high]),
                start: starts,
            });
        }
        starts += 1;
    }
    found
}

impl Prediction {
    pub(crate) fn of(foretold: &[Foretold], held_back_s: f64) -> Self {
        let count = foretold.len().max(1) as f64;
        let mean = |of: &dyn Fn(&Foretold) -> f64| (foretold.iter().map(of).sum::<f64>() / count).sqrt();
        let squares = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>();
        let speed = mean(&|f| squares([f.measured[0], f.measured[1], f.measured[2]]));
        let error = mean(&|f| squares([0, 1, 2].map(|axis| f.measured[axis] - f.predicted[axis])));
        let mut starts: Vec<usize> = foretold.iter().map(|f| f.start).collect();
        starts.dedup();
        Self {
            horizon_s: HORIZON_S,
            held_back_s,
            starts: starts.len(),
            speed_rms_m_s: speed,
            velocity_error_rms_m_s: error,
            velocity_error: (speed > 0.0).then(|| error / speed),
            yaw_rate_rms_rad_s: mean(&|f| f.measured[3].powi(2)),
            yaw_rate_error_rms_rad_s: mean(&|f| (f.measured[3] - f.predicted[3]).powi(2)),
        }
    }
}
