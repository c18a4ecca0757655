//! The cycle a module runs and the one it runs next.
//!
//! Two slots. A cycle is offered during the one before and begins exactly at its start on the fleet clock. When
//! nothing valid follows, the tail holds the end pose of what it ran: holding is the safe act. Offers are
//! idempotent, so the host may repeat them until they are acknowledged.
//!
//! | what comes | while a cycle runs | otherwise |
//! |---|---|---|
//! | offer | kept for its start, or refused with the reason | the same |
//! | [`hold`](Schedule::hold) | the running one is finished, the next dropped | the next is dropped |
//! | [`emergency_stop`](Schedule::emergency_stop) | freezes where the reference is, refuses offers until resumed | the same |
//!
//! Decided here:
//! - A number names a cycle once. The same number with other content is refused, even before its start: an
//!   acknowledgement already given must stay true. A host that changes its mind holds first; the hold forgets
//!   the cycle that has not started, and its number is free again.
//! - Numbers only go up. What follows a hold may skip numbers.
//! - A cycle that runs, or ran last, and is offered again is a duplicate, so that a lost acknowledgement can
//!   be given again.
//!
//! Assumptions and limits: time is fleet time, always an argument. Should the fleet clock step back by less
//! than a cycle, the tail steps back with it; [`clock`](crate::clock) bounds that step. A pose is compared on the circle
//! ([`POSE_TOLERANCE`]), so a reference may step by whole turns where one cycle follows another.

use core::fmt;

use protocol::units::{Micros, MicrosSpan, Radians};

use crate::cycle::{Phase, SwimCycle};
use crate::limits::{Limits, Violation};
use crate::reference::{Reference, wrap};

/// How far ahead of its start a cycle may be offered: 10 s. A start farther off is more likely a wrong clock.
pub const HORIZON: MicrosSpan = MicrosSpan(10_000_000);

/// How far the start pose of a cycle may lie from the end pose of what precedes it, on the circle. At 0.02 rad
/// a tail of 0.1 m moves 2 mm.
pub const POSE_TOLERANCE: Radians = Radians(0.02);

/// What became of an offer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Held, to begin at its start.
    Accepted,
    /// Held already, with the same content.
    Duplicate,
    /// Not taken.
    Refused(Refusal),
}

/// Why an offer was not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// An emergency stop is in force.
    Stopped,
    /// The same number is held with other content.
    Conflict,
    /// A cycle of this number, or a later one, has begun before.
    AlreadyRun {
        /// Number of the latest cycle that began.
        latest: u32,
    },
    /// Another cycle waits for its start.
    Full {
        /// Its number.
        held: u32,
    },
    /// It breaks a limit.
    Limit(Violation),
    /// Its start has passed.
    Late {
        /// How long ago.
        by: MicrosSpan,
    },
    /// Its start lies beyond the [`HORIZON`].
    TooFarAhead {
        /// How far beyond.
        by: MicrosSpan,
    },
    /// It would begin before the running cycle ends.
    Overlap {
        /// How long before.
        by: MicrosSpan,
    },
    /// It sets out from elsewhere than the tail will be.
    PoseMismatch {
        /// Pose at its start if it is not taken, in (−π, π].
        expected: Radians,
        /// Pose it sets out from, in (−π, π].
        offered: Radians,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped => write!(f, "an emergency stop is in force"),
            Self::Conflict => write!(f, "its number is held with other content"),
            Self::AlreadyRun { latest } => write!(f, "cycle {latest} has begun already"),
            Self::Full { held } => write!(f, "cycle {held} waits for its start"),
            Self::Limit(violation) => violation.fmt(f),
            Self::Late { by } => write!(f, "late by {} µs", by.0),
            Self::TooFarAhead { by } => write!(f, "too far ahead by {} µs", by.0),
            Self::Overlap { by } => write!(f, "begins {} µs before the running cycle ends", by.0),
            Self::PoseMismatch { expected, offered } => {
                write!(f, "sets out from {} rad where the tail will be at {} rad", offered.0, expected.0)
            }
        }
    }
}

impl core::error::Error for Refusal {}

/// The slots for the running and the next cycle, and where the tail rests when both are empty.
#[derive(Clone, Debug)]
pub struct Schedule {
    limits: Limits,
    rest_rad: f32,
    /// The cycle that began last. It stays after its end, as the pose to hold and to recognise duplicates.
    current: Option<SwimCycle>,
    next: Option<SwimCycle>,
    latest: Option<u32>,
    stopped: bool,
}

