//! Observer of one robot or docked cluster: its state now, and the acceleration by what no model knows, from late and noisy fixes.
//!
//! ```text
//! M ν̇ + C(ν)ν + D(ν)ν + g(η) = T u + M a_u              between fixes, with the thrusts that should be given      (7)
//! r = z − x(t_c)                                          at a fix, against what was held true of the time it was taken
//! x(t) += r (g + h δ + k δ²)    v(t) += r (h + 2k δ)/T    a_u += 2k r/T²      for all t ≥ t_c,  δ = (t − t_c)/T
//! g = 1 − θ³      h = 3/2 (1−θ)² (1+θ)      k = (1−θ)³/2      θ = e^(−ω T)
//! ```
//!
//! Gains of the fading-memory filter of second degree (Brookner, *Tracking and Kalman Filtering Made Easy*, 1998, table 1.7-1): all
//! three poles of the error at θ. What it extrapolates is the model and not a parabola, so that planned accelerations cost no lag, and
//! ω may be as low as what is *not* known is slow. A fix that is late corrects the past from its time on, and with it the present.
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | z, t_c | fix and the time it was captured | world; m, s |
//! | x, v | position and velocity; for the attitude r is a rotation vector and v are rates | world and m, body and rad |
//! | a_u | acceleration by currents, buoyancy, trim, wrong coefficients | linear: world, m/s²; angular: body, rad/s² |
//! | ω | bandwidth: [`CALM_RAD_S`], and up to [`BANDWIDTH_RAD_S`] while the mean of r shows that the model is missed | rad/s |
//! | T | time between two fixes | s |
//!
//! Assumptions and limits: a_u changes slowly against 1/ω. Fixes later than [`PAST_S`] are left aside.

use std::collections::VecDeque;

use nalgebra::{UnitQuaternion, Vector3, Vector6};

use super::super::configuration_matrix::ConfigurationMatrix;
use super::super::dynamics::{Dynamics, State};

/// Greatest bandwidth ω, rad/s, while fixes miss the model. *Assumed*: above that of the controller, so that a push is answered.
pub const BANDWIDTH_RAD_S: f64 = 3.5;
/// Least, rad/s, while they do not. *Assumed*: 2 mm and 0.01 rad of noise at 100 Hz become less than 1 mm/s and 3 mrad/s, which keeps
/// propellers from answering noise.
pub const CALM_RAD_S: f64 = 1.2;
/// Fixes miss the model when their mean over [`MISSES_S`] is off by so much, m. *Assumed*: five times what is left of that noise.
const MISSES_M: f64 = 2.5e-3;
/// The same, rad.
const MISSES_RAD: f64 = 1e-2;
/// Time constant of that mean, s.
const MISSES_S: f64 = 0.3;
/// What was held true is remembered for this time, s: more than any latency worth steering with.
pub const PAST_S: f64 = 1.0;
/// Longest step of integration, s.
const STEP_MOST_S: f64 = 0.010;
/// The time between fixes counts as no longer, s: after a gap the first fix is not believed alone.
const STEP_BELIEVED_S: f64 = 0.1;

/// What was held true of one moment.
#[derive(Clone, Copy, Debug)]
struct Past {
    at_s: f64,
    position_m: Vector3<f64>,
    attitude: UnitQuaternion<f64>,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Observer {
    dynamics: Dynamics,
    matrix: ConfigurationMatrix,
    state: State,
    unknown: Vector6<f64>,
    past: VecDeque<Past>,
    fixed_s: Option<f64>,
    /// Mean of r: m, rad.
    missed: [Vector3<f64>; 2],
}

impl Observer {
    /// Of a body with these equations of motion and thrusters that is in `state`, where nothing unknown acts.
    #[must_use]
    pub fn new(dynamics: Dynamics, matrix: ConfigurationMatrix, state: State) -> Self {
        let (unknown, missed) = (Vector6::zeros(), [Vector3::zeros(); 2]);
        Self { dynamics, matrix, state, unknown, past: VecDeque::new(), fixed_s: None, missed }
    }

    /// The same for another body, `part`, that sits at `arm_m` on this one, turned by `turn`: it goes on from what is known.
    #[must_use]
    pub fn passed_on(
        &self,
        (dynamics, matrix): (Dynamics, ConfigurationMatrix),
        arm_m: &Vector3<f64>,
        turn: &UnitQuaternion<f64>,
    ) -> Self {
        let past = self.past.iter().map(|then| Past {
            at_s: then.at_s,
            position_m: then.position_m + then.attitude * arm_m,
            attitude: then.attitude * turn,
        });
        let angular = turn.inverse_transform_vector(&self.unknown.fixed_rows::<3>(3).into());
        let mut unknown = self.unknown;
        unknown.fixed_rows_mut::<3>(3).copy_from(&angular);
        let state = self.state.carried(arm_m, turn);
        Self {
            dynamics,
            matrix,
            state,
            unknown,
            past: past.collect(),
            fixed_s: self.fixed_s,
            missed: self.missed,
        }
    }

    /// What is held true now.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// a_u: linear part in the world, angular part in the body.
    #[must_use]
    pub fn unknown(&self) -> &Vector6<f64> {
        &self.unknown
    }

    /// T: which wrench each thruster gives.
    #[must_use]
    pub fn matrix(&self) -> &ConfigurationMatrix {
        &self.matrix
    }

