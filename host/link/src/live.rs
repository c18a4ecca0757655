//! A session in force with one module.

use protocol::window::Window;
use protocol::{ModuleKind, Nonce, Session};

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
}

impl<A> Live<A> {
    /// Whether it is of the boot that drew `boot`.
    pub(super) fn is_of(&self, boot: &Nonce) -> bool {
        self.boot.0.first_chunk::<12>() == boot.0.first_chunk::<12>()
    }
}
