//! Lead of a cycle that goes to all modules or none: how long before its start it is sent first, and its commit at the latest.
//!
//! ```text
//!  dispatched                       all have answered        last commit that counts      start
//!   │ t₁ t₂ t₃ …              tₖ        │ │ │ │ │ │ … m commits      │                       │
//!   ├──── resent until answered ───────→├───────── commit lead C ────┴───── on its way ─────→│
//!   ╰──────────────────────────────── lead L ───────────────────────────────────────────────╯
//! ```
//!
//! A send is answered when it arrives and its answer does; the chance that it is not is uᵢ = 1 − (1 − pᵢ)(1 − qᵢ). After k sends some module has
//! not answered with probability 1 − Πᵢ(1 − uᵢᵏ) ≤ Σᵢ uᵢᵏ, and after m commits some module has none with at most Σᵢ pᵢᵐ (Boole's inequality). So
//!
//! ```text
//! k = least with Σᵢ uᵢᵏ ≤ ε_p          m = least with Σᵢ pᵢᵐ ≤ ε_c
//! C = max((m − 1)·COMMIT_EVERY + R + τ, COMMIT_LEAD)
//! L = tₖ + R + τ + C
//! R = SRTT + 4·RTTVAR                                                            RFC 6298, (2.3)
//! p̂ = x/n + 2·√(x/n·(1 − x/n)/n)                                                 one-sided normal interval, 97.7 %
//! ```
//!
//! | symbol | what | unit |
//! |---|---|---|
//! | pᵢ, qᵢ | share of datagrams lost on the way to module i, and from it: p̂ of what the ledger and the numbers of its datagrams say | |
//! | x, n | datagrams lost, and all, each forgotten with a half-life of [`HALF_LIFE`] updates | |
//! | tₖ | time of the k-th send, after the first ([`sends`]) | µs |
//! | R | round trip of cycles and their answers, over the fleet: mean and deviation | µs |
//! | τ | the host looks at its timers once in this time ([`TICK`]) | µs |
//! | ε_p | [`UNPREPARED`]: a cycle is not prepared in time, and dropped | |
//! | ε_c | [`UNCOMMITTED`]: it is committed, and the commit misses a module | |
//!
//! A datagram tells its receiver how many were seen when it was sent. So the round trip of an answer is that of the newest datagram that its
//! module had seen, whichever of the repeated ones that was, and losses do not lengthen it.
//!
//! Assumptions and limits: losses are independent of each other and of time; bursts longer than C defeat any repetition in it. What is
//! measured is the past: for some seconds after the weather has changed the bounds do not hold. With no loss so far nothing is expected to be lost. A
//! pilot bounds L by the length of a cycle, and beyond that no bound is kept.

use protocol::ledger::Outgoing;
use protocol::time::{Duration, FleetInstant};

use super::delivery::{COMMIT_EVERY, COMMIT_LEAD, RESEND_FIRST, next_pause};

/// ε_p: of so many cycles one may be dropped because a module has not answered in time. *Assumed*: a drop costs one pause.
pub const UNPREPARED: f64 = 1e-3;
/// ε_c: the same of a commit that some module misses: the others move without it. *Assumed*.
pub const UNCOMMITTED: f64 = 1e-6;
/// τ: pause between two looks at the timers.
pub const TICK: Duration = Duration(1_000);
/// More sends than this are not counted on: at 20 ms a lead of 4 s.
const SENDS_MAX: u32 = 200;
/// Pause between two updates of the losses. *Assumed.*
const UPDATE_EVERY: Duration = Duration(500_000);
/// Updates after which a loss counts half: 5 s. *Assumed*: three cycles.
pub const HALF_LIFE: f64 = 10.0;

/// Times of the sends of a cycle that is not answered, after the first, for a host that looks once in [`TICK`], µs.
pub fn sends() -> impl Iterator<Item = u64> {
    let mut next = (0, RESEND_FIRST);
    std::iter::repeat_with(move || {
        let (at, pause) = next;
        next = ((at + u64::from(pause.0)).next_multiple_of(u64::from(TICK.0)), next_pause(pause));
        at
    })
}

/// Share lost of what went one way: p̂ of the table above.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Loss {
    lost: f64,
    all: f64,
    /// Session and counts at the last update.
    last: (u32, u64, u64),
}

