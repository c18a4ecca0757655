//! What the medium did, counted exactly:
//!
//! ```text
//! sent + duplicated + replayed + forged = delivered + lost + under way
//! ```
//!
//! The others say what happened to datagrams among these; one datagram can be among several of them.

use serde::Serialize;

/// What the medium did to the datagrams handed to it, and what it added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FaultCount {
    /// Handed over.
    pub sent: u64,
    /// Vanished, for whatever reason.
    pub lost: u64,
    /// Of those lost: sent in a burst.
    pub burst_lost: u64,
    /// Of those lost: thrown away when the medium was healed, or because too many were under way.
    pub dropped: u64,
    /// Doubled.
    pub duplicated: u64,
    /// Sent on with one bit flipped.
    pub corrupted: u64,
    /// Sent on shorter than they were.
    pub truncated: u64,
    /// Held back behind later ones.
    pub reordered: u64,
    /// Held up in a spike of delay.
    pub late: u64,
    /// Sent again.
    pub replayed: u64,
    /// Added by a stranger.
    pub forged: ForgeryCount,
    /// Handed to the radio below, which took them.
    pub delivered: u64,
    /// Neither delivered nor lost yet.
    pub under_way: u64,
}

/// What a stranger added, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ForgeryCount {
    /// Random bytes.
    pub noise: u64,
    /// A recorded datagram changed in its middle, with a right checksum.
    pub remade: u64,
    /// A recorded datagram to an address it was not for.
    pub misdirected: u64,
    /// A recorded datagram back to whom it came from.
    pub reflected: u64,
}

impl ForgeryCount {
    /// Of whatever kind.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.noise + self.remade + self.misdirected + self.reflected
    }
}

impl FaultCount {
    /// Whether every datagram is accounted for.
    #[must_use]
    pub fn is_balanced(&self) -> bool {
        self.sent + self.duplicated + self.replayed + self.forged.total()
            == self.delivered + self.lost + self.under_way
    }
}

impl std::ops::Add for ForgeryCount {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            noise: self.noise + other.noise,
            remade: self.remade + other.remade,
            misdirected: self.misdirected + other.misdirected,
            reflected: self.reflected + other.reflected,
        }
    }
}

impl std::ops::Add for FaultCount {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            sent: self.sent + other.sent,
            lost: self.lost + other.lost,
            burst_lost: self.burst_lost + other.burst_lost,
            dropped: self.dropped + other.dropped,
            duplicated: self.duplicated + other.duplicated,
            corrupted: self.corrupted + other.corrupted,
            truncated: self.truncated + other.truncated,
            reordered: self.reordered + other.reordered,
            late: self.late + other.late,
            replayed: self.replayed + other.replayed,
            forged: self.forged + other.forged,
            delivered: self.delivered + other.delivered,
            under_way: self.under_way + other.under_way,
        }
    }
}
