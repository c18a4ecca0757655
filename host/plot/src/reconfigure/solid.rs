//! Boxes seen in parallel projection, and the order in which to paint them.
//!
//! World north-east-down; a view looks along a compass azimuth α and down by an elevation ε:
//!
//! ```text
//! right  = (−sin α, cos α, 0)            up = (cos α·sin ε, sin α·sin ε, −cos ε)
//! toward = (−cos α·cos ε, −sin α·cos ε, −sin ε)                 from the scene to the viewer
//! ```
//!
//! Two convex bodies that do not meet are parted by a plane, for boxes one of fifteen: normal to a face of either or to
//! an edge of both (S. Gottschalk et al., OBBTree, SIGGRAPH 1996). The body beyond a plane as the viewer sees it cannot
//! hide the other; if two planes say opposite things, neither hides the other. What must be painted first follows by
//! a topological sort; where bodies hide each other in a ring, the farthest goes first.

use quantity::vector::{cross, dot, length};

use crate::lines::Point;

/// A vector in the world, m.
pub type Vec3 = [f64; 3];

/// How far two bodies may sink into each other and still count as parted, m.
const TOUCH_M: f64 = 0.02;

/// The direction from which a scene is seen.
#[derive(Clone, Copy, Debug)]
pub struct View {
    right: Vec3,
    up: Vec3,
    toward: Vec3,
}

impl View {
    /// Looks along that azimuth (from north over east) and down by that elevation.
    #[must_use]
    pub fn new(azimuth_rad: f64, elevation_rad: f64) -> Self {
        let (sin, cos) = azimuth_rad.sin_cos();
        let (high, flat) = elevation_rad.sin_cos();
        Self {
            right: [-sin, cos, 0.0],
            up: [cos * high, sin * high, -flat],
            toward: [-cos * flat, -sin * flat, -high],
        }
    }

    /// Where a point is seen, m to the right and up.
    #[must_use]
    pub fn project(&self, p: Vec3) -> Point {
        (dot(self.right, p), dot(self.up, p))
    }

    /// How near a point is to the viewer, m.
    #[must_use]
    pub fn nearness(&self, p: Vec3) -> f64 {
        dot(self.toward, p)
    }
}

/// A box, or with a half length of zero something flatter.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    /// Its centre.
    pub centre: Vec3,
    /// Its axes x, y, z, unit vectors.
    pub axes: [Vec3; 3],
    /// Half its length along each.
    pub half: Vec3,
}

/// A face of a solid, and whether the viewer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Axis it is normal to.
    pub axis: usize,
    /// Its centre.
    pub centre: Vec3,
    /// Its corners, in order.
    pub corners: [Vec3; 4],
    /// Whether the viewer sees its outside.
    pub is_seen: bool,
}

