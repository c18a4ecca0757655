//! The watchdog, and everything else that resets the chip.
//!
//! A reset is what makes the outputs safe: a pin is no output then. So the resistors at the inputs of a motor bridge brake the tail, and the
//! controller of a thruster, without pulses, stops.
//!
//! | what | resets |
//! |---|---|
//! | the control loop has not fed it for [`TIMEOUT`] | the watchdog, by itself |
//! | booting takes longer than [`BOOT_TIMEOUT`] | the same |
//! | a panic, a fault of the processor | at once |
//! | an interrupt without a handler, an endless loop with interrupts off | the watchdog, as the control loop does not run |
//!
//! Assumptions and limits: the watchdog restarts the chip from its oscillators on, and with that resets the peripherals and the pads
//! (RP2350 datasheet, sections 7.4.1, 7.5 and 9.7), which a reset of the processor alone may leave as they are. Nothing else
//! feeds it. The chip's pull-down is weak, and on its revision A2 weaker than the leakage of an input (erratum E9; not that of a pin
//! after a reset): a level that matters then has a resistor of its own, 10 kΩ or less to 3.3 V or 8.2 kΩ or less to ground.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use embassy_rp::Peri;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog;
use embassy_time::Duration;

/// The chip is reset when not fed for this time: ten times the longest interval of a control loop. *Assumed.*
pub const TIMEOUT: Duration = Duration::from_millis(100);

/// The same until the control loop runs. *Assumed*: the random numbers may take a second.
pub const BOOT_TIMEOUT: Duration = Duration::from_secs(2);

/// The watchdog timer; the control loop feeds it.
pub struct Watchdog(watchdog::Watchdog);

impl Watchdog {
    /// Running from now on.
    #[must_use]
    pub fn start(peripheral: Peri<'static, WATCHDOG>) -> Self {
        let mut watchdog = watchdog::Watchdog::new(peripheral);
        watchdog.start(BOOT_TIMEOUT);
        Self(watchdog)
    }

    /// Feeds it.
    pub fn feed(&mut self) {
        self.0.feed(TIMEOUT);
    }
}

/// Resets the chip now.
pub fn reset() -> ! {
    // SAFETY: another holder of the watchdog can do no more than feed it, and the chip is about to forget both.
    let peripheral = unsafe { WATCHDOG::steal() };
    watchdog::Watchdog::new(peripheral).trigger_reset();
    // It takes some cycles.
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    reset()
}

// SAFETY: it touches no memory that the fault may have left half written, and does not return.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    reset()
}
