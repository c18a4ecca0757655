//! The paper's controller as corrected: from the velocity and heading that are wanted to the wrench of the next cycle, (13)–(19).
//!
//! Yaw:
//!
//! ```text
//! e_Θ = wrap(Θ_des − (Θ_obs + Ω·h))              printed: without wrap, h = T        (13)
//! α   = K_p,Θ e_Θ + K_d,Θ de_Θ/dt,  de_Θ/dt = −Ω                                   (14)
//! d̄   ← d̄ + g(d_Θ − d̄),   τ = I(α − d̄) + C_R |Ω| Ω      printed: without d̄; d_Θ of the observer, (o6)   (15)
//! ```
//!
//! Velocity, in the world:
//!
//! ```text
//! e_v = v_des − v_obs                                                              (16)
//! a   = K_p,v e_v + K_d,v de_v/dt                                                  (17)
//! s   ← γ s + a,   v_c = v_des + s·T             printed: γⁿ⁻¹ Σ a + a              (18)
//! F   = N C_L v_S |v_S| + M (a − d)_S            printed: C_L Rᵀ (v_c ⊙ v_c)        (19)
//! v_S = (v_c·x_S, v_c·y_S), (a − d)_S likewise; d of the observer, (o6)
//! x_S = (sin Θ, −cos Θ),  y_S = (cos Θ, sin Θ)
//! ```
//!
//! Position, where a station is to be kept instead of a velocity (the paper has none):
//!
//! ```text
//! e_x = x_des − (x_obs + v_obs·h)
//! v_des = K_x e_x,  shortened to v_max where it is longer                              (20)
//! ```
//!
//! What was changed, and why:
//! - (13) predicts over T, but a decision holds for the transition too: h is the caller's whole horizon.
//! - (14): the heading wanted is constant within a leg, so that de_Θ/dt = −Ω, without the noise of a difference.
//! - (18): γⁿ⁻¹ multiplies the whole sum and kills it after some cycles; a leaky sum is meant.
//! - (19): the printed matrix is the transpose of the rotation that fits Fig. 1 and (7), and v ⊙ v loses the
//!   sign; C_L is that of one module here, hence N. Quadratic drag alone answers an error about a standstill with
//!   next to no force, so that a structure told to stop drifts on for a minute: M·a, the force that gives the
//!   mass its acceleration (17), is added. For the same reason the leaky sum has no hold on a slow drift: the acceleration d that
//!   nothing known explains is taken off.
//! - (15): a servo that falls a little short on one side of the structure leaves a lasting torque, and with it a lasting error of the
//!   heading: τ/(I·K_p,Θ), 1 mrad for 1e-5 N·m at three modules. d̄ takes it off, slowly, as d_Θ is a noisy estimate: g = 0.15 is
//!   some 10 s.
//! - A cycle pushes during T of every interval; the demand is raised by interval / T so that the mean is right.
//!
//! Gains, for an interval h = 2 s. With the drag compensated by (15), yaw is a double integrator,
//! Θ' = Θ + hΩ + ½h²α, Ω' = Ω + hα, under α = K_p(Θ_des − Θ) − (K_p h + K_d)Ω. Its poles are the roots of
//!
//! ```text
//! z² + (h b + ½h² K_p − 2) z + (1 − h b + ½h² K_p),   b = K_p h + K_d
//! ```
//!
//! stable for h b < 2 (else a root passes −1). K_p = 0.15 1/s², K_d = 0.3 1/s give h b = 1.2 and roots of magnitude
//! 0.32: some 6 s to settle, and the inertia may be wrong by a factor of 1.6 before it oscillates.
//!
//! Velocity: with M·a in (19) an error shrinks by 1 − K_p,v·h = 0.5 a decision, whatever the speed. The leaky sum
//! trims what is left: K_p,v·h/(1 − γ) = 10 lowers the effect of a drag that is 15 % wrong below 1 %.
//!
//! Position: over h = 2 s the velocity loop halves its error, v' = v/2 + v_des/2, and v_des = K_x(e − v·h) by (20), so that
//! K_x = 0.2 1/s gives e' = 0.9e − 1.3v, v' = 0.1e + 0.3v, with roots of magnitude 0.63: some 15 s to settle. What a current asks
//! for is kept by the leaky sum, so that the offset that remains is small and not zero.

use quantity::wrap_rad;

use super::limits::Limits;
use super::{ControlConfig, Observation, Target};
use crate::motion::Wrench;
use crate::parameters::Parameters;
use crate::structure::Structure;

/// PID control of velocity and heading, one call a decision.
#[derive(Clone, Debug)]
pub struct Controller {
    config: ControlConfig,
    period_s: f64,
    mass_kg: f64,
    inertia_kg_m2: f64,
    yaw_drag_n_m_s2: f64,
    drag_n_s2_m2: f64,
    limits: Limits,
    /// The leaky sum s of (18), m/s².
    sum_m_s2: [f64; 2],
    /// d̄ of (15), rad/s².
    trim_rad_s2: f64,
    last_error_m_s: Option<[f64; 2]>,
}

