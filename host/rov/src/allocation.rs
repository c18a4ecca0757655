//! Allocation: the thrusts that give a wrench at least electric power, within the thrusters' limits.
//!
//! ```text
//! minimise Σ P(uᵢ)   subject to   T u = s τ,   lᵢ ≤ uᵢ ≤ hᵢ,   with the greatest s ≤ 1 for which this can be done
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | u, l, h | thrusts and their limits; a failed thruster has l = h = 0 | N |
//! | T | configuration matrix (9), (16) | 1, m |
//! | τ, s | demanded wrench, the share of it that is served | N, N·m; 1 |
//! | P | electric power of a thruster, see [`power`](super::power) | W |
//!
//! A demand out of reach keeps its direction and loses in size. Which way the thrusts are found:
//!
//! - Columns of working thrusters independent (one BlueROV1): T u = τ has one solution, u = T⁺ τ. No solver.
//! - Smooth laws: Newton on the six multipliers (`dual`), to 1e-10 of the demand. The quadratic law makes it an exact
//!   QP: the optimum is where the last active set's linear equations hold.
//! - The measured table is no convex law. Its lower convex envelope is minimised exactly, as a linear program
//!   (`simplex`); the power told is the table's own for these thrusts.
//! - The greatest s of a demand out of reach is a linear program too.
//!
//! Roll and pitch that no thruster can push in may be left to the restoring moment ([`Allocator::with_passive`]):
//!
//! ```text
//! T u = s (τ − E p),   p = (R E)⁺ R τ,   R = I − T T⁺,   s |p| ≤ S sin θ
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | E, p | the columns of K and M of the unit matrix, the moments left to stability | 1, N·m |
//! | S | stiffness z_G W − z_B B: the moment at a tilt θ is S sin θ | N·m |

mod dual;
mod simplex;

use nalgebra::{DMatrix, Matrix6, Matrix6xX, Vector2, Vector6};

use super::configuration_matrix::{AXES, ConfigurationMatrix};
use super::power::PowerLaw;

/// A demand this share of itself outside what the thrusters can push at all is out of reach.
const RANGE_TOLERANCE: f64 = 1e-9;
/// Singular values below this share of the greatest count as zero.
const RANK_TOLERANCE: f64 = 1e-9;
/// A thrust may pass its limit by this share of it before the demand is scaled down: rounding.
const LIMIT_TOLERANCE: f64 = 1e-12;

/// Why thrusts cannot be allocated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum AllocationError {
    /// Not one pair of limits a thruster.
    #[error("{limits} pairs of limits were given for {thrusters} thrusters")]
    LimitCount { limits: usize, thrusters: usize },
    /// Limits that leave out zero or are no numbers.
    #[error("limits {low_n} to {high_n} N of thruster {thruster}: rest, 0 N, must be between them")]
    Limits { thruster: usize, low_n: f64, high_n: f64 },
    /// A demand that is no number.
    #[error("the demand in {axis} is {value}, a finite number of N or N·m is asked for")]
    Demand { axis: &'static str, value: f64 },
    /// Not one place for each thrust.
    #[error("room for {room} thrusts was given for {thrusters} thrusters")]
    Room { room: usize, thrusters: usize },
}

/// Thrusts that serve a demanded wrench.
#[derive(Clone, Debug, PartialEq)]
pub struct Allocation {
    /// Thrust of each thruster, N, in the order of the configuration matrix.
    pub thrusts_n: Vec<f64>,
    /// Electric power, W.
    pub power_w: f64,
    /// Share of the demand that is served: 1 for all of it.
    pub served: f64,
    /// Wrench that is missing, (1 − served) times the demand, N and N·m.
    pub missing: [f64; 6],
}

/// Everything about a set of thrusters that stays the same from demand to demand.
#[derive(Clone, Debug)]
pub struct Allocator {
    matrix: ConfigurationMatrix,
    limits_n: Vec<(f64, f64)>,
    law: PowerLaw,
    /// T of the working thrusters = U S Q, Q with orthonormal rows: Q u = S⁻¹ Uᵀ τ =: W τ.
    rows: Matrix6xX<f64>,
    whiten: DMatrix<f64>,
    /// T⁺, one row a thruster, where the columns of the working thrusters are independent.
    direct: Option<Vec<Vector6<f64>>>,
    full_rank: bool,
    passive: Option<Passive>,
}

/// What stability takes of a demand.
#[derive(Clone, Debug)]
struct Passive {
    /// p of a demand, one row for K and one for M.
    map: [Vector6<f64>; 2],
    /// Greatest size of p, N·m.
    most_nm: f64,
}

