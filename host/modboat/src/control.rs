//! From the velocity and heading that are wanted to the wrench that is demanded of the next cycle, (13)–(19).
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

use quantity::{ParameterError, check_within, wrap_rad};
use serde::{Deserialize, Serialize};

use super::motion::Wrench;
use super::parameters::Parameters;
use super::structure::Structure;

/// Gains and limits of the controller. None are in the paper: *assumed*, see the module's text for why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlConfig {
    /// K_p,Θ, 1/s².
    pub yaw_proportional_1_s2: f64,
    /// K_d,Θ, 1/s.
    pub yaw_derivative_1_s: f64,
    /// g of (15): how much of what is new of the unknown torque is taken off at each decision.
    pub yaw_trim: f64,
    /// K_p,v, 1/s.
    pub velocity_proportional_1_s: f64,
    /// K_d,v, dimensionless. Zero by default: a difference over one interval is mostly noise.
    pub velocity_derivative: f64,
    /// K_x of (20), 1/s.
    pub position_proportional_1_s: f64,
    /// v_max of (20), m/s.
    pub position_speed_max_m_s: f64,
    /// γ of (18): what is left of the sum after one interval.
    pub leak: f64,
    /// Water that turns with the structure: total inertia / dry inertia.
    pub added_inertia_factor: f64,
    /// Water that moves along with the structure: total mass / dry mass. Zero leaves inertia out, as printed.
    pub added_mass_factor: f64,
    /// Share of the greatest thrust that the least-norm allocation of the demand may ask of any module. Below one,
    /// because collisions shrink the envelope.
    pub thrust_share: f64,
    /// Share of `thrust_share` that torque alone may take, so that some is left to hold against a current.
    pub torque_share: f64,
}

impl Default for ControlConfig {
    fn default() -> Self {
        Self {
            yaw_proportional_1_s2: 0.15,
            yaw_derivative_1_s: 0.3,
            yaw_trim: 0.15,
            velocity_proportional_1_s: 0.25,
            velocity_derivative: 0.0,
            position_proportional_1_s: 0.2,
            position_speed_max_m_s: 0.04,
            leak: 0.95,
            added_inertia_factor: 1.2,
            added_mass_factor: 1.5,
            thrust_share: 0.9,
            torque_share: 0.7,
        }
    }
}

impl ControlConfig {
    /// Refuses what the controller cannot work with, by the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let gain = "must be from 0 to 10";
        let share = "must be from 0.01 to 1";
        check_within(&[
            ("yaw_proportional_1_s2", self.yaw_proportional_1_s2, "1/s²", 0.0..=10.0, gain),
            ("yaw_derivative_1_s", self.yaw_derivative_1_s, "1/s", 0.0..=10.0, gain),
            ("yaw_trim", self.yaw_trim, "", 0.0..=1.0, "must be from 0 to 1"),
            ("velocity_proportional_1_s", self.velocity_proportional_1_s, "1/s", 0.0..=10.0, gain),
            ("velocity_derivative", self.velocity_derivative, "", 0.0..=10.0, gain),
            ("position_proportional_1_s", self.position_proportional_1_s, "1/s", 0.0..=10.0, gain),
            ("position_speed_max_m_s", self.position_speed_max_m_s, "m/s", 0.0..=10.0, gain),
            ("leak", self.leak, "", 0.0..=1.0, "must be from 0 to 1"),
            ("added_inertia_factor", self.added_inertia_factor, "", 1.0..=10.0, "must be from 1 to 10"),
            ("added_mass_factor", self.added_mass_factor, "", 0.0..=10.0, "must be from 0 to 10"),
            ("thrust_share", self.thrust_share, "", 0.01..=1.0, share),
            ("torque_share", self.torque_share, "", 0.01..=1.0, share),
        ])
    }
}

/// Demanded velocity and heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Velocity in the world, m/s.
    pub velocity_m_s: [f64; 2],
    /// Heading Θ of the surge axis, rad counter-clockwise from world x.
    pub heading_rad: f64,
}

/// Observed motion of the structure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Velocity in the world, m/s.
    pub velocity_m_s: [f64; 2],
    /// Heading Θ, rad; may be unwrapped.
    pub heading_rad: f64,
    /// Angular velocity Ω, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Acceleration in the world that neither wrench nor drag explains, m/s².
    pub unknown_m_s2: [f64; 2],
    /// Angular acceleration that neither torque nor drag explains, rad/s².
    pub unknown_rad_s2: f64,
}

