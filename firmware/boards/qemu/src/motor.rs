//! A motor in software behind the traits that a real one has on other boards. It stands where it stood before a reset of the board.

use core::cell::RefCell;
use core::convert::Infallible;

use critical_section::Mutex;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::kept_zero::KeptQuadrature;
use firmware::modboat::motor::Bridge;
use firmware::modboat::quadrature::READINGS;
use firmware::modboat::servo::CurrentSense;
use firmware::provision::{self, NotProvisioned};
use plant::{Constants, Motor};
use protocol::configuration::EncoderConstants;
use protocol::units::Amperes;

use crate::retained::{self, Retained};
use crate::semihosting;

/// Duty cycle of a motor that is always on.
const MAX_DUTY: u16 = 10_000;

/// Counts of the absolute encoder in one turn (12 bits), zero where the tail points along x_S.
const ENCODER_COUNTS: u32 = 4096;

/// Readings of an encoder with an index for one of the absolute one.
const READINGS_PER_COUNT: u32 = READINGS / ENCODER_COUNTS;

/// The magnet of the index: from where on counter-clockwise, rad, and over how much of a turn.
pub const MAGNET: (f64, f64) = (-0.7, 0.1);

/// The wires between the board and its motor: what the pins put out, and what the sensors show as of the last step.
struct Wires {
    motor: Option<Motor>,
    duty: u16,
    in1: bool,
    in2: bool,
    encoder_counts: u32,
    /// Counts in a turn of an encoder that counts; its count, and whether the magnet is over its switch.
    counts_per_turn: u32,
    edges: i32,
    index: bool,
    /// Edges that the counter has missed.
    lost: u32,
    swapped: bool,
    current: Amperes,
}

static WIRES: Mutex<RefCell<Wires>> = Mutex::new(RefCell::new(Wires {
    motor: None,
    duty: 0,
    in1: false,
    in2: false,
    encoder_counts: 0,
    counts_per_turn: 0,
    edges: 0,
    index: false,
    lost: 0,
    swapped: false,
    current: Amperes(0.0),
}));

fn with<T: Default>(use_it: impl FnOnce(&mut Wires) -> T) -> T {
    // The cell is not borrowed while interrupts are off, but the compiler cannot know.
    critical_section::with(|cs| {
        WIRES.borrow(cs).try_borrow_mut().map_or_else(|_| T::default(), |mut wires| use_it(&mut wires))
    })
}

/// Connects a motor at rest, with its tail along x_S at the first start, and where it stood, or was turned to, after a reset.
pub fn connect() {
    let turned_rad =
        semihosting::number_after("turned").map_or(0.0, |thousandths| f64::from(thousandths) * 1e-3);
    let angle_rad = retained::tail().map_or(0.0, |angle_rad| angle_rad + turned_rad);
    with(|wires| wires.motor = Some(Motor::new(Constants::default(), angle_rad)));
}

/// Lets the motor go on by `dt_s` with the pins as they are.
pub fn step(dt_s: f64) {
    with(|wires| {
        let drive = plant::drive(f64::from(wires.duty) / f64::from(MAX_DUTY), wires.in1, wires.in2);
        let drive = if wires.swapped { drive.map(|drive| -drive) } else { drive };
        let Some(motor) = &mut wires.motor else { return };
        motor.step(drive, dt_s);
        let (from_rad, over) = MAGNET;
        let turns = |angle_rad: f64| angle_rad / core::f64::consts::TAU;
        let beyond = turns(motor.angle_rad() - from_rad);
        #[expect(clippy::cast_possible_truncation, reason = "some thousand turns at most")]
        let edges = libm::floor(turns(motor.angle_rad()) * f64::from(wires.counts_per_turn)) as i32;
        wires.edges = edges;
        retained::put_tail(motor.angle_rad());
        wires.index = beyond - libm::floor(beyond) < over;
        wires.encoder_counts = plant::encoder_counts(motor.angle_rad(), ENCODER_COUNTS);
        #[expect(clippy::cast_possible_truncation, reason = "a current of some amperes")]
        let current_a = motor.current_a() as f32;
        wires.current = Amperes(current_a);
    });
}

