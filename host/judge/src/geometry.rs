//! Level boxes against each other by clipping their outlines, which is not how the planner does it.

use reconfiguration::pose::Pose;

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
