//! Dynamics of a robot or a cluster in six degrees of freedom.
//!
//! ```text
//! η̇ = J(η) ν                                                                             (6), (8)
//! M ν̇ + C(ν)ν + D(ν)ν + g(η) = τ,      M = M_RB + M_A                                        (7)
//! C(ν) = [   0     −S(a) ]     a = M₁₁v + M₁₂ω     (Fossen 2011, theorem 3.2)
//!        [ −S(a)   −S(b) ]     b = M₂₁v + M₂₂ω
//! ```
//!
//! As printed, (7) has no C: then a body that turns would gain or lose energy from nothing, and the Munk moment
//! (w u (Z_ẇ − X_u̇), which pitches a vehicle up at speed) is missing. C is linear in M, so C = C_RB + C_A at once.
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | η = (x, y, z, φ, θ, ψ) | pose, ZYX Euler angles | world; m, rad |
//! | ν = (v, ω) = (u, v, w, p, q, r) | velocity | body; m/s, rad/s |
//! | τ | wrench at the body origin | body; N, N·m |
//! | D(ν)ν, g(η) | [`Cluster::drag`], [`Hydrostatics::restoring`](super::hydrostatics::Hydrostatics::restoring) | body; N, N·m |
//!
//! J(η) is singular at θ = ±90°. Attitude is therefore integrated as a unit quaternion, q̇ = ½ q ∘ (0, ω), and
//! Euler angles are read off when asked for.
//!
//! Steps: the classical fourth-order Runge–Kutta method. At [`STEP_S`] the error over 20 s is below 10⁻⁶ m, rad, m/s
//! and rad/s for the vehicles that come with the program.
//!
//! Limits: still water; no tether; coefficients that do not depend on frequency.

use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector3, Vector6};
use quantity::wrap_rad;
use thiserror::Error;

use super::cluster::Cluster;

/// Default step of integration, s.
pub const STEP_S: f64 = 1e-3;

/// Why a body has no equations of motion.
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum DynamicsError {
    /// M is not positive definite.
    #[error("the least eigenvalue of the mass matrix is {least:e} (kg, kg·m²): must be greater than zero")]
    Mass { least: f64 },
}

/// Pose and velocity of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Body origin in the world, m.
    pub position_m: Vector3<f64>,
    /// Body to world.
    pub attitude: UnitQuaternion<f64>,
    /// Velocity ν in the body frame.
    pub nu: Vector6<f64>,
}

impl State {
    /// From η with ZYX Euler angles, and ν.
    #[must_use]
    pub fn from_eta(eta: &[f64; 6], nu: &[f64; 6]) -> Self {
        let [x, y, z, phi, theta, psi] = *eta;
        Self {
            position_m: Vector3::new(x, y, z),
            attitude: UnitQuaternion::from_euler_angles(phi, theta, psi),
            nu: Vector6::from(*nu),
        }
    }

    /// η with ZYX Euler angles within (−π, π]. Straight up or down only φ ∓ ψ is defined: there φ is zero.
    #[must_use]
    pub fn eta(&self) -> [f64; 6] {
        let r = self.attitude.to_rotation_matrix();
        let level = r[(0, 0)].hypot(r[(1, 0)]);
        let theta = (-r[(2, 0)]).atan2(level);
        let (phi, psi) = if level > 1e-12 {
            (r[(2, 1)].atan2(r[(2, 2)]), r[(1, 0)].atan2(r[(0, 0)]))
        } else {
            (0.0, (-r[(0, 1)]).atan2(r[(1, 1)]))
        };
        let p = &self.position_m;
        [p.x, p.y, p.z, wrap_rad(phi), wrap_rad(theta), wrap_rad(psi)]
    }

    /// The state of what is fixed to this body at `arm_m` (body), turned by `turn` from it.
    #[must_use]
    pub fn carried(&self, arm_m: &Vector3<f64>, turn: &UnitQuaternion<f64>) -> Self {
        let (v, omega): (Vector3<f64>, Vector3<f64>) =
            (self.nu.fixed_rows::<3>(0).into(), self.nu.fixed_rows::<3>(3).into());
        let v = turn.inverse_transform_vector(&(v + omega.cross(arm_m)));
        let omega = turn.inverse_transform_vector(&omega);
        Self {
            position_m: self.position_m + self.attitude * arm_m,
            attitude: self.attitude * turn,
            nu: Vector6::new(v.x, v.y, v.z, omega.x, omega.y, omega.z),
        }
    }

    fn down(&self) -> Vector3<f64> {
        self.attitude.inverse_transform_vector(&Vector3::z())
    }