impl Loss {
    /// Takes in the counts of `session` so far.
    fn update(&mut self, session: u32, lost: u64, all: u64) {
        let (known, lost_before, all_before) = self.last;
        let (lost_before, all_before) = if known == session { (lost_before, all_before) } else { (0, 0) };
        self.last = (session, lost, all);
        let kept = 0.5_f64.powf(1.0 / HALF_LIFE);
        // One that was counted as lost may come after all.
        self.lost = (self.lost * kept + (lost as f64 - lost_before as f64)).max(0.0);
        self.all = self.all * kept + all.saturating_sub(all_before) as f64;
    }

    fn share(&self) -> f64 {
        if self.all < 1.0 || self.lost <= 0.0 {
            return 0.0;
        }
        let share = (self.lost / self.all).min(1.0);
        (share + 2.0 * (share * (1.0 - share) / self.all).sqrt()).min(1.0)
    }
}

/// Losses both ways of one module.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Losses {
    to_module: Loss,
    to_host: Loss,
    next_update: FleetInstant,
}

impl Losses {
    /// Takes in the counts of `session` at `now`: what became of what was sent, how many came, and how many must have been sent to this host.
    pub(super) fn update(
        &mut self,
        now: FleetInstant,
        session: u32,
        outgoing: &Outgoing,
        came: u32,
        seen: u32,
    ) {
        if now < self.next_update {
            return;
        }
        self.next_update = now.after(UPDATE_EVERY);
        self.to_module.update(session, outgoing.lost, outgoing.acknowledged + outgoing.late + outgoing.lost);
        self.to_host.update(session, u64::from(seen.saturating_sub(came)), u64::from(seen));
    }

    /// pᵢ and qᵢ.
    pub(super) fn shares(&self) -> [f64; 2] {
        [self.to_module.share(), self.to_host.share()]
    }
}

/// Mean and deviation of round trips, RFC 6298 (2.2), (2.3).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoundTrip {
    /// SRTT and RTTVAR, µs.
    smoothed_us: Option<(f64, f64)>,
}

impl RoundTrip {
    pub(super) fn add(&mut self, measured: Duration) {
        let measured_us = f64::from(measured.0);
        let (mean_us, deviation_us) =
            self.smoothed_us.map_or((measured_us, 0.5 * measured_us), |(mean_us, deviation_us)| {
                let off_us = (mean_us - measured_us).abs();
                (0.875 * mean_us + 0.125 * measured_us, 0.75 * deviation_us + 0.25 * off_us)
            });
        self.smoothed_us = Some((mean_us, deviation_us));
    }

    /// R; zero before the first.
    fn bound(&self) -> Duration {
        let bound_us = self.smoothed_us.map_or(0.0, |(mean_us, deviation_us)| mean_us + 4.0 * deviation_us);
        Duration(bound_us.min(1e7) as u32)
    }
}

/// The two parts of a lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lead {
    /// From the first send until every module has answered, with probability 1 − [`UNPREPARED`].
    pub prepare: Duration,
    /// C: from the first commit to the start.
    pub commit: Duration,
}

impl Lead {
    /// L.
    #[must_use]
    pub const fn total(&self) -> Duration {
        Duration(self.prepare.0.saturating_add(self.commit.0))
    }

    /// For modules with these losses pᵢ and qᵢ.
    pub(super) fn new(modules: impl Iterator<Item = [f64; 2]> + Clone, round_trip: &RoundTrip) -> Self {
        let round_us = round_trip.bound().0 + TICK.0;
        // k = least with Σᵢ uᵢᵏ ≤ ε_p
        let unanswered = modules.clone().map(|[p, q]| 1.0 - (1.0 - p) * (1.0 - q));
        let k = repeats(unanswered, UNPREPARED);
        // m = least with Σᵢ pᵢᵐ ≤ ε_c
        let m = repeats(modules.map(|[p, _]| p), UNCOMMITTED);
        let sent_us = sends().nth(k as usize - 1).unwrap_or(0);
        let commit = Duration((m - 1) * COMMIT_EVERY.0 + round_us).max(COMMIT_LEAD);
        Self { prepare: Duration(sent_us as u32 + round_us), commit }
    }
}

