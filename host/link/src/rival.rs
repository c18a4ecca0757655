//! Rival: a second module that answers to the same number.
//!
//! ```text
//!             another boot takes up a call                 it answers what is asked in that session
//!  in session ────────────────────────────→ displaced ─────────────────────────────────────────────→ doubled
//!                                              │ ALIVE_FOR without such an answer                       │ one of the two silent for ALIVE_FOR
//!                                              ↓                                                        ↓
//!                                           it has booted                                            the other alone
//! ```
//!
//! A module that boots draws another nonce, and its old session is silent from then on. So when another boot takes the place of a session, that one
//! is kept for a while. A datagram of it proves nothing yet: it may have been under way, or be a recording. It is answered with something of no
//! meaning, and only a datagram whose receipt says that the answer came proves that its sender is there too. A recording cannot say that.
//! The same holds of a boot that takes up a call after another one did: it was there all the time.
//!
//! A datagram that was held back, and is played later, is let in where the first copy was lost, and says nothing of now. So either of two is taken to have
//! been there when the newest datagram was sent that it says it had seen, and not when that comes to be known: nothing that is played keeps
//! one alive.
//!
//! Assumptions and limits: two are told apart, and of more than two the two that were there last. What the older one has accepted it runs.

use protocol::ledger::{Class, Outgoing};
use protocol::time::{Duration, FleetInstant};
use protocol::{Frame, Nonce};

use super::live::Live;

/// A module that was not heard for this time is not there. *Assumed*: in a session it reports many times a second, and is asked [`ASK_EVERY`].
pub(super) const ALIVE_FOR: Duration = Duration(3_000_000);
/// Pause between two questions. *Assumed*: several within the 1.5 s after which a module that hears nothing looks for another host.
pub(super) const ASK_EVERY: Duration = Duration(200_000);

/// A session that another boot took the place of.
#[derive(Clone, Debug)]
pub(super) struct Rival<A> {
    pub(super) live: Live<A>,
    since: FleetInstant,
    /// When its sender was last shown to be there.
    proven: Option<FleetInstant>,
    /// Datagrams sent to it when that was last shown: what it saw after them shows it again.
    asked: u64,
    next_ask: FleetInstant,
}

impl<A: Copy> Rival<A> {
    /// Of the session that ceased to be in force at `now`.
    pub(super) fn new(now: FleetInstant, live: Live<A>, proven: Option<FleetInstant>) -> Self {
        let asked = live.session.outgoing().sent;
        Self { live, since: now, proven, asked, next_ask: now }
    }

    pub(super) fn is_proven(&self) -> bool {
        self.proven.is_some()
    }

    /// When it was last shown to be there, or was displaced.
    pub(super) fn alive(&self) -> FleetInstant {
        self.proven.unwrap_or(self.since)
    }

    pub(super) fn is_silent(&self, now: FleetInstant) -> bool {
        now.since(self.alive()) >= ALIVE_FOR
    }

    /// Whether it is of the boot that drew `boot`.
    pub(super) fn is_of(&self, boot: &Nonce) -> bool {
        self.live.is_of(boot)
    }

    /// Takes in a datagram of its session; whether it is to be asked again.
    pub(super) fn hear(&mut self, now: FleetInstant, from: A, frame: &Frame<'_>) -> Result<bool, Class> {
        let opened = self.live.session.open(frame)?;
        if !opened.overtaken {
            self.live.address = from;
        }
        let Outgoing { sent, acknowledged, late, lost } = self.live.session.outgoing();
        if acknowledged + late + lost > self.asked
            && let Some(saw) = self.live.saw(opened.seen)
        {
            (self.proven, self.asked) = (self.proven.max(Some(saw)), sent);
        }
        // Nothing of it is of use.
        self.live.session.came_late();
        let ask = now >= self.next_ask;
        if ask {
            self.next_ask = now.after(ASK_EVERY);
        }
        Ok(ask)
    }
}
