//! Lines of text on the first CMSDK UART (Arm DDI 0479, "APB UART").

use core::fmt;

use crate::registers::Registers;

const DATA: usize = 0x00;
const STATE: usize = 0x04;
const CTRL: usize = 0x08;
const BAUD_DIVIDER: usize = 0x10;
const TX_FULL: u32 = 1;
const RX_FULL: u32 = 1 << 1;
const TX_ENABLE: u32 = 1;
const RX_ENABLE: u32 = 1 << 1;

/// Writes, and waits where the line is slower.
#[derive(Debug)]
pub struct Uart(Registers);

impl Uart {
    /// The first one, at 25 MHz/217 = 115 207 baud.
    ///
    /// # Safety
    /// Only one may be in use.
    #[must_use]
    pub unsafe fn first() -> Self {
        // SAFETY: CMSDK UART 0; the caller has no other.
        let registers = unsafe { Registers::at(0x4000_4000) };
        registers.write(BAUD_DIVIDER, 217);
        registers.write(CTRL, TX_ENABLE | RX_ENABLE);
        Self(registers)
    }

    /// Writes bytes.
    pub fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            while self.0.read(STATE) & TX_FULL != 0 {}
            self.0.write(DATA, u32::from(byte));
        }
    }

    /// The next byte that has come, if one has.
    pub fn read(&mut self) -> Option<u8> {
        #[expect(clippy::cast_possible_truncation, reason = "eight bits of data")]
        (self.0.read(STATE) & RX_FULL != 0).then(|| self.0.read(DATA) as u8)
    }
}

impl fmt::Write for Uart {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.write(text.as_bytes());
        Ok(())
    }
}
