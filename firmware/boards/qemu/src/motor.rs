//! A motor in software behind the traits that a real one has on other boards.

use core::cell::RefCell;
use core::convert::Infallible;

use critical_section::Mutex;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;
use firmware::modboat::servo::CurrentSense;
use plant::{Constants, Motor};
use protocol::units::Amperes;

/// Duty cycle of a motor that is always on.
const MAX_DUTY: u16 = 10_000;

/// Counts of the absolute encoder in one turn (12 bits), zero where the tail points along x_S.
const ENCODER_COUNTS: u32 = 4096;

/// The wires between the board and its motor: what the pins put out, and what the sensors show as of the last step.
struct Wires {
    motor: Option<Motor>,
    duty: u16,
    in1: bool,
    in2: bool,
    encoder_counts: u32,
    current: Amperes,
}

static WIRES: Mutex<RefCell<Wires>> = Mutex::new(RefCell::new(Wires {
    motor: None,
    duty: 0,
    in1: false,
    in2: false,
    encoder_counts: 0,
    current: Amperes(0.0),
}));

fn with<T: Default>(use_it: impl FnOnce(&mut Wires) -> T) -> T {
    // The cell is not borrowed while interrupts are off, but the compiler cannot know.
    critical_section::with(|cs| {
        WIRES.borrow(cs).try_borrow_mut().map_or_else(|_| T::default(), |mut wires| use_it(&mut wires))
    })
}

/// Connects a motor at rest with its tail along x_S.
pub fn connect() {
    with(|wires| wires.motor = Some(Motor::new(Constants::default(), 0.0)));
}

/// Lets the motor go on by `dt_s` with the pins as they are.
pub fn step(dt_s: f64) {
    with(|wires| {
        let drive = plant::drive(f64::from(wires.duty) / f64::from(MAX_DUTY), wires.in1, wires.in2);
        let Some(motor) = &mut wires.motor else { return };
        motor.step(drive, dt_s);
        wires.encoder_counts = plant::encoder_counts(motor.angle_rad(), ENCODER_COUNTS);
        #[expect(clippy::cast_possible_truncation, reason = "a current of some amperes")]
        let current_a = motor.current_a() as f32;
        wires.current = Amperes(current_a);
    });
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

/// Encoder and current sensor.
#[derive(Debug)]
pub struct Sensors;

impl Encoder for Sensors {
    type Error = Infallible;
    const COUNTS_PER_TURN: u32 = ENCODER_COUNTS;

    fn counts(&mut self) -> Result<u32, Infallible> {
        Ok(with(|wires| wires.encoder_counts))
    }
}

impl CurrentSense for Sensors {
    type Error = Infallible;

    fn current(&mut self) -> Result<Option<Amperes>, Infallible> {
        Ok(Some(with(|wires| wires.current)))
    }
}
