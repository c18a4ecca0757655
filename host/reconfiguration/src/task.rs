//! What a configuration is to be good for, where no goal is given (g1, g7): services at places, a passage, tools.
//!
//! Tools are those of the problem: the configuration holds them where they are.

use serde::{Deserialize, Serialize};

/// A service that is wanted at a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Service {
    /// What: a capability of a robot.
    pub capability: String,
    /// Where, world, m.
    pub place_m: [f64; 3],
    /// How far the robot's centre may be from there, m.
    pub within_m: f64,
}

/// A passage that the configuration is to fit through along a heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Passage {
    /// Heading of the passage, rad.
    pub heading_rad: f64,
    /// Its width across, m.
    pub width_m: f64,
    /// Its height, m.
    pub height_m: f64,
}

/// What a goal configuration has to do.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Task {
    /// Services at places.
    #[serde(rename = "service")]
    pub services: Vec<Service>,
    /// What it fits through.
    pub passage: Option<Passage>,
}
