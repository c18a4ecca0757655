//! The module's schedule: the real one, rebuilt from a state that can be hashed, asked, and read back.
//!
//! A slot of the model is `SLOT` long; a cycle fills its slot. What comes, comes in the middle of a slot.

use firmware::modboat::cycle::SwimCycle;
use firmware::modboat::schedule::{Schedule, Verdict};
use firmware::modboat::waveform::Waveform;
use protocol::Delivery;
use protocol::configuration::TailLimits;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;

use crate::said::{Answer, Held, Pose};

/// Transition and period of every cycle.
const SLOT: (Duration, Duration) = (Duration(500_000), Duration(1_500_000));
const SLOT_US: u64 = 2_000_000;
const AMPLITUDE_RAD: f32 = 1.0;

fn start_of(slot: u8) -> FleetInstant {
    FleetInstant(u64::from(slot) * SLOT_US)
}

fn within(slot: u8) -> FleetInstant {
    start_of(slot).after(Duration(1_000_000))
}

fn cycle(held: &Held) -> SwimCycle {
    let (from_rad, to_rad) = (held.from.angle_rad(), held.to().angle_rad());
    let waveform = Waveform::new(Radians(to_rad - AMPLITUDE_RAD), Radians(AMPLITUDE_RAD), SLOT.1);
    SwimCycle::new(
        u32::from(held.number),
        start_of(held.start),
        Radians(to_rad - from_rad),
        (SLOT.0, protocol::TransitionLaw::ConstantSpeed),
        waveform,
    )
}

/// A cycle before its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Waiting {
    /// Which.
    pub held: Held,
    /// It may begin.
    pub committed: bool,
}

/// What a [`Schedule`] consists of.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Slots {
    /// Where the tail rests while nothing has begun.
    rest: Pose,
    /// What began last.
    pub current: Option<Held>,
    /// What waits.
    pub next: Option<Waiting>,
    /// Greatest number that has begun.
    latest: u8,
    stopped: bool,
}

impl Slots {
    /// Empty, after a boot with the tail at `pose`.
    #[must_use]
    pub fn new(pose: Pose) -> Self {
        Self { rest: pose, ..Self::default() }
    }

    /// What runs in slot `now`.
    #[must_use]
    pub fn running(&self, now: u8) -> Option<&Held> {
        self.current.as_ref().filter(|held| held.start == now)
    }

    /// Whether the number waits, runs or ran last.
    #[must_use]
    pub fn knows(&self, number: u8) -> bool {
        self.all().any(|held| held.number == number)
    }

    /// Whether this very cycle waits, runs or ran last.
    #[must_use]
    pub fn has(&self, id: u8) -> bool {
        self.all().any(|held| held.id == id)
    }

    /// What waits, runs or ran last.
    pub fn all(&self) -> impl Iterator<Item = Held> {
        self.current.into_iter().chain(self.next.map(|next| next.held))
    }

    /// Where the tail is in slot `now`, or somewhere on the way there.
    #[must_use]
    pub fn tail(&self, now: u8) -> Pose {
        match self.current {
            Some(held) if held.start == now => held.to().short_of(),
            _ => self.end(),
        }
    }

    /// Where the tail will rest after all that has begun.
    #[must_use]
    pub fn end(&self) -> Pose {
        self.current.map_or(self.rest, |held| held.to())
    }

    /// Whether it is stopped.
    #[must_use]
    pub const fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// The number that a report names.
    #[must_use]
    pub fn reported(&self) -> u8 {
        self.current.map_or(0, |held| held.number)
    }

    /// [`Schedule::offer`].
    pub fn offer(&mut self, now: u8, held: Held, delivery: Delivery) -> Answer {
        answer(self.with(now, Some(held), |real, now| real.offer(now, cycle(&held), delivery)))
    }

    /// [`Schedule::commit`].
    pub fn commit(&mut self, now: u8, number: u8) -> Answer {
        answer(self.with(now, None, |real, now| real.commit(now, u32::from(number))))
    }

