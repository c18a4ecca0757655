//! What was sent to a module and what came back.

use serde::Serialize;

/// Counts of one module's link, as the host sees it. `cycles = acknowledged + refused + unanswered`, plus one while
/// a cycle is still open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Ledger {
    /// Datagrams sent to the module.
    pub datagrams_sent: u64,
    /// Valid datagrams received from it.
    pub datagrams_received: u64,
    /// Datagrams it sent before its last reboot that came after it.
    pub stale: u64,
    /// Cycles dispatched to it.
    pub cycles: u64,
    /// Times a cycle was sent again.
    pub resent: u64,
    /// Cycles it accepted.
    pub acknowledged: u64,
    /// Cycles it refused.
    pub refused: u64,
    /// Cycles without an answer when they started (an ROV's: when their lease ended) or a newer one took their place.
    pub unanswered: u64,
}

impl Ledger {
    /// Cycles whose fate is not decided yet.
    #[must_use]
    pub fn open(&self) -> u64 {
        self.cycles - self.acknowledged - self.refused - self.unanswered
    }
}
