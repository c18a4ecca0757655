//! The schedule of a Modboat: the cycle that it runs and the one that it runs next.
//!
//! Two slots. A cycle is offered during the one before and begins exactly at its start on the fleet clock. When
//! nothing valid follows, the tail holds the end pose of what it ran: holding is the safe act. Offers are
//! idempotent, so the host may repeat them until they are acknowledged.
//!
//! | what comes | while a cycle runs | otherwise |
//! |---|---|---|
//! | offer | kept for its start, or refused with the reason | the same |
//! | [`commit`](Schedule::commit) | the prepared one may begin at its start | the same |
//! | [`hold`](Schedule::hold) | the running one is finished, the next dropped | the next is dropped |
//! | [`emergency_stop`](Schedule::emergency_stop) | freezes where the reference is, refuses offers until resumed | the same |
//!
//! Decided here:
//! - A number names a cycle once. The same number with other content is refused, even before its start: an
//!   acknowledgement already given must stay true. A host that changes its mind holds first; the hold forgets
//!   the cycle that has not started, and its number is free again.
//! - Numbers only go up. What follows a hold may skip numbers.
//! - A cycle that needs a commit and has none at its start is forgotten, and the tail holds: [`Delivery::Prepare`]. Until
//!   then one of a greater number may take its place; no module runs it, so no promise is broken.
//! - A cycle that runs, or ran last, and is offered again is a duplicate, so that a lost acknowledgement can
//!   be given again.
//!
//! Assumptions and limits: time is fleet time, always an argument. Should the fleet clock step back by less
//! than a cycle, the tail steps back with it; [`clock`](crate::link::clock) bounds that step. A pose is compared on the circle
//! ([`POSE_TOLERANCE`]), so a reference may step by whole turns where one cycle follows another.

use core::fmt;

use protocol::Delivery;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Radians;

use crate::modboat::cycle::{Phase, SwimCycle};
use crate::modboat::limits::{self, Violation};
use crate::modboat::reference::{Reference, wrap};
use protocol::configuration::TailLimits;

/// How far ahead of its start a cycle may be offered: 10 s. A start farther off is more likely a wrong clock.
pub const HORIZON: Duration = Duration(10_000_000);

/// How far the start pose of a cycle may lie from the end pose of what precedes it, on the circle. At 0.02 rad
/// a tail of 0.1 m moves 2 mm.
pub const POSE_TOLERANCE: Radians = Radians(0.02);

/// What became of an offer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Held, to begin at its start.
    Accepted,
    /// Held, to begin at its start if it is committed by then.
    Prepared,
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
    /// A commit for a cycle that is not held.
    NotPrepared,
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
        by: Duration,
    },
    /// Its start lies beyond the [`HORIZON`].
    TooFarAhead {
        /// How far beyond.
        by: Duration,
    },
    /// It would begin before the running cycle ends.
    Overlap {
        /// How long before.
        by: Duration,
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
            Self::NotPrepared => write!(f, "it is not held"),
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

/// A cycle before its start.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    cycle: SwimCycle,
    committed: bool,
}

/// The slots for the running and the next cycle, and where the tail rests when both are empty.
#[derive(Clone, Debug)]
pub struct Schedule {
    limits: TailLimits,
    rest_rad: f32,
    /// The cycle that began last. It stays after its end, as the pose to hold and to recognise duplicates.
    current: Option<SwimCycle>,
    next: Option<Waiting>,
    latest: Option<u32>,
    stopped: bool,
}

impl Schedule {
    /// An empty schedule that rests at `pose`: where the tail was found at boot. A pose that is not finite
    /// counts as zero.
    #[must_use]
    pub fn new(limits: TailLimits, pose: Radians) -> Self {
        Self { limits, rest_rad: pose_or_zero(pose), current: None, next: None, latest: None, stopped: false }
    }

    /// Takes a cycle for its start, or says why not. `now` is fleet time.
    pub fn offer(&mut self, now: FleetInstant, cycle: SwimCycle, delivery: Delivery) -> Verdict {
        self.settle(now);
        if self.stopped {
            return Verdict::Refused(Refusal::Stopped);
        }
        let next = self.next.map(|next| (next.cycle, next.committed));
        let held = [self.current.map(|cycle| (cycle, true)), next].into_iter().flatten();
        let number = cycle.number();
        if let Some((held, committed)) = held.into_iter().find(|(held, _)| held.number() == number) {
            return match (held == cycle, committed) {
                (false, _) => Verdict::Refused(Refusal::Conflict),
                (true, true) => Verdict::Duplicate,
                (true, false) => Verdict::Prepared,
            };
        }
        let committed = delivery == Delivery::Direct;
        match self.admit(now, &cycle) {
            Ok(()) => {
                self.next = Some(Waiting { cycle, committed });
                if committed { Verdict::Accepted } else { Verdict::Prepared }
            }
            Err(refusal) => Verdict::Refused(refusal),
        }
    }

    /// Whether the cycle with this number waits, runs or ran last.
    #[must_use]
    pub fn knows(&self, number: u32) -> bool {
        let next = self.next.as_ref().map(|next| &next.cycle);
        self.current.iter().chain(next).any(|held| held.number() == number)
    }

