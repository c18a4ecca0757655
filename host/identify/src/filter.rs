//! The extended Kalman filter over one log: what each measured coordinate adds to the likelihood of θ.
//!
//! Coordinates of a bin are taken in one after the other. Of each the filter predicts the mean and the variance s; e is what was measured
//! less the mean. Given θ, log-likelihood is −½ Σ (ln s + e²/s).

use nalgebra::{SMatrix, SVector};

use super::binning::Bin;

/// The measured coordinates come first, whatever the vehicle.
pub(crate) type State = SVector<f64, 8>;
/// Covariance or transition of states.
pub(crate) type Square = SMatrix<f64, 8, 8>;

/// Longest step of the prediction, s.
const STEP_MAX_S: f64 = 0.06;

/// Motion under what a log says was done, of which N coordinates are measured.
pub(crate) trait Motion<const N: usize> {
    /// What pushes.
    type Force: Copy;

    /// The state where a stretch of poses begins.
    fn begin(&self, pose: [f64; N]) -> State;

    /// Deviation of each element of it; those of the measured ones are their noise.
    fn begins(&self) -> State;

    /// Deviation of a fix.
    fn noise(&self) -> [f64; N];

    /// Mean forces over the two halves of the time to bin `index`, which is `span_s` long.
    fn halves(&self, index: usize, span_s: f64) -> [Self::Force; 2];

    /// The state `dt_s` later, under the mean forces of each half of it; with a covariance, that goes along.
    fn step(
        &self,
        state: &State,
        covariance: Option<&mut Square>,
        halves: [Self::Force; 2],
        dt_s: f64,
    ) -> State;
}

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

/// Runs the filter over these bins.
pub(crate) fn errors<const N: usize, M: Motion<N>>(
    bins: &[Bin<N>],
    motion: &M,
    watch: &mut impl Watch,
) -> Errors {
    let noise = motion.noise();
    let mut found = Errors::default();
    let (mut state, mut covariance) = (State::zeros(), Square::zeros());
    let mut before: Option<usize> = None;
    for (index, bin) in bins.iter().enumerate() {
        let variance = noise.map(|deviation| deviation * deviation / bin.count);
        let Some(last) = before.replace(index).filter(|_| !bin.begins) else {
            state = motion.begin(bin.pose);
            covariance = Square::from_diagonal(&motion.begins().map(|deviation| deviation * deviation));
            for (axis, &variance) in variance.iter().enumerate() {
                covariance[(axis, axis)] = variance;
            }
            watch.filtered(index, &state);
            continue;
        };
        let span_s = bin.t_s - bins[last].t_s;
        debug_assert_eq!(last + 1, index);
        let halves = motion.halves(index, span_s);
        let parts = (span_s / STEP_MAX_S).ceil().max(1.0) as usize;
        for part in 0..parts {
            // Of a longer pause the first half of its parts has the first half's mean.
            let both = if parts == 1 { halves } else { [halves[2 * part / parts]; 2] };
            state = motion.step(&state, Some(&mut covariance), both, span_s / parts as f64);
        }
        for axis in 0..N {
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

/// A midpoint rule for each half; the covariance goes along, and grows by `fresh` (element, variance).
///
/// Strokes push for a few tenths of a second: one mean force over a bin of 40 ms would take a quarter of a percent off what they move.
pub(crate) fn propagate<F: Copy>(
    state: &State,
    covariance: Option<&mut Square>,
    halves: [F; 2],
    dt_s: f64,
    rates: impl Fn(&State, F) -> (State, Square),
    fresh: impl FnOnce() -> [(usize, f64); 5],
) -> State {
    let mut next = *state;
    let mut by = Square::zeros();
    for force in halves {
        let (first, _) = rates(&next, force);
        let (rate, along) = rates(&(next + first * (0.25 * dt_s)), force);
        next += rate * (0.5 * dt_s);
        by += along * 0.5;
    }
    if let Some(covariance) = covariance {
        // Φ = I + A·dt + ½(A·dt)²,   P ← Φ·P·Φᵀ + Q
        let small = by * dt_s;
        let transition = Square::identity() + small + small * small * 0.5;
        *covariance = transition * *covariance * transition.transpose();
        for (index, more) in fresh() {
            covariance[(index, index)] += more;
        }
    }
    next
}

/// q of (i7), the mean of r·|r| where r has this variance, and its derivative.
pub(crate) fn squared(r: f64, variance: f64) -> (f64, f64) {
    let root = (r * r + 2.0 * variance).sqrt().max(1e-12);
    (r * root, (2.0 * r * r + 2.0 * variance) / root)
}
