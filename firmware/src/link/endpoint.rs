//! The module's end of the link: learns the fleet time, takes cycles, acknowledges, reports, and stops.
//!
//! Sans-IO: datagrams, measurements and the time on the module's own clock go in; datagrams come out of
//! [`Endpoint::poll_transmit`]. Who may speak to it decides the [`Link`], what it may do the [`Failsafe`], what a cycle
//! means the kind of [`Robot`]: [`ModboatRobot`](crate::modboat::robot::ModboatRobot) for a Modboat,
//! [`ThrustLease`](crate::rov::lease::ThrustLease) for an ROV.
//!
//! | what | when |
//! |---|---|
//! | announcement | every [`HELLO_EVERY`] while no host is heard, else every second |
//! | clock exchange | as often as the clock wants it |
//! | telemetry | every [`Identity::report_every`] |
//! | health | every second; every [`HELLO_EVERY`] while the fleet time is not sure, or no cycle has begun a second after it was: the host may not know |
//! | acknowledgement | for every cycle and commit that arrives |
//!
//! All of it is posted by [`Endpoint::poll_transmit`], in the turn of what is sent and not of the tick.
//!
//! A cycle that would start while fleet time is not known well enough is not started: it is dropped [`GATE`] before, and
//! the module holds. How sure the fleet time is takes a root and products of 64 bits, so that too is asked in the turn of what is sent.

use heapless::Deque;
use protocol::ledger::Class;
use protocol::session::Opened;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::{
    Acknowledge, Cycle, Health, Hello, Message, ModuleState, Refusal, TimeReply, TimeRequest, Verdict,
};

use crate::link::clock::{Exchange, FleetClock};
use crate::link::failsafe::{Conditions, Failsafe, FailsafeEvent};
pub use crate::link::robot::{Present, Robot};
use crate::link::session::{Host, Identity, Link};
use crate::modboat::schedule::HORIZON;

/// Pause between two announcements while no host is heard.
pub const HELLO_EVERY: Duration = Duration(200_000);

/// Pause between two announcements, and two reports of health, from then on.
pub const KEEP_EVERY: Duration = Duration(1_000_000);

/// Time before the start of a cycle at which it is decided whether the cycle may start.
pub const GATE: Duration = Duration(5_000);

/// Messages that wait to be sent, at most; the oldest gives way.
const OUTBOX: usize = 8;

/// A datagram that waits to be sent; it is sealed when it is sent.
#[derive(Clone, Debug)]
enum QueuedDatagram {
    Announcement,
    Message(Message),
}

/// Numbers of the newest commands of the session, so that one that was overtaken undoes nothing newer.
#[derive(Clone, Copy, Debug, Default)]
struct Newest {
    /// It made the cycle wait that waits, or let it run.
    cycle: Option<u32>,
    /// A hold, a stop or its release: what was sent before it is not wanted any more.
    drop: Option<u32>,
    stop: Option<u32>,
    release: Option<u32>,
    /// A release was sent too early that had not seen so many datagrams of this side: it knew nothing of the last stop that was not its host's.
    stopped_at: u32,
}

/// The module's end of the link, for one kind of [`Robot`].
#[derive(Clone, Debug)]
pub struct Endpoint<R> {
    link: Option<Link>,
    robot: R,
    clock: FleetClock,
    failsafe: Failsafe,
    low_battery: bool,
    newest: Newest,
    /// Greatest number that was refused, and why. A refusal is final: the host tells others what it means.
    refused: Option<(u32, Refusal)>,
    outbox: Deque<QueuedDatagram, OUTBOX>,
    /// The last tick, until what was due then is posted.
    ticked: Option<LocalInstant>,
    next_hello: LocalInstant,
    next_exchange: LocalInstant,
    next_report: LocalInstant,
    next_health: LocalInstant,
    /// The last health said that the fleet time is sure.
    said_sure: bool,
}

impl<R: Robot> Endpoint<R> {
    /// The endpoint of a robot that has just booted. Without an identity it has no valid configuration: it moves nothing
    /// and says nothing.
    #[must_use]
    pub fn new(identity: Option<Identity>, robot: R) -> Self {
        Self {
            link: identity.map(Link::new),
            robot,
            clock: FleetClock::new(),
            failsafe: Failsafe::new(),
            low_battery: false,
            newest: Newest::default(),
            refused: None,
            outbox: Deque::new(),
            ticked: None,
            next_hello: LocalInstant(0),
            next_exchange: LocalInstant(0),
            next_report: LocalInstant(0),
            next_health: LocalInstant(0),
            said_sure: false,
        }
    }

