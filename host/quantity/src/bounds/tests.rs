use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;

fn bounds(edge_m: &[[f64; 2]]) -> Bounds {
    Bounds { edge_m: edge_m.to_vec(), margin_m: 0.1 }
}

fn square() -> Bounds {
    bounds(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
}

/// An L: the square without its upper right quarter.
fn corner() -> Bounds {
    bounds(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]])
}

#[test]
fn what_is_no_polygon_is_refused() {
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert_eq!(bounds(&bow).validate(), Err(BoundsError::Crossing(1, 3)));
    let spike = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    assert_eq!(bounds(&spike).validate(), Err(BoundsError::Crossing(1, 2)));
    let twice = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    assert_eq!(bounds(&twice).validate(), Err(BoundsError::Crossing(1, 2)));
    assert_eq!(bounds(&bow[..2]).validate(), Err(BoundsError::Count(2)));
    let none = bounds(&[[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]]).validate();
    assert!(matches!(none, Err(BoundsError::Coordinate { vertex: 2, .. })), "{none:?}");
    for good in [square(), corner()] {
        assert_eq!(good.validate(), Ok(()));
        // The other way round it is the same polygon.
        let mut turned = good;
        turned.edge_m.reverse();
        assert_eq!(turned.validate(), Ok(()));
    }
}

#[test]
fn distances_are_those_of_the_nearest_edge() {
    for (point, distance_m) in
        [([0.0, -0.5], 0.5), ([0.5, 0.5], -0.5), ([-0.1, 0.1], 0.1), ([-3.0, 0.0], -2.0), ([0.5, -0.2], 0.2)]
    {
        assert!((corner().distance_m(point) - distance_m).abs() < 1e-12, "{point:?}");
    }
}

/// A rectangle about `at`, turned.
fn rectangle(at: [f64; 2], half: [f64; 2], turn_rad: f64) -> [[f64; 2]; 4] {
    let (sin, cos) = turn_rad.sin_cos();
    [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[a, b]| {
        let (x, y) = (a * half[0], b * half[1]);
        [at[0] + cos * x - sin * y, at[1] + sin * x + cos * y]
    })
}

#[test]
fn a_hull_has_the_room_that_its_nearest_part_has() {
    let half = [0.2, 0.1];
    for (at, turn_rad, room_m) in [
        ([0.0, -0.5], 0.0, 0.4),
        // Its right end is nearest to the re-entrant corner, straight above.
        ([-0.2, -0.2], 0.0, 0.1),
        ([0.9, -0.5], 0.0, -0.1),
        // The re-entrant corner is inside of it, and all of its corners but one are in the water.
        ([-0.1, -0.05], 0.0, -0.05),
    ] {
        let found_m = corner().room_m(&rectangle(at, half, turn_rad));
        assert!((found_m - room_m).abs() < 1e-9, "{at:?}: {found_m} m, not {room_m}");
    }
    // A pier thinner than the hull, which lies across it: every corner is in the water.
    let pier = bounds(&[
        [-2.0, -1.0],
        [2.0, -1.0],
        [2.0, 1.0],
        [0.01, 1.0],
        [0.01, -0.5],
        [-0.01, -0.5],
        [-0.01, 1.0],
        [-2.0, 1.0],
    ]);
    pier.validate().expect("a polygon");
    assert!(pier.room_m(&rectangle([0.0, 0.3], half, 0.0)) < -0.09);
}

/// Against points all over the hull's rim and inside it: none is nearer, and one is as near.
#[test]
fn the_room_is_that_of_dense_samples() {
    for seed in 0..400 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let water = if seed % 2 == 0 { square() } else { corner() };
        let at = [rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2)];
        let (half, turn_rad) = ([0.24, 0.17], rng.random_range(-3.0..3.0));
        let outline = rectangle(at, half, turn_rad);
        // Either way round.
        let room_m = water.room_m(&outline);
        let mut turned = outline;
        turned.reverse();
        assert!((room_m - water.room_m(&turned)).abs() < 1e-12, "seed {seed}");
        let (mut least_m, steps) = (f64::INFINITY, 60);
        for (i, j) in (0..=steps).flat_map(|i| (0..=steps).map(move |j| (i, j))) {
            let [p, q] = [i, j].map(|k| 2.0 * f64::from(k) / f64::from(steps) - 1.0);
            let (sin, cos) = turn_rad.sin_cos();
            let (x, y) = (p * half[0], q * half[1]);
            least_m = least_m.min(water.distance_m([at[0] + cos * x - sin * y, at[1] + sin * x + cos * y]));
        }
        if least_m > 0.01 {
            assert!((room_m - least_m).abs() < 6e-3, "seed {seed}: {room_m} m, {least_m} m by samples");
        } else if least_m < -0.01 {
            assert!(
                room_m < 0.0 && room_m > least_m - 0.12,
                "seed {seed}: {room_m} m, {least_m} m by samples"
            );
        }
    }
}
