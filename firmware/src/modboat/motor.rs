//! The motor bridge: a signed drive to a duty cycle and two direction pins.
//!
//! | state | in1 | in2 | duty |
//! |---|---|---|---|
//! | forward (counter-clockwise) | high | low | \|drive\| |
//! | reverse (clockwise) | low | high | \|drive\| |
//! | coast | low | low | 0 |
//! | brake | high | high | full |
//!
//! Pins change only while the duty is zero, the falling one first, so the bridge never drives the old direction with the
//! new pins. A drive of zero is zero volts across the motor, which damps it; to let it run free, coast.
//!
//! Assumptions and limits: a bridge that shorts the motor in the off part of the duty (drive/brake, such as the
//! TB6612FNG), for which the mean voltage is proportional to the duty, zero included; one that lets it float
//! (drive/coast, such as the L298N on its enable pin) is not linear at small duties. Motor leads swapped: swap the
//! pins.

use core::fmt;

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

/// Which of the three outputs failed, with what it reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BridgeError<P, A, B> {
    /// The PWM output.
    Pwm(P),
    /// Direction pin in1.
    In1(A),
    /// Direction pin in2.
    In2(B),
}

impl<P: fmt::Debug, A: fmt::Debug, B: fmt::Debug> fmt::Display for BridgeError<P, A, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pwm(error) => write!(f, "motor PWM: {error:?}"),
            Self::In1(error) => write!(f, "motor pin in1: {error:?}"),
            Self::In2(error) => write!(f, "motor pin in2: {error:?}"),
        }
    }
}

impl<P: fmt::Debug, A: fmt::Debug, B: fmt::Debug> core::error::Error for BridgeError<P, A, B> {}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// After boot or a failure: nothing is assumed about the pins.
    Unknown,
    Coast,
    Forward,
    Reverse,
    Brake,
}

/// A bridge of one PWM output and two direction pins.
#[derive(Debug)]
pub struct Bridge<P, A, B> {
    pwm: P,
    in1: A,
    in2: B,
    state: State,
}

/// The error type of a bridge made of these parts.
pub type ErrorOf<P, A, B> = BridgeError<
    <P as embedded_hal::pwm::ErrorType>::Error,
    <A as embedded_hal::digital::ErrorType>::Error,
    <B as embedded_hal::digital::ErrorType>::Error,
>;

impl<P: SetDutyCycle, A: OutputPin, B: OutputPin> Bridge<P, A, B> {
    /// From its parts. Nothing is written before the first command.
    pub const fn new(pwm: P, in1: A, in2: B) -> Self {
        Self { pwm, in1, in2, state: State::Unknown }
    }

    /// Drives with `drive` in −1..1 of the supply, counter-clockwise positive; beyond that it is limited. Zero
    /// leaves the direction as it is. NaN coasts.
    ///
    /// # Errors
    /// The output that failed. The next command writes all of them again.
    pub fn drive(&mut self, drive: f32) -> Result<(), ErrorOf<P, A, B>> {
        if drive.is_nan() {
            return self.coast();
        }
        let duty = duty_of(drive, self.pwm.max_duty_cycle());
        // At zero either direction will do: the pins stay, unless they are neither.
        let keep = duty == 0 && matches!(self.state, State::Forward | State::Reverse);
        if !keep {
            self.enter(if drive < 0.0 { State::Reverse } else { State::Forward })?;
        }
        self.set_duty(duty)
    }

    /// Lets the motor run free.
    ///
    /// # Errors
    /// The output that failed. The next command writes all of them again.
    pub fn coast(&mut self) -> Result<(), ErrorOf<P, A, B>> {
        self.enter(State::Coast)
    }

    /// Shorts the motor, which holds it against slow movement.
    ///
    /// # Errors
    /// The output that failed. The next command writes all of them again.
    pub fn brake(&mut self) -> Result<(), ErrorOf<P, A, B>> {
        if self.state == State::Brake {
            return Ok(());
        }
        self.enter(State::Brake)?;
        self.set_duty(self.pwm.max_duty_cycle())
    }

    /// Gives the parts back.
    pub fn release(self) -> (P, A, B) {
        (self.pwm, self.in1, self.in2)
    }

