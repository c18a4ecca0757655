//! Bare pins where a motor would be: two outputs, a compare value and an encoder's register, and nothing behind them.
//!
//! What the smallest driver takes, for the image that shows what the core takes. Outputs and encoder are bits of the FPGA's
//! miscellaneous register (Arm DAI 0386, "FPGA system control"), so the tail stands still whatever is put out.

use core::convert::Infallible;

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;

use crate::registers::Registers;

const PRESCALE: usize = 0x1c;
const MISC: usize = 0x4c;

/// The FPGA's input and output block.
fn block() -> Registers {
    // SAFETY: the block is there; the registers used here are used nowhere else.
    unsafe { Registers::at(0x4002_8000) }
}

/// A bridge of bare pins.
#[must_use]
pub fn bridge() -> Bridge<Compare, Pin, Pin> {
    Bridge::new(Compare, Pin(1 << 0), Pin(1 << 1))
}

/// A compare value.
#[derive(Debug)]
pub struct Compare;

impl pwm::ErrorType for Compare {
    type Error = Infallible;
}

impl SetDutyCycle for Compare {
    fn max_duty_cycle(&self) -> u16 {
        10_000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        block().write(PRESCALE, u32::from(duty));
        Ok(())
    }
}

/// One bit of the outputs.
#[derive(Debug)]
pub struct Pin(u32);

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        let block = block();
        block.write(MISC, block.read(MISC) & !self.0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        let block = block();
        block.write(MISC, block.read(MISC) | self.0);
        Ok(())
    }
}

/// A 12-bit encoder's register.
#[derive(Debug)]
pub struct Register;

impl Encoder for Register {
    type Error = Infallible;
    const COUNTS_PER_TURN: u32 = 4096;

    fn counts(&mut self) -> Result<u32, Infallible> {
        Ok(block().read(MISC) >> 2 & 0xfff)
    }
}
