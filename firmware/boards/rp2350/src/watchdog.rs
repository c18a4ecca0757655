//! The watchdog, and everything else that resets the chip.
//!
//! A reset is what makes the outputs safe: a pin is no output then. So the resistors at the inputs of a motor bridge brake the tail, and the
//! controller of a thruster, without pulses, stops.
//!
//! | what | resets |
//! |---|---|
//! | the control loop has not fed it for [`INTERVALS`] | the watchdog, by itself |
//! | booting takes longer than [`BOOT_TIMEOUT`] | the same |
//! | a panic, a fault of the processor | at once |
//! | an interrupt without a handler, an endless loop with interrupts off | the watchdog, as the control loop does not run |
//!
//! Four of its scratch registers keep what a reset by the watchdog is not to lose ([`Scratch`]): such a reset leaves them alone, and a power-on, a
//! brown-out and the RUN pin clear them (RP2350 datasheet, section 12.9.5). The boot ROM looks at the upper four (section 5.2.4), so these
//! are the lower ones. A debugger's reset clears the reason of the last one (section 12.9.7), so what it finds there is not believed.
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
use firmware::modboat::kept_zero::{RetainedMemory, WORDS};

/// The chip is reset when not fed for so many intervals of the loop that feeds it: what was put out last goes on for no longer. *Assumed*: a tick that
/// waits for a datagram is half a millisecond late.
pub const INTERVALS: u32 = 10;

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

    /// Feeds it, in a loop of this interval.
    pub fn feed(&mut self, interval: Duration) {
        self.0.feed(interval * INTERVALS);
    }
}

/// The watchdog's lower scratch registers.
pub struct Scratch(());

impl Watchdog {
    /// Its scratch registers, for the one who keeps something there.
    #[must_use]
    pub const fn scratch(&self) -> Scratch {
        Scratch(())
    }
}

impl Scratch {
    fn registers() -> watchdog::Watchdog {
        // SAFETY: nothing else touches the scratch registers and the reason of the last reset, and nothing else is touched here.
        watchdog::Watchdog::new(unsafe { WATCHDOG::steal() })
    }
}

impl RetainedMemory for Scratch {
    fn recall(&mut self) -> Option<[u32; WORDS]> {
        let mut registers = Self::registers();
        registers.reset_reason()?;
        Some([0, 1, 2, 3].map(|index| registers.get_scratch(index)))
    }

    fn keep(&mut self, words: [u32; WORDS]) {
        let mut registers = Self::registers();
        for (index, word) in words.into_iter().enumerate() {
            registers.set_scratch(index, word);
        }
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
