//! Legs of a scenario: what is demanded, one after the other.

use quantity::ParameterError;
use serde::Deserialize;

/// One demand and how long it lasts.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// How long, s.
    pub duration_s: f64,
    /// Where to, or how fast.
    pub demand: Demand,
    /// Heading Θ of the surge axis, rad counter-clockwise from world x.
    pub heading_rad: f64,
}

/// What is demanded of the motion of the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand {
    /// A velocity in the world (x east, y north), m/s.
    Velocity([f64; 2]),
    /// A position in the world, to go to and to keep, m.
    Station([f64; 2]),
}

/// A `[[leg]]` as it stands in the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LegTable {
    duration_s: f64,
    velocity_m_s: Option<[f64; 2]>,
    position_m: Option<[f64; 2]>,
    heading_rad: f64,
}

impl LegTable {
    /// The leg, or the key that is wrong and what to say about it.
    pub(super) fn check(&self) -> Result<Leg, (&'static str, String)> {
        let &Self { duration_s, velocity_m_s, position_m, heading_rad } = self;
        let demand = match (velocity_m_s, position_m) {
            (Some(velocity_m_s), None) => Demand::Velocity(velocity_m_s),
            (None, Some(position_m)) => Demand::Station(position_m),
            _ => {
                return Err(("velocity_m_s", "takes exactly one of velocity_m_s and position_m".to_owned()));
            }
        };
        let [vx, vy] = velocity_m_s.unwrap_or_default();
        let [x, y] = position_m.unwrap_or_default();
        let speed = "must lie between −10 and 10";
        let far = "must lie between −1000000 and 1000000";
        for (key, value, unit, range, reason) in [
            ("duration_s", duration_s, "s", 1e-3..=1e5, "must lie between 0.001 and 100000"),
            ("velocity_m_s", vx, "m/s", -10.0..=10.0, speed),
            ("velocity_m_s", vy, "m/s", -10.0..=10.0, speed),
            ("position_m", x, "m", -1e6..=1e6, far),
            ("position_m", y, "m", -1e6..=1e6, far),
            ("heading_rad", heading_rad, "rad", -1e3..=1e3, "must lie between −1000 and 1000"),
        ] {
            if !range.contains(&value) {
                return Err((key, ParameterError { key, value, unit, reason }.to_string()));
            }
        }
        Ok(Leg { duration_s, demand, heading_rad })
    }
}
