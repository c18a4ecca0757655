//! Places that a way around bodies at rest can bend at: the vertices of the sparse graph.
//!
//! | places | why |
//! |---|---|
//! | along the axes of start and slot, and on the line between them | undocking, docking, turning on the way |
//! | around the box that the mover's centre keeps out of, for every body near a dock zone | sliding around hulls |
//! | beside such bodies by half a hull's diagonal | room to turn |
//! | eighteen at two distances around start, slot and the middle between them, where there is room to turn | turning, if the headings differ |
//! | eight on the circle where the border of a zone meets the sphere of radius d around a body | leaving the zone past it |
//! | eighteen on a sphere around every body, a little outside (19) | the way around bodies outside the zones |
//!
//! Neighbours among the eighteen see each other past the sphere, in a level layer of water too: they are at most 54.7° apart, and
//! 1/cos 27.4° = 1.126. All directions
//! come from the problem: the axes of bodies, the vertical, and the level direction from start to slot.

use std::f64::consts::TAU;

use quantity::vector::cross;
use quantity::wrap_rad;

use super::super::clearance::{Clearance, Resting};
use super::super::vector::{length, offset, turned};
use super::{SAME_RAD, azimuth_rad};

/// Radius of the sphere of places around a body, in d.
const AROUND: f64 = 1.13;
/// What places keep from the hulls they are beside, in d.
const BESIDE: f64 = 1e-4;
/// Distances of places to turn at from start, slot and the middle, in d.
const TURNING: [f64; 2] = [0.35, 0.75];
/// Places nearer to each other than this share of d are one.
const APART: f64 = 0.02;

/// Fills `places` with start, slot, and what the mover's centre may be at.
pub(super) fn collect(clearance: &Clearance, places: &mut Vec<[f64; 3]>) {
    let (start, slot) = (&clearance.start, &clearance.slot);
    let d_m = clearance.distance_m;
    places.clear();
    places.extend([start.position_m, slot.position_m]);
    let way_m = offset(start.position_m, slot.position_m);
    let mut offer = |at_m: [f64; 3]| {
        let is_new = || {
            let apart_m2 = (APART * d_m) * (APART * d_m);
            places[2..].iter().all(|place| {
                let between = offset(*place, at_m);
                between[0] * between[0] + between[1] * between[1] + between[2] * between[2] > apart_m2
            })
        };
        if is_new() && (is_open(clearance, at_m, start.yaw_rad) || is_open(clearance, at_m, slot.yaw_rad)) {
            places.push(at_m);
        }
    };
    for share in [0.25, 0.5, 0.75] {
        offer(std::array::from_fn(|k| start.position_m[k] + share * way_m[k]));
    }
    for pose in [start, slot] {
        for axis in 0..3 {
            let side_m = 2.0 * clearance.half_m[axis];
            for out_m in [0.5 * side_m, 1.02 * side_m, 1.05 * d_m] {
                for sign in [1.0, -1.0] {
                    let mut arm = [0.0; 3];
                    arm[axis] = sign * out_m;
                    offer(sum(pose.position_m, turned(arm, pose.yaw_rad)));
                }
            }
        }
    }
    let is_in_zone =
        |at_m: [f64; 3]| [start, slot].iter().any(|pose| length(offset(pose.position_m, at_m)) <= d_m);
    let mut beside = |body: &Resting, arm: [f64; 3]| {
        let at_m = sum(body.pose.position_m, turned(arm, body.pose.yaw_rad));
        if is_in_zone(at_m) {
            offer(at_m);
        }
    };
    for body in &clearance.resting {
        let radius_m = clearance.half_m[0].hypot(clearance.half_m[1]);
        for yaw_rad in [start.yaw_rad, slot.yaw_rad] {
            let [x, y, z] = kept_out_m(clearance, body, yaw_rad);
            for up in [-z, 0.0, z] {
                for (sx, sy) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    beside(body, [sx * x, sy * y, up]);
                }
                if up != 0.0 {
                    beside(body, [0.0, 0.0, up]);
                }
            }
        }
        let gap_m = radius_m + BESIDE * d_m;
        for (axis, half_m) in [(0, body.half_m[0]), (1, body.half_m[1])] {
            for sign in [1.0, -1.0] {
                let mut arm = [0.0; 3];
                arm[axis] = sign * (half_m + gap_m);
                beside(body, arm);
            }
        }
    }
    let ahead_rad = azimuth_rad(way_m).unwrap_or(start.yaw_rad);
    if wrap_rad(start.yaw_rad - slot.yaw_rad).abs() >= SAME_RAD {
        let middle_m = std::array::from_fn(|k| start.position_m[k] + 0.5 * way_m[k]);
        for centre_m in [start.position_m, slot.position_m, middle_m] {
            for arm in TURNING.iter().flat_map(|share| around(share * d_m)) {
                let at_m = sum(centre_m, turned(arm, ahead_rad));
                if clearance.turn_is_free(at_m) {
                    offer(at_m);
                }
            }
        }
    }
    for pose in [start, slot] {
        for body in &clearance.resting {
            for at_m in where_spheres_meet(pose.position_m, body.pose.position_m, d_m) {
                offer(at_m);
            }
        }
    }
    for body in &clearance.resting {
        for arm in around(AROUND * d_m) {
            offer(sum(body.pose.position_m, turned(arm, ahead_rad)));
        }
    }
}

