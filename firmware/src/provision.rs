//! Builds the firmware of a module from the configuration image in flash; the same on every board.
//!
//! ```text
//! flash → Configuration::read → modboat(…) or rov(…)          anything wrong → NotProvisioned: blink, say and move nothing
//! ```
//!
//! A board gives its parts and twelve random bytes; all that differs between modules comes from the image.

use core::fmt;

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use protocol::configuration::{
    EncoderConstants, Robot, ServoConstants, SupplyConstants, TailConstants, TailLimits,
};
use protocol::time::Duration;
use protocol::units::{Amperes, Volts};
use protocol::{Configuration, ConfigurationError, ModuleKind};

use crate::link::endpoint::Endpoint;
use crate::link::session::Identity;
use crate::modboat::Modboat;
use crate::modboat::encoder::Encoder;
use crate::modboat::homing::Homing;
use crate::modboat::motor::Bridge;
use crate::modboat::quadrature::{COUNTS_MAX, Quadrature};
use crate::modboat::robot::ModboatRobot;
use crate::modboat::servo::{CurrentSense, ServoError};
use crate::modboat::tail::Tail;
use crate::rov::Rov;
use crate::rov::lease::ThrustLease;
use crate::rov::thruster::bank::{Bank, BankError};

/// Shortest and longest interval of a servo loop on a board. *Assumed*: half a millisecond is several times what a tick
/// takes, and after 10 ms a tail at 11 rad/s has moved 0.1 rad.
pub const SERVO_INTERVAL: (Duration, Duration) = (Duration(500), Duration(10_000));

/// Greatest following error, rad, and longest time of it, for which a module is not stopped: what holds a tail must not hold it for longer, or
/// the motor burns. *Assumed.*
pub const FOLLOWING: (f32, Duration) = (0.15, Duration(350_000));

/// Why a board has nothing to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotProvisioned {
    /// There is no valid image.
    Image(ConfigurationError),
    /// The image is for another kind of robot.
    Kind(ModuleKind),
    /// No motor is like that.
    Servo(ServoError),
    /// No thrusters are like that.
    Bank(BankError),
    /// So many counts in one turn, where the board has an encoder that counts.
    Counts(u32),
    /// The interval of the servo loop is out of [`SERVO_INTERVAL`].
    Interval(Duration),
    /// Following error, rad, and its time are beyond [`FOLLOWING`], or no time.
    Following(f32, Duration),
    /// A pair of limits of which the lesser is negative or above the greater, or one that is not positive.
    Limits(&'static str),
}

impl fmt::Display for NotProvisioned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Image(error) => write!(f, "configuration: {error}"),
            Self::Kind(ModuleKind::Modboat) => f.write_str("the configuration is a Modboat's"),
            Self::Kind(ModuleKind::Rov) => f.write_str("the configuration is an ROV's"),
            Self::Servo(error) => write!(f, "configuration: servo.{error}"),
            Self::Bank(error) => write!(f, "configuration: thrusters: {error}"),
            Self::Counts(counts) => {
                write!(f, "configuration: encoder.counts_per_turn = {counts}: 1 to {COUNTS_MAX}")
            }
            Self::Interval(interval) => {
                let (Duration(least), Duration(greatest)) = SERVO_INTERVAL;
                write!(f, "configuration: servo.interval = {} µs: {least} to {greatest}", interval.0)
            }
            Self::Following(error_rad, time) => {
                let (most_rad, Duration(longest)) = FOLLOWING;
                write!(
                    f,
                    "configuration: servo.following_error_max = {error_rad} rad for {} µs: at most {most_rad} rad for 1 to {longest} µs",
                    time.0
                )
            }
            Self::Limits(key) => write!(
                f,
                "configuration: limits.{key}: must be positive, and the least not above the greatest"
            ),
        }
    }
}

impl core::error::Error for NotProvisioned {}

impl From<ConfigurationError> for NotProvisioned {
    fn from(error: ConfigurationError) -> Self {
        Self::Image(error)
    }
}

impl From<ServoError> for NotProvisioned {
    fn from(error: ServoError) -> Self {
        Self::Servo(error)
    }
}

impl From<BankError> for NotProvisioned {
    fn from(error: BankError) -> Self {
        Self::Bank(error)
    }
}

/// The identity that the image gives the module, in the boot that `boot` names; see [`Identity::boot`].
#[must_use]
pub fn identity(configuration: &Configuration, boot: [u8; 12]) -> Identity {
    Identity {
        module: configuration.module,
        fleet: configuration.fleet,
        key: configuration.key.clone(),
        boot,
        report_every: configuration.report_every,
        sure_within: configuration.sure_within,
    }
}

