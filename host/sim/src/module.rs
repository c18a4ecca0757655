//! A simulated Modboat: the firmware crate, compiled for the PC, on a simulated motor.

use std::convert::Infallible;
use std::f64::consts::TAU;

use firmware::link::endpoint::Endpoint;
use firmware::link::session::{Identity, SURE_WITHIN};
use firmware::modboat::Modboat;
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;
use firmware::modboat::robot::ModboatRobot;
use firmware::modboat::servo::{CurrentSense, ServoError};
use firmware::modboat::tail::Tail;
use firmware::module::Supply;
use modboat::parameters::Parameters;
use protocol::Radio;
use protocol::configuration::{EncoderMounting, ServoConstants, TailLimits};
use protocol::time::{Duration, FleetInstant};
use protocol::units::{Amperes, Radians, RadiansPerSecond, Volts};
use quantity::ParameterError;
use thiserror::Error;

use super::TailState;
use super::motor::{DirectionPin, ENCODER_COUNTS, MotorParameters, PwmPin, Sensors, SimMotor};
use super::node::{Hardware, Simulated};

/// Servo period of a module: 1 kHz.
pub const TICK: Duration = Duration(1_000);

/// What a full battery of two lithium cells shows. *Assumed*.
const FULL: Supply = Supply { battery: Volts(7.4), current: Amperes(0.0) };

/// Why there is no module.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModuleError {
    /// The motor cannot be.
    #[error("motor: {0}")]
    Motor(#[from] ParameterError),
    /// The servo cannot drive it.
    #[error("servo: {0}")]
    Servo(#[from] ServoError),
}

impl Encoder for Sensors {
    type Error = Infallible;
    const COUNTS_PER_TURN: u32 = ENCODER_COUNTS as u32;

    fn counts(&mut self) -> Result<u32, Infallible> {
        Ok(u32::from(self.encoder_counts()))
    }
}

impl CurrentSense for Sensors {
    type Error = Infallible;

    fn current(&mut self) -> Result<Option<Amperes>, Infallible> {
        Ok(Some(Amperes(self.current_a().abs() as f32)))
    }
}

/// One Modboat at one end of a radio.
pub type SimModule<R> = Simulated<Boat, R>;

/// What a Modboat is made of.
pub struct Boat {
    limits: TailLimits,
    servo: ServoConstants,
    mounting: EncoderMounting,
    motor: SimMotor,
    supply: Supply,
}

impl Boat {
    /// A Modboat of this kind with this motor, as drawn by `seed`, its tail at `tail_rad`.
    ///
    /// # Errors
    /// [`ModuleError`] for a motor that cannot be.
    pub fn new(
        modboat: &Parameters,
        motor: &MotorParameters,
        tail_rad: f64,
        seed: u64,
    ) -> Result<Self, ModuleError> {
        let mounting = EncoderMounting { zero_counts: motor.encoder_offset_counts(), reversed: false };
        let (limits, servo) = (limits_of(modboat), servo_for(motor, modboat));
        let (motor, _) = SimMotor::new(&motor.drawn(seed), tail_rad)?;
        Ok(Self { limits, servo, mounting, motor, supply: FULL })
    }
}

impl<R: Radio> SimModule<R> {
    /// The tail as it is.
    pub fn tail(&self) -> TailState {
        self.hardware.motor.state()
    }

    /// What its battery shows from now on.
    pub fn set_battery(&mut self, battery: Volts) {
        self.hardware.supply.battery = battery;
    }

    /// The motor, for faults in it.
    pub fn motor_mut(&mut self) -> &mut SimMotor {
        &mut self.hardware.motor
    }
}

impl Hardware for Boat {
    type Firmware = Modboat<Sensors, Sensors, PwmPin, DirectionPin, DirectionPin>;
    type Actuation = TailState;
    type Error = ModuleError;
    const SURE_WITHIN: Duration = SURE_WITHIN;

    fn boot(&self, identity: Identity) -> Result<Self::Firmware, ModuleError> {
        let &Self { limits, ref servo, mounting, ref motor, .. } = self;
        let pins = motor.pins();
        let bridge = Bridge::new(pins.pwm, pins.in1, pins.in2);
        let tail = Tail::new(pins.sensors.clone(), mounting, pins.sensors, bridge, servo)?;
        Ok(Modboat::new(Endpoint::new(Some(identity), ModboatRobot::new(limits)), tail))
    }

    /// The firmware, then its motor for one [`TICK`].
    fn tick<T>(&mut self, _now: FleetInstant, run: impl FnOnce(&Self, &Supply) -> T) -> T {
        let done = run(self, &self.supply);
        self.motor.step(f64::from(TICK.as_secs_f32()));
        done
    }

    fn power_off(&mut self) {
        self.motor.release();
    }

    fn actuate(&self, tail: &mut TailState) {
        *tail = self.motor.state();
    }
}

/// What the firmware is told of a motor like this, for plans that allow its tail so much error: one reading of its encoder less, as that is
/// how much further off the tail may be than it measures.
pub(super) fn servo_for(motor: &MotorParameters, modboat: &Parameters) -> ServoConstants {
    let reading_rad = TAU / f64::from(ENCODER_COUNTS);
    ServoConstants {
        following_error_max: Radians((modboat.tracking_error_rad - reading_rad).max(reading_rad) as f32),
        no_load_speed: RadiansPerSecond(motor.no_load_speed_rad_s as f32),
        time_constant_s: motor.time_constant_s as f32,
        speed_max: RadiansPerSecond(motor.no_load_speed_rad_s as f32),
        // The current that the torque limit stands for.
        stall_current: Amperes(motor.stall_current_a() as f32),
        interval: TICK,
        ..ServoConstants::default()
    }
}

/// The limits a module is provisioned with: those of the kind of Modboat it is.
fn limits_of(modboat: &Parameters) -> TailLimits {
    TailLimits {
        amplitude_min: Radians(modboat.amplitude_min_rad as f32),
        amplitude_max: Radians(modboat.amplitude_max_rad as f32),
        speed_max: RadiansPerSecond(modboat.tail_speed_max_rad_s as f32),
        ..TailLimits::default()
    }
}
