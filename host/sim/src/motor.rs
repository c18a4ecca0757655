//! A DC gear motor with the tail on its shaft, driven through `embedded-hal` pins as on a board.
//!
//! The firmware gets three pins of an H-bridge ([`PwmPin`], two [`DirectionPin`]s) and a [`Sensors`] handle; the
//! simulation keeps the [`SimMotor`] and steps it. The handles share a few cells with the motor, no locks.
//!
//! How motor and tail move is the package `plant`, which the emulator's board drives as well.
//!
//! Assumptions and limits: those of `plant`; every number in [`MotorParameters`] is *assumed*.

use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use plant::{Constants, Motor};
use quantity::ParameterError;
use quantity::{Range, check_ranges};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

use super::TailState;

/// Duty cycle of a motor that is always on.
pub const MAX_DUTY: u16 = 10_000;

/// Greatest spread of motors.
pub const SPREAD_MAX: f64 = 0.2;

/// Counts of the absolute encoder in one turn (12 bits).
pub const ENCODER_COUNTS: u16 = 4096;

/// A tail slower than this, rad/s, is about to stop.
const STOPPING_RAD_S: f64 = 0.05;
/// Step in which a stopping tail is followed, s.
const STOPPING_STEP_S: f64 = 1e-3;

/// Motor, rotor and encoder of one module. *Assumed* throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorParameters {
    /// No-load speed ω₀ at full duty, rad/s.
    pub no_load_speed_rad_s: f64,
    /// Mechanical time constant τ_m, s.
    pub time_constant_s: f64,
    /// Torque limit as an acceleration α_max, rad/s².
    pub acceleration_max_rad_s2: f64,
    /// Moment of inertia J of rotor and tail about the motor axis, kg·m².
    pub rotor_inertia_kg_m2: f64,
    /// Quadratic drag c of the tail in the water, N·m·s².
    pub tail_drag_n_m_s2: f64,
    /// Torque constant k_t at the shaft, after the gears, N·m/A.
    pub torque_constant_n_m_a: f64,
    /// What the encoder reads at φ = 0, rad: how the magnet happens to sit on the shaft.
    pub encoder_offset_rad: f64,
    /// Every module has its own motor: no-load speed, time constant, torque limit and drag each differ by at most this share
    /// from what stands here, which is what its firmware is told. *Assumed.*
    pub spread: f64,
    /// Whether the bridge shorts the winding while the board is in reset: its two inputs are pulled up, by a resistor each. Otherwise
    /// the tail coasts.
    pub reset_brakes: bool,
}

impl Default for MotorParameters {
    fn default() -> Self {
        let Constants {
            no_load_speed_rad_s,
            time_constant_s,
            acceleration_max_rad_s2,
            rotor_inertia_kg_m2,
            tail_drag_n_m_s2,
            torque_constant_n_m_a,
        } = Constants::default();
        Self {
            no_load_speed_rad_s,
            time_constant_s,
            acceleration_max_rad_s2,
            rotor_inertia_kg_m2,
            tail_drag_n_m_s2,
            torque_constant_n_m_a,
            encoder_offset_rad: 0.0,
            spread: 0.0,
            reset_brakes: true,
        }
    }
}

