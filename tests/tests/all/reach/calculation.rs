//! How surely a cycle arrives, calculated. Losses are independent, each of probability p; a send is of use when it arrives before the
//! start.
//!
//! ```text
//! direct     miss = Π (p + (1 − p)·P(tₖ + delay ≥ start))                 over the sends tₖ
//!            all  = (1 − miss)ᴺ
//! prepared   a send is answered with (1 − p)²; all are after k sends: Aₖ = (1 − (1 − (1 − p)²)ᵏ)ᴺ
//!            committed = A of the last send whose answer comes the commit lead before the start
//!            split     = Σ (Aₖ − Aₖ₋₁)·(1 − (1 − pᵐ)ᴺ − pᵐᴺ)              with the m commits that follow and arrive in time
//! ```
//!
//! | symbol | what | unit |
//! |---|---|---|
//! | p | share of datagrams lost, each way | |
//! | N | modules | |
//! | tₖ | time of the k-th send, from the first | µs |
//!
//! Limits: bursts of losses are no part of it. The host looks at its timers every [`TICK_US`], and so did the calculation.

use std::ops::RangeInclusive;

use link::delivery::{COMMIT_EVERY, RESEND_FIRST, RESEND_MAX};

/// Pause between two looks at the timers, µs.
pub const TICK_US: u64 = 1_000;

/// Uniformly drawn time under way, µs.
pub type DelayUs = RangeInclusive<u64>;

/// When a cycle is sent that is never answered, µs from the first time, until `lead_us`.
pub fn sends(lead_us: u64) -> Vec<u64> {
    let (mut at, mut pause) = (0, u64::from(RESEND_FIRST.0));
    let mut sends = vec![at];
    loop {
        at = (at + pause).next_multiple_of(TICK_US);
        if at >= lead_us {
            return sends;
        }
        sends.push(at);
        pause = (pause + pause / 5).min(u64::from(RESEND_MAX.0));
    }
}

/// Probability that one module has not got a cycle at its start.
pub fn miss(loss: f64, delay: &DelayUs, lead_us: u64) -> f64 {
    let span_us = (delay.end() - delay.start()) as f64;
    let in_time = |sent: u64| {
        let left_us = (lead_us - TICK_US) as f64 - (sent + delay.start()) as f64;
        if left_us < 0.0 {
            0.0
        } else if span_us > 0.0 {
            (left_us / span_us).min(1.0)
        } else {
            1.0
        }
    };
    sends(lead_us).into_iter().map(|sent| 1.0 - (1.0 - loss) * in_time(sent)).product()
}

/// 1 − (1 − miss)ᴺ, without losing small numbers.
pub fn any(miss: f64, modules: usize) -> f64 {
    -f64::exp_m1(modules as f64 * f64::ln_1p(-miss))
}

/// What becomes of a cycle that is prepared.
#[derive(Clone, Copy, Debug)]
pub struct TwoPhase {
    /// Probability that it is not committed: all modules hold.
    pub dropped: f64,
    /// Probability that it is committed and the commit reaches some, and not all.
    pub split: f64,
}

/// Of a prepared cycle, with the same delay of every datagram, that is not committed later than `commit_lead_us` before its start.
pub fn two_phase(loss: f64, delay_us: u64, lead_us: u64, commit_lead_us: u64, modules: usize) -> TwoPhase {
    let unanswered = 1.0 - (1.0 - loss).powi(2);
    // There and back, and the host looks a tick later.
    let round_us = 2 * delay_us + TICK_US;
    let (mut dropped, mut split, mut power) = (1.0, 0.0, 1.0);
    for sent in sends(lead_us) {
        let commit = sent + round_us;
        if commit + commit_lead_us > lead_us {
            break;
        }
        power *= unanswered;
        let still = any(power, modules);
        let last = lead_us - TICK_US - delay_us;
        let commits = if commit > last { 0 } else { (last - commit) / u64::from(COMMIT_EVERY.0) + 1 };
        let lost = loss.powi(commits as i32);
        split += (dropped - still) * (any(lost, modules) - lost.powi(modules as i32));
        dropped = still;
    }
    TwoPhase { dropped, split }
}

/// The least lead, in steps of 10 ms, with which `failure` is at most one in a million.
pub fn least_lead_us(failure: impl Fn(u64) -> f64) -> Option<u64> {
    (5..500).map(|step| step * 10_000).find(|&lead_us| failure(lead_us) <= 1e-6)
}
