//! From what is wanted to the wrench that is demanded of the next cycle: the controllers, their settings, and what they are asked.
//!
//! | kind | what |
//! |---|---|
//! | `forgiving` | the default: [`forgiving`] follows a reference, takes off what pushes beside the tails, learns thrust and drag |
//! | `paper` | [`paper`]: the laws (13)–(19) as corrected, from the motion that the [`Observer`](super::observer::Observer) tells |

use quantity::{ParameterError, check_within};
use serde::{Deserialize, Serialize};

use self::forgiving::{Forgiving, ForgivingConfig};
use self::paper::Controller as Paper;
use super::motion::Wrench;
use super::observer::{Fix, ObserverParameters};
use super::parameters::Parameters;
use super::structure::Structure;

pub mod forgiving;
mod limits;
pub mod margins;
pub mod paper;

/// A controller by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerKind {
    /// See [`forgiving`].
    #[default]
    Forgiving,
    /// See [`paper`].
    Paper,
}

impl ControllerKind {
    /// All controllers.
    pub const ALL: [Self; 2] = [Self::Forgiving, Self::Paper];

    /// `forgiving` or `paper`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Forgiving => "forgiving",
            Self::Paper => "paper",
        }
    }
}

/// Gains and limits of the controller. None are in the paper: *assumed*, see the texts of [`paper`] and [`forgiving`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlConfig {
    /// Which controller.
    pub kind: ControllerKind,
    /// K_p,Θ, 1/s².
    pub yaw_proportional_1_s2: f64,
    /// K_d,Θ, 1/s.
    pub yaw_derivative_1_s: f64,
    /// g of (15): how much of what is new of the unknown torque is taken off at each decision.
    pub yaw_trim: f64,
    /// K_p,v, 1/s.
    pub velocity_proportional_1_s: f64,
    /// K_d,v, dimensionless. Zero by default: a difference over one interval is mostly noise.
    pub velocity_derivative: f64,
    /// K_x of (20), 1/s.
    pub position_proportional_1_s: f64,
    /// v_max of (20), m/s.
    pub position_speed_max_m_s: f64,
    /// γ of (18): what is left of the sum after one interval.
    pub leak: f64,
    /// Water that turns with the structure: total inertia / dry inertia.
    pub added_inertia_factor: f64,
    /// Water that moves along with the structure: total mass / dry mass. Zero leaves inertia out, as printed.
    pub added_mass_factor: f64,
    /// Share of the greatest thrust that the least-norm allocation of the demand may ask of any module. Below one,
    /// because collisions shrink the envelope.
    pub thrust_share: f64,
    /// Share of `thrust_share` that torque alone may take, so that some is left to hold against a current.
    pub torque_share: f64,
    /// Gains of the forgiving controller.
    pub forgiving: ForgivingConfig,
}

impl Default for ControlConfig {
    fn default() -> Self {
        Self {
            kind: ControllerKind::default(),
            yaw_proportional_1_s2: 0.15,
            yaw_derivative_1_s: 0.3,
            yaw_trim: 0.15,
            velocity_proportional_1_s: 0.25,
            velocity_derivative: 0.0,
            position_proportional_1_s: 0.2,
            position_speed_max_m_s: 0.04,
            leak: 0.95,
            added_inertia_factor: 1.2,
            added_mass_factor: 1.5,
            thrust_share: 0.9,
            torque_share: 0.7,
            forgiving: ForgivingConfig::default(),
        }
    }
}

impl ControlConfig {
    /// Refuses what the controller cannot work with, by the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let gain = "must be from 0 to 10";
        self.forgiving.validate()?;
        let share = "must be from 0.01 to 1";
        check_within(&[
            ("yaw_proportional_1_s2", self.yaw_proportional_1_s2, "1/s²", 0.0..=10.0, gain),
            ("yaw_derivative_1_s", self.yaw_derivative_1_s, "1/s", 0.0..=10.0, gain),
            ("yaw_trim", self.yaw_trim, "", 0.0..=1.0, "must be from 0 to 1"),
            ("velocity_proportional_1_s", self.velocity_proportional_1_s, "1/s", 0.0..=10.0, gain),
            ("velocity_derivative", self.velocity_derivative, "", 0.0..=10.0, gain),
            ("position_proportional_1_s", self.position_proportional_1_s, "1/s", 0.0..=10.0, gain),
            ("position_speed_max_m_s", self.position_speed_max_m_s, "m/s", 0.0..=10.0, gain),
            ("leak", self.leak, "", 0.0..=1.0, "must be from 0 to 1"),
            ("added_inertia_factor", self.added_inertia_factor, "", 1.0..=10.0, "must be from 1 to 10"),
            ("added_mass_factor", self.added_mass_factor, "", 0.0..=10.0, "must be from 0 to 10"),
            ("thrust_share", self.thrust_share, "", 0.01..=1.0, share),
            ("torque_share", self.torque_share, "", 0.01..=1.0, share),
        ])
    }
}

/// Demanded velocity and heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Velocity in the world, m/s.
    pub velocity_m_s: [f64; 2],
    /// Heading Θ of the surge axis, rad counter-clockwise from world x.
    pub heading_rad: f64,
}

