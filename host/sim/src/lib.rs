//! The simulated tank: motors behind `embedded-hal` pins, thrust from the actual tail angles, the floating
//! structure, and the motion capture that watches it.
//!
//! It stands in for the hardware below the firmware: the firmware crate writes duty cycles and direction pins
//! and reads the encoder, as on a board; everything after the H-bridge is simulated here. Each step runs
//!
//! ```text
//! pins → SimMotor → TailState (φ, φ̇, φ̈, J) → Tank (Thrust per module, reaction torques, drag) → Mocap → host
//! ```
//!
//! An ROV's firmware writes pulses instead, and its propellers' thrusts come out ([`rov`]), into a water of its own
//! ([`rov::basin`]).
//!
//! All noise comes from seeded generators: the same seed and the same steps give the same run to the bit.

mod body;
pub mod clock;
mod contact;
pub mod lab;
pub mod mocap;
pub mod module;
pub mod motor;
pub mod node;
pub mod remote;
pub mod rov;
pub mod tank;
pub mod thrust;
pub mod tracking;
pub mod waves;

#[cfg(test)]
mod tests;

/// One tail as the water and the structure feel it at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TailState {
    /// Angle φ counter-clockwise from the sway axis x_S, rad (unwrapped).
    pub angle_rad: f64,
    /// Angular velocity φ̇ relative to the structure, rad/s.
    pub rate_rad_s: f64,
    /// Angular acceleration φ̈ relative to the structure over the step that ends here, rad/s².
    pub acceleration_rad_s2: f64,
    /// Moment of inertia J of everything that turns with the tail, kg·m².
    pub inertia_kg_m2: f64,
}
