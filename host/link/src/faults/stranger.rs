//! An attacker without keys that receives what passes, sends it again, and makes datagrams of its own.
//!
//! Recorded are the last [`RECORDED`] datagrams sent, while replay or forgery is on, and for reflection the last
//! [`RECORDED`] received, while forgery is; a record is kept however old it gets. Four kinds of forgery are drawn alike; where the record has nothing for a kind, noise takes
//! its place:
//!
//! | kind | what |
//! |---|---|
//! | noise | 1 to 512 random bytes |
//! | remade | a recorded datagram, up to four neighbouring bytes of its middle changed, its last four a right CRC-32 again |
//! | misdirected | a recorded datagram to another address |
//! | reflected | a received datagram back to whom it came from |
//!
//! A radio that speaks to one address only, like a module's, knows no other to misdirect to.

use std::collections::VecDeque;

use crc::{CRC_32_ISO_HDLC, Crc};
use protocol::MAX_DATAGRAM;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

use super::FaultCount;

/// How many datagrams are remembered in each direction.
pub(super) const RECORDED: usize = 256;

const CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
const CRC32_LEN: usize = 4;
/// What says of which kind a datagram is: changed, it would be turned away at the door.
const HEAD: usize = 2;
const CHANGED_MAX: usize = 4;

/// A datagram and the address at its other end.
type Recording<Address> = (Address, Vec<u8>);

#[derive(Debug)]
pub(super) struct Stranger<Address> {
    pub(super) rng: ChaCha8Rng,
    sent: VecDeque<Recording<Address>>,
    received: VecDeque<Recording<Address>>,
}

fn record<Address>(ring: &mut VecDeque<Recording<Address>>, peer: Address, datagram: &[u8]) {
    let oldest = if ring.len() < RECORDED { None } else { ring.pop_front() };
    let mut bytes = oldest.map(|(_, bytes)| bytes).unwrap_or_default();
    bytes.clear();
    bytes.extend_from_slice(datagram);
    ring.push_back((peer, bytes));
}

/// One of `candidates`, all alike.
fn draw<T>(rng: &mut ChaCha8Rng, mut candidates: impl Iterator<Item = T> + Clone) -> Option<T> {
    let number = candidates.clone().count();
    if number == 0 { None } else { candidates.nth(rng.random_range(0..number)) }
}

impl<Address: Copy + Eq> Stranger<Address> {
    pub(super) fn new(rng: ChaCha8Rng) -> Self {
        Self { rng, sent: VecDeque::new(), received: VecDeque::new() }
    }

    /// Records what is sent to `to`.
    pub(super) fn record_sent(&mut self, to: Address, datagram: &[u8]) {
        record(&mut self.sent, to, datagram);
    }

    /// Records what comes from `from`.
    pub(super) fn record_received(&mut self, from: Address, datagram: &[u8]) {
        record(&mut self.received, from, datagram);
    }

    /// An earlier datagram to `to`, if there is one.
    pub(super) fn replay(&mut self, to: Address) -> Option<Vec<u8>> {
        let earlier = self.sent.iter().filter(|(peer, _)| *peer == to);
        draw(&mut self.rng, earlier).map(|(_, datagram)| datagram.clone())
    }

    /// A forged datagram and where it goes; noise goes to `to`. Counts it by its kind.
    pub(super) fn forge(&mut self, to: Address, count: &mut FaultCount) -> (Address, Vec<u8>) {
        let forged = &mut count.forged;
        let (drawn, counter) = match self.rng.random_range(0..4) {
            0 => (self.remade(), &mut forged.remade),
            1 => (self.misdirected(), &mut forged.misdirected),
            2 => (draw(&mut self.rng, self.received.iter()).cloned(), &mut forged.reflected),
            _ => (None, &mut forged.noise),
        };
        if let Some(forgery) = drawn {
            *counter += 1;
            return forgery;
        }
        forged.noise += 1;
        let mut noise = vec![0; self.rng.random_range(1..=MAX_DATAGRAM)];
        self.rng.fill(&mut noise[..]);
        (to, noise)
    }

    fn remade(&mut self) -> Option<Recording<Address>> {
        let long_enough = self.sent.iter().filter(|(_, datagram)| datagram.len() > HEAD + CRC32_LEN);
        let (to, mut datagram) = draw(&mut self.rng, long_enough).cloned()?;
        let end = datagram.len() - CRC32_LEN;
        let first = self.rng.random_range(HEAD..end);
        let last = (first + self.rng.random_range(0..CHANGED_MAX)).min(end - 1);
        for byte in &mut datagram[first..=last] {
            *byte ^= self.rng.random_range(1..=u8::MAX);
        }
        let checksum = CRC32.checksum(&datagram[..end]);
        datagram[end..].copy_from_slice(&checksum.to_le_bytes());
        Some((to, datagram))
    }

    fn misdirected(&mut self) -> Option<Recording<Address>> {
        let (meant_for, datagram) = draw(&mut self.rng, self.sent.iter())?;
        let others = self.sent.iter().chain(&self.received).map(|(peer, _)| *peer);
        let to = draw(&mut self.rng, others.filter(|peer| peer != meant_for))?;
        Some((to, datagram.clone()))
    }
}
