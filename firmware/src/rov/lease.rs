//! The [`Robot`] of an ROV: thrusts on a lease.
//!
//! ```text
//!      start                    start + lease
//!        │  thrusts of this cycle  │  neutral
//!        └──────── until a cycle of a greater number begins ────────→
//! ```
//!
//! Of the cycles whose start has come the one with the greatest number is executed, for as long as its lease lasts;
//! then neutral, whatever came before it. A host that speaks twenty times a second gives each cycle a lease of a few of its periods:
//! lost datagrams are ridden through, a lost link is neutral thrust.
//!
//! | what comes | what happens |
//! |---|---|
//! | a cycle again, while it is held | duplicate |
//! | a cycle whose start has passed, its lease not | executed at once |
//! | a cycle of a greater number that begins no later than one that waits | that one is dropped |
//! | hold | everything is dropped: neutral. Numbers go on growing |
//! | a cycle that is only to be prepared | refused: every packet of thrusts stands for itself |
//! | emergency stop | neutral until released |
//!
//! Docking connectors are on the same lease: they are open as long as a cycle that says so is executed, and closed otherwise.
//!
//! While the controllers arm, cycles are accepted and nothing is put out; the state says so.
//!
//! Assumptions and limits: at most [`WAITING`] cycles wait for their start. Thrusts are along each thruster's axis; how much
//! of them the battery allows is decided at the output.

use heapless::Vec;
use protocol::configuration::LeaseLimits;
use protocol::message::MAX_THRUSTERS;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::{Amperes, Newtons, PulseMicros, Volts};
use protocol::{
    Connectors, Cycle, Delivery, Message, ModuleKind, Motion, Refusal, RovCycle, RovTelemetry, Verdict,
};

use crate::link::endpoint::{Endpoint, Present, Robot};
use crate::modboat::schedule::HORIZON;

/// Cycles that may wait for their start.
pub const WAITING: usize = 4;

/// No cycle is taken while fleet time may be off by more: thrusts of two modules need not begin together, and a
/// board that ticks two hundred times a second does not see an exchange closer than 5 ms. *Assumed.*
pub const SURE_WITHIN: Duration = Duration(20_000);

/// What an ROV measures and puts out, for its reports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Output {
    /// Pulses that are put out, in the order of the thrusters.
    pub pulses: Vec<PulseMicros, MAX_THRUSTERS>,
    /// Battery voltage.
    pub battery: Volts,
    /// Battery current.
    pub current: Amperes,
    /// The speed controllers obey by now.
    pub armed: bool,
}

/// A cycle that is kept.
#[derive(Clone, Debug, PartialEq)]
struct Leased {
    number: u32,
    start: FleetInstant,
    cycle: RovCycle,
}

impl Leased {
    fn end(&self) -> FleetInstant {
        self.start.after(self.cycle.lease)
    }
}

/// The [`Robot`] of an ROV: the thrusts in force and those that wait.
#[derive(Clone, Debug)]
pub struct ThrustLease {
    /// How many thrusts a cycle has, exactly.
    thrusters: usize,
    limits: LeaseLimits,
    /// The cycle that began last; it stays after its lease to recognise duplicates.
    current: Option<Leased>,
    /// Numbers and starts both grow.
    waiting: Vec<Leased, WAITING>,
    latest: Option<u32>,
    stopped: bool,
    output: Output,
}

impl ThrustLease {
    /// Of so many thrusters, with no cycle: neutral.
    #[must_use]
    pub const fn new(thrusters: usize, limits: LeaseLimits) -> Self {
        Self {
            thrusters,
            limits,
            current: None,
            waiting: Vec::new(),
            latest: None,
            stopped: false,
            output: Output {
                pulses: Vec::new(),
                battery: Volts(f32::NAN),
                current: Amperes(0.0),
                armed: false,
            },
        }
    }

    /// Thrusts to put out at `now` (fleet time); none at all is neutral.
    #[must_use]
    pub fn thrusts(&self, now: FleetInstant) -> &[Newtons] {
        self.executed(now).map_or(&[], |leased| &leased.cycle.thrusts)
    }

    /// What the connectors do at `now` (fleet time). They open for as long as a lease says so: without one a docked robot stays docked.
    #[must_use]
    pub fn connectors(&self, now: FleetInstant) -> Connectors {
        self.executed(now).map_or(Connectors::Closed, |leased| leased.cycle.connectors)
    }

    /// True for a cycle within the limits. NaN is within nothing.
    fn allows(&self, cycle: &RovCycle) -> bool {
        let LeaseLimits { thrust_max, lease_max } = self.limits;
        cycle.thrusts.len() == self.thrusters
            && cycle.thrusts.iter().all(|thrust| libm::fabsf(thrust.0) <= thrust_max.0)
            && cycle.lease.0 > 0
            && cycle.lease <= lease_max
    }

    /// The cycle that began last by `now`, whether its lease still lasts or not.
    fn begun(&self, now: FleetInstant) -> Option<&Leased> {
        self.waiting.iter().rev().find(|leased| leased.start <= now).or(self.current.as_ref())
    }

