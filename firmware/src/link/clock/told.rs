//! Cache of the last answer: a tick asks for the fleet time of one and the same moment several times.

use core::cell::Cell;
use core::fmt;

use protocol::time::{FleetInstant, LocalInstant};

/// Own clock, and the fleet clock that was told for it. It decides nothing, so its `Debug` shows nothing.
#[derive(Clone)]
pub(super) struct Told(Cell<Option<(LocalInstant, FleetInstant)>>);

impl Told {
    /// Nothing has been told.
    pub(super) const fn new() -> Self {
        Self(Cell::new(None))
    }

    /// What was told for `local`, or what `work_out` says.
    pub(super) fn or_else(
        &self,
        local: LocalInstant,
        work_out: impl FnOnce() -> Option<FleetInstant>,
    ) -> Option<FleetInstant> {
        if let Some((_, fleet)) = self.0.get().filter(|(asked, _)| *asked == local) {
            return Some(fleet);
        }
        let fleet = work_out()?;
        self.0.set(Some((local, fleet)));
        Some(fleet)
    }

    /// To be called whenever the answers change.
    pub(super) fn forget(&self) {
        self.0.set(None);
    }
}

impl fmt::Debug for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Told")
    }
}
