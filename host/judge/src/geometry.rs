//! Level boxes against each other by clipping their outlines, which is not how the planner does it.

use reconfiguration::pose::Pose;

use super::distance_m;

/// Boxes may run into each other by this much, m.
const TOUCH_M: f64 = 1e-3;

/// Corners of the outline of a box seen from above, in the order of growing angle about z.
fn outline(pose: Pose, [length_m, width_m]: [f64; 2]) -> Vec<[f64; 2]> {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]
        .map(|[ahead, aside]| {
            let (a, b) = (ahead * length_m, aside * width_m);
            [pose.position_m[0] + cos * a - sin * b, pose.position_m[1] + sin * a + cos * b]
        })
        .to_vec()
}

/// Twice the signed area left of the line from `a` to `b`, as seen by `p`.
fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// The part of a convex outline on the inner side of the line from `a` to `b`.
fn clipped(outline: &[[f64; 2]], a: [f64; 2], b: [f64; 2]) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for (k, &here) in outline.iter().enumerate() {
        let next = outline[(k + 1) % outline.len()];
        let (own, other) = (side(a, b, here), side(a, b, next));
        if own >= 0.0 {
            kept.push(here);
        }
        if (own > 0.0 && other < 0.0) || (own < 0.0 && other > 0.0) {
            let share = own / (own - other);
            kept.push([here[0] + share * (next[0] - here[0]), here[1] + share * (next[1] - here[1])]);
        }
    }
    kept
}

fn area_m2(outline: &[[f64; 2]]) -> f64 {
    let corner = |k: usize| outline[k % outline.len()];
    (0..outline.len())
        .map(|k| 0.5 * (corner(k)[0] * corner(k + 1)[1] - corner(k)[1] * corner(k + 1)[0]))
        .sum()
}

/// Whether two level boxes (length, width, height) share more than a touch.
pub(super) fn overlap(first: (Pose, [f64; 3]), second: (Pose, [f64; 3])) -> bool {
    let [(a, size_a), (b, size_b)] = [first, second];
    // Nothing overlaps beyond half the sum of the diagonals.
    let reach_m: f64 = size_a.iter().zip(size_b).map(|(a, b)| (a + b).powi(2)).sum();
    if distance_m(a.position_m, b.position_m) > reach_m.sqrt() {
        return false;
    }
    let apart_m = (a.position_m[2] - b.position_m[2]).abs();
    if apart_m >= (size_a[2] + size_b[2]) / 2.0 - TOUCH_M {
        return false;
    }
    // Seen from the first: far from the world's origin the products of the areas lose what is asked for.
    let [own, other] = [a, b].map(|pose| {
        let position_m = std::array::from_fn(|k| pose.position_m[k] - a.position_m[k]);
        Pose { position_m, ..pose }
    });
    // The first a touch smaller all around.
    let mut common = outline(own, [size_a[0] - 2.0 * TOUCH_M, size_a[1] - 2.0 * TOUCH_M]);
    let fence = outline(other, [size_b[0], size_b[1]]);
    for k in 0..4 {
        common = clipped(&common, fence[k], fence[(k + 1) % 4]);
    }
    common.len() >= 3 && area_m2(&common) > 1e-12
}

/// Radius of the upright cylinder that a level box stays in while it turns, m.
pub(super) fn swing_m([length_m, width_m, _]: [f64; 3]) -> f64 {
    length_m.hypot(width_m) / 2.0
}

/// Whether that cylinder of the first box and the second box share more than a touch.
pub(super) fn swings_into((turning, size): (Pose, [f64; 3]), (pose, other): (Pose, [f64; 3])) -> bool {
    let apart_m = (turning.position_m[2] - pose.position_m[2]).abs();
    if apart_m >= (size[2] + other[2]) / 2.0 - TOUCH_M {
        return false;
    }
    let centre = [turning.position_m[0], turning.position_m[1]];
    let fence = outline(pose, [other[0], other[1]]);
    let edges = (0..4).map(|k| (fence[k], fence[(k + 1) % 4]));
    // Inside, or nearer to an edge than the radius.
    let is_inside = edges.clone().all(|(a, b)| side(a, b, centre) > 0.0);
    let nearest_m = edges.map(|(a, b)| from_segment_m(a, b, centre)).fold(f64::INFINITY, f64::min);
    is_inside || nearest_m < swing_m(size) - TOUCH_M
}

/// Distance of `p` from the straight line between `a` and `b`, m.
fn from_segment_m(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let (edge, way) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = edge[0] * edge[0] + edge[1] * edge[1];
    let share = ((way[0] * edge[0] + way[1] * edge[1]) / squared).clamp(0.0, 1.0);
    (way[0] - share * edge[0]).hypot(way[1] - share * edge[1])
}

/// Least and greatest coordinates of a level box, m.
pub(super) fn extent_m(pose: Pose, box_m: [f64; 3]) -> [[f64; 3]; 2] {
    let corners = outline(pose, [box_m[0], box_m[1]]);
    let mut extent = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for [x, y] in corners {
        for (k, value) in [(0, x), (1, y)] {
            extent[0][k] = extent[0][k].min(value);
            extent[1][k] = extent[1][k].max(value);
        }
    }
    let z = pose.position_m[2];
    (extent[0][2], extent[1][2]) = (z - box_m[2] / 2.0, z + box_m[2] / 2.0);
    extent
}

/// Longest way between two points of a hull's rim that are looked at, m.
const RIM_M: f64 = 0.01;

