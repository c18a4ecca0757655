//! What the host knows of one module: its sessions, where it is, what it was sent and what it said.
//!
//! ```text
//!            announcement                    first datagram of that session
//!  unknown ────────────────→ on offer (≤ 8) ────────────────────────────────→ in session
//! ```
//!
//! An announcement may be a recording. So the host answers it and believes nothing yet: only a datagram of the session that
//! the answer opens, which needs the host's fresh nonce, shows that the module is there. Until then the session that
//! was in force stays in force. How many are offered at once, and to whom again: `offers`.

use std::collections::VecDeque;

use protocol::ledger::{Incoming, Outgoing};
use protocol::session::{Opened, seal_stop};
use protocol::time::{Duration, FleetInstant};
use protocol::{
    Faults, FleetId, Health, Message, ModuleId, ModuleKey, ModuleKind, ModuleState, Nonce, RovTelemetry,
    TailUnknown, Telemetry,
};

use super::delivery::{CycleDelivery, Knowledge};
use super::lead::Losses;
use super::ledger::{Durations, Ledger};
use super::live::Live;
use super::offers::Offers;
use super::rival::Rival;

mod sessions;

/// A module that reports nothing but such numbers for this time is named for it. *Assumed*: fifty of its reports, and more than the damage of one.
pub const IMPLAUSIBLE_FOR: Duration = Duration(1_000_000);

/// A report of before a start may carry a time that much after it: the module's clock is that good.
const CLOCK_GUARD: Duration = Duration(10_000);

/// What came with a datagram that was let in.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Heard {
    /// An announcement of this boot that wants an answer: call it.
    Call {
        /// The boot.
        boot: Nonce,
        /// It says that it is in a session, of another host or of one that has died.
        in_another: bool,
    },
    /// An announcement of this boot of a module that serves another host.
    Elsewhere(Nonce),
    /// An announcement that says nothing new.
    Known,
    /// A datagram of the session that the one in force took the place of; whether its sender is to be asked if it is there.
    Rival {
        /// It is.
        ask: bool,
    },
    /// A message of the session in force.
    Said {
        /// The message; nothing if a number in it is none that a module can have.
        opened: Option<Opened>,
        /// The session is new.
        joined: Option<Joined>,
    },
}

/// How a session came to be in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Joined {
    /// It is the first.
    First,
    /// The module has booted since the last one.
    Rebooted,
    /// The module is in the same boot; it may have served another host meanwhile.
    Again,
}

/// What the host knows of one module: sessions, address, cycles sent, reports received.
#[derive(Clone, Debug)]
pub struct ModuleLink<A> {
    id: ModuleId,
    fleet: FleetId,
    key: ModuleKey,
    live: Option<Live<A>>,
    rival: Option<Rival<A>>,
    offers: Offers<A>,
    former: VecDeque<Nonce>,
    boots: u32,
    sessions: u32,
    elsewhere: bool,
    heard: FleetInstant,
    /// When the newest datagram was sent that it has said it had seen, or it joined: it was there then, whatever is played of it since.
    alive: FleetInstant,
    /// When it is asked next whether it is there, while there are two.
    next_ask: FleetInstant,
    pub(super) delivery: Option<CycleDelivery>,
    /// Greatest number of a cycle that was dispatched to it.
    latest: u32,
    /// When no cycle that was sent to it can begin any more, fleet time.
    useful_until: FleetInstant,
    telemetry: Option<Telemetry>,
    rov_telemetry: Option<RovTelemetry>,
    tail_unknown: Option<TailUnknown>,
    /// When the last report came, fleet time.
    reported: FleetInstant,
    /// Since when it has reported nothing but numbers that no module can have.
    implausible_since: Option<FleetInstant>,
    health: Option<Health>,
    pub(super) ledger: Ledger,
    pub(super) answers: Durations,
    incoming: Incoming,
    pub(super) losses: Losses,
    /// Of sessions that are over.
    closed: Outgoing,
}

impl<A: Copy> ModuleLink<A> {
    /// One that has not been heard of.
    pub(super) fn new(fleet: FleetId, id: ModuleId, key: ModuleKey) -> Self {
        Self {
            id,
            fleet,
            key,
            live: None,
            rival: None,
            offers: Offers::new(),
            former: VecDeque::new(),
            boots: 0,
            sessions: 0,
            elsewhere: false,
            heard: FleetInstant(0),
            alive: FleetInstant(0),
            next_ask: FleetInstant(0),
            delivery: None,
            latest: 0,
            useful_until: FleetInstant(0),
            telemetry: None,
            rov_telemetry: None,
            tail_unknown: None,
            reported: FleetInstant(0),
            implausible_since: None,
            health: None,
            ledger: Ledger::default(),
            answers: Durations::default(),
            incoming: Incoming::default(),
            losses: Losses::default(),
            closed: Outgoing::default(),
        }
    }

    /// The module's id.
    pub fn id(&self) -> ModuleId {
        self.id
    }

