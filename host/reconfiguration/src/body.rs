//! Constants of the motion of one rigid body under water: mass, weight, buoyancy, inertia, hydrodynamics.
//!
//! What moves a [`Vehicle`](super::vehicle::Vehicle), and what `flotilla simulate` is given in a request.
//! Body frame: x forward, y right, z down, about the body origin O.
//!
//! Assumed: added mass and damping are diagonal at O (three planes of symmetry), as in the models that are published
//! for vehicles of this kind.

use quantity::{ParameterError, Range, check_ranges};
use serde::{Deserialize, Serialize};

/// Standard acceleration of gravity g, m/s² (3rd CGPM, 1901).
pub const GRAVITY_M_S2: f64 = 9.806_65;

/// One rigid body under water.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Weight W, N.
    pub weight_n: f64,
    /// Buoyancy B = ρ g ∇, N.
    pub buoyancy_n: f64,
    /// Centre of gravity (1), m.
    pub r_g_m: [f64; 3],
    /// Centre of buoyancy (2), m.
    pub r_b_m: [f64; 3],
    /// Moments of inertia about the centre of gravity, kg·m².
    pub inertia_kg_m2: [f64; 3],
    /// Diagonal of M_A, kg and kg·m².
    pub added_mass: [f64; 6],
    /// Diagonal of D_V, N/(m/s) and N·m/(rad/s).
    pub linear_damping: [f64; 6],
    /// Diagonal of D_N at unit speed, N/(m/s)² and N·m/(rad/s)².
    pub quadratic_damping: [f64; 6],
}

impl Body {
    /// Refuses what no body can have, by the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges(&[
            ("mass_kg", self.mass_kg, "kg", Range::Positive),
            ("weight_n", self.weight_n, "N", Range::NonNegative),
            ("buoyancy_n", self.buoyancy_n, "N", Range::NonNegative),
        ])?;
        let lengths = [("r_g_m", self.r_g_m), ("r_b_m", self.r_b_m)];
        for (key, values) in lengths {
            check_ranges(&values.map(|value| (key, value, "m", Range::Finite)))?;
        }
        check_ranges(&self.inertia_kg_m2.map(|value| ("inertia_kg_m2", value, "kg·m²", Range::Positive)))?;
        for (key, values, units) in [
            ("added_mass", self.added_mass, ["kg", "kg·m²"]),
            ("linear_damping", self.linear_damping, ["N/(m/s)", "N·m/(rad/s)"]),
            ("quadratic_damping", self.quadratic_damping, ["N/(m/s)²", "N·m/(rad/s)²"]),
        ] {
            // Less than none would feed the motion from nothing.
            for (axis, value) in values.into_iter().enumerate() {
                check_ranges(&[(key, value, units[axis / 3], Range::NonNegative)])?;
            }
        }
        Ok(())
    }
}
