//! A Kalman filter of the shares and of what else is not known of a structure: (h2), one cycle at a time.
//!
//! ```text
//! z = H·x + noise,   K = P Hᵀ/(H P Hᵀ + r),   x ← x + K (z − H x),   P ← P − K H P                  (h4)
//! x = (s₁ … s_N, μ, c_x, c_y, ι, c_R, m, d_x, d_y, d_Θ)
//! r_F = λ·[(M·σ_a)² + (κ·|f|)²]                                                                      (h5)
//! ```
//!
//! σ_a is the noise of (h1), κ how far swings differ from law (2) from cycle to cycle, and λ what innovations say of the water: a filter that is
//! right has innovations of its own variance.

use super::Found;
use crate::observer::ObserverParameters;
use crate::parameters::Parameters;
use crate::structure::Structure;

/// Unknowns beside the shares.
const OTHERS: usize = 9;
/// Standard deviations at the beginning: of what all shares have in common; of μ, c, ι and c_R; of m, over that of a share. *Assumed.*
const COMMON: f64 = 0.35;
const UNSURE: [f64; 5] = [0.3, 0.5, 0.5, 0.3, 0.7];
const UNSURE_MUNK: f64 = 2.0;
/// The same of d, as a share of the greatest thrust of every module; and its growth in a cycle, over that. *Assumed.*
const PUSH: f64 = 0.15;
const CHANGE: f64 = 0.1;
/// Growth of the deviation of a share in a second. *Assumed*: weed comes within a minute.
const WANDER: f64 = 0.01;
/// σ_a of a mean of positions, m, and of headings, rad. *Assumed*: the noise of a window, or a wobble that is not quite periodic.
const SEEN_M: f64 = 1.5e-4;
const SEEN_RAD: f64 = 8e-4;
/// κ. *Assumed.*
const INEXACT: f64 = 0.03;
/// How fast λ follows the innovations, how far one of them counts, over its variance, and between what λ stays. *Assumed.*
const HEED: f64 = 0.1;
const ODD: f64 = 8.0;
const LAMBDA: [f64; 2] = [0.6, 100.0];

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(super) struct Regression {
    mass_kg: f64,
    /// With water.
    inertia_kg_m2: f64,
    /// J/I of one tail.
    rotor_share: f64,
    drag_n_s2_m2: f64,
    yaw_drag_n_m_s2: f64,
    /// RMS distance of a module from the centre, m.
    radius_m: f64,
    /// PUSH in N and N·m.
    push: [f64; 3],
    modules: usize,
    /// Shares before anything was seen.
    believed: Vec<f64>,
    state: Vec<f64>,
    /// P, row by row.
    covariance: Vec<f64>,
    /// λ.
    noise: f64,
    row: Vec<f64>,
    gain: Vec<f64>,
}

impl Regression {
    /// `unsure`: standard deviation of each share beside what all have in common; `munk`: what m is taken for.
    pub(super) fn new(
        structure: &Structure,
        parameters: &Parameters,
        observer: &ObserverParameters,
        (unsure, munk): (f64, f64),
    ) -> Self {
        let modules = structure.len();
        let positions_m = structure.positions_m(parameters.pitch_m);
        let squares_m2: f64 = positions_m.iter().map(|[x, y]| x * x + y * y).sum();
        let most_n = parameters.thrust_n(parameters.amplitude_max_rad);
        let radius_m = (squares_m2 / modules as f64).sqrt();
        let push_n = PUSH * most_n * modules as f64;
        let push = [push_n, push_n, push_n * radius_m];
        let size = modules + OTHERS;
        let shares = || (0..modules).map(|module| parameters.share(module));
        let state = shares().chain([0.0, 1.0, 1.0, 0.0, 1.0, munk, 0.0, 0.0, 0.0]).collect();
        let mut covariance = vec![0.0; size * size];
        for (i, one) in shares().enumerate() {
            for (j, other) in shares().enumerate() {
                covariance[i * size + j] = one * other * COMMON * COMMON;
            }
            covariance[i * size + i] += (unsure * one).powi(2);
        }
        for (k, deviation) in UNSURE.into_iter().chain([UNSURE_MUNK * unsure]).chain(push).enumerate() {
            covariance[(modules + k) * (size + 1)] = deviation * deviation;
        }
        let inertia_kg_m2 = structure.inertia_kg_m2(parameters) * (1.0 + observer.added_inertia);
        Self {
            mass_kg: structure.mass_kg(parameters) * (1.0 + observer.added_mass),
            inertia_kg_m2,
            rotor_share: parameters.tail_inertia_kg_m2 / inertia_kg_m2,
            drag_n_s2_m2: modules as f64 * parameters.drag_n_s2_m2,
            yaw_drag_n_m_s2: structure.yaw_drag_n_m_s2(parameters),
            radius_m,
            push,
            modules,
            believed: shares().collect(),
            state,
            covariance,
            noise: 1.0,
            row: vec![0.0; size],
            gain: vec![0.0; size],
        }
    }

    /// J/I of one tail.
    pub(super) fn rotor_share(&self) -> f64 {
        self.rotor_share
    }