    /// Whether it has ever been in a session.
    pub fn is_known(&self) -> bool {
        self.live.is_some()
    }

    /// Whether cycles reach it: it is in a session, and alone with its number.
    pub fn is_reachable(&self) -> bool {
        self.is_known() && !self.is_doubled()
    }

    /// Whether two modules answer to its number. Neither is used then: none is sent a cycle, and what they report is not noted.
    pub fn is_doubled(&self) -> bool {
        self.rival.as_ref().is_some_and(Rival::is_proven)
    }

    /// Where the two are that answer to its number, if there are two.
    pub fn doubled(&self) -> Option<[A; 2]> {
        let rival = self.rival.as_ref().filter(|rival| rival.is_proven())?;
        Some([self.live.as_ref()?.address, rival.live.address])
    }

    /// Whether for [`IMPLAUSIBLE_FOR`] it has reported nothing but numbers that no module can have: what it does is not known.
    pub fn is_implausible(&self, now: FleetInstant) -> bool {
        self.implausible_since.is_some_and(|since| now.since(since) >= IMPLAUSIBLE_FOR)
    }

    /// Where it was heard last in a session.
    pub fn address(&self) -> Option<A> {
        self.live.as_ref().map(|live| live.address)
    }

    /// What kind of robot it announces itself as, or reports as, in this session.
    pub fn kind(&self) -> Option<ModuleKind> {
        self.live.as_ref()?.kind
    }

    /// Whether it says that it serves another host.
    pub fn is_elsewhere(&self) -> bool {
        self.elsewhere
    }

    /// How often it was seen to boot.
    pub fn boots(&self) -> u32 {
        self.boots
    }

    /// How many sessions it has had.
    pub fn sessions(&self) -> u32 {
        self.sessions
    }

    /// When it was last heard in a session, fleet time.
    pub fn heard(&self) -> FleetInstant {
        self.heard
    }

    /// Its last report of this session, if it is an ROV.
    pub fn rov_telemetry(&self) -> Option<&RovTelemetry> {
        self.rov_telemetry.as_ref()
    }

    /// Its last report of this session, if it is a Modboat that knows where its tail is.
    pub fn telemetry(&self) -> Option<&Telemetry> {
        self.telemetry.as_ref()
    }

    /// What it last said of its link and clock.
    pub fn health(&self) -> Option<&Health> {
        self.health.as_ref()
    }

    /// What it last said it was doing.
    pub fn state(&self) -> Option<ModuleState> {
        let boat = self.telemetry.as_ref().map(|report| report.state);
        let unknown = self.tail_unknown.as_ref().map(|report| report.state);
        boat.or(unknown).or(self.rov_telemetry.as_ref().map(|report| report.state))
    }

    /// What it said it was doing in a report that came at `since` or later.
    pub(super) fn state_since(&self, since: FleetInstant) -> Option<ModuleState> {
        self.state().filter(|_| self.reported >= since)
    }

    /// What it last said was wrong with it.
    pub fn faults(&self) -> Faults {
        let boat = self.telemetry.as_ref().map(|report| report.faults);
        let unknown = self.tail_unknown.as_ref().map(|report| report.faults);
        boat.or(unknown).or(self.rov_telemetry.as_ref().map(|report| report.faults)).unwrap_or_default()
    }

    /// The cycle it last said it runs or ran, and when it said so, fleet time.
    fn reported(&self) -> Option<(u32, FleetInstant)> {
        let boat = self.telemetry.as_ref().map(|report| (report.cycle, report.at));
        let unknown = self.tail_unknown.as_ref().map(|report| (report.cycle, report.at));
        boat.or(unknown).or(self.rov_telemetry.as_ref().map(|report| (report.cycle, report.at)))
    }

    /// Whether the module certainly has `cycle`: it reports that it runs or ran it.
    pub fn has(&self, cycle: u32) -> bool {
        self.knowledge(cycle) == Knowledge::Certainly
    }

    /// What is known of `cycle`, the last one that was dispatched to it.
    pub fn knowledge(&self, cycle: u32) -> Knowledge {
        let delivery = self.delivery.as_ref().filter(|delivery| delivery.number == cycle);
        let reported = self.reported().and_then(|(running, at)| {
            // It would have begun.
            let begun = delivery.is_some_and(|delivery| at >= delivery.useful_until.after(CLOCK_GUARD));
            (running == cycle || begun).then_some(running == cycle)
        });
        match delivery {
            Some(delivery) => delivery.state.knowledge(reported),
            None if reported == Some(true) => Knowledge::Certainly,
            None => Knowledge::Possibly,
        }
    }

    /// Whether it reports that it was still executing `cycle` at `since`, fleet time, or later.
    pub fn was_executing(&self, cycle: u32, since: FleetInstant) -> bool {
        let executes = self.state() == Some(ModuleState::Executing);
        executes
            && self.reported().is_some_and(|(running, at)| running == cycle && at >= since.after(CLOCK_GUARD))
    }

