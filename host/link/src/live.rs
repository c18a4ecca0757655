//! A session in force with one module.

use protocol::time::FleetInstant;
use protocol::window::Window;
use protocol::{ModuleKind, Nonce, Session};

use super::lead::SentTimes;

/// The session in force.
#[derive(Clone, Debug)]
pub(super) struct Live<A> {
    pub(super) boot: Nonce,
    pub(super) session: Session,
    pub(super) address: A,
    /// The nonce that its next session would have, and which announcements of that have come.
    pub(super) next: Option<(Nonce, Window)>,
    /// Greatest number of a report.
    pub(super) newest_report: Option<u32>,
    /// As it announces itself, or reports.
    pub(super) kind: Option<ModuleKind>,
    /// When what was sent was sent.
    pub(super) sent: SentTimes,
    /// Datagrams that were let in, and one more than the greatest number of them.
    pub(super) came: (u32, u32),
}

impl<A> Live<A> {
    /// Notes the number of a datagram that was let in.
    pub(super) fn note(&mut self, number: u32) {
        let (came, seen) = self.came;
        self.came = (came.saturating_add(1), seen.max(number.saturating_add(1)));
    }

    /// When the newest datagram was sent that its module had seen when it had seen so many: it was there after that.
    pub(super) fn saw(&self, seen: u32) -> Option<FleetInstant> {
        self.sent.of(seen.checked_sub(1)?)
    }

    /// Whether it is of the boot that drew `boot`.
    pub(super) fn is_of(&self, boot: &Nonce) -> bool {
        self.boot.0.first_chunk::<12>() == boot.0.first_chunk::<12>()
    }
}
