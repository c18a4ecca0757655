//! Tail geometry, collision regions and distance to collision against oracles that share no code with them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use modboat::distance::{DistanceToCollision, Outline};
use modboat::motion::Swing;
use modboat::parameters::Parameters;
use modboat::region::{CollisionRegion, DEPTH_RAD};
use modboat::tail::{CLEARANCE_TOLERANCE_M, Tail};
use modboat::tube::Tube;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};

/// Geometries of tails: the default, long enough for diagonals, slim, and barely long enough to touch.
fn tails() -> Vec<Tail> {
    let tail = |length, width| Tail { pitch_m: 0.15, length_m: 0.15 * length, width_m: 0.15 * width };
    vec![tail(0.6, 0.1), tail(0.8, 0.15), tail(0.7, 0.03), tail(0.47, 0.1), tail(0.451, 0.1)]
}

/// Distance of two centre lines by sampling one and measuring to the other: off by at most half a sample.
fn sampled_clearance(tail: &Tail, offset: [i32; 2], phi_i: f64, phi_j: f64) -> f64 {
    const SAMPLES: i32 = 3000;
    let root = [f64::from(offset[0]) * tail.pitch_m, f64::from(offset[1]) * tail.pitch_m];
    let mut least = f64::INFINITY;
    for k in 0..=SAMPLES {
        let r = tail.length_m * f64::from(k) / f64::from(SAMPLES);
        let p = [r * phi_i.cos() - root[0], r * phi_i.sin() - root[1]];
        let along = (p[0] * phi_j.cos() + p[1] * phi_j.sin()).clamp(0.0, tail.length_m);
        least = least.min((p[0] - along * phi_j.cos()).hypot(p[1] - along * phi_j.sin()));
    }
    least - tail.width_m
}

fn pose(rng: &mut impl Rng) -> [f64; 2] {
    [rng.random_range(-TAU..TAU), rng.random_range(-TAU..TAU)]
}

#[test]
fn clearance_agrees_with_sampling() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for tail in tails() {
        for offset in [[1, 0], [0, 1], [1, 1], [1, -1], [-1, 0]] {
            for _ in 0..200 {
                let p = pose(&mut rng);
                let (exact, sampled) =
                    (tail.clearance_m(offset, p[0], p[1]), sampled_clearance(&tail, offset, p[0], p[1]));
                assert!(exact <= sampled + 1e-12 && sampled < exact + 5e-5, "{tail:?} {offset:?} {p:?}");
            }
        }
    }
}

#[test]
fn clearance_keeps_the_symmetries_of_the_pair() {
    let (tail, mut rng) = (tails()[0], ChaCha8Rng::seed_from_u64(2));
    for _ in 0..2000 {
        let [a, b] = pose(&mut rng);
        let side = tail.clearance_m([1, 0], a, b);
        let same = |other: f64| assert!((side - other).abs() < 1e-12, "{a} {b}: {side} {other}");
        same(tail.clearance_m([1, 0], -a, -b));
        same(tail.clearance_m([1, 0], b + PI, a + PI));
        same(tail.clearance_m([-1, 0], b, a));
        same(tail.clearance_m([0, 1], a + FRAC_PI_2, b + FRAC_PI_2));
        same(tail.clearance_m([1, 0], a + TAU, b - TAU));
    }
}

#[test]
fn reach_by_hand_and_by_sweep() {
    let default = Tail::new(&Parameters::default());
    assert_eq!(default.reachable_offsets(), [[1, 0], [0, 1]]);
    // cos φ = (1 + 0.36 − 0.49) / 1.2 = 0.725
    assert!((default.reach_rad([1, 0]) - 0.725_f64.acos()).abs() < 1e-12);
    assert!((default.reach_rad([0, 1]) - 0.7597).abs() < 1e-4);
    assert!(default.reach_rad([1, 1]).abs() < 1e-15);
    assert_eq!(tails()[1].reachable_offsets(), [[1, 0], [0, 1], [1, 1], [1, -1]]);
    let short = Tail { length_m: 0.06, ..default };
    assert!(short.reachable_offsets().is_empty());
    for tail in tails() {
        for offset in [[1, 0], [0, 1], [1, 1], [1, -1], [2, 0], [2, 1], [-1, 0]] {
            let axis = f64::from(offset[1]).atan2(f64::from(offset[0]));
            let reach = tail.reach_rad(offset);
            let touches = |off: f64| {
                (0..4000).any(|k| tail.clearance_m(offset, axis + off, f64::from(k) * TAU / 4000.0) < 0.0)
            };
            assert!(!touches(reach + 1e-6) && !touches(-reach - 1e-6), "{tail:?} {offset:?}");
            assert!(reach <= 0.0 || touches(0.98 * reach), "{tail:?} {offset:?}");
            let canonical = offset[0] > 0 || (offset[0] == 0 && offset[1] > 0);
            assert_eq!(
                tail.reachable_offsets().contains(&offset),
                canonical && reach > 0.0,
                "{tail:?} {offset:?}"
            );
        }
    }
}

