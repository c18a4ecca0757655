//! The reference trajectory of one action of a plan: pose, velocity and acceleration at every instant.
//!
//! A leg goes straight with its heading held, a turn goes the shorter way in place, undocking and docking stay where
//! they are. Legs and turns begin and end at rest ([`Profile`]).
//!
//! **Constant speed.** The paper's plans start at full speed and stop from it, which no robot does. Such an action is
//! executed with the acceleration of the rules; it takes v/a longer than planned.

use quantity::wrap_rad;
use reconfiguration::plan::{Action, ActionKind};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Rules;

use super::super::vector::{dot, length, offset};
use super::profile::Profile;

/// The reference of one instant: pose, velocity and acceleration of a level body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// Pose.
    pub pose: Pose,
    /// Velocity of the body origin, world, m/s.
    pub velocity_m_s: [f64; 3],
    /// Its acceleration, world, m/s².
    pub acceleration_m_s2: [f64; 3],
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Yaw acceleration, rad/s².
    pub yaw_acceleration_rad_s2: f64,
}

impl Reference {
    /// A reference at rest at `pose`.
    #[must_use]
    pub fn at_rest(pose: Pose) -> Self {
        Self { pose, ..Self::default() }
    }
}

/// One action as it is executed: the reference at every instant of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceTrajectory {
    kind: ActionKind,
    from: Pose,
    to: Pose,
    /// Unit vector of a leg, world; zero otherwise.
    direction: [f64; 3],
    /// Way round of a turn, +1 or −1; zero otherwise.
    round: f64,
    profile: Profile,
    /// What undocking and docking take, s.
    pause_s: f64,
    /// Greatest speed, m/s or rad/s, and acceleration, m/s² or rad/s².
    limits: [f64; 2],
}

impl ReferenceTrajectory {
    /// That of an action. What the action leaves open is decided by the rules.
    #[must_use]
    pub fn new(action: &Action, rules: &Rules) -> Self {
        let (least, usual) = match action.kind {
            ActionKind::Turn => (rules.yaw_rates_rad_s[0], rules.yaw_acceleration_rad_s2),
            _ => (rules.speeds_m_s[0], rules.acceleration_m_s2),
        };
        let speed = if action.speed > 0.0 { action.speed } else { least };
        let acceleration = action.acceleration.filter(|a| *a > 0.0).unwrap_or(usual);
        Self::between(action.kind, action.from, action.to, [speed, acceleration], action.duration_s)
    }

    fn between(
        kind: ActionKind,
        from: Pose,
        to: Pose,
        [speed, acceleration]: [f64; 2],
        duration_s: f64,
    ) -> Self {
        let way_m = offset(from.position_m, to.position_m);
        let length_m = length(way_m);
        let angle_rad = wrap_rad(to.yaw_rad - from.yaw_rad);
        let (mut direction, mut round, mut pause_s) = ([0.0; 3], 0.0, 0.0);
        let way = match kind {
            ActionKind::Leg => {
                direction = way_m.map(|x| if length_m > 0.0 { x / length_m } else { 0.0 });
                length_m
            }
            ActionKind::Turn => {
                round = angle_rad.signum();
                angle_rad.abs()
            }
            ActionKind::Undock | ActionKind::Dock => {
                pause_s = duration_s;
                0.0
            }
        };
        let profile = Profile::new(way, speed, acceleration);
        Self { kind, from, to, direction, round, profile, pause_s, limits: [speed, acceleration] }
    }

    /// The rest of it from the reference at `t_s` on, beginning at rest.
    #[must_use]
    pub fn resumed(&self, t_s: f64) -> Self {
        Self::between(self.kind, self.at(t_s).pose, self.to, self.limits, self.pause_s)
    }

    /// The same, with a duration of at least `least_s`.
    #[must_use]
    pub fn lasting(self, least_s: f64) -> Self {
        Self { pause_s: self.pause_s.max(least_s), ..self }
    }

    /// What kind of action it is.
    #[must_use]
    pub fn kind(&self) -> ActionKind {
        self.kind
    }

