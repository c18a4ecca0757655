//! Least power under limits by Newton on the multipliers of the wrench.
//!
//! ```text
//! y = Qᵀλ,   uᵢ(yᵢ) = clamp((P')⁻¹(yᵢ), lᵢ, hᵢ)          each thruster for itself, given the price of a wrench
//! g(λ) = Σ (yᵢ uᵢ − P(uᵢ)) − λ·b → least,   ∇g = Q u(y) − b,   ∇²g = Q diag(u'(y)) Qᵀ
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Q, b | whitened configuration matrix (orthonormal or zero rows) and demand, Q u = b | 1, N |
//! | λ, y | multipliers; marginal power of each thruster | W/N |
//!
//! g is convex, for P is. At ∇g = 0 the thrusts make the demand and fulfil the conditions of Karush, Kuhn and Tucker: y
//! is the marginal power where a limit does not hold, above it at the upper limit and below it at the lower. Where no thrusts
//! make the demand, g falls without end; a λ with λ·b > Σ max(yᵢlᵢ, yᵢhᵢ) proves it.

use nalgebra::{Matrix6, Matrix6xX, Vector6};

use super::super::power::PowerLaw;
use super::times;

/// Residual of the demand at which the search ends, as a share of it.
const TOLERANCE: f64 = 1e-12;
/// Residual with which a search that gets no further is taken.
const GOOD_ENOUGH: f64 = 1e-10;
const STEPS_MAX: usize = 200;
const HALVINGS_MAX: usize = 40;

struct State {
    lambda: Vector6<f64>,
    thrusts_n: Vec<f64>,
    /// How fast each thrust grows with its marginal power; zero at a limit.
    grows: Vec<f64>,
    value: f64,
    gradient: Vector6<f64>,
    unreachable: bool,
}

/// The thrusts, or `None` where the demand is out of reach (or so near the end of the reach that it may be).
pub(super) fn solve(
    rows: &Matrix6xX<f64>,
    target: &Vector6<f64>,
    limits_n: &[(f64, f64)],
    law: &PowerLaw,
) -> Option<Vec<f64>> {
    let evaluate = |lambda: Vector6<f64>| -> Option<State> {
        let y = rows.tr_mul(&lambda);
        let (mut thrusts_n, mut grows) = (Vec::with_capacity(y.len()), Vec::with_capacity(y.len()));
        let (mut value, mut most) = (-lambda.dot(target), 0.0);
        for (&y, &(low, high)) in y.iter().zip(limits_n) {
            let (free, slope) = law.thrust_of_marginal(y)?;
            let u = free.clamp(low, high);
            grows.push(if free > low && free < high { slope } else { 0.0 });
            value += y * u - law.power_w(u);
            most += (y * low).max(y * high);
            thrusts_n.push(u);
        }
        let gradient = times(rows, &thrusts_n) - target;
        let unreachable = lambda.dot(target) > most * (1.0 + 1e-12) + f64::MIN_POSITIVE;
        Some(State { lambda, thrusts_n, grows, value, gradient, unreachable })
    };
    // Start at the marginal powers of the least-norm thrusts, the answer of the quadratic law without limits.
    let least_norm = rows.tr_mul(target);
    let mut start = Vector6::zeros();
    for (column, u) in rows.column_iter().zip(least_norm.iter()) {
        start += column * law.marginal_w_n(*u)?;
    }
    let mut now = evaluate(start)?;
    let size = target.norm();
    // One curvature for the directions in which no free thruster pushes.
    let typical = (now.grows.iter().sum::<f64>() / now.grows.len() as f64).max(size / start.norm());
    for _ in 0..STEPS_MAX {
        let residual = now.gradient.norm();
        if residual <= TOLERANCE * size {
            return Some(now.thrusts_n);
        }
        if now.unreachable {
            return None;
        }
        let mut hessian = Matrix6::zeros();
        for (column, grows) in rows.column_iter().zip(&now.grows).filter(|(_, grows)| **grows > 0.0) {
            hessian.ger(*grows, &column, &column, 1.0);
        }
        hessian += Matrix6::identity() * (typical * (1e-3 * residual / size).clamp(1e-13, 1e-3));
        let step = -hessian.cholesky()?.solve(&now.gradient);
        let slope = step.dot(&now.gradient);
        let noise = 1e-14 * (now.value.abs() + now.lambda.dot(target).abs());
        let (mut scale, mut next) = (1.0, None);
        for _ in 0..HALVINGS_MAX {
            let tried = evaluate(now.lambda + step * scale)?;
            let falls = tried.value <= now.value + 1e-4 * scale * slope;
            // Near the end g is level to rounding; its gradient is not.
            let settles = tried.value <= now.value + noise && tried.gradient.norm() <= 0.5 * residual;
            if falls || settles {
                next = Some(tried);
                break;
            }
            scale *= 0.5;
        }
        match next {
            Some(next) => now = next,
            None if residual <= GOOD_ENOUGH * size => return Some(now.thrusts_n),
            None => return None,
        }
    }
    (now.gradient.norm() <= GOOD_ENOUGH * size).then_some(now.thrusts_n)
}
