//! The watchdog, and everything else that resets the chip.
//!
//! A reset is what makes the outputs safe: pins are inputs with a weak pull-down then, so a motor bridge is off and a thruster's
//! controller, without pulses, stops. The tail runs free.
//!
//! | what | resets |
//! |---|---|
//! | the control loop has not fed it for [`TIMEOUT`] | the watchdog, by itself |
//! | a panic, a fault of the processor | at once |
//! | an interrupt that nobody handles, an endless loop with interrupts off | the watchdog, as the control loop does not run |
//!
//! Assumptions and limits: the watchdog resets all but the oscillators (RP2350 datasheet, section 12.9), the peripherals of the
//! pins included, which a reset of the processor alone leaves as they are. Nobody else feeds it.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use embassy_rp::Peri;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog;
use embassy_time::Duration;

/// So long without food, and the chip is reset: ten times the longest interval of a control loop. *Assumed.*
pub const TIMEOUT: Duration = Duration::from_millis(100);

/// See the module's documentation.
pub struct Watchdog(watchdog::Watchdog);

impl Watchdog {
    /// Running from now on.
    #[must_use]
    pub fn start(peripheral: Peri<'static, WATCHDOG>) -> Self {
        let mut watchdog = watchdog::Watchdog::new(peripheral);
        watchdog.start(TIMEOUT);
        Self(watchdog)
    }

    /// Feeds it.
    pub fn feed(&mut self) {
        self.0.feed(TIMEOUT);
    }
}

/// Resets the chip now.
pub fn reset() -> ! {
    // SAFETY: whoever else has the watchdog can do no more than feed it, and the chip is about to forget both.
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
