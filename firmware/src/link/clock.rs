//! The fleet clock as a module knows it: offset and drift of its own clock, from four-timestamp exchanges.
//!
//! ```text
//!   module   t1 ──────────────────────── t4      own clock
//!               ╲ request        reply ╱
//!   host          t2 ──────────────── t3         fleet clock
//! ```
//!
//! t3 − t4 ≤ offset ≤ t2 − t1   (offset = fleet clock less own clock)
//!
//! as in NTP (RFC 5905, §8), each way for itself: the best of either direction is kept for 16 blocks of time
//! (`blocks`), offset and drift are what fits best between these two half planes (`estimate`), and what is told
//! follows at once, or while a cycle runs by at most 500 ppm beside the drift (`output`). Between exchanges the clock
//! goes on at the drift it knows.
//!
//! Two figures say how wrong the time told may be (`known`). [`hard_bound`](FleetClock::hard_bound) is never exceeded,
//! however unequal the two ways: it is half the least delay if they are equal. [`uncertainty`](FleetClock::uncertainty)
//! is not exceeded in 99 % of the time **if the delays of both ways are random in the same manner**. A difference that
//! is always there, of cable, queue or polling, cannot be observed; only the hard bound covers it. Both grow with the
//! time since the last exchange, so that a later `local` asks how sure the clock will still be then.
//!
//! An exchange that cannot be on the same two clocks as those before (no offset within 300 ppm of drift is left, or it
//! is better than they by far more than they leave open) means that one of the clocks jumped: the clock restarts from
//! it, unsure.
//!
//! Simulated, loops at 1 kHz at both ends, 120 s, pauses by [`exchange_pause`](FleetClock::exchange_pause) for 1 ms; from
//! the moment it is sure within 1 ms for the first time (`cargo test -p firmware clock::evaluation -- --nocapture`):
//!
//! | delay each way, loss, drift | sure after, median (95 %) | of 100 | error, median | 99 % | skew of two, 99.9 % | within uncertainty | not sure again | exchanges/s |
//! |---|---|---|---|---|---|---|---|---|
//! | **20 ± 15 ms, 10 % each way, 50 ppm** | 5.4 (16) s | 100 | 0.14 ms | 0.70 ms | 1.45 ms | 99.7 % | 13 % | 14 |
//! | no delay, none | 0.2 (0.2) | 100 | 0.01 | 0.50 | 1.01 | 100 % | 0 % | 5 |
//! | 1 ± 0.5 ms | 1.3 (1) | 100 | 0.05 | 0.52 | 1.05 | 99.9 % | 4 % | 6 |
//! | 20 ± 15 ms, 30 % | 13 (45) | 100 | 0.15 | 0.79 | 1.77 | 99.7 % | 19 % | 16 |
//! | 2 ms and exponential, mean 10 ms | 2.0 (3) | 100 | 0.10 | 0.63 | 1.36 | 99.4 % | 5 % | 11 |
//! | 20 ± 15 ms, 100 ppm | 5.5 (17) | 100 | 0.16 | 0.84 | 1.80 | 99.8 % | 11 % | 14 |
//! | 20 ± 15 ms, no drift | 5.3 (16) | 100 | 0.17 | 0.46 | 0.90 | 100 % | 5 % | 8 |
//! | 20 ± 15 ms, 50 ppm and 1 ppm/min | 5.4 (16) | 100 | 0.14 | 0.66 | 1.26 | 99.7 % | 15 % | 14 |
//! | 2 ms and the sum of three exponentials, 5 ms each | 9.4 (82) | 99 | 0.33 | 1.28 | 2.02 | **94 %** | 50 % | 19 |
//!
//! Where nothing but polling is random, half a turn of the loops (0.5 ms) is what remains. The last row has no sharp
//! lower edge of its delays, and the clock is then surer than it should be. Over the first link one in eight
//! samples after the first sure one is not sure any more: what is claimed wavers around 1 ms.
//!
//! Assumptions and limits: quartz on both sides, 300 ppm between them at most, 60 ppm likely, 1 ppm/min of wander
//! (*assumed*); a stamp is not taken more than 100 µs before what it stamps has come (*assumed*), or the hard bound is too
//! low by that much. A jump smaller than what is left open, or than the delays' spread, shifts the time by half of it
//! unseen, until the window has passed: say so by [`disturbed`](FleetClock::disturbed). A host that begins a new epoch
//! looks like contradiction: call [`reset`](FleetClock::reset) for a new session. What is told is integer, the
//! estimate in `f32`. 808 bytes; on a PC 15 µs an exchange and 4 ns to ask
//! the time.

