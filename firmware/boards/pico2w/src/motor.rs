//! PWM output of the motor bridge, at zero duty from its first instant.
//!
//! `firmware::modboat::motor::Bridge` changes the direction while the duty is zero. The timer takes a new duty with its next period, 50 µs
//! later at most, and until then the old one would drive the new direction. So with a duty of zero the timer is set to the end of
//! its period: the next count begins another.
//!
//! Source: RP2350 datasheet, section 12.5.2.3: a duty is taken over when the counter wraps.

use embassy_rp::pwm::{Pwm, PwmError, SetDutyCycle};
use embedded_hal::pwm::ErrorType;

/// PWM output of the motor bridge; it starts at zero duty.
pub struct MotorPwm(pub Pwm<'static>);

impl ErrorType for MotorPwm {
    type Error = PwmError;
}

impl SetDutyCycle for MotorPwm {
    fn max_duty_cycle(&self) -> u16 {
        self.0.max_duty_cycle()
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), PwmError> {
        self.0.set_duty_cycle(duty)?;
        if duty == 0 {
            self.0.set_counter(self.0.max_duty_cycle());
        }
        Ok(())
    }
}