impl Schedule {
    /// An empty schedule that rests at `pose`: where the tail was found at boot. A pose that is not finite
    /// counts as zero.
    #[must_use]
    pub fn new(limits: Limits, pose: Radians) -> Self {
        Self { limits, rest_rad: pose_or_zero(pose), current: None, next: None, latest: None, stopped: false }
    }

    /// Takes a cycle for its start, or says why not. `now` is fleet time.
    pub fn offer(&mut self, now: Micros, cycle: SwimCycle) -> Verdict {
        self.settle(now);
        if self.stopped {
            return Verdict::Refused(Refusal::Stopped);
        }
        let held = [&self.current, &self.next].into_iter().flatten().find(|c| c.number() == cycle.number());
        if let Some(held) = held {
            return if *held == cycle { Verdict::Duplicate } else { Verdict::Refused(Refusal::Conflict) };
        }
        match self.admit(now, &cycle) {
            Ok(()) => {
                self.next = Some(cycle);
                Verdict::Accepted
            }
            Err(refusal) => Verdict::Refused(refusal),
        }
    }

    /// The checks on a cycle that is not held, cheapest and most telling first.
    fn admit(&self, now: Micros, cycle: &SwimCycle) -> Result<(), Refusal> {
        if let Some(latest) = self.latest.filter(|latest| cycle.number() <= *latest) {
            return Err(Refusal::AlreadyRun { latest });
        }
        if let Some(next) = &self.next {
            return Err(Refusal::Full { held: next.number() });
        }
        self.limits.check(cycle).map_err(Refusal::Limit)?;
        if cycle.start() < now {
            return Err(Refusal::Late { by: now.since(cycle.start()) });
        }
        let horizon = now.after(HORIZON);
        if cycle.start() > horizon {
            return Err(Refusal::TooFarAhead { by: cycle.start().since(horizon) });
        }
        if let Some(current) = self.current.as_ref().filter(|c| c.end() > cycle.start()) {
            return Err(Refusal::Overlap { by: current.end().since(cycle.start()) });
        }
        let (expected, offered) = (self.pose_at_end(), cycle.start_pose());
        let apart_rad = libm::fabsf(wrap(offered.0 - expected.0));
        if apart_rad <= POSE_TOLERANCE.0 { Ok(()) } else { Err(Refusal::PoseMismatch { expected, offered }) }
    }

    /// What the tail is to do at `now` (fleet time).
    #[must_use]
    pub fn reference(&self, now: Micros) -> Reference {
        match self.active(now) {
            Some(cycle) => cycle.reference(now),
            None => Reference::at_rest(self.rest_rad),
        }
    }

    /// Number of the cycle that is being run at `now` (fleet time), if any.
    #[must_use]
    pub fn running(&self, now: Micros) -> Option<u32> {
        self.active(now)
            .filter(|cycle| matches!(cycle.phase(now), Phase::Turning | Phase::Swimming))
            .map(SwimCycle::number)
    }

    /// Number of the cycle that began last by `now` (fleet time), whether it still runs or not.
    #[must_use]
    pub fn latest(&self, now: Micros) -> Option<u32> {
        self.active(now).map(SwimCycle::number)
    }

    /// A schedule that has run nothing and rests where this one's reference is at `now` (fleet time): for another
    /// epoch of fleet time. A stop in force stays in force.
    #[must_use]
    pub fn anew(&self, now: Micros) -> Self {
        let rest = Radians(self.reference(now).angle_rad);
        Self { stopped: self.stopped, ..Self::new(self.limits, rest) }
    }

    /// The cycle that waits for its start at `now` (fleet time), if any.
    #[must_use]
    pub fn waiting(&self, now: Micros) -> Option<&SwimCycle> {
        self.next.as_ref().filter(|next| next.start() > now)
    }

    /// Where the tail will rest when everything held has been run, in (−π, π].
    #[must_use]
    pub fn pose_at_end(&self) -> Radians {
        self.next.as_ref().or(self.current.as_ref()).map_or(Radians(self.rest_rad), SwimCycle::end_pose)
    }

    /// Drops what has not begun by `now` (fleet time). A running cycle is finished and its end pose held.
    pub fn hold(&mut self, now: Micros) {
        self.settle(now);
        self.next = None;
    }

