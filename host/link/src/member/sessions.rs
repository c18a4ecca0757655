//! Sessions of one module: which datagrams are let in, which session is in force, and when another takes its place.

use protocol::ledger::Class;
use protocol::session::{Opened, open_announcement};
use protocol::time::{Duration, FleetInstant};
use protocol::window::{Arrival, Window};
use protocol::{Frame, Kind, Message, Nonce, Session, Side};

use super::super::delivery::DeliveryState;
use super::super::lead::SentTimes;
use super::super::live::Live;
use super::super::offers::Offer;
use super::super::plausible::plausible;
use super::super::rival::{ALIVE_FOR, ASK_EVERY, Rival};
use super::{Heard, Joined, ModuleLink};

/// Boot nonces that are remembered as used up.
const FORMER: usize = 16;
/// Pause between two calls that answer announcements of one boot.
const CALL_EVERY: Duration = Duration(50_000);
/// A module that names another session and leaves so many calls unanswered serves another host. *Assumed.*
const UNANSWERED: u64 = 10;
/// Heard so lately a module is in our session. *Assumed*: it asks for the time every second.
const HERE_FOR: Duration = Duration(2_000_000);

impl<A: Copy> ModuleLink<A> {
    /// Takes in a datagram that claims to be from it.
    pub(in super::super) fn open(
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
        let is_health = matches!(opened.message, Message::Health(_));
        let message = plausible(now, self.latest, opened.message);
        if message.is_none() {
            self.came_late();
            if !is_health {
                self.implausible_since.get_or_insert(now);
            }
        }
        Heard::Said { opened: message.map(|message| Opened { message, ..opened }), joined }
    }

    fn said(&mut self, now: FleetInstant, from: A, frame: &Frame<'_>) -> Result<Heard, Class> {
        let id = frame.header.session;
        if let Some(live) = self.live.as_mut().filter(|live| live.session.id() == id) {
            let opened = live.session.open(frame)?;
            live.note(opened.sequence);
            self.alive = self.alive.max(live.saw(opened.seen).unwrap_or_default());
            // Its address is wherever its newest datagram came from.
            // One that was overtaken may have been held back, and says nothing of now.
            if !opened.overtaken {
                (live.address, self.heard) = (from, now);
            }
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
        let offer = self.offers.in_session(id).ok_or(Class::Stale)?;
        let opened = offer.session.open(frame)?;
        offer.address = from;
        let boot = offer.boot;
        let joined = self.join(now, &boot);
        self.live.iter_mut().for_each(|live| live.note(opened.sequence));
        self.heard = now;
        Ok(Heard::Said { opened: Some(opened), joined: Some(joined) })
    }

    /// Puts a session that was on offer in force: the module has shown that it is there.
    fn join(&mut self, now: FleetInstant, boot: &Nonce) -> Joined {
        let mut joined = Joined::First;
        let alive = std::mem::replace(&mut self.alive, now);
        // No other offer can be taken up any more.
        if let Some(Offer { boot, session, address, .. }) = self.offers.take_up(boot) {
            self.retire(boot);
            let (sent, came) = (SentTimes::new(), (0, 0));
            let live =
                Live { boot, session, address, next: None, newest_report: None, kind: None, sent, came };
            if let Some(former) = self.live.replace(live) {
                joined = if former.is_of(&boot) { Joined::Again } else { Joined::Rebooted };
                self.displaced(now, alive, former, &boot);
            }
        }
        self.sessions += 1;
        self.boots += u32::from(joined != Joined::Again);
        self.elsewhere = false;
        // Nothing sent before its reboot counts any more.
        (self.telemetry, self.rov_telemetry, self.tail_unknown, self.health) = (None, None, None, None);
        self.implausible_since = None;
        joined
    }

    /// A session of the boot that drew `boot` has taken the place of `former`, which was last there at `alive`. Unless that was the same boot it
    /// may be a second module's.
    fn displaced(&mut self, now: FleetInstant, alive: FleetInstant, former: Live<A>, boot: &Nonce) {
        // Of three the two that were there last.
        let kept = |rival: &Rival<A>| rival.is_proven() && !rival.is_of(boot) && rival.alive() > alive;
        if former.is_of(boot) || self.rival.as_ref().is_some_and(kept) {
            self.close(&former);
            return;
        }
        // A boot that comes back was there all the time: then there are two.
        let comes_back = self.rival.take().is_some_and(|rival| {
            self.close(&rival.live);
            rival.is_of(boot)
        });
        let proven = (comes_back && now.since(alive) < ALIVE_FOR).then_some(alive);
        self.rival = Some(Rival::new(now, former, proven));
    }

    /// What was under way in it is lost.
    fn close(&mut self, live: &Live<A>) {
        self.closed = self.closed.plus(&live.session.outgoing().closed());
    }

    /// Forgets what one said that reports no numbers any more; lets one of two go that is silent.
    /// Whether the one in force is to be asked whether it is there.
    pub(in super::super) fn handle_timer(&mut self, now: FleetInstant) -> bool {
        if self.is_implausible(now) {
            // It may have moved since.
            (self.telemetry, self.rov_telemetry, self.tail_unknown) = (None, None, None);
        }
        if let Some(live) = &self.live {
            let (came, seen) = live.came;
            self.losses.update(now, live.session.id(), &live.session.outgoing(), came, seen);
        }
        let Some(rival) = &self.rival else { return false };
        let rival_alone = rival.is_proven() && now.since(self.alive) >= ALIVE_FOR;
        if rival.is_silent(now) {
            if let Some(rival) = self.rival.take() {
                self.close(&rival.live);
            }
        } else if rival_alone && let Some(rival) = self.rival.take() {
            (self.heard, self.alive) = (rival.alive(), rival.alive());
            if let Some(gone) = self.live.replace(rival.live) {
                self.close(&gone);
            }
        }
        let ask = self.is_doubled() && now >= self.next_ask;
        if ask {
            self.next_ask = now.after(ASK_EVERY);
        }
        ask
    }

    /// Two modules answer: nothing that was reported is of one that is known, and either may have what was sent.
    pub(in super::super) fn doubt(&mut self) {
        (self.telemetry, self.rov_telemetry, self.health) = (None, None, None);
        self.tail_unknown = None;
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
        // A module that is in our session is in no other: an announcement that says so is a recording.
        let is_here = self.live.is_some() && now.since(self.heard) < HERE_FOR;
        let (fleet, id, key) = (self.fleet, self.id, &self.key);
        let make = || Session::new(Side::Host, fleet, id, key, &boot, nonce());
        let Some(offer) = self.offers.to(now, boot, from, make) else { return Ok(Heard::Known) };
        fresh(offer.announced.note(sequence))?;
        offer.address = from;
        let due = now >= offer.next_call;
        if due {
            offer.next_call = now.after(CALL_EVERY);
        }
        // Its former session may be one of a host that has died: only one that it does not leave is another host's.
        self.elsewhere = !is_here && hello.session != 0 && offer.session.outgoing().sent >= UNANSWERED;
        Ok(if due {
            Heard::Call { boot, in_another: hello.session != 0 }
        } else if self.elsewhere {
            Heard::Elsewhere(boot)
        } else {
            Heard::Known
        })
    }
}

fn fresh(arrival: Arrival) -> Result<(), Class> {
    match arrival {
        Arrival::Fresh { .. } => Ok(()),
        Arrival::Duplicate => Err(Class::Duplicate),
        Arrival::Stale => Err(Class::Stale),
    }
}
