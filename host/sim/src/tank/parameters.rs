//! `[tank]`: what the water and the boat in it are really like, whatever the host believes.
//!
//! Everything that stands in `[modboat]` as well is left out by default, and then as it is there. No field can be read outside of
//! this crate: a host parses the table, keeps it in its log, and hands it to [`Tank::new`](super::Tank::new); what it plans and
//! controls by is `[modboat]`, `[control]` and `[observer]`.
//!
//! ```text
//! F_x = −(D_x·|w_x| + D_c·|w_y|)·w_x,   F_y = −(D_y·|w_y| + D_c·|w_x|)·w_y                     per module, N times   (p1)
//! τ   = −C_R·Ω|Ω| − 2s·Σᵢ(D_y·xᵢ²·|w_y| + D_x·yᵢ²·|w_x|)·Ω                                                         (p2)
//! C_R = q·Σᵢ (D(tᵢ)·rᵢ³ + C_R,own),   D(t) = D_x·t_x² + D_y·t_y²,   tᵢ across rᵢ                                   (p3)
//! ```
//!
//! w is the velocity of the drag's centre through the water. (p1) never gives energy to the body, nor does (p2). The second term of (p2) is
//! that of strip theory to first order in Ω: a module at rᵢ meets the water at v + Ω×rᵢ, and the drag's difference between two of them
//! brakes the turn. The controller's law (15) has no such term.
//!
//! Assumptions and limits: all modules float alike; what differs between them is thrust ([`ThrustParameters`]). Numbers are *assumed*.

use modboat::parameters::Parameters;
use modboat::structure::Structure;
use quantity::{ParameterError, Range, check_ranges};
use serde::{Deserialize, Serialize};

use crate::body::Body;
use crate::thrust::ThrustParameters;
use crate::waves::{JonswapParameters, WaveParameters};

/// See the module's documentation. Keys with their units stand in `host/scenarios/README.md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TankParameters {
    /// Mass of one module, kg.
    pub(crate) module_mass_kg: Option<f64>,
    /// Moment of inertia of one module about its own vertical axis, kg·m².
    pub(crate) module_inertia_kg_m2: Option<f64>,
    /// Centre of mass in S, from the mean of the modules' centres, m.
    pub(crate) centre_of_mass_m: [f64; 2],
    /// Added mass in sway as a fraction of the structure's mass.
    pub(crate) added_mass_sway: f64,
    /// Added mass in surge as a fraction of the structure's mass.
    pub(crate) added_mass_surge: f64,
    /// Added moment of inertia as a fraction of the structure's.
    pub(crate) added_inertia: f64,
    /// D_x of one module, N·s²/m².
    pub(crate) drag_sway_n_s2_m2: Option<f64>,
    /// D_y of one module, N·s²/m².
    pub(crate) drag_surge_n_s2_m2: Option<f64>,
    /// D_c of one module, N·s²/m²: motion along one axis raises the drag along the other.
    pub(crate) drag_cross_n_s2_m2: f64,
    /// Where the drag (p1) acts, in S from the mean of the modules' centres, m.
    pub(crate) drag_centre_m: [f64; 2],
    /// C_R,own of one module about its own axis, N·m·s².
    pub(crate) yaw_drag_n_m_s2: Option<f64>,
    /// q: the structure's C_R over the sum over its modules.
    pub(crate) yaw_drag_scale: f64,
    /// s: share of strip theory in the yaw damping of a moving structure.
    pub(crate) yaw_drag_speed: f64,
    /// c of (k1): quadratic drag of one tail in the water about its motor axis, as the structure feels it, N·m·s².
    pub(crate) tail_drag_n_m_s2: f64,
    /// Uniform current in the world, m/s.
    pub(crate) current_m_s: [f64; 2],
    /// Standard deviation of the gusts on top of the current, per world axis, m/s.
    pub(crate) gust_m_s: f64,
    /// Correlation time of the gusts, s.
    pub(crate) gust_time_s: f64,
    /// Thrust of the flippers.
    pub(crate) thrust: ThrustParameters,
    /// A regular wave.
    pub(crate) wave: WaveParameters,
    /// An irregular sea.
    pub(crate) jonswap: JonswapParameters,
}

