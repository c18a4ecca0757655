//! A simulated Modboat: the firmware crate, compiled for the PC, on a simulated motor.

use std::convert::Infallible;

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
use protocol::configuration::{EncoderMounting, ServoConstants, TailLimits};
use protocol::time::{Duration, FleetInstant};
use protocol::units::{Amperes, Radians, RadiansPerSecond, Volts};
use protocol::{FleetId, ModuleId, ModuleKey, Radio};
use quantity::ParameterError;
use thiserror::Error;

use super::TailState;
use super::clock::ClockParameters;
use super::motor::{DirectionPin, ENCODER_COUNTS, MotorParameters, PwmPin, Sensors, SimMotor};
use super::node::{Hardware, Simulated};

/// Servo period of a module: 1 kHz.
pub const TICK: Duration = Duration(1_000);

/// What a full battery of two lithium cells shows. *Assumed*, and constant.
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
    id: ModuleId,
    fleet: FleetId,
    key: ModuleKey,
    report_every: Duration,
    limits: TailLimits,
    servo: ServoConstants,
    mounting: EncoderMounting,
    motor: SimMotor,
    supply: Supply,
}

/// How a module is set up.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    /// Its number.
    pub id: ModuleId,
    /// Its fleet.
    pub fleet: FleetId,
    /// Its key.
    pub key: ModuleKey,
    /// What kind of Modboat it is.
    pub modboat: &'a Parameters,
    /// Its motor.
    pub motor: &'a MotorParameters,
    /// How wrong its clock is.
    pub clock: &'a ClockParameters,
    /// Where its tail points, rad.
    pub tail_rad: f64,
    /// Pause between two reports.
    pub report_every: Duration,
    /// Decides its clock, its boot time and its boot nonces.
    pub seed: u64,
}

impl<R: Radio> SimModule<R> {
    /// A module that boots within the first 50 ms and talks to `host` over `radio`.
    ///
    /// # Errors
    /// [`ModuleError`] for a motor or servo that cannot be.
    pub fn new(setup: &Setup<'_>, radio: R, host: R::Address) -> Result<Self, ModuleError> {
        let (motor, _) = SimMotor::new(&setup.motor.drawn(setup.seed), setup.tail_rad)?;
        let zero_counts = setup.motor.encoder_offset_counts();
        let boat = Boat {
            id: setup.id,
            fleet: setup.fleet,
            key: setup.key.clone(),
            report_every: setup.report_every,
            limits: limits_of(setup.modboat),
            servo: servo_for(setup.motor),
            mounting: EncoderMounting { zero_counts, reversed: false },
            motor,
            supply: FULL,
        };
        Self::on(boat, (setup.seed, setup.clock), radio, host)
    }

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

    fn boot(&self, boot: [u8; 12]) -> Result<Self::Firmware, ModuleError> {
        let &Self { id: module, fleet, ref key, report_every, limits, ref servo, mounting, .. } = self;
        let pins = self.motor.pins();
        let key = key.clone();
        let identity = Identity { module, fleet, key, boot, report_every, sure_within: SURE_WITHIN };
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

/// What the firmware is told of a motor like this.
pub(super) fn servo_for(motor: &MotorParameters) -> ServoConstants {
    ServoConstants {
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