    /// Takes in one cycle: heading Θ, rates and accelerations (world, and yaw), what each module gives of law (2), and the time since the last.
    /// The logarithm of its likelihood.
    pub(super) fn learn(
        &mut self,
        heading_rad: f64,
        rate: [f64; 3],
        acceleration: [f64; 3],
        given: &[[f64; 3]],
        interval_s: f64,
    ) -> f64 {
        let size = self.state.len();
        for module in 0..self.modules {
            self.covariance[module * (size + 1)] += WANDER * WANDER * interval_s;
        }
        for (axis, push) in self.push.into_iter().enumerate() {
            self.covariance[(self.modules + 6 + axis) * (size + 1)] += self.noise * (CHANGE * push).powi(2);
        }
        let (sin, cos) = heading_rad.sin_cos();
        // World → S: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
        let to_s = |[x, y, _]: [f64; 3]| [sin * x - cos * y, cos * x + sin * y];
        let ([v_x, v_y], [a_x, a_y]) = (to_s(rate), to_s(acceleration));
        let (omega, alpha) = (rate[2], acceleration[2]);
        let (mass, inertia) = (self.mass_kg, self.inertia_kg_m2);
        let drag = |v: f64| -self.drag_n_s2_m2 * v * v.abs();
        let yaw_drag = -self.yaw_drag_n_m_s2 * omega * omega.abs();
        let mut believed = [0.0; 3];
        for (share, given) in self.believed.iter().zip(given) {
            (0..3).for_each(|axis| believed[axis] += share * given[axis]);
        }
        let squares = given.iter().map(|[x, y, _]| x * x + y * y).sum::<f64>();
        let second = self.step_s2(interval_s);
        let seen = [SEEN_M * mass / second, SEEN_M * mass / second, SEEN_RAD * inertia / second];
        let lever = [1.0, 1.0, self.radius_m];
        // (h2): what is measured, and what the unknowns beside the shares are multiplied by.
        let others = [
            [-believed[0], drag(v_x), 0.0, 0.0, 0.0, 0.0, sin, -cos, 0.0],
            [0.0, 0.0, drag(v_y), 0.0, 0.0, 0.0, cos, sin, 0.0],
            [0.0, 0.0, 0.0, -believed[2], yaw_drag, -mass * v_x * v_y, 0.0, 0.0, 1.0],
        ];
        let measured = [mass * a_x, mass * a_y, inertia * alpha];
        let (mut odd, mut likelihood) = (0.0, 0.0);
        for axis in 0..3 {
            for (row, given) in self.row.iter_mut().zip(given) {
                *row = given[axis];
            }
            self.row[self.modules..].copy_from_slice(&others[axis]);
            let own = seen[axis].powi(2) + (INEXACT * lever[axis]).powi(2) * squares;
            let (innovation, spread) = self.correct(measured[axis], self.noise * own);
            odd += innovation.min(ODD) / 3.0;
            likelihood -= 0.5 * (innovation.min(ODD) + spread.ln());
        }
        self.noise = (self.noise * (HEED * (odd - 1.0)).exp()).clamp(LAMBDA[0], LAMBDA[1]);
        likelihood
    }

    /// The time over which (h1) differences twice, over the noise of that: h²/√6, s².
    fn step_s2(&self, interval_s: f64) -> f64 {
        interval_s * interval_s / 6.0_f64.sqrt()
    }

    /// (h4) with the row that stands ready; the square of the innovation over its variance, and that variance.
    fn correct(&mut self, measured: f64, variance: f64) -> (f64, f64) {
        let size = self.state.len();
        for (gain, row) in self.gain.iter_mut().zip(self.covariance.chunks_exact(size)) {
            *gain = row.iter().zip(&self.row).map(|(p, h)| p * h).sum();
        }
        let dot = |of: &[f64], row: &[f64]| of.iter().zip(row).map(|(a, b)| a * b).sum::<f64>();
        let spread = dot(&self.gain, &self.row) + variance;
        let innovation = measured - dot(&self.state, &self.row);
        let odd = innovation * innovation / spread;
        // One that is far off is no more than an odd one.
        let innovation = innovation * (ODD / odd).sqrt().min(1.0);
        for (state, gain) in self.state.iter_mut().zip(&self.gain) {
            *state += gain / spread * innovation;
        }
        for (row, gain) in self.covariance.chunks_exact_mut(size).zip(&self.gain) {
            for (p, other) in row.iter_mut().zip(&self.gain) {
                *p -= gain * other / spread;
            }
        }
        (odd, spread)
    }

    /// m and its deviation.
    pub(super) fn munk(&self) -> Found {
        let (size, at) = (self.state.len(), self.modules + 5);
        Found { share: self.state[at], deviation: self.covariance[at * (size + 1)].max(0.0).sqrt() }
    }

    /// Shares over their mean, and the deviation of that.
    pub(super) fn relative(&self) -> impl Iterator<Item = Found> + '_ {
        let (size, modules) = (self.state.len(), self.modules as f64);
        let mean = self.state[..self.modules].iter().sum::<f64>() / modules;
        let rows = move |module: usize| &self.covariance[module * size..][..self.modules];
        let shared: Vec<f64> =
            (0..self.modules).map(|module| rows(module).iter().sum::<f64>() / modules).collect();
        let whole = shared.iter().sum::<f64>() / modules;
        (0..self.modules).map(move |module| {
            let share = self.state[module] / mean;
            // Of (sᵢ − share·mean)/mean.
            let variance = rows(module)[module] - 2.0 * share * shared[module] + share * share * whole;
            Found { share, deviation: variance.max(0.0).sqrt() / mean }
        })
    }
}