    /// This state after `dt_s` at the rate `rate`; the quaternion is not yet of unit length.
    fn along(&self, rate: &Rate, dt_s: f64) -> (Vector3<f64>, Quaternion<f64>, Vector6<f64>) {
        (
            self.position_m + dt_s * rate.position,
            *self.attitude.quaternion() + rate.attitude * dt_s,
            self.nu + dt_s * rate.nu,
        )
    }
}

/// Time derivative of a [`State`].
struct Rate {
    position: Vector3<f64>,
    attitude: Quaternion<f64>,
    nu: Vector6<f64>,
}

/// Equations of motion of one rigid body or cluster.
#[derive(Clone, Debug)]
pub struct Dynamics {
    cluster: Cluster,
    mass: Matrix6<f64>,
    inverse: Matrix6<f64>,
}

impl Dynamics {
    /// The equations of motion of this cluster.
    ///
    /// # Errors
    /// [`DynamicsError::Mass`] for what cannot be accelerated.
    pub fn new(cluster: &Cluster) -> Result<Self, DynamicsError> {
        let mass = cluster.rigid_body_mass() + cluster.added_mass();
        let least = mass.symmetric_eigenvalues().min();
        let inverse = mass.cholesky().map(|factor| factor.inverse()).ok_or(DynamicsError::Mass { least })?;
        Ok(Self { cluster: cluster.clone(), mass, inverse })
    }

    /// The cluster whose equations these are.
    #[must_use]
    pub fn cluster(&self) -> &Cluster {
        &self.cluster
    }

    /// Mass matrix M = M_RB + M_A.
    #[must_use]
    pub fn mass_matrix(&self) -> &Matrix6<f64> {
        &self.mass
    }

    /// ν̇ under the wrench τ: M⁻¹(τ − C(ν)ν − D(ν)ν − g(η))                                      (7)
    #[must_use]
    pub fn acceleration(&self, state: &State, tau: &Vector6<f64>) -> Vector6<f64> {
        let nu = &state.nu;
        let drag = Vector6::from(self.cluster.drag(&(*nu).into()));
        let restoring = self.cluster.hydrostatics().restoring(&state.down());
        self.inverse * (tau - coriolis(&self.mass, nu) * nu - drag - restoring)
    }

    fn rate(&self, state: &State, tau: &Vector6<f64>) -> Rate {
        let nu = &state.nu;
        let omega = Quaternion::new(0.0, nu[3], nu[4], nu[5]);
        Rate {
            position: state.attitude * Vector3::new(nu[0], nu[1], nu[2]),
            // q̇ = ½ q ∘ (0, ω)
            attitude: state.attitude.quaternion() * omega * 0.5,
            nu: self.acceleration(state, tau),
        }
    }

    /// One step of `dt_s` under a constant wrench.
    pub fn step(&self, state: &mut State, tau: &Vector6<f64>, dt_s: f64) {
        // A stage only turns vectors with its quaternion; its length is second order in the step and matters there.
        let stage = |rate: &Rate, dt_s: f64| {
            let (position_m, attitude, nu) = state.along(rate, dt_s);
            State { position_m, attitude: UnitQuaternion::new_normalize(attitude), nu }
        };
        let k1 = self.rate(state, tau);
        let k2 = self.rate(&stage(&k1, dt_s / 2.0), tau);
        let k3 = self.rate(&stage(&k2, dt_s / 2.0), tau);
        let k4 = self.rate(&stage(&k3, dt_s), tau);
        let sixth = Rate {
            position: (k1.position + 2.0 * (k2.position + k3.position) + k4.position) / 6.0,
            attitude: (k1.attitude + (k2.attitude + k3.attitude) * 2.0 + k4.attitude) / 6.0,
            nu: (k1.nu + 2.0 * (k2.nu + k3.nu) + k4.nu) / 6.0,
        };
        *state = stage(&sixth, dt_s);
    }

    /// On by `duration_s` under a constant wrench, in equal steps of at most `step_s`.
    pub fn advance(&self, state: &mut State, tau: &Vector6<f64>, duration_s: f64, step_s: f64) {
        let steps = (duration_s / step_s).ceil().max(1.0);
        for _ in 0..steps as u64 {
            self.step(state, tau, duration_s / steps);
        }
    }
}

/// C(ν) of a mass matrix M, skew-symmetric: it does no work.
#[must_use]
pub fn coriolis(mass: &Matrix6<f64>, nu: &Vector6<f64>) -> Matrix6<f64> {
    let momentum = mass * nu;
    let [a, b] = [0, 3].map(|row| momentum.fixed_rows::<3>(row).cross_matrix());
    let mut c = Matrix6::zeros();
    c.fixed_view_mut::<3, 3>(0, 3).copy_from(&-a);
    c.fixed_view_mut::<3, 3>(3, 0).copy_from(&-a);
    c.fixed_view_mut::<3, 3>(3, 3).copy_from(&-b);
    c
}

#[cfg(test)]
mod tests;