impl Controller {
    /// A controller at rest, with an empty sum.
    #[must_use]
    pub fn new(structure: &Structure, parameters: &Parameters, config: &ControlConfig) -> Self {
        Self {
            config: config.clone(),
            period_s: parameters.period_s,
            mass_kg: config.added_mass_factor * structure.mass_kg(parameters),
            inertia_kg_m2: config.added_inertia_factor * structure.inertia_kg_m2(parameters),
            yaw_drag_n_m_s2: structure.yaw_drag_n_m_s2(parameters),
            drag_n_s2_m2: structure.len() as f64 * parameters.drag_n_s2_m2,
            limits: Limits::new(structure, parameters, config),
            sum_m_s2: [0.0; 2],
            trim_rad_s2: 0.0,
            last_error_m_s: None,
        }
    }

    /// The wrench to demand of the next cycle. `interval_s` is the time between decisions, `horizon_s` the time
    /// from the observation to the end of what this decision governs.
    pub fn demand(
        &mut self,
        target: &Target,
        observed: &Observation,
        interval_s: f64,
        horizon_s: f64,
    ) -> Wrench {
        // Pushing lasts T of every interval.
        let duty = (interval_s / self.period_s).max(1.0);
        let torque_nm = self.torque(target, observed, horizon_s);
        let tau_nm = self.limits.clamp_torque(duty * torque_nm);
        let acceleration = self.acceleration(target, observed, interval_s);
        let (v_des, theta) = (target.velocity_m_s, observed.heading_rad);
        let held = self.sum_m_s2.map(|s| self.config.leak * s);
        // s ← γ s + a,  v_c = v_des + s·T                                                (18)
        let full = [0, 1].map(|k| held[k] + acceleration[k]);
        let commanded = [0, 1].map(|k| v_des[k] + full[k] * interval_s);
        let wanted = [0, 1].map(|k| acceleration[k] - observed.unknown_m_s2[k]);
        let (drag_n, inertia_n) = (self.drag_force(commanded, theta), self.inertia_force(wanted, theta));
        let [fx_n, fy_n] = [0, 1].map(|k| duty * (drag_n[k] + inertia_n[k]));
        let scale = self.limits.force_scale([fx_n, fy_n], tau_nm);
        // Where the thrusters are at their limit, the sum may shrink and not grow.
        self.sum_m_s2 = [0, 1]
            .map(|k| if scale < 1.0 && acceleration[k] * commanded[k] > 0.0 { held[k] } else { full[k] });
        Wrench { fx_n: scale * fx_n, fy_n: scale * fy_n, tau_nm }
    }

    fn torque(&mut self, target: &Target, observed: &Observation, horizon_s: f64) -> f64 {
        let omega = observed.yaw_rate_rad_s;
        // e_Θ = wrap(Θ_des − (Θ_obs + Ω·h))                                              (13)
        let error_rad = wrap_rad(target.heading_rad - (observed.heading_rad + omega * horizon_s));
        // α = K_p,Θ e_Θ + K_d,Θ de_Θ/dt                                                  (14)
        let alpha = self.config.yaw_proportional_1_s2 * error_rad - self.config.yaw_derivative_1_s * omega;
        // d̄ ← d̄ + g(d_Θ − d̄),  τ = I (α − d̄) + C_R |Ω| Ω                                 (15)
        self.trim_rad_s2 += self.config.yaw_trim * (observed.unknown_rad_s2 - self.trim_rad_s2);
        let wanted = alpha - self.trim_rad_s2;
        self.inertia_kg_m2 * wanted + self.yaw_drag_n_m_s2 * omega.abs() * omega
    }

    fn acceleration(&mut self, target: &Target, observed: &Observation, interval_s: f64) -> [f64; 2] {
        // e_v = v_des − v_obs                                                            (16)
        let error = [0, 1].map(|k| target.velocity_m_s[k] - observed.velocity_m_s[k]);
        let last = self.last_error_m_s.replace(error).unwrap_or(error);
        // a = K_p,v e_v + K_d,v de_v/dt                                                  (17)
        [0, 1].map(|k| {
            self.config.velocity_proportional_1_s * error[k]
                + self.config.velocity_derivative * (error[k] - last[k]) / interval_s
        })
    }

    /// The force in S that holds the velocity `v_c` (world) against quadratic drag.
    fn drag_force(&self, [vx, vy]: [f64; 2], heading_rad: f64) -> [f64; 2] {
        let (sin, cos) = heading_rad.sin_cos();
        // v_S = (v_c·x_S, v_c·y_S),  F = N C_L v_S |v_S| + …                              (19)
        [vx * sin - vy * cos, vx * cos + vy * sin].map(|v| self.drag_n_s2_m2 * v * v.abs())
    }

    /// The force in S that accelerates the structure by `a` (world).
    fn inertia_force(&self, [ax, ay]: [f64; 2], heading_rad: f64) -> [f64; 2] {
        let (sin, cos) = heading_rad.sin_cos();
        // … + M (a − d)_S
        [ax * sin - ay * cos, ax * cos + ay * sin].map(|a| self.mass_kg * a)
    }
}

#[cfg(test)]
mod tests;
