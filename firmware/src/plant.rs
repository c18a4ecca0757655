//! A simulated motor with encoder and bridge outputs, for the tests of this crate.
//!
//! φ̈ = clamp((ω₀·d − φ̇)/τ_m, ±600 rad/s²), integrated in double precision in steps of 0.1 ms.

use std::cell::RefCell;
use std::convert::Infallible;
use std::f64::consts::TAU;
use std::rc::Rc;

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

use crate::modboat::encoder::Encoder;
use crate::modboat::kept_zero::{KeptQuadrature, REST_DRIVE, RetainedMemory, WORDS};
use crate::modboat::motor::Bridge;
use crate::modboat::quadrature::{Quadrature, READINGS};
use crate::modboat::servo::NoSense;
use crate::modboat::tail::Tail;
use protocol::configuration::{EncoderMounting, ServoConstants};

const NO_LOAD_RAD_S: f64 = 18.0;
const TIME_CONSTANT_S: f64 = 0.02;
const ACCELERATION_MAX_RAD_S2: f64 = 600.0;
const ZERO_COUNTS: u32 = 1234;
const DUTY_MAX: u16 = 2000;
/// Edges of an incremental encoder in one turn: 12 pulses on two lines, and a gear of 1:100.
const EDGES: u32 = 4_800;
/// The magnet is over so much of a turn.
const MAGNET_TURN: f64 = 0.1;

#[derive(Default)]
struct State {
    angle_rad: f64,
    rate_rad_s: f64,
    duty: u16,
    in1: bool,
    in2: bool,
    encoder_fails: bool,
    blocked: bool,
    magnet_rad: Option<f64>,
    swapped: bool,
    lost: i64,
    weed: f64,
    retained: [u32; WORDS],
    /// The last reset was the watchdog's.
    by_watchdog: bool,
}

impl State {
    fn drive(&self) -> f64 {
        (f64::from(u8::from(self.in1)) - f64::from(u8::from(self.in2))) * f64::from(self.duty)
            / f64::from(DUTY_MAX)
    }

    fn edges(&self) -> i64 {
        (self.angle_rad / TAU * f64::from(EDGES)).floor() as i64 - self.lost
    }
}

/// The bench with one motor on it.
#[derive(Clone, Default)]
pub struct Rig(Rc<RefCell<State>>);

/// A tail wired to the rig.
pub type RigTail<E = RigEncoder> = Tail<E, NoSense, RigPwm, RigPin, RigPin>;

impl Rig {
    pub fn new(angle_rad: f64) -> Self {
        Self(Rc::new(RefCell::new(State { angle_rad, ..State::default() })))
    }

    pub fn tail(&self) -> RigTail {
        self.tail_of(&ServoConstants::default())
    }

    pub fn tail_of(&self, servo: &ServoConstants) -> RigTail {
        self.tail_with(RigEncoder(self.clone()), ZERO_COUNTS, servo)
    }

    /// With an incremental encoder that counts from now on, and the magnet of its index at `magnet_rad`.
    pub fn indexed_tail(&self, magnet_rad: f64) -> RigTail<RigIndexed> {
        let start = self.0.borrow().edges();
        let quadrature = KeptQuadrature::boot(Quadrature::new(EDGES), RigMemory(self.clone()));
        let encoder = RigIndexed { rig: self.clone(), start, quadrature };
        // Readings from the magnet to x_S, counter-clockwise.
        let zero_counts = (-magnet_rad / TAU).rem_euclid(1.0) * f64::from(READINGS);
        self.tail_with(encoder, zero_counts.round() as u32, &ServoConstants::default())
    }

    fn tail_with<E: Encoder>(&self, encoder: E, zero_counts: u32, servo: &ServoConstants) -> RigTail<E> {
        let bridge =
            Bridge::new(RigPwm(self.clone()), RigPin(self.clone(), true), RigPin(self.clone(), false));
        let mounting = EncoderMounting { zero_counts, reversed: false };
        Tail::new(encoder, mounting, NoSense, bridge, servo).unwrap()
    }

    /// Puts the magnet there, counter-clockwise from `at_rad` on, or takes it away.
    pub fn put_magnet(&self, at_rad: Option<f64>) {
        self.0.borrow_mut().magnet_rad = at_rad;
    }

    /// The leads of the motor are swapped.
    pub fn swap(&self) {
        self.0.borrow_mut().swapped = true;
    }

    /// Something drags at the tail: it turns slower by this share.
    pub fn weed(&self, share: f64) {
        self.0.borrow_mut().weed = share;
    }

    /// The counter misses so many edges.
    pub fn lose(&self, edges: i64) {
        self.0.borrow_mut().lost += edges;
    }

    /// In reset: both inputs of the bridge are pulled up, so the motor is shorted.
    pub fn reset(&self, by_watchdog: bool) {
        let mut state = self.0.borrow_mut();
        (state.in1, state.in2, state.by_watchdog) = (true, true, by_watchdog);
    }

