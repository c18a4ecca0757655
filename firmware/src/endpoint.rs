//! The module's side of the link: announces itself, learns the fleet time, takes cycles, acknowledges, reports.
//!
//! Sans-IO: datagrams, measurements and the time on the module's own clock go in; datagrams come out of
//! [`Endpoint::poll_transmit`]. What a cycle means depends on the kind of robot and is the business of its [`Robot`]:
//! [`Swimmer`](crate::swimmer::Swimmer) for a Modboat, [`ThrustLease`](crate::lease::ThrustLease) for an ROV.
//!
//! | what | when |
//! |---|---|
//! | hello | every [`HELLO_EVERY`] until the host is heard, then every second |
//! | clock exchange | every [`EXCHANGE_EVERY`] until synchronised, then every second |
//! | telemetry | every [`Identity::report_every`] |
//! | acknowledgement | for every cycle that arrives |
//!
//! Assumptions and limits: nothing is authenticated yet; the checksum guards against damage only. A host that
//! starts anew (another session) brings a new epoch of fleet time; it is heard once the running cycle is over.

use heapless::Deque;
use protocol::units::{Micros, MicrosSpan};
use protocol::{
    Acknowledge, Cycle, DecodeError, Header, Hello, Message, ModuleId, ModuleKind, ModuleState, Refusal,
    TimeReply, TimeRequest, Verdict, decode, encode,
};

use crate::clock::{Exchange, FleetClock};

/// Pause between two hellos until the host is heard.
pub const HELLO_EVERY: MicrosSpan = MicrosSpan(200_000);

/// Pause between two clock exchanges until synchronised.
pub const EXCHANGE_EVERY: MicrosSpan = MicrosSpan(50_000);

/// Pause between two hellos, and two clock exchanges, from then on.
pub const KEEP_EVERY: MicrosSpan = MicrosSpan(1_000_000);

/// Messages that wait to be sent, at most; the oldest gives way.
const OUTBOX: usize = 8;

/// Who a module is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Its number in the fleet.
    pub module: ModuleId,
    /// Drawn at boot, different from life to life.
    pub session: u32,
    /// Pause between two reports.
    pub report_every: MicrosSpan,
}

/// What every report begins with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Present {
    /// Fleet time (0 while unsynchronised).
    pub at: Micros,
    /// What the module is doing.
    pub state: ModuleState,
    /// The cycle that runs, or ran last; 0 before the first.
    pub cycle: u32,
}

/// What depends on the kind of robot: what a cycle means, and what is reported. Times are fleet time; before that is
/// known nothing is offered, and every time is zero.
pub trait Robot {
    /// Said in the hello.
    const KIND: ModuleKind;

    /// What the robot measures for its reports.
    type Measurement;

    /// Takes in what was measured, before anything else that happens at that time.
    fn observe(&mut self, _measurement: &Self::Measurement) {}

    /// False while it cannot do yet what a cycle asks.
    fn is_ready(&self) -> bool {
        true
    }

    /// Takes a cycle, or says why not. Idempotent.
    fn offer(&mut self, now: Micros, cycle: &Cycle) -> Verdict;

    /// Drops what has not begun and goes over to holding.
    fn hold(&mut self, now: Micros);

    /// Stops at once, for good.
    fn emergency_stop(&mut self, now: Micros);

    /// True from an emergency stop on.
    fn is_stopped(&self) -> bool;

    /// Number of the cycle that is being run at `now`, if any.
    fn running(&self, now: Micros) -> Option<u32>;

    /// Number of the cycle that began last by `now`, whether it still runs or not.
    fn latest(&self, now: Micros) -> Option<u32>;

    /// Forgets every cycle, for another epoch of fleet time. A stop in force stays in force.
    fn begin_anew(&mut self, now: Micros);

    /// The report that is due; nothing while there is nothing to report.
    fn report(&self, present: &Present, measurement: &Self::Measurement) -> Option<Message>;
}

/// Datagrams that were not followed, by reason. Saturating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ignored {
    /// Did not decode.
    pub damaged: u32,
    /// For another module.
    pub foreign: u32,
    /// From a new host while a cycle of the old one runs.
    pub early: u32,
    /// From a former host, or a hold that something newer has overtaken.
    pub stale: u32,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Endpoint<R> {
    identity: Identity,
    robot: R,
    clock: FleetClock,
    host: Option<u32>,
    former_host: Option<u32>,
    /// Greatest sequence number of this host.
    newest: Option<u32>,
    outbox: Deque<Message, OUTBOX>,
    sequence: u32,
    next_hello: Micros,
    next_exchange: Micros,
    next_report: Micros,
    ignored: Ignored,
}

impl<R: Robot> Endpoint<R> {
    /// The endpoint of a robot that has just booted.
    #[must_use]
    pub const fn new(identity: Identity, robot: R) -> Self {
        Self {
            identity,
            robot,
            clock: FleetClock::new(),
            host: None,
            former_host: None,
            newest: None,
            outbox: Deque::new(),
            sequence: 0,
            next_hello: Micros(0),
            next_exchange: Micros(0),
            next_report: Micros(0),
            ignored: Ignored { damaged: 0, foreign: 0, early: 0, stale: 0 },
        }
    }

