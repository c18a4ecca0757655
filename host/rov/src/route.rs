//! One robot's route from its start to its slot: corners, headings, speeds; as timed actions.
//!
//! | manner | how |
//! |---|---|
//! | [`Manner::Paper`] | `paper`: Basic Theta* on the regular grid, turns in place, constant speed |
//! | [`Manner::Best`] | `best`: a sparse graph around the bodies at rest, then corners and headings refined together |
//!
//! What motion costs is in [`Mover`], with lower bounds of it. A route of either manner is free as
//! [`clearance`](super::clearance) says.

use grid::theta::Search;
use reconfiguration::plan::{Action, Criterion, Manner};
use reconfiguration::problem::Rules;

use super::clearance::Clearance;
use super::search_graph::Lattice;
use super::vector::{length, offset, turned};

mod best;
mod bound;
mod fares;
mod mover;
mod paper;
mod polyline;
mod refine;
mod sparse;
mod tariff;
mod timeline;
mod waypoints;

pub use mover::Mover;

/// Headings that differ by less are the same, rad.
const SAME_RAD: f64 = 1e-9;

/// A route with its actions and its energy.
#[derive(Clone, Debug)]
pub struct Route {
    /// Its corners, start and slot included.
    pub path: Vec<[f64; 3]>,
    /// What the robot does, from time 0.
    pub actions: Vec<Action>,
    /// How long that takes, s.
    pub duration_s: f64,
    /// What its thrusters draw, J.
    pub energy_j: f64,
}

impl Route {
    /// Cost by a criterion: (17), or its length.
    #[must_use]
    pub fn cost(&self, criterion: Criterion, lambda_w: f64) -> f64 {
        match criterion {
            Criterion::Energy => self.energy_j + lambda_w * self.duration_s,
            Criterion::Euclidean => self.path.windows(2).map(|leg| length(offset(leg[0], leg[1]))).sum(),
        }
    }
}

/// Scratch of searches for routes, to be used again; one for each thread.
#[derive(Debug, Default)]
pub struct Scratch {
    search: Search,
    sparse: sparse::Sparse,
}

/// One question for a route, with everything that the answer depends on.
pub struct RouteQuery<'a> {
    /// The robot that moves.
    pub mover: &'a Mover,
    /// Where it may move.
    pub clearance: &'a Clearance,
    /// The grid of the paper's rules.
    pub lattice: &'a Lattice,
    /// The rules' numbers.
    pub rules: &'a Rules,
    /// What all others draw meanwhile, W.
    pub lambda_w: f64,
}

impl RouteQuery<'_> {
    /// The best route found, or `None`: then no way was found on this grid, or around these bodies.
    #[must_use]
    pub fn route(&self, criterion: Criterion, manner: Manner, scratch: &mut Scratch) -> Option<Route> {
        match manner {
            Manner::Paper => paper::route(self, criterion, &mut scratch.search),
            Manner::Best => best::route(self, criterion, &mut scratch.sparse),
        }
    }
}

/// Heading of a leg; `None` straight up or down.
fn azimuth_rad([x, y, _]: [f64; 3]) -> Option<f64> {
    (x.hypot(y) > 1e-9).then(|| y.atan2(x))
}

/// A world vector in the body of a level robot.
fn in_body(vector: [f64; 3], yaw_rad: f64) -> [f64; 3] {
    turned(vector, -yaw_rad)
}

#[cfg(test)]
mod tests;