/// The leads are swapped, something holds the tail, the counter has missed so many edges.
pub fn disturb(swapped: bool, blocked: bool, lost: u32) {
    with(|wires| {
        (wires.swapped, wires.lost) = (swapped, lost);
        if let Some(motor) = &mut wires.motor {
            motor.set_jammed(blocked);
        }
    });
}

/// Whether the bridge shorts the motor; how it drives it otherwise, a thousandth of the supply, counter-clockwise positive.
#[must_use]
pub fn drive() -> (bool, i32) {
    with(|wires| {
        let share = i32::from(wires.duty) * 1_000 / i32::from(MAX_DUTY);
        (wires.in1 && wires.in2, share * (i32::from(wires.in1) - i32::from(wires.in2)))
    })
}

/// The bridge to it.
pub type MotorBridge = Bridge<PwmPin, DirectionPin, DirectionPin>;

/// The bridge to it.
#[must_use]
pub fn bridge() -> MotorBridge {
    Bridge::new(PwmPin, DirectionPin::In1, DirectionPin::In2)
}

/// The enable input of the bridge.
#[derive(Debug)]
pub struct PwmPin;

impl pwm::ErrorType for PwmPin {
    type Error = Infallible;
}

impl SetDutyCycle for PwmPin {
    fn max_duty_cycle(&self) -> u16 {
        MAX_DUTY
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        with(|wires| wires.duty = duty.min(MAX_DUTY));
        Ok(())
    }
}

/// One of the two direction inputs of the bridge.
#[derive(Debug)]
pub enum DirectionPin {
    /// High for counter-clockwise.
    In1,
    /// High for clockwise.
    In2,
}

impl DirectionPin {
    fn set(&mut self, level: bool) {
        with(|wires| match self {
            Self::In1 => wires.in1 = level,
            Self::In2 => wires.in2 = level,
        });
    }
}

impl digital::ErrorType for DirectionPin {
    type Error = Infallible;
}

impl OutputPin for DirectionPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}

/// The encoder that the configuration names: absolute, or one that counts and has an index.
#[derive(Debug)]
pub struct Wheel(Option<KeptQuadrature<Retained>>);

impl Wheel {
    /// # Errors
    /// More counts in a turn than are told apart.
    pub fn new(constants: &EncoderConstants) -> Result<Self, NotProvisioned> {
        let counts = constants.counts_per_turn;
        with(|wires| wires.counts_per_turn = counts);
        let quadrature = if counts == 0 { None } else { Some(provision::quadrature(constants)?) };
        Ok(Self(quadrature.map(|quadrature| KeptQuadrature::boot(quadrature, Retained))))
    }
}

/// It has not passed its index yet.
#[derive(Debug)]
pub struct NotHomed;

/// The current sensor.
#[derive(Debug)]
pub struct Sensors;

impl Encoder for Wheel {
    type Error = NotHomed;
    const COUNTS_PER_TURN: u32 = READINGS;

    fn counts(&mut self) -> Result<u32, NotHomed> {
        let Some(quadrature) = &mut self.0 else {
            return Ok(with(|wires| wires.encoder_counts) * READINGS_PER_COUNT);
        };
        let (edges, index, lost) = with(|wires| (wires.edges, wires.index, wires.lost));
        quadrature.update(edges - lost.cast_signed(), index).ok_or(NotHomed)
    }

    fn is_homed(&self) -> bool {
        self.0.as_ref().is_none_or(KeptQuadrature::is_homed)
    }

    fn take_index_fault(&mut self) -> bool {
        self.0.as_mut().is_some_and(KeptQuadrature::take_fault)
    }

    fn keep_zero(&mut self, resting: bool) {
        if let Some(quadrature) = &mut self.0 {
            quadrature.keep_zero(resting);
        }
    }
}

impl CurrentSense for Sensors {
    type Error = Infallible;

    fn current(&mut self) -> Result<Option<Amperes>, Infallible> {
        Ok(Some(with(|wires| wires.current)))
    }
}
