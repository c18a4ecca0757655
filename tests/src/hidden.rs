//! Hidden boats: boat and water differ from what the host believes, and the host is not told.
//!
//! Each is drawn from its seed: drag of each axis × 0.5 to 2, dry mass × 0.5 to 1.5, added mass, thrust × 0.6 to 1.6, ± 15 % from module to
//! module, pose latency of 0 to 0.15 s stamped on arrival, noise × 1 to 5, a current of up to 0.02 m/s in any direction, gusts of 0.005 m/s.

use std::f64::consts::TAU;
use std::fmt::Write;

use modboat::parameters::Parameters;
use modboat::structure::Structure;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// A hidden boat.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// `[tank]`, `[tank.thrust]` and `[mocap]` of a scenario that hides it.
    pub tables: String,
    /// What `flotilla identify` calls its constants, with their true values.
    pub truth: Vec<(&'static str, f64)>,
    /// Thrust of each module over the mean.
    pub shares: Vec<f64>,
}

impl Hidden {
    /// The boat `seed` of this structure, about which `belief` is held.
    #[must_use]
    pub fn new(structure: &Structure, belief: &Parameters, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // Drawn by its logarithm: halved as often as doubled.
        let mut factor = |low: f64, high: f64| -> f64 { rng.random_range(low.ln()..high.ln()).exp() };
        let drag = [0, 1].map(|_| factor(0.5, 2.0) * belief.drag_n_s2_m2);
        let (mass, thrust) = (factor(0.5, 1.5) * belief.module_mass_kg, factor(0.6, 1.6));
        let added = [0, 1, 2].map(|_| factor(0.25, 0.9));
        let shares: Vec<f64> = structure.cells().iter().map(|_| rng.random_range(0.85..1.15)).collect();
        let (speed, course) = (rng.random_range(0.0..0.02), rng.random_range(0.0..TAU));
        let current = [speed * f64::cos(course), speed * f64::sin(course)];
        let (latency, noise) = (rng.random_range(0.0..0.15), rng.random_range(1.0..5.0));
        let (slope, offset) = (thrust * belief.force_slope_n_rad, thrust * belief.force_offset_n);
        let inertia = mass * belief.module_inertia_kg_m2 / belief.module_mass_kg;
        let mut tables = String::new();
        let _ = write!(
            tables,
            "[tank]\nmodule_mass_kg = {mass}\nmodule_inertia_kg_m2 = {inertia}\nadded_mass_sway = {}\nadded_mass_surge = {}\n\
             added_inertia = {}\ndrag_sway_n_s2_m2 = {}\ndrag_surge_n_s2_m2 = {}\ncurrent_m_s = [{}, {}]\ngust_m_s = 0.005\n\
             [tank.thrust]\nslope_n_rad = {slope}\noffset_n = {offset}\nmodule_share = {shares:?}\n\
             [mocap]\nposition_noise_m = {}\nheading_noise_rad = {}\nlatency_s = {latency}\nstamped_on_arrival = true\n",
            added[0],
            added[1],
            added[2],
            drag[0],
            drag[1],
            current[0],
            current[1],
            5e-4 * noise,
            2e-3 * noise,
        );
        let mean = (shares.iter().map(|share| share.ln()).sum::<f64>() / shares.len() as f64).exp();
        let wet = |axis: usize| (1.0 + added[axis]) * mass;
        let (slope, offset) = (mean * slope, mean * offset);
        let positions = structure.positions_m(belief.pitch_m);
        let square: f64 = positions.iter().map(|[x, y]| x * x + y * y).sum();
        let wet_inertia = (1.0 + added[2]) * (structure.len() as f64 * inertia + mass * square);
        // (p3): a module at rᵢ meets the water across rᵢ.
        let yaw = |[x, y]: &[f64; 2]| {
            let r = x.hypot(*y);
            let along_surge = if r > 0.0 { (x / r).powi(2) } else { 0.0 };
            (drag[0] + (drag[1] - drag[0]) * along_surge) * r.powi(3) + belief.yaw_drag_n_m_s2
        };
        let truth = vec![
            ("structure_yaw_drag_n_m_s2", positions.iter().map(yaw).sum()),
            ("drag_sway_n_s2_m2", drag[0]),
            ("drag_surge_n_s2_m2", drag[1]),
            ("mass_sway_kg", wet(0)),
            ("mass_surge_kg", wet(1)),
            ("structure_inertia_kg_m2", wet_inertia),
            ("force_slope_n_rad", slope),
            ("force_offset_n", offset),
            ("current_east_m_s", current[0]),
            ("current_north_m_s", current[1]),
            ("latency_s", latency),
            ("drag_over_mass_sway_1_m", drag[0] / wet(0)),
            ("drag_over_mass_surge_1_m", drag[1] / wet(1)),
            ("slope_over_mass_surge_m_s2_rad", slope / wet(1)),
            ("slope_over_drag_sway_m2_s2_rad", slope / drag[0]),
            ("slope_over_drag_surge_m2_s2_rad", slope / drag[1]),
        ];
        Self { tables, truth, shares: shares.iter().map(|share| share / mean).collect() }
    }
}
