//! Offers: sessions that a host has called a module into and that the module has not taken up yet.
//!
//! ```text
//!                     room, or an offer that has run out            PROVES_WITHIN without an answer, and its place is wanted
//!  announcement ─────────────────────────────────────────→ on offer ─────────────────────────────────────────────────────→ silent
//!        ↑                                                                    │ a datagram of that session                   │
//!        └─ once more after 1, 2, 4 … 60 s ───────────────────────────────────┼──────────────────────────────────────────────┘
//!                                                                             ↓
//!                                                                         in session
//! ```
//!
//! An announcement may be a recording of an old boot, and a player needs no key. So what may still be proven is never given up for what
//! is not proven either: an offer keeps its place for [`PROVES_WITHIN`], and after that until another needs it. A boot that had its time
//! is remembered, and is offered a session again after a pause that doubles. However many recordings are played, and however fast, each
//! boot of them takes one of [`OFFERS`] places for [`PROVES_WITHIN`] once in a pause; a module that is there has the first that is free.
//!
//! Assumptions and limits: recordings of more boots than are remembered ([`SILENT`]), played at once, keep the places taken. A module whose
//! way back is longer than [`PROVES_WITHIN`] loses its place only to others that want it.

use std::collections::VecDeque;

use protocol::ledger::Outgoing;
use protocol::time::{Duration, FleetInstant};
use protocol::window::Window;
use protocol::{Nonce, Session};

/// Sessions offered to one module at the same time, at most.
pub const OFFERS: usize = 8;
/// An offer that is this old may give its place to another. *Assumed*: several round trips of a bad link.
pub const PROVES_WITHIN: Duration = Duration(500_000);
/// Boots that had their time, remembered.
pub const SILENT: usize = 256;
/// Pause before the second offer to a boot, and the longest; it doubles from one to the next. *Assumed.*
const PAUSE: (Duration, Duration) = (Duration(1_000_000), Duration(60_000_000));

/// A session on offer.
#[derive(Clone, Debug)]
pub(super) struct Offer<A> {
    pub(super) boot: Nonce,
    pub(super) session: Session,
    pub(super) address: A,
    /// Announcements of that boot that have come.
    pub(super) announced: Window,
    pub(super) next_call: FleetInstant,
    since: FleetInstant,
}

/// A boot whose offer was not taken up in its time.
#[derive(Clone, Copy, Debug)]
struct Silent {
    boot: Nonce,
    again: FleetInstant,
    pause: Duration,
}

/// All that is on offer to one module.
#[derive(Clone, Debug)]
pub(super) struct Offers<A> {
    open: Vec<Offer<A>>,
    silent: VecDeque<Silent>,
    /// Of offers that were given up.
    closed: Outgoing,
}

impl<A> Offers<A> {
    pub(super) const fn new() -> Self {
        let closed = Outgoing { sent: 0, acknowledged: 0, late: 0, lost: 0 };
        Self { open: Vec::new(), silent: VecDeque::new(), closed }
    }

    pub(super) fn of(&mut self, boot: &Nonce) -> Option<&mut Offer<A>> {
        self.open.iter_mut().find(|offer| offer.boot == *boot)
    }

    pub(super) fn in_session(&mut self, session: u32) -> Option<&mut Offer<A>> {
        self.open.iter_mut().find(|offer| offer.session.id() == session)
    }

    /// The offer to the boot that drew `boot`; `make` draws a session for a new one. `None` while there is no place for it.
    pub(super) fn to(
        &mut self,
        now: FleetInstant,
        boot: Nonce,
        address: A,
        make: impl FnOnce() -> Session,
    ) -> Option<&mut Offer<A>> {
        if let Some(place) = self.open.iter().position(|offer| offer.boot == boot) {
            return self.open.get_mut(place);
        }
        if self.silent.iter().any(|silent| silent.boot == boot && now < silent.again) {
            return None;
        }
        if self.open.len() >= OFFERS {
            // In the order in which they were made.
            let over = self.open.first().filter(|offer| now.since(offer.since) >= PROVES_WITHIN)?.boot;
            self.give_up(now, &over);
        }
        let (announced, next_call) = (Window::new(), FleetInstant(0));
        self.open.push(Offer { boot, session: make(), address, announced, next_call, since: now });
        self.open.last_mut()
    }

    fn give_up(&mut self, now: FleetInstant, boot: &Nonce) {
        let (first, longest) = PAUSE;
        let known = self.silent.iter().position(|silent| silent.boot == *boot);
        let before = known.and_then(|place| self.silent.remove(place));
        let pause = before.map_or(first, |before| Duration(before.pause.0.saturating_mul(2)).min(longest));
        if self.silent.len() >= SILENT {
            self.silent.pop_front();
        }
        self.silent.push_back(Silent { boot: *boot, again: now.after(pause), pause });
        if let Some(offer) = self.take(boot) {
            self.closed = self.closed.plus(&offer.session.outgoing().closed());
        }
    }

    fn take(&mut self, boot: &Nonce) -> Option<Offer<A>> {
        let place = self.open.iter().position(|offer| offer.boot == *boot)?;
        Some(self.open.remove(place))
    }

    /// The module has taken up the one of `boot`; no other can be taken up any more.
    pub(super) fn take_up(&mut self, boot: &Nonce) -> Option<Offer<A>> {
        let taken = self.take(boot);
        for offer in self.open.drain(..) {
            self.closed = self.closed.plus(&offer.session.outgoing().closed());
        }
        taken
    }

    /// What became of the calls.
    pub(super) fn outgoing(&self) -> Outgoing {
        self.open.iter().fold(self.closed, |sum, offer| sum.plus(&offer.session.outgoing()))
    }
}
