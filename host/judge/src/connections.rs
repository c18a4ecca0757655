//! Who is connected with whom, found anew: faces that meet, and clusters by merging.

use super::{Body, distance_m};

/// Connectors meet within this, m.
const REACH_M: f64 = 0.01;
/// The cosine of how far their normals may be from opposed, 5°.
const TILT_COS: f64 = 0.996_194_698_091_745_5;

/// Centre and normal of every connector in the world.
fn faces(body: &Body<'_>) -> Vec<[[f64; 3]; 2]> {
    let (sin, cos) = body.pose.yaw_rad.sin_cos();
    let turn = |v: [f64; 3]| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
    let mut own: Vec<[[f64; 3]; 2]> =
        body.vehicle.connectors.iter().map(|c| [c.position_m, c.normal]).collect();
    if own.is_empty() {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                own.push([normal.map(|n| n * body.vehicle.box_m[axis] / 2.0), normal]);
            }
        }
    }
    own.into_iter()
        .map(|[arm, normal]| {
            let arm = turn(arm);
            let at = body.pose.position_m;
            [[at[0] + arm[0], at[1] + arm[1], at[2] + arm[2]], turn(normal)]
        })
        .collect()
}

/// Cluster of every body: the same number for bodies that a chain of connections joins.
pub(super) fn clusters(bodies: &[Body<'_>]) -> Vec<usize> {
    let faces: Vec<_> = bodies.iter().map(faces).collect();
    let mut cluster: Vec<usize> = (0..bodies.len()).collect();
    for i in 0..bodies.len() {
        for j in i + 1..bodies.len() {
            let meet = faces[i].iter().any(|[p, n]| {
                faces[j].iter().any(|[q, m]| {
                    let cosine: f64 = n.iter().zip(m).map(|(a, b)| a * b).sum();
                    distance_m(*p, *q) <= REACH_M && cosine <= -TILT_COS
                })
            });
            if meet {
                let (from, to) = (cluster[j], cluster[i]);
                cluster.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
            }
        }
    }
    cluster
}
