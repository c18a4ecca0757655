//! Maximum likelihood: Fisher scoring with a damped step over all of θ.
//!
//! ```text
//! ℓ(θ) = ½ Σ (ln s + e²/s) + ½ Σ ((θᵢ − θ̂ᵢ)/σᵢ)²                                                   (i8)
//! gᵢ   = Σ (½·∂ᵢs/s·(1 − e²/s) + e·∂ᵢe/s)                                                          (i9)
//! Fᵢⱼ  = Σ (∂ᵢe·∂ⱼe/s + ½·∂ᵢs·∂ⱼs/s²)                                                              (i10)
//! θ ← θ − (F + Σ⁻¹ + μ·diag)⁻¹·(g + Σ⁻¹(θ − θ̂))                                                    (i11)
//! ```
//!
//! s and e of the filter, derivatives by differences; θ̂ and σ of the prior; μ falls where a step succeeds and grows where it does not
//! (Levenberg, Marquardt). (i10) is the information of a Gaussian whose mean and variance both depend on θ.
//!
//! Disturbances are part of the filter, as gusts with memory and as white accelerations, so that its errors are white where the model
//! holds, and the estimate is consistent. Least squares on accelerations is not: with w disturbed, w|w| has another mean.

use nalgebra::{DMatrix, DVector};

use super::constants::{Layout, RATIO, ROTOR};
use super::filter::{Errors, errors};
use super::log::Prepared;
use super::strokes::Instant;

/// Difference for derivatives, in units of θ.
const DIFFERENCE: f64 = 1e-4;
/// Most steps of the search.
const STEPS_MAX: usize = 60;
/// The search is over where the next step promises less, in units of (i8).
const PROMISE: f64 = 2e-3;
/// Longest step of one element of θ.
const STEP_MAX: f64 = 0.7;
/// Width of the blocks that scores are summed over, s. *Assumed*: longer than gusts remember.
const BLOCK_S: f64 = 6.0;

/// What the search is in.
pub(crate) struct Problem<'a> {
    pub logs: &'a [Prepared],
    /// Bins of each log that count.
    pub bins: Vec<usize>,
    pub layout: Layout,
    pub prior: Vec<f64>,
    pub deviation: Vec<f64>,
    /// Elements of θ that stay as they are.
    pub fixed: Vec<usize>,
    /// Mean of ln κᵢ, where that is taken as known.
    pub mean_slope: Option<f64>,
}

/// How exactly a mean slope that is taken as known is kept, in its logarithm.
const PIN: f64 = 1e-4;

/// What the search has found.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub theta: Vec<f64>,
    /// F of (i10), without the prior.
    pub information: DMatrix<f64>,
    /// Σ over blocks of the outer product of their scores.
    pub scores: DMatrix<f64>,
    /// Of each log.
    pub errors: Vec<Errors>,
    pub steps: usize,
    /// Whether it ended by itself.
    pub converged: bool,
}

/// Errors and instants of all logs at one θ.
struct Point {
    theta: Vec<f64>,
    instants: Vec<Vec<Vec<Instant>>>,
    errors: Vec<Errors>,
    cost: f64,
}