#[test]
fn clearance_along_agrees_with_dense_sampling() {
    let (mut rng, mut collisions) = (ChaCha8Rng::seed_from_u64(3), 0);
    for k in 0..2000 {
        let (tail, offset) = (tails()[k % 5], [[1, 0], [0, 1], [1, 1]][k % 3]);
        let from = pose(&mut rng);
        // Every fourth motion turns tail i alone, every eighth none.
        let mut to = pose(&mut rng);
        if k % 4 == 0 {
            to[1] = from[1];
        }
        if k % 8 == 0 {
            to[0] = from[0];
        }
        let at = |share: f64| {
            let [a, b] = [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
            tail.clearance_m(offset, a, b)
        };
        const SAMPLES: i32 = 4000;
        let sampled =
            (0..=SAMPLES).map(|k| at(f64::from(k) / f64::from(SAMPLES))).fold(f64::INFINITY, f64::min);
        // Between two samples a tip moves at most this far.
        let turn = (to[0] - from[0]).abs() + (to[1] - from[1]).abs();
        let slack = tail.length_m * turn / f64::from(SAMPLES) / 2.0 + CLEARANCE_TOLERANCE_M + 1e-12;
        let found = tail.least_along_m(offset, from, to, f64::INFINITY);
        assert!(found <= sampled + CLEARANCE_TOLERANCE_M, "{k}: {found} {sampled}");
        assert!(found >= sampled - slack, "{k}: {found} {sampled}");
        let back = tail.least_along_m(offset, to, from, f64::INFINITY);
        assert!((back - found).abs() <= CLEARANCE_TOLERANCE_M, "{k}");
        if sampled.abs() > slack {
            assert_eq!(tail.collides_along(offset, from, to), sampled < 0.0, "{k}: {sampled}");
        }
        if (sampled - 0.01).abs() > slack {
            assert_eq!(tail.clears_along(offset, from, to, 0.01), sampled > 0.01, "{k}: {sampled}");
        }
        collisions += u32::from(sampled < 0.0);
    }
    assert!((200..1800).contains(&collisions), "{collisions} of 2000 collide");
    let tail = tails()[0];
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(tail.collides_along([1, 0], [0.0, 0.0], [bad, 0.0]), "{bad}");
    }
}

/// The region lies within the exact one and misses nothing deeper than [`DEPTH_RAD`]. Depth is measured by the exact test
/// on circles: if every point of the circle of that radius collides, and its centre too, the centre lies deeper.
#[test]
fn polygons_hold_no_free_pose_and_miss_none_that_lies_deep() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for tail in tails() {
        for offset in tail.reachable_offsets() {
            let region = CollisionRegion::new(&tail, offset);
            let [polygon] = region.polygons() else { panic!("one polygon expected: {tail:?} {offset:?}") };
            println!("{tail:?} {offset:?}: {} vertices", polygon.len());
            let (centre, reach) = (region.centre(), tail.reach_rad(offset));
            let (mut inside, mut missed) = (0, 0);
            let points = if tail == tails()[0] { 100_000 } else { 30_000 };
            for k in 0..points {
                let p = match k % 4 {
                    // Anywhere, unwrapped; around the region; close to its edge, where mistakes are made.
                    0 => pose(&mut rng),
                    1 => centre.map(|c| c + rng.random_range(-1.1 * reach..1.1 * reach)),
                    _ => {
                        let n = rng.random_range(0..polygon.len());
                        let (a, b) = (polygon[n], polygon[(n + 1) % polygon.len()]);
                        let share = rng.random_range(0.0..1.0);
                        let spread = 2.0 * DEPTH_RAD.min(0.05 * reach);
                        [0, 1].map(|k| a[k] + share * (b[k] - a[k]) + rng.random_range(-spread..spread))
                    }
                };
                let collides = |x: f64, y: f64| tail.clearance_m(offset, x, y) < 0.0;
                if region.contains(p) {
                    inside += 1;
                    assert!(collides(p[0], p[1]), "{tail:?} {offset:?} {p:?}: free, but in the polygon");
                } else if collides(p[0], p[1]) {
                    missed += 1;
                    let on_circle = |k: i32| {
                        let (sin, cos) = (f64::from(k) * TAU / 512.0).sin_cos();
                        collides(p[0] + DEPTH_RAD * cos, p[1] + DEPTH_RAD * sin)
                    };
                    assert!(
                        !(0..512).all(on_circle),
                        "{tail:?} {offset:?} {p:?}: deep, but not in the polygon"
                    );
                }
            }
            assert!(
                inside > points / 10 && missed > points / 100,
                "{tail:?} {offset:?}: {inside} inside, {missed} missed"
            );
        }
    }
}

