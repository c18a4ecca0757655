//! The edge of the water: a simple polygon, and the room that a point or a hull has in it.
//!
//! The room of a convex outline is its distance from the edge. It is attained at a corner of one of the two: of the outline against
//! the edges, or of the edge against the outline. Where the outline sticks out it is negative, and by how much is told by the corner
//! that is furthest outside, and by the middle of every edge's part inside the outline.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::vector::{dot, length};

/// Most vertices of a polygon.
pub const VERTICES_MAX: usize = 64;

/// The edge of the water, a simple polygon in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Its vertices in order, either way round, m.
    pub edge_m: Vec<[f64; 2]>,
    /// How far from it every part of a structure or hull keeps, m. *Assumed*: a gust of some seconds.
    #[serde(default = "margin_m")]
    pub margin_m: f64,
}

const fn margin_m() -> f64 {
    0.1
}

/// Why it is none.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BoundsError {
    /// Too few or too many vertices.
    #[error("has {0} vertices: must have 3 to {VERTICES_MAX}")]
    Count(usize),
    /// A coordinate that is none, or too great.
    #[error("vertex {vertex} has the coordinate {value} m: must lie in ±1000000")]
    Coordinate {
        /// From 1.
        vertex: usize,
        /// Which.
        value: f64,
    },
    /// Two edges meet where they should not.
    #[error("its edge {0} crosses or touches its edge {1}")]
    Crossing(usize, usize),
}

impl Bounds {
    /// Refuses what is no simple polygon.
    ///
    /// # Errors
    /// [`BoundsError`].
    pub fn validate(&self) -> Result<(), BoundsError> {
        let count = self.edge_m.len();
        if !(3..=VERTICES_MAX).contains(&count) {
            return Err(BoundsError::Count(count));
        }
        for (vertex, point) in self.edge_m.iter().enumerate() {
            if let Some(&value) = point.iter().find(|value| !(-1e6..=1e6).contains(*value)) {
                return Err(BoundsError::Coordinate { vertex: vertex + 1, value });
            }
        }
        for first in 0..count {
            for second in first + 1..count {
                let neighbours = second == first + 1 || first == 0 && second == count - 1;
                let (a, b) = (self.segment(first), self.segment(second));
                let meet = if neighbours { folds(a, b) } else { meets(a, b) };
                if meet {
                    return Err(BoundsError::Crossing(first + 1, second + 1));
                }
            }
        }
        Ok(())
    }

