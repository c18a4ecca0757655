//! `cmd_vel`: a velocity for as long as it is asked for.
//!
//! A twist is of the body: x forward (surge), y left (against sway), turning counter-clockwise (REP 103). The run takes a velocity in the
//! world and a heading, so
//!
//! v = R(Θ)·(v_x, v_y), R(Θ) = [cos Θ, −sin Θ; sin Θ, cos Θ]
//!
//! with the newest measured heading Θ, and the heading that is asked for is the integral of ω_z from where the body points when driving begins.
//! It leads the measured one by at most [`LEAD_RAD`], so that a body that cannot turn as fast does not go on turning when the operator has
//! let go.
//!
//! The last twist counts for [`DEADMAN_S`], as a controller of ROS has it; then the fleet is let go of, and holds. The run has a deadman of
//! its own, 0.3 s, for which what is asked is repeated every [`REFRESH_S`].

/// How long a twist counts, s.
pub const DEADMAN_S: f64 = 0.5;
/// What is asked is repeated after this time, s: a third of what the run waits for.
pub const REFRESH_S: f64 = 0.1;
/// How far the heading that is asked for leads, rad. *Assumed*: a structure turns it within seconds.
pub const LEAD_RAD: f64 = 0.6;

/// A velocity is turned with the body when that has turned by so much, rad: each other velocity is an order of its own in the log. *Assumed*:
/// half as much is 2.5 % of a velocity.
pub const TURNED_RAD: f64 = 0.05;

/// What is wanted of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// m/s.
    pub forward_m_s: f64,
    /// m/s.
    pub left_m_s: f64,
    /// Counter-clockwise, rad/s.
    pub turn_rad_s: f64,
}

/// What the run is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// A velocity, east and north, and a heading.
    Velocity([f64; 2], f64),
    /// To hold.
    LetGo,
}

#[derive(Clone, Copy, Debug)]
struct Driving {
    wanted: Wanted,
    /// When it came.
    came_s: f64,
    /// The heading that is asked for, and when it was reckoned.
    heading_rad: f64,
    reckoned_s: f64,
    /// The heading along which the velocity is asked for.
    along_rad: f64,
    /// When the run was asked last.
    asked_s: Option<f64>,
}

/// See the module's documentation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    driving: Option<Driving>,
}

impl Drive {
    /// A twist has come at `now_s`, for a body that points to `heading_rad`. One that is no number ends what was wanted before.
    pub fn take(&mut self, now_s: f64, wanted: Wanted, heading_rad: f64) {
        let numbers = [wanted.forward_m_s, wanted.left_m_s, wanted.turn_rad_s];
        if !numbers.iter().all(|number| number.is_finite()) {
            self.driving.iter_mut().for_each(|driving| driving.came_s = f64::NEG_INFINITY);
            return;
        }
        let begun = Driving {
            wanted,
            came_s: now_s,
            heading_rad,
            reckoned_s: now_s,
            along_rad: heading_rad,
            asked_s: None,
        };
        let driving = self.driving.get_or_insert(begun);
        // What was wanted before counts up to now.
        driving.reckon(now_s, heading_rad);
        let changed = driving.wanted != wanted;
        (driving.wanted, driving.came_s) = (wanted, now_s);
        if changed {
            driving.asked_s = None;
        }
    }

    /// What the run is to be asked for at `now_s`.
    pub fn due(&mut self, now_s: f64, heading_rad: f64) -> Option<Asked> {
        let driving = self.driving.as_mut()?;
        if now_s - driving.came_s > DEADMAN_S {
            self.driving = None;
            return Some(Asked::LetGo);
        }
        if driving.asked_s.is_some_and(|asked_s| now_s - asked_s < REFRESH_S) {
            return None;
        }
        driving.reckon(now_s, heading_rad);
        driving.asked_s = Some(now_s);
        if wrapped(heading_rad - driving.along_rad).abs() > TURNED_RAD {
            driving.along_rad = heading_rad;
        }
        let (sin, cos) = driving.along_rad.sin_cos();
        let Wanted { forward_m_s, left_m_s, .. } = driving.wanted;
        let velocity_m_s = [forward_m_s * cos - left_m_s * sin, forward_m_s * sin + left_m_s * cos];
        Some(Asked::Velocity(velocity_m_s, driving.heading_rad))
    }

    /// Another target was given: it is that which counts.
    pub fn forget(&mut self) {
        self.driving = None;
    }

    /// Whether the fleet is being driven.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.driving.is_some()
    }
}

impl Driving {
    fn reckon(&mut self, now_s: f64, heading_rad: f64) {
        let turn_rad = self.wanted.turn_rad_s * (now_s - self.reckoned_s);
        self.reckoned_s = now_s;
        if turn_rad != 0.0 {
            // The measured heading is known up to whole turns.
            let ahead_rad = wrapped(self.heading_rad - heading_rad) + turn_rad;
            self.heading_rad = heading_rad + ahead_rad.clamp(-LEAD_RAD, LEAD_RAD);
        }
    }
}