impl Allocator {
    /// For thrusters with limits (reverse, negative or zero; forward) and a law of power.
    ///
    /// # Errors
    /// [`AllocationError::LimitCount`], [`AllocationError::Limits`].
    pub fn new(
        matrix: ConfigurationMatrix,
        limits_n: &[(f64, f64)],
        law: PowerLaw,
    ) -> Result<Self, AllocationError> {
        let thrusters = matrix.thrusters();
        if limits_n.len() != thrusters {
            return Err(AllocationError::LimitCount { limits: limits_n.len(), thrusters });
        }
        for (k, &(low_n, high_n)) in limits_n.iter().enumerate() {
            if !(low_n <= 0.0 && high_n >= 0.0 && low_n.is_finite() && high_n.is_finite()) {
                return Err(AllocationError::Limits { thruster: k + 1, low_n, high_n });
            }
        }
        let usable: Vec<bool> = limits_n.iter().map(|(low, high)| high - low > 0.0).collect();
        let working = matrix.restricted(&usable);
        let mut wide = DMatrix::zeros(6, thrusters.max(6));
        wide.view_mut((0, 0), (6, thrusters)).copy_from(working.matrix());
        let svd = wide.svd(true, true);
        let (u, v_t, s) = (svd.u.unwrap_or_default(), svd.v_t.unwrap_or_default(), svd.singular_values);
        let cut = RANK_TOLERANCE * s.iter().copied().fold(0.0, f64::max);
        // Rows of lost directions stay zero.
        let (mut rows, mut whiten) = (Matrix6xX::zeros(thrusters), DMatrix::zeros(6, 6));
        let kept: Vec<usize> = (0..s.len()).filter(|&k| s[k] > cut).collect();
        for &k in &kept {
            rows.row_mut(k).copy_from(&v_t.row(k).columns(0, thrusters));
            whiten.row_mut(k).copy_from(&(u.column(k).transpose() / s[k]));
        }
        let independent = kept.len() == usable.iter().filter(|usable| **usable).count();
        let direct = independent.then(|| {
            let pseudo_inverse = rows.transpose() * &whiten;
            pseudo_inverse.row_iter().map(|row| Vector6::from_iterator(row.iter().copied())).collect()
        });
        let full_rank = kept.len() == 6;
        Ok(Self { matrix, limits_n: limits_n.to_vec(), law, rows, whiten, direct, full_rank, passive: None })
    }

    /// The same thrusters on a body whose own stability takes up to `most_nm` of roll and pitch where no thruster can
    /// push. What thrusters can do they do.
    #[must_use]
    pub fn with_passive(mut self, most_nm: f64) -> Self {
        if self.full_rank || most_nm <= 0.0 {
            return self;
        }
        // R = I − T T⁺
        let mut residual = Matrix6::identity();
        for axis in 0..6 {
            let unit = Vector6::ith(axis, 1.0);
            let reached = self.matrix.matrix() * (self.rows.transpose() * self.whitened(&unit));
            residual.set_column(axis, &(unit - reached));
        }
        // p = (R E)⁺ R τ
        let levelled = residual.fixed_columns::<2>(3).into_owned();
        let inverse = levelled.pseudo_inverse(1e-6).unwrap_or_default();
        let map = inverse * residual;
        self.passive = Some(Passive { map: [0, 1].map(|k| map.row(k).transpose()), most_nm });
        self
    }

    /// Whether the thrusters, or stability where it helps, can push along `demand` at all.
    #[must_use]
    pub fn reaches(&self, demand: &[f64; 6]) -> bool {
        let (tau, _) = self.relieved(Vector6::from(*demand));
        let reached = self.matrix.matrix() * (self.rows.transpose() * self.whitened(&tau));
        (tau - reached).norm() <= RANGE_TOLERANCE * Vector6::from(*demand).norm()
    }

    /// W τ.
    fn whitened(&self, tau: &Vector6<f64>) -> Vector6<f64> {
        let target = &self.whiten * tau;
        Vector6::from_iterator(target.iter().copied())
    }

    /// s (τ − E p) and s.
    fn relieved(&self, tau: Vector6<f64>) -> (Vector6<f64>, f64) {
        let Some(Passive { map, most_nm }) = &self.passive else { return (tau, 1.0) };
        let p = Vector2::new(map[0].dot(&tau), map[1].dot(&tau));
        let share = if p.norm() > *most_nm { most_nm / p.norm() } else { 1.0 };
        let left = tau - Vector6::new(0.0, 0.0, 0.0, p.x, p.y, 0.0);
        // What stability takes whole leaves rounding.
        let left = if left.norm() <= RANGE_TOLERANCE * tau.norm() { Vector6::zeros() } else { left };
        (share * left, share)
    }

    /// Wrench T u of thrusts u, N and N·m.
    #[must_use]
    pub fn wrench(&self, thrusts_n: &[f64]) -> [f64; 6] {
        self.matrix.wrench(thrusts_n)
    }

    /// Electric power of thrusts, W.
    #[must_use]
    pub fn power_w(&self, thrusts_n: &[f64]) -> f64 {
        thrusts_n.iter().map(|&u| self.law.power_w(u)).sum()
    }

