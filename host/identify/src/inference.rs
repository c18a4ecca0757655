//! From the information at the best θ to intervals, correlations, and what is not told apart.
//!
//! ```text
//! C = (F + Σ⁻¹)⁻¹          Fisher                                                                   (i13)
//! R = C·(Σ_b g_b·g_bᵀ)·C    robust: scores summed over blocks b of 6 s                               (i14)
//! ```
//!
//! A quantity aᵀθ has the variance max(aᵀCa, min(aᵀRa, 9·aᵀCa)), and its interval is ±1.96 deviations in θ: of what is in θ as a
//! logarithm, a factor. (i14) is wider than (i13) where prediction errors hang together over seconds, which they do where the water does
//! what the model has no word for; few blocks make it uncertain itself, hence the limit of three deviations.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::fit::{Fit, Likelihood, Problem};
use super::outcome::Indistinct;

/// Half the width of a 95 % interval in deviations.
pub(crate) const WIDTH: f64 = 1.96;
/// A direction in which θ is known no better than this is told. In logarithms: 15 %.
const INDISTINCT: f64 = 0.15;
/// Share in a direction below which an element is not named.
const NAMED: f64 = 0.25;

/// Covariances of θ.
pub(crate) struct Covariance {
    fisher: DMatrix<f64>,
    robust: DMatrix<f64>,
}

impl Covariance {
    pub(crate) fn new<M: Likelihood>(problem: &Problem<M>, fit: &Fit) -> Option<Self> {
        let size = problem.model.elements();
        let mut curvature = fit.information.clone();
        problem.with_prior(&fit.theta, &mut DVector::zeros(size), &mut curvature);
        let mut fisher = curvature.cholesky()?.inverse();
        for &index in &problem.fixed {
            fisher[(index, index)] = 0.0;
        }
        let robust = &fisher * &fit.scores * &fisher;
        Some(Self { fisher, robust })
    }

    /// Standard deviation of Σ aᵢθᵢ.
    pub(crate) fn deviation(&self, terms: &[(usize, f64)]) -> f64 {
        let quadratic = |matrix: &DMatrix<f64>| -> f64 {
            terms
                .iter()
                .flat_map(|&(i, a)| terms.iter().map(move |&(j, b)| a * b * matrix[(i, j)]))
                .sum::<f64>()
                .max(0.0)
        };
        let fisher = quadratic(&self.fisher);
        quadratic(&self.robust).min(9.0 * fisher).max(fisher).sqrt()
    }

    /// Correlations of these elements of θ.
    pub(crate) fn correlations(&self, elements: &[usize]) -> Vec<Vec<f64>> {
        let of = |i: usize, j: usize| self.fisher[(i, j)];
        elements
            .iter()
            .map(|&i| elements.iter().map(|&j| of(i, j) / (of(i, i) * of(j, j)).sqrt().max(1e-300)).collect())
            .collect()
    }

    /// Directions of θ that are known worse than [`INDISTINCT`], of these elements.
    pub(crate) fn indistinct(&self, elements: &[usize], name: impl Fn(usize) -> String) -> Vec<Indistinct> {
        let size = elements.len();
        let part = DMatrix::from_fn(size, size, |i, j| self.fisher[(elements[i], elements[j])]);
        let eigen = SymmetricEigen::new(part);
        let mut found: Vec<Indistinct> = (0..size)
            .filter_map(|column| {
                let deviation = eigen.eigenvalues[column].max(0.0).sqrt();
                let vector = eigen.eigenvectors.column(column);
                (deviation > INDISTINCT).then(|| {
                    let mut terms: Vec<(String, f64)> = (0..size)
                        .filter(|&row| vector[row].abs() > NAMED)
                        .map(|row| (name(elements[row]), vector[row]))
                        .collect();
                    terms.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
                    // The sign of a direction means nothing: the greatest element counts up.
                    if terms.first().is_some_and(|term| term.1 < 0.0) {
                        terms.iter_mut().for_each(|term| term.1 = -term.1);
                    }
                    let text = words(&terms, deviation);
                    Indistinct { deviation, terms, text }
                })
            })
            .collect();
        found.sort_by(|a, b| b.deviation.total_cmp(&a.deviation));
        found
    }
}

fn words(terms: &[(String, f64)], deviation: f64) -> String {
    let listed = |up: bool| {
        let names: Vec<&str> =
            terms.iter().filter(|term| (term.1 > 0.0) == up).map(|term| term.0.as_str()).collect();
        names.join(", ")
    };
    let (up, down, percent) = (listed(true), listed(false), 100.0 * deviation);
    match (terms.len(), down.is_empty()) {
        (0 | 1, _) => format!("{up}: hardly shown, ±{percent:.0} %"),
        (_, true) => format!("{up}: all greater or all smaller by ±{percent:.0} % look alike"),
        (_, false) => format!("more {up} and less {down} look alike, by ±{percent:.0} %"),
    }
}
