//! Where every datagram went. Sums are exact: nothing is counted twice, nothing is left out.
//!
//! ```text
//! sender:    sent     = acknowledged + late + lost + under way
//! receiver:  received = accepted + duplicate + stale + corrupt + forged + foreign
//! ```
//!
//! The two meet in the [`Receipt`] that every datagram of a session carries back: of the numbers up to the newest that came,
//! so many were accepted, and so many of those came when they were of no use any more. What is missing below
//! the newest is lost, until it comes after all. When a session ends, what was under way is lost.

use serde::{Deserialize, Serialize};

/// What one end tells the other about what came, in every datagram of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Receipt {
    /// One more than the greatest sequence number that came; 0 before any.
    pub seen: u32,
    /// How many different ones came and were accepted.
    pub accepted: u32,
    /// How many of those came too late to be of use.
    pub late: u32,
}

/// What became of what was sent in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outgoing {
    /// Datagrams sent.
    pub sent: u64,
    /// Arrived in time, by the receipts of the other side.
    pub acknowledged: u64,
    /// Arrived too late to be of use.
    pub late: u64,
    /// Did not arrive, or its arrival was not reported.
    pub lost: u64,
}

impl Outgoing {
    /// Sent, and neither confirmed nor given up.
    #[must_use]
    pub const fn under_way(&self) -> u64 {
        self.sent.saturating_sub(self.acknowledged).saturating_sub(self.late).saturating_sub(self.lost)
    }

    /// The counts with everything under way lost: no more receipts will come.
    #[must_use]
    pub const fn closed(&self) -> Self {
        Self { lost: self.lost.saturating_add(self.under_way()), ..*self }
    }

    /// The sum, member by member.
    #[must_use]
    pub const fn plus(&self, other: &Self) -> Self {
        Self {
            sent: self.sent.saturating_add(other.sent),
            acknowledged: self.acknowledged.saturating_add(other.acknowledged),
            late: self.late.saturating_add(other.late),
            lost: self.lost.saturating_add(other.lost),
        }
    }
}

/// What became of what was received in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Incoming {
    /// Datagrams received, whatever they were.
    pub received: u32,
    /// Genuine and new.
    pub accepted: u32,
    /// Genuine, and had come before.
    pub duplicate: u32,
    /// From a session that is over, or from too far back to tell whether it had come.
    pub stale: u32,
    /// Damaged on the way, no datagram of this wire version, or a report with numbers that no module can have (the host looks).
    pub corrupt: u32,
    /// Undamaged, and not sealed by whom it claims.
    pub forged: u32,
    /// Another fleet's, another module's, or another host's while this one is heard.
    pub foreign: u32,
}

/// What a received datagram was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// See [`Incoming::accepted`].
    Accepted,
    /// See [`Incoming::duplicate`].
    Duplicate,
    /// See [`Incoming::stale`].
    Stale,
    /// See [`Incoming::corrupt`].
    Corrupt,
    /// See [`Incoming::forged`].
    Forged,
    /// See [`Incoming::foreign`].
    Foreign,
}

impl Incoming {
    /// Counts one more.
    pub fn count(&mut self, class: Class) {
        let member = match class {
            Class::Accepted => &mut self.accepted,
            Class::Duplicate => &mut self.duplicate,
            Class::Stale => &mut self.stale,
            Class::Corrupt => &mut self.corrupt,
            Class::Forged => &mut self.forged,
            Class::Foreign => &mut self.foreign,
        };
        // Both stand still together, or the sum would be wrong.
        if self.received < u32::MAX {
            self.received = self.received.saturating_add(1);
            *member = member.saturating_add(1);
        }
    }

    /// Whether the sum is exact.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        let members = [self.accepted, self.duplicate, self.stale, self.corrupt, self.forged, self.foreign];
        members.iter().try_fold(0_u32, |sum, member| sum.checked_add(*member)) == Some(self.received)
    }
}
