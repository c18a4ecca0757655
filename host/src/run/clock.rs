//! Ticks of a thousandth of a second, simulated or awaited.

use std::time::{Duration, Instant};

use protocol::time::FleetInstant;
use sim::module::TICK;

/// Whose time a run follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Simulated time, as fast as the machine can.
    Simulated,
    /// Simulated time, no faster than the wall clock: to watch.
    Watched,
    /// The wall clock's: with modules that have clocks of their own.
    Real,
}

/// See the module's documentation.
pub(super) struct Clock {
    pace: Pace,
    began: Instant,
    tick: FleetInstant,
}

impl Clock {
    /// At tick zero, now.
    pub(super) fn new(pace: Pace) -> Self {
        Self { pace, began: Instant::now(), tick: FleetInstant(0) }
    }

    /// How long it has run by the wall clock, s.
    pub(super) fn elapsed_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// The next tick; in real time it waits for it.
    pub(super) fn next_tick(&mut self) -> FleetInstant {
        self.tick = self.tick.after(TICK);
        if self.pace != Pace::Simulated {
            let due = self.began + Duration::from_micros(self.tick.0);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        self.tick
    }

    /// The time now: of the tick in a simulation, of the wall clock otherwise.
    pub(super) fn now(&self) -> FleetInstant {
        match self.pace {
            Pace::Simulated | Pace::Watched => self.tick,
            Pace::Real => FleetInstant(self.began.elapsed().as_micros() as u64),
        }
    }
}
