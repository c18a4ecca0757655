//! The watchdog: the board's CMSDK watchdog (Arm DDI 0479, "APB watchdog"), whose time-out is the processor's NMI.
//!
//! It runs only where a test lets the control loop hang: an emulator that gets no processor for a while looks the same.

use cortex_m::peripheral::SCB;

use crate::registers::Registers;

const LOAD: usize = 0x00;
const CONTROL: usize = 0x08;
const INT_CLEAR: usize = 0x0c;
const LOCK: usize = 0xc00;
const UNLOCK: u32 = 0x1acc_e551;
/// It counts down, and interrupts at zero; without an answer it resets at the next zero.
const INTERRUPTS: u32 = 1;
const RESETS: u32 = 1 << 1;

/// Ten ticks of 1 ms at 25 MHz, as on other boards.
const TIMEOUT: u32 = 250_000;

// SAFETY: the watchdog's registers, used here alone.
const WATCHDOG: Registers = unsafe { Registers::at(0x4000_8000) };

/// Running from now on.
pub fn start() {
    WATCHDOG.write(LOCK, UNLOCK);
    WATCHDOG.write(LOAD, TIMEOUT);
    WATCHDOG.write(CONTROL, INTERRUPTS | RESETS);
}

/// Feeds it, if it runs.
pub fn feed() {
    WATCHDOG.write(INT_CLEAR, 1);
}

/// It was not fed.
pub fn timed_out() -> ! {
    SCB::sys_reset()
}
