//! Geometry of a configuration: connectors in the world, which bodies are connected (18), which boxes overlap.
//!
//! ```text
//! p = p_O + R_z(ψ)·l,   n = R_z(ψ)·n_b                     connector of a level body in the world
//! a_ij = k   if connector k of i holds j, nothing otherwise     (18)
//! ```
//!
//! Two connectors hold each other when their centres lie within [`MEET_M`] and their normals are opposed within
//! [`OPPOSED_RAD`]; how they are turned about their normals does not matter. A body without connectors of its own has
//! one in the centre of each face of its box: front, back, right, left, bottom, top.
//!
//! Level boxes share the vertical, so five axes can separate two of them: the vertical, and the horizontal edges of
//! each. The gap along an axis is |Δ·a| − Σ h|e·a|, and two boxes overlap when every gap is below −[`TOUCH_M`].
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | p_O, ψ | pose of the body, [`Pose`] | world; m, rad |
//! | l, n_b | centre and outward normal of a connector | body; m, 1 |

use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;

use super::vector::{dot, offset, turned};

/// Connectors meet when their centres are this near, m; *assumed*: the magnets pull in the rest.
pub const MEET_M: f64 = 0.01;
/// Connectors meet when their normals are opposed within this, rad; *assumed*, 5°.
pub const OPPOSED_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Boxes that run into each other by no more than this touch, m; *assumed*: the precision of poses in a file.
pub const TOUCH_M: f64 = 1e-3;

/// Centre and outward normal of every connector of a body, in the world.
#[must_use]
pub fn connectors(pose: Pose, vehicle: &Vehicle) -> Vec<([f64; 3], [f64; 3])> {
    let place = |(position_m, normal): ([f64; 3], [f64; 3])| {
        // p = p_O + R_z(ψ)·l,  n = R_z(ψ)·n_b
        let arm = turned(position_m, pose.yaw_rad);
        (std::array::from_fn(|k| pose.position_m[k] + arm[k]), turned(normal, pose.yaw_rad))
    };
    vehicle.connectors().iter().map(|own| place((own.position_m, own.normal))).collect()
}

/// The connector of `first` that holds `second`, and the other way round; the nearest pair if several meet.
#[must_use]
pub fn holds(first: (Pose, &Vehicle), second: (Pose, &Vehicle)) -> Option<(usize, usize)> {
    meeting(&connectors(first.0, first.1), &connectors(second.0, second.1))
}

fn meeting(first: &[([f64; 3], [f64; 3])], second: &[([f64; 3], [f64; 3])]) -> Option<(usize, usize)> {
    let pairs = first.iter().enumerate().flat_map(|(i, a)| {
        second.iter().enumerate().map(move |(j, b)| ((i, j), offset(b.0, a.0), dot(a.1, b.1)))
    });
    pairs
        .map(|(pair, between, cosine)| (pair, dot(between, between).sqrt(), cosine))
        .filter(|&(_, apart_m, cosine)| apart_m <= MEET_M && cosine <= -OPPOSED_RAD.cos())
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(pair, ..)| pair)
}

/// The adjacency matrix (18): `[i][j]` is the index of the connector of i that holds j.
#[must_use]
pub fn adjacency(bodies: &[(Pose, &Vehicle)]) -> Vec<Vec<Option<usize>>> {
    let placed: Vec<_> = bodies.iter().map(|&(pose, vehicle)| connectors(pose, vehicle)).collect();
    let mut matrix = vec![vec![None; bodies.len()]; bodies.len()];
    for j in 1..bodies.len() {
        for i in 0..j {
            if let Some((own, other)) = meeting(&placed[i], &placed[j]) {
                (matrix[i][j], matrix[j][i]) = (Some(own), Some(other));
            }
        }
    }
    matrix
}

/// The clusters of an adjacency matrix: bodies that a chain of connections joins, each in ascending order.
#[must_use]
pub fn clusters(adjacency: &[Vec<Option<usize>>]) -> Vec<Vec<usize>> {
    clusters_by(adjacency.len(), |body, other| adjacency[body][other].is_some())
}

/// What a chain of those that are joined joins, each in ascending order.
#[must_use]
pub fn clusters_by(count: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..count).collect();
    let mut found = Vec::new();
    while !left.is_empty() {
        let (mut cluster, mut next) = (vec![left.remove(0)], 0);
        while let Some(&body) = cluster.get(next) {
            left.retain(|&other| {
                let joins = joined(body, other);
                if joins {
                    cluster.push(other);
                }
                !joins
            });
            next += 1;
        }
        cluster.sort_unstable();
        found.push(cluster);
    }
    found
}