/// Observed motion of the structure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Velocity in the world, m/s.
    pub velocity_m_s: [f64; 2],
    /// Heading Θ, rad; may be unwrapped.
    pub heading_rad: f64,
    /// Angular velocity Ω, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Acceleration in the world that neither wrench nor drag explains, m/s².
    pub unknown_m_s2: [f64; 2],
    /// Angular acceleration that neither torque nor drag explains, rad/s².
    pub unknown_rad_s2: f64,
}

/// When a decision is made, and what for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Now, s.
    pub now_s: f64,
    /// When the cycle that is decided on starts, s.
    pub start_s: f64,
    /// Time between decisions, s.
    pub interval_s: f64,
}

impl Moment {
    /// From now to the end of what is decided on, s.
    #[must_use]
    pub fn horizon_s(&self) -> f64 {
        self.start_s - self.now_s + self.interval_s
    }
}

/// What all tails together do from a time on. Sums over the modules, of unwrapped angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tails {
    /// Of the angles that they swing about, or rest at, rad.
    pub about_rad: f64,
    /// Of the signed amplitudes, rad.
    pub net_rad: f64,
    /// Of where they rest before, rad.
    pub from_rad: f64,
    /// When they turn from there, s.
    pub turn_s: f64,
    /// When they swing, s.
    pub swim_s: f64,
}

impl Tails {
    /// Sum of their angles over what they swing about, at `t_s`, rad; the period of the swing is `period_s`.
    #[must_use]
    pub fn beyond_rad(&self, t_s: f64, period_s: f64) -> f64 {
        if t_s >= self.swim_s {
            return self.net_rad * (std::f64::consts::TAU * (t_s - self.swim_s) / period_s).cos();
        }
        let share = ((t_s - self.turn_s) / (self.swim_s - self.turn_s)).clamp(0.0, 1.0);
        let from_rad = self.from_rad - self.about_rad;
        from_rad + share * (self.net_rad - from_rad)
    }
}

/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Velocity and heading; the velocity that leads to the station where there is one.
    pub target: Target,
    /// Position in the world to be kept, m.
    pub station_m: Option<[f64; 2]>,
    /// Whether the target is less than what was asked for, to stay inside the edge of the water: it counts from now on.
    pub is_bounded: bool,
}

/// One of the controllers.
#[derive(Clone, Debug)]
pub enum Controller {
    /// See [`paper`].
    Paper(Box<Paper>),
    /// See [`forgiving`].
    Forgiving(Box<Forgiving>),
}

impl Controller {
    /// That of `config`.
    #[must_use]
    pub fn new(
        structure: &Structure,
        parameters: &Parameters,
        config: &ControlConfig,
        observer: &ObserverParameters,
    ) -> Self {
        match config.kind {
            ControllerKind::Paper => Self::Paper(Box::new(Paper::new(structure, parameters, config))),
            ControllerKind::Forgiving => {
                Self::Forgiving(Box::new(Forgiving::new(structure, parameters, config, observer)))
            }
        }
    }

    /// Takes a fix.
    pub fn update(&mut self, fix: &Fix) {
        if let Self::Forgiving(forgiving) = self {
            forgiving.update(fix);
        }
    }

    /// The mean wrench of the tails from `t_s` on, as [`Observer::set_wrench`](super::observer::Observer::set_wrench), and what they do.
    pub fn set_wrench(&mut self, t_s: f64, wrench: Wrench, tails: Option<Tails>) {
        if let Self::Forgiving(forgiving) = self {
            forgiving.set_wrench(t_s, wrench, tails);
        }
    }

    /// The running wrench is known to be another than was set: `wrench`.
    pub fn correct_wrench(&mut self, wrench: Wrench) {
        if let Self::Forgiving(forgiving) = self {
            forgiving.correct_wrench(wrench);
        }
    }

    /// m of the Munk moment, as it is known now.
    pub fn set_munk(&mut self, munk: f64) {
        if let Self::Forgiving(forgiving) = self {
            forgiving.set_munk(munk);
        }
    }

    /// The wrench of the plan that was made for the last demand.
    pub fn planned(&mut self, wrench: Wrench) {
        if let Self::Forgiving(forgiving) = self {
            forgiving.planned(wrench);
        }
    }

    /// The wrench to demand of the next cycle.
    pub fn demand(&mut self, goal: &Goal, observed: &Observation, moment: &Moment) -> Wrench {
        match self {
            Self::Paper(paper) => paper.demand(&goal.target, observed, moment.interval_s, moment.horizon_s()),
            Self::Forgiving(forgiving) => forgiving.demand(goal, moment),
        }
    }
}

impl ControlConfig {
    /// The velocity (world) that leads to a station, (20); `horizon_s` is the time from the observation to the end of what is decided on.
    #[must_use]
    pub fn towards(
        &self,
        station_m: [f64; 2],
        position_m: [f64; 2],
        observed: &Observation,
        horizon_s: f64,
    ) -> [f64; 2] {
        // e_x = x_des − (x_obs + v_obs·h),  v_des = K_x e_x, at most v_max                (20)
        let wanted = [0, 1].map(|k| {
            let ahead_m = position_m[k] + observed.velocity_m_s[k] * horizon_s;
            self.position_proportional_1_s * (station_m[k] - ahead_m)
        });
        let speed = wanted[0].hypot(wanted[1]);
        let most = self.position_speed_max_m_s;
        if speed > most { wanted.map(|v| v * most / speed) } else { wanted }
    }
}