    /// Thrusts for a demanded wrench at least power.
    ///
    /// # Errors
    /// [`AllocationError::Demand`] for a demand that is not finite.
    pub fn allocate(&self, demand: &[f64; 6]) -> Result<Allocation, AllocationError> {
        let mut thrusts_n = vec![0.0; self.matrix.thrusters()];
        let served = self.allocate_into(demand, &mut thrusts_n)?;
        let power_w = self.power_w(&thrusts_n);
        Ok(Allocation { thrusts_n, power_w, served, missing: demand.map(|d| (1.0 - served) * d) })
    }

    /// As [`allocate`](Self::allocate) into memory of the caller; gives the share that is served. Allocates nothing
    /// where the columns of the working thrusters are independent.
    ///
    /// # Errors
    /// [`AllocationError::Demand`] for a demand that is not finite, [`AllocationError::Room`].
    pub fn allocate_into(&self, demand: &[f64; 6], thrusts_n: &mut [f64]) -> Result<f64, AllocationError> {
        if let Some(k) = demand.iter().position(|d| !d.is_finite()) {
            return Err(AllocationError::Demand { axis: AXES[k], value: demand[k] });
        }
        if thrusts_n.len() != self.matrix.thrusters() {
            return Err(AllocationError::Room { room: thrusts_n.len(), thrusters: self.matrix.thrusters() });
        }
        let (tau, share) = self.relieved(Vector6::from(*demand));
        Ok(share * self.serve(&tau, thrusts_n))
    }

    /// The greatest share of τ that the thrusters give, at least power.
    fn serve(&self, tau: &Vector6<f64>, thrusts_n: &mut [f64]) -> f64 {
        if let Some(pseudo_inverse) = &self.direct {
            return self.solve_directly(pseudo_inverse, tau, thrusts_n);
        }
        let target = self.whitened(tau);
        let reached = self.matrix.matrix() * (self.rows.transpose() * target);
        if target.norm() == 0.0 || self.out_of_range(tau, &reached) {
            thrusts_n.fill(0.0);
            return if tau.norm() == 0.0 { 1.0 } else { 0.0 };
        }
        let smooth = !matches!(self.law, PowerLaw::Table(_));
        if smooth && let Some(u) = dual::solve(&self.rows, &target, &self.limits_n, &self.law) {
            thrusts_n.copy_from_slice(&u);
            return 1.0;
        }
        self.solve_linear(&target, thrusts_n)
    }

    /// u = s T⁺ τ, with the greatest s that the limits allow.
    fn solve_directly(
        &self,
        pseudo_inverse: &[Vector6<f64>],
        tau: &Vector6<f64>,
        thrusts_n: &mut [f64],
    ) -> f64 {
        let mut served: f64 = 1.0;
        for ((u, row), (low, high)) in thrusts_n.iter_mut().zip(pseudo_inverse).zip(&self.limits_n) {
            *u = row.dot(tau);
            let limit = if *u < 0.0 { low } else { high };
            if u.abs() > limit.abs() * (1.0 + LIMIT_TOLERANCE) {
                served = served.min(limit / *u);
            }
        }
        if !self.full_rank && self.out_of_range(tau, &Vector6::from(self.matrix.wrench(thrusts_n))) {
            served = if tau.norm() == 0.0 { 1.0 } else { 0.0 };
        }
        for (u, (low, high)) in thrusts_n.iter_mut().zip(&self.limits_n) {
            *u = (*u * served).clamp(*low, *high);
        }
        served
    }

    /// By linear programs: the greatest share, and for the table the thrusts as well.
    fn solve_linear(&self, target: &Vector6<f64>, thrusts_n: &mut [f64]) -> f64 {
        let pieces = self.law.pieces();
        let Some(found) = simplex::solve(&self.rows, target, &self.limits_n, &pieces) else {
            // Not met in any test: more pivots than the solver allows itself. Rest is always allowed.
            thrusts_n.fill(0.0);
            return 0.0;
        };
        thrusts_n.copy_from_slice(&found.thrusts_n);
        if pieces.is_empty() {
            // A thruster that helps along the direction in which the reach ends stands at its limit in every solution;
            // the others are free to save power.
            let fixed: Vec<(f64, f64)> = (self.limits_n.iter().zip(&found.thrusts_n).zip(&found.pinned))
                .map(|((&limits, &u), &pinned)| if pinned { (u, u) } else { limits })
                .collect();
            let target = target * found.served;
            // Without an answer the program's own thrusts stay: they serve as much, at more power.
            if let Some(u) = dual::solve(&self.rows, &target, &fixed, &self.law) {
                thrusts_n.copy_from_slice(&u);
            }
        }
        found.served
    }

    fn out_of_range(&self, tau: &Vector6<f64>, reached: &Vector6<f64>) -> bool {
        (tau - reached).norm() > RANGE_TOLERANCE * tau.norm()
    }
}

/// Σ over thrusters of a column of `rows` weighted: rows · u.
fn times(rows: &Matrix6xX<f64>, u: &[f64]) -> Vector6<f64> {
    rows.column_iter().zip(u).map(|(column, u)| column * *u).sum()
}

#[cfg(test)]
mod tests;