mod blocks;
mod estimate;
mod exact;
mod known;
mod output;
mod told;

use protocol::time::{Duration, FleetInstant, LocalInstant};

use blocks::{Block, Blocks, Sight};
use estimate::{DRIFT_MAX_PPM, Estimate, Prior, SURE_NORMAL};
use exact::{micros, whole};
use known::{Known, middle_us};
use output::Output;
use told::Told;

/// Exchanges needed before fleet time is trusted.
pub const NEEDED: usize = 4;

/// The longest delay of an exchange that still says something: 1 s.
const DELAY_MAX_US: u64 = 1_000_000;

/// By how much stamps may contradict each other: they are taken beside the sending, not by it. *Assumed.*
const STAMP_US: i64 = 100;

/// Blocks from which on their scatter says something; with fewer than the second, what was known before may say more.
const BLOCKS_NEEDED: usize = 6;
const BLOCKS_FEW: usize = 8;

/// What the drift wanders within a window: 2 ppm. *Assumed.*
const WANDER_PPM: f32 = 2.0;

/// Pauses between exchanges: while there is something to learn, then at least and at most.
const PAUSE_LEARNING: Duration = Duration(50_000);
const PAUSE_MIN_US: f32 = 100_000.0;
const PAUSE_MAX_US: f32 = 1_000_000.0;

/// One exchange: request and reply, each with the times it was sent and received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// t1: the module sent the request, own clock.
    pub request_sent: LocalInstant,
    /// t2: the host received it, fleet clock.
    pub request_received: FleetInstant,
    /// t3: the host sent the reply, fleet clock.
    pub reply_sent: FleetInstant,
    /// t4: the module received it, own clock.
    pub reply_received: LocalInstant,
}

impl Exchange {
    /// What both directions saw; nothing if its times cannot be.
    fn sights(&self) -> Option<Block> {
        let (t1, t4) = (self.request_sent.0, self.reply_received.0);
        let (t2, t3) = (self.request_received.0, self.reply_sent.0);
        // delay = (t4 − t1) − (t3 − t2); negative: the host claims to have taken longer than the exchange
        let delay_us = t4.checked_sub(t1)?.checked_sub(t3.checked_sub(t2)?)?;
        if delay_us > DELAY_MAX_US {
            return None;
        }
        let difference = |a: u64, b: u64| i64::try_from(a).ok()?.checked_sub(i64::try_from(b).ok()?);
        let forward = Sight { at_us: t1, offset_us: difference(t2, t1)? };
        let backward = Sight { at_us: t4, offset_us: difference(t3, t4)? };
        Some(Block { forward, backward, count: 1 })
    }
}

/// Own clock to fleet clock and back.
#[derive(Clone, Debug)]
pub struct FleetClock {
    blocks: Blocks,
    prior: Prior,
    known: Option<Known>,
    exchanges: usize,
    /// The own clock may have jumped at this time: requests sent before it say nothing.
    disturbed_us: u64,
    told: Told,
}

impl Default for FleetClock {
    fn default() -> Self {
        Self::new()
    }
}