    /// Follows one datagram that arrived at `now`, own clock.
    ///
    /// # Errors
    /// [`DecodeError`] if it is none; it is counted and nothing happens.
    pub fn handle_datagram(&mut self, now: Micros, datagram: &[u8]) -> Result<(), DecodeError> {
        let (header, message) = decode(datagram).inspect_err(|_| {
            self.ignored.damaged = self.ignored.damaged.saturating_add(1);
        })?;
        if header.module != self.identity.module {
            self.ignored.foreign = self.ignored.foreign.saturating_add(1);
            return Ok(());
        }
        if self.former_host == Some(header.session) {
            self.ignored.stale = self.ignored.stale.saturating_add(1);
            return Ok(());
        }
        if self.host != Some(header.session) && !self.take_host(now, header.session) {
            self.ignored.early = self.ignored.early.saturating_add(1);
            return Ok(());
        }
        let overtaken = self.newest.is_some_and(|newest| header.sequence <= newest);
        self.newest = self.newest.max(Some(header.sequence));
        match message {
            Message::TimeReply(reply) => self.take_time(now, &reply),
            Message::Cycle(cycle) => {
                let verdict = self.take_cycle(now, &cycle);
                self.post(Message::Acknowledge(Acknowledge { cycle: cycle.number, verdict }));
            }
            // It would drop a cycle that was sent after it.
            Message::Hold if overtaken => self.ignored.stale = self.ignored.stale.saturating_add(1),
            Message::Hold => {
                let fleet = self.fleet(now);
                self.robot.hold(fleet);
            }
            Message::EmergencyStop => {
                let fleet = self.fleet(now);
                self.robot.emergency_stop(fleet);
            }
            // What modules say is not for modules.
            Message::Hello(_)
            | Message::TimeRequest(_)
            | Message::Acknowledge(_)
            | Message::Telemetry(_)
            | Message::RovTelemetry(_) => {}
        }
        Ok(())
    }

    /// Posts what is due at `now`, own clock.
    pub fn handle_timer(&mut self, now: Micros, measurement: &R::Measurement) {
        self.robot.observe(measurement);
        if now >= self.next_hello {
            self.next_hello = now.after(if self.host.is_some() { KEEP_EVERY } else { HELLO_EVERY });
            self.post(Message::Hello(Hello { kind: R::KIND, firmware: VERSION }));
        }
        if now >= self.next_exchange {
            self.next_exchange =
                now.after(if self.clock.is_synchronised() { KEEP_EVERY } else { EXCHANGE_EVERY });
            self.post(Message::TimeRequest(TimeRequest { sent: now }));
        }
        if now >= self.next_report {
            let at = self.fleet(now);
            let present = Present { at, state: self.state(now), cycle: self.robot.latest(at).unwrap_or(0) };
            if let Some(report) = self.robot.report(&present, measurement) {
                self.next_report = now.after(self.identity.report_every);
                self.post(report);
            }
        }
    }

    /// Writes the next datagram to the start of `buffer` (of [`protocol::MAX_DATAGRAM`] bytes) and returns that part.
    pub fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        let message = self.outbox.pop_front()?;
        let Identity { module, session, .. } = self.identity;
        let header = Header { module, session, sequence: self.sequence };
        self.sequence = self.sequence.wrapping_add(1);
        encode(&header, &message, buffer).ok()
    }

    /// What the module is doing at `now`, own clock.
    #[must_use]
    pub fn state(&self, now: Micros) -> ModuleState {
        let fleet = self.fleet(now);
        if self.robot.is_stopped() {
            ModuleState::Stopped
        } else if !self.clock.is_synchronised() {
            ModuleState::Unsynchronised
        } else if !self.robot.is_ready() {
            ModuleState::Arming
        } else if self.robot.running(fleet).is_some() {
            ModuleState::Executing
        } else if self.robot.latest(fleet).is_some() {
            ModuleState::Holding
        } else {
            ModuleState::Ready
        }
    }

    /// What depends on the kind of robot.
    #[must_use]
    pub const fn robot(&self) -> &R {
        &self.robot
    }

    /// Who it is.
    #[must_use]
    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The fleet time as this module knows it.
    #[must_use]
    pub const fn clock(&self) -> &FleetClock {
        &self.clock
    }

    /// What it did not follow.
    #[must_use]
    pub const fn ignored(&self) -> Ignored {
        self.ignored
    }

    /// Fleet time at `now`, own clock, or the beginning of time: with nothing scheduled every time is the same.
    pub(crate) fn fleet(&self, now: Micros) -> Micros {
        self.clock.fleet(now).unwrap_or(Micros(0))
    }

    fn post(&mut self, message: Message) {
        if self.outbox.is_full() {
            self.outbox.pop_front();
        }
        // There is room now, so nothing comes back.
        let _ = self.outbox.push_back(message);
    }

    /// A host with another session is another life of it: its time and its cycle numbers begin anew. False while a
    /// cycle of the one before still runs.
    fn take_host(&mut self, now: Micros, session: u32) -> bool {
        let fleet = self.fleet(now);
        if self.host.is_some() {
            if self.robot.running(fleet).is_some() {
                return false;
            }
            self.clock.reset();
            self.robot.begin_anew(fleet);
            self.next_exchange = now;
        }
        self.former_host = self.host.replace(session);
        self.newest = None;
        true
    }

    fn take_time(&mut self, now: Micros, reply: &TimeReply) {
        self.clock.add(&Exchange {
            request_sent: reply.request_sent,
            request_received: reply.received,
            reply_sent: reply.sent,
            reply_received: now,
        });
    }

    fn take_cycle(&mut self, now: Micros, cycle: &Cycle) -> Verdict {
        match self.clock.fleet(now).filter(|_| self.clock.is_synchronised()) {
            Some(fleet) => self.robot.offer(fleet, cycle),
            None => Verdict::Refused(Refusal::NotSynchronised),
        }
    }
}

/// Version of this crate, as said in the hello.
const VERSION: (u8, u8, u8) = (0, 1, 0);

#[cfg(test)]
mod tests;
