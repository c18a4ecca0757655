//! The constants that are looked for, as one vector θ.
//!
//! | θ | what | unit | in θ as |
//! |---|---|---|---|
//! | M_x, M_y | mass of the structure with the water that moves along, sway and surge | kg | ln |
//! | I | moment of inertia with water | kg·m² | ln |
//! | D_x, D_y | drag of the structure, sway and surge | N·s²/m² | ln |
//! | C_R | yaw drag of the structure | N·m·s² | ln |
//! | ρ | offset over slope of law (2): half the sweep after which flippers push | rad | ln |
//! | J | moment of inertia of rotor and tail | kg·m² | ln |
//! | c | drag of a tail about its motor axis | N·m·s² | c / [`TAIL_DRAG_UNIT`] |
//! | σ_x, σ_Θ | noise of a fix | m, rad | ln |
//! | σ_g, τ_g | gusts: deviation and memory | m/s, s | ln |
//! | q_v, q_Ω | accelerations that nothing explains, white | m/s²/√Hz, rad/s²/√Hz | ln |
//! | κᵢ | slope of law (2) of module i | N/rad | ln |
//! | c_x, c_y | mean current, of each log | m/s | c / [`CURRENT_UNIT`] |
//! | δ | by how much stamps of poses are later than those of tails, of each log | s | δ / [`LATENCY_UNIT`] |
//!
//! Each has a weak prior about the belief, so that every search has an end: deviations of a factor e for what is in θ as a logarithm, and
//! of several units for the others. Data of a run of minutes weigh a hundred times as much for everything that they show.

use super::data::Boat;

pub(crate) const MASS: [usize; 2] = [0, 1];
pub(crate) const INERTIA: usize = 2;
pub(crate) const DRAG: [usize; 2] = [3, 4];
pub(crate) const YAW_DRAG: usize = 5;
pub(crate) const RATIO: usize = 6;
pub(crate) const ROTOR: usize = 7;
pub(crate) const TAIL_DRAG: usize = 8;
pub(crate) const POSITION_NOISE: usize = 9;
pub(crate) const HEADING_NOISE: usize = 10;
pub(crate) const GUST: usize = 11;
pub(crate) const GUST_TIME: usize = 12;
pub(crate) const PUSH: usize = 13;
pub(crate) const TWIST: usize = 14;
const FIXED: usize = 15;

/// Unit of a tail's drag in θ, N·m·s².
pub const TAIL_DRAG_UNIT: f64 = 2e-5;
/// Unit of currents in θ, m/s.
pub const CURRENT_UNIT: f64 = 0.02;
/// Unit of latencies in θ, s.
pub const LATENCY_UNIT: f64 = 0.1;

/// Water that moves along, as a share of the dry mass and inertia, where the search begins. *Assumed*.
const ADDED: f64 = 0.5;

/// Which element of θ is what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Modules of the structure.
    pub modules: usize,
    /// Logs.
    pub logs: usize,
}

impl Layout {
    /// Elements of θ.
    #[must_use]
    pub const fn len(self) -> usize {
        FIXED + self.modules + 3 * self.logs
    }