/// To (−π, π].
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad.sin().atan2(angle_rad.cos())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const FORWARD: Wanted = Wanted { forward_m_s: 0.04, left_m_s: 0.0, turn_rad_s: 0.0 };

    fn velocity(asked: Option<Asked>) -> ([f64; 2], f64) {
        match asked {
            Some(Asked::Velocity(velocity_m_s, heading_rad)) => (velocity_m_s, heading_rad),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn forward_is_along_the_heading_and_left_is_across_it() {
        let wanted = Wanted { forward_m_s: 0.03, left_m_s: 0.01, turn_rad_s: 0.0 };
        for (heading_rad, expected) in [(0.0, [0.03, 0.01]), (FRAC_PI_2, [-0.01, 0.03])] {
            let mut drive = Drive::default();
            drive.take(1.0, wanted, heading_rad);
            let (found, heading) = velocity(drive.due(1.0, heading_rad));
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}");
            assert!((heading - heading_rad).abs() < 1e-15);
        }
    }

    #[test]
    fn a_body_that_sways_is_asked_for_one_velocity_and_one_that_turns_for_others() {
        let mut drive = Drive::default();
        let mut asked = Vec::new();
        for step in 0..100 {
            let now_s = 0.125 * f64::from(step);
            drive.take(now_s, FORWARD, 0.04 * now_s.sin());
            asked.push(velocity(drive.due(now_s, 0.04 * now_s.sin())).0);
        }
        assert!(asked.iter().all(|[x, y]| (x - 0.04).abs() < 1e-15 && y.abs() < 1e-15), "{asked:?}");
        drive.take(12.5, FORWARD, FRAC_PI_2);
        let turned = velocity(drive.due(12.5, FRAC_PI_2)).0;
        assert!(turned[0].abs() < 1e-15 && (turned[1] - 0.04).abs() < 1e-15, "{turned:?}");
    }

    #[test]
    fn a_twist_counts_for_half_a_second_and_is_repeated_until_then() {
        let mut drive = Drive::default();
        assert_eq!(drive.due(0.0, 0.0), None);
        drive.take(10.0, FORWARD, 0.0);
        let asked: Vec<f64> = (0..200)
            .map(|step| 10.0 + 0.005 * f64::from(step))
            .filter(|&now_s| match drive.due(now_s, 0.0) {
                Some(Asked::LetGo) => {
                    assert!(now_s - 10.0 > DEADMAN_S && now_s - 10.0 < DEADMAN_S + 0.011, "{now_s}");
                    false
                }
                asked => asked.is_some(),
            })
            .collect();
        assert!((5..=6).contains(&asked.len()), "{asked:?}");
        assert!(asked.windows(2).all(|pair| pair[1] - pair[0] < 0.3), "{asked:?}");
        assert!(!drive.is_on());
        assert_eq!(drive.due(11.0, 0.0), None);
    }

    #[test]
    fn another_velocity_is_asked_for_at_once() {
        let mut drive = Drive::default();
        drive.take(0.0, FORWARD, 0.0);
        assert!(drive.due(0.0, 0.0).is_some());
        drive.take(0.01, FORWARD, 0.0);
        assert_eq!(drive.due(0.01, 0.0), None);
        drive.take(0.02, Wanted { forward_m_s: 0.0, ..FORWARD }, 0.0);
        let [x, y] = velocity(drive.due(0.02, 0.0)).0;
        assert!(x.hypot(y) < 1e-15, "{x} {y}");
    }

    #[test]
    fn the_heading_turns_as_asked_and_leads_by_no_more_than_it_may() {
        let mut drive = Drive::default();
        let turning = Wanted { turn_rad_s: 0.5, ..Wanted::default() };
        // A body that follows at once.
        let mut heading_rad = 3.0;
        for step in 0..=80 {
            let now_s = 0.125 * f64::from(step);
            drive.take(now_s, turning, heading_rad);
            heading_rad = velocity(drive.due(now_s, heading_rad)).1;
        }
        assert!((heading_rad - 8.0).abs() < 1e-9, "{heading_rad}");
        // One that does not, as it is measured: wrapped.
        for step in 81..=160 {
            let now_s = 0.125 * f64::from(step);
            drive.take(now_s, turning, wrapped(heading_rad));
            let asked_rad = velocity(drive.due(now_s, wrapped(heading_rad))).1;
            assert!(wrapped(asked_rad - heading_rad) <= LEAD_RAD + 1e-9);
        }
    }

    #[test]
    fn what_is_no_number_ends_the_drive() {
        let mut drive = Drive::default();
        drive.take(0.0, FORWARD, 0.0);
        drive.take(0.1, Wanted { turn_rad_s: f64::NAN, ..FORWARD }, 0.0);
        assert_eq!(drive.due(0.1, 0.0), Some(Asked::LetGo));
        drive.take(0.2, Wanted { left_m_s: f64::INFINITY, ..FORWARD }, 0.0);
        assert_eq!(drive.due(0.2, 0.0), None);
    }
}