/// PID control of velocity and heading, one call a decision.
#[derive(Clone, Debug)]
pub struct Controller {
    config: ControlConfig,
    modules: f64,
    period_s: f64,
    mass_kg: f64,
    inertia_kg_m2: f64,
    yaw_drag_n_m_s2: f64,
    drag_n_s2_m2: f64,
    positions_m: Vec<[f64; 2]>,
    /// Σ |rᵢ|², m².
    square_radius_m2: f64,
    /// Greatest |rᵢ|, m.
    radius_m: f64,
    thrust_max_n: f64,
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
        let positions_m = structure.positions_m(parameters.pitch_m);
        let square = |p: &[f64; 2]| p[0] * p[0] + p[1] * p[1];
        let modules = structure.len() as f64;
        Self {
            config: config.clone(),
            modules,
            period_s: parameters.period_s,
            mass_kg: config.added_mass_factor * structure.mass_kg(parameters),
            inertia_kg_m2: config.added_inertia_factor * structure.inertia_kg_m2(parameters),
            yaw_drag_n_m_s2: structure.yaw_drag_n_m_s2(parameters),
            drag_n_s2_m2: modules * parameters.drag_n_s2_m2,
            square_radius_m2: positions_m.iter().map(square).sum(),
            radius_m: positions_m.iter().map(square).fold(0.0, f64::max).sqrt(),
            positions_m,
            thrust_max_n: parameters.thrust_n(parameters.amplitude_max_rad),
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
        let tau_nm = self.clamp_torque(duty * torque_nm);
        let acceleration = self.acceleration(target, observed, interval_s);
        let (v_des, theta) = (target.velocity_m_s, observed.heading_rad);
        let held = self.sum_m_s2.map(|s| self.config.leak * s);
        // s ← γ s + a,  v_c = v_des + s·T                                                (18)
        let full = [0, 1].map(|k| held[k] + acceleration[k]);
        let commanded = [0, 1].map(|k| v_des[k] + full[k] * interval_s);
        let wanted = [0, 1].map(|k| acceleration[k] - observed.unknown_m_s2[k]);
        let (drag_n, inertia_n) = (self.drag_force(commanded, theta), self.inertia_force(wanted, theta));
        let [fx_n, fy_n] = [0, 1].map(|k| duty * (drag_n[k] + inertia_n[k]));
        let scale = self.force_scale([fx_n, fy_n], tau_nm);
        // Where the thrusters are at their limit, the sum may shrink and not grow.
        self.sum_m_s2 = [0, 1]
            .map(|k| if scale < 1.0 && acceleration[k] * commanded[k] > 0.0 { held[k] } else { full[k] });
        Wrench { fx_n: scale * fx_n, fy_n: scale * fy_n, tau_nm }
    }

    /// The velocity (world) to ask for on the way to a station, (20); `horizon_s` as for [`demand`](Self::demand).
    #[must_use]
    pub fn towards(
        &self,
        station_m: [f64; 2],
        position_m: [f64; 2],
        observed: &Observation,
        horizon_s: f64,
    ) -> [f64; 2] {
        // e_x = x_des − (x_obs + v_obs·h),  v_des = K_x e_x, at most v_max                (20)
        let wanted = [0, 1].map(|k| {
            let ahead_m = position_m[k] + observed.velocity_m_s[k] * horizon_s;
            self.config.position_proportional_1_s * (station_m[k] - ahead_m)
        });
        let speed = wanted[0].hypot(wanted[1]);
        let most = self.config.position_speed_max_m_s;
        if speed > most { wanted.map(|v| v * most / speed) } else { wanted }
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

    fn clamp_torque(&self, tau_nm: f64) -> f64 {
        if self.radius_m == 0.0 {
            return 0.0; // A lone module's thrust passes through its centre.
        }
        // The least-norm share of module i is τ·|rᵢ| / Σ|r|².
        let limit_n = self.config.torque_share * self.config.thrust_share * self.thrust_max_n;
        let limit_nm = limit_n * self.square_radius_m2 / self.radius_m;
        tau_nm.clamp(-limit_nm, limit_nm)
    }

    /// The greatest factor ≤ 1 on the force with which no module's least-norm share
    ///
    /// fᵢ = F/N + τ·(−yᵢ, xᵢ)/Σ|r|²
    ///
    /// exceeds its limit.
    fn force_scale(&self, [fx_n, fy_n]: [f64; 2], tau_nm: f64) -> f64 {
        let limit_n = self.config.thrust_share * self.thrust_max_n;
        let force = [fx_n / self.modules, fy_n / self.modules];
        let square = force[0] * force[0] + force[1] * force[1];
        if square == 0.0 {
            return 1.0;
        }
        let lever = if self.square_radius_m2 > 0.0 { tau_nm / self.square_radius_m2 } else { 0.0 };
        let mut scale: f64 = 1.0;
        for &[x_m, y_m] in &self.positions_m {
            let turning = [-lever * y_m, lever * x_m];
            // |s·f + t| = limit: the greater root of f² s² + 2 f·t s + t² − limit² = 0.
            let half = force[0] * turning[0] + force[1] * turning[1];
            let rest = turning[0] * turning[0] + turning[1] * turning[1] - limit_n * limit_n;
            let root = (half * half - square * rest).max(0.0).sqrt();
            scale = scale.min((root - half) / square);
        }
        scale.max(0.0)
    }
}

#[cfg(test)]
mod tests;
