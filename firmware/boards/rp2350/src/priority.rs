//! Priority of the control loop: an interrupt of its own, above thread mode, in which the network works.
//!
//! Priorities, the most urgent first: P0 the timer and other interrupts that do no more than wake a task; P1 control; P3 the DMA and the
//! pins, as embassy-rp sets them; thread mode.

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};

static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Where tasks are spawned that run above everything else. Once only.
pub fn start() -> SendSpawner {
    interrupt::SWI_IRQ_0.set_priority(Priority::P1);
    EXECUTOR.start(interrupt::SWI_IRQ_0)
}

#[interrupt]
fn SWI_IRQ_0() {
    // SAFETY: this is its interrupt, which nothing enables before `start`.
    unsafe { EXECUTOR.on_interrupt() }
}