    /// [`Schedule::hold`]: drops what waits.
    pub fn hold(&mut self, now: u8) {
        self.with(now, None, Schedule::hold);
    }

    /// [`Schedule::emergency_stop`].
    pub fn stop(&mut self, now: u8) {
        let tail = self.tail(now);
        self.with(now, None, Schedule::emergency_stop);
        self.rest = tail;
    }

    /// [`Schedule::resume`].
    pub fn resume(&mut self, now: u8) {
        let rest = Radians(self.rest.angle_rad());
        self.with(now, None, |real, _| real.resume(rest));
    }

    /// [`Schedule::for_new_epoch`].
    pub fn reset(&mut self, now: u8) {
        let tail = self.tail(now);
        self.with(now, None, |real, now| *real = real.for_new_epoch(now));
        (self.rest, self.latest) = (tail, 0);
    }

    /// Slot `now` begins, and with it what may.
    pub fn begin(&mut self, now: u8) {
        if self.next.is_some() {
            self.with(now, None, |_, _| ());
        }
    }

    /// The real schedule that this stands for, in the slot of what began last or before `now`.
    fn real(&self, now: u8) -> Schedule {
        let limits = TailLimits::default();
        let before = |held: &Held| FleetInstant(start_of(held.start).0 - 1);
        let Some(current) = self.current else {
            let mut real = Schedule::new(limits, Radians(self.rest.angle_rad()));
            if self.latest > 0 {
                // It ran something, and forgot it when it was stopped.
                let (from, beside, id, boot) = (self.rest, Pose(0), 0, 0);
                let (number, delivery) = (self.latest, Delivery::Direct);
                let former = Held { number, id, start: 0, delivery, from, beside, boot };
                real.offer(FleetInstant(0), cycle(&former), delivery);
                real.emergency_stop(FleetInstant(1));
                real.resume(Radians(self.rest.angle_rad()));
            }
            if self.stopped {
                real.emergency_stop(within(now));
            }
            return real;
        };
        let mut real = Schedule::new(limits, Radians(current.from.angle_rad()));
        real.offer(before(&current), cycle(&current), Delivery::Direct);
        real.hold(start_of(current.start));
        real
    }

    /// Does something to the real schedule, and reads back what that made of it. `offered`: what it may hold then.
    fn with<R>(
        &mut self,
        now: u8,
        offered: Option<Held>,
        act: impl FnOnce(&mut Schedule, FleetInstant) -> R,
    ) -> R {
        let mut real = self.real(now);
        if let Some(Waiting { held, committed }) = self.next {
            // It was taken in the slot before its start.
            real.offer(within(held.start - 1), cycle(&held), held.delivery);
            if committed && held.delivery == Delivery::Prepare {
                real.commit(within(held.start - 1), u32::from(held.number));
            }
        }
        let now_us = within(now);
        let result = act(&mut real, now_us);
        let known = [offered, self.next.map(|next| next.held), self.current];
        let find = |cycle_number: u32, start: Option<FleetInstant>| {
            let fits = |held: &&Held| {
                u32::from(held.number) == cycle_number
                    && start.is_none_or(|start| start_of(held.start) == start)
            };
            known.iter().flatten().find(fits).copied()
        };
        let waiting = real.waiting(now_us);
        let held = waiting.and_then(|waiting| find(waiting.number(), Some(waiting.start())));
        let begun = real.latest(now_us);
        self.next = held.map(|held| Waiting { held, committed: !real.is_uncommitted(now_us) });
        if begun != self.current.map(|held| u32::from(held.number)) {
            self.current = begun.and_then(|number| find(number, None));
        }
        self.latest = self.latest.max(self.reported());
        self.stopped = real.is_stopped();
        result
    }
}

fn answer(verdict: Verdict) -> Answer {
    match verdict {
        Verdict::Accepted | Verdict::Duplicate => Answer::Taken,
        Verdict::Prepared => Answer::Prepared,
        Verdict::Refused(_) => Answer::Refused,
    }
}