impl MotorParameters {
    /// Refuses what no motor can have, by the first offending key.
    ///
    /// # Errors
    /// [`ParameterError`] with the key, its value and unit, and what is asked of it.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges(&[
            ("no_load_speed_rad_s", self.no_load_speed_rad_s, "rad/s", Range::Positive),
            ("time_constant_s", self.time_constant_s, "s", Range::Positive),
            ("acceleration_max_rad_s2", self.acceleration_max_rad_s2, "rad/s²", Range::Positive),
            ("rotor_inertia_kg_m2", self.rotor_inertia_kg_m2, "kg·m²", Range::Positive),
            ("tail_drag_n_m_s2", self.tail_drag_n_m_s2, "N·m·s²", Range::NonNegative),
            ("torque_constant_n_m_a", self.torque_constant_n_m_a, "N·m/A", Range::Positive),
            ("encoder_offset_rad", self.encoder_offset_rad, "rad", Range::Finite),
            ("spread", self.spread, "", Range::NonNegative),
        ])?;
        if self.spread > SPREAD_MAX {
            let reason = "must be at most 0.2: a servo made for one motor does not drive every other";
            return Err(ParameterError { key: "spread", value: self.spread, unit: "", reason });
        }
        Ok(())
    }

    /// The motor of one module: each constant differs by its share of −1..1 of the spread.
    #[must_use]
    pub fn differing(&self, shares: [f64; 4]) -> Self {
        let [speed, time, torque, drag] = shares.map(|share| 1.0 + self.spread * share);
        Self {
            no_load_speed_rad_s: speed * self.no_load_speed_rad_s,
            time_constant_s: time * self.time_constant_s,
            acceleration_max_rad_s2: torque * self.acceleration_max_rad_s2,
            tail_drag_n_m_s2: drag * self.tail_drag_n_m_s2,
            spread: 0.0,
            ..self.clone()
        }
    }

    /// The motor of the module with this seed, drawn from the spread.
    #[must_use]
    pub fn drawn(&self, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        self.differing(std::array::from_fn(|_| rng.random_range(-1.0..=1.0)))
    }

    /// Current at the torque limit, A: i = J·α_max / k_t.
    #[must_use]
    pub fn stall_current_a(&self) -> f64 {
        self.rotor_inertia_kg_m2 * self.acceleration_max_rad_s2 / self.torque_constant_n_m_a
    }

    /// What the encoder reads at φ = 0.
    #[must_use]
    pub fn encoder_offset_counts(&self) -> u32 {
        plant::encoder_counts(self.encoder_offset_rad, ENCODER_COUNTS.into())
    }

    /// The part of them that moves.
    fn constants(&self) -> Constants {
        Constants {
            no_load_speed_rad_s: self.no_load_speed_rad_s,
            time_constant_s: self.time_constant_s,
            acceleration_max_rad_s2: self.acceleration_max_rad_s2,
            rotor_inertia_kg_m2: self.rotor_inertia_kg_m2,
            tail_drag_n_m_s2: self.tail_drag_n_m_s2,
            torque_constant_n_m_a: self.torque_constant_n_m_a,
        }
    }
}

/// The wires between the board and its motor.
#[derive(Debug, Default)]
struct Wires {
    duty: Cell<u16>,
    direction: [Cell<bool>; 2],
    encoder_counts: Cell<u16>,
    current_a: Cell<f64>,
}

/// The enable input of the H-bridge.
#[derive(Debug)]
pub struct PwmPin(Rc<Wires>);

impl pwm::ErrorType for PwmPin {
    type Error = Infallible;
}

impl SetDutyCycle for PwmPin {
    fn max_duty_cycle(&self) -> u16 {
        MAX_DUTY
    }

    /// A compare value above the top of the timer is always on, as in hardware.
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.duty.set(duty.min(MAX_DUTY));
        Ok(())
    }
}

/// One of the two direction inputs of the H-bridge.
#[derive(Debug)]
pub struct DirectionPin {
    wires: Rc<Wires>,
    input: usize,
}

impl digital::ErrorType for DirectionPin {
    type Error = Infallible;
}

impl OutputPin for DirectionPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.wires.direction[self.input].set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.wires.direction[self.input].set(true);
        Ok(())
    }
}

/// What the board can measure of its motor, as of the last step.
#[derive(Clone, Debug)]
pub struct Sensors(Rc<Wires>);

impl Sensors {
    /// Absolute encoder, 0 … [`ENCODER_COUNTS`] − 1, rising counter-clockwise.
    #[must_use]
    pub fn encoder_counts(&self) -> u16 {
        self.0.encoder_counts.get()
    }

    /// Motor current, A; positive while it pushes counter-clockwise.
    #[must_use]
    pub fn current_a(&self) -> f64 {
        self.0.current_a.get()
    }
}

