//! Bare pins where a motor would be: two outputs, a compare value and an encoder's register, and the least motor behind them that swims.
//!
//! ```text
//! ω ← ω + (ω₀·d − ω)/20,   φ ← φ + ω        once a reading of the encoder, which is once a tick of 1 ms: τ_m = 20 ms
//! ```
//!
//! About what the smallest driver takes, for the image that shows what the core takes. The outputs are bits of the FPGA's
//! miscellaneous register and its prescaler (Arm DAI 0386, "FPGA system control").

use core::convert::Infallible;
use core::sync::atomic::{AtomicI32, Ordering};

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::motor::Bridge;

use crate::registers::Registers;

const PRESCALE: usize = 0x1c;
const MISC: usize = 0x4c;

/// ω₀ = 18 rad/s, in 2⁻¹⁶ counts of 4096 in a turn, a millisecond, for one count of the duty.
const SPEED: i32 = 77;

static RATE: AtomicI32 = AtomicI32::new(0);
/// Wraps with the turn and its counts: 2²⁸ in a turn.
static ANGLE: AtomicI32 = AtomicI32::new(0);

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
        let block = block();
        let outputs = block.read(MISC);
        let duty = block.read(PRESCALE).cast_signed();
        let drive = match outputs & 3 {
            1 => duty,
            2 => -duty,
            _ => 0,
        };
        let rate = RATE.load(Ordering::Relaxed);
        let rate = rate + (drive * SPEED - rate) / 20;
        let angle = ANGLE.load(Ordering::Relaxed).wrapping_add(rate);
        RATE.store(rate, Ordering::Relaxed);
        ANGLE.store(angle, Ordering::Relaxed);
        Ok(angle.cast_unsigned() >> 16 & 0xfff)
    }
}
