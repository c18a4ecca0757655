//! The constants of a Modboat: what its tail may be asked, its motor and its encoder.

use core::f32::consts::TAU;

use serde::{Deserialize, Serialize};

use super::finite;
use crate::configuration::ConfigurationError;
use crate::time::Duration;
use crate::units::{Amperes, Radians, RadiansPerSecond};

/// A tail: `firmware::modboat`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TailConstants {
    /// What it may be asked.
    pub limits: TailLimits,
    /// The motor and its loop.
    pub servo: ServoConstants,
    /// The encoder.
    pub encoder: EncoderConstants,
}

/// Bounds on one cycle: `firmware::modboat::limits`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TailLimits {
    /// Least |A|; exactly zero (rest) is allowed besides.
    pub amplitude_min: Radians,
    /// Greatest |A|.
    pub amplitude_max: Radians,
    /// Greatest |φ₀| as sent; farther out `f32` is too coarse to say where the tail points.
    pub centerline_max: Radians,
    /// Greatest |Δφ| of a transition.
    pub rotation_max: Radians,
    /// Greatest speed of the tail, in the waveform and in the transition.
    pub speed_max: RadiansPerSecond,
    /// Least period T.
    pub period_min: Duration,
    /// Greatest period T.
    pub period_max: Duration,
    /// Greatest transition time t_trans.
    pub transition_max: Duration,
}

impl Default for TailLimits {
    /// Those of the planner: amplitudes from law (2) of the paper, the rest *assumed*.
    fn default() -> Self {
        Self {
            amplitude_min: Radians(0.9),
            amplitude_max: Radians(2.6),
            centerline_max: Radians(1000.0),
            rotation_max: Radians(2.0 * TAU),
            speed_max: RadiansPerSecond(13.0),
            period_min: Duration(500_000),
            period_max: Duration(10_000_000),
            transition_max: Duration(10_000_000),
        }
    }
}

/// Motor constants, gains and limits of the servo loop: `firmware::modboat::servo`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServoConstants {
    /// No-load speed ω₀ at full drive.
    pub no_load_speed: RadiansPerSecond,
    /// Mechanical time constant τ_m, s.
    pub time_constant_s: f32,
    /// Position gain k_p, 1/s.
    pub position_gain_per_s: f32,
    /// Rate gain k_d, 1.
    pub rate_gain: f32,
    /// Greatest speed ω_max that reference and position error together may ask for.
    pub speed_max: RadiansPerSecond,
    /// Current I_stall at full drive with the axis held.
    pub stall_current: Amperes,
    /// Current limit I_max.
    pub current_max: Amperes,
    /// Error from which on the tail counts as lagging: with one reading of the encoder at most what plans keep free about planned angles.
    pub following_error_max: Radians,
    /// How long it may lag before it is stopped.
    pub following_error_time: Duration,
    /// Interval of the loop.
    pub interval: Duration,
}

impl Default for ServoConstants {
    /// All *assumed*, to be replaced by measurement.
    fn default() -> Self {
        Self {
            no_load_speed: RadiansPerSecond(18.0),
            time_constant_s: 0.02,
            position_gain_per_s: 60.0,
            rate_gain: 1.2,
            speed_max: RadiansPerSecond(15.0),
            stall_current: Amperes(1.8),
            current_max: Amperes(1.2),
            following_error_max: Radians(0.020),
            following_error_time: Duration(50_000),
            interval: Duration(1000),
        }
    }
}

/// The encoder, how it sits on the axis, and how it finds its zero: `firmware::modboat::encoder` and `homing`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EncoderConstants {
    /// Counts in one turn of the tail, each edge of both lines, gears included; 0: the encoder is absolute, and the board knows.
    pub counts_per_turn: u32,
    /// How it sits on the axis.
    pub mounting: EncoderMounting,
    /// Speed at which the tail looks for the index after boot, counter-clockwise; 0: it is turned by hand.
    pub homing_speed: RadiansPerSecond,
    /// Wait after boot before it does.
    pub homing_after: Duration,
}

/// How the encoder sits on the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EncoderMounting {
    /// Reading n₀ at which the tail points along x_S, in readings of the encoder: with an index, 1/65536 of a turn beyond it.
    pub zero_counts: u32,
    /// True if readings fall while the tail turns counter-clockwise.
    pub reversed: bool,
}

impl TailConstants {
    pub(super) fn check(&self) -> Result<(), ConfigurationError> {
        let Self { limits, servo, encoder } = self;
        finite(&[
            ("amplitude_min", limits.amplitude_min.0, "rad"),
            ("amplitude_max", limits.amplitude_max.0, "rad"),
            ("centerline_max", limits.centerline_max.0, "rad"),
            ("rotation_max", limits.rotation_max.0, "rad"),
            ("speed_max", limits.speed_max.0, "rad/s"),
            ("servo.no_load_speed", servo.no_load_speed.0, "rad/s"),
            ("servo.time_constant_s", servo.time_constant_s, "s"),
            ("servo.position_gain_per_s", servo.position_gain_per_s, "1/s"),
            ("servo.rate_gain", servo.rate_gain, "1"),
            ("servo.speed_max", servo.speed_max.0, "rad/s"),
            ("servo.stall_current", servo.stall_current.0, "A"),
            ("servo.current_max", servo.current_max.0, "A"),
            ("servo.following_error_max", servo.following_error_max.0, "rad"),
            ("encoder.homing_speed", encoder.homing_speed.0, "rad/s"),
        ])
    }
}
