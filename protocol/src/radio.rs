//! The [`Radio`] trait: the seam between the link and the medium that carries its datagrams.

use crate::time::FleetInstant;

/// A datagram carrier: UDP, the loopback of the tests, a modem. It may lose, delay, reorder and duplicate.
///
/// Nothing blocks. Time is an argument, so that a simulated carrier can hold a datagram back. It is fleet time, which the
/// medium of a simulation keeps for host and modules alike; a real carrier does without.
pub trait Radio {
    /// Where a datagram goes to or comes from.
    type Address: Copy + Eq + core::fmt::Debug;
    /// Why the carrier itself failed (not: why a datagram was lost).
    type Error;

    /// Hands `datagram` (at most [`MAX_DATAGRAM`](crate::MAX_DATAGRAM) bytes) to the carrier.
    ///
    /// # Errors
    /// The carrier's own; a datagram lost on the way is not an error.
    fn send(&mut self, now: FleetInstant, to: Self::Address, datagram: &[u8]) -> Result<(), Self::Error>;

    /// Takes the next datagram that has arrived by `now` into `buffer`: its length and where it came from, or
    /// `None` when there is none. A datagram longer than the buffer is cut.
    ///
    /// # Errors
    /// The carrier's own.
    fn receive(
        &mut self,
        now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, Self::Address)>, Self::Error>;
}
