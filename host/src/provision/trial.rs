//! The firmware, built from a configuration that is about to be written: what does not come to life here would not on the board.

use core::convert::Infallible;

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;
use firmware::modboat::quadrature::READINGS;
use firmware::modboat::servo::NoSense;
use firmware::provision::{self, NotProvisioned};
use protocol::Configuration;
use protocol::configuration::{IMAGE_MAX, Robot};
use protocol::message::MAX_THRUSTERS;
use zeroize::Zeroizing;

/// A pin of no board.
struct Pin;

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl pwm::ErrorType for Pin {
    type Error = Infallible;
}

impl SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        u16::MAX
    }

    fn set_duty_cycle(&mut self, _: u16) -> Result<(), Infallible> {
        Ok(())
    }
}

/// An encoder on no axis.
struct Still;

impl Encoder for Still {
    type Error = Infallible;

    const COUNTS_PER_TURN: u32 = READINGS;

    fn counts(&mut self) -> Result<u32, Infallible> {
        Ok(0)
    }
}

/// Whether a module could be written so, and would run.
pub(super) fn run(configuration: &Configuration) -> Result<(), NotProvisioned> {
    configuration.write(&mut *Zeroizing::new([0; IMAGE_MAX]))?;
    match configuration.robot {
        Robot::Modboat(_) => {
            let bridge = Bridge::new(Pin, Pin, Pin);
            provision::modboat(configuration, [0; 12], Still, NoSense, bridge).map(drop)
        }
        Robot::Rov(_) => {
            provision::rov(configuration, [0; 12], core::array::from_fn::<_, MAX_THRUSTERS, _>(|_| Pin))
                .map(drop)
        }
    }
}
