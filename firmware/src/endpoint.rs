//! The module's side of the link: announces itself, learns the fleet time, takes cycles, acknowledges, reports.
//!
//! Sans-IO: datagrams, measurements and the time on the module's own clock go in; datagrams come out of
//! [`Endpoint::poll_transmit`], the tail's reference out of [`Endpoint::reference`].
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
use protocol::units::{Amperes, Micros, MicrosSpan, Radians, RadiansPerSecond, Volts};
use protocol::{
    Acknowledge, Cycle, DecodeError, Header, Hello, Message, ModboatCycle, ModuleId, ModuleKind, ModuleState,
    Motion, Refusal, Telemetry, TimeReply, TimeRequest, Verdict, decode, encode,
};

use crate::clock::{Exchange, FleetClock};
use crate::cycle::SwimCycle;
use crate::limits::Limits;
use crate::reference::Reference;
use crate::schedule::{self, Schedule};
use crate::waveform::Waveform;

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

/// What the module measures for its reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Tail angle, unwrapped; nothing while the encoder is not believed.
    pub tail: Option<Radians>,
    /// Tail speed.
    pub rate: RadiansPerSecond,
    /// Motor current.
    pub current: Amperes,
    /// Battery voltage.
    pub battery: Volts,
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
pub struct Endpoint {
    identity: Identity,
    limits: Limits,
    clock: FleetClock,
    /// From the first measurement on: before it nobody knows where the tail is.
    schedule: Option<Schedule>,
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

impl Endpoint {
    /// An endpoint that has just booted.
    #[must_use]
    pub const fn new(identity: Identity, limits: Limits) -> Self {
        Self {
            identity,
            limits,
            clock: FleetClock::new(),
            schedule: None,
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
                if let Some(schedule) = &mut self.schedule {
                    schedule.hold(fleet);
                }
            }
            Message::EmergencyStop => {
                let fleet = self.fleet(now);
                if let Some(schedule) = &mut self.schedule {
                    schedule.emergency_stop(fleet);
                }
            }
            // What modules say is not for modules.
            Message::Hello(_) | Message::TimeRequest(_) | Message::Acknowledge(_) | Message::Telemetry(_) => {
            }
        }
        Ok(())
    }

    /// Posts what is due at `now`, own clock.
    pub fn handle_timer(&mut self, now: Micros, measurement: &Measurement) {
        if let (None, Some(tail)) = (&self.schedule, measurement.tail) {
            self.schedule = Some(Schedule::new(self.limits, tail));
        }
        if now >= self.next_hello {
            self.next_hello = now.after(if self.host.is_some() { KEEP_EVERY } else { HELLO_EVERY });
            self.post(Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: VERSION }));
        }
        if now >= self.next_exchange {
            self.next_exchange =
                now.after(if self.clock.is_synchronised() { KEEP_EVERY } else { EXCHANGE_EVERY });
            self.post(Message::TimeRequest(TimeRequest { sent: now }));
        }
        if let Some(tail) = measurement.tail.filter(|_| now >= self.next_report) {
            self.next_report = now.after(self.identity.report_every);
            let report = self.report(now, tail, measurement);
            self.post(Message::Telemetry(report));
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

    /// What the tail is to do at `now`, own clock; nothing before the first measurement.
    #[must_use]
    pub fn reference(&self, now: Micros) -> Option<Reference> {
        Some(self.schedule.as_ref()?.reference(self.fleet(now)))
    }

    /// What the module is doing at `now`, own clock.
    #[must_use]
    pub fn state(&self, now: Micros) -> ModuleState {
        let fleet = self.fleet(now);
        match &self.schedule {
            Some(schedule) if schedule.is_stopped() => ModuleState::Stopped,
            _ if !self.clock.is_synchronised() => ModuleState::Unsynchronised,
            Some(schedule) if schedule.running(fleet).is_some() => ModuleState::Executing,
            Some(schedule) if schedule.latest(fleet).is_some() => ModuleState::Holding,
            _ => ModuleState::Ready,
        }
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

    /// Fleet time, or the beginning of time: with nothing scheduled every time is the same.
    fn fleet(&self, now: Micros) -> Micros {
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
            if self.schedule.as_ref().is_some_and(|schedule| schedule.running(fleet).is_some()) {
                return false;
            }
            self.clock.reset();
            self.schedule = self.schedule.as_ref().map(|schedule| schedule.anew(fleet));
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
        let Motion::Modboat(motion) = &cycle.motion else { return Verdict::Refused(Refusal::WrongKind) };
        let (Some(fleet), true) = (self.clock.fleet(now), self.clock.is_synchronised()) else {
            return Verdict::Refused(Refusal::NotSynchronised);
        };
        let Some(schedule) = &mut self.schedule else { return Verdict::Refused(Refusal::NotSynchronised) };
        let &ModboatCycle { rotation, centerline, amplitude, transition, period } = motion;
        let waveform = Waveform::new(centerline, amplitude, period);
        let offered = SwimCycle::new(cycle.number, cycle.start, rotation, transition, waveform);
        on_the_wire(schedule.offer(fleet, offered))
    }

    fn report(&self, now: Micros, tail: Radians, measurement: &Measurement) -> Telemetry {
        let fleet = self.fleet(now);
        let cycle = self.schedule.as_ref().and_then(|schedule| schedule.latest(fleet)).unwrap_or(0);
        let &Measurement { rate, current, battery, .. } = measurement;
        Telemetry { at: fleet, state: self.state(now), cycle, tail, rate, current, battery }
    }
}

/// Version of this crate, as said in the hello.
const VERSION: (u8, u8, u8) = (0, 1, 0);

/// The schedule's verdict without its numbers.
fn on_the_wire(verdict: schedule::Verdict) -> Verdict {
    let refusal = match verdict {
        schedule::Verdict::Accepted => return Verdict::Accepted,
        schedule::Verdict::Duplicate => return Verdict::Duplicate,
        schedule::Verdict::Refused(refusal) => refusal,
    };
    Verdict::Refused(match refusal {
        schedule::Refusal::Stopped => Refusal::Stopped,
        schedule::Refusal::Conflict | schedule::Refusal::Full { .. } | schedule::Refusal::Overlap { .. } => {
            Refusal::Conflict
        }
        schedule::Refusal::AlreadyRun { .. } => Refusal::AlreadyRun,
        schedule::Refusal::Limit(_) => Refusal::BeyondLimits,
        schedule::Refusal::Late { .. } => Refusal::Late,
        schedule::Refusal::TooFarAhead { .. } => Refusal::TooFarAhead,
        schedule::Refusal::PoseMismatch { .. } => Refusal::PoseMismatch,
    })
}

#[cfg(test)]
mod tests;