impl Default for TankParameters {
    fn default() -> Self {
        Self {
            module_mass_kg: None,
            module_inertia_kg_m2: None,
            centre_of_mass_m: [0.0; 2],
            added_mass_sway: 0.5,
            added_mass_surge: 0.5,
            added_inertia: 0.5,
            drag_sway_n_s2_m2: None,
            drag_surge_n_s2_m2: None,
            drag_cross_n_s2_m2: 0.0,
            drag_centre_m: [0.0; 2],
            yaw_drag_n_m_s2: None,
            yaw_drag_scale: 1.0,
            yaw_drag_speed: 0.0,
            tail_drag_n_m_s2: 0.0,
            current_m_s: [0.0; 2],
            gust_m_s: 0.0,
            gust_time_s: 5.0,
            thrust: ThrustParameters::default(),
            wave: WaveParameters::default(),
            jonswap: JonswapParameters::default(),
        }
    }
}

impl TankParameters {
    /// Refuses what no tank with so many modules can have, by the first offending key and the table it stands in.
    ///
    /// # Errors
    /// [`ParameterError`] with the key, its value and unit, and what is asked of it.
    pub fn validate(&self, modules: usize) -> Result<(), (&'static str, ParameterError)> {
        self.thrust.validate(modules).map_err(|error| ("tank.thrust", error))?;
        self.wave.validate().map_err(|error| ("tank.wave", error))?;
        self.jonswap.validate().map_err(|error| ("tank.jonswap", error))?;
        self.validate_own().map_err(|error| ("tank", error))
    }

    fn validate_own(&self) -> Result<(), ParameterError> {
        for (key, value, unit) in [
            ("module_mass_kg", self.module_mass_kg, "kg"),
            ("module_inertia_kg_m2", self.module_inertia_kg_m2, "kg·m²"),
            ("drag_sway_n_s2_m2", self.drag_sway_n_s2_m2, "N·s²/m²"),
            ("drag_surge_n_s2_m2", self.drag_surge_n_s2_m2, "N·s²/m²"),
            ("yaw_drag_n_m_s2", self.yaw_drag_n_m_s2, "N·m·s²"),
        ] {
            if let Some(value) = value {
                check_ranges(&[(key, value, unit, Range::Positive)])?;
            }
        }
        check_ranges(&[
            ("centre_of_mass_m", self.centre_of_mass_m[0], "m", Range::Finite),
            ("centre_of_mass_m", self.centre_of_mass_m[1], "m", Range::Finite),
            ("added_mass_sway", self.added_mass_sway, "of the mass", Range::NonNegative),
            ("added_mass_surge", self.added_mass_surge, "of the mass", Range::NonNegative),
            ("added_inertia", self.added_inertia, "of the inertia", Range::NonNegative),
            ("drag_cross_n_s2_m2", self.drag_cross_n_s2_m2, "N·s²/m²", Range::NonNegative),
            ("drag_centre_m", self.drag_centre_m[0], "m", Range::Finite),
            ("drag_centre_m", self.drag_centre_m[1], "m", Range::Finite),
            ("yaw_drag_scale", self.yaw_drag_scale, "", Range::Positive),
            ("yaw_drag_speed", self.yaw_drag_speed, "", Range::NonNegative),
            ("tail_drag_n_m_s2", self.tail_drag_n_m_s2, "N·m·s²", Range::NonNegative),
            ("current_m_s", self.current_m_s[0], "m/s", Range::Finite),
            ("current_m_s", self.current_m_s[1], "m/s", Range::Finite),
            ("gust_m_s", self.gust_m_s, "m/s", Range::NonNegative),
            ("gust_time_s", self.gust_time_s, "s", Range::Positive),
        ])
    }