    /// Freezes the reference where it is at `now` (fleet time), drops everything and refuses offers until
    /// [`resume`](Self::resume).
    pub fn emergency_stop(&mut self, now: Micros) {
        self.settle(now);
        if self.stopped {
            return;
        }
        self.rest_rad = wrap(self.reference(now).angle_rad);
        self.current = None;
        self.next = None;
        self.stopped = true;
    }

    /// True from an emergency stop to [`resume`](Self::resume).
    #[must_use]
    pub const fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Ends an emergency stop; the tail rests at `pose`, where it was found. Without a stop in force nothing
    /// changes, and neither does the pose if it is not finite.
    pub fn resume(&mut self, pose: Radians) {
        if self.stopped {
            self.stopped = false;
            if pose.is_finite() {
                self.rest_rad = wrap(pose.0);
            }
        }
    }

    /// The cycle that decides the reference at `now`.
    fn active(&self, now: Micros) -> Option<&SwimCycle> {
        self.next.as_ref().filter(|next| next.start() <= now).or(self.current.as_ref())
    }

    /// Moves a cycle that has begun by `now` into the slot of the running one.
    fn settle(&mut self, now: Micros) {
        if let Some(begun) = self.next.take_if(|next| next.start() <= now) {
            self.latest = Some(begun.number());
            self.current = Some(begun);
        }
    }
}

