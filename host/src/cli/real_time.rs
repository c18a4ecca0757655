//! Ticks of simulated modules in real time, until they are told to end.
//!
//! A process that was kept from the processor catches up tick by tick: firmware, motor and water live through each of them, as a real
//! module would have. Radios are silent meanwhile. A datagram that was read at a tick that is past would be stamped earlier than it came,
//! and modules' clocks would follow it; one that waits is as late as by a slow network.

use std::sync::atomic::Ordering;

use super::{Failure, signal};
use crate::run::clock::{Clock, Pace, Tick};

/// When a simulated module lives through a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Live {
    /// The tick, and what was left out before it.
    pub(super) tick: Tick,
    /// Its time is now: what came is read, and what there is to say is sent.
    pub(super) hears: bool,
}

/// Lets `step` live through every tick of real time until a signal, or for `duration`, s.
pub(super) fn live(
    duration: Option<f64>,
    mut step: impl FnMut(Live) -> Result<(), Failure>,
) -> Result<(), Failure> {
    signal::watch();
    let mut clock = Clock::new(Pace::Real);
    loop {
        let tick = clock.next_tick();
        let ends = duration.is_some_and(|seconds| tick.now.as_secs_f64() >= seconds);
        if signal::STOP.load(Ordering::Relaxed) || ends {
            return Ok(());
        }
        step(Live { hears: clock.is_due(&tick), tick })?;
    }
}