    /// Follows one datagram that arrived at `now`, own clock.
    ///
    /// # Errors
    /// What it is, if it is not to be followed; it is counted and nothing happens.
    pub fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class> {
        let busy = self.robot.running(self.fleet(now)).is_some();
        let Some(link) = &mut self.link else { return Err(Class::Foreign) };
        let heard = link.open(now, datagram, busy)?;
        if heard.host == Host::Outside {
            self.stop(now, FailsafeEvent::EmergencyStop);
            self.settle(now);
            return Ok(());
        }
        if heard.host != Host::Same {
            self.newest = Newest::default();
            self.next_exchange = now;
            self.next_health = now;
        }
        if heard.host == Host::Another {
            // The host was restarted: its fleet time and its cycle numbers are new.
            let fleet = self.fleet(now);
            self.robot.start_new_epoch(fleet);
            self.refused = None;
            self.clock.reset();
            self.failsafe.handle(FailsafeEvent::HostChanged);
        }
        self.follow(now, &heard.opened);
        self.settle(now);
        Ok(())
    }

    fn follow(&mut self, now: LocalInstant, opened: &Opened) {
        let &Opened { ref message, sequence, seen, .. } = opened;
        let fleet = self.fleet(now);
        match message {
            Message::TimeReply(reply) => self.take_time(now, reply),
            // Called off already.
            Message::Cycle(_) | Message::Commit(_) if self.newest.drop > Some(sequence) => self.came_late(),
            Message::Cycle(cycle) => {
                let verdict = self.take_cycle(now, cycle);
                self.answer(cycle.number, verdict, sequence);
            }
            Message::Commit(cycle) => {
                let verdict = self.robot.commit(fleet, *cycle);
                self.answer(*cycle, verdict, sequence);
            }
            Message::Hold => {
                self.newest.drop = self.newest.drop.max(Some(sequence));
                // It would drop a cycle that was sent after it.
                if self.newest.cycle > Some(sequence) { self.came_late() } else { self.robot.hold(fleet) }
            }
            Message::EmergencyStop => {
                self.newest.drop = self.newest.drop.max(Some(sequence));
                self.newest.stop = self.newest.stop.max(Some(sequence));
                if self.newest.release > Some(sequence) {
                    self.came_late();
                } else {
                    // Its own release is told from an older one by its number.
                    self.stop_for(now, FailsafeEvent::EmergencyStop);
                }
            }
            // Sent before the last stop, its own or another's.
            Message::Release if self.newest.stop > Some(sequence) || seen < self.newest.stopped_at => {
                self.came_late();
            }
            Message::Release => {
                self.newest.drop = self.newest.drop.max(Some(sequence));
                self.newest.release = self.newest.release.max(Some(sequence));
                if self.failsafe.state() == ModuleState::Stopped {
                    self.robot.release();
                    self.failsafe.handle(FailsafeEvent::Released);
                }
            }
            // What modules say is not for modules; the call has said what it has to by being let in.
            Message::Called
            | Message::Hello(_)
            | Message::TimeRequest(_)
            | Message::Acknowledge(_)
            | Message::Telemetry(_)
            | Message::RovTelemetry(_)
            | Message::TailUnknown(_)
            | Message::Health(_) => {}
        }
    }

    /// Stops at once, for a reason that its host does not know of: the module's own, or another host's word.
    pub(crate) fn stop(&mut self, now: LocalInstant, reason: FailsafeEvent) {
        if self.stop_for(now, reason) {
            // Only a host that has seen a report of it can mean it by a release.
            self.newest.stopped_at = self.link.as_ref().map_or(0, Link::sent).saturating_add(1);
        }
    }

    /// Stops at once. Whether that says something new.
    fn stop_for(&mut self, now: LocalInstant, reason: FailsafeEvent) -> bool {
        let fleet = self.fleet(now);
        let before = self.failsafe.faults();
        self.failsafe.handle(reason);
        let new = self.failsafe.faults() != before;
        if self.failsafe.state() == ModuleState::Stopped {
            self.robot.emergency_stop(fleet);
        }
        if new {
            self.next_report = now;
        }
        new
    }