    /// The modules as they really are.
    pub(crate) fn real(&self, believed: &Parameters) -> Parameters {
        Parameters {
            module_mass_kg: self.module_mass_kg.unwrap_or(believed.module_mass_kg),
            module_inertia_kg_m2: self.module_inertia_kg_m2.unwrap_or(believed.module_inertia_kg_m2),
            yaw_drag_n_m_s2: self.yaw_drag_n_m_s2.unwrap_or(believed.yaw_drag_n_m_s2),
            force_slope_n_rad: self.thrust.slope_n_rad.unwrap_or(believed.force_slope_n_rad),
            force_offset_n: self.thrust.offset_n.unwrap_or(believed.force_offset_n),
            ..believed.clone()
        }
    }

    /// Refuses what the mean wrench of a cycle by the believed law (2) cannot show.
    pub(crate) fn has_mean_alone(&self) -> Result<(), ParameterError> {
        let reason = "cannot be told from the mean wrench of a cycle: tails have to be simulated for it";
        let thrust = &self.thrust;
        for (key, value, unit) in [
            ("gust_m_s", self.gust_m_s, "m/s"),
            ("tail_drag_n_m_s2", self.tail_drag_n_m_s2, "N·m·s²"),
            ("height_m", self.wave.height_m, "m"),
            ("height_m", self.jonswap.height_m, "m"),
            ("spread", thrust.spread, ""),
            ("interaction", thrust.interaction, ""),
            ("module_share", thrust.module_share.len() as f64, "numbers"),
            ("slope_n_rad", thrust.slope_n_rad.unwrap_or(0.0), "N/rad"),
            ("offset_n", thrust.offset_n.unwrap_or(0.0), "N"),
        ] {
            if value != 0.0 {
                return Err(ParameterError { key, value, unit, reason });
            }
        }
        Ok(())
    }

    /// The structure as a body in the water; `real` from [`Self::real`].
    pub(crate) fn body(&self, structure: &Structure, real: &Parameters) -> Body {
        let (mass_kg, inertia_kg_m2) = (structure.mass_kg(real), structure.inertia_kg_m2(real));
        let modules = structure.len() as f64;
        let sway_n_s2_m2 = self.drag_sway_n_s2_m2.unwrap_or(real.drag_n_s2_m2);
        let surge_n_s2_m2 = self.drag_surge_n_s2_m2.unwrap_or(real.drag_n_s2_m2);
        let (mut yaw_drag_n_m_s2, mut second_m2) = (0.0, [0.0; 2]);
        for [x_m, y_m] in structure.positions_m(real.pitch_m) {
            let r_m = x_m.hypot(y_m);
            // t_y² = x²/r² across r; a module in the middle has no arm.
            let along_surge = if r_m > 0.0 { (x_m / r_m).powi(2) } else { 0.0 };
            // C_R = Σᵢ (D(tᵢ)·rᵢ³ + C_R,own),   D(t) = D_x·t_x² + D_y·t_y²                       (p3)
            let drag_n_s2_m2 = sway_n_s2_m2 + (surge_n_s2_m2 - sway_n_s2_m2) * along_surge;
            yaw_drag_n_m_s2 += drag_n_s2_m2 * r_m.powi(3) + real.yaw_drag_n_m_s2;
            second_m2 = [second_m2[0] + y_m * y_m, second_m2[1] + x_m * x_m];
        }
        Body {
            mass_kg,
            inertia_kg_m2,
            centre_m: self.centre_of_mass_m,
            added_mass_kg: [self.added_mass_sway * mass_kg, self.added_mass_surge * mass_kg],
            added_inertia_kg_m2: self.added_inertia * inertia_kg_m2,
            drag_n_s2_m2: [modules * sway_n_s2_m2, modules * surge_n_s2_m2],
            drag_cross_n_s2_m2: modules * self.drag_cross_n_s2_m2,
            drag_centre_m: self.drag_centre_m,
            yaw_drag_n_m_s2: self.yaw_drag_scale * yaw_drag_n_m_s2,
            // 2s·Σᵢ(D_y·xᵢ²·|w_y| + D_x·yᵢ²·|w_x|)·Ω                                              (p2)
            yaw_drag_speed_n_s2: [sway_n_s2_m2 * second_m2[0], surge_n_s2_m2 * second_m2[1]]
                .map(|drag| 2.0 * self.yaw_drag_speed * drag),
        }
    }
}
