//! From elements of θ to a constant with its interval.

use super::inference::{Covariance, WIDTH};
use super::outcome::Constant;

/// What bins and steps of 40 ms leave in a logarithm, *measured* against the simulated water: biases of up to three parts in a thousand.
const STEPS: f64 = 2e-3;
/// What is known of one element or a sum of elements of θ.
pub(crate) struct Quantity {
    pub name: String,
    pub terms: Vec<(usize, f64)>,
    /// Of a logarithm: a factor on the exponential. Else a factor on the sum.
    pub logarithm: bool,
    pub factor: f64,
    /// Subtracted at the end.
    pub less: f64,
    pub belief: Option<f64>,
    /// What is not a logarithm is shown where its interval is narrower than this either way.
    pub narrow: f64,
    /// A deviation that (i13) and (i14) do not have.
    pub besides: f64,
}

impl Quantity {
    pub(crate) fn log(name: &str, terms: &[(usize, f64)], factor: f64, belief: f64) -> Self {
        let terms = terms.to_vec();
        let (name, belief) = (name.to_owned(), Some(belief));
        Self { name, terms, logarithm: true, factor, less: 0.0, belief, narrow: 0.0, besides: STEPS }
    }

    pub(crate) fn linear(name: String, index: usize, factor: f64, belief: Option<f64>, narrow: f64) -> Self {
        let terms = vec![(index, 1.0)];
        Self { name, terms, logarithm: false, factor, less: 0.0, belief, narrow, besides: 0.0 }
    }

    pub(crate) fn constant(&self, theta: &[f64], covariance: &Covariance) -> Constant {
        let at: f64 = self.terms.iter().map(|&(index, weight)| weight * theta[index]).sum();
        let deviation = covariance.deviation(&self.terms);
        let value = |x: f64| self.factor * if self.logarithm { x.exp() } else { x } - self.less;
        let half = WIDTH * deviation.hypot(self.besides);
        let shown = if self.logarithm { half < 0.5 } else { half * self.factor < self.narrow };
        Constant {
            name: self.name.clone(),
            value: value(at),
            low: value(at - half),
            high: value(at + half),
            belief: self.belief,
            shown,
        }
    }
}
