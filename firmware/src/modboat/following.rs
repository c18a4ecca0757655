//! Following error: a tail that is not where it was told to be, and what it does instead.
//!
//! It is stopped once |wrap(φ_ref − φ)| > e_max for t_max without a break, with the fault that what it did meanwhile calls for:
//!
//! | in that time | fault |
//! |---|---|
//! | \|Δφ\| ≤ φ̇_min·t_max: it stood still | motor stalled: something holds it |
//! | ∫ d·dφ < 0: it turned against its drive | wrong direction of motion: leads are swapped, or a sign is wrong |
//! | anything else | following error: weed, a weak motor, a wrong constant |
//!
//! | symbol | meaning | default | unit |
//! |---|---|---|---|
//! | e_max | [`ServoConstants::following_error_max`](protocol::configuration::ServoConstants) | 0.020 | rad |
//! | t_max | [`ServoConstants::following_error_time`](protocol::configuration::ServoConstants) | 0.05, *assumed* | s |
//! | φ̇_min | mean speed of a tail that does not move | 0.5, *assumed* | rad/s |
//! | Δφ̇, α | step of the reference's speed at the ends of a transition at constant speed; acceleration that the current limit allows | 600, *assumed* | rad/s, rad/s² |
//! | d | drive | | 1 |
//!
//! **Where the two bounds meet.** Plans keep the tube of e_s about every planned angle free (`tracking_error_rad` of the host,
//! 0.022 rad). What the module measures is off by up to one reading of its encoder, 0.0015 rad of 4096 in a turn, so
//! e_max + 2π/N ≤ e_s, and a servo that keeps 0.0165 rad with every motor of the spread is not stopped: the test
//! `the_bound_of_the_module_is_inside_the_tube_of_the_planner` of the host's `sim` holds both. What leaves the tube is braked
//! within t_max and the time that braking takes; until then, and from then on, it is a tail that stays behind, which is what
//! plans that are power tolerant keep clear of.
//!
//! No servo follows a step of speed: it leaves the path by about Δφ̇²/2α. In a cycle with such a transition the bound is Δφ̇²/α where that is
//! more: plans of that law (`--planner potential-field`) keep no tube free.
//!
//! Assumptions and limits: an error that comes and goes within t_max is not counted. Two causes at once have one name: only the stop is
//! certain. A blind tail is not driven and not watched here.

use protocol::time::{Duration, LocalInstant};

use crate::link::failsafe::{FailsafeEvent, Lasting};
use crate::modboat::reference::wrap;
use crate::modboat::servo::Command;
use crate::modboat::tail::TailStatus;

/// φ̇_min.
const STILL_RAD_S: f32 = 0.5;

/// α.
const ACCELERATION_RAD_S2: f32 = 600.0;

/// Detects a tail that is not where it was told to be.
#[derive(Clone, Debug)]
pub struct FollowingWatch {
    time: Duration,
    beyond: Lasting,
    /// Pose and drive of the tick before, while it is beyond its bound.
    last: Option<(f32, f32)>,
    /// Δφ since then.
    turned_rad: f32,
    /// ∫ d·dφ since then.
    driven_rad: f32,
}

impl FollowingWatch {
    /// Of a tail that is where it should be; t_max.
    #[must_use]
    pub const fn new(time: Duration) -> Self {
        Self { time, beyond: Lasting::new(), last: None, turned_rad: 0.0, driven_rad: 0.0 }
    }

    /// Takes one tick of the tail at `now`, own clock, in a cycle whose reference steps by `step_rad_s`; why it is to be stopped, if
    /// it is.
    pub fn update(
        &mut self,
        now: LocalInstant,
        status: &TailStatus,
        step_rad_s: f32,
    ) -> Option<FailsafeEvent> {
        let Command { lagging, error_rad, .. } = status.command;
        // Δφ̇²/α
        let within_step = libm::fabsf(error_rad) < step_rad_s * step_rad_s / ACCELERATION_RAD_S2;
        let Some(pose) = status.pose.filter(|_| lagging && !within_step && !status.blind) else {
            *self = Self::new(self.time);
            return None;
        };
        let (last_rad, drive) = self.last.unwrap_or((pose.0, 0.0));
        self.last = Some((pose.0, status.command.drive));
        let step_rad = wrap(pose.0 - last_rad);
        self.turned_rad += step_rad;
        // ∫ d·dφ, with the drive that was put out meanwhile
        self.driven_rad += drive * step_rad;
        if !self.beyond.update(now, true, self.time) {
            return None;
        }
        let still = libm::fabsf(self.turned_rad) <= STILL_RAD_S * self.time.as_secs_f32();
        Some(if still {
            FailsafeEvent::MotorStalled
        } else if self.driven_rad < 0.0 {
            FailsafeEvent::WrongWay
        } else {
            FailsafeEvent::FollowingError
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::units::Radians;

    const TIME: Duration = Duration(50_000);

    fn status(pose_rad: f32, drive: f32, lagging: bool) -> TailStatus {
        let command = Command { drive, lagging, ..Command::default() };
        TailStatus { pose: Some(Radians(pose_rad)), command, ..TailStatus::default() }
    }

    /// The first word of a tail that turns so fast and is driven so, and when it comes, ms.
    fn first(speed_rad_s: f32, drive: f32) -> Option<(u64, FailsafeEvent)> {
        let mut watch = FollowingWatch::new(TIME);
        (0..100_u64).find_map(|ms| {
            // Across the seam of the circle.
            let pose_rad = wrap(3.1 + speed_rad_s * ms as f32 * 1e-3);
            Some((ms, watch.update(LocalInstant(ms * 1000), &status(pose_rad, drive, true), 0.0)?))
        })
    }

    #[test]
    fn the_fault_is_what_the_tail_did() {
        for (speed_rad_s, drive, expected) in [
            (0.0, 0.67, FailsafeEvent::MotorStalled),
            (0.4, 0.67, FailsafeEvent::MotorStalled),
            (4.0, 0.67, FailsafeEvent::FollowingError),
            (-4.0, -0.67, FailsafeEvent::FollowingError),
            (4.0, -0.67, FailsafeEvent::WrongWay),
            (-4.0, 0.67, FailsafeEvent::WrongWay),
        ] {
            assert_eq!(first(speed_rad_s, drive), Some((50, expected)), "{speed_rad_s} rad/s at {drive}");
        }
    }

    #[test]
    fn what_does_not_last_is_no_fault() {
        let mut watch = FollowingWatch::new(TIME);
        for ms in 0..10_000_u64 {
            let lagging = ms % 51 != 50;
            assert_eq!(
                watch.update(LocalInstant(ms * 1000), &status(0.0, 1.0, lagging), 0.0),
                None,
                "{ms} ms"
            );
        }
        let blind = TailStatus { blind: true, ..status(0.0, 0.0, true) };
        let unseen = TailStatus { pose: None, ..blind };
        for ms in 10_000..20_000_u64 {
            let status = if ms % 2 == 0 { blind } else { unseen };
            assert_eq!(watch.update(LocalInstant(ms * 1000), &status, 0.0), None, "{ms} ms");
        }
    }
}
