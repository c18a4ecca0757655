//! The constants of a module's hardware, as its firmware takes them. What each is for is said there.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::ConfigurationError;
use crate::message::MAX_THRUSTERS;
use crate::units::{Amperes, MicrosSpan, Newtons, Radians, RadiansPerSecond, Volts};

/// What the module is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Robot {
    /// One motor, one tail.
    Modboat(TailConstants),
    /// Thrusters.
    Rov(RovConstants),
}

/// What a tail may be asked, its motor and its encoder: `firmware::limits`, `servo` and `encoder`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TailConstants {
    /// Least |A| but zero.
    pub amplitude_min: Radians,
    /// Greatest |A|.
    pub amplitude_max: Radians,
    /// Greatest |φ₀|.
    pub centerline_max: Radians,
    /// Greatest |Δφ| of a transition.
    pub rotation_max: Radians,
    /// Greatest speed of a cycle.
    pub speed_max: RadiansPerSecond,
    /// Least period.
    pub period_min: MicrosSpan,
    /// Greatest period.
    pub period_max: MicrosSpan,
    /// Longest transition.
    pub transition_max: MicrosSpan,
    /// The motor and its loop.
    pub servo: ServoConstants,
    /// The encoder.
    pub encoder: EncoderConstants,
}

/// The encoder, how it sits on the axis, and how it finds its zero: `firmware::encoder` and `homing`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EncoderConstants {
    /// Counts in one turn of the tail, each edge of both lines, gears included; 0: the encoder is absolute, and the board knows.
    pub counts_per_turn: u32,
    /// How it sits on the axis.
    pub mounting: Mounting,
    /// Speed at which the tail looks for the index after boot, counter-clockwise; 0: it is turned by hand.
    pub homing_speed: RadiansPerSecond,
    /// It waits for so long after boot before it does.
    pub homing_after: MicrosSpan,
}

/// The motor and its loop.
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
    /// Greatest speed that reference and position error together may ask for.
    pub speed_max: RadiansPerSecond,
    /// Current at full drive with the axis held.
    pub stall_current: Amperes,
    /// Current limit.
    pub current_max: Amperes,
    /// Greatest error of the tail about its reference: what plans of the host keep free about planned angles.
    pub following_error_max: Radians,
    /// A tail that is beyond it for so long has failed.
    pub following_error_time: MicrosSpan,
    /// Interval of the loop.
    pub interval: MicrosSpan,
}

/// How the encoder sits on the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mounting {
    /// Reading at which the tail points along x_S, in readings of the encoder: with an index, 1/65536 of a turn beyond it.
    pub zero_counts: u32,
    /// True if readings fall while the tail turns counter-clockwise.
    pub reversed: bool,
}

/// What the board measures of its supply, and when the battery is low: `firmware::failsafe::battery`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SupplyConstants {
    /// Battery voltage for one volt at the board's input, V/V: the divider's ratio; 0: nothing is wired there.
    pub volts_per_volt: f32,
    /// Current for one volt at the board's input, A/V: of the motor, or of an ROV's battery; 0: nothing is wired there.
    pub amperes_per_volt: f32,
    /// The battery is low below this.
    pub low: Volts,
    /// And no longer from this on.
    pub recover: Volts,
    /// It must have crossed for so long.
    pub hold_off: MicrosSpan,
}

/// Thrusters, their wiring and what they may be asked: `firmware::lease` and `thruster::bank`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RovConstants {
    /// Each thruster's wiring, in the order of a cycle's thrusts.
    pub thrusters: Vec<ThrusterMounting, MAX_THRUSTERS>,
    /// Greatest |thrust|.
    pub thrust_max: Newtons,
    /// Longest lease.
    pub lease_max: MicrosSpan,
    /// Frames a second at every pin, Hz.
    pub frame_rate_hz: f32,
    /// Neutral for so long after boot.
    pub arming: MicrosSpan,
    /// Fastest growth of thrust, N/s.
    pub slew_n_s: f32,
    /// Rest at neutral before the thrust changes sign.
    pub reversal_delay: MicrosSpan,
}

/// Where one thruster is wired, and which way round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ThrusterMounting {
    /// Which pin, in the order in which the board gives them.
    pub output: u8,
    /// Thrust ahead needs a pulse below neutral.
    pub reversed: bool,
}

impl SupplyConstants {
    pub(super) fn check(&self) -> Result<(), ConfigurationError> {
        finite(&[
            ("supply.volts_per_volt", self.volts_per_volt, "V/V"),
            ("supply.amperes_per_volt", self.amperes_per_volt, "A/V"),
            ("supply.low", self.low.0, "V"),
            ("supply.recover", self.recover.0, "V"),
        ])
    }
}

impl Robot {
    pub(super) fn check(&self) -> Result<(), ConfigurationError> {
        match self {
            Self::Modboat(tail) => {
                let servo = &tail.servo;
                finite(&[
                    ("amplitude_min", tail.amplitude_min.0, "rad"),
                    ("amplitude_max", tail.amplitude_max.0, "rad"),
                    ("centerline_max", tail.centerline_max.0, "rad"),
                    ("rotation_max", tail.rotation_max.0, "rad"),
                    ("speed_max", tail.speed_max.0, "rad/s"),
                    ("servo.no_load_speed", servo.no_load_speed.0, "rad/s"),
                    ("servo.time_constant_s", servo.time_constant_s, "s"),
                    ("servo.position_gain_per_s", servo.position_gain_per_s, "1/s"),
                    ("servo.rate_gain", servo.rate_gain, "1"),
                    ("servo.speed_max", servo.speed_max.0, "rad/s"),
                    ("servo.stall_current", servo.stall_current.0, "A"),
                    ("servo.current_max", servo.current_max.0, "A"),
                    ("servo.following_error_max", servo.following_error_max.0, "rad"),
                    ("encoder.homing_speed", tail.encoder.homing_speed.0, "rad/s"),
                ])
            }
            Self::Rov(rov) => finite(&[
                ("thrust_max", rov.thrust_max.0, "N"),
                ("frame_rate_hz", rov.frame_rate_hz, "Hz"),
                ("slew_n_s", rov.slew_n_s, "N/s"),
            ]),
        }
    }
}

fn finite(constants: &[(&'static str, f32, &'static str)]) -> Result<(), ConfigurationError> {
    let wrong = constants.iter().find(|(_, value, _)| !value.is_finite());
    wrong.map_or(Ok(()), |&(key, value, unit)| Err(ConfigurationError::Constant { key, value, unit }))
}
