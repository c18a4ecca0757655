//! A motor without inertia, φ̇ = 18 rad/s · d, with its encoder and the pins that drive it.

use std::cell::RefCell;
use std::convert::Infallible;
use std::f64::consts::TAU;
use std::rc::Rc;

use embedded_hal::digital::{ErrorType as DigitalError, OutputPin};
use embedded_hal::pwm::{ErrorType as PwmError, SetDutyCycle};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;
use firmware::modboat::servo::NoSense;
use firmware::modboat::tail::Tail;
use protocol::configuration::{EncoderMounting, ServoConstants};

const DUTY_MAX: u16 = 1000;
const NO_LOAD_RAD_S: f64 = 18.0;

#[derive(Default)]
struct State {
    angle_rad: f64,
    duty: u16,
    pins: [bool; 2],
    blind: bool,
    blocked: bool,
}

/// A motor without inertia, with its encoder and pins.
#[derive(Clone, Default)]
pub struct Board(Rc<RefCell<State>>);

/// A tail wired to it.
pub type BoardTail = Tail<Eye, NoSense, Pwm, Pin, Pin>;

impl Board {
    pub fn tail(&self) -> BoardTail {
        let bridge = Bridge::new(Pwm(self.clone()), Pin(self.clone(), 0), Pin(self.clone(), 1));
        let parameters = ServoConstants::default();
        Tail::new(Eye(self.clone()), EncoderMounting::default(), NoSense, bridge, &parameters)
            .expect("the defaults")
    }

    pub fn drive(&self) -> f64 {
        let state = self.0.borrow();
        let sign = f64::from(u8::from(state.pins[0])) - f64::from(u8::from(state.pins[1]));
        sign * f64::from(state.duty) / f64::from(DUTY_MAX)
    }

    pub fn step_ms(&self) {
        let moved_rad = self.drive() * NO_LOAD_RAD_S * 1e-3;
        let mut state = self.0.borrow_mut();
        if !state.blocked {
            state.angle_rad += moved_rad;
        }
    }

    pub fn turn(&self, by_rad: f64) {
        self.0.borrow_mut().angle_rad += by_rad;
    }

    pub fn fail_encoder(&self, fails: bool) {
        self.0.borrow_mut().blind = fails;
    }

    pub fn block(&self, blocked: bool) {
        self.0.borrow_mut().blocked = blocked;
    }
}

pub struct Eye(Board);

impl Encoder for Eye {
    type Error = ();
    const COUNTS_PER_TURN: u32 = 4096;

    fn counts(&mut self) -> Result<u32, ()> {
        let state = self.0.0.borrow();
        let counts = (state.angle_rad / TAU * 4096.0).rem_euclid(4096.0) as u32;
        if state.blind { Err(()) } else { Ok(counts.min(4095)) }
    }
}

pub struct Pwm(Board);

impl PwmError for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    fn max_duty_cycle(&self) -> u16 {
        DUTY_MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.0.borrow_mut().duty = duty;
        Ok(())
    }
}

pub struct Pin(Board, usize);

impl DigitalError for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.0.borrow_mut().pins[self.1] = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.0.borrow_mut().pins[self.1] = true;
        Ok(())
    }
}
