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

use super::binning::BIN_S;
use super::filter::Errors;

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

/// What the search needs of a model: prediction errors of each log at any θ.
pub(crate) trait Likelihood {
    /// What few elements of θ change, of one log: made once for many derivatives.
    type Setting;
    /// Coordinates of a bin.
    const COORDINATES: usize;

    /// How many there are.
    fn logs(&self) -> usize;
    /// Of θ.
    fn elements(&self) -> usize;
    /// The log whose own constant this is, if it is one's.
    fn log_of(&self, index: usize) -> Option<usize>;
    /// The setting of a log at θ.
    fn setting(&self, theta: &[f64], log: usize) -> Self::Setting;
    /// Whether this element changes it.
    fn sets(&self, index: usize, log: usize) -> bool;
    /// Prediction errors of a log in order.
    fn errors(&self, theta: &[f64], setting: &Self::Setting, log: usize) -> Errors;
}

/// What the search is in.
#[derive(Clone)]
pub(crate) struct Problem<M> {
    pub model: M,
    pub prior: Vec<f64>,
    pub deviation: Vec<f64>,
    /// Elements of θ that stay as they are.
    pub fixed: Vec<usize>,
    /// Sets of elements whose mean is taken as known, and what it is.
    pub known_means: Vec<(Vec<usize>, f64)>,
}

/// How exactly a mean that is taken as known is kept, in units of θ.
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

/// Errors and settings of all logs at one θ.
struct Point<S> {
    theta: Vec<f64>,
    settings: Vec<S>,
    errors: Vec<Errors>,
    cost: f64,
}

impl<M: Likelihood> Problem<M> {
    /// By how much each mean is off that is taken as known, with its elements.
    fn pins<'a>(&'a self, theta: &'a [f64]) -> impl Iterator<Item = (&'a [usize], f64)> {
        self.known_means.iter().map(|(elements, known)| {
            let mean = elements.iter().map(|&index| theta[index]).sum::<f64>() / elements.len() as f64;
            (elements.as_slice(), mean - known)
        })
    }

    /// What prior and pin add to slope and curvature of (i8) at `theta`; what is fixed is taken out.
    pub(crate) fn with_prior(&self, theta: &[f64], slope: &mut DVector<f64>, curvature: &mut DMatrix<f64>) {
        for index in 0..self.model.elements() {
            let weight = self.deviation[index].powi(-2);
            slope[index] += weight * (theta[index] - self.prior[index]);
            curvature[(index, index)] += weight;
        }
        for (elements, off) in self.pins(theta) {
            let share = 1.0 / elements.len() as f64;
            for &index in elements {
                slope[index] += share * off * PIN.powi(-2);
                elements.iter().for_each(|&other| curvature[(index, other)] += (share / PIN).powi(2));
            }
        }
        for &index in &self.fixed {
            curvature.row_mut(index).fill(0.0);
            curvature.column_mut(index).fill(0.0);
            (curvature[(index, index)], slope[index]) = (1.0, 0.0);
        }
    }

    fn point(&self, theta: Vec<f64>) -> Point<M::Setting> {
        let settings: Vec<_> = (0..self.model.logs()).map(|log| self.model.setting(&theta, log)).collect();
        let errors: Vec<Errors> = settings
            .iter()
            .enumerate()
            .map(|(log, setting)| self.model.errors(&theta, setting, log))
            .collect();
        let likelihood: f64 = errors.iter().map(Errors::cost).sum();
        let prior: f64 = (0..theta.len())
            .map(|index| ((theta[index] - self.prior[index]) / self.deviation[index]).powi(2))
            .sum();
        let pin: f64 = self.pins(&theta).map(|(_, off)| (off / PIN).powi(2)).sum();
        let cost = 0.5 * (likelihood + prior + pin);
        Point { theta, settings, errors, cost: if cost.is_finite() { cost } else { f64::INFINITY } }
    }

    /// Derivatives of e and s of one log by each element of θ; empty where there are none.
    fn slopes(&self, point: &Point<M::Setting>, log: usize) -> Vec<Errors> {
        let base = &point.errors[log];
        let difference = |index: usize| {
            let own = self.model.log_of(index).is_none_or(|own| own == log);
            if !own || self.fixed.contains(&index) {
                return Errors::default();
            }
            let mut theta = point.theta.clone();
            theta[index] += DIFFERENCE;
            let mut moved = if self.model.sets(index, log) {
                self.model.errors(&theta, &self.model.setting(&theta, log), log)
            } else {
                self.model.errors(&theta, &point.settings[log], log)
            };
            moved.e.iter_mut().zip(&base.e).for_each(|(moved, base)| *moved = (*moved - base) / DIFFERENCE);
            moved.s.iter_mut().zip(&base.s).for_each(|(moved, base)| *moved = (*moved - base) / DIFFERENCE);
            moved
        };
        (0..self.model.elements()).map(difference).collect()
    }

    /// (i9), (i10) and the scores of blocks.
    fn linearized(&self, point: &Point<M::Setting>) -> (DVector<f64>, DMatrix<f64>, DMatrix<f64>) {
        let size = self.model.elements();
        let mut gradient = DVector::zeros(size);
        let mut information = DMatrix::zeros(size, size);
        let mut scores = DMatrix::zeros(size, size);
        for log in 0..self.model.logs() {
            let slopes = self.slopes(point, log);
            let active: Vec<usize> = (0..size).filter(|&index| !slopes[index].e.is_empty()).collect();
            let base = &point.errors[log];
            let per_block = M::COORDINATES * (BLOCK_S / BIN_S) as usize;
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
        let size = self.model.elements();
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
    pub(crate) fn search_in_stages(&self, start: Vec<f64>, held: &[usize]) -> Fit
    where
        M: Clone,
    {
        let mut first = self.clone();
        first.fixed.extend(held);
        let begun = first.search(start);
        let rest = self.search(begun.theta);
        Fit { steps: begun.steps + rest.steps, ..rest }
    }
}
