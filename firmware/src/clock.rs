//! The fleet clock as a module knows it: its own clock plus an offset, from four-timestamp exchanges.
//!
//! ```text
//!   module   t1 ──────────────────────── t4      own clock
//!               ╲ request        reply ╱
//!   host          t2 ──────────────── t3         fleet clock
//! ```
//!
//! offset = ((t2 − t1) + (t3 − t4)) / 2,   delay = (t4 − t1) − (t3 − t2)
//!
//! as in NTP (RFC 5905, §8). However unequal the two ways are, the offset is wrong by at most half the delay, and by
//! what the clocks have drifted since: |error| ≤ delay/2 + age·100 ppm. The last eight exchanges are kept
//! and the one with the least bound is used; as all of them age alike, which one that is does not depend on
//! when one asks.
//!
//! Assumptions and limits: quartz on both sides, 100 ppm between them (*assumed*). Drift is bounded, not
//! estimated, and a better exchange moves fleet time by a step, forwards or backwards, of at most the sum of the two
//! bounds; at 1 ms and 11 rad/s a tail's reference then steps by 0.011 rad. A host that begins a new epoch looks
//! like contradiction: call [`reset`](FleetClock::reset) for a new session. All integers, saturating.

use heapless::Deque;
use protocol::units::{Micros, MicrosSpan};

/// Exchanges kept.
pub const KEPT: usize = 8;

/// Exchanges needed before fleet time is trusted.
pub const NEEDED: usize = 4;

/// Bound on the drift between two quartzes: 1 µs in this many (100 ppm). *Assumed.*
const DRIFT_DIVISOR: u64 = 10_000;

/// The longest delay of an exchange that still says something: 1 s.
const DELAY_MAX_US: u64 = 1_000_000;

/// One exchange: request and reply, each with the times it was sent and received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// t1: the module sent the request, own clock.
    pub request_sent: Micros,
    /// t2: the host received it, fleet clock.
    pub request_received: Micros,
    /// t3: the host sent the reply, fleet clock.
    pub reply_sent: Micros,
    /// t4: the module received it, own clock.
    pub reply_received: Micros,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Fleet clock less own clock, µs.
    offset_us: i64,
    delay_us: u64,
    /// t4, own clock.
    at: Micros,
}

impl Sample {
    /// From one exchange; nothing if its times cannot be.
    fn of(exchange: &Exchange) -> Option<Self> {
        let [t1, t2, t3, t4] =
            [exchange.request_sent, exchange.request_received, exchange.reply_sent, exchange.reply_received]
                .map(|t| t.0);
        // delay = (t4 − t1) − (t3 − t2); negative: the host claims to have taken longer than the exchange
        let delay_us = t4.checked_sub(t1)?.checked_sub(t3.checked_sub(t2)?)?;
        if delay_us > DELAY_MAX_US {
            return None;
        }
        // offset = ((t2 − t1) + (t3 − t4)) / 2
        let there_us = signed_difference(t2, t1)?;
        let back_us = signed_difference(t3, t4)?;
        let offset_us = there_us.checked_add(back_us)?.checked_div(2)?;
        Some(Self { offset_us, delay_us, at: exchange.reply_received })
    }

    /// |error| ≤ delay/2 + age·100 ppm, µs.
    fn bound_us(&self, local: Micros) -> u64 {
        let age_us = local.0.saturating_sub(self.at.0);
        // One more for the two divisions.
        self.delay_us.div_ceil(2).saturating_add(age_us.div_ceil(DRIFT_DIVISOR)).saturating_add(1)
    }
}

fn signed_difference(later: u64, earlier: u64) -> Option<i64> {
    i64::try_from(later).ok()?.checked_sub(i64::try_from(earlier).ok()?)
}

/// Own clock to fleet clock and back.
#[derive(Clone, Debug, Default)]
pub struct FleetClock {
    samples: Deque<Sample, KEPT>,
    best: Option<Sample>,
}