#[test]
fn regions_lie_where_the_tails_point_at_each_other_and_repeat() {
    let tail = tails()[0];
    let side = CollisionRegion::new(&tail, [1, 0]);
    let stacked = CollisionRegion::new(&tail, [0, 1]);
    assert!(side.contains([0.0, PI]) && side.contains([TAU, -PI]) && !side.contains([PI, 0.0]));
    assert!(stacked.contains([FRAC_PI_2, -FRAC_PI_2]) && !stacked.contains([0.0, PI]));
    let count = side.polygons()[0].len();
    assert!((60..=150).contains(&count), "{count} vertices");
    // Centres at 0, ±2π by ±π, and those beyond the square that reach into it.
    assert_eq!(side.copies([-TAU; 2], [TAU; 2]).len(), 3 * 2);
    assert_eq!(side.copies([-0.1, PI - 0.1], [0.1, PI + 0.1]), side.polygons());
    // Two pictures of the same thing, a quarter turn apart.
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let differ = (0..20_000)
        .map(|_| pose(&mut rng))
        .filter(|p| side.contains(*p) != stacked.contains([p[0] + FRAC_PI_2, p[1] + FRAC_PI_2]))
        .count();
    assert!(differ < 20, "{differ} of 20000 differ");
    let short = Tail { length_m: 0.06, ..tail };
    assert!(CollisionRegion::new(&short, [1, 0]).polygons().is_empty());
    let none = DistanceToCollision::new(&Parameters { tail_length_m: 0.06, ..Parameters::default() });
    assert!(none.offsets().is_empty() && none.along(0, [0.0; 2], [1.0; 2]) == f64::INFINITY);
}

