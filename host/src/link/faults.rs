//! Faults as middleware: wraps any [`Radio`] and loses, delays, reorders, duplicates and damages what it sends.
//!
//! Everything is drawn from one seeded generator, so that a seed reproduces a run.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use protocol::Radio;
use protocol::units::{Micros, MicrosSpan};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::quantity::{ParameterError, Range, check_ranges};

/// How bad the medium is. The default is a perfect one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultParameters {
    /// Share of datagrams that vanish, 0–1.
    pub loss: f64,
    /// Share of datagrams that arrive twice, 0–1.
    pub duplication: f64,
    /// Share of datagrams that arrive with one bit flipped, 0–1.
    pub corruption: f64,
    /// Least time under way, s.
    pub delay_s: f64,
    /// Up to this much more, uniformly drawn for each datagram, s. Longer than the gap between two datagrams, it
    /// reorders them.
    pub jitter_s: f64,
}

impl FaultParameters {
    /// Refuses shares outside 0–1 and delays that are negative or not numbers.
    ///
    /// # Errors
    /// [`ParameterError`] names the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges(&[
            ("loss", self.loss, "(share)", Range::Share),
            ("duplication", self.duplication, "(share)", Range::Share),
            ("corruption", self.corruption, "(share)", Range::Share),
            ("delay_s", self.delay_s, "s", Range::NonNegative),
            ("jitter_s", self.jitter_s, "s", Range::NonNegative),
        ])
    }
}

/// What the medium did to the datagrams handed to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FaultCount {
    /// Handed over.
    pub sent: u64,
    /// Vanished.
    pub lost: u64,
    /// Doubled.
    pub duplicated: u64,
    /// Damaged.
    pub corrupted: u64,
}

impl std::ops::Add for FaultCount {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            sent: self.sent + other.sent,
            lost: self.lost + other.lost,
            duplicated: self.duplicated + other.duplicated,
            corrupted: self.corrupted + other.corrupted,
        }
    }
}

/// One datagram under way. Ordered by arrival, then by the order of sending.
#[derive(Debug)]
struct Flight<Address> {
    due: Micros,
    order: u64,
    to: Address,
    datagram: Vec<u8>,
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

/// A radio with faults on its sending side.
#[derive(Debug)]
pub struct Faulty<R: Radio> {
    radio: R,
    parameters: FaultParameters,
    rng: ChaCha8Rng,
    under_way: BinaryHeap<Reverse<Flight<R::Address>>>,
    order: u64,
    count: FaultCount,
}

impl<R: Radio> Faulty<R> {
    /// Wraps `radio`; `seed` decides every fault.
    pub fn new(radio: R, parameters: FaultParameters, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { radio, parameters, rng, under_way: BinaryHeap::new(), order: 0, count: FaultCount::default() }
    }

    /// What it did so far.
    pub fn count(&self) -> FaultCount {
        self.count
    }

    fn launch(&mut self, now: Micros, to: R::Address, mut datagram: Vec<u8>) {
        if self.rng.random_bool(self.parameters.corruption) && !datagram.is_empty() {
            let bit = self.rng.random_range(0..datagram.len() * 8);
            datagram[bit / 8] ^= 1 << (bit % 8);
            self.count.corrupted += 1;
        }
        let delay_s = self.parameters.delay_s + self.parameters.jitter_s * self.rng.random::<f64>();
        let due = now.after(MicrosSpan((delay_s * 1e6) as u32));
        self.order += 1;
        self.under_way.push(Reverse(Flight { due, order: self.order, to, datagram }));
    }

    /// Hands over everything that has arrived by `now`.
    fn deliver(&mut self, now: Micros) -> Result<(), R::Error> {
        while self.under_way.peek().is_some_and(|Reverse(flight)| flight.due <= now) {
            if let Some(Reverse(flight)) = self.under_way.pop() {
                self.radio.send(now, flight.to, &flight.datagram)?;
            }
        }
        Ok(())
    }
}

impl<R: Radio> Radio for Faulty<R> {
    type Address = R::Address;
    type Error = R::Error;