impl Problem<'_> {
    /// By how much the mean slope is off, where it is taken as known.
    fn pin(&self, theta: &[f64]) -> Option<f64> {
        let modules = self.layout.modules;
        let mean = (0..modules).map(|module| theta[self.layout.slope(module)]).sum::<f64>() / modules as f64;
        self.mean_slope.map(|known| mean - known)
    }

    /// What prior and pin add to slope and curvature of (i8) at `theta`; what is fixed is taken out.
    pub(crate) fn with_prior(&self, theta: &[f64], slope: &mut DVector<f64>, curvature: &mut DMatrix<f64>) {
        for index in 0..self.layout.len() {
            let weight = self.deviation[index].powi(-2);
            slope[index] += weight * (theta[index] - self.prior[index]);
            curvature[(index, index)] += weight;
        }
        if let Some(off) = self.pin(theta) {
            let share = 1.0 / self.layout.modules as f64;
            let slopes = || (0..self.layout.modules).map(|module| self.layout.slope(module));
            for index in slopes() {
                slope[index] += share * off * PIN.powi(-2);
                slopes().for_each(|other| curvature[(index, other)] += (share / PIN).powi(2));
            }
        }
        for &index in &self.fixed {
            curvature.row_mut(index).fill(0.0);
            curvature.column_mut(index).fill(0.0);
            (curvature[(index, index)], slope[index]) = (1.0, 0.0);
        }
    }

    fn instants(&self, theta: &[f64], log: usize) -> Vec<Vec<Instant>> {
        self.logs[log].instants(super::constants::LATENCY_UNIT * theta[self.layout.latency(log)])
    }

    fn errors(&self, theta: &[f64], instants: &[Vec<Instant>], log: usize) -> Errors {
        errors(&self.logs[log], instants, theta, self.layout, log, self.bins[log], &mut ())
    }

    fn point(&self, theta: Vec<f64>) -> Point {
        let instants: Vec<_> = (0..self.logs.len()).map(|log| self.instants(&theta, log)).collect();
        let errors: Vec<Errors> =
            instants.iter().enumerate().map(|(log, instants)| self.errors(&theta, instants, log)).collect();
        let likelihood: f64 = errors.iter().map(Errors::cost).sum();
        let prior: f64 = (0..theta.len())
            .map(|index| ((theta[index] - self.prior[index]) / self.deviation[index]).powi(2))
            .sum();
        let pin = self.pin(&theta).map_or(0.0, |off| (off / PIN).powi(2));
        let cost = 0.5 * (likelihood + prior + pin);
        Point { theta, instants, errors, cost: if cost.is_finite() { cost } else { f64::INFINITY } }
    }

    /// Derivatives of e and s of one log by each element of θ; empty where there are none.
    fn slopes(&self, point: &Point, log: usize) -> Vec<Errors> {
        let base = &point.errors[log];
        let difference = |index: usize| {
            let own = self.layout.log_of(index).is_none_or(|own| own == log);
            if !own || self.fixed.contains(&index) {
                return Errors::default();
            }
            let mut theta = point.theta.clone();
            theta[index] += DIFFERENCE;
            let mut moved = if index == self.layout.latency(log) {
                self.errors(&theta, &self.instants(&theta, log), log)
            } else {
                self.errors(&theta, &point.instants[log], log)
            };
            moved.e.iter_mut().zip(&base.e).for_each(|(moved, base)| *moved = (*moved - base) / DIFFERENCE);
            moved.s.iter_mut().zip(&base.s).for_each(|(moved, base)| *moved = (*moved - base) / DIFFERENCE);
            moved
        };
        (0..self.layout.len()).map(difference).collect()
    }

    /// (i9), (i10) and the scores of blocks.
    fn linearized(&self, point: &Point) -> (DVector<f64>, DMatrix<f64>, DMatrix<f64>) {
        let size = self.layout.len();
        let mut gradient = DVector::zeros(size);
        let mut information = DMatrix::zeros(size, size);
        let mut scores = DMatrix::zeros(size, size);
        for log in 0..self.logs.len() {
            let slopes = self.slopes(point, log);
            let active: Vec<usize> = (0..size).filter(|&index| !slopes[index].e.is_empty()).collect();
            let base = &point.errors[log];
            let per_block = 3 * (BLOCK_S / super::log::BIN_S) as usize;
            for from in (0..base.e.len()).step_by(per_block) {
                let to = (from + per_block).min(base.e.len());
                let mut block = vec![0.0; active.len()];
                for at in from..to {
                    let (e, s) = (base.e[at], base.s[at]);
                    for (place, &index) in active.iter().enumerate() {
                        let (de, ds) = (slopes[index].e[at], slopes[index].s[at]);
                        // gᵢ = Σ (½·∂ᵢs/s·(1 − e²/s) + e·∂ᵢe/s)                                     (i9)
                        block[place] += 0.5 * ds / s * (1.0 - e * e / s) + e * de / s;
                    }
                }
                for (place, &index) in active.iter().enumerate() {
                    gradient[index] += block[place];
                    for (other, &second) in active.iter().enumerate() {
                        scores[(index, second)] += block[place] * block[other];
                    }
                }
            }
            // Fᵢⱼ = Σ (∂ᵢe·∂ⱼe/s + ½·∂ᵢs·∂ⱼs/s²)                                                    (i10)
            let weights: Vec<f64> = base.s.iter().map(|s| 1.0 / s).collect();
            for (place, &index) in active.iter().enumerate() {
                for &second in &active[place..] {
                    let (a, b) = (&slopes[index], &slopes[second]);
                    let sum: f64 = (0..weights.len())
                        .map(|at| {
                            let weight = weights[at];
                            weight * (a.e[at] * b.e[at] + 0.5 * weight * a.s[at] * b.s[at])
                        })
                        .sum();
                    information[(index, second)] += sum;
                    if index != second {
                        information[(second, index)] += sum;
                    }
                }
            }
        }
        (gradient, information, scores)
    }

    /// Searches from `start`.
    pub(crate) fn search(&self, start: Vec<f64>) -> Fit {
        let size = self.layout.len();
        let mut point = self.point(start);
        let mut damping = 1e-2;
        let (mut steps, mut converged) = (0, false);
        let mut linear = self.linearized(&point);
        while steps < STEPS_MAX && !converged {
            steps += 1;
            let (gradient, information, _) = &linear;
            let (mut slope, mut curvature) = (gradient.clone(), information.clone());
            self.with_prior(&point.theta, &mut slope, &mut curvature);
            let mut accepted = false;
            for _ in 0..12 {
                let mut damped = curvature.clone();
                for index in 0..size {
                    damped[(index, index)] *= 1.0 + damping;
                }
                let Some(factor) = damped.cholesky() else {
                    damping *= 10.0;
                    continue;
                };
                let mut step = -factor.solve(&slope);
                let longest = step.amax();
                if longest > STEP_MAX {
                    step *= STEP_MAX / longest;
                }
                let promise = -0.5 * slope.dot(&step);
                let theta = (0..size).map(|index| point.theta[index] + step[index]).collect();
                let next = self.point(theta);
                if next.cost <= point.cost {
                    converged = promise < PROMISE;
                    damping = (0.2 * damping).max(1e-6);
                    point = next;
                    accepted = true;
                    break;
                }
                if promise < PROMISE {
                    converged = true;
                    break;
                }
                damping = (damping * 5.0).max(1e-3);
            }
            if accepted {
                linear = self.linearized(&point);
            } else {
                break;
            }
        }
        let (_, information, scores) = linear;
        let errors = point.errors;
        Fit { errors, theta: point.theta, information, scores, steps, converged }
    }

    /// The same, and first with what is hardest to tell apart held.
    pub(crate) fn search_in_stages(&self, start: Vec<f64>) -> Fit {
        let held: Vec<usize> = self.fixed.iter().copied().chain([RATIO, ROTOR]).collect();
        let first = Problem {
            logs: self.logs,
            bins: self.bins.clone(),
            layout: self.layout,
            prior: self.prior.clone(),
            deviation: self.deviation.clone(),
            fixed: held,
            mean_slope: self.mean_slope,
        };
        let begun = first.search(start);
        let rest = self.search(begun.theta);
        Fit { steps: begun.steps + rest.steps, ..rest }
    }
}
