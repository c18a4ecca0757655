//! Replay window: which sequence numbers of a session have come, each once, in any order, but not from too far back.
//!
//! ```text
//!   newest − 127 … newest         the window: a bit for each number
//!   older                         stale: whether it came before is not known any more
//! ```
//!
//! As in IPsec (RFC 4303, §3.4.3). Ask only after the tag was right, or strangers could move the window.

/// How far behind the newest a datagram may come and still be followed.
pub const WINDOW: u32 = 128;

/// What a sequence number is to the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arrival {
    /// It had not come.
    Fresh {
        /// Something newer came before it.
        overtaken: bool,
    },
    /// It had come.
    Duplicate,
    /// From before the window.
    Stale,
}

/// Replay window: the sequence numbers of a session that have arrived.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Window {
    newest: Option<u32>,
    /// Bit k: newest − k has come.
    came: u128,
}

impl Window {
    /// Before anything has come.
    #[must_use]
    pub const fn new() -> Self {
        Self { newest: None, came: 0 }
    }

    /// The greatest number that has come.
    #[must_use]
    pub const fn newest(&self) -> Option<u32> {
        self.newest
    }

    /// Notes that `sequence` has come, and says what it is.
    pub fn note(&mut self, sequence: u32) -> Arrival {
        let Some(newest) = self.newest else {
            (self.newest, self.came) = (Some(sequence), 1);
            return Arrival::Fresh { overtaken: false };
        };
        if sequence > newest {
            self.came = self.came.checked_shl(sequence.saturating_sub(newest)).unwrap_or(0) | 1;
            self.newest = Some(sequence);
            return Arrival::Fresh { overtaken: false };
        }
        let Some(bit) = 1_u128.checked_shl(newest.saturating_sub(sequence)) else { return Arrival::Stale };
        if self.came & bit != 0 {
            return Arrival::Duplicate;
        }
        self.came |= bit;
        Arrival::Fresh { overtaken: true }
    }
}
