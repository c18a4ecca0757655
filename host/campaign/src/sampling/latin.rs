//! Latin hypercubes.
//!
//! ```text
//! x_ij = (π_j(i) + u_ij) / n
//! ```
//!
//! McKay, Beckman and Conover, *Technometrics* 21 (1979): π_j is a random permutation of 0 … n − 1 for each dimension j, u_ij uniform
//! in [0, 1).

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};

/// `count` points.
pub(super) fn points(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut points = vec![vec![0.0; dimensions]; count];
    for dimension in 0..dimensions {
        let order = permutation(count, &mut random);
        for (point, slice) in points.iter_mut().zip(order) {
            let within: f64 = random.random();
            // Rounding must not carry a point over into the next slice.
            point[dimension] = ((slice as f64 + within) / count as f64).min(below(slice + 1, count));
        }
    }
    points
}

/// The greatest number below `slice`/`count`.
fn below(slice: usize, count: usize) -> f64 {
    (slice as f64 / count as f64).next_down()
}

/// 0 … `count` − 1 in random order, by Fisher and Yates.
fn permutation(count: usize, random: &mut impl Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, random.random_range(0..=last));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slice_of_every_dimension_has_one_point() {
        for (count, dimensions, seed) in [(1, 1, 1), (7, 3, 2), (100, 12, 3), (3, 40, u64::MAX)] {
            let points = points(count, dimensions, seed);
            assert_eq!(points.len(), count);
            for dimension in 0..dimensions {
                let mut slices: Vec<usize> =
                    points.iter().map(|point| (point[dimension] * count as f64) as usize).collect();
                slices.sort_unstable();
                assert_eq!(slices, (0..count).collect::<Vec<_>>(), "{count} × {dimensions}, seed {seed}");
            }
        }
        assert_eq!(points(9, 2, 4), points(9, 2, 4));
        assert_ne!(points(9, 2, 4), points(9, 2, 5));
    }
}