    fn send(&mut self, now: Micros, to: R::Address, datagram: &[u8]) -> Result<(), R::Error> {
        self.count.sent += 1;
        if self.rng.random_bool(self.parameters.loss) {
            self.count.lost += 1;
        } else {
            self.launch(now, to, datagram.to_vec());
            if self.rng.random_bool(self.parameters.duplication) {
                self.count.duplicated += 1;
                self.launch(now, to, datagram.to_vec());
            }
        }
        self.deliver(now)
    }

    fn receive(&mut self, now: Micros, buffer: &mut [u8]) -> Result<Option<(usize, R::Address)>, R::Error> {
        self.deliver(now)?;
        self.radio.receive(now, buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::super::loopback::{Ether, Node};
    use super::*;

    const HOST: Node = Node(0);
    const MODULE: Node = Node(1);

    /// Sends 0, 1, 2 … a millisecond apart and returns (arrival in ms, number) in order of arrival.
    fn flood(parameters: FaultParameters, seed: u64, datagrams: u32) -> (Vec<(u64, u32)>, FaultCount) {
        let ether = Ether::default();
        let mut host = Faulty::new(ether.radio(HOST), parameters, seed);
        let mut module = ether.radio(MODULE);
        let mut arrivals = Vec::new();
        for ms in 0..u64::from(datagrams) + 200 {
            let now = Micros(ms * 1000);
            if let Ok(number) = u32::try_from(ms)
                && number < datagrams
            {
                host.send(now, MODULE, &number.to_le_bytes()).unwrap();
            }
            let mut buffer = [0; 16];
            assert_eq!(host.receive(now, &mut buffer), Ok(None), "nobody sends to the host");
            while let Ok(Some((4, HOST))) = module.receive(now, &mut buffer) {
                arrivals.push((ms, u32::from_le_bytes(buffer[..4].try_into().unwrap())));
            }
        }
        (arrivals, host.count())
    }

    #[test]
    fn a_perfect_medium_changes_nothing() {
        let (arrivals, count) = flood(FaultParameters::default(), 1, 500);
        assert!(arrivals.iter().copied().eq((0..500).map(|number| (u64::from(number), number))));
        assert_eq!(count, FaultCount { sent: 500, ..FaultCount::default() });
    }

    #[test]
    fn every_datagram_is_accounted_for() {
        let parameters =
            FaultParameters { loss: 0.3, duplication: 0.1, corruption: 0.0, delay_s: 0.010, jitter_s: 0.050 };
        for seed in 0..5 {
            let (arrivals, count) = flood(parameters, seed, 5_000);
            assert_eq!(arrivals.len() as u64, count.sent - count.lost + count.duplicated, "seed {seed}");
            let share = count.lost as f64 / count.sent as f64;
            assert!((share - 0.3).abs() < 0.03, "seed {seed}: lost {share}");
            assert!(arrivals.windows(2).any(|pair| pair[1].1 < pair[0].1), "seed {seed}: jitter reorders");
            for (ms, number) in arrivals {
                assert!(
                    (10..=61).contains(&(ms - u64::from(number))),
                    "seed {seed}: {number} came at {ms} ms"
                );
            }
        }
    }

    #[test]
    fn a_seed_reproduces_a_run() {
        let parameters = FaultParameters { loss: 0.2, corruption: 0.2, jitter_s: 0.02, ..Default::default() };
        assert_eq!(flood(parameters, 7, 300), flood(parameters, 7, 300));
        assert_ne!(flood(parameters, 7, 300), flood(parameters, 8, 300));
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let error = FaultParameters { loss: f64::NAN, ..Default::default() }.validate().unwrap_err();
        assert_eq!(error.key, "loss");
        let error = FaultParameters { delay_s: -1.0, ..Default::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "delay_s = -1 s: must be a finite number, zero or greater");
    }
}
