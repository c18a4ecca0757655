//! Lock step with a test: at every step of this board's own clock the whole emulator stands still until the test lets it go on.
//!
//! Only where the emulator's command line asks for it, and only where it counts instructions (`-icount`): then what a test sees
//! does not depend on how fast the PC is. The board writes what it has exchanged with the network to a file of the debugger's,
//! by semihosting; the debugger is the test, and answers when the next step may begin.
//!
//! ```text
//! SysTick   every STEP µs   write("steps", sent, received) ─→ debugger stops the emulator … answers ─→ goes on
//! ```
//!
//! The emulator stands still in two acts: first the processor, then its time. In between it may take the processor for one that
//! sleeps, and jump to the time of the next timer (QEMU 7.2, `icount_start_warp_timer` between `vm_stop` in the thread of the processor
//! and in the main loop). So a timer is due a moment after the call, and is waited for: time is the same then whether it has jumped or
//! not, to the few instructions of the loop that waits. Before the first step there is no timer to jump to.

use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

use crate::registers::Registers;
use crate::semihosting;

/// SysTick and the dual timer count the board's clock, 25 MHz.
const PER_MICROSECOND: u32 = 25;

/// The word on the command line, with the length of a step in microseconds behind it.
const WORD: &str = "step";

/// Long enough for the few instructions between the start of its timer and the call.
const MOMENT_US: u32 = 5;

// The CMSDK dual timer's first (Arm DDI 0479, "Dual-input timers").
const LOAD: usize = 0x00;
const CONTROL: usize = 0x08;
const INT_CLEAR: usize = 0x0c;
const RAW_STATUS: usize = 0x10;
const ENABLE: u32 = 1 << 7;
const WIDE: u32 = 1 << 1;
const ONE_SHOT: u32 = 1;

/// Semihosting's handle of the file; no step has one before it is opened.
static FILE: AtomicUsize = AtomicUsize::new(0);
static SENT: AtomicU32 = AtomicU32::new(0);
static RECEIVED: AtomicU32 = AtomicU32::new(0);

/// Begins to step if that is asked for. No timer runs before.
pub fn start(mut timer: SYST) {
    let Some(step_us) = semihosting::number_after(WORD) else { return };
    let file = semihosting::open_to_write(c"steps").expect("a file for steps");
    FILE.store(file, Ordering::Relaxed);
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(step_us.saturating_mul(PER_MICROSECOND).saturating_sub(1));
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

/// Datagrams that have left this board, and those that have come, since its start.
pub fn count(sent: u32, received: u32) {
    SENT.store(sent, Ordering::Relaxed);
    RECEIVED.store(received, Ordering::Relaxed);
}

/// A step is over: returns a moment after the call, when the next one may begin.
pub fn interrupted() {
    let (sent, received) = (SENT.load(Ordering::Relaxed), RECEIVED.load(Ordering::Relaxed));
    let mut bytes = [0; 8];
    bytes[..4].copy_from_slice(&sent.to_le_bytes());
    bytes[4..].copy_from_slice(&received.to_le_bytes());
    // SAFETY: the CMSDK dual timer, used here alone.
    let timer = unsafe { Registers::at(0x4000_2000) };
    timer.write(CONTROL, 0);
    timer.write(INT_CLEAR, 1);
    timer.write(LOAD, MOMENT_US * PER_MICROSECOND);
    timer.write(CONTROL, ENABLE | WIDE | ONE_SHOT);
    semihosting::write(FILE.load(Ordering::Relaxed), &bytes);
    while timer.read(RAW_STATUS) & 1 == 0 {}
}
