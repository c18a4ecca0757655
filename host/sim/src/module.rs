//! A simulated module: the firmware crate, compiled for the PC, on a simulated motor.
//!
//! It has a clock of its own, with an offset and a drift, so that the fleet time it learns over the link is really
//! learnt. The in-process run and `flotilla module` use the same code.

use std::convert::Infallible;
use std::f64::consts::TAU;

use firmware::link::endpoint::Endpoint;
use firmware::link::session::{Identity, Link, SURE_WITHIN};
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
use protocol::{FleetId, ModuleId, ModuleKey, ModuleState, Radio};
use quantity::ParameterError;
use thiserror::Error;

use super::TailState;
use super::clock::ClockParameters;
use super::motor::{DirectionPin, ENCODER_COUNTS, MotorParameters, PwmPin, Sensors, SimMotor};
use super::node::Node;

/// Servo period of a module: 1 kHz.
pub const TICK: Duration = Duration(1_000);

/// What a full battery of two lithium cells shows. *Assumed*, and constant.
const SUPPLY: Supply = Supply { battery: Volts(7.4), current: Amperes(0.0) };

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

type Firmware = Modboat<Sensors, Sensors, PwmPin, DirectionPin, DirectionPin>;

/// One module at one end of a radio.
pub struct SimModule<R: Radio> {
    build: Build,
    motor: SimMotor,
    node: Node<Firmware, R>,
}

/// What a module is made of, kept for its next boot.
#[derive(Clone, Debug)]
struct Build {
    id: ModuleId,
    fleet: FleetId,
    key: ModuleKey,
    report_every: Duration,
    limits: TailLimits,
    servo: ServoConstants,
    mounting: EncoderMounting,
    motor: MotorParameters,
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
        let mut node = Node::new(setup.seed, setup.clock, radio, host);
        let motor = setup.motor;
        let zero_counts = motor.encoder_offset_counts();
        let build = Build {
            id: setup.id,
            fleet: setup.fleet,
            key: setup.key.clone(),
            report_every: setup.report_every,
            limits: limits_of(setup.modboat),
            servo: servo_for(motor, setup.modboat),
            mounting: EncoderMounting { zero_counts, reversed: false },
            motor: motor.drawn(setup.seed),
        };
        let (motor, _) = SimMotor::new(&build.motor, setup.tail_rad)?;
        // A module that cannot be built says so now, not when it boots.
        boot(&build, &motor, node.boot_nonce())?;
        Ok(Self { build, motor, node })
    }

    /// One servo tick at `now`, true time: what came over the radio, the firmware, what it says, and the motor for
    /// one [`TICK`].
    ///
    /// # Errors
    /// The radio's own; [`ModuleError`] cannot occur after [`new`](Self::new) succeeded.
    pub fn tick(&mut self, now: FleetInstant) -> Result<(), R::Error> {
        if self.node.boots(now) {
            let firmware = boot(&self.build, &self.motor, self.node.boot_nonce()).ok();
            self.node.power_on(firmware);
        }
        self.node.tick(now, &SUPPLY)?;
        self.motor.step(f64::from(TICK.as_secs_f32()));
        Ok(())
    }

    /// Takes the power away at `now` and gives it back `off` later. What the firmware knew is gone; the tail coasts.
    pub fn reboot(&mut self, now: FleetInstant, off: Duration) {
        self.node.power_off(now, off);
        self.motor.release();
    }

    /// Lets its own clock jump ahead by so much, or back.
    pub fn step_clock(&mut self, by_s: f64) {
        self.node.step_clock(by_s);
    }

    /// The tail as it is.
    pub fn tail(&self) -> TailState {
        self.motor.state()
    }

    /// The motor, for faults in it.
    pub fn motor_mut(&mut self) -> &mut SimMotor {
        &mut self.motor
    }

    /// Whether it has power, and its firmware runs.
    pub fn has_power(&self) -> bool {
        self.node.has_power()
    }

    /// What the firmware is doing at `now`, true time; nothing without power.
    pub fn state(&self, now: FleetInstant) -> Option<ModuleState> {
        Some(self.node.status(now)?.state)
    }

    /// Number of the cycle that it runs at `now`, true time, if any.
    pub fn running(&self, now: FleetInstant) -> Option<u32> {
        self.node.status(now)?.running
    }

    /// Its way in and out, while it has power.
    pub fn link(&self) -> Option<&Link> {
        self.node.link()
    }

    /// Fleet time by the module's own reckoning less the true one, µs; nothing before it is synchronised.
    pub fn clock_error_us(&self, now: FleetInstant) -> Option<i64> {
        self.node.clock_error_us(now)
    }

    /// Its end of the radio.
    pub fn radio(&self) -> &R {
        self.node.radio()
    }

    /// Its end of the radio, to change the weather there.
    pub fn radio_mut(&mut self) -> &mut R {
        self.node.radio_mut()
    }

    /// Datagrams that came while it had no power.
    pub fn unheard(&self) -> u64 {
        self.node.unheard()
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

fn boot(build: &Build, motor: &SimMotor, boot: [u8; 12]) -> Result<Firmware, ModuleError> {
    let &Build { id: module, fleet, ref key, report_every, limits, ref servo, mounting, .. } = build;
    let pins = motor.pins();
    let key = key.clone();
    let identity = Identity { module, fleet, key, boot, report_every, sure_within: SURE_WITHIN };
    let bridge = Bridge::new(pins.pwm, pins.in1, pins.in2);
    let tail = Tail::new(pins.sensors.clone(), mounting, pins.sensors, bridge, servo)?;
    Ok(Modboat::new(Endpoint::new(Some(identity), ModboatRobot::new(limits)), tail))
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
