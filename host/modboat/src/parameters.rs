//! The numbers that describe one kind of Modboat, in one struct that a scenario's `[modboat]` table overrides.
//!
//! The paper publishes the law (2), T = 1.5 s and the amplitude range; geometry, mass and drag it does not.
//! Those are *assumed* and meant to be replaced by measurement.

use quantity::{ParameterError, check_within};
use serde::{Deserialize, Serialize};

/// Shares of law (2) that are taken. *Assumed*: one that gives less is out of order.
const SHARES: std::ops::RangeInclusive<f64> = 0.1..=4.0;

/// Geometry, thrust law, mass, drag and timing of one Modboat module. All in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Lattice pitch d: the distance between the centres of two docked neighbours, m. *Assumed.*
    pub pitch_m: f64,
    /// Tail capsule: length of its centre line from the motor axis, m (0.60 d). *Assumed.*
    pub tail_length_m: f64,
    /// Tail capsule: full width, m (0.10 d). *Assumed.*
    pub tail_width_m: f64,
    /// Period T of the waveform (1), s. Paper, footnote 1.
    pub period_s: f64,
    /// Duration t_trans of a transition at constant speed, s; at the tail's greatest speed it also bounds a rotation. *Assumed*: the
    /// paper asks for a small one.
    pub transition_s: f64,
    /// Least amplitude |A| of law (2), rad. Paper.
    pub amplitude_min_rad: f64,
    /// Greatest amplitude |A| of law (2), rad. Paper.
    pub amplitude_max_rad: f64,
    /// Slope of law (2), N/rad. Paper.
    pub force_slope_n_rad: f64,
    /// Offset of law (2), N: F(A) = slope·|A| − offset. Paper.
    pub force_offset_n: f64,
    /// Mass of one module, kg. *Assumed.*
    pub module_mass_kg: f64,
    /// Moment of inertia I₁ of one module about its own vertical axis, kg·m². *Assumed.*
    pub module_inertia_kg_m2: f64,
    /// Moment of inertia J of one tail with its rotor about the motor axis, kg·m²: its turning turns the structure the other way.
    /// *Assumed.*
    pub tail_inertia_kg_m2: f64,
    /// Translational drag C_L of one module: F = C_L·v|v|, N·s²/m². *Assumed.*
    pub drag_n_s2_m2: f64,
    /// Rotational drag of one module about its own vertical axis: τ = c·Ω|Ω|, N·m·s². *Assumed.*
    pub yaw_drag_n_m_s2: f64,
    /// Greatest speed of a tail relative to the body, rad/s. *Assumed.*
    pub tail_speed_max_rad_s: f64,
    /// Greatest acceleration of a tail in a transition, rad/s². *Assumed*: with it a motor 20 % weaker than nominal still has
    /// torque in hand at the speed of a transition.
    pub tail_acceleration_max_rad_s2: f64,
    /// Greatest error of a tail's servo about its reference, rad: what a module keeps, or stops at. *Measured* of the simulated
    /// motor with 20 % of spread: 0.0165 (`sim::tracking`).
    pub tracking_error_rad: f64,
    /// Greatest error of a module's fleet time while it moves, s: one that is not sure within this starts no cycle
    /// (`firmware::link::session::SURE_WITHIN`).
    pub clock_error_s: f64,
    /// How far beyond the ends of a swing a tail can come to rest that loses its power, rad, its servo's error included.
    /// *Measured* of the simulated motor with 20 % of spread, braked by its winding: 0.0234 (`sim::tracking`).
    pub stop_past_swing_rad: f64,
    /// The same beyond the end of a transition, rad. *Measured* as that: 0.0854.
    pub stop_past_turn_rad: f64,
    /// Share of law (2) that each module gives, by place; empty: one each. A module with weed about its flippers gives less.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub module_share: Vec<f64>,
}

/// Share of the tail's greatest speed that transitions are planned for. *Assumed*: a servo needs some in hand.
pub const SPEED_SHARE: f64 = 0.8;

impl Default for Parameters {
    fn default() -> Self {
        Self {
            pitch_m: 0.15,
            tail_length_m: 0.09,
            tail_width_m: 0.015,
            period_s: 1.5,
            transition_s: 0.5,
            amplitude_min_rad: 0.9,
            amplitude_max_rad: 2.6,
            force_slope_n_rad: 0.022,
            force_offset_n: 0.019,
            module_mass_kg: 1.0,
            module_inertia_kg_m2: 0.003,
            tail_inertia_kg_m2: 1.5e-4,
            drag_n_s2_m2: 4.5,
            yaw_drag_n_m_s2: 5e-4,
            tail_speed_max_rad_s: 13.0,
            tail_acceleration_max_rad_s2: 200.0,
            tracking_error_rad: 0.022,
            clock_error_s: 0.002,
            stop_past_swing_rad: 0.024,
            stop_past_turn_rad: 0.09,
            module_share: Vec::new(),
        }
    }
}

impl Parameters {
    /// Thrust of law (2), N, for an amplitude in rad (its sign does not matter):
    ///
    /// F(A) = 0.022·|A| − 0.019                                                     (2)
    #[must_use]
    pub fn thrust_n(&self, amplitude_rad: f64) -> f64 {
        self.force_slope_n_rad * amplitude_rad.abs() - self.force_offset_n
    }

    /// Share of law (2) that the module at this place gives.
    #[must_use]
    pub fn share(&self, place: usize) -> f64 {
        self.module_share.get(place).copied().unwrap_or(1.0)
    }

    /// Greatest speed of a tail in a transition, rad/s.
    #[must_use]
    pub fn transition_speed_rad_s(&self) -> f64 {
        SPEED_SHARE * self.tail_speed_max_rad_s
    }

