//! The extended Kalman filter over one log: what each measured coordinate adds to the likelihood of θ.
//!
//! Every bin has three coordinates, taken in one after the other. Of each the filter predicts the mean and the variance s; e is what was
//! measured less the mean. Given θ, log-likelihood is −½ Σ (ln s + e²/s).

use super::constants::{Layout, Values};
use super::log::{Impulse, PER_BIN, Prepared};
use super::model::{Square, State, step};
use super::strokes::Instant;

/// Longest step of the prediction, s.
const STEP_MAX_S: f64 = 0.06;
/// Where a stretch of poses begins: deviation of each velocity, m/s and rad/s. *Assumed*.
const BEGINS_M_S: f64 = 0.05;
const BEGINS_RAD_S: f64 = 0.1;

/// A prediction error and its variance, for each coordinate in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Errors {
    pub e: Vec<f64>,
    pub s: Vec<f64>,
}

impl Errors {
    /// Twice the negative log-likelihood, less its constant.
    pub(crate) fn cost(&self) -> f64 {
        self.e.iter().zip(&self.s).map(|(e, s)| s.ln() + e * e / s).sum()
    }
}

/// What is wanted besides.
pub(crate) trait Watch {
    /// The state after bin `index` was taken in.
    fn filtered(&mut self, index: usize, state: &State);
}

impl Watch for () {
    fn filtered(&mut self, _: usize, _: &State) {}
}

impl<F: FnMut(usize, &State)> Watch for F {
    fn filtered(&mut self, index: usize, state: &State) {
        self(index, state);
    }
}

/// Runs the filter over the first `bins` of a log, of which the tails stood as in `instants`.
pub(crate) fn errors(
    prepared: &Prepared,
    instants: &[Vec<Instant>],
    theta: &[f64],
    layout: Layout,
    log: usize,
    bins: usize,
    watch: &mut impl Watch,
) -> Errors {
    let values = Values::new(theta, layout, log);
    let impulses = prepared.impulses(&values, instants);
    let noise = [values.position_noise_m, values.position_noise_m, values.heading_noise_rad];
    let mut found = Errors::default();
    let (mut state, mut covariance) = (State::zeros(), Square::zeros());
    let mut before: Option<usize> = None;
    for (index, bin) in prepared.bins.iter().take(bins).enumerate() {
        let variance = noise.map(|deviation| deviation * deviation / bin.count);
        let Some(last) = before.replace(index).filter(|_| !bin.begins) else {
            state = begin(&values, bin.pose);
            covariance = Square::zeros();
            let speed = BEGINS_M_S * BEGINS_M_S;
            let gust = values.gust_m_s.powi(2);
            for (at, value) in
                [variance[0], variance[1], variance[2], speed, speed, BEGINS_RAD_S.powi(2), gust, gust]
                    .into_iter()
                    .enumerate()
            {
                covariance[(at, at)] = value;
            }
            watch.filtered(index, &state);
            continue;
        };
        let span_s = bin.t_s - prepared.bins[last].t_s;
        debug_assert_eq!(last + 1, index);
        let halves = forces(&impulses, index, span_s);
        let parts = (span_s / STEP_MAX_S).ceil().max(1.0) as usize;
        for part in 0..parts {
            // Of a longer pause the first half of its parts has the first half's mean.
            let both = if parts == 1 { halves } else { [halves[2 * part / parts]; 2] };
            state = step(&values, &state, Some(&mut covariance), both, span_s / parts as f64);
        }
        for axis in 0..3 {
            let e = bin.pose[axis] - state[axis];
            let s = covariance[(axis, axis)] + variance[axis];
            let column = covariance.column(axis).into_owned();
            state += column * (e / s);
            covariance -= column * column.transpose() / s;
            found.e.push(e);
            found.s.push(s);
        }
        watch.filtered(index, &state);
    }
    found
}

/// Mean forces over the two halves of the time to bin `index`, which is `span_s` long.
pub(crate) fn forces(impulses: &[Impulse], index: usize, span_s: f64) -> [[f64; 3]; 2] {
    let at = PER_BIN * index;
    let [before, half, now] = [impulses[at - 1], impulses[at], impulses[at + 1]];
    let mean = |from: Impulse, to: Impulse| [0, 1, 2].map(|axis| 2.0 * (to[axis] - from[axis]) / span_s);
    [mean(before, half), mean(half, now)]
}

/// At rest over ground.
pub(crate) fn begin(values: &Values, pose: [f64; 3]) -> State {
    let (sin, cos) = pose[2].sin_cos();
    let [east, north] = values.current_m_s;
    let mut state = State::zeros();
    (state[0], state[1], state[2]) = (pose[0], pose[1], pose[2]);
    (state[3], state[4]) = (-(sin * east - cos * north), -(cos * east + sin * north));
    state
}
