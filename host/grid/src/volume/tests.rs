use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::theta::{Search, cost, smooth};

fn random(rng: &mut ChaCha8Rng, side_max: u32, share: f64) -> Volume {
    let size = std::array::from_fn(|_| rng.random_range(1..=side_max));
    let mut volume = Volume::new(size).expect("a map");
    for cell in cells(size) {
        if rng.random_bool(share) {
            volume.block(cell);
        }
    }
    volume
}

fn cells(size: [u32; 3]) -> Vec<[u32; 3]> {
    (0..size[2]).flat_map(|z| (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y, z]))).collect()
}

fn vertex(volume: &Volume, cell: [u32; 3]) -> usize {
    volume.vertex(cell).expect("on the map")
}

/// Sight, point by point. All planes are met at multiples of 1/(2·|Δx|·|Δy|·|Δz|): those points and the ones halfway
/// between them touch every cell that the leg touches.
fn sampled_sight(volume: &Volume, from: [u32; 3], to: [u32; 3]) -> bool {
    let d: [i64; 3] = std::array::from_fn(|axis| i64::from(to[axis]) - i64::from(from[axis]));
    let points = 4 * d.iter().map(|d| d.abs().max(1)).product::<i64>();
    (0..=points).all(|k| {
        // On each axis the layers whose closed interval [c − ½, c + ½] holds the point.
        let layers: [Vec<i64>; 3] = std::array::from_fn(|axis| {
            let twice = 2 * (i64::from(from[axis]) * points + d[axis] * k) + points;
            let layer = twice.div_euclid(2 * points);
            if twice % (2 * points) == 0 { vec![layer - 1, layer] } else { vec![layer] }
        });
        let is_free = |cell: [i64; 3]| {
            let cell = cell.map(|c| u32::try_from(c).ok());
            let [Some(x), Some(y), Some(z)] = cell else { return false };
            volume.vertex([x, y, z]).is_some_and(|vertex| volume.is_open(vertex))
        };
        layers[0].iter().all(|&x| layers[1].iter().all(|&y| layers[2].iter().all(|&z| is_free([x, y, z]))))
    })
}

#[test]
fn sight_is_exact_and_neighbours_are_the_free_legs_to_them() {
    let (mut seen, mut hidden) = (0, 0);
    for seed in 0..60 {
        let volume = random(&mut ChaCha8Rng::seed_from_u64(seed), 5, 0.02 + 0.004 * seed as f64);
        let cells = cells(volume.size);
        for &from in &cells {
            let mut offered = Vec::new();
            volume.for_neighbours(vertex(&volume, from), |next, cost| offered.push((next, cost)));
            offered.sort_by_key(|&(next, _)| next);
            let mut expected = Vec::new();
            for &to in &cells {
                let sight = sampled_sight(&volume, from, to);
                let leg = volume.leg(vertex(&volume, from), vertex(&volume, to));
                assert_eq!(leg.is_some(), sight, "seed {seed}: {from:?} to {to:?} on {volume:?}");
                *(if sight { &mut seen } else { &mut hidden }) += 1;
                let apart: Vec<_> = from.iter().zip(&to).map(|(a, b)| a.abs_diff(*b)).collect();
                let squared = apart.iter().map(|d| d * d).sum::<u32>();
                if apart.iter().max() == Some(&1) && sight {
                    expected.push((vertex(&volume, to), f64::from(squared).sqrt()));
                }
            }
            assert_eq!(offered, expected, "seed {seed}: {from:?} on {volume:?}");
        }
    }
    assert!(seen > 20_000 && hidden > 20_000, "{seen} seen, {hidden} hidden");
}

#[test]
fn theta_star_in_three_dimensions() {
    let mut search = Search::new();
    let (mut theta_sum, mut smoothed_sum, mut along_sum, mut count) = (0.0, 0.0, 0.0, 0);
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut volume = Volume::new([24, 24, 24]).expect("a map");
        for _ in 0..24 {
            // Boxes of up to eight cells along a side.
            let corner: [u32; 3] = std::array::from_fn(|_| rng.random_range(0..22));
            let size: [u32; 3] = std::array::from_fn(|_| rng.random_range(1..8));
            for cell in cells(size) {
                volume.block(std::array::from_fn(|axis| corner[axis] + cell[axis]));
            }
        }
        for _ in 0..10 {
            let place = std::array::from_fn(|_| rng.random_range(0..24));
            let goal = std::array::from_fn(|_| rng.random_range(0..24));
            let (from, to) = (vertex(&volume, place), vertex(&volume, goal));
            let (theta, along) = (search.theta_star(&volume, from, to), search.a_star(&volume, from, to));
            let (Some(theta), Some(along)) = (&theta, &along) else {
                assert!(theta.is_none() && along.is_none(), "seed {seed}: one of the two found a way");
                continue;
            };
            let straight = volume.distance(from, to);
            assert!(theta.cost >= straight * (1.0 - 1e-12), "seed {seed}: shorter than straight");
            for pair in theta.path.windows(2) {
                let ends = [volume.place(pair[0]), volume.place(pair[1])];
                assert!(sampled_sight(&volume, ends[0], ends[1]), "seed {seed}: {ends:?}");
            }
            smoothed_sum += cost(&volume, &smooth(&volume, &along.path)).expect("free legs");
            theta_sum += theta.cost;
            along_sum += along.cost;
            count += 1;
        }
    }
    println!(
        "3D, {count} queries: Theta* is {:.4} of the length along 26 moves, smoothed A* {:.4}",
        theta_sum / along_sum,
        smoothed_sum / along_sum
    );
    assert!(count > 200);
    assert!(theta_sum <= smoothed_sum, "{theta_sum} cells against {smoothed_sum} after smoothing");
}

#[test]
fn places_and_sizes() {
    let volume = Volume::new([4, 3, 2]).expect("a map");
    assert_eq!(volume.last(), [3, 2, 1]);
    for cell in cells(volume.size) {
        assert_eq!(volume.place(vertex(&volume, cell)), cell);
    }
    for outside in [[4, 0, 0], [0, 3, 0], [0, 0, 2]] {
        assert_eq!(volume.vertex(outside), None);
        assert!(!volume.clone().block(outside));
    }
    assert!(Volume::new([0, 1, 1]).is_none() && Volume::new([1, 1, SIDE_MAX + 1]).is_none());
    assert!(Volume::new([SIDE_MAX; 3]).is_none());
}