    /// Greatest speed 2π·A_max/T of a tail in waveform (1), rad/s.
    #[must_use]
    pub fn swing_speed_max_rad_s(&self) -> f64 {
        self.amplitude_max_rad * std::f64::consts::TAU / self.period_s
    }

    /// Duration of a transition in which the longest rotation is `longest_rad`, and of each of its two ramps, s: as short as
    /// speed v and acceleration α allow, from rest to rest.
    ///
    /// t_trans = Δφ/v + v/α, tᵣ = v/α   if Δφ ≥ v²/α,   otherwise   t_trans = 2·√(Δφ/α), tᵣ = t_trans/2
    #[must_use]
    pub fn transition_times_s(&self, longest_rad: f64) -> (f64, f64) {
        let longest_rad = longest_rad.abs();
        let (speed_rad_s, acceleration_rad_s2) =
            (self.transition_speed_rad_s(), self.tail_acceleration_max_rad_s2);
        let ramp_s = speed_rad_s / acceleration_rad_s2;
        if longest_rad >= speed_rad_s * ramp_s {
            (longest_rad / speed_rad_s + ramp_s, ramp_s)
        } else {
            let transition_s = 2.0 * (longest_rad / acceleration_rad_s2).sqrt();
            (transition_s, 0.5 * transition_s)
        }
    }

    /// Refuses shares of law (2) that are not of so many modules.
    pub fn validate_shares(&self, modules: usize) -> Result<(), ParameterError> {
        let count = self.module_share.len();
        if count == 0 || count == modules {
            return Ok(());
        }
        let reason = "must be one for each module of the structure, or none";
        Err(ParameterError { key: "module_share", value: count as f64, unit: "numbers", reason })
    }

    /// Refuses what no Modboat can have, by the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let fail = |key, value, unit, reason| Err(ParameterError { key, value, unit, reason });
        for (key, value, unit) in [
            ("pitch_m", self.pitch_m, "m"),
            ("tail_length_m", self.tail_length_m, "m"),
            ("tail_width_m", self.tail_width_m, "m"),
            ("period_s", self.period_s, "s"),
            ("transition_s", self.transition_s, "s"),
            ("amplitude_min_rad", self.amplitude_min_rad, "rad"),
            ("amplitude_max_rad", self.amplitude_max_rad, "rad"),
            ("force_slope_n_rad", self.force_slope_n_rad, "N/rad"),
            ("module_mass_kg", self.module_mass_kg, "kg"),
            ("module_inertia_kg_m2", self.module_inertia_kg_m2, "kg·m²"),
            ("drag_n_s2_m2", self.drag_n_s2_m2, "N·s²/m²"),
            ("yaw_drag_n_m_s2", self.yaw_drag_n_m_s2, "N·m·s²"),
            ("tail_speed_max_rad_s", self.tail_speed_max_rad_s, "rad/s"),
            ("tail_acceleration_max_rad_s2", self.tail_acceleration_max_rad_s2, "rad/s²"),
        ] {
            if !value.is_finite() || value <= 0.0 {
                return fail(key, value, unit, "must be a finite number greater than zero");
            }
            if value > 1e4 {
                return fail(key, value, unit, "must be at most 10000");
            }
        }
        if !self.force_offset_n.is_finite() || self.force_offset_n < 0.0 {
            let reason = "must be a finite number, zero or greater";
            return fail("force_offset_n", self.force_offset_n, "N", reason);
        }
        if self.amplitude_min_rad > self.amplitude_max_rad {
            let reason = "must not exceed amplitude_max_rad: the range is reversed";
            return fail("amplitude_min_rad", self.amplitude_min_rad, "rad", reason);
        }
        if self.amplitude_max_rad > std::f64::consts::PI {
            let reason = "must be at most π: a tail swings at most once around each way";
            return fail("amplitude_max_rad", self.amplitude_max_rad, "rad", reason);
        }
        if self.thrust_n(self.amplitude_min_rad) < 0.0 {
            let reason = "gives a negative thrust by law (2)";
            return fail("amplitude_min_rad", self.amplitude_min_rad, "rad", reason);
        }
        // A tail that reaches its neighbour's motor axis has no free pose beside it.
        if self.tail_length_m + self.tail_width_m >= self.pitch_m {
            let reason = "tail length and width together must stay below the pitch";
            return fail("tail_length_m", self.tail_length_m, "m", reason);
        }
        check_within(&[
            ("tail_inertia_kg_m2", self.tail_inertia_kg_m2, "kg·m²", 0.0..=1.0, "must be from 0 to 1"),
            ("tracking_error_rad", self.tracking_error_rad, "rad", 0.0..=0.5, "must be from 0 to 0.5"),
            ("clock_error_s", self.clock_error_s, "s", 0.0..=0.5, "must be from 0 to 0.5"),
            ("stop_past_swing_rad", self.stop_past_swing_rad, "rad", 0.0..=7.0, "must be from 0 to 7"),
            ("stop_past_turn_rad", self.stop_past_turn_rad, "rad", 0.0..=7.0, "must be from 0 to 7"),
        ])?;
        let share = |&share: &f64| ("module_share", share, "", SHARES, "must be from 0.1 to 4");
        check_within(&self.module_share.iter().map(share).collect::<Vec<_>>())?;
        if self.swing_speed_max_rad_s() > self.tail_speed_max_rad_s {
            let reason = "is below the peak speed 2π·amplitude_max_rad/period_s of the waveform (1)";
            return fail("tail_speed_max_rad_s", self.tail_speed_max_rad_s, "rad/s", reason);
        }
        Ok(())
    }
}
