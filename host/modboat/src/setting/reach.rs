//! Where a tail can touch a neighbour's: the directions towards it, and how far off them.

use std::f64::consts::{PI, TAU};

use crate::distance::DistanceToCollision;
use quantity::wrap_rad;

/// Where a tail can touch a neighbour's at one lattice offset.
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

    /// Whether tail i is out of j's reach at this angle, wherever tail j is.
    #[must_use]
    pub fn clears_i(&self, phi_i_rad: f64) -> bool {
        wrap_rad(phi_i_rad - self.towards_rad).abs() >= self.within_rad
    }

    /// Whether tail i is out of j's reach all the way from one angle to another.
    #[must_use]
    pub fn clears_i_along(&self, from_rad: f64, to_rad: f64) -> bool {
        self.clears_along(self.towards_rad, from_rad, to_rad)
    }

    /// The same of tail j.
    #[must_use]
    pub fn clears_j_along(&self, from_rad: f64, to_rad: f64) -> bool {
        self.clears_along(self.towards_rad + PI, from_rad, to_rad)
    }

    /// Whether the way from one angle to another lies in what `within_rad` about `towards_rad` leaves of the circle.
    fn clears_along(&self, towards_rad: f64, from_rad: f64, to_rad: f64) -> bool {
        let past_rad = (from_rad.min(to_rad) - towards_rad - self.within_rad).rem_euclid(TAU);
        past_rad + (to_rad - from_rad).abs() <= TAU - 2.0 * self.within_rad
    }

    /// Whether tail j is out of i's reach at this angle, wherever tail i is.
    #[must_use]
    pub fn clears_j(&self, phi_j_rad: f64) -> bool {
        wrap_rad(phi_j_rad - self.towards_rad - PI).abs() >= self.within_rad
    }
}