impl FleetClock {
    /// A clock that knows nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            blocks: Blocks::new(),
            prior: Prior::QUARTZ,
            known: None,
            exchanges: 0,
            disturbed_us: 0,
            told: Told::new(),
        }
    }

    /// Takes an exchange in; while `busy`, a cycle runs and the time told is slewed, by at most 500 ppm beside the
    /// drift, where else it may step. False if its times cannot be (a reply before its request, more than one second
    /// of delay), or it came twice, ended before the last or began before a disturbance: it is then left out.
    // Out of line, as what is opened before is: the stack takes the larger of both, not their sum.
    #[inline(never)]
    pub fn add(&mut self, exchange: &Exchange, busy: bool) -> bool {
        let Some(sights) = exchange.sights() else { return false };
        self.told.forget();
        let (at_us, request_us) = (sights.backward.at_us, sights.forward.at_us);
        if request_us < self.disturbed_us {
            return false;
        }
        let Some(known) = self.known else {
            self.begin(sights, None);
            return true;
        };
        if at_us < known.at_us || request_us == known.request_us {
            return false;
        }
        let mut now = known.later(at_us);
        let [high_us, low_us] = now.bounds_us;
        let (high_us, low_us) =
            (high_us.min(sights.forward.offset_us), low_us.max(sights.backward.offset_us));
        if low_us.saturating_sub(high_us) > STAMP_US || known.is_surprised_by(&sights) {
            self.begin(sights, busy.then_some(&known.output));
            return true;
        }
        now.request_us = request_us;
        now.bounds_us = [high_us, low_us.min(high_us)];
        self.exchanges = self.exchanges.saturating_add(1);
        self.blocks.add(sights, known.drift_ppb);
        if self.blocks.len() == 1 {
            self.remember(&now);
        }
        self.estimate(&mut now);
        now.output = if busy {
            known.output.slewed(at_us, now.offset_us, now.drift_ppb)
        } else {
            Output::at_once(at_us, now.offset_us, now.drift_ppb)
        };
        self.known = Some(now);
        true
    }

    /// Forgets everything: a new session, a new epoch.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Says that the own clock may have jumped by as much as `by` when it showed `local`. The time told goes on; it is
    /// that much less sure, until new exchanges alone are surer.
    pub fn disturbed(&mut self, local: LocalInstant, by: Duration) {
        self.disturbed_us = self.disturbed_us.max(local.0);
        let Some(known) = self.known.as_mut() else { return };
        let by_us = i64::from(by.0);
        let [high_us, low_us] = known.bounds_us;
        known.bounds_us = [high_us.saturating_add(by_us), low_us.saturating_sub(by_us)];
        known.unsure_us += micros(by_us);
        let known = *known;
        self.blocks.clear();
        self.remember(&known);
    }

    /// Fleet time at `local` on the own clock. Nothing before the first exchange, or where it does not fit.
    #[must_use]
    pub fn fleet(&self, local: LocalInstant) -> Option<FleetInstant> {
        let known = self.known.as_ref()?;
        self.told
            .or_else(local, || local.0.checked_add_signed(known.output.offset_us(local.0)).map(FleetInstant))
    }

    /// Own time at `fleet` on the fleet clock, to 1 µs. Nothing before the first exchange, or where it does not fit.
    #[must_use]
    pub fn local(&self, fleet: FleetInstant) -> Option<LocalInstant> {
        let output = &self.known.as_ref()?.output;
        let mut local_us = fleet.0;
        // An error shrinks to less than a thousandth each time.
        for _ in 0..6 {
            local_us = fleet.0.checked_add_signed(output.offset_us(local_us).checked_neg()?)?;
        }
        Some(LocalInstant(local_us))
    }

    /// True from [`NEEDED`] good exchanges on.
    #[must_use]
    pub const fn is_synchronised(&self) -> bool {
        self.exchanges >= NEEDED
    }

    /// What the error of [`fleet`](Self::fleet) at `local` stays within in 99 % of the time, if the delays of both ways
    /// are random in the same manner. It counts in what is still to be slewed and is never above the hard bound.
    #[must_use]
    pub fn uncertainty(&self, local: LocalInstant) -> Option<Duration> {
        Some(span(self.known.as_ref()?.uncertainty_us(local.0)))
    }

    /// What the error of [`fleet`](Self::fleet) at `local` is never above, whatever the delays.
    #[must_use]
    pub fn hard_bound(&self, local: LocalInstant) -> Option<Duration> {
        Some(span(self.known.as_ref()?.hard_us(local.0)))
    }

    /// True if synchronised and uncertain by no more than `within` at `local`, which may lie ahead.
    #[must_use]
    pub fn is_sure(&self, local: LocalInstant, within: Duration) -> bool {
        self.is_synchronised() && self.uncertainty(local).is_some_and(|unsure| unsure <= within)
    }

    /// How much faster the fleet clock runs than the own one, 10⁻⁹; 0 as long as that is not known.
    #[must_use]
    pub fn drift_ppb(&self) -> i32 {
        self.known.as_ref().map_or(0, |known| known.drift_ppb)
    }

    /// How long to wait from `local` to the next exchange: 50 ms until sure within half of `wanted` but for what
    /// exchanges cannot mend, then 100 ms, up to 1 s with the third power of how much surer it is.
    #[must_use]
    pub fn exchange_pause(&self, local: LocalInstant, wanted: Duration) -> Duration {
        let Some(known) = self.known.as_ref().filter(|_| self.is_synchronised()) else {
            return PAUSE_LEARNING;
        };
        let unsure_us = known.unsure_us(local.0).min(micros(known.hard_us(local.0)));
        let room = 0.5 * micros(i64::from(wanted.0)) / unsure_us.max(1.0);
        if room < 1.0 {
            return PAUSE_LEARNING;
        }
        span(whole((PAUSE_MIN_US * room * room * room).min(PAUSE_MAX_US)))
    }

    /// Begins from one exchange; what is told goes on from `from` if it must.
    fn begin(&mut self, sights: Block, from: Option<&Output>) {
        self.blocks.clear();
        self.blocks.add(sights, 0);
        self.prior = Prior::QUARTZ;
        self.exchanges = 1;
        self.known = Some(Known::of(&sights, from));
    }

    /// Whatever becomes of the exchanges, the drift is known.
    fn remember(&mut self, known: &Known) {
        if known.unsure_us < f32::INFINITY {
            self.prior = Prior {
                drift_ppm: micros(i64::from(known.drift_ppb)) * 1e-3,
                deviation_ppm: known.unsure_ppm.min(Prior::QUARTZ.deviation_ppm),
            };
        }
    }

    /// Corrects what is known by what the blocks say.
    fn estimate(&self, now: &mut Known) {
        let reference_us = middle_us(now.bounds_us);
        let found = Estimate::of(self.blocks.iter(), now.at_us, reference_us, self.prior);
        let blocks = self.blocks.len();
        let unsure_us = if blocks < BLOCKS_NEEDED { f32::INFINITY } else { found.unsure_us };
        if blocks >= BLOCKS_FEW || unsure_us <= now.unsure_us {
            let above_us = |us: f32| reference_us.saturating_add(whole(us));
            let drift_ppb = whole(found.drift_ppm.clamp(-DRIFT_MAX_PPM, DRIFT_MAX_PPM) * 1e3);
            now.offset_us = above_us(found.offset_us);
            now.edges_us = found.edges_us.map(above_us);
            now.drift_ppb = i32::try_from(drift_ppb).unwrap_or(0);
            now.unsure_us = unsure_us;
            now.unsure_ppm = SURE_NORMAL * found.drift_deviation_ppm + WANDER_PPM;
        }
        let [high_us, low_us] = now.bounds_us;
        now.offset_us = now.offset_us.min(high_us).max(low_us);
    }
}

fn span(us: i64) -> Duration {
    Duration(u32::try_from(us.max(0)).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod evaluation;
#[cfg(test)]
mod tests;