    /// The record that is kept, to be looked at or damaged.
    pub fn retained(&self, change: impl FnOnce(&mut [u32; WORDS])) -> [u32; WORDS] {
        let mut state = self.0.borrow_mut();
        change(&mut state.retained);
        state.retained
    }

    pub fn angle_rad(&self) -> f64 {
        self.0.borrow().angle_rad
    }

    pub fn drive(&self) -> f64 {
        self.0.borrow().drive()
    }

    pub fn fail_encoder(&self, fails: bool) {
        self.0.borrow_mut().encoder_fails = fails;
    }

    /// Whether the winding is shorted.
    pub fn is_shorted(&self) -> bool {
        let state = self.0.borrow();
        state.in1 && state.in2
    }

    /// Something holds the tail.
    pub fn block(&self, blocked: bool) {
        self.0.borrow_mut().blocked = blocked;
    }

    /// Turns the tail as by hand.
    pub fn turn(&self, by_rad: f64) {
        self.0.borrow_mut().angle_rad += by_rad;
    }

    pub fn step_ms(&self) {
        const STEP_S: f64 = 1e-4;
        let mut state = self.0.borrow_mut();
        if state.blocked {
            state.rate_rad_s = 0.0;
            return;
        }
        let drive = if state.swapped { -state.drive() } else { state.drive() };
        // An open winding takes no torque, and friction is not modelled: the tail coasts on.
        let open = !state.in1 && !state.in2;
        for _ in 0..10 {
            let no_load_rad_s = NO_LOAD_RAD_S * (1.0 - state.weed);
            let driven_rad_s2 = (no_load_rad_s * drive - state.rate_rad_s) / TIME_CONSTANT_S;
            let free_rad_s2 = if open { 0.0 } else { driven_rad_s2 };
            let rate_rad_s = state.rate_rad_s
                + free_rad_s2.clamp(-ACCELERATION_MAX_RAD_S2, ACCELERATION_MAX_RAD_S2) * STEP_S;
            state.angle_rad += 0.5 * (state.rate_rad_s + rate_rad_s) * STEP_S;
            state.rate_rad_s = rate_rad_s;
        }
    }
}

pub struct RigEncoder(Rig);

impl Encoder for RigEncoder {
    type Error = ();
    const COUNTS_PER_TURN: u32 = 4096;

    fn counts(&mut self) -> Result<u32, ()> {
        let state = self.0.0.borrow();
        let counts = (state.angle_rad / TAU * 4096.0).floor() as i64 + i64::from(ZERO_COUNTS);
        if state.encoder_fails { Err(()) } else { u32::try_from(counts.rem_euclid(4096)).map_err(|_| ()) }
    }
}

/// Counts edges from where it was switched on, and has a switch that the magnet closes.
pub struct RigIndexed {
    rig: Rig,
    start: i64,
    quadrature: KeptQuadrature<RigMemory>,
}

impl Encoder for RigIndexed {
    type Error = ();
    const COUNTS_PER_TURN: u32 = READINGS;

    fn counts(&mut self) -> Result<u32, ()> {
        let state = self.rig.0.borrow();
        let counter = (state.edges() - self.start) as i32;
        let from_magnet = |at_rad: f64| ((state.angle_rad - at_rad) / TAU).rem_euclid(1.0);
        let index = state.magnet_rad.is_some_and(|at| from_magnet(at) < MAGNET_TURN);
        drop(state);
        self.quadrature.update(counter, index).ok_or(())
    }

    fn is_homed(&self) -> bool {
        self.quadrature.is_homed()
    }

    fn take_index_fault(&mut self) -> bool {
        self.quadrature.take_fault()
    }

    fn keep_zero(&mut self, resting: bool) {
        self.quadrature.keep_zero(resting);
    }
}

/// Four registers of the rig that outlive a reset.
pub struct RigMemory(Rig);

impl RetainedMemory for RigMemory {
    fn recall(&mut self) -> Option<[u32; WORDS]> {
        let state = self.0.0.borrow();
        state.by_watchdog.then_some(state.retained)
    }

    fn keep(&mut self, words: [u32; WORDS]) {
        self.0.0.borrow_mut().retained = words;
    }
}

pub struct RigPwm(Rig);

impl embedded_hal::pwm::ErrorType for RigPwm {
    type Error = Infallible;
}

impl SetDutyCycle for RigPwm {
    fn max_duty_cycle(&self) -> u16 {
        DUTY_MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        let mut state = self.0.0.borrow_mut();
        state.duty = duty;
        let holds = state.drive().abs() <= f64::from(REST_DRIVE) + 1e-3;
        assert!(holds || state.retained == [0; WORDS], "driven by {} with a record", state.drive());
        Ok(())
    }
}

/// in1 if true, else in2.
pub struct RigPin(Rig, bool);

impl embedded_hal::digital::ErrorType for RigPin {
    type Error = Infallible;
}

impl RigPin {
    fn set(&mut self, level: bool) {
        let mut state = self.0.0.borrow_mut();
        if self.1 { state.in1 = level } else { state.in2 = level }
    }
}

impl OutputPin for RigPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}
