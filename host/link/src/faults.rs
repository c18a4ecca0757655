//! Faults as middleware: wraps any [`Radio`] and loses, delays, reorders, duplicates, damages, replays and forges what
//! it sends.
//!
//! | file | what |
//! |---|---|
//! | `parameters` | how bad the medium is, from the table `[radio]` |
//! | `count` | what it did, exactly |
//! | `burst` | losses that come together |
//! | `flight` | what is under way |
//! | `stranger` | what is recorded, replayed and forged |
//!
//! Everything is drawn from one seed, so that a seed reproduces a run: what befalls a datagram, the bursts and the
//! stranger each have a stream of their own. A fault beyond loss, duplication, corruption and jitter draws nothing while
//! it is off, so that it leaves the runs without it as they were.
//!
//! A burst takes everything sent while it lasts, a replay or a forgery too. `loss` is of what was handed over alone, as
//! are damage and spikes; replays and forgeries come through as they were made, after the usual delay. A replay or a
//! forgery can follow on any datagram handed over, lost or not; recorded are those that were not lost, before damage.

mod burst;
mod count;
mod flight;
mod parameters;
mod stranger;
#[cfg(test)]
mod tests;

use protocol::Radio;
use protocol::time::FleetInstant;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

pub use count::{FaultCount, ForgeryCount};
pub use parameters::FaultParameters;

use burst::Burst;
use flight::UnderWay;
use stranger::Stranger;

use super::spare::Spare;

/// A radio with faults on its sending side.
#[derive(Debug)]
pub struct Faulty<R: Radio> {
    radio: R,
    parameters: FaultParameters,
    rng: ChaCha8Rng,
    burst: Burst,
    stranger: Stranger<R::Address>,
    under_way: UnderWay<R::Address>,
    spare: Spare,
    count: FaultCount,
}

/// Whether a fault of probability `share` strikes. Draws nothing while it is off.
fn strikes(rng: &mut ChaCha8Rng, share: f64) -> bool {
    share > 0.0 && rng.random_bool(share)
}

