//! What the host knows of one module: its sessions, where it is, what it was sent and what it said.
//!
//! ```text
//!            announcement                    first datagram of that session
//!  unknown ────────────────→ calling (≤ 4) ─────────────────────────────────→ in session
//! ```
//!
//! An announcement may be a recording. So the host answers it and believes nothing yet: only a datagram of the session that
//! the answer opens, which needs the host's fresh nonce, shows that the module is there. Until then the session that
//! was in force stays in force.

use std::collections::VecDeque;

use protocol::ledger::{Class, Incoming, Outgoing};
use protocol::session::{Opened, open_announcement};
use protocol::time::{Duration, FleetInstant};
use protocol::window::{Arrival, Window};
use protocol::{
    Faults, FleetId, Frame, Health, Kind, Message, ModuleId, ModuleKey, ModuleKind, ModuleState, Nonce,
    RovTelemetry, Session, Side, Telemetry,
};

use super::delivery::{CycleDelivery, DeliveryState, Knowledge};
use super::ledger::{Durations, Ledger};
use super::plausible::plausible;
use super::rival::{ALIVE_FOR, Rival};

/// Sessions offered at the same time, at most; the oldest offer gives way.
const CALLS: usize = 4;
/// Boot nonces that are remembered as used up.
const FORMER: usize = 16;
/// Pause between two calls that answer announcements of one boot.
const CALL_EVERY: Duration = Duration(50_000);
/// A module that names another session and leaves so many calls unanswered serves another host. *Assumed.*
const UNANSWERED: u64 = 10;
/// A report of before a start may carry a time that much after it: the module's clock is that good.
const CLOCK_GUARD: Duration = Duration(10_000);

/// A session on offer.
#[derive(Clone, Debug)]
struct Calling<A> {
    boot: Nonce,
    session: Session,
    address: A,
    announced: Window,
    next_call: FleetInstant,
}

/// The session in force.
#[derive(Clone, Debug)]
pub(super) struct Live<A> {
    boot: Nonce,
    pub(super) session: Session,
    pub(super) address: A,
    /// The nonce that its next session would have, and which announcements of that have come.
    next: Option<(Nonce, Window)>,
    /// Greatest number of a report.
    newest_report: Option<u32>,
    /// As it announces itself, or reports.
    kind: Option<ModuleKind>,
}

impl<A> Live<A> {
    /// Whether it is of the boot that drew `boot`.
    pub(super) fn is_of(&self, boot: &Nonce) -> bool {
        self.boot.0.first_chunk::<12>() == boot.0.first_chunk::<12>()
    }
}