impl Solid {
    /// A hull of that length, width and height at a pose η (ZYX Euler angles).
    #[must_use]
    pub fn hull(eta: [f64; 6], box_m: Vec3) -> Self {
        let [x, y, z, roll, pitch, yaw] = eta;
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
        // Columns of R = Rz(ψ)·Ry(θ)·Rx(φ).
        let axes = [
            [cy * cp, sy * cp, -sp],
            [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
            [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
        ];
        Self { centre: [x, y, z], axes, half: box_m.map(|side| 0.5 * side) }
    }

    /// A straight stretch between two points.
    #[must_use]
    pub fn stretch(a: Vec3, b: Vec3) -> Self {
        let step: Vec3 = std::array::from_fn(|k| b[k] - a[k]);
        let length = dot(step, step).sqrt();
        let along = if length > 1e-12 { step.map(|v| v / length) } else { [1.0, 0.0, 0.0] };
        let aside = if along[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let second = unit(cross(along, aside)).unwrap_or([0.0, 1.0, 0.0]);
        Self {
            centre: std::array::from_fn(|k| 0.5 * (a[k] + b[k])),
            axes: [along, second, cross(along, second)],
            half: [0.5 * length, 0.0, 0.0],
        }
    }

    /// The point that lies `share` half lengths from the centre along each axis.
    #[must_use]
    pub fn at(&self, share: Vec3) -> Vec3 {
        let mut p = self.centre;
        for (axis, reach) in self.axes.iter().zip([0, 1, 2].map(|k| share[k] * self.half[k])) {
            p = std::array::from_fn(|k| p[k] + reach * axis[k]);
        }
        p
    }

    /// All eight corners of the box.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|n| self.at([0, 1, 2].map(|k| if n >> k & 1 == 1 { 1.0 } else { -1.0 })))
    }

    /// All six faces of the box.
    #[must_use]
    pub fn faces(&self, view: &View) -> [Face; 6] {
        std::array::from_fn(|n| {
            let (axis, side) = (n / 2, if n % 2 == 0 { 1.0 } else { -1.0 });
            let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
            let point = |a: f64, b: f64| {
                let mut share = [0.0; 3];
                (share[axis], share[second], share[third]) = (side, a, b);
                self.at(share)
            };
            Face {
                axis,
                centre: point(0.0, 0.0),
                corners: [point(-1.0, -1.0), point(1.0, -1.0), point(1.0, 1.0), point(-1.0, 1.0)],
                is_seen: side * view.nearness(self.axes[axis]) > 1e-9,
            }
        })
    }

    fn is_thin(&self) -> bool {
        self.half.iter().any(|&h| h <= 0.0)
    }

    /// How far it reaches from its centre along a unit vector, m.
    fn reach(&self, along: Vec3) -> f64 {
        self.axes.iter().zip(self.half).map(|(&axis, half)| half * dot(axis, along).abs()).sum()
    }
}

/// Which of two bodies must be painted first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum First {
    A,
    B,
    Either,
}

fn first(view: &View, a: &Solid, b: &Solid) -> First {
    let crossed = a.axes.iter().flat_map(|&u| b.axes.iter().map(move |&v| cross(u, v)));
    let normals = a.axes.iter().chain(&b.axes).copied().chain(crossed).filter_map(unit);
    // (gap, nearness of the normal that points from a to b)
    let mut planes: Vec<(f64, f64)> = normals
        .map(|normal| {
            let apart = dot(normal, std::array::from_fn(|k| b.centre[k] - a.centre[k]));
            let gap = apart.abs() - a.reach(normal) - b.reach(normal);
            (gap, apart.signum() * view.nearness(normal))
        })
        .collect();
    planes.sort_by(|p, q| q.0.total_cmp(&p.0));
    let widest = planes.first().map_or(f64::NEG_INFINITY, |p| p.0);
    if widest < -TOUCH_M {
        // One is inside the other: a path ends in a hull, and is hidden there.
        return match (a.is_thin(), b.is_thin()) {
            (true, false) => First::A,
            (false, true) => First::B,
            _ if view.nearness(a.centre) <= view.nearness(b.centre) => First::A,
            _ => First::B,
        };
    }
    // Bodies that touch, or almost, are parted by their widest plane; others by each that leaves a gap.
    let parting = planes.iter().filter(|p| p.0 >= widest.min(0.0) - 1e-9);
    let (mut a_first, mut b_first) = (true, true);
    for &(_, toward_b) in parting {
        a_first &= toward_b > 1e-9;
        b_first &= toward_b < -1e-9;
    }
    match (a_first, b_first) {
        (true, _) => First::A,
        (_, true) => First::B,
        _ => First::Either,
    }
}

/// The order in which to paint bodies, so that what is nearer covers what it hides: indices.
#[must_use]
pub fn painting_order(view: &View, solids: &[Solid]) -> Vec<usize> {
    let count = solids.len();
    let mut after: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut waits_for = vec![0_usize; count];
    for (i, a) in solids.iter().enumerate() {
        for (j, b) in solids.iter().enumerate().skip(i + 1) {
            if a.is_thin() && b.is_thin() {
                continue;
            }
            let (before, behind) = match first(view, a, b) {
                First::A => (i, j),
                First::B => (j, i),
                First::Either => continue,
            };
            after[before].push(behind);
            waits_for[behind] += 1;
        }
    }
    let far_first = |&i: &usize, &j: &usize| {
        view.nearness(solids[i].centre).total_cmp(&view.nearness(solids[j].centre)).then(i.cmp(&j))
    };
    let mut left: Vec<usize> = (0..count).collect();
    let mut order = Vec::with_capacity(count);
    while !left.is_empty() {
        let free = left.iter().copied().filter(|&i| waits_for[i] == 0).min_by(far_first);
        let Some(next) = free.or_else(|| left.iter().copied().min_by(far_first)) else { break };
        left.retain(|&i| i != next);
        for &behind in &after[next] {
            waits_for[behind] = waits_for[behind].saturating_sub(1);
        }
        order.push(next);
    }
    order
}

/// Whether a point lies in a convex polygon.
#[must_use]
pub fn is_inside(polygon: &[Point], p: Point) -> bool {
    let sides = polygon
        .iter()
        .zip(polygon.iter().cycle().skip(1))
        .map(|(a, b)| (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0));
    let (mut left, mut right) = (true, true);
    for side in sides {
        left &= side >= 0.0;
        right &= side <= 0.0;
    }
    left || right
}

fn unit(v: Vec3) -> Option<Vec3> {
    let size = length(v);
    (size > 1e-6).then(|| v.map(|c| c / size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{Rng, SeedableRng};

    fn uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
        low + (high - low) * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// How near to the viewer the ray through `p` (right, up) enters a box, if it does: slab by slab.
    fn entry(view: &View, solid: &Solid, p: Point) -> Option<f64> {
        let origin: Vec3 = std::array::from_fn(|k| p.0 * view.right[k] + p.1 * view.up[k]);
        let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
        for (axis, half) in solid.axes.iter().zip(solid.half) {
            let from = dot(*axis, std::array::from_fn(|k| solid.centre[k] - origin[k]));
            let slope = dot(*axis, view.toward);
            if slope.abs() < 1e-9 {
                if from.abs() > half {
                    return None;
                }
                continue;
            }
            let (s, t) = ((from - half) / slope, (from + half) / slope);
            near = near.min(s.max(t));
            far = far.max(s.min(t));
        }
        (far <= near).then_some(near)
    }

    fn views() -> impl Iterator<Item = View> {
        (0..12).map(|n| View::new(0.3 + 0.53 * f64::from(n), 0.2 + 0.08 * f64::from(n)))
    }

    fn assert_nearest_on_top(view: &View, solids: &[Solid], random: &mut ChaCha8Rng, case: &str) {
        let order = painting_order(view, solids);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..solids.len()).collect::<Vec<_>>(), "{case}");
        for _ in 0..400 {
            let p = (uniform(random, -2.0, 2.0), uniform(random, -2.0, 2.0));
            let hit = |&i: &usize| entry(view, &solids[i], p).map(|depth| (depth, i));
            let top = order.iter().filter_map(hit).next_back();
            let nearest = order.iter().filter_map(hit).max_by(|a, b| a.0.total_cmp(&b.0));
            if let (Some(top), Some(nearest)) = (top, nearest) {
                assert!(nearest.0 - top.0 < 1e-6, "{case}: {} hides {} at {p:?}", top.1, nearest.1);
            }
        }
    }

    #[test]
    fn docked_boxes_are_painted_from_far_to_near() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let box_m = [0.483, 0.33, 0.267];
        let cells =
            [[0, 0, 0], [-1, 0, 0], [-2, -1, 0], [-2, 0, 0], [-2, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 0]];
        let solids = cells.map(|cell: [i32; 3]| {
            let [x, y, z] = [0, 1, 2].map(|k| f64::from(cell[k]) * box_m[k]);
            Solid::hull([x, y, z, 0.0, 0.0, 0.0], box_m)
        });
        for (n, view) in views().enumerate() {
            assert_nearest_on_top(&view, &solids, &mut random, &format!("view {n}"));
        }
    }

