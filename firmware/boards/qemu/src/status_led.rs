//! The status LED: the board's first user LED (Arm DAI 0386, "FPGA system control", FPGAIO_LED0).

use crate::registers::Registers;

const LED0: usize = 0x00;

/// The status LED of the emulated board.
#[derive(Debug)]
pub struct StatusLed {
    registers: Registers,
    lit: bool,
}

impl StatusLed {
    /// Off.
    ///
    /// # Safety
    /// Only one may be in use.
    #[must_use]
    pub unsafe fn new() -> Self {
        // SAFETY: the FPGA's input and output block; the caller has no other status LED.
        let registers = unsafe { Registers::at(0x4002_8000) };
        registers.write(LED0, 0);
        Self { registers, lit: false }
    }

    /// On or off; whether that is a change.
    pub fn set(&mut self, lit: bool) -> bool {
        let changes = lit != self.lit;
        if changes {
            self.registers.write(LED0, u32::from(lit));
            self.lit = lit;
        }
        changes
    }
}