    /// Lets the prepared cycle with this number run, if its start has not come. `now` is fleet time.
    pub fn commit(&mut self, now: FleetInstant, number: u32) -> Verdict {
        self.settle(now);
        if self.stopped {
            return Verdict::Refused(Refusal::Stopped);
        }
        if self.current.is_some_and(|current| current.number() == number) {
            return Verdict::Duplicate;
        }
        match self.next.as_mut().filter(|next| next.cycle.number() == number) {
            Some(next) if next.committed => Verdict::Duplicate,
            Some(next) => {
                next.committed = true;
                Verdict::Accepted
            }
            None => Verdict::Refused(Refusal::NotPrepared),
        }
    }

    /// The checks on a cycle that is not held, cheapest and most telling first.
    fn admit(&self, now: FleetInstant, cycle: &SwimCycle) -> Result<(), Refusal> {
        if let Some(latest) = self.latest.filter(|latest| cycle.number() <= *latest) {
            return Err(Refusal::AlreadyRun { latest });
        }
        if let Some(next) = self.next.filter(|next| next.committed || next.cycle.number() > cycle.number()) {
            return Err(Refusal::Full { held: next.cycle.number() });
        }
        limits::check(&self.limits, cycle).map_err(Refusal::Limit)?;
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
        // What waits without a commit would be replaced: the tail will be where the one before it ends.
        let before = self.current.map_or(Radians(self.rest_rad), |current| current.end_pose());
        let (expected, offered) = (before, cycle.start_pose());
        let apart_rad = libm::fabsf(wrap(offered.0 - expected.0));
        if apart_rad <= POSE_TOLERANCE.0 { Ok(()) } else { Err(Refusal::PoseMismatch { expected, offered }) }
    }

    /// What the tail is to do at `now` (fleet time).
    #[must_use]
    pub fn reference(&self, now: FleetInstant) -> Reference {
        match self.active(now) {
            Some(cycle) => cycle.reference(now),
            None => Reference::at_rest(self.rest_rad),
        }
    }

    /// Number of the cycle that is being run at `now` (fleet time), if any.
    #[must_use]
    pub fn running(&self, now: FleetInstant) -> Option<u32> {
        self.active(now)
            .filter(|cycle| matches!(cycle.phase(now), Phase::Turning | Phase::Swimming))
            .map(SwimCycle::number)
    }

    /// The steps of speed, rad/s, in the transition of the cycle that is being run at `now` (fleet time).
    #[must_use]
    pub fn speed_step_rad_s(&self, now: FleetInstant) -> f32 {
        let runs = |cycle: &&SwimCycle| cycle.start() <= now && now < cycle.end();
        self.active(now).filter(runs).map_or(0.0, |cycle| cycle.transition().speed_step_rad_s())
    }

    /// Number of the cycle that began last by `now` (fleet time), whether it still runs or not.
    #[must_use]
    pub fn latest(&self, now: FleetInstant) -> Option<u32> {
        self.active(now).map(SwimCycle::number)
    }

    /// A schedule that has run nothing and rests where this one's reference is at `now` (fleet time): for another
    /// epoch of fleet time. A stop in force stays in force.
    #[must_use]
    pub fn for_new_epoch(&self, now: FleetInstant) -> Self {
        let rest = Radians(self.reference(now).angle_rad);
        Self { stopped: self.stopped, ..Self::new(self.limits, rest) }
    }

    /// The cycle that waits for its start at `now` (fleet time), if any.
    #[must_use]
    pub fn waiting(&self, now: FleetInstant) -> Option<&SwimCycle> {
        self.next.as_ref().map(|next| &next.cycle).filter(|next| next.start() > now)
    }

    /// Whether it waits for a commit too.
    #[must_use]
    pub fn is_uncommitted(&self, now: FleetInstant) -> bool {
        self.next.is_some_and(|next| next.cycle.start() > now && !next.committed)
    }

    /// Where the tail will rest when everything that is sure to run has been run, in (−π, π].
    #[must_use]
    pub fn pose_at_end(&self) -> Radians {
        let next = self.next.as_ref().filter(|next| next.committed).map(|next| &next.cycle);
        next.or(self.current.as_ref()).map_or(Radians(self.rest_rad), SwimCycle::end_pose)
    }

    /// Drops what has not begun by `now` (fleet time). A running cycle is finished and its end pose held.
    pub fn hold(&mut self, now: FleetInstant) {
        self.settle(now);
        self.next = None;
    }

    /// Freezes the reference where it is at `now` (fleet time), drops everything and refuses offers until
    /// [`resume`](Self::resume).
    pub fn emergency_stop(&mut self, now: FleetInstant) {
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
    fn active(&self, now: FleetInstant) -> Option<&SwimCycle> {
        let begun = self.next.as_ref().filter(|next| next.committed && next.cycle.start() <= now);
        begun.map(|next| &next.cycle).or(self.current.as_ref())
    }

    /// Moves a cycle that has begun by `now` into the slot of the running one; without a commit it is forgotten.
    fn settle(&mut self, now: FleetInstant) {
        if let Some(begun) = self.next.take_if(|next| next.cycle.start() <= now).filter(|next| next.committed)
        {
            self.latest = Some(begun.cycle.number());
            self.current = Some(begun.cycle);
        }
    }
}

fn pose_or_zero(pose: Radians) -> f32 {
    if pose.is_finite() { wrap(pose.0) } else { 0.0 }
}

#[cfg(test)]
mod tests;
