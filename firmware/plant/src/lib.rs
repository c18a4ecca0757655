//! A DC gear motor with the tail on its shaft, in the water: what the firmware drives where there is no real one.
//!
//! ```text
//! φ̈_m = clamp((ω₀·d − φ̇)/τ_m, ±α_max)          what the motor gives (coasting: zero)             (m1)
//! φ̈   = φ̈_m − (c/J)·φ̇|φ̇|                       less what the water takes                         (m2)
//! i    = J·φ̈_m / k_t                            current                                           (m3)
//! ```
//!
//! Assumptions and limits: φ is measured against the structure, whose own (slow) yaw acceleration does not act
//! back on the motor. No dead band, friction or backlash; no winding inductance, so torque follows duty at once,
//! and τ_m is the mechanical time constant. Every number in [`Constants`] is *assumed*.
#![no_std]

/// Motor, rotor and tail. *Assumed* throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// No-load speed ω₀ at full duty, rad/s.
    pub no_load_speed_rad_s: f64,
    /// Mechanical time constant τ_m, s.
    pub time_constant_s: f64,
    /// Torque limit as an acceleration α_max, rad/s².
    pub acceleration_max_rad_s2: f64,
    /// Moment of inertia J of rotor and tail about the motor axis, kg·m².
    pub rotor_inertia_kg_m2: f64,
    /// Quadratic drag c of the tail in the water, N·m·s².
    pub tail_drag_n_m_s2: f64,
    /// Torque constant k_t at the shaft, after the gears, N·m/A.
    pub torque_constant_n_m_a: f64,
}

impl Default for Constants {
    fn default() -> Self {
        Self {
            no_load_speed_rad_s: 18.0,
            time_constant_s: 0.02,
            acceleration_max_rad_s2: 600.0,
            rotor_inertia_kg_m2: 1.5e-4,
            tail_drag_n_m_s2: 2e-5,
            torque_constant_n_m_a: 0.09,
        }
    }
}

/// The drive that a bridge gives at a duty in 0..1 with its direction inputs so; nothing while it coasts.
///
/// | in1, in2 | bridge | d |
/// |---|---|---|
/// | high, low | forward, the tail turns counter-clockwise | +duty |
/// | low, high | reverse, clockwise | −duty |
/// | high, high | brake: winding shorted | 0 |
/// | low, low | coast: winding open, no current | none |
#[must_use]
pub fn drive(duty: f64, in1: bool, in2: bool) -> Option<f64> {
    match (in1, in2) {
        (true, false) => Some(duty),
        (false, true) => Some(-duty),
        (true, true) => Some(0.0),
        (false, false) => None,
    }
}

/// One motor with its tail.
#[derive(Clone, Debug)]
pub struct Motor {
    constants: Constants,
    angle_rad: f64,
    rate_rad_s: f64,
    acceleration_rad_s2: f64,
    current_a: f64,
    jammed: bool,
}

impl Motor {
    /// At rest, with the tail at `angle_rad`.
    #[must_use]
    pub const fn new(constants: Constants, angle_rad: f64) -> Self {
        Self {
            constants,
            angle_rad,
            rate_rad_s: 0.0,
            acceleration_rad_s2: 0.0,
            current_a: 0.0,
            jammed: false,
        }
    }

    /// Goes on by `dt_s` with `drive` in −1..1; nothing: it coasts.
    ///
    /// The exponential step gives (m1) exactly while the limit does not bind, and the drag of (m2) is taken
    /// implicitly, so no step length makes it unstable.
    pub fn step(&mut self, drive: Option<f64>, dt_s: f64) {
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        let c = &self.constants;
        let mean_of_step = -libm::expm1(-dt_s / c.time_constant_s) / dt_s;
        // φ̈_m = clamp((ω₀·d − φ̇)/τ_m, ±α_max)                                                    (m1)
        let motor_rad_s2 = drive.map_or(0.0, |d| {
            ((c.no_load_speed_rad_s * d - self.rate_rad_s) * mean_of_step)
                .max(-c.acceleration_max_rad_s2)
                .min(c.acceleration_max_rad_s2)
        });
        let rate_rad_s = if self.jammed {
            0.0
        } else {
            // φ̈ = φ̈_m − (c/J)·φ̇|φ̇|                                                              (m2)
            let drag_per_rad = c.tail_drag_n_m_s2 / c.rotor_inertia_kg_m2;
            (self.rate_rad_s + motor_rad_s2 * dt_s)
                / (1.0 + drag_per_rad * libm::fabs(self.rate_rad_s) * dt_s)
        };
        self.acceleration_rad_s2 = (rate_rad_s - self.rate_rad_s) / dt_s;
        self.angle_rad += 0.5 * (self.rate_rad_s + rate_rad_s) * dt_s;
        self.rate_rad_s = rate_rad_s;
        // i = J·φ̈_m / k_t                                                                          (m3)
        self.current_a = c.rotor_inertia_kg_m2 * motor_rad_s2 / c.torque_constant_n_m_a;
    }

    /// Blocks the shaft (weed, a rope) or frees it again. A blocked motor draws its stall current.
    pub const fn set_jammed(&mut self, jammed: bool) {
        self.jammed = jammed;
    }

    /// True angle φ, rad (unwrapped).
    #[must_use]
    pub const fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Angular velocity φ̇, rad/s.
    #[must_use]
    pub const fn rate_rad_s(&self) -> f64 {
        self.rate_rad_s
    }

    /// Mean angular acceleration φ̈ of the last step, rad/s².
    #[must_use]
    pub const fn acceleration_rad_s2(&self) -> f64 {
        self.acceleration_rad_s2
    }

    /// Mean motor current of the last step, A.
    #[must_use]
    pub const fn current_a(&self) -> f64 {
        self.current_a
    }
}

/// Reading of an absolute encoder of `counts` a turn with its magnet at `shaft_rad`, 0..`counts`.
#[must_use]
pub fn encoder_counts(shaft_rad: f64, counts: u32) -> u32 {
    let turns = shaft_rad / core::f64::consts::TAU;
    // Rounding can bring the rest of a tiny negative number up to a whole turn.
    let within = turns - libm::floor(turns);
    ((within * f64::from(counts)) as u32) % counts.max(1)
}
