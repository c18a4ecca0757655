//! Data of a robot or a tool: hull, mass, buoyancy, hydrodynamic coefficients, thrusters, connectors, services.
//!
//! Read from TOML; every number in the files that come with the program has its source beside it. A tool is a vehicle
//! without thrusters. All vectors are in the body frame (x forward, y right, z down) about the body origin, which is
//! the centre of the hull's box.
//!
//! The integrals (1), (2) over mass and volume are not computed here: [`Body::r_g_m`] and [`Body::r_b_m`] are
//! their results.

use std::borrow::Cow;

use reader::{FileError, names};
use serde::{Deserialize, Serialize};

use super::body::Body;

mod file;

/// The vehicles that come with the program, by name.
pub const BUILT_IN: [(&str, &str); 4] = [
    ("bluerov1", include_str!("../../data/vehicles/bluerov1.toml")),
    ("bluerov2", include_str!("../../data/vehicles/bluerov2.toml")),
    ("bluerov2-heavy", include_str!("../../data/vehicles/bluerov2-heavy.toml")),
    ("tool-20n", include_str!("../../data/vehicles/tool-20n.toml")),
];

/// What is said of a name that none of [`BUILT_IN`] has: those that there are, and the nearest.
#[must_use]
pub fn there_are(name: &str) -> String {
    names::there_are(name, &BUILT_IN.map(|(known, _)| known))
}

/// A thruster: where it sits and which way it pushes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thruster {
    /// Position l, m.
    pub position_m: [f64; 3],
    /// Direction e of positive thrust, a unit vector.
    pub direction: [f64; 3],
    /// Whether the wires are swapped, so that positive thrust needs a pulse below neutral.
    #[serde(default)]
    pub reversed: bool,
    /// Whether it is out of order: it pushes nothing.
    #[serde(default)]
    pub failed: bool,
}

/// A face that can dock to another connector (g4): two hold when they meet, facing each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Connector {
    /// What it is called.
    pub name: String,
    /// Centre of the face, m.
    pub position_m: [f64; 3],
    /// Outward direction, a unit vector.
    pub normal: [f64; 3],
}

/// One kind of robot or tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// Its name.
    pub name: String,
    /// Length, width and height of the box around it, m.
    pub box_m: [f64; 3],
    /// Mass, buoyancy and hydrodynamics.
    pub body: Body,
    /// Its thrusters, in the order of their outputs; none for a tool.
    pub thrusters: Vec<Thruster>,
    /// Its connectors; the centres of the six faces of the box if none are given.
    pub connectors: Vec<Connector>,
    /// Sensors, actuators and other services it brings (g2, g7).
    pub capabilities: Vec<String>,
}

impl Vehicle {
    /// The one of that name among those that come with the program.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        let (_, text) = BUILT_IN.iter().find(|(built_in, _)| *built_in == name)?;
        Self::parse(name, text).ok()
    }

    /// Reads a vehicle from TOML; `file` is its name in error messages.
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        file::parse(file, text)
    }

    /// The connectors that it has, or the centres of the six faces of its box.
    #[must_use]
    pub fn connectors(&self) -> Cow<'_, [Connector]> {
        if !self.connectors.is_empty() {
            return Cow::Borrowed(&self.connectors);
        }
        const FACES: [(&str, usize, f64); 6] = [
            ("front", 0, 1.0),
            ("back", 0, -1.0),
            ("right", 1, 1.0),
            ("left", 1, -1.0),
            ("bottom", 2, 1.0),
            ("top", 2, -1.0),
        ];
        let face = |&(name, axis, sign): &(&str, usize, f64)| {
            let (mut position_m, mut normal) = ([0.0; 3], [0.0; 3]);
            position_m[axis] = sign * self.box_m[axis] / 2.0;
            normal[axis] = sign;
            Connector { name: name.to_owned(), position_m, normal }
        };
        Cow::Owned(FACES.iter().map(face).collect())
    }
}