    #[test]
    fn turned_boxes_cover_what_lies_behind_them() {
        for seed in 0..60 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut solids: Vec<Solid> = Vec::new();
            while solids.len() < 7 {
                let eta = [1.2, 1.2, 0.8, 0.2, 0.2, 3.1].map(|reach| uniform(&mut random, -reach, reach));
                let next = Solid::hull(eta, [0.483, 0.33, 0.267]);
                // Far enough apart whatever their attitude.
                let clear = |s: &Solid| {
                    let step: Vec3 = std::array::from_fn(|k| s.centre[k] - next.centre[k]);
                    dot(step, step).sqrt() > 0.65
                };
                if solids.iter().all(clear) {
                    solids.push(next);
                }
            }
            for (n, view) in views().enumerate() {
                assert_nearest_on_top(&view, &solids, &mut random, &format!("seed {seed}, view {n}"));
            }
        }
    }

    #[test]
    fn a_path_goes_before_and_behind_a_hull() {
        let view = View::new(0.0, 0.5);
        let hull = Solid::hull([0.0; 6], [0.4; 3]);
        // Looking north: what lies south is nearer.
        let south = Solid::stretch([-1.0, -0.5, 0.0], [-1.0, 0.5, 0.0]);
        let north = Solid::stretch([1.0, -0.5, 0.0], [1.0, 0.5, 0.0]);
        let within = Solid::stretch([0.0, 0.0, 0.0], [0.0, 0.15, 0.0]);
        let order = painting_order(&view, &[south, hull, north, within]);
        let place = |n: usize| order.iter().position(|&i| i == n);
        assert!(place(2) < place(1) && place(1) < place(0) && place(3) < place(1), "{order:?}");
    }

    #[test]
    fn up_in_the_world_is_up_in_the_picture() {
        let view = View::new(5.1, 0.6);
        let (right, up) = view.project([0.0, 0.0, -1.0]);
        assert!(right.abs() < 1e-12 && up > 0.5);
        let seen = Solid::hull([0.0; 6], [1.0; 3]).faces(&view);
        assert_eq!(seen.iter().filter(|f| f.is_seen).count(), 3);
        assert!(seen[5].is_seen && seen[5].axis == 2 && (seen[5].centre[2] + 0.5).abs() < 1e-12);
    }
}