    /// The pose at the end of the action.
    #[must_use]
    pub fn end(&self) -> Pose {
        self.to
    }

    /// How long the action takes, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.profile.duration_s().max(self.pause_s)
    }

    /// The reference `t_s` after its beginning.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Reference {
        let now = self.profile.at(t_s);
        let along = |size: f64| self.direction.map(|component| component * size);
        let way_m = along(now.way);
        let pose = Pose {
            position_m: std::array::from_fn(|k| self.from.position_m[k] + way_m[k]),
            yaw_rad: wrap_rad(self.from.yaw_rad + self.round * now.way),
        };
        Reference {
            pose,
            velocity_m_s: along(now.speed),
            acceleration_m_s2: along(now.acceleration),
            yaw_rate_rad_s: self.round * now.speed,
            yaw_acceleration_rad_s2: self.round * now.acceleration,
        }
    }

    /// Distance of a place from the straight line of a leg, from the place of anything else, m.
    #[must_use]
    pub fn cross_track_m(&self, position_m: [f64; 3]) -> f64 {
        let off_m = offset(self.from.position_m, position_m);
        let along_m = dot(off_m, self.direction);
        length([0, 1, 2].map(|k| off_m[k] - along_m * self.direction[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn action(
        kind: ActionKind,
        from: [f64; 4],
        to: [f64; 4],
        speed: f64,
        acceleration: Option<f64>,
    ) -> Action {
        let (from, to) = (from.into(), to.into());
        Action { kind, start_s: 0.0, duration_s: 0.7, from, to, speed, acceleration, energy_j: 0.0 }
    }

    #[test]
    fn a_turn_goes_the_shorter_way_and_a_leg_straight() {
        let rules = Rules::default();
        let turn = action(ActionKind::Turn, [1.0, 2.0, 3.0, 3.0], [1.0, 2.0, 3.0, -3.0], 1.0, Some(0.5));
        let turn = ReferenceTrajectory::new(&turn, &rules);
        let angle_rad = std::f64::consts::TAU - 6.0;
        // A triangle: T = 2√(L/a).
        assert!((turn.duration_s() - 2.0 * (angle_rad / 0.5).sqrt()).abs() < 1e-12);
        let middle = turn.at(turn.duration_s() / 2.0);
        assert!(
            (middle.pose.yaw_rad.abs() - std::f64::consts::PI).abs() < 1e-9 && middle.yaw_rate_rad_s > 0.0
        );
        assert!((turn.at(9.0).pose.yaw_rad + 3.0).abs() < 1e-12);

        let leg = action(ActionKind::Leg, [0.0; 4], [3.0, 0.0, 4.0, 0.0], 0.5, None);
        let leg = ReferenceTrajectory::new(&leg, &rules);
        // Constant speed takes the acceleration of the rules: L/v + v/a.
        assert!((leg.duration_s() - (10.0 + 0.5 / rules.acceleration_m_s2)).abs() < 1e-12);
        let cruise = leg.at(6.0);
        assert!((cruise.velocity_m_s[0] - 0.3).abs() < 1e-12 && (cruise.velocity_m_s[2] - 0.4).abs() < 1e-12);
        assert!((leg.cross_track_m([3.0, 2.0, 4.0]) - 2.0).abs() < 1e-12);
        let rest = leg.resumed(6.0);
        assert!((rest.at(0.0).pose.position_m[2] - cruise.pose.position_m[2]).abs() < 1e-12);
        assert!(rest.at(0.0).velocity_m_s[0].abs() < 1e-12 && rest.end() == leg.end());

        let dock = ReferenceTrajectory::new(&action(ActionKind::Dock, [1.0; 4], [1.0; 4], 0.0, None), &rules);
        assert!(
            (dock.duration_s() - 0.7).abs() < 1e-12 && dock.at(0.3) == Reference::at_rest([1.0; 4].into())
        );
        assert!((dock.lasting(1.5).duration_s() - 1.5).abs() < 1e-12);
    }
}
