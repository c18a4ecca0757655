//! Datagrams under way, in the order of their arrival.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use protocol::time::FleetInstant;

/// No more than this are under way at a time; what comes on top is lost. 32 MiB of the longest datagrams.
pub(super) const UNDER_WAY_MAX: usize = 1 << 16;

/// One datagram under way. Ordered by arrival, then by the order of sending.
#[derive(Debug)]
pub(super) struct Flight<Address> {
    due: FleetInstant,
    order: u64,
    pub(super) to: Address,
    pub(super) datagram: Vec<u8>,
}

impl<Address> PartialEq for Flight<Address> {
    fn eq(&self, other: &Self) -> bool {
        self.order == other.order
    }
}

impl<Address> Eq for Flight<Address> {}

impl<Address> PartialOrd for Flight<Address> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<Address> Ord for Flight<Address> {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.due, self.order).cmp(&(other.due, other.order))
    }
}

/// Everything under way.
#[derive(Debug)]
pub(super) struct UnderWay<Address> {
    flights: BinaryHeap<Reverse<Flight<Address>>>,
    order: u64,
}

impl<Address> UnderWay<Address> {
    pub(super) fn new() -> Self {
        Self { flights: BinaryHeap::new(), order: 0 }
    }

    pub(super) fn len(&self) -> u64 {
        self.flights.len() as u64
    }

    pub(super) fn is_full(&self) -> bool {
        self.flights.len() >= UNDER_WAY_MAX
    }

    /// Sends `datagram` on its way; it arrives `delay_s` after `now`.
    pub(super) fn launch(&mut self, now: FleetInstant, delay_s: f64, to: Address, datagram: Vec<u8>) {
        let due = FleetInstant(now.0.saturating_add((delay_s * 1e6) as u64));
        self.order += 1;
        self.flights.push(Reverse(Flight { due, order: self.order, to, datagram }));
    }

    /// The next that has arrived by `now`.
    pub(super) fn land(&mut self, now: FleetInstant) -> Option<Flight<Address>> {
        if self.flights.peek().is_none_or(|Reverse(flight)| flight.due > now) {
            return None;
        }
        self.flights.pop().map(|Reverse(flight)| flight)
    }

    /// Throws everything away: how many.
    pub(super) fn clear(&mut self) -> u64 {
        let dropped = self.len();
        self.flights.clear();
        dropped
    }
}