    /// Whether its last report is from when what it was sent last could not begin any more, unless it does not run that.
    pub fn is_up_to_date(&self) -> bool {
        // The planner of that one had a report from after the start of all before it.
        let at = self.reported().map(|(_, at)| at);
        let after = |until: FleetInstant| at.is_some_and(|at| at >= until.after(CLOCK_GUARD));
        self.delivery
            .as_ref()
            .is_none_or(|delivery| delivery.state.is_never_run() || after(delivery.useful_until))
    }

    /// Takes the place of the cycle that was dispatched before.
    pub(super) fn dispatched(&mut self, delivery: CycleDelivery) {
        self.useful_until = self.useful_until.max(delivery.useful_until);
        self.latest = self.latest.max(delivery.number);
        self.delivery = Some(delivery);
    }

    /// When no cycle that was sent to it can begin any more, by its clock too, fleet time; zero before the first.
    pub(super) fn nothing_begins_after(&self) -> FleetInstant {
        if self.useful_until == FleetInstant(0) {
            self.useful_until
        } else {
            self.useful_until.after(CLOCK_GUARD)
        }
    }

    /// Counts of its cycles.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// How long it took from a cycle's first datagram to its answer.
    pub fn answers(&self) -> &Durations {
        &self.answers
    }

    /// What became of the datagrams that claimed to be from it.
    pub fn incoming(&self) -> &Incoming {
        &self.incoming
    }

    /// What became of the datagrams that were sent to it.
    pub fn outgoing(&self) -> Outgoing {
        let sessions = self.live.iter().chain(self.rival.iter().map(|rival| &rival.live));
        let sum = sessions.fold(self.closed, |sum, live| sum.plus(&live.session.outgoing()));
        sum.plus(&self.offers.outgoing())
    }

    /// What was let in last came too late to be of use.
    pub(super) fn came_late(&mut self) {
        if let Some(live) = &mut self.live {
            live.session.came_late();
        }
    }

    /// Notes a report, unless a newer one has been noted. Whether it was noted.
    pub(super) fn note_report(&mut self, now: FleetInstant, sequence: u32, report: Message) -> bool {
        let Some(live) = &mut self.live else { return false };
        if live.newest_report > Some(sequence) {
            return false;
        }
        live.newest_report = Some(sequence);
        self.reported = now;
        self.implausible_since = None;
        self.tail_unknown = None;
        (self.telemetry, self.rov_telemetry, live.kind) = match report {
            Message::Telemetry(telemetry) => (Some(telemetry), None, Some(ModuleKind::Modboat)),
            Message::RovTelemetry(telemetry) => (None, Some(telemetry), Some(ModuleKind::Rov)),
            // Where it was seen before means nothing any more.
            Message::TailUnknown(unknown) => {
                self.tail_unknown = Some(unknown);
                (None, None, Some(ModuleKind::Modboat))
            }
            _ => return false,
        };
        true
    }

    pub(super) fn note_health(&mut self, health: Health) {
        self.health = Some(health);
    }

    /// Shares of datagrams lost on the way to it, and from it.
    pub(super) fn losses(&self) -> [f64; 2] {
        self.losses.shares()
    }

    /// When the newest datagram was sent that it had seen when it had seen so many.
    pub(super) fn saw(&self, seen: u32) -> Option<FleetInstant> {
        self.live.as_ref()?.saw(seen)
    }

    /// Writes a message of the session in force, to be sent at `now`; nothing without one.
    pub(super) fn seal<'a>(
        &mut self,
        now: FleetInstant,
        message: &Message,
        buffer: &'a mut [u8],
    ) -> Option<(A, &'a [u8])> {
        let live = self.live.as_mut()?;
        live.sent.sent(now, live.session.sent());
        Some((live.address, live.session.seal(message, buffer).ok()?))
    }

    /// Writes a message of the session that the one in force took the place of, to be sent at `now`; nothing without one.
    pub(super) fn seal_rival<'a>(
        &mut self,
        now: FleetInstant,
        message: &Message,
        buffer: &'a mut [u8],
    ) -> Option<(A, &'a [u8])> {
        let live = &mut self.rival.as_mut()?.live;
        live.sent.sent(now, live.session.sent());
        Some((live.address, live.session.seal(message, buffer).ok()?))
    }

    /// Writes the call that answers an announcement of `boot`; nothing if the offer was withdrawn.
    pub(super) fn seal_call<'a>(&mut self, boot: Nonce, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        let offer = self.offers.of(&boot)?;
        Some((offer.address, offer.session.seal_call(buffer).ok()?))
    }

    /// Writes the stop that answers an announcement of `boot`, whatever host it serves; nothing if the offer was withdrawn.
    pub(super) fn seal_stop<'a>(&mut self, boot: Nonce, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        let address = self.offers.of(&boot)?.address;
        Some((address, seal_stop(self.fleet, self.id, &self.key, boot, buffer).ok()?))
    }
}