fn pose_or_zero(pose: Radians) -> f32 {
    if pose.is_finite() { wrap(pose.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waveform::Waveform;
    use proptest::prelude::*;
    use std::vec::Vec;

    const T: MicrosSpan = MicrosSpan(1_500_000);
    const T_TRANS: MicrosSpan = MicrosSpan(500_000);

    /// Cycle that ends at φ₀ + A and sets out from φ₀ + A − rotation.
    fn cycle(number: u32, start: u64, centerline: f32, amplitude: f32, rotation: f32) -> SwimCycle {
        let waveform = Waveform::new(Radians(centerline), Radians(amplitude), T);
        SwimCycle::new(number, Micros(start), Radians(rotation), T_TRANS, waveform)
    }

    fn schedule() -> Schedule {
        Schedule::new(Limits::default(), Radians(0.0))
    }

    fn refused(verdict: Verdict) -> Refusal {
        match verdict {
            Verdict::Refused(refusal) => refusal,
            other => panic!("expected a refusal, got {other:?}"),
        }
    }

    #[test]
    fn begins_each_cycle_at_its_start_and_holds_when_none_follows() {
        let mut schedule = schedule();
        assert_eq!(schedule.reference(Micros(0)), Reference::at_rest(0.0));
        let (first, second) = (cycle(1, 1_000_000, 0.5, 1.0, 1.5), cycle(2, 3_000_000, 2.5, -1.0, 0.0));
        assert_eq!(schedule.offer(Micros(0), first), Verdict::Accepted);
        assert_eq!(schedule.running(Micros(999_999)), None);
        assert_eq!(schedule.waiting(Micros(999_999)).map(SwimCycle::number), Some(1));
        assert_eq!(schedule.reference(Micros(999_999)), Reference::at_rest(0.0));
        assert_eq!(schedule.running(Micros(1_000_000)), Some(1));
        assert_eq!(schedule.offer(Micros(1_200_000), second), Verdict::Accepted);
        assert_eq!(schedule.running(Micros(2_999_999)), Some(1));
        assert_eq!(schedule.reference(Micros(2_999_999)), first.reference(Micros(2_999_999)));
        assert_eq!(schedule.running(Micros(3_000_000)), Some(2));
        assert_eq!(schedule.reference(Micros(4_000_000)), second.reference(Micros(4_000_000)));
        assert_eq!(schedule.running(Micros(5_000_000)), None);
        assert_eq!(schedule.reference(Micros(u64::MAX)), Reference::at_rest(1.5));
        assert_eq!(schedule.pose_at_end(), Radians(1.5));
    }

    #[test]
    fn says_why_it_refuses() {
        let mut schedule = schedule();
        let now = Micros(20_000_000);
        assert_eq!(
            refused(schedule.offer(now, cycle(5, 19_999_000, 1.0, -1.0, 0.0))),
            Refusal::Late { by: MicrosSpan(1000) }
        );
        assert_eq!(
            refused(schedule.offer(now, cycle(5, 30_000_007, 1.0, -1.0, 0.0))),
            Refusal::TooFarAhead { by: MicrosSpan(7) }
        );
        assert!(matches!(
            refused(schedule.offer(now, cycle(5, 20_000_000, 1.0, 3.0, 0.0))),
            Refusal::Limit(Violation::Amplitude(_))
        ));
        assert!(matches!(
            refused(schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.03, 0.0))),
            Refusal::PoseMismatch { expected: Radians(0.0), offered } if (offered.0 + 0.03).abs() < 1e-6
        ));
        assert_eq!(schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.0, 0.0)), Verdict::Accepted);
        let now = Micros(20_000_001);
        assert_eq!(schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.0, 0.0)), Verdict::Duplicate);
        assert_eq!(refused(schedule.offer(now, cycle(5, 23_000_000, 1.0, -1.0, 0.0))), Refusal::Conflict);
        assert_eq!(
            refused(schedule.offer(now, cycle(4, 23_000_000, 1.0, -1.0, 0.0))),
            Refusal::AlreadyRun { latest: 5 }
        );
        assert_eq!(
            refused(schedule.offer(now, cycle(6, 21_999_000, 1.0, -1.0, 0.0))),
            Refusal::Overlap { by: MicrosSpan(1000) }
        );
        assert_eq!(schedule.offer(now, cycle(6, 22_000_000, 1.0, -1.0, 0.0)), Verdict::Accepted);
        assert_eq!(
            refused(schedule.offer(now, cycle(7, 24_000_000, 1.0, -1.0, 0.0))),
            Refusal::Full { held: 6 }
        );
        // The running one and the waiting one are both recognised.
        assert_eq!(schedule.offer(now, cycle(5, 20_000_000, 1.0, -1.0, 0.0)), Verdict::Duplicate);
        assert_eq!(schedule.offer(now, cycle(6, 22_000_000, 1.0, -1.0, 0.0)), Verdict::Duplicate);
    }

    #[test]
    fn poses_are_compared_on_the_circle() {
        let mut schedule = Schedule::new(Limits::default(), Radians(3.135));
        // Sets out from −3.135 rad: 0.0132 rad away across the seam.
        assert_eq!(schedule.offer(Micros(0), cycle(1, 0, -4.135, 1.0, 0.0)), Verdict::Accepted);
    }

    #[test]
    fn a_hold_finishes_what_runs_and_frees_the_number_of_what_waits() {
        let mut schedule = schedule();
        let running = cycle(1, 0, 1.0, -1.0, 0.0);
        assert_eq!(schedule.offer(Micros(0), running), Verdict::Accepted);
        assert_eq!(schedule.offer(Micros(10), cycle(2, 2_000_000, 1.0, -1.0, 0.0)), Verdict::Accepted);
        schedule.hold(Micros(1_000_000));
        assert_eq!(schedule.reference(Micros(1_500_000)), running.reference(Micros(1_500_000)));
        assert_eq!(schedule.running(Micros(2_500_000)), None);
        assert_eq!(schedule.reference(Micros(2_500_000)), Reference::at_rest(0.0));
        assert_eq!(schedule.offer(Micros(2_500_000), cycle(2, 3_000_000, -1.0, 1.0, 0.0)), Verdict::Accepted);
    }

    #[test]
    fn an_emergency_stop_freezes_at_once_and_keeps_everything_out() {
        let mut schedule = schedule();
        let running = cycle(3, 0, 1.0, -1.0, 0.0);
        assert_eq!(schedule.offer(Micros(0), running), Verdict::Accepted);
        let now = Micros(1_000_000);
        let frozen = Reference::at_rest(running.reference(now).angle_rad);
        assert!(frozen.angle_rad > 0.4, "the test stops it in mid swing");
        schedule.emergency_stop(now);
        assert!(schedule.is_stopped());
        assert_eq!(schedule.reference(Micros(1_000_001)), frozen);
        assert_eq!(schedule.running(Micros(1_000_001)), None);
        schedule.emergency_stop(Micros(1_100_000));
        assert_eq!(schedule.reference(Micros(5_000_000)), frozen);
        assert_eq!(
            refused(schedule.offer(Micros(5_000_000), cycle(4, 6_000_000, 1.0, -1.0, 0.0))),
            Refusal::Stopped
        );
        schedule.resume(Radians(0.6));
        assert_eq!(schedule.reference(Micros(5_000_000)), Reference::at_rest(0.6));
        assert_eq!(
            refused(schedule.offer(Micros(5_000_000), cycle(3, 6_000_000, 1.6, -1.0, 0.0))),
            Refusal::AlreadyRun { latest: 3 }
        );
        assert_eq!(schedule.offer(Micros(5_000_000), cycle(4, 6_000_000, 1.6, -1.0, 0.0)), Verdict::Accepted);
    }

    /// Arguments of a plausible cycle: its number and start relative to what went before, and its motion.
    fn steps() -> impl Strategy<Value = Vec<(u32, u32, f32, f32, f32, u8)>> {
        let step = (0_u32..3, 0_u32..2_500_000, -3.0_f32..3.0, 0.9_f32..2.6, -6.0_f32..6.0, 0_u8..12);
        proptest::collection::vec(step, 1..40)
    }

    proptest! {
        /// A host that follows the module's pose: whatever it offers, held or stopped in between, the reference
        /// never steps faster than the speed limit allows, no cycle runs outside its time, and what is
        /// offered twice changes nothing.
        #[test]
        fn reference_is_continuous_and_punctual(steps in steps()) {
            const TICK_US: u64 = 1000;
            let mut schedule = schedule();
            let (mut now, mut number) = (0_u64, 0_u32);
            let mut accepted: Vec<SwimCycle> = Vec::new();
            let mut last = schedule.reference(Micros(now));
            // What the tolerance let through of the last accepted cycle.
            let mut apart_rad = 0.0;
            for (advance, wait, centerline, amplitude, rotation, event) in steps {
                number += advance;
                // Sets out from where the tail will be.
                let start_rad = schedule.pose_at_end().0;
                let amplitude = if event % 2 == 0 { amplitude } else { -amplitude };
                let centerline = if event == 0 { centerline } else { start_rad + rotation - amplitude };
                let start = now + u64::from(wait);
                let offered = cycle(number, start, centerline, amplitude, rotation);
                let verdict = schedule.offer(Micros(now), offered);
                prop_assert!(verdict == Verdict::Accepted || event == 0 || !accepted.is_empty());
                if verdict == Verdict::Accepted {
                    accepted.push(offered);
                    apart_rad = wrap(offered.start_pose().0 - start_rad).abs();
                    prop_assert!(apart_rad <= POSE_TOLERANCE.0 && (event == 0 || apart_rad < 1e-5));
                    let before = schedule.clone();
                    prop_assert_eq!(schedule.offer(Micros(now), offered), Verdict::Duplicate);
                    prop_assert_eq!(schedule.reference(Micros(start + 1)), before.reference(Micros(start + 1)));
                }
                for _ in 0..1200 {
                    now += TICK_US;
                    let at = schedule.reference(Micros(now));
                    let step_rad = wrap(at.angle_rad - last.angle_rad).abs();
                    prop_assert!(step_rad <= 13.0 * 1e-3 + 1e-4 + apart_rad, "{step_rad} rad in one tick at {now} µs");
                    last = at;
                    if let Some(running) = schedule.running(Micros(now)) {
                        let it = accepted.iter().rfind(|c| c.number() == running).unwrap();
                        prop_assert!(it.start() <= Micros(now) && Micros(now) < it.end());
                    }
                }
                match event {
                    10 => schedule.hold(Micros(now)),
                    11 => {
                        schedule.emergency_stop(Micros(now));
                        last = schedule.reference(Micros(now));
                        schedule.resume(Radians(last.angle_rad));
                    }
                    _ => {}
                }
            }
        }

        #[test]
        fn takes_any_numbers(
            offers in proptest::collection::vec(any::<([u32; 3], [u32; 3], u64, u64, u8)>(), 1..20),
        ) {
            let mut schedule = Schedule::new(Limits::default(), Radians(f32::NAN));
            for (bits, [number, t_trans, period], start, now, event) in offers {
                let [c, a, r] = bits.map(|b| Radians(f32::from_bits(b)));
                let waveform = Waveform::new(c, a, MicrosSpan(period));
                let offered = SwimCycle::new(number, Micros(start), r, MicrosSpan(t_trans), waveform);
                schedule.offer(Micros(now), offered);
                match event % 8 {
                    0 => schedule.hold(Micros(now)),
                    1 => schedule.emergency_stop(Micros(now)),
                    2 => schedule.resume(c),
                    _ => {}
                }
                prop_assert!(schedule.reference(Micros(now)).is_finite());
                let _ = (schedule.running(Micros(now)), schedule.waiting(Micros(now)), schedule.pose_at_end());
            }
        }
    }
}
