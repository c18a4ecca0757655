//! The seam between everything that talks and whatever carries it.

use crate::units::Micros;

/// A datagram carrier: UDP, the loopback of the tests, a modem. It may lose, delay, reorder and duplicate.
///
/// Nothing blocks. Time is an argument, so that a simulated carrier can hold a datagram back.
pub trait Radio {
    /// Where a datagram goes to or comes from.
    type Address: Copy + Eq + core::fmt::Debug;
    /// Why the carrier itself failed (not: why a datagram was lost).
    type Error;

    /// Hands `datagram` (at most [`MAX_DATAGRAM`](crate::MAX_DATAGRAM) bytes) to the carrier.
    ///
    /// # Errors
    /// The carrier's own; a datagram lost on the way is not an error.
    fn send(&mut self, now: Micros, to: Self::Address, datagram: &[u8]) -> Result<(), Self::Error>;

    /// Takes the next datagram that has arrived by `now` into `buffer`: its length and where it came from, or
    /// `None` when there is none. A datagram longer than the buffer is cut.
    ///
    /// # Errors
    /// The carrier's own.
    fn receive(
        &mut self,
        now: Micros,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, Self::Address)>, Self::Error>;
}