/// What the board holds of one motor.
#[derive(Debug)]
pub struct MotorPins {
    /// Enable input.
    pub pwm: PwmPin,
    /// First direction input: high for counter-clockwise.
    pub in1: DirectionPin,
    /// Second direction input: high for clockwise.
    pub in2: DirectionPin,
    /// Encoder and current sense.
    pub sensors: Sensors,
}

/// One motor with its tail, to be stepped by the simulation.
#[derive(Debug)]
pub struct SimMotor {
    parameters: MotorParameters,
    wires: Rc<Wires>,
    motor: Motor,
}

impl SimMotor {
    /// A motor at rest with its tail at `angle_rad`, and the pins to hand to the firmware. All pins are low.
    ///
    /// # Errors
    /// As [`MotorParameters::validate`].
    pub fn new(parameters: &MotorParameters, angle_rad: f64) -> Result<(Self, MotorPins), ParameterError> {
        parameters.validate()?;
        let motor = Self {
            parameters: parameters.clone(),
            wires: Rc::default(),
            motor: Motor::new(parameters.constants(), angle_rad),
        };
        motor.wires.encoder_counts.set(motor.encoder_counts());
        let pins = motor.pins();
        Ok((motor, pins))
    }

    /// The pins once more, for a board that boots again.
    #[must_use]
    pub fn pins(&self) -> MotorPins {
        MotorPins {
            pwm: PwmPin(Rc::clone(&self.wires)),
            in1: DirectionPin { wires: Rc::clone(&self.wires), input: 0 },
            in2: DirectionPin { wires: Rc::clone(&self.wires), input: 1 },
            sensors: Sensors(Rc::clone(&self.wires)),
        }
    }

    /// What the pins do while the board is in reset: its outputs are open, and resistors decide.
    pub fn release(&mut self) {
        self.wires.duty.set(0);
        self.wires.direction.iter().for_each(|input| input.set(self.parameters.reset_brakes));
    }

    /// Where the tail would come to rest if the power went now, rad; `None` if it coasts, which without friction has no end.
    #[must_use]
    pub fn stops_at_rad(&self) -> Option<f64> {
        if !self.parameters.reset_brakes {
            return None;
        }
        let mut motor = self.motor.clone();
        while motor.rate_rad_s().abs() > STOPPING_RAD_S {
            motor.step(plant::drive(0.0, true, true), STOPPING_STEP_S);
        }
        // What is left takes ω·τ_m, and less in the water.
        Some(motor.angle_rad() + motor.rate_rad_s() * self.parameters.time_constant_s)
    }

    /// Advances the motor by `dt_s` with the pins as they are.
    pub fn step(&mut self, dt_s: f64) {
        let [in1, in2] = [0, 1].map(|input: usize| self.wires.direction[input].get());
        let duty = f64::from(self.wires.duty.get()) / f64::from(MAX_DUTY);
        self.motor.step(plant::drive(duty, in1, in2), dt_s);
        self.wires.current_a.set(self.motor.current_a());
        self.wires.encoder_counts.set(self.encoder_counts());
    }

    /// Blocks the shaft (weed, a rope) or frees it again. A blocked motor draws its stall current.
    pub fn set_jammed(&mut self, jammed: bool) {
        self.motor.set_jammed(jammed);
    }

    /// The tail as the tank needs it.
    #[must_use]
    pub fn state(&self) -> TailState {
        TailState {
            angle_rad: self.motor.angle_rad(),
            rate_rad_s: self.motor.rate_rad_s(),
            acceleration_rad_s2: self.motor.acceleration_rad_s2(),
            inertia_kg_m2: self.parameters.rotor_inertia_kg_m2,
        }
    }