    /// The cycle that is executed at `now`.
    fn executed(&self, now: FleetInstant) -> Option<&Leased> {
        // Should the clock step back to before its start, that is not its lease any more.
        self.begun(now).filter(|leased| leased.start <= now && now < leased.end())
    }

    /// Moves what has begun by `now` out of the queue.
    fn settle(&mut self, now: FleetInstant) {
        while self.waiting.first().is_some_and(|leased| leased.start <= now) {
            let begun = self.waiting.remove(0);
            self.latest = Some(begun.number);
            self.current = Some(begun);
        }
    }

    /// The checks on a cycle that is not held, and its place in the queue.
    fn admit(&mut self, now: FleetInstant, offered: Leased) -> Result<(), Refusal> {
        if self.latest.is_some_and(|latest| offered.number <= latest) {
            return Err(Refusal::AlreadyRun);
        }
        if !self.allows(&offered.cycle) {
            return Err(Refusal::BeyondLimits);
        }
        if offered.end() <= now {
            return Err(Refusal::Late);
        }
        if offered.start > now.after(HORIZON) {
            return Err(Refusal::TooFarAhead);
        }
        // It would never run: one of a greater number begins no later.
        if self.waiting.iter().any(|held| held.number > offered.number && held.start <= offered.start) {
            return Err(Refusal::Conflict);
        }
        let superseded = |held: &Leased| held.number < offered.number && held.start >= offered.start;
        if self.waiting.is_full() && !self.waiting.iter().any(superseded) {
            return Err(Refusal::Conflict);
        }
        self.waiting.retain(|held| !superseded(held));
        let place = self.waiting.iter().take_while(|held| held.number < offered.number).count();
        // There is room, and the place is within the queue.
        self.waiting.insert(place, offered).map_err(|_| Refusal::Conflict)
    }
}

impl Endpoint<ThrustLease> {
    /// Thrusts to put out at `now`, own clock; none at all is neutral.
    #[must_use]
    pub fn thrusts(&self, now: LocalInstant) -> &[Newtons] {
        self.robot().thrusts(self.fleet(now))
    }

    /// What the connectors do at `now`, own clock.
    #[must_use]
    pub fn connectors(&self, now: LocalInstant) -> Connectors {
        self.robot().connectors(self.fleet(now))
    }
}

impl Robot for ThrustLease {
    const KIND: ModuleKind = ModuleKind::Rov;
    type Measurement = Output;

    fn observe(&mut self, output: &Output) {
        self.output.clone_from(output);
    }

    fn is_ready(&self) -> bool {
        self.output.armed
    }

    fn knows(&self, cycle: u32) -> bool {
        self.current.iter().chain(&self.waiting).any(|held| held.number == cycle)
    }

    fn offer(&mut self, now: FleetInstant, cycle: &Cycle) -> Verdict {
        let (Motion::Rov(motion), Delivery::Direct) = (&cycle.motion, cycle.delivery) else {
            return Verdict::Refused(Refusal::WrongKind);
        };
        self.settle(now);
        if self.stopped {
            return Verdict::Refused(Refusal::Stopped);
        }
        let offered = Leased { number: cycle.number, start: cycle.start, cycle: motion.clone() };
        let mut held = self.current.iter().chain(&self.waiting);
        if let Some(held) = held.find(|held| held.number == offered.number) {
            return if *held == offered { Verdict::Duplicate } else { Verdict::Refused(Refusal::Conflict) };
        }
        let admitted = self.admit(now, offered);
        self.settle(now);
        admitted.map_or_else(Verdict::Refused, |()| Verdict::Accepted)
    }

    fn hold(&mut self, now: FleetInstant) {
        self.settle(now);
        self.current = None;
        self.waiting.clear();
    }

    fn emergency_stop(&mut self, now: FleetInstant) {
        self.hold(now);
        self.stopped = true;
    }

    fn release(&mut self) {
        self.stopped = false;
    }

    fn commit(&mut self, _now: FleetInstant, _cycle: u32) -> Verdict {
        Verdict::Refused(Refusal::NotPrepared)
    }

    /// Thrusts are on a lease: a start that is off by some milliseconds does no harm.
    fn waiting(&self, _now: FleetInstant) -> Option<FleetInstant> {
        None
    }

    fn running(&self, now: FleetInstant) -> Option<u32> {
        self.executed(now).map(|leased| leased.number)
    }

    fn latest(&self, now: FleetInstant) -> Option<u32> {
        self.begun(now).map(|leased| leased.number).or(self.latest)
    }

    fn start_new_epoch(&mut self, _now: FleetInstant) {
        let output = core::mem::take(&mut self.output);
        *self = Self { stopped: self.stopped, output, ..Self::new(self.thrusters, self.limits) };
    }

    fn report(&self, present: &Present) -> Option<Message> {
        let &Present { at, state, cycle, faults } = present;
        let &Output { ref pulses, battery, current, .. } = &self.output;
        let pulses = pulses.clone();
        Some(Message::RovTelemetry(RovTelemetry { at, state, cycle, pulses, battery, current, faults }))
    }
}

#[cfg(test)]
mod tests;