    /// Sets the pins for `state`, with the duty at zero while they change.
    fn enter(&mut self, state: State) -> Result<(), ErrorOf<P, A, B>> {
        if self.state == state {
            return Ok(());
        }
        self.set_duty(0)?;
        self.state = State::Unknown;
        let (in1_high, in2_high) = match state {
            State::Coast | State::Unknown => (false, false),
            State::Forward => (true, false),
            State::Reverse => (false, true),
            State::Brake => (true, true),
        };
        // Low before high: both are high in brake only.
        if !in1_high {
            self.in1.set_low().map_err(BridgeError::In1)?;
        }
        if !in2_high {
            self.in2.set_low().map_err(BridgeError::In2)?;
        }
        if in1_high {
            self.in1.set_high().map_err(BridgeError::In1)?;
        }
        if in2_high {
            self.in2.set_high().map_err(BridgeError::In2)?;
        }
        self.state = state;
        Ok(())
    }

    fn set_duty(&mut self, duty: u16) -> Result<(), ErrorOf<P, A, B>> {
        self.pwm.set_duty_cycle(duty).map_err(|error| {
            self.state = State::Unknown;
            BridgeError::Pwm(error)
        })
    }
}

/// |drive|, at most 1, in steps of the PWM. NaN gives 0.
#[cfg_attr(
    not(test),
    expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rounded and between 0 and `full`; the cast saturates and takes NaN to 0"
    )
)]
fn duty_of(drive: f32, full: u16) -> u16 {
    let duty = libm::roundf(libm::fabsf(drive) * f32::from(full)) as u16;
    duty.min(full)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Level::{High, Low};
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State as Level, Transaction as Set};
    use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as Duty};
    use proptest::prelude::*;
    use std::cell::RefCell;
    use std::convert::Infallible;
    use std::rc::Rc;
    use std::vec::Vec;

    /// Runs `use_it` on a bridge of mocks that expect exactly these writes, in this order for each output.
    fn expect(duty: &[Duty], in1: &[Level], in2: &[Level], use_it: impl FnOnce(&mut Bridge<Pwm, Pin, Pin>)) {
        let pin =
            |levels: &[Level]| Pin::new(&levels.iter().map(|level| Set::set(*level)).collect::<Vec<_>>());
        let mut bridge = Bridge::new(Pwm::new(duty), pin(in1), pin(in2));
        use_it(&mut bridge);
        let (mut pwm, mut in1, mut in2) = bridge.release();
        pwm.done();
        in1.done();
        in2.done();
    }

    fn full() -> Duty {
        Duty::max_duty_cycle(1000)
    }

    fn duty(duty: u16) -> Duty {
        Duty::set_duty_cycle(duty)
    }

    #[test]
    fn forward() {
        expect(&[full(), duty(0), duty(250), full(), duty(500)], &[High], &[Low], |bridge| {
            bridge.drive(0.25).unwrap();
            bridge.drive(0.5).unwrap();
        });
    }

    #[test]
    fn reverse() {
        expect(&[full(), duty(0), duty(250), full(), duty(1000)], &[Low], &[High], |bridge| {
            bridge.drive(-0.25).unwrap();
            bridge.drive(-7.0).unwrap();
        });
    }

    #[test]
    fn direction_changes_at_zero_duty() {
        let writes = [full(), duty(0), duty(900), full(), duty(0), duty(300)];
        expect(&writes, &[High, Low], &[Low, High], |bridge| {
            bridge.drive(0.9).unwrap();
            bridge.drive(-0.3).unwrap();
        });
    }

    #[test]
    fn zero_keeps_the_direction() {
        let writes = [full(), duty(0), duty(900), full(), duty(0), full(), duty(0), full(), duty(10)];
        expect(&writes, &[Low], &[High], |bridge| {
            bridge.drive(-0.9).unwrap();
            bridge.drive(0.0).unwrap();
            bridge.drive(0.0004).unwrap();
            bridge.drive(-0.01).unwrap();
        });
    }

    #[test]
    fn stop_is_coast_or_brake() {
        let writes = [full(), duty(0), duty(900), duty(0), duty(0), full(), duty(1000)];
        expect(&writes, &[High, Low, High], &[Low, Low, High], |bridge| {
            bridge.drive(0.9).unwrap();
            bridge.drive(f32::NAN).unwrap();
            bridge.coast().unwrap();
            bridge.brake().unwrap();
            bridge.brake().unwrap();
        });
    }

    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Write {
        Duty(u16),
        In1(bool),
        In2(bool),
    }

    /// Outputs that share one record, and fail when told to.
    #[derive(Clone, Default)]
    struct Board {
        writes: Rc<RefCell<Vec<Write>>>,
        failing: Rc<RefCell<bool>>,
    }

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Broken;

    impl embedded_hal::pwm::Error for Broken {
        fn kind(&self) -> embedded_hal::pwm::ErrorKind {
            embedded_hal::pwm::ErrorKind::Other
        }
    }

    impl embedded_hal::pwm::ErrorType for Board {
        type Error = Broken;
    }

    impl SetDutyCycle for Board {
        fn max_duty_cycle(&self) -> u16 {
            1000
        }

        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Broken> {
            if *self.failing.borrow() {
                return Err(Broken);
            }
            self.writes.borrow_mut().push(Write::Duty(duty));
            Ok(())
        }
    }

    struct Line(Board, fn(bool) -> Write);

    impl embedded_hal::digital::ErrorType for Line {
        type Error = Infallible;
    }

    impl OutputPin for Line {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.writes.borrow_mut().push((self.1)(false));
            Ok(())
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.writes.borrow_mut().push((self.1)(true));
            Ok(())
        }
    }

    #[test]
    fn rewrites_every_output_after_a_failure() {
        let board = Board::default();
        let mut bridge =
            Bridge::new(board.clone(), Line(board.clone(), Write::In1), Line(board.clone(), Write::In2));
        bridge.drive(0.5).unwrap();
        *board.failing.borrow_mut() = true;
        assert_eq!(bridge.drive(0.6), Err(BridgeError::Pwm(Broken)));
        assert_eq!(bridge.coast(), Err(BridgeError::Pwm(Broken)));
        *board.failing.borrow_mut() = false;
        board.writes.borrow_mut().clear();
        bridge.drive(0.5).unwrap();
        let expected = [Write::Duty(0), Write::In2(false), Write::In1(true), Write::Duty(500)];
        assert_eq!(*board.writes.borrow(), expected);
    }

    proptest! {
        /// Whatever is asked for, in whatever order: no pin changes unless the duty is zero, both pins are high
        /// in brake only, and the sign of what is driven is the sign asked for.
        #[test]
        fn pins_change_at_zero_duty_only(bits in proptest::collection::vec((any::<u32>(), -1.2_f32..1.2, 0_u8..8), 1..60)) {
            let board = Board::default();
            let mut bridge = Bridge::new(board.clone(), Line(board.clone(), Write::In1), Line(board.clone(), Write::In2));
            let (mut duty, mut in1, mut in2) = (0_u16, false, false);
            for (bits, drive, command) in bits {
                let drive = if command == 0 { f32::from_bits(bits) } else { drive };
                match command {
                    1 => bridge.brake().unwrap(),
                    2 => bridge.coast().unwrap(),
                    _ => bridge.drive(drive).unwrap(),
                }
                for write in board.writes.borrow_mut().drain(..) {
                    match write {
                        Write::Duty(set) => duty = set,
                        Write::In1(level) => { prop_assert!(duty == 0 || level == in1); in1 = level; }
                        Write::In2(level) => { prop_assert!(duty == 0 || level == in2); in2 = level; }
                    }
                    // Out of brake the pins fall one after the other, at zero duty.
                    prop_assert!(!(in1 && in2) || command == 1 || duty == 0);
                }
                let driven = f32::from(duty) / 1000.0 * (f32::from(u8::from(in1)) - f32::from(u8::from(in2)));
                let asked = if command == 1 || command == 2 || drive.is_nan() { 0.0 } else { drive.clamp(-1.0, 1.0) };
                prop_assert!((driven - asked).abs() <= 0.0005001, "{driven} for {asked}");
            }
        }
    }
}