/// Bodies that move as one, each in ascending order: clusters of those that are docked, then every other body alone. `berths` has where
/// each body is docked, and what it is; `None` for one that is not.
#[must_use]
pub fn groups(berths: &[Option<(Pose, &Vehicle)>]) -> Vec<Vec<usize>> {
    let docked: Vec<usize> = (0..berths.len()).filter(|&body| berths[body].is_some()).collect();
    let placed: Vec<(Pose, &Vehicle)> = berths.iter().flatten().copied().collect();
    let clusters = clusters(&adjacency(&placed)).into_iter();
    let clusters = clusters.map(|cluster| cluster.into_iter().map(|index| docked[index]).collect());
    let alone = (0..berths.len()).filter(|&body| berths[body].is_none()).map(|body| vec![body]);
    clusters.chain(alone).collect()
}

/// A level box, turned about the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelBox {
    /// Its centre in the world, m.
    pub centre_m: [f64; 3],
    /// Half its length, width and height, m.
    pub half_m: [f64; 3],
    /// Heading of its length, rad.
    pub yaw_rad: f64,
}

impl LevelBox {
    /// The box around a vehicle at `pose`.
    #[must_use]
    pub fn around(pose: Pose, vehicle: &Vehicle) -> Self {
        Self {
            centre_m: pose.position_m,
            half_m: vehicle.box_m.map(|side| side / 2.0),
            yaw_rad: pose.yaw_rad,
        }
    }

    /// Half its width along a unit vector.
    fn reach_m(&self, axis: [f64; 3]) -> f64 {
        let edges = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        (0..3).map(|k| self.half_m[k] * dot(turned(edges[k], self.yaw_rad), axis).abs()).sum()
    }

    /// Greatest gap along any axis that can separate the two, m; below zero it is how deep they overlap.
    #[must_use]
    pub fn gap_m(&self, other: &Self) -> f64 {
        let between = offset(self.centre_m, other.centre_m);
        let (along, across) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let axes = [
            [0.0, 0.0, 1.0],
            turned(along, self.yaw_rad),
            turned(across, self.yaw_rad),
            turned(along, other.yaw_rad),
            turned(across, other.yaw_rad),
        ];
        // |Δ·a| − Σ h|e·a|
        let gap = |axis| dot(between, axis).abs() - self.reach_m(axis) - other.reach_m(axis);
        axes.into_iter().map(gap).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the two share more than a touch.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.gap_m(other) < -TOUCH_M
    }

    /// Least and greatest world coordinates, m.
    #[must_use]
    pub fn extent_m(&self) -> [[f64; 3]; 2] {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let reach: [f64; 3] = axes.map(|axis| self.reach_m(axis));
        [-1.0, 1.0].map(|side| std::array::from_fn(|k| self.centre_m[k] + side * reach[k]))
    }

    /// Its outline, seen from above, m.
    #[must_use]
    pub fn outline_m(&self) -> [[f64; 2]; 4] {
        [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[ahead, aside]| {
            let corner = turned([ahead * self.half_m[0], aside * self.half_m[1], 0.0], self.yaw_rad);
            [self.centre_m[0] + corner[0], self.centre_m[1] + corner[1]]
        })
    }

    /// Whether it lies inside the corners `bounds_m`; touching counts as inside.
    #[must_use]
    pub fn is_within(&self, bounds_m: [[f64; 3]; 2]) -> bool {
        let [least, greatest] = self.extent_m();
        (0..3).all(|k| least[k] >= bounds_m[0][k] - TOUCH_M && greatest[k] <= bounds_m[1][k] + TOUCH_M)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};
    use reconfiguration::vehicle::Connector;

    use super::*;

    fn hull(box_m: [f64; 3]) -> Vehicle {
        let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
        Vehicle { box_m, connectors: Vec::new(), ..robot }
    }

    #[test]
    fn a_row_of_three_holds_front_to_back() {
        let hull = hull([0.4, 0.3, 0.2]);
        let bodies = [[0.0; 4], [0.4, 0.005, 0.0, 0.0], [0.8, 0.0, 0.0, 0.0]].map(|p| (p.into(), &hull));
        let matrix = adjacency(&bodies);
        // Faces: 0 front, 1 back.
        assert_eq!(matrix[0], [None, Some(0), None]);
        assert_eq!(matrix[1], [Some(1), None, Some(0)]);
        assert_eq!(matrix[2], [None, Some(1), None]);
        assert_eq!(clusters(&matrix), [[0, 1, 2]]);
    }

    #[test]
    fn a_quarter_turn_brings_the_right_side_to_the_back() {
        let hull = hull([0.4, 0.3, 0.2]);
        // Heading east, its right side (2) looks south, to the front (0) of the other.
        let east: Pose = [0.35, 0.0, 0.0, FRAC_PI_2].into();
        assert_eq!(holds(([0.0; 4].into(), &hull), (east, &hull)), Some((0, 2)));
        // Below: bottom (4) holds top (5), whatever the heading.
        assert_eq!(holds(([0.0; 4].into(), &hull), ([0.0, 0.0, 0.2, 0.7].into(), &hull)), Some((4, 5)));
    }