/// What came with a datagram that was let in.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Heard {
    /// An announcement of this boot that wants an answer: call it.
    Call(Nonce),
    /// An announcement of a module that serves another host.
    Elsewhere,
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
    calling: VecDeque<Calling<A>>,
    former: VecDeque<Nonce>,
    boots: u32,
    sessions: u32,
    elsewhere: bool,
    heard: FleetInstant,
    pub(super) delivery: Option<CycleDelivery>,
    /// Greatest number of a cycle that was dispatched to it.
    latest: u32,
    /// When no cycle that was sent to it can begin any more, fleet time.
    useful_until: FleetInstant,
    telemetry: Option<Telemetry>,
    rov_telemetry: Option<RovTelemetry>,
    /// When the last report came, fleet time.
    reported: FleetInstant,
    health: Option<Health>,
    pub(super) ledger: Ledger,
    pub(super) answers: Durations,
    incoming: Incoming,
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
            calling: VecDeque::new(),
            former: VecDeque::new(),
            boots: 0,
            sessions: 0,
            elsewhere: false,
            heard: FleetInstant(0),
            delivery: None,
            latest: 0,
            useful_until: FleetInstant(0),
            telemetry: None,
            rov_telemetry: None,
            reported: FleetInstant(0),
            health: None,
            ledger: Ledger::default(),
            answers: Durations::default(),
            incoming: Incoming::default(),
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

    /// Its last report of this session, if it is a Modboat.
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
        boat.or(self.rov_telemetry.as_ref().map(|report| report.state))
    }

    /// What it said it was doing in a report that came at `since` or later.
    pub(super) fn state_since(&self, since: FleetInstant) -> Option<ModuleState> {
        self.state().filter(|_| self.reported >= since)
    }

    /// What it last said was wrong with it.
    pub fn faults(&self) -> Faults {
        let boat = self.telemetry.as_ref().map(|report| report.faults);
        boat.or(self.rov_telemetry.as_ref().map(|report| report.faults)).unwrap_or_default()
    }

    /// The cycle it last said it runs or ran, and when it said so, fleet time.
    fn reported(&self) -> Option<(u32, FleetInstant)> {
        let boat = self.telemetry.as_ref().map(|report| (report.cycle, report.at));
        boat.or(self.rov_telemetry.as_ref().map(|report| (report.cycle, report.at)))
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
        let calls = self.calling.iter().map(|calling| &calling.session);
        let sessions = self.live.iter().map(|live| &live.session).chain(calls);
        let sessions = sessions.chain(self.rival.iter().map(|rival| &rival.live.session));
        sessions.fold(self.closed, |sum, session| sum.plus(&session.outgoing()))
    }

    /// What was let in last came too late to be of use.
    pub(super) fn came_late(&mut self) {
        if let Some(live) = &mut self.live {
            live.session.came_late();
        }
    }

    /// Takes in a datagram that claims to be from it.
    pub(super) fn open(
        &mut self,
        now: FleetInstant,
        from: A,
        frame: &Frame<'_>,
        nonce: impl FnOnce() -> Nonce,
    ) -> Result<Heard, Class> {
        let heard = match frame.header.kind {
            Kind::Announce => self.announced(now, from, frame, nonce),
            _ => self.said(now, from, frame),
        };
        let heard = heard.map(|heard| self.checked(now, heard));
        self.incoming.count(match &heard {
            Ok(Heard::Said { opened: None, .. }) => Class::Corrupt,
            // Of a session that is over, unless it shows that it is not.
            Ok(Heard::Rival { .. }) if !self.is_doubled() => Class::Stale,
            Ok(_) => Class::Accepted,
            Err(class) => *class,
        });
        heard
    }

    /// Takes out a message with a number that no module can have.
    fn checked(&mut self, now: FleetInstant, heard: Heard) -> Heard {
        let Heard::Said { opened: Some(opened), joined } = heard else { return heard };
        let message = plausible(now, self.latest, opened.message);
        if message.is_none() {
            self.came_late();
        }
        Heard::Said { opened: message.map(|message| Opened { message, ..opened }), joined }
    }

    fn said(&mut self, now: FleetInstant, from: A, frame: &Frame<'_>) -> Result<Heard, Class> {
        let id = frame.header.session;
        if let Some(live) = self.live.as_mut().filter(|live| live.session.id() == id) {
            let opened = live.session.open(frame)?;
            // Its address is wherever its newest datagram came from.
            if !opened.overtaken {
                live.address = from;
            }
            self.heard = now;
            return Ok(Heard::Said { opened: Some(opened), joined: None });
        }
        if let Some(rival) = self.rival.as_mut().filter(|rival| rival.live.session.id() == id) {
            let was_proven = rival.is_proven();
            let ask = rival.hear(now, from, frame);
            // Whatever comes of a session that is over is stale.
            return ask
                .map(|ask| Heard::Rival { ask })
                .map_err(|class| if was_proven { class } else { Class::Stale });
        }
        let offered = self.calling.iter().position(|calling| calling.session.id() == id);
        let offered = offered.ok_or(Class::Stale)?;
        let calling = &mut self.calling[offered];
        let opened = calling.session.open(frame)?;
        calling.address = from;
        let joined = self.join(now, offered);
        self.heard = now;
        Ok(Heard::Said { opened: Some(opened), joined: Some(joined) })
    }

    /// Puts a session that was on offer in force: the module has shown that it is there.
    fn join(&mut self, now: FleetInstant, offered: usize) -> Joined {
        let mut joined = Joined::First;
        if let Some(Calling { boot, session, address, .. }) = self.calling.remove(offered) {
            self.retire(boot);
            let live = Live { boot, session, address, next: None, newest_report: None, kind: None };
            if let Some(former) = self.live.replace(live) {
                joined = if former.is_of(&boot) { Joined::Again } else { Joined::Rebooted };
                self.displaced(now, former, &boot);
            }
        }
        // No other offer can be taken up any more.
        while let Some(offer) = self.calling.pop_front() {
            self.closed = self.closed.plus(&offer.session.outgoing().closed());
        }
        self.sessions += 1;
        self.boots += u32::from(joined != Joined::Again);
        self.elsewhere = false;
        // Nothing sent before its reboot counts any more.
        (self.telemetry, self.rov_telemetry, self.health) = (None, None, None);
        joined
    }

    /// A session of the boot that drew `boot` has taken the place of `former`. Unless that was the same boot it may be a second module's.
    fn displaced(&mut self, now: FleetInstant, former: Live<A>, boot: &Nonce) {
        let keep = self.rival.as_ref().is_some_and(|rival| rival.is_proven() && !rival.is_of(boot));
        if former.is_of(boot) || keep {
            self.close(&former);
            return;
        }
        // A boot that comes back was there all the time: then there are two.
        let comes_back = self.rival.take().is_some_and(|rival| {
            self.close(&rival.live);
            rival.is_of(boot)
        });
        let proven = (comes_back && now.since(self.heard) < ALIVE_FOR).then_some(self.heard);
        self.rival = Some(Rival::new(now, former, proven));
    }

    /// What was under way in it is lost.
    fn close(&mut self, live: &Live<A>) {
        self.closed = self.closed.plus(&live.session.outgoing().closed());
    }

    /// Lets one of two go that is silent.
    pub(super) fn handle_timer(&mut self, now: FleetInstant) {
        let Some(rival) = &self.rival else { return };
        let rival_alone = rival.is_proven() && now.since(self.heard) >= ALIVE_FOR;
        if rival.is_silent(now) {
            if let Some(rival) = self.rival.take() {
                self.close(&rival.live);
            }
        } else if rival_alone && let Some(rival) = self.rival.take() {
            self.heard = rival.alive();
            if let Some(gone) = self.live.replace(rival.live) {
                self.close(&gone);
            }
        }
    }

    /// Two modules answer: nothing that was reported is of one that is known, and either may have what was sent.
    pub(super) fn doubt(&mut self) {
        (self.telemetry, self.rov_telemetry, self.health) = (None, None, None);
        if let Some(delivery) =
            self.delivery.as_mut().filter(|delivery| delivery.state != DeliveryState::Unsent)
        {
            delivery.state = DeliveryState::Sent;
            delivery.closed = true;
        }
    }

    fn retire(&mut self, nonce: Nonce) {
        if self.former.len() == FORMER {
            self.former.pop_front();
        }
        self.former.push_back(nonce);
    }

    fn announced(
        &mut self,
        now: FleetInstant,
        from: A,
        frame: &Frame<'_>,
        nonce: impl FnOnce() -> Nonce,
    ) -> Result<Heard, Class> {
        let Some(boot) = frame.header.nonce else { return Err(Class::Corrupt) };
        let Message::Hello(hello) = open_announcement(&self.key, frame)? else { return Err(Class::Corrupt) };
        if self.former.contains(&boot) {
            return Err(Class::Stale);
        }
        let sequence = frame.header.sequence;
        let rival = self.rival.as_mut().map(|rival| &mut rival.live);
        let ours = self.live.iter_mut().chain(rival).find(|live| live.session.id() == hello.session);
        if let Some(live) = ours {
            live.kind = Some(hello.kind);
            // It is in our session, and says which nonce the next one would have.
            let (known, window) = live.next.get_or_insert((boot, Window::new()));
            if *known != boot {
                (*known, *window) = (boot, Window::new());
            }
            fresh(window.note(sequence))?;
            return Ok(Heard::Known);
        }
        let offered = self.calling.iter().position(|calling| calling.boot == boot);
        let offered = offered.unwrap_or_else(|| self.offer(boot, from, nonce()));
        let calling = &mut self.calling[offered];
        fresh(calling.announced.note(sequence))?;
        calling.address = from;
        let due = now >= calling.next_call;
        if due {
            calling.next_call = now.after(CALL_EVERY);
        }
        // Its former session may be one of a host that has died: only one that it does not leave is another host's.
        self.elsewhere = hello.session != 0 && calling.session.outgoing().sent >= UNANSWERED;
        Ok(if due {
            Heard::Call(boot)
        } else if self.elsewhere {
            Heard::Elsewhere
        } else {
            Heard::Known
        })
    }

    /// Offers a session to the boot that drew `boot`, and says where the offer stands.
    fn offer(&mut self, boot: Nonce, address: A, nonce: Nonce) -> usize {
        if self.calling.len() == CALLS
            && let Some(oldest) = self.calling.pop_front()
        {
            self.closed = self.closed.plus(&oldest.session.outgoing().closed());
        }
        let session = Session::new(Side::Host, self.fleet, self.id, &self.key, &boot, nonce);
        let announced = Window::new();
        self.calling.push_back(Calling { boot, session, address, announced, next_call: FleetInstant(0) });
        self.calling.len() - 1
    }

    /// Notes a report, unless a newer one has been noted. Whether it was noted.
    pub(super) fn note_report(&mut self, now: FleetInstant, sequence: u32, report: Message) -> bool {
        let Some(live) = &mut self.live else { return false };
        if live.newest_report > Some(sequence) {
            return false;
        }
        live.newest_report = Some(sequence);
        self.reported = now;
        (self.telemetry, self.rov_telemetry, live.kind) = match report {
            Message::Telemetry(telemetry) => (Some(telemetry), None, Some(ModuleKind::Modboat)),
            Message::RovTelemetry(telemetry) => (None, Some(telemetry), Some(ModuleKind::Rov)),
            _ => return false,
        };
        true
    }

    pub(super) fn note_health(&mut self, health: Health) {
        self.health = Some(health);
    }

    /// Writes a message of the session in force; nothing without one.
    pub(super) fn seal<'a>(&mut self, message: &Message, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        let live = self.live.as_mut()?;
        Some((live.address, live.session.seal(message, buffer).ok()?))
    }

    /// Writes a message of the session that the one in force took the place of; nothing without one.
    pub(super) fn seal_rival<'a>(
        &mut self,
        message: &Message,
        buffer: &'a mut [u8],
    ) -> Option<(A, &'a [u8])> {
        let live = &mut self.rival.as_mut()?.live;
        Some((live.address, live.session.seal(message, buffer).ok()?))
    }

    /// Writes the call that answers an announcement of `boot`; nothing if the offer was withdrawn.
    pub(super) fn seal_call<'a>(&mut self, boot: Nonce, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        let calling = self.calling.iter_mut().find(|calling| calling.boot == boot)?;
        Some((calling.address, calling.session.seal_call(buffer).ok()?))
    }
}

fn fresh(arrival: Arrival) -> Result<(), Class> {
    match arrival {
        Arrival::Fresh { .. } => Ok(()),
        Arrival::Duplicate => Err(Class::Duplicate),
        Arrival::Stale => Err(Class::Stale),
    }
}