/// The least number of sends after which the sum of what each misses with is at most `most`.
fn repeats(misses: impl Iterator<Item = f64> + Clone, most: f64) -> u32 {
    (1..SENDS_MAX)
        .find(|&n| misses.clone().map(|miss| miss.powi(n as i32)).sum::<f64>() <= most)
        .unwrap_or(SENDS_MAX)
}

/// When the last datagrams of a session were sent, by number.
#[derive(Clone, Debug)]
pub(super) struct SentTimes([(u32, FleetInstant); Self::KEPT]);

impl SentTimes {
    /// *Assumed*: more than are on their way at once.
    const KEPT: usize = 32;

    pub(super) const fn new() -> Self {
        Self([(u32::MAX, FleetInstant(0)); Self::KEPT])
    }

    pub(super) fn sent(&mut self, now: FleetInstant, number: u32) {
        self.0[number as usize % Self::KEPT] = (number, now);
    }

    /// When number `number` was sent.
    pub(super) fn of(&self, number: u32) -> Option<FleetInstant> {
        let (known, at) = self.0[number as usize % Self::KEPT];
        (known == number).then_some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady(round_us: u32) -> RoundTrip {
        let mut round_trip = RoundTrip::default();
        (0..200).for_each(|_| round_trip.add(Duration(round_us)));
        round_trip
    }

    #[test]
    fn without_loss_one_send_and_the_least_commit_lead_are_enough() {
        let modules = [[0.0; 2]; 49];
        let lead = Lead::new(modules.into_iter(), &steady(2_000));
        assert_eq!(lead, Lead { prepare: Duration(3_000), commit: COMMIT_LEAD });
    }

    /// The bounds by counting out, with modules that differ.
    #[test]
    fn the_least_number_of_sends_is_taken() {
        for (worst, others) in [(0.4, 0.4), (0.3, 0.01), (0.8, 0.0), (0.05, 0.05)] {
            let modules = (0..25).map(|index| [if index == 0 { worst } else { others }; 2]);
            let miss = |of: &dyn Fn(f64) -> f64, n: i32| -> f64 {
                1.0 - modules.clone().map(|[p, _]| 1.0 - of(p).powi(n)).product::<f64>()
            };
            let unanswered = |p: f64| 1.0 - (1.0 - p) * (1.0 - p);
            let k = repeats(modules.clone().map(|[p, _]| unanswered(p)), UNPREPARED) as i32;
            assert!(miss(&unanswered, k) <= UNPREPARED, "{worst}, {others}: {k}");
            assert!(
                miss(&unanswered, k - 1) > 0.99 * UNPREPARED,
                "{worst}, {others}: {k} is more than is needed"
            );
            let m = repeats(modules.clone().map(|[p, _]| p), UNCOMMITTED) as i32;
            assert!(
                miss(&|p| p, m) <= UNCOMMITTED && miss(&|p| p, m - 1) > 0.99 * UNCOMMITTED,
                "{worst}, {others}: {m}"
            );
        }
    }

    #[test]
    fn what_is_lost_is_forgotten_and_what_comes_after_all_is_not_lost() {
        let mut loss = Loss::default();
        assert!(loss.share().abs() < 1e-12);
        loss.update(7, 30, 100);
        assert!((loss.share() - (0.3 + 2.0 * (0.3_f64 * 0.7 / 100.0).sqrt())).abs() < 1e-9);
        loss.update(7, 0, 100);
        assert!(loss.share().abs() < 1e-12);
        loss.update(7, 50, 200);
        let before = loss.share();
        (1..=100).for_each(|n| loss.update(8, 0, n * 50));
        assert!(loss.share() < 0.1 * before, "{} of {before}", loss.share());
    }

    #[test]
    fn a_round_trip_of_any_size_gives_a_bound() {
        assert_eq!(steady(20_000).bound(), Duration(20_000));
        let mut wild = RoundTrip::default();
        [0, u32::MAX, 0, u32::MAX].into_iter().for_each(|us| wild.add(Duration(us)));
        assert_eq!(wild.bound(), Duration(10_000_000));
        assert_eq!(RoundTrip::default().bound(), Duration(0));
    }
}