    /// Never.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        false
    }

    pub(crate) const fn slope(self, module: usize) -> usize {
        FIXED + module
    }

    pub(crate) const fn current(self, log: usize, axis: usize) -> usize {
        FIXED + self.modules + 3 * log + axis
    }

    pub(crate) const fn latency(self, log: usize) -> usize {
        self.current(log, 2)
    }

    /// The log whose own constant this is, if it is one's.
    pub(crate) const fn log_of(self, index: usize) -> Option<usize> {
        let own = FIXED + self.modules;
        if index < own { None } else { Some((index - own) / 3) }
    }

    /// What is of the noise, and not of the boat or the water.
    pub(crate) const fn is_noise(index: usize) -> bool {
        index >= POSITION_NOISE && index < FIXED
    }

    /// Short name, for correlations and directions that are not told apart.
    #[must_use]
    pub fn name(self, index: usize, ids: &[u16]) -> String {
        const NAMES: [&str; FIXED] = [
            "mass sway",
            "mass surge",
            "inertia",
            "drag sway",
            "drag surge",
            "yaw drag",
            "offset/slope",
            "rotor inertia",
            "tail drag",
            "position noise",
            "heading noise",
            "gust",
            "gust memory",
            "push noise",
            "twist noise",
        ];
        if let Some(name) = NAMES.get(index) {
            return (*name).to_owned();
        }
        match self.log_of(index) {
            None => format!("slope of module {}", ids.get(index - FIXED).copied().unwrap_or_default()),
            Some(log) => {
                let what = ["current east", "current north", "latency"][(index - FIXED - self.modules) % 3];
                if self.logs > 1 { format!("{what}, log {}", log + 1) } else { what.to_owned() }
            }
        }
    }

    /// θ where the search begins, and the deviation of each element's prior.
    #[must_use]
    pub fn prior(self, boat: &Boat) -> (Vec<f64>, Vec<f64>) {
        let (structure, belief) = (&boat.structure, &boat.belief);
        let modules = self.modules as f64;
        let mass_kg = (1.0 + ADDED) * structure.mass_kg(belief);
        let drag = modules * belief.drag_n_s2_m2;
        let ratio_rad = belief.force_offset_n / belief.force_slope_n_rad;
        let mut theta = vec![0.0; self.len()];
        let mut deviation = vec![1.0; self.len()];
        for (index, value, spread) in [
            (MASS[0], mass_kg, 1.0),
            (MASS[1], mass_kg, 1.0),
            (INERTIA, (1.0 + ADDED) * structure.inertia_kg_m2(belief), 1.0),
            (DRAG[0], drag, 1.0),
            (DRAG[1], drag, 1.0),
            (YAW_DRAG, structure.yaw_drag_n_m_s2(belief), 1.0),
            // The flippers' opening is geometry: a third of it either way.
            (RATIO, ratio_rad, 0.3),
            (ROTOR, boat.rotor_inertia_kg_m2, 1.0),
            (POSITION_NOISE, 1e-3, 2.0),
            (HEADING_NOISE, 4e-3, 2.0),
            (GUST, 4e-3, 2.0),
            // The memory of gusts is hardly told from their size in minutes: assumed, within a third.
            (GUST_TIME, 5.0, 0.3),
            (PUSH, 1e-3, 2.0),
            (TWIST, 4e-3, 2.0),
        ] {
            theta[index] = f64::max(value, 1e-12).ln();
            deviation[index] = spread;
        }
        deviation[TAIL_DRAG] = 3.0;
        for module in 0..self.modules {
            theta[self.slope(module)] = belief.force_slope_n_rad.ln();
        }
        for log in 0..self.logs {
            for axis in 0..2 {
                deviation[self.current(log, axis)] = 3.0;
            }
            deviation[self.latency(log)] = 3.0;
        }
        (theta, deviation)
    }
}

/// θ in units, for one log.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    pub mass_kg: [f64; 2],
    pub inertia_kg_m2: f64,
    pub drag: [f64; 2],
    pub yaw_drag: f64,
    pub ratio_rad: f64,
    pub rotor_kg_m2: f64,
    pub tail_drag: f64,
    pub position_noise_m: f64,
    pub heading_noise_rad: f64,
    pub gust_m_s: f64,
    pub gust_time_s: f64,
    pub push: f64,
    pub twist: f64,
    pub slope_n_rad: Vec<f64>,
    pub current_m_s: [f64; 2],
    pub latency_s: f64,
}

impl Values {
    pub(crate) fn new(theta: &[f64], layout: Layout, log: usize) -> Self {
        let of = |index: usize| theta[index].exp();
        Self {
            mass_kg: MASS.map(of),
            inertia_kg_m2: of(INERTIA),
            drag: DRAG.map(of),
            yaw_drag: of(YAW_DRAG),
            ratio_rad: of(RATIO),
            rotor_kg_m2: of(ROTOR),
            tail_drag: TAIL_DRAG_UNIT * theta[TAIL_DRAG],
            position_noise_m: of(POSITION_NOISE),
            heading_noise_rad: of(HEADING_NOISE),
            gust_m_s: of(GUST),
            gust_time_s: of(GUST_TIME),
            push: of(PUSH),
            twist: of(TWIST),
            slope_n_rad: (0..layout.modules).map(|module| of(layout.slope(module))).collect(),
            current_m_s: [0, 1].map(|axis| CURRENT_UNIT * theta[layout.current(log, axis)]),
            latency_s: LATENCY_UNIT * theta[layout.latency(log)],
        }
    }
}