    /// True angle φ, rad (unwrapped).
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        self.motor.angle_rad()
    }

    /// Angular velocity φ̇, rad/s.
    #[must_use]
    pub fn rate_rad_s(&self) -> f64 {
        self.motor.rate_rad_s()
    }

    /// Mean angular acceleration φ̈ of the last step, rad/s².
    #[must_use]
    pub fn acceleration_rad_s2(&self) -> f64 {
        self.motor.acceleration_rad_s2()
    }

    /// Mean motor current of the last step, A.
    #[must_use]
    pub fn current_a(&self) -> f64 {
        self.wires.current_a.get()
    }

    /// What the absolute encoder reads now, 0 … [`ENCODER_COUNTS`] − 1.
    #[must_use]
    pub fn encoder_counts(&self) -> u16 {
        // Twelve bits.
        plant::encoder_counts(self.angle_rad() + self.parameters.encoder_offset_rad, ENCODER_COUNTS.into())
            as u16
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const DT_S: f64 = 1e-3;

    fn no_drag() -> MotorParameters {
        MotorParameters { tail_drag_n_m_s2: 0.0, ..MotorParameters::default() }
    }

    /// Sets the pins through the traits alone, as a driver does.
    fn drive(pins: &mut MotorPins, in1: bool, in2: bool, duty: u16) {
        fn write(pin: &mut impl OutputPin, high: bool) {
            pin.set_state(high.into()).expect("infallible");
        }
        fn pwm(pin: &mut impl SetDutyCycle, duty: u16) {
            pin.set_duty_cycle_fraction(duty, pin.max_duty_cycle()).expect("infallible");
        }
        write(&mut pins.in1, in1);
        write(&mut pins.in2, in2);
        pwm(&mut pins.pwm, duty);
    }

    fn run(motor: &mut SimMotor, steps: usize) {
        (0..steps).for_each(|_| motor.step(DT_S));
    }

    #[test]
    fn half_duty_follows_the_exponential_in_both_directions() {
        for (in1, sign) in [(true, 1.0), (false, -1.0)] {
            let (mut motor, mut pins) = SimMotor::new(&no_drag(), 0.3).expect("valid");
            drive(&mut pins, in1, !in1, MAX_DUTY / 2);
            // 9 rad/s / 0.02 s = 450 rad/s² stays below the limit of 600.
            for step in 1..=100 {
                motor.step(DT_S);
                let t_s = f64::from(step) * DT_S;
                let rate_rad_s = sign * 9.0 * (1.0 - (-t_s / 0.02).exp());
                assert!((motor.rate_rad_s() - rate_rad_s).abs() < 1e-9, "{t_s} s: {}", motor.rate_rad_s());
            }
            // ∫ = 9·(t − τ·(1 − e^(−t/τ))) with t = 0.1 s, τ = 0.02 s; trapezoids are good to (dt/τ)²/12.
            let angle_rad = 0.3 + sign * 9.0 * (0.1 - 0.02 * (1.0 - (-5.0_f64).exp()));
            assert!((motor.angle_rad() - angle_rad).abs() < 1e-4, "{}", motor.angle_rad());
        }
    }

    #[test]
    fn the_torque_limit_binds_at_full_duty() {
        let (mut motor, mut pins) = SimMotor::new(&no_drag(), 0.0).expect("valid");
        drive(&mut pins, true, false, MAX_DUTY);
        motor.step(DT_S);
        assert!((motor.acceleration_rad_s2() - 600.0).abs() < 1e-9);
        // 1.5e-4 kg·m² · 600 rad/s² / 0.09 N·m/A = 1 A.
        assert!((pins.sensors.current_a() - 1.0).abs() < 1e-12);
        run(&mut motor, 500);
        assert!((motor.rate_rad_s() - 18.0).abs() < 1e-6, "{}", motor.rate_rad_s());
    }

    #[test]
    fn drag_lowers_the_top_speed_to_the_hand_worked_one() {
        let parameters = MotorParameters { tail_drag_n_m_s2: 7.5e-4, ..MotorParameters::default() };
        let (mut motor, mut pins) = SimMotor::new(&parameters, 0.0).expect("valid");
        drive(&mut pins, true, false, MAX_DUTY);
        run(&mut motor, 1000);
        // (18 − ω)/0.02 = 5·ω²  →  0.1·ω² + ω − 18 = 0  →  ω = (−1 + √8.2)/0.2 = 9.3178 rad/s; the
        // exponential step at dt/τ = 1/20 takes 2.5 % off the motor's slope.
        let rate_rad_s = (-1.0 + 8.2_f64.sqrt()) / 0.2;
        assert!((motor.rate_rad_s() / rate_rad_s - 1.0).abs() < 0.02, "{}", motor.rate_rad_s());
    }

    #[test]
    fn both_low_coasts_without_current_and_both_high_brakes() {
        for (level, keeps, current_a) in [(false, 1.0, 0.0), (true, (-0.05_f64).exp(), -0.8)] {
            let (mut motor, mut pins) = SimMotor::new(&no_drag(), 0.0).expect("valid");
            drive(&mut pins, true, false, MAX_DUTY / 2);
            run(&mut motor, 500);
            let before_rad_s = motor.rate_rad_s();
            drive(&mut pins, level, level, MAX_DUTY);
            motor.step(DT_S);
            assert!((motor.rate_rad_s() - keeps * before_rad_s).abs() < 1e-9, "{level}");
            if level {
                assert!(motor.current_a() < 0.9 * current_a, "{}", motor.current_a());
            } else {
                assert!(motor.current_a().abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_encoder_counts_4096_to_the_turn_from_its_offset() {
        let counts = |angle_rad: f64, encoder_offset_rad: f64| {
            let parameters = MotorParameters { encoder_offset_rad, ..no_drag() };
            let (motor, pins) = SimMotor::new(&parameters, angle_rad).expect("valid");
            assert_eq!(motor.encoder_counts(), pins.sensors.encoder_counts());
            motor.encoder_counts()
        };
        assert_eq!(counts(0.0, 0.0), 0);
        assert_eq!(counts(TAU / 4.0 + 1e-6, 0.0), 1024);
        assert_eq!(counts(-1e-6, 0.0), 4095);
        assert_eq!(counts(-1e-18, 0.0), 0, "rounds up to a whole turn");
        assert_eq!(counts(5.0 * TAU + 1e-6, TAU / 2.0), 2048);
    }

    #[test]
    fn a_jammed_shaft_stands_still_and_draws_the_stall_current() {
        let (mut motor, mut pins) = SimMotor::new(&MotorParameters::default(), 0.0).expect("valid");
        drive(&mut pins, false, true, MAX_DUTY);
        run(&mut motor, 100);
        motor.set_jammed(true);
        motor.step(DT_S);
        assert!(motor.acceleration_rad_s2() > 1000.0, "stops within one step");
        let angle_rad = motor.angle_rad();
        run(&mut motor, 100);
        assert!((motor.angle_rad() - angle_rad).abs() < 1e-15);
        assert!((motor.current_a() + 1.0).abs() < 1e-12, "{}", motor.current_a());
        motor.set_jammed(false);
        run(&mut motor, 100);
        assert!(motor.rate_rad_s() < -15.0);
    }

    #[test]
    fn long_steps_stay_stable() {
        let parameters = MotorParameters { tail_drag_n_m_s2: 1e-2, ..MotorParameters::default() };
        let (mut motor, mut pins) = SimMotor::new(&parameters, 0.0).expect("valid");
        drive(&mut pins, true, false, MAX_DUTY);
        for _ in 0..100 {
            motor.step(0.5);
            assert!((0.0..=18.0).contains(&motor.rate_rad_s()), "{}", motor.rate_rad_s());
        }
    }

    #[test]
    fn impossible_motors_are_refused_by_name() {
        let parameters = MotorParameters { time_constant_s: 0.0, ..MotorParameters::default() };
        let error = SimMotor::new(&parameters, 0.0).expect_err("no time constant");
        assert_eq!((error.key, error.unit), ("time_constant_s", "s"));
    }
}