/// A Modboat of the image and the board's parts.
///
/// # Errors
/// [`NotProvisioned`].
// Out of line: it moves whole modules about, and a board's main loop never gives its stack back.
#[inline(never)]
pub fn modboat<E: Encoder, S: CurrentSense, P: SetDutyCycle, A: OutputPin, B: OutputPin>(
    configuration: &Configuration,
    boot: [u8; 12],
    encoder: E,
    sense: S,
    bridge: Bridge<P, A, B>,
) -> Result<Modboat<E, S, P, A, B>, NotProvisioned> {
    let Robot::Modboat(constants) = &configuration.robot else {
        return Err(NotProvisioned::Kind(configuration.kind()));
    };
    let TailConstants {
        limits,
        servo,
        encoder: EncoderConstants { mounting, homing_speed, homing_after, .. },
    } = constants;
    check_limits(limits)?;
    check_following(servo)?;
    let tail = Tail::new(encoder, *mounting, sense, bridge, servo)?;
    let endpoint = Endpoint::new(Some(identity(configuration, boot)), ModboatRobot::new(*limits));
    let homing = Homing::new(*homing_speed, *homing_after, servo.no_load_speed);
    Ok(Modboat::new(endpoint, tail).with_battery(configuration.supply.battery).with_homing(homing))
}

fn check_following(servo: &ServoConstants) -> Result<(), NotProvisioned> {
    let (error_max_rad, longest) = FOLLOWING;
    let (error_rad, time) = (servo.following_error_max.0, servo.following_error_time);
    let watched = error_rad <= error_max_rad && time.0 > 0 && time <= longest;
    if watched { Ok(()) } else { Err(NotProvisioned::Following(error_rad, time)) }
}

/// Limits that no cycle keeps, or that mean nothing, are a mistake in the file.
fn check_limits(limits: &TailLimits) -> Result<(), NotProvisioned> {
    let &TailLimits {
        amplitude_min,
        amplitude_max,
        centerline_max,
        rotation_max,
        speed_max,
        period_min,
        period_max,
        transition_max,
    } = limits;
    let sound = [
        ("amplitude", amplitude_min.0 >= 0.0 && amplitude_min <= amplitude_max && amplitude_max.0 > 0.0),
        ("centerline_max", centerline_max.0 > 0.0),
        ("rotation_max", rotation_max.0 > 0.0),
        ("speed_max", speed_max.0 > 0.0),
        ("period", period_min.0 > 0 && period_min <= period_max),
        ("transition_max", transition_max.0 > 0),
    ];
    sound.into_iter().find(|(_, is)| !is).map_or(Ok(()), |(key, _)| Err(NotProvisioned::Limits(key)))
}

/// The encoder of a board that counts edges and has an index.
///
/// # Errors
/// [`NotProvisioned::Counts`] for none, which means an absolute encoder, and for more than are told apart.
pub fn quadrature(constants: &EncoderConstants) -> Result<Quadrature, NotProvisioned> {
    match constants.counts_per_turn {
        counts @ 1..=COUNTS_MAX => Ok(Quadrature::new(counts)),
        counts => Err(NotProvisioned::Counts(counts)),
    }
}

/// How often a board calls [`Module::tick`](crate::module::Module::tick).
///
/// # Errors
/// [`NotProvisioned::Interval`].
pub fn servo_interval(constants: &ServoConstants) -> Result<Duration, NotProvisioned> {
    let (least, greatest) = SERVO_INTERVAL;
    let interval = constants.interval;
    if (least..=greatest).contains(&interval) {
        Ok(interval)
    } else {
        Err(NotProvisioned::Interval(interval))
    }
}

/// An ROV of the image and the board's pins, in the board's order.
///
/// # Errors
/// [`NotProvisioned`].
pub fn rov<P: SetDutyCycle>(
    configuration: &Configuration,
    boot: [u8; 12],
    pins: impl IntoIterator<Item = P>,
) -> Result<Rov<P>, NotProvisioned> {
    let Robot::Rov(constants) = &configuration.robot else {
        return Err(NotProvisioned::Kind(configuration.kind()));
    };
    let bank = Bank::new(pins, &constants.thrusters, constants.bank)?;
    let lease = ThrustLease::new(constants.thrusters.len(), constants.limits);
    let endpoint = Endpoint::new(Some(identity(configuration, boot)), lease);
    Ok(Rov::new(endpoint, bank).with_battery(configuration.supply.battery))
}

/// The battery's voltage where the board's input shows `input`; not a number where nothing is wired.
#[must_use]
pub fn battery(supply: &SupplyConstants, input: Volts) -> Volts {
    Volts(if supply.volts_per_volt > 0.0 { input.0 * supply.volts_per_volt } else { f32::NAN })
}

/// The current where the board's input shows `input`; nothing where nothing is wired.
#[must_use]
pub fn current(supply: &SupplyConstants, input: Volts) -> Option<Amperes> {
    (supply.amperes_per_volt > 0.0).then_some(Amperes(input.0 * supply.amperes_per_volt))
}

#[cfg(test)]
mod tests;