    /// Takes in what was measured at `now`, own clock, and what that and the time change.
    pub fn handle_timer(&mut self, now: LocalInstant, measurement: &R::Measurement) {
        self.robot.observe(measurement);
        self.settle(now);
        self.ticked = Some(now);
    }

    /// Queues what is due at `now`, own clock.
    fn post(&mut self, now: LocalInstant) {
        let Some(link) = self.link.as_ref().filter(|_| self.failsafe.announces()) else { return };
        let (hears_host, is_open, sure_within) =
            (link.hears_host(now), link.is_open(), link.identity().sure_within);
        let (incoming, report_every) = (*link.incoming(), link.identity().report_every);
        if now >= self.next_hello {
            self.next_hello = now.after(if hears_host { KEEP_EVERY } else { HELLO_EVERY });
            self.enqueue(QueuedDatagram::Announcement);
        }
        if !is_open {
            return;
        }
        if now >= self.next_exchange {
            self.next_exchange = now.after(self.clock.exchange_pause(now, sure_within));
            self.enqueue(QueuedDatagram::Message(Message::TimeRequest(TimeRequest { sent: now })));
        }
        if now >= self.next_report {
            let at = self.fleet(now);
            let (state, faults) = (self.failsafe.state(), self.failsafe.faults());
            let present = Present { at, state, cycle: self.robot.latest(at).unwrap_or(0), faults };
            if let Some(report) = self.robot.report(&present) {
                self.next_report = now.after(report_every);
                self.enqueue(QueuedDatagram::Message(report));
            }
        }
        if now >= self.next_health {
            let sure = self.clock.is_sure(now, sure_within);
            let knows = !self.said_sure || self.robot.latest(self.fleet(now)).is_some();
            self.said_sure = sure;
            self.next_health = now.after(if sure && knows { KEEP_EVERY } else { HELLO_EVERY });
            let uncertainty = self.clock.uncertainty(now).unwrap_or(Duration(u32::MAX));
            let health = Health { incoming, uncertainty, drift_ppb: self.clock.drift_ppb() };
            self.enqueue(QueuedDatagram::Message(Message::Health(health)));
        }
    }

