//! Microseconds since boot on one CMSDK timer, the tick on another (Arm DDI 0479, "APB timer"; both count down at 25 MHz).
//!
//! The free timer wraps every 171 s; a caller that reads the time at least that often, as the tick does, never sees it. Microseconds
//! are added up as they pass, which takes no division of 64 bits.

use core::cell::RefCell;

use cortex_m::peripheral::NVIC;
use critical_section::Mutex;
use protocol::time::{Duration, LocalInstant};

use crate::registers::Registers;

/// Counts in a microsecond: the board's clock of 25 MHz.
const PER_MICROSECOND: u32 = 25;

const CTRL: usize = 0x00;
const VALUE: usize = 0x04;
const RELOAD: usize = 0x08;
const INT_CLEAR: usize = 0x0c;
const ENABLE: u32 = 1;
const INTERRUPT: u32 = 1 << 3;

/// Interrupts of this board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// The tick.
    Tick = 9,
    /// The Ethernet controller.
    Ethernet = 13,
}

// SAFETY: the numbers are those of the board's interrupt map (Arm DAI 0386, table 3-6), each once.
unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

struct Free {
    timer: Registers,
    last: u32,
    counts: u64,
    micros: u64,
    /// Counts of the microsecond that has begun.
    rest: u32,
}

impl Free {
    fn update(&mut self) {
        let count = u32::MAX - self.timer.read(VALUE);
        let passed = count.wrapping_sub(self.last);
        self.last = count;
        self.counts += u64::from(passed);
        let (whole, rest) = (passed / PER_MICROSECOND, passed % PER_MICROSECOND + self.rest);
        self.micros += u64::from(whole + rest / PER_MICROSECOND);
        self.rest = rest % PER_MICROSECOND;
    }
}

static FREE: Mutex<RefCell<Free>> = Mutex::new(RefCell::new(Free {
    // SAFETY: CMSDK timer 0, used here alone.
    timer: unsafe { Registers::at(0x4000_0000) },
    last: 0,
    counts: 0,
    micros: 0,
    rest: 0,
}));

fn with<T: Default>(use_it: impl FnOnce(&mut Free) -> T) -> T {
    // The cell is not borrowed while interrupts are off, but the compiler cannot know.
    critical_section::with(|cs| {
        FREE.borrow(cs).try_borrow_mut().map_or_else(|_| T::default(), |mut free| use_it(&mut free))
    })
}

/// Starts the clock.
pub fn start() {
    with(|free| {
        free.timer.write(RELOAD, u32::MAX);
        free.timer.write(VALUE, u32::MAX);
        free.timer.write(CTRL, ENABLE);
    });
}

/// Counts since the start, 25 to a microsecond.
pub fn counts() -> u64 {
    with(|free| {
        free.update();
        free.counts
    })
}

/// Time since the start, own clock.
#[must_use]
pub fn now() -> LocalInstant {
    with(|free| {
        free.update();
        LocalInstant(free.micros)
    })
}

/// The tick's timer.
#[derive(Debug)]
pub struct Tick {
    timer: Registers,
    counts: u32,
}

impl Tick {
    /// Interrupts every `interval` from now on.
    #[must_use]
    pub fn start(interval: Duration) -> Self {
        let counts = interval.0.saturating_mul(PER_MICROSECOND).max(PER_MICROSECOND);
        // SAFETY: CMSDK timer 1, used here alone.
        let timer = unsafe { Registers::at(0x4000_1000) };
        timer.write(RELOAD, counts - 1);
        timer.write(VALUE, counts - 1);
        timer.write(INT_CLEAR, 1);
        timer.write(CTRL, ENABLE | INTERRUPT);
        Self { timer, counts }
    }

    /// Whether a tick is due; it is not any more then.
    pub fn take(&self) -> bool {
        let due = self.is_due();
        if due {
            self.timer.write(INT_CLEAR, 1);
        }
        due
    }

    /// Whether a tick is due.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.timer.read(INT_CLEAR) & 1 != 0
    }

    /// How long ago the last tick was due.
    #[must_use]
    pub fn late(&self) -> Duration {
        Duration((self.counts - 1).saturating_sub(self.timer.read(VALUE)) / PER_MICROSECOND)
    }
}

/// Lets the control loop run as if a tick had come: a datagram waits for it.
pub fn call_control() {
    NVIC::pend(Interrupt::Tick);
}