impl<R: Radio> Faulty<R> {
    /// Wraps `radio`; `seed` decides every fault. Takes what [`FaultParameters::validate`] does not refuse.
    pub fn new(radio: R, parameters: FaultParameters, seed: u64) -> Self {
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(number);
            rng
        };
        Self {
            radio,
            parameters,
            rng: stream(0),
            burst: Burst::new(stream(1)),
            stranger: Stranger::new(stream(2)),
            under_way: UnderWay::new(),
            spare: Spare::default(),
            count: FaultCount::default(),
        }
    }

    /// What it did so far.
    pub fn count(&self) -> FaultCount {
        FaultCount { under_way: self.under_way.len(), ..self.count }
    }

    /// How bad the medium is at present.
    pub fn parameters(&self) -> &FaultParameters {
        &self.parameters
    }

    /// Changes the weather for what is sent from now on; what is under way arrives when it would have. What was
    /// recorded stays recorded.
    pub fn set_parameters(&mut self, parameters: FaultParameters) {
        self.parameters = parameters;
    }

    /// Makes the medium perfect from now on; with `drop_under_way`, what is still under way is lost.
    pub fn heal(&mut self, drop_under_way: bool) {
        self.parameters = FaultParameters::default();
        if drop_under_way {
            let dropped = self.under_way.clear();
            self.count.dropped += dropped;
            self.count.lost += dropped;
        }
    }

    /// Puts one copy of what was handed over under way, with whatever befalls it.
    fn launch(&mut self, now: FleetInstant, to: R::Address, datagram: &[u8]) {
        if self.is_full() {
            return;
        }
        let mut datagram = self.spare.copied(datagram);
        let p = &self.parameters;
        // Cut first: a flipped bit that is then cut off would be no flipped bit.
        if strikes(&mut self.rng, p.truncation) && !datagram.is_empty() {
            datagram.truncate(self.rng.random_range(0..datagram.len()));
            self.count.truncated += 1;
        }
        if self.rng.random_bool(p.corruption) && !datagram.is_empty() {
            let bit = self.rng.random_range(0..datagram.len() * 8);
            datagram[bit / 8] ^= 1 << (bit % 8);
            self.count.corrupted += 1;
        }
        let mut delay_s = p.delay_s + p.jitter_s * self.rng.random::<f64>();
        if strikes(&mut self.rng, p.reordering) {
            delay_s += p.reorder_s;
            self.count.reordered += 1;
        }
        if strikes(&mut self.rng, p.late) {
            delay_s += p.late_s * self.rng.random::<f64>();
            self.count.late += 1;
        }
        self.under_way.launch(now, delay_s, to, datagram);
    }

    /// What the stranger does on hearing that something is sent to `to`.
    fn intrude(&mut self, now: FleetInstant, to: R::Address, in_burst: bool) {
        let p = self.parameters;
        if strikes(&mut self.stranger.rng, p.replay)
            && let Some(datagram) = self.stranger.replay(to)
        {
            self.count.replayed += 1;
            let wait_s = p.replay_s * self.stranger.rng.random::<f64>();
            self.launch_strange(now, wait_s, to, datagram, in_burst);
        }
        if strikes(&mut self.stranger.rng, p.forgery) {
            let (to, datagram) = self.stranger.forge(to, &mut self.count);
            self.launch_strange(now, 0.0, to, datagram, in_burst);
        }
    }

    fn launch_strange(
        &mut self,
        now: FleetInstant,
        wait_s: f64,
        to: R::Address,
        datagram: Vec<u8>,
        in_burst: bool,
    ) {
        if in_burst {
            self.count.lost += 1;
            self.count.burst_lost += 1;
        } else if !self.is_full() {
            let jitter_s = self.parameters.jitter_s * self.stranger.rng.random::<f64>();
            self.under_way.launch(now, self.parameters.delay_s + jitter_s + wait_s, to, datagram);
        }
    }

    /// Whether one more cannot be under way; then counts it as dropped.
    fn is_full(&mut self) -> bool {
        let full = self.under_way.is_full();
        self.count.lost += u64::from(full);
        self.count.dropped += u64::from(full);
        full
    }

    /// Hands over everything that has arrived by `now`.
    fn deliver(&mut self, now: FleetInstant) -> Result<(), R::Error> {
        while let Some(flight) = self.under_way.land(now) {
            if let Err(error) = self.radio.send(now, flight.to, &flight.datagram) {
                self.count.lost += 1;
                return Err(error);
            }
            self.spare.take_back(flight.datagram);
            self.count.delivered += 1;
        }
        Ok(())
    }
}

impl<R: Radio> Radio for Faulty<R> {
    type Address = R::Address;
    type Error = R::Error;

    fn send(&mut self, now: FleetInstant, to: R::Address, datagram: &[u8]) -> Result<(), R::Error> {
        self.count.sent += 1;
        let lost = self.rng.random_bool(self.parameters.loss);
        let in_burst = self.burst.is_bad(now, &self.parameters);
        if lost || in_burst {
            self.count.lost += 1;
            self.count.burst_lost += u64::from(in_burst);
        } else {
            self.launch(now, to, datagram);
            if self.rng.random_bool(self.parameters.duplication) {
                self.count.duplicated += 1;
                self.launch(now, to, datagram);
            }
        }
        if self.parameters.replay > 0.0 || self.parameters.forgery > 0.0 {
            self.intrude(now, to, in_burst);
            if !lost && !in_burst {
                self.stranger.record_sent(to, datagram);
            }
        }
        self.deliver(now)
    }

    fn receive(
        &mut self,
        now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, R::Address)>, R::Error> {
        self.deliver(now)?;
        let received = self.radio.receive(now, buffer)?;
        if let Some((length, from)) = received
            && self.parameters.forgery > 0.0
        {
            self.stranger.record_received(from, &buffer[..length]);
        }
        Ok(received)
    }
}
