//! How much of a wrench the modules' least-norm shares can give.

use super::ControlConfig;
use crate::parameters::Parameters;
use crate::structure::Structure;

/// The greatest thrust a module is asked for, shared out by the least norm.
#[derive(Clone, Debug)]
pub(super) struct Limits {
    modules: f64,
    positions_m: Vec<[f64; 2]>,
    /// Σ |rᵢ|², m².
    square_radius_m2: f64,
    /// Greatest |rᵢ|, m.
    radius_m: f64,
    thrust_max_n: f64,
    thrust_share: f64,
    torque_share: f64,
}

impl Limits {
    pub(super) fn new(structure: &Structure, parameters: &Parameters, config: &ControlConfig) -> Self {
        let positions_m = structure.positions_m(parameters.pitch_m);
        let square = |p: &[f64; 2]| p[0] * p[0] + p[1] * p[1];
        Self {
            modules: structure.len() as f64,
            square_radius_m2: positions_m.iter().map(square).sum(),
            radius_m: positions_m.iter().map(square).fold(0.0, f64::max).sqrt(),
            positions_m,
            thrust_max_n: parameters.thrust_n(parameters.amplitude_max_rad),
            thrust_share: config.thrust_share,
            torque_share: config.torque_share,
        }
    }

    /// The greatest torque, N·m; none of a lone module, whose thrust passes through its centre.
    pub(super) fn torque_nm(&self) -> f64 {
        if self.radius_m == 0.0 {
            return 0.0;
        }
        // The least-norm share of module i is τ·|rᵢ| / Σ|r|².
        let limit_n = self.torque_share * self.thrust_share * self.thrust_max_n;
        limit_n * self.square_radius_m2 / self.radius_m
    }

    pub(super) fn clamp_torque(&self, tau_nm: f64) -> f64 {
        if self.radius_m == 0.0 {
            return 0.0;
        }
        let limit_nm = self.torque_nm();
        tau_nm.clamp(-limit_nm, limit_nm)
    }

    /// The greatest factor ≤ 1 on the force with which no module's least-norm share
    ///
    /// fᵢ = F/N + τ·(−yᵢ, xᵢ)/Σ|r|²
    ///
    /// exceeds its limit.
    pub(super) fn force_scale(&self, [fx_n, fy_n]: [f64; 2], tau_nm: f64) -> f64 {
        let limit_n = self.thrust_share * self.thrust_max_n;
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