    /// Does what was due at the last tick and is not of the tick: drops a cycle that may not start, queues what is to be sent. Then writes the
    /// next datagram to the start of `buffer` (of [`protocol::MAX_DATAGRAM`] bytes) and returns that part.
    pub fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        if let Some(ticked) = self.ticked {
            self.gate(ticked);
            // What waits goes first, and has its place.
            if self.outbox.is_empty() {
                self.ticked = None;
                self.post(ticked);
            }
        }
        let link = self.link.as_mut()?;
        match self.outbox.pop_front()? {
            QueuedDatagram::Announcement => {
                let hello = Hello { kind: R::KIND, firmware: VERSION, session: link.session() };
                link.seal_announcement(&hello, buffer)
            }
            QueuedDatagram::Message(message) => link.seal(&message, buffer),
        }
    }

    /// What the module is doing at `now`, own clock.
    #[must_use]
    pub fn state(&self, now: LocalInstant) -> ModuleState {
        let mut failsafe = self.failsafe.clone();
        failsafe.follow(&self.conditions(now));
        failsafe.state()
    }

    /// Number of the cycle that it runs at `now`, own clock, if any.
    #[must_use]
    pub fn running(&self, now: LocalInstant) -> Option<u32> {
        self.robot.running(self.fleet(now))
    }

    /// What it may do, as of the last tick or datagram.
    #[must_use]
    pub const fn failsafe(&self) -> &Failsafe {
        &self.failsafe
    }

    /// What the board knows of its battery, as of now.
    pub(crate) const fn set_low_battery(&mut self, low: bool) {
        self.low_battery = low;
    }

    /// What depends on the kind of robot.
    #[must_use]
    pub const fn robot(&self) -> &R {
        &self.robot
    }

    /// Its way in and out; nothing without a valid configuration.
    #[must_use]
    pub const fn link(&self) -> Option<&Link> {
        self.link.as_ref()
    }

    /// The fleet time as this module knows it.
    #[must_use]
    pub const fn clock(&self) -> &FleetClock {
        &self.clock
    }

    /// Its own clock may have jumped by so much at `now`: it is less sure of the fleet time.
    pub fn disturbed(&mut self, now: LocalInstant, by: Duration) {
        self.clock.disturbed(now, by);
        self.next_exchange = now;
    }

    /// Fleet time at `now`, own clock, or the beginning of time: with nothing scheduled every time is the same.
    pub(crate) fn fleet(&self, now: LocalInstant) -> FleetInstant {
        self.clock.fleet(now).unwrap_or(FleetInstant(0))
    }

    fn conditions(&self, now: LocalInstant) -> Conditions {
        Conditions {
            configured: self.link.is_some(),
            located: self.robot.is_located(),
            clock_known: self.clock.is_synchronised(),
            armed: self.robot.is_ready(),
            running: self.robot.running(self.fleet(now)).is_some(),
            low_battery: self.low_battery,
        }
    }

    fn settle(&mut self, now: LocalInstant) {
        let conditions = self.conditions(now);
        if self.failsafe.follow(&conditions) == Some(ModuleState::Unsynchronised) {
            // The starts of what waits mean nothing now.
            let fleet = self.fleet(now);
            self.robot.hold(fleet);
        }
    }

    /// Drops a cycle that is about to start while fleet time is not known well enough, as of the tick at `now`.
    fn gate(&mut self, now: LocalInstant) {
        self.gate_at(self.fleet(now), now);
    }

    /// The same of what waits at `before`, fleet time.
    fn gate_at(&mut self, before: FleetInstant, now: LocalInstant) {
        let Some(sure_within) = self.link.as_ref().map(|link| link.identity().sure_within) else { return };
        let latest = self.fleet(now).max(before).after(GATE);
        let due = self.robot.waiting(before).is_some_and(|start| start <= latest);
        if due && !self.clock.is_sure(now, sure_within) {
            self.robot.hold(before);
        }
    }

    fn enqueue(&mut self, queued: QueuedDatagram) {
        if self.outbox.is_full() {
            self.outbox.pop_front();
        }
        // There is room now, so nothing comes back.
        let _ = self.outbox.push_back(queued);
    }

    /// Acknowledges a cycle or its commit that came with `sequence`.
    fn answer(&mut self, cycle: u32, verdict: Verdict, sequence: u32) {
        if let Verdict::Refused(refusal) = verdict {
            self.refused = self.refused.filter(|(former, _)| *former >= cycle).or(Some((cycle, refusal)));
            if refusal == Refusal::Late {
                self.came_late();
            }
        } else {
            self.newest.cycle = self.newest.cycle.max(Some(sequence));
        }
        self.enqueue(QueuedDatagram::Message(Message::Acknowledge(Acknowledge { cycle, verdict })));
    }

    fn came_late(&mut self) {
        if let Some(link) = &mut self.link {
            link.came_late();
        }
    }

    fn take_time(&mut self, now: LocalInstant, reply: &TimeReply) {
        let busy = self.robot.running(self.fleet(now)).is_some();
        let exchange = Exchange {
            request_sent: reply.request_sent,
            request_received: reply.received,
            reply_sent: reply.sent,
            reply_received: now,
        };
        let before = self.fleet(now);
        self.clock.add(&exchange, busy);
        // Fleet time may have stepped past the start of what waits.
        self.gate_at(before, now);
    }

    fn take_cycle(&mut self, now: LocalInstant, cycle: &Cycle) -> Verdict {
        let fleet = self.fleet(now);
        // What was answered stays true, whatever has changed since.
        if self.robot.knows(cycle.number) {
            return self.robot.offer(fleet, cycle);
        }
        if let Some((_, refusal)) = self.refused.filter(|(number, _)| cycle.number <= *number) {
            return Verdict::Refused(refusal);
        }
        if let Err(refusal) = self.failsafe.takes_cycles() {
            return Verdict::Refused(refusal);
        }
        let sure_within = self.link.as_ref().map_or(Duration(0), |link| link.identity().sure_within);
        let Some(fleet) = self.clock.fleet(now).filter(|_| self.clock.is_synchronised()) else {
            return Verdict::Refused(Refusal::NotSynchronised);
        };
        // Beyond the horizon the uncertainty does not matter.
        if cycle.start > fleet.after(HORIZON) {
            return Verdict::Refused(Refusal::TooFarAhead);
        }
        // How sure it will be then, if no other answer comes until then.
        let at_start = now.after(cycle.start.since(fleet));
        if !self.clock.is_sure(at_start, sure_within) {
            return Verdict::Refused(Refusal::Unsure);
        }
        self.robot.offer(fleet, cycle)
    }
}

/// Version of this crate, as said in the hello.
const VERSION: (u8, u8, u8) = (0, 2, 0);

#[cfg(test)]
mod tests;