    #[test]
    fn a_centimetre_and_five_degrees_are_the_limits() {
        let hull = hull([0.4, 0.3, 0.2]);
        let held = |pose: [f64; 4]| holds(([0.0; 4].into(), &hull), (pose.into(), &hull)).is_some();
        assert!(held([0.4, 0.009, 0.0, 0.0]) && !held([0.4, 0.011, 0.0, 0.0]));
        assert!(held([0.4, 0.0, 0.0, 4.5_f64.to_radians() * 0.5]));
        // Turned about the meeting point, so that the centres stay together.
        let about = |degrees: f64| {
            let yaw = degrees.to_radians();
            [0.2 + 0.2 * yaw.cos(), 0.2 * yaw.sin(), 0.0, yaw]
        };
        assert!(held(about(4.9)) && !held(about(5.1)));
    }

    #[test]
    fn own_connectors_replace_the_faces() {
        let mut nose = hull([0.4, 0.3, 0.2]);
        nose.connectors =
            vec![Connector { name: "nose".to_owned(), position_m: [0.2, 0.0, 0.0], normal: [1.0, 0.0, 0.0] }];
        let other = hull([0.4, 0.3, 0.2]);
        assert_eq!(holds(([0.0; 4].into(), &nose), ([0.4, 0.0, 0.0, 0.0].into(), &other)), Some((0, 1)));
        assert_eq!(holds(([0.0; 4].into(), &nose), ([-0.4, 0.0, 0.0, 0.0].into(), &other)), None);
    }

    #[test]
    fn two_pairs_are_two_clusters() {
        let hull = hull([0.4, 0.3, 0.2]);
        let xs = [0.0, 2.0, 0.4, 2.4];
        let bodies = xs.map(|x| ([x, 0.0, 0.0, 0.0].into(), &hull));
        assert_eq!(clusters(&adjacency(&bodies)), [[0, 2], [1, 3]]);
        assert_eq!(clusters(&[]), Vec::<Vec<usize>>::new());
    }

    /// Sampling oracle: no overlap found may have points of one deep inside the other, and the other way round.
    #[test]
    fn overlap_agrees_with_points_drawn_in_both_boxes() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut overlapping, mut apart) = (0, 0);
        for round in 0..300 {
            let mut draw = || LevelBox {
                centre_m: std::array::from_fn(|_| rng.random_range(-0.4..0.4)),
                half_m: std::array::from_fn(|_| rng.random_range(0.05..0.4)),
                yaw_rad: rng.random_range(-4.0..4.0),
            };
            let (first, second) = (draw(), draw());
            let inside = |b: &LevelBox, p: [f64; 3]| {
                let local = turned(offset(b.centre_m, p), -b.yaw_rad);
                (0..3).all(|k| local[k].abs() <= b.half_m[k])
            };
            let shared = (0..20_000).any(|_| {
                let local = std::array::from_fn(|k| rng.random_range(-first.half_m[k]..=first.half_m[k]));
                let arm = turned(local, first.yaw_rad);
                inside(&second, std::array::from_fn(|k| first.centre_m[k] + arm[k]))
            });
            let gap_m = first.gap_m(&second);
            assert!((gap_m - second.gap_m(&first)).abs() < 1e-12);
            // Between −0.05 and 0 the common volume may be too small to be hit.
            assert!(!shared || gap_m <= 0.0, "seed 5, round {round}: a common point, gap {gap_m} m");
            assert!(shared || gap_m > -0.05, "seed 5, round {round}: no common point, gap {gap_m} m");
            overlapping += usize::from(shared);
            apart += usize::from(!shared);
        }
        assert!(overlapping > 50 && apart > 50, "{overlapping} overlapping, {apart} apart");
    }

    #[test]
    fn touching_is_no_overlap_and_a_turned_box_reaches_further() {
        let hull = hull([0.4, 0.3, 0.2]);
        let boxed = |pose: [f64; 4]| LevelBox::around(pose.into(), &hull);
        assert!(!boxed([0.0; 4]).overlaps(&boxed([0.3995, 0.0, 0.0, 0.0])));
        assert!(boxed([0.0; 4]).overlaps(&boxed([0.398, 0.0, 0.0, 0.0])));
        let [least, greatest] = boxed([1.0, 2.0, 3.0, FRAC_PI_2]).extent_m();
        for (value, expected) in least.iter().chain(&greatest).zip([0.85, 1.8, 2.9, 1.15, 2.2, 3.1]) {
            assert!((value - expected).abs() < 1e-12, "{value}");
        }
        assert!(boxed([0.0; 4]).is_within([[-0.2, -0.15, -0.1], [0.2, 0.15, 0.1]]));
        assert!(!boxed([0.0, 0.0, 0.0, 0.1]).is_within([[-0.2, -0.15, -0.1], [0.2, 0.15, 0.1]]));
    }
}