    /// M a_u in the body, N and N·m: the wrench of what no model knows.
    #[must_use]
    pub fn unknown_wrench(&self) -> Vector6<f64> {
        self.dynamics.mass_matrix() * self.in_body()
    }

    /// A wrench that is known from now on is unknown no more.
    pub fn explain(&mut self, wrench: &Vector6<f64>) {
        let Some(factor) = self.dynamics.mass_matrix().cholesky() else { return };
        let a = factor.solve(wrench);
        let linear: Vector3<f64> = self.state.attitude * Vector3::from(a.fixed_rows::<3>(0));
        self.unknown -= Vector6::new(linear.x, linear.y, linear.z, a[3], a[4], a[5]);
    }

    fn in_body(&self) -> Vector6<f64> {
        let linear = self.unknown.fixed_rows::<3>(0).into_owned();
        let linear = self.state.attitude.inverse_transform_vector(&linear);
        Vector6::new(linear.x, linear.y, linear.z, self.unknown[3], self.unknown[4], self.unknown[5])
    }

    /// Lets `dt_s` pass until `now_s` under these thrusts, N; `None` while the body is held in its place.
    pub fn advance(&mut self, now_s: f64, dt_s: f64, thrusts_n: Option<&[f64]>) {
        match thrusts_n {
            Some(thrusts_n) => {
                // τ = T u + M a_u
                let tau = Vector6::from(self.matrix.wrench(thrusts_n)) + self.unknown_wrench();
                self.dynamics.advance(&mut self.state, &tau, dt_s, STEP_MOST_S);
            }
            None => (self.state.nu, self.unknown) = (Vector6::zeros(), Vector6::zeros()),
        }
        while self.past.front().is_some_and(|then| now_s - then.at_s > PAST_S) {
            self.past.pop_front();
        }
        let State { position_m, attitude, .. } = self.state;
        self.past.push_back(Past { at_s: now_s, position_m, attitude });
    }

    /// Takes a fix that was captured at `at_s`; one that is older than the last, or too old, is left aside.
    pub fn take(&mut self, at_s: f64, position_m: &Vector3<f64>, attitude: &UnitQuaternion<f64>) {
        let fresh_s = at_s - self.fixed_s.unwrap_or(at_s - STEP_MOST_S);
        let Some(then) = self.held(at_s).filter(|_| fresh_s > 0.0) else { return };
        self.fixed_s = Some(at_s);
        let step_s = fresh_s.min(STEP_BELIEVED_S);
        // r = z − x(t_c)
        let off_m = position_m - then.position_m;
        let off_rad = (then.attitude.inverse() * attitude).scaled_axis();
        let theta = (-self.bandwidth_rad_s(&[off_m, off_rad], step_s) * step_s).exp();
        let left = 1.0 - theta;
        let (g, h, k) = (1.0 - theta.powi(3), 1.5 * left.powi(2) * (1.0 + theta), 0.5 * left.powi(3));
        let shift = |later: f64| g + later * (h + k * later);
        let mut newest = 0.0;
        for past in self.past.iter_mut().filter(|past| past.at_s >= at_s) {
            newest = (past.at_s - at_s) / step_s;
            past.position_m += off_m * shift(newest);
            past.attitude *= UnitQuaternion::from_scaled_axis(off_rad * shift(newest));
        }
        let speed = (h + 2.0 * k * newest) / step_s;
        self.state.position_m += off_m * shift(newest);
        self.state.attitude *= UnitQuaternion::from_scaled_axis(off_rad * shift(newest));
        let v = self.state.attitude.inverse_transform_vector(&(off_m * speed));
        let omega = off_rad * speed;
        self.state.nu += Vector6::new(v.x, v.y, v.z, omega.x, omega.y, omega.z);
        let (a, alpha) = (off_m * (2.0 * k / step_s.powi(2)), off_rad * (2.0 * k / step_s.powi(2)));
        self.unknown += Vector6::new(a.x, a.y, a.z, alpha.x, alpha.y, alpha.z);
    }

    /// ω by the mean of r, which this one joins.
    fn bandwidth_rad_s(&mut self, off: &[Vector3<f64>; 2], step_s: f64) -> f64 {
        for (mean, off) in self.missed.iter_mut().zip(off) {
            *mean += (off - *mean) * (step_s / MISSES_S).min(1.0);
        }
        let [off_m, off_rad] = self.missed.map(|mean| mean.norm());
        let level = (off_m / MISSES_M).max(off_rad / MISSES_RAD);
        CALM_RAD_S + (BANDWIDTH_RAD_S - CALM_RAD_S) * (2.0 * level - 1.0).clamp(0.0, 1.0)
    }

    /// What was held true of a moment, between two steps; of one later than the last step that one.
    fn held(&self, at_s: f64) -> Option<Past> {
        let after = self.past.partition_point(|then| then.at_s < at_s);
        let Some(next) = self.past.get(after) else { return self.past.back().copied() };
        let last = self.past.get(after.checked_sub(1)?)?;
        let share = (at_s - last.at_s) / (next.at_s - last.at_s);
        let turn = (last.attitude.inverse() * next.attitude).scaled_axis() * share;
        Some(Past {
            at_s,
            position_m: last.position_m.lerp(&next.position_m, share),
            attitude: last.attitude * UnitQuaternion::from_scaled_axis(turn),
        })
    }
}

#[cfg(test)]
mod tests;
