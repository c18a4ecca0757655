//! Homing: the search for the tail's zero after boot, where the encoder is not absolute.
//!
//! d = min(ω_h/ω₀, [`DRIVE_MAX`])   counter-clockwise, without feedback, until the index is seen
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | d | drive, share of the supply | |
//! | ω_h, ω₀ | homing speed of the configuration; no-load speed of the motor | rad/s |
//!
//! With ω_h = 0, the default of `flotilla provision`, the motor stays off until the operator has turned the tail over its magnet: no person is
//! hit. Otherwise the module waits first, so that a person can step back and docked modules can take turns. So weak a drive
//! stops at whatever it meets.
//!
//! Turned by hand, it waits past the index until the tail has been still for [`STILL_FOR`]: a hand that turns it further is no following error.
//!
//! Assumptions and limits: the tail passes the index within [`TURNS`] turns at ω_h, or it is given up: the module stops, blind. A module
//! that homes sends nothing yet, so no plan includes it; what a tail beside it does meanwhile is not asked.

use core::f32::consts::TAU;

use protocol::time::{Duration, LocalInstant};
use protocol::units::RadiansPerSecond;

use crate::link::failsafe::Lasting;

/// Greatest drive. *Assumed*: a fifth of the torque is too little to break a tail.
pub const DRIVE_MAX: f32 = 0.2;

/// So many turns without an index, and there is none. *Assumed*: one is enough, where friction does not slow it down.
pub const TURNS: f32 = 3.0;

/// A tail that turns slower is still, rad/s. *Assumed.*
pub const STILL_RAD_S: f32 = 0.1;

/// The tail must be still for that time before it counts as found. *Assumed*: a hand has let go by then.
pub const STILL_FOR: Duration = Duration(300_000);

/// What a tail does that looks for its zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// It is let free: it waits, or is turned by hand.
    Wait,
    /// It is driven so, counter-clockwise.
    Turn(f32),
    /// There is no index.
    Fail,
}

/// The search for the encoder's index after boot.
#[derive(Clone, Debug)]
pub struct Homing {
    speed_rad_s: f32,
    drive: f32,
    after: Duration,
    since: Option<LocalInstant>,
    still: Lasting,
}

impl Homing {
    /// At `speed`, `after` boot, with a motor that turns at `no_load_speed` by itself. A speed that is no number, or not
    /// positive, is zero.
    #[must_use]
    pub fn new(speed: RadiansPerSecond, after: Duration, no_load_speed: RadiansPerSecond) -> Self {
        let drive = (speed.0 / no_load_speed.0).min(DRIVE_MAX);
        let turns = speed.0.is_finite() && drive > 0.0;
        Self {
            speed_rad_s: if turns { speed.0 } else { 0.0 },
            drive: if turns { drive } else { 0.0 },
            after,
            since: None,
            still: Lasting::new(),
        }
    }

    /// By hand.
    #[must_use]
    pub const fn by_hand() -> Self {
        Self { speed_rad_s: 0.0, drive: 0.0, after: Duration(0), since: None, still: Lasting::new() }
    }

    /// What to do at `now`, own clock, while the zero is not known.
    pub fn search(&mut self, now: LocalInstant) -> Search {
        let waited = now.since(*self.since.get_or_insert(now));
        if self.drive <= 0.0 || waited < self.after {
            return Search::Wait;
        }
        let turned_s = Duration(waited.0.saturating_sub(self.after.0)).as_secs_f32();
        if turned_s * self.speed_rad_s > TURNS * TAU { Search::Fail } else { Search::Turn(self.drive) }
    }

    /// The zero is known and the tail turns at `rate`: ends the search, unless a hand still turns it.
    pub fn settles(&mut self, now: LocalInstant, rate: RadiansPerSecond) -> bool {
        let still = libm::fabsf(rate.0) < STILL_RAD_S;
        let by_hand = self.drive <= 0.0 && self.since.is_some();
        if by_hand && !self.still.update(now, still, STILL_FOR) {
            return false;
        }
        self.end();
        true
    }

    /// Whether a search goes on.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        self.since.is_some()
    }

    /// The zero is looked for no more: the next search starts over.
    pub const fn end(&mut self) {
        self.since = None;
        self.still = Lasting::new();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000;

    fn homing(speed: f32) -> Homing {
        Homing::new(RadiansPerSecond(speed), Duration(2_000_000), RadiansPerSecond(18.0))
    }

    #[test]
    fn waits_then_turns_then_gives_up() {
        let mut homing = homing(0.9);
        assert_eq!(homing.search(LocalInstant(7_000 * MS)), Search::Wait);
        assert_eq!(homing.search(LocalInstant(8_999 * MS)), Search::Wait);
        let Search::Turn(drive) = homing.search(LocalInstant(9_000 * MS)) else { panic!("it does not turn") };
        assert!((drive - 0.05).abs() < 1e-6);
        // Three turns at 0.9 rad/s are 20.94 s.
        assert_eq!(homing.search(LocalInstant(29_900 * MS)), Search::Turn(drive));
        assert_eq!(homing.search(LocalInstant(30_000 * MS)), Search::Fail);
        homing.end();
        assert_eq!(homing.search(LocalInstant(31_000 * MS)), Search::Wait);
    }

    #[test]
    fn has_found_it_once_the_tail_is_still() {
        let mut driven = homing(0.9);
        driven.search(LocalInstant(0));
        assert!(driven.settles(LocalInstant(0), RadiansPerSecond(5.0)), "its own motor turned it");
        let mut homing = Homing::by_hand();
        assert!(homing.settles(LocalInstant(0), RadiansPerSecond(5.0)), "it was not looked for");
        homing.search(LocalInstant(0));
        let ends = |homing: &mut Homing, ms: u64, rate| {
            homing.settles(LocalInstant(ms * MS), RadiansPerSecond(rate))
        };
        assert!(!ends(&mut homing, 100, 0.0) && !ends(&mut homing, 399, 0.09));
        assert!(!ends(&mut homing, 401, -0.2), "it is turned on");
        assert!(!ends(&mut homing, 402, 0.0) && homing.is_searching());
        assert!(ends(&mut homing, 702, 0.0) && !homing.is_searching());
    }

    #[test]
    fn is_weak_and_needs_a_speed() {
        let mut fast = homing(50.0);
        fast.search(LocalInstant(0));
        assert_eq!(fast.search(LocalInstant(2_000 * MS)), Search::Turn(DRIVE_MAX));
        for none in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let mut homing = homing(none);
            homing.search(LocalInstant(0));
            assert_eq!(homing.search(LocalInstant(u64::from(u32::MAX))), Search::Wait, "{none}");
        }
        let mut broken = Homing::new(RadiansPerSecond(1.0), Duration(0), RadiansPerSecond(f32::NAN));
        assert!(matches!(broken.search(LocalInstant(0)), Search::Turn(drive) if drive <= DRIVE_MAX));
    }
}