/// The square 0 … 4 by 0 … 4, by hand.
#[test]
fn four_cases_of_distance_to_collision_by_hand() {
    let square = Outline::new(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
    let is = |from: [f64; 2], to: [f64; 2], expected: f64| {
        for (a, b) in [(from, to), (to, from)] {
            let doc = square.distance(a, b);
            assert!((doc - expected).abs() < 1e-12, "{a:?} to {b:?}: {doc}, expected {expected}");
        }
    };
    // 1: beside an edge, with an end towards an edge, off a corner, a pose.
    is([-1.0, 6.5], [9.0, 6.5], 2.5);
    is([5.5, 1.0], [9.0, 2.0], 1.5);
    is([7.0, 8.0], [9.0, 9.0], 5.0);
    is([4.0, 6.0], [6.0, 4.0], 2.0_f64.sqrt());
    is([2.0, 7.0], [2.0, 7.0], 3.0);
    // 2: G = (0, 2), B = (3, 2).
    is([-5.0, 2.0], [3.0, 2.0], -3.0);
    // 3: |AB| = 2, |AG| = 0.5, |BH| = 1.5; and slanting, G = (0, 0), H = (4, 4).
    is([0.5, 1.0], [2.5, 1.0], -2.5);
    is([1.0, 1.0], [2.0, 2.0], -2.0 * 2.0_f64.sqrt());
    // 4: |GH| = 4, |AG| = 3, |BH| = 1.
    is([-3.0, 1.0], [5.0, 1.0], -5.0);
    // A pose inside: minus its distance from the boundary.
    is([1.0, 2.0], [1.0, 2.0], -1.0);
}

/// A U of two prongs, each 1 wide with a gap of 2: first entry, last exit.
#[test]
fn a_line_that_cuts_more_than_twice_counts_from_first_entry_to_last_exit() {
    let u = Outline::new(&[
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ]);
    let doc = |a: f64, b: f64| u.distance([a, 2.0], [b, 2.0]);
    let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    is(doc(-2.0, 7.0), -6.0); // through both: |GH| = 4, |AG| = 2, |BH| = 3
    is(doc(-2.0, 3.5), -3.5); // into the second: |BG|
    is(doc(0.25, 3.5), -3.5); // from the first to the second: |AB| = 3.25, |AG| = 0.25, |BH| = 0.5
    is(doc(1.5, 2.5), 0.5); // between them
    is(doc(1.5, 9.0), -2.5); // out through the second: G = 3, H = 4, |GH| + |AG| = 1 + 1.5
}

/// DoC against one polygon from its definition: all cuts of the line sorted, all distances.
fn plain_doc(polygon: &[[f64; 2]], a: [f64; 2], b: [f64; 2]) -> f64 {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let e = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    let uv = |p: [f64; 2]| {
        ((p[0] - a[0]) * e[0] + (p[1] - a[1]) * e[1], (p[1] - a[1]) * e[0] - (p[0] - a[0]) * e[1])
    };
    let to_segment = |p: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        let (d, o) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let t = ((d[0] * o[0] + d[1] * o[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
        (o[0] - t * d[0]).hypot(o[1] - t * d[1])
    };
    let (mut cuts, mut least) = (Vec::new(), f64::INFINITY);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let ((u, v), (x, y)) = (uv(p), uv(q));
        if (v > 0.0) != (y > 0.0) {
            cuts.push(u + (x - u) * v / (v - y));
        }
        least = least.min(to_segment(p, a, b)).min(to_segment(a, p, q)).min(to_segment(b, p, q));
    }
    cuts.sort_by(f64::total_cmp);
    // The line is inside between cut 0 and 1, 2 and 3, and so on; those stretches that AB meets count.
    let met: Vec<_> = cuts.chunks(2).filter(|s| s[0] <= length && s[1] >= 0.0).collect();
    match (met.first(), met.last()) {
        (Some(first), Some(last)) => -(last[1].min(length - first[0])),
        _ => least,
    }
}

#[test]
fn distance_over_all_copies_agrees_with_its_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for tail in [tails()[0], tails()[1]] {
        let parameters =
            Parameters { tail_length_m: tail.length_m, tail_width_m: tail.width_m, ..Parameters::default() };
        let doc = DistanceToCollision::new(&parameters);
        let copies: Vec<_> =
            doc.regions().iter().map(|r| r.copies([-4.0 * TAU; 2], [4.0 * TAU; 2])).collect();
        let (mut negatives, mut spared) = (0, 0);
        for k in 0..3000 {
            let index = k % doc.offsets().len();
            let from = pose(&mut rng);
            let span = [5.2, 1.0, 9.0][k % 3];
            let to = from.map(|x| x + rng.random_range(-span..span));
            let plain = copies[index].iter().map(|p| plain_doc(p, from, to)).fold(f64::INFINITY, f64::min);
            let found = doc.along(index, from, to);
            assert!((found - plain).abs() < 1e-9, "{k} {from:?} {to:?}: {found}, {plain}");
            negatives += u32::from(found < 0.0);
            assert!((doc.along(index, to, from) - plain).abs() < 1e-9, "{k}: backwards");
            let turned = |p: [f64; 2]| [p[0] + 3.0 * TAU, p[1] - 7.0 * TAU];
            assert!((doc.along(index, turned(from), turned(to)) - plain).abs() < 1e-9, "{k}: turned");
            for margin in [-1.0, -0.1, 0.0, 0.2, 1.0, 3.0] {
                if margin >= 0.0 {
                    let bounded = doc.along_bounded(index, [from, to], margin);
                    let low = if plain < margin { plain } else { margin };
                    assert!(
                        bounded >= low - 1e-9 && bounded <= plain + 1e-9,
                        "{k}: {margin}: {bounded} {plain}"
                    );
                    spared += usize::from(plain > margin && bounded > margin);
                }
                if (plain - margin).abs() > 1e-9 {
                    assert_eq!(doc.clear(index, from, to, margin), plain > margin, "{k}: {margin} {plain}");
                }
            }
        }
        assert!((300..2900).contains(&negatives), "{negatives} of 3000 collide");
        assert!(spared > 1000, "a bound beyond the margin is what it is for: {spared}");
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert!(!doc.clear(0, [0.0, 0.0], [bad, 0.0], 0.0) && !doc.clear(0, [bad, 0.0], [bad, 0.1], 0.0));
        }
    }
}

