//! Reach of a tail: angles at which it can touch a neighbour's, as a direction and a greatest angle off it.

use std::f64::consts::{PI, TAU};

use crate::distance::DistanceToCollision;
use quantity::wrap_rad;

/// From the direction i to j to that in which tail i, tail j, points at the other, rad.
const TURNED_RAD: [f64; 2] = [0.0, PI];

/// Angles at which two tails at one lattice offset can touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Direction from i to j, rad from x_S.
    pub towards_rad: f64,
    /// Greatest planned angle off it of tail i, or off the opposite of tail j, at which they can touch: by geometry, and e_s beyond
    /// it, rad.
    pub within_rad: f64,
}

impl Reach {
    /// Between two modules at that offset.
    #[must_use]
    pub fn new(distance: &DistanceToCollision, offset: [i32; 2]) -> Self {
        let [col, row] = offset.map(f64::from);
        let within_rad = distance.tail().reach_rad(offset) + distance.errors().tracking_rad();
        Self { towards_rad: row.atan2(col), within_rad: within_rad.min(PI) }
    }

    /// Whether tail i (`end` 0) or tail j (1) is out of the other's reach at this angle, wherever the other is.
    #[must_use]
    pub fn clears(&self, end: usize, phi_rad: f64) -> bool {
        wrap_rad(phi_rad - self.towards_rad - TURNED_RAD[end]).abs() >= self.within_rad
    }

    /// The same all the way from one angle to another: it lies in what `within_rad` about the direction leaves of the circle.
    #[must_use]
    pub fn clears_along(&self, end: usize, from_rad: f64, to_rad: f64) -> bool {
        let towards_rad = self.towards_rad + TURNED_RAD[end];
        let past_rad = (from_rad.min(to_rad) - towards_rad - self.within_rad).rem_euclid(TAU);
        past_rad + (to_rad - from_rad).abs() <= TAU - 2.0 * self.within_rad
    }
}
