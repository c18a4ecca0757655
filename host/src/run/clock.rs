//! Ticks of a thousandth of a second, simulated or awaited.
//!
//! A host that did not run for a while (it was suspended, stopped or kept from the processor) does not catch up tick by tick: what it
//! would decide for then is of no use now. It goes on from now, and the span is a [`Gap`].

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

/// Ticks that come later than this are not caught up with. *Assumed*: less than the time from one decision to the next, so that nothing
/// is planned into the past, and more than a busy machine keeps a process from running.
const LATE_MAX: Duration = Duration::from_millis(500);

/// A span in which the host did not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The last tick before it.
    pub start: FleetInstant,
    /// The first one after it.
    pub end: FleetInstant,
}

impl Gap {
    /// Its length, s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.end.as_secs_f64() - self.start.as_secs_f64()
    }
}

/// A time that goes on while the process is stopped or the machine sleeps.
pub(crate) trait WallClock {
    /// Time since some fixed instant.
    fn now(&self) -> Duration;

    /// Lets `span` pass.
    fn wait(&mut self, span: Duration);
}

/// The machine's, from its making on.
pub(crate) struct SystemClock {
    #[cfg_attr(target_os = "linux", expect(dead_code, reason = "only other systems count from it"))]
    began: Instant,
}

impl WallClock for SystemClock {
    /// The monotonic clock of Linux stands still while the machine is suspended, while modules' clocks go on.
    #[cfg(target_os = "linux")]
    fn now(&self) -> Duration {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
        Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
    }

    #[cfg(not(target_os = "linux"))]
    fn now(&self) -> Duration {
        self.began.elapsed()
    }

    fn wait(&mut self, span: Duration) {
        std::thread::sleep(span);
    }
}

/// One tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tick {
    /// When it is.
    pub(crate) now: FleetInstant,
    /// What was left out before it.
    pub(crate) gap: Option<Gap>,
}

/// See the module's documentation.
pub(crate) struct Clock<W = SystemClock> {
    pace: Pace,
    wall: W,
    /// When tick zero was, by the wall clock.
    began: Duration,
    tick: FleetInstant,
    /// The same, for how long a run takes.
    started: Duration,
}

impl Clock {
    /// At tick zero, now.
    pub(crate) fn new(pace: Pace) -> Self {
        Self::over(pace, SystemClock { began: Instant::now() })
    }
}

impl<W: WallClock> Clock<W> {
    /// At tick zero, now by `wall`.
    pub(super) fn over(pace: Pace, wall: W) -> Self {
        let began = wall.now();
        Self { pace, wall, began, tick: FleetInstant(0), started: began }
    }

    /// How long it has run by the wall clock, s.
    pub(super) fn elapsed_s(&self) -> f64 {
        self.wall.now().saturating_sub(self.started).as_secs_f64()
    }

    /// The next tick; in real time it waits for it.
    pub(crate) fn next_tick(&mut self) -> Tick {
        let last = self.tick;
        self.tick = last.after(TICK);
        if self.pace == Pace::Simulated {
            return Tick { now: self.tick, gap: None };
        }
        let (due, now) = (self.began + Duration::from_micros(self.tick.0), self.wall.now());
        let late = now.saturating_sub(due);
        if late <= LATE_MAX {
            self.wall.wait(due.saturating_sub(now));
            return Tick { now: self.tick, gap: None };
        }
        if self.pace == Pace::Watched {
            // Simulated time stood still with its host.
            self.began += late;
            return Tick { now: self.tick, gap: None };
        }
        let tick_us = u64::from(TICK.0);
        self.tick = FleetInstant(self.now().0 / tick_us * tick_us);
        Tick { now: self.tick, gap: Some(Gap { start: last, end: self.tick }) }
    }

    /// Whether the next tick is still to come: a clock that catches up is at ticks that are past.
    pub(crate) fn is_due(&self, tick: &Tick) -> bool {
        self.now() < tick.now.after(TICK)
    }

    /// The time now: of the tick in a simulation, of the wall clock otherwise.
    pub(super) fn now(&self) -> FleetInstant {
        match self.pace {
            Pace::Simulated | Pace::Watched => self.tick,
            Pace::Real => FleetInstant(self.wall.now().saturating_sub(self.began).as_micros() as u64),
        }
    }
}

/// A wall clock that only waiting and a test move.
#[cfg(test)]
pub(super) struct Fake<'a>(pub(super) &'a std::cell::Cell<Duration>);

#[cfg(test)]
impl WallClock for Fake<'_> {
    fn now(&self) -> Duration {
        self.0.get()
    }

    fn wait(&mut self, span: Duration) {
        self.0.set(self.0.get() + span);
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn pass(time: &Cell<Duration>, milliseconds: u64) {
        time.set(time.get() + Duration::from_millis(milliseconds));
    }

    #[test]
    fn a_short_delay_is_caught_up_with_and_a_long_one_left_out() {
        let time = Cell::new(Duration::from_secs(1000));
        let mut clock = Clock::over(Pace::Real, Fake(&time));
        assert_eq!(clock.next_tick(), Tick { now: FleetInstant(1_000), gap: None });
        pass(&time, 400);
        for number in 2..=500 {
            let tick = clock.next_tick();
            assert_eq!(tick, Tick { now: FleetInstant(number * 1_000), gap: None });
            // It is 401 ms.
            assert_eq!(clock.is_due(&tick), number >= 401, "{number}");
        }
        pass(&time, 15_000);
        let (start, end) = (FleetInstant(500_000), FleetInstant(15_500_000));
        assert_eq!(clock.next_tick(), Tick { now: end, gap: Some(Gap { start, end }) });
        assert_eq!(clock.next_tick(), Tick { now: FleetInstant(15_501_000), gap: None });
        assert_eq!(time.get(), Duration::from_millis(1_015_501));
    }

    /// It is watched, and nothing in it happens by itself.
    #[test]
    fn a_watched_simulation_goes_on_from_where_it_was() {
        let time = Cell::new(Duration::ZERO);
        let mut clock = Clock::over(Pace::Watched, Fake(&time));
        clock.next_tick();
        pass(&time, 60_000);
        assert_eq!(clock.next_tick(), Tick { now: FleetInstant(2_000), gap: None });
        // No faster than before.
        let before = time.get();
        for _ in 0..1000 {
            clock.next_tick();
        }
        assert_eq!(time.get() - before, Duration::from_secs(1));
    }
}