    /// Whether a point is inside.
    #[must_use]
    pub fn contains(&self, point: [f64; 2]) -> bool {
        let edges = 0..self.edge_m.len();
        let crossings = edges.filter(|&edge| {
            let [a, b] = self.segment(edge);
            (a[1] > point[1]) != (b[1] > point[1])
                && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossings.count() % 2 == 1
    }

    /// Distance of a point from the edge, m; negative outside.
    #[must_use]
    pub fn distance_m(&self, point: [f64; 2]) -> f64 {
        let edges = 0..self.edge_m.len();
        let least = edges.map(|edge| length(between(point, closest(point, self.segment(edge)))));
        let least = least.fold(f64::INFINITY, f64::min);
        if self.contains(point) { least } else { -least }
    }

    /// Least distance of a convex outline from the edge, m; negative where a part of it is outside.
    #[must_use]
    pub fn room_m(&self, outline: &[[f64; 2]]) -> f64 {
        let corners = outline.iter().map(|&corner| self.distance_m(corner));
        let sides = || outline.iter().copied().zip(outline.iter().copied().cycle().skip(1));
        let away_m = |point| {
            sides().map(|(a, b)| length(between(point, closest(point, [a, b])))).fold(f64::INFINITY, f64::min)
        };
        let edges = (0..self.edge_m.len()).map(|edge| {
            let [a, b] = self.segment(edge);
            match inner(outline, [a, b]) {
                Some(share) => -away_m([0, 1].map(|k| a[k] + share * (b[k] - a[k]))),
                None => away_m(a),
            }
        });
        corners.chain(edges).fold(f64::INFINITY, f64::min)
    }

    /// Calls `take` with each edge that holds back a point inside, or with the nearest edge of one outside: its index, the unit
    /// vector along which the point leaves, and the distance from it, negative outside, m.
    pub fn nearest(&self, point: [f64; 2], mut take: impl FnMut(usize, [f64; 2], f64)) {
        let inside = self.contains(point);
        let mut outside = (f64::INFINITY, 0, [0.0; 2]);
        for edge in 0..self.edge_m.len() {
            let segment = self.segment(edge);
            let to = between(point, closest(point, segment));
            let distance_m = length(to);
            // On the edge itself the way out is its normal.
            let normal = if distance_m > 1e-9 { to.map(|k| k / distance_m) } else { self.outward(segment) };
            if inside {
                take(edge, normal, distance_m);
            } else if distance_m < outside.0 {
                let way_out = if distance_m > 1e-9 { normal.map(|k| -k) } else { normal };
                outside = (distance_m, edge, way_out);
            }
        }
        if !inside {
            take(outside.1, outside.2, -outside.0);
        }
    }

    fn segment(&self, edge: usize) -> [[f64; 2]; 2] {
        [self.edge_m[edge], self.edge_m[(edge + 1) % self.edge_m.len()]]
    }

    fn outward(&self, [a, b]: [[f64; 2]; 2]) -> [f64; 2] {
        let points = self.edge_m.iter().zip(self.edge_m.iter().cycle().skip(1));
        let area: f64 = points.map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum();
        let (along, side) = (between(a, b), area.signum());
        let length = length(along);
        [side * along[1] / length, -side * along[0] / length]
    }
}

fn between(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [b[0] - a[0], b[1] - a[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn closest(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    let (along, to) = (between(a, b), between(a, point));
    let share = (dot(along, to) / dot(along, along)).clamp(0.0, 1.0);
    [0, 1].map(|k| a[k] + share * along[k])
}

/// The middle of the part of a segment inside a convex outline, as a share of the segment; none where it is outside or touches.
fn inner(outline: &[[f64; 2]], [a, b]: [[f64; 2]; 2]) -> Option<f64> {
    let sides = || outline.iter().copied().zip(outline.iter().copied().cycle().skip(1));
    let turns: f64 = sides().map(|(p, q)| cross(p, q)).sum::<f64>().signum();
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (p, q) in sides() {
        // Twice the area that a point spans with the side, positive within.
        let [at_a, at_b] = [a, b].map(|point| turns * cross(between(p, q), between(p, point)));
        if at_a <= 0.0 && at_b <= 0.0 {
            return None;
        }
        let share = at_a / (at_a - at_b);
        if at_a < 0.0 {
            from = from.max(share);
        } else if at_b < 0.0 {
            to = to.min(share);
        }
    }
    (to - from > 1e-9).then_some(0.5 * (from + to))
}

/// Whether two segments without a common vertex have a common point.
fn meets([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p, q, r| cross(between(p, q), between(p, r));
    let (c_side, d_side, a_side, b_side) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
    if c_side * d_side < 0.0 && a_side * b_side < 0.0 {
        return true;
    }
    let on = |point, segment| length(between(point, closest(point, segment))) == 0.0;
    on(c, [a, b]) || on(d, [a, b]) || on(a, [c, d]) || on(b, [c, d])
}

/// Whether two edges with a common vertex lie on each other, or one has no length.
fn folds(first: [[f64; 2]; 2], second: [[f64; 2]; 2]) -> bool {
    let (u, v) = (between(first[0], first[1]), between(second[0], second[1]));
    if length(u) == 0.0 || length(v) == 0.0 {
        return true;
    }
    // The common vertex is the end of the one and the start of the other, whichever comes first.
    cross(u, v) == 0.0 && dot(u, v) < 0.0
}

#[cfg(test)]
mod tests;