impl FleetClock {
    /// A clock that knows nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { samples: Deque::new(), best: None }
    }

    /// Takes an exchange in. False if its times cannot be (a reply before its request, more than one second of
    /// delay, older than the last): it is then left out.
    pub fn add(&mut self, exchange: &Exchange) -> bool {
        let Some(sample) = Sample::of(exchange) else { return false };
        if self.samples.back().is_some_and(|last| sample.at < last.at) {
            return false;
        }
        if self.samples.is_full() {
            self.samples.pop_front();
        }
        // Room was just made.
        let added = self.samples.push_back(sample).is_ok();
        self.best = self.samples.iter().min_by_key(|kept| kept.bound_us(sample.at)).copied();
        added
    }

    /// Forgets everything: a new session, a new epoch.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Fleet time at `local` on the own clock. Nothing before the first exchange, or where it does not fit.
    #[must_use]
    pub fn fleet(&self, local: Micros) -> Option<Micros> {
        local.0.checked_add_signed(self.best?.offset_us).map(Micros)
    }

    /// Own time at `fleet` on the fleet clock. Nothing before the first exchange, or where it does not fit.
    #[must_use]
    pub fn local(&self, fleet: Micros) -> Option<Micros> {
        fleet.0.checked_add_signed(self.best?.offset_us.checked_neg()?).map(Micros)
    }

    /// True from [`NEEDED`] good exchanges on.
    #[must_use]
    pub fn is_synchronised(&self) -> bool {
        self.samples.len() >= NEEDED
    }

    /// Bound on the error of [`fleet`](Self::fleet) at `local` on the own clock.
    #[must_use]
    pub fn uncertainty(&self, local: Micros) -> Option<MicrosSpan> {
        Some(MicrosSpan(u32::try_from(self.best?.bound_us(local)).unwrap_or(u32::MAX)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn exchange(t1: u64, t2: u64, t3: u64, t4: u64) -> Exchange {
        Exchange {
            request_sent: Micros(t1),
            request_received: Micros(t2),
            reply_sent: Micros(t3),
            reply_received: Micros(t4),
        }
    }

    #[test]
    fn hand_worked_exchange() {
        let mut clock = FleetClock::new();
        assert_eq!(clock.fleet(Micros(5)), None);
        assert_eq!(clock.uncertainty(Micros(5)), None);
        // Offset 1 000 000, 300 µs there, 500 µs back, 50 µs at the host: half of 200 µs is what it cannot see.
        assert!(clock.add(&exchange(10_000, 1_010_300, 1_010_350, 10_850)));
        assert_eq!(clock.fleet(Micros(10_850)), Some(Micros(1_010_750)));
        assert_eq!(clock.local(Micros(1_010_750)), Some(Micros(10_850)));
        assert_eq!(clock.uncertainty(Micros(10_850)), Some(MicrosSpan(401)));
        assert_eq!(clock.uncertainty(Micros(1_010_850)), Some(MicrosSpan(501)));
    }

    #[test]
    fn the_least_delay_wins_until_it_is_too_old() {
        let mut clock = FleetClock::new();
        // Delay 100, offset 1000.
        assert!(clock.add(&exchange(0, 1050, 1050, 100)));
        for k in 1..8_u64 {
            // Delay 2000, all of it on the way there: offset 2000 where it is 1000.
            let t1 = k * 1_000_000;
            assert!(clock.add(&exchange(t1, t1 + 3000, t1 + 3000, t1 + 2000)));
            assert_eq!(clock.fleet(Micros(t1)), Some(Micros(t1 + 1000)), "exchange {k}");
            assert_eq!(clock.is_synchronised(), k >= 3);
        }
        let t1 = 8_000_000;
        assert!(clock.add(&exchange(t1, t1 + 3000, t1 + 3000, t1 + 2000)));
        assert_eq!(clock.fleet(Micros(t1)), Some(Micros(t1 + 2000)), "the good one has left the eight");
        clock.reset();
        assert!(!clock.is_synchronised() && clock.fleet(Micros(t1)).is_none());
    }

    #[test]
    fn leaves_out_what_cannot_be() {
        let mut clock = FleetClock::new();
        for (what, bad) in [
            ("reply before request", exchange(100, 1000, 1000, 99)),
            ("the host sent before it received", exchange(0, 1000, 999, 500)),
            ("the host took longer than the exchange", exchange(0, 1000, 1501, 500)),
            ("two seconds of delay", exchange(0, 1000, 1000, 2_000_000)),
            ("out of range", exchange(0, u64::MAX, u64::MAX, 500)),
        ] {
            assert!(!clock.add(&bad), "{what}");
        }
        assert!(clock.add(&exchange(5000, 5000, 5000, 5010)));
        assert!(!clock.add(&exchange(1000, 1000, 1000, 1010)), "older than the last");
        assert_eq!(clock.fleet(Micros(6000)), Some(Micros(5995)));
    }

    proptest! {
        /// Unequal delays and 80 ppm of drift: the error stays within what the clock says of itself.
        #[test]
        fn error_is_within_the_stated_bound(
            offset in -1_000_000_000_i64..1_000_000_000_000,
            drift_ppm in -80_i64..80,
            ways in proptest::collection::vec((0_u64..20_000, 0_u64..20_000, 0_u64..500, 1_u64..2_000_000), 1..20),
        ) {
            let fleet_of = |local: u64| {
                let local = i64::try_from(local).unwrap();
                u64::try_from(local + offset + local * drift_ppm / 1_000_000).unwrap()
            };
            let mut clock = FleetClock::new();
            let mut local = 2_000_000_000_u64;
            for (there, host, back, pause) in ways {
                let t4 = local + there + host + back;
                let (t2, t3) = (fleet_of(local + there), fleet_of(local + there + host));
                prop_assert!(clock.add(&exchange(local, t2, t3, t4)));
                local = t4 + pause;
                let told = clock.fleet(Micros(local)).unwrap().0;
                let bound = u64::from(clock.uncertainty(Micros(local)).unwrap().0);
                prop_assert!(told.abs_diff(fleet_of(local)) <= bound + 2, "{told} ± {bound}");
                let back_again = clock.local(Micros(told)).unwrap();
                prop_assert_eq!(back_again, Micros(local));
            }
        }

        #[test]
        fn takes_any_numbers(times in proptest::collection::vec(any::<[u64; 4]>(), 1..20), local in any::<u64>()) {
            let mut clock = FleetClock::new();
            for [t1, t2, t3, t4] in times {
                clock.add(&exchange(t1, t2, t3, t4));
                let _ = (clock.fleet(Micros(local)), clock.local(Micros(local)), clock.uncertainty(Micros(local)));
            }
        }
    }
}