/// Least distance of a level box, seen from above, from a polygon's edge, m; negative where it sticks out. It is told by points of its rim,
/// and by vertices of the polygon that lie in it.
pub(super) fn edge_room_m(edge_m: &[[f64; 2]], pose: Pose, box_m: [f64; 3]) -> f64 {
    let corners = outline(pose, [box_m[0], box_m[1]]);
    let mut least_m = f64::INFINITY;
    for (k, &here) in corners.iter().enumerate() {
        let next = corners[(k + 1) % corners.len()];
        let steps = (f64::hypot(next[0] - here[0], next[1] - here[1]) / RIM_M).ceil().clamp(1.0, 1e4);
        for step in 0..steps as u32 {
            let share = f64::from(step) / steps;
            let point = [0, 1].map(|axis| here[axis] + share * (next[axis] - here[axis]));
            least_m = least_m.min(from_edge_m(edge_m, point));
        }
    }
    for &vertex in edge_m {
        let depth_m = (0..corners.len()).map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            side(a, b, vertex) / f64::hypot(b[0] - a[0], b[1] - a[1])
        });
        let depth_m = depth_m.fold(f64::INFINITY, f64::min);
        // In the box, a vertex is left of all four sides.
        if depth_m > 0.0 {
            least_m = least_m.min(-depth_m);
        }
    }
    least_m
}

/// Distance of a point from a polygon's edge, negative outside: how often the edge winds round the point tells where it is.
pub(super) fn from_edge_m(edge_m: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let (mut least_m, mut winding_rad) = (f64::INFINITY, 0.0);
    for (k, &a) in edge_m.iter().enumerate() {
        let b = edge_m[(k + 1) % edge_m.len()];
        let ([ax, ay], [bx, by]) = ([0, 1].map(|k| a[k] - point[k]), [0, 1].map(|k| b[k] - point[k]));
        winding_rad += f64::atan2(ax * by - ay * bx, ax * bx + ay * by);
        least_m = least_m.min(from_segment_m(a, b, point));
    }
    if winding_rad.abs() > std::f64::consts::PI { least_m } else { -least_m }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn overlap_by_hand() {
        let unit = [1.0; 3];
        let beside = |x: f64, y: f64, z: f64, yaw: f64| {
            overlap((Pose::default(), unit), ([x, y, z, yaw].into(), unit))
        };
        assert!(beside(0.0, 0.0, 0.0, 0.0) && beside(0.99, 0.99, 0.99, 0.0));
        assert!(!beside(1.0, 0.0, 0.0, 0.0) && !beside(0.0, 1.0, 0.0, 0.0) && !beside(0.0, 0.0, 1.0, 0.0));
        // Half a side and half a diagonal: 0.5 + 0.7071.
        assert!(beside(1.2, 0.0, 0.0, FRAC_PI_4) && !beside(1.21, 0.0, 0.0, FRAC_PI_4));
        // Corner against corner, both turned alike: diagonal apart.
        assert!(beside(0.85, 0.85, 0.0, FRAC_PI_4) && !beside(0.86, 0.86, 0.0, FRAC_PI_4));
        assert!(!overlap(([5.0, 5.0, 0.0, 1.0].into(), unit), (Pose::default(), unit)));
        // The same a million metres away.
        let far = |x: f64| ([1e6 + x, -1e6, 0.0, FRAC_PI_4].into(), unit);
        assert!(overlap(far(0.0), far(1.41)) && !overlap(far(0.0), far(1.42)));
    }

    #[test]
    fn room_to_an_edge_by_hand() {
        // A square of 4 m with a thin pier from the top to the middle.
        let pier = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0], [-0.01, 2.0], [-2.0, 2.0]];
        let room_m = |pose: [f64; 4]| edge_room_m(&pier, pose.into(), [0.4, 0.2, 1.0]);
        for (pose, expected_m) in [
            ([0.0, -1.0, 0.0, 0.0], 0.9),
            ([1.5, -1.0, 7.0, 0.0], 0.3),
            ([1.5, -1.0, 0.0, FRAC_PI_4], 0.5 - 0.3 * FRAC_PI_4.sin()),
            ([1.9, -1.0, 0.0, 0.0], -0.1),
            // The pier's end lies 0.05 m deep in it.
            ([0.0, -0.05, 0.0, 0.0], -0.05),
        ] {
            let found_m = room_m(pose);
            assert!((found_m - expected_m).abs() < 1e-3, "{pose:?}: {found_m} m, not {expected_m} m");
        }
    }

    #[test]
    fn room_to_turn_by_hand() {
        let (hull, other) = ([0.6, 0.8, 0.2], [1.0, 1.0, 0.2]);
        let turns = |x: f64, y: f64, z: f64, yaw: f64| {
            swings_into(([x, y, z, 0.3].into(), hull), ([0.0, 0.0, 0.0, yaw].into(), other))
        };
        // Half the diagonal is 0.5: beside a face, beside a corner, above.
        assert!(turns(0.99, 0.0, 0.0, 0.0) && !turns(1.0, 0.0, 0.0, 0.0));
        assert!(turns(0.85, 0.85, 0.0, 0.0) && !turns(0.86, 0.86, 0.0, 0.0));
        assert!(turns(1.2, 0.0, 0.0, FRAC_PI_4) && !turns(1.21, 0.0, 0.0, FRAC_PI_4));
        assert!(turns(0.1, 0.0, 0.19, 0.0) && !turns(0.1, 0.0, 0.2, 0.0));
    }

    #[test]
    fn a_turned_box_reaches_to_its_corners() {
        let [least, greatest] = extent_m([1.0, 0.0, 2.0, FRAC_PI_4].into(), [1.0, 1.0, 0.5]);
        let half = 0.5_f64.sqrt();
        for (value, expected) in
            least.iter().chain(&greatest).zip([1.0 - half, -half, 1.75, 1.0 + half, half, 2.25])
        {
            assert!((value - expected).abs() < 1e-12);
        }
    }
}