/// Whether the mover's centre may be there at that heading.
fn is_open(clearance: &Clearance, at_m: [f64; 3], yaw_rad: f64) -> bool {
    clearance.leg_is_free(at_m, at_m, yaw_rad)
}

/// Half the box around a body that the mover's centre keeps out of at a heading, and a little more.
fn kept_out_m(clearance: &Clearance, body: &Resting, yaw_rad: f64) -> [f64; 3] {
    let (sin, cos) = (yaw_rad - body.pose.yaw_rad).sin_cos();
    let ([length, width, height], [x, y, z]) = (clearance.half_m, body.half_m);
    let gap_m = BESIDE * clearance.distance_m;
    [
        x + length * cos.abs() + width * sin.abs() + gap_m,
        y + length * sin.abs() + width * cos.abs() + gap_m,
        z + height + gap_m,
    ]
}

/// Eight places on the circle that is at the same distance `d_m` from both, a little farther out; none where there is no circle.
fn where_spheres_meet(a: [f64; 3], b: [f64; 3], d_m: f64) -> impl Iterator<Item = [f64; 3]> {
    const CIRCLE: usize = 8;
    const OUT: f64 = 1.01;
    let way = offset(a, b);
    let apart_m = length(way);
    let radius_m = (d_m * d_m - apart_m * apart_m / 4.0).max(0.0).sqrt();
    let count = if apart_m < 1e-6 * d_m || radius_m == 0.0 { 0 } else { CIRCLE };
    let axis = way.map(|component| component / apart_m);
    // Level, and the third direction; any level one where the axis is upright.
    let level = cross(axis, [0.0, 0.0, 1.0]);
    let across = if length(level) > 1e-6 { level.map(|c| c / length(level)) } else { [1.0, 0.0, 0.0] };
    let third = cross(axis, across);
    (0..count).map(move |k| {
        let (sin, cos) = (k as f64 / CIRCLE as f64 * TAU).sin_cos();
        std::array::from_fn(|n| a[n] + 0.5 * way[n] + OUT * radius_m * (cos * across[n] + sin * third[n]))
    })
}

/// The faces, the corners and the upright edges of a cube, all at the same distance.
fn around(radius_m: f64) -> impl Iterator<Item = [f64; 3]> {
    let corner_m = radius_m / 3.0_f64.sqrt();
    let faces = (0..6).map(move |face| {
        let mut arm = [0.0; 3];
        arm[face / 2] = if face % 2 == 0 { radius_m } else { -radius_m };
        arm
    });
    let corners = (0..8)
        .map(move |corner| std::array::from_fn(|k| if corner >> k & 1 == 0 { corner_m } else { -corner_m }));
    let edge_m = radius_m / 2.0_f64.sqrt();
    let edges = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let edges = edges.into_iter().map(move |[x, y]: [f64; 2]| [x * edge_m, y * edge_m, 0.0]);
    faces.chain(corners).chain(edges)
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + b[k])
}