/// DoC ≥ 0 exactly when no sampled pose is in the region, and a DoC of 2·DEPTH is free by the exact test.
#[test]
fn a_motion_collides_exactly_when_its_distance_is_negative() {
    let (doc, mut rng) = (DistanceToCollision::new(&Parameters::default()), ChaCha8Rng::seed_from_u64(7));
    let mut collisions = 0;
    for k in 0..3000 {
        let index = k % 2;
        let [c_i, c_j, a_i, a_j] = [0; 4].map(|_| rng.random_range(-PI..PI));
        let swing = |centerline_rad, amplitude_rad| Swing { centerline_rad, amplitude_rad };
        let d = doc.swim(index, swing(c_i, a_i), swing(c_j, a_j));
        let share = |n: i32| (f64::from(n) * PI / 3000.0).cos();
        let (region, offset) = (&doc.regions()[index], doc.offsets()[index]);
        let hit = (0..=3000).any(|n| region.contains([c_i + a_i * share(n), c_j + a_j * share(n)]));
        // A motion that only cuts a corner slips between two samples.
        if d.abs() > 0.01 {
            assert_eq!(d < 0.0, hit, "{k}: {d}");
        }
        assert!(d < 0.0 || !hit, "{k}: {d}");
        let (from, to) = ([c_i + a_i, c_j + a_j], [c_i - a_i, c_j - a_j]);
        let exact = doc.tail().collides_along(offset, from, to);
        assert!(d < 2.0 * DEPTH_RAD || !exact, "{k}: {d}");
        assert!(d > -0.02 || exact, "{k}: {d}");
        collisions += u32::from(hit);
    }
    assert!((300..2700).contains(&collisions), "{collisions} of 3000 collide");
}

/// The tube about a motion: its least clearance against poses sampled over every pair of errors, and what the search makes of it.
#[test]
fn the_clearance_of_a_tube_is_the_least_over_all_errors() {
    let seed = 9;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let parameters = Parameters::default();
    let doc = DistanceToCollision::new(&parameters);
    let tail = doc.tail();
    let (mut free, mut hit) = (0, 0);
    for k in 0..400 {
        let index = k % doc.offsets().len();
        let offset = doc.offsets()[index];
        // Near the pose in which the tails point at each other, where it matters.
        let centre = doc.regions()[index].centre();
        let from = centre.map(|x| x + rng.random_range(-1.6..1.6));
        let span = [5.2, 1.0, 0.0][k % 3];
        let to = from.map(|x| if span > 0.0 { x + rng.random_range(-span..span) } else { x });
        for tube in Tube::ALL {
            let error_rad = doc.errors().of(tube);
            let least_m = tail.tube_clearance_m(offset, from, to, error_rad, f64::INFINITY);
            // Densely along the motion, and over the box there.
            let steps = 1 + (200.0 * span) as usize;
            let mut sampled_m = f64::INFINITY;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                for (a, b) in (0..5).flat_map(|a| (0..5).map(move |b| (a, b))) {
                    let off = [a, b].map(|n| error_rad * (f64::from(n) / 2.0 - 1.0));
                    let at = [0, 1].map(|k| from[k] + share * (to[k] - from[k]) + off[k]);
                    sampled_m = sampled_m.min(tail.clearance_m(offset, at[0], at[1]));
                }
            }
            // Samples see a little less than the least, never more; far apart the least may lie within.
            let far_m = tail.pitch_m - tail.length_m - tail.width_m;
            let cap = |clearance_m: f64| clearance_m.min(far_m);
            assert!(
                cap(least_m) <= cap(sampled_m) + 2e-5 && cap(least_m) >= cap(sampled_m) - 2e-3,
                "seed {seed}, {k}, {tube:?}: {least_m} m, {sampled_m} m sampled"
            );
            // What the search takes for free is; what it refuses is hardly so.
            let clear = doc.tube_clear(tube, index, from, to);
            assert!(!clear || least_m > 0.0, "seed {seed}, {k}, {tube:?}: {least_m} m");
            let wider_m = tail.tube_clearance_m(offset, from, to, error_rad + 3.0 * DEPTH_RAD, f64::INFINITY);
            assert!(clear || wider_m <= 0.0, "seed {seed}, {k}, {tube:?}: {wider_m} m");
            *(if clear { &mut free } else { &mut hit }) += 1;
        }
    }
    assert!(free > 200 && hit > 200, "{free} free, {hit} not");
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(tail.tube_clearance_m([1, 0], [bad, 0.0], [0.0; 2], 0.02, f64::INFINITY) < 0.0);
        assert!(!doc.tube_clear(Tube::Both, 0, [0.0; 2], [bad, 0.0]));
    }
}
