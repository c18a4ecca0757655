//! Sobol's sequence.
//!
//! ```text
//! x_i = i₀v₀ ⊕ i₁v₁ ⊕ … ⊕ s      (i₀ i₁ … the binary digits of i, least first; v_k direction numbers, s the shift)
//! ```
//!
//! Bratley and Fox, *ACM TOMS* 14 (1988), Algorithm 659, with the direction numbers `new-joe-kuo-6` of Joe and Kuo, *SIAM J. Sci.
//! Comput.* 30 (2008). The shift is a random number for each dimension (L'Ecuyer and Lemieux, *Recent advances in randomized
//! quasi-Monte Carlo methods*, 2002): which slices hold a point stays as it is, and points lie anywhere in them.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Dimensions that there are direction numbers for.
pub(super) const DIMENSIONS: usize = 21;
/// Binary digits of a coordinate.
const DIGITS: usize = 32;

/// Of dimensions 2 to 21: degree s and coefficients a of the primitive polynomial, and the first s direction integers m.
const JOE_KUO: [(u32, u32, &[u32]); DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
];

/// `count` points.
pub(super) fn points(count: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let shifts: Vec<u32> = (0..dimensions).map(|_| random.random()).collect();
    shifted(count, &shifts)
}

/// `count` points with the shift of each dimension.
fn shifted(count: usize, shifts: &[u32]) -> Vec<Vec<f64>> {
    let directions: Vec<[u32; DIGITS]> = (0..shifts.len()).map(directions).collect();
    let point = |index: usize| {
        let coordinate = |(directions, shift): (&[u32; DIGITS], &u32)| {
            let set = (0..DIGITS).filter(|&digit| index >> digit & 1 == 1);
            f64::from(set.fold(*shift, |sum, digit| sum ^ directions[digit])) / 2f64.powi(DIGITS as i32)
        };
        directions.iter().zip(shifts).map(coordinate).collect()
    };
    (0..count).map(point).collect()
}

/// Direction numbers of `dimension`, from 0, as fractions of 2³².
fn directions(dimension: usize) -> [u32; DIGITS] {
    let mut v = [0; DIGITS];
    let Some(&(degree, coefficients, first)) = dimension.checked_sub(1).and_then(|at| JOE_KUO.get(at)) else {
        // Van der Corput's sequence.
        return std::array::from_fn(|k| 1 << (DIGITS - 1 - k));
    };
    let s = degree as usize;
    for k in 0..DIGITS {
        v[k] = match first.get(k) {
            Some(m) => m << (DIGITS - 1 - k),
            None => {
                // The recurrence of the primitive polynomial x^s + a₁x^(s−1) + … + 1.
                let start = v[k - s] ^ (v[k - s] >> s);
                let terms = (1..s).filter(|j| coefficients >> (s - 1 - j) & 1 == 1);
                terms.fold(start, |sum, j| sum ^ v[k - j])
            }
        };
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the first 2⁸ points of `scipy.stats.qmc.Sobol(d=21, scramble=False)` (SciPy 1.17.1), in the order of the first coordinate, some, in
    /// 1/256.
    const SCIPY: [(usize, [u32; DIMENSIONS]); 4] = [
        (1, [1, 255, 197, 147, 157, 251, 227, 45, 113, 91, 35, 43, 51, 163, 157, 133, 103, 109, 187, 65, 81]),
        (77, [77, 123, 177, 223, 249, 87, 239, 193, 205, 23, 7, 159, 135, 159, 33, 89, 11, 161, 151, 5, 197]),
        (130, [130, 42, 14, 34, 250, 214, 190, 146, 234, 10, 30, 22, 98, 194, 26, 198, 118, 182, 46, 78, 10]),
        (
            255,
            [255, 1, 79, 141, 147, 209, 33, 163, 215, 77, 169, 153, 21, 173, 235, 111, 173, 199, 73, 27, 255],
        ),
    ];
    const DRAWN: u32 = 8;

    #[test]
    fn the_first_points_are_those_of_scipy() {
        // Its order is Gray's; of the first 2ᵏ they are the same.
        let mut points = shifted(1 << DRAWN, &[0; DIMENSIONS]);
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        for (index, told) in SCIPY {
            let found: Vec<u32> = points[index].iter().map(|x| (x * f64::from(1 << DRAWN)) as u32).collect();
            assert_eq!(found, told, "point {index}");
        }
    }

    #[test]
    fn a_shifted_power_of_two_has_one_point_in_every_slice() {
        for (digits, seed) in [(0, 1), (3, 2), (8, 3)] {
            let count = 1_usize << digits;
            let points = points(count, DIMENSIONS, seed);
            for dimension in 0..DIMENSIONS {
                let mut slices: Vec<usize> =
                    points.iter().map(|point| (point[dimension] * count as f64) as usize).collect();
                slices.sort_unstable();
                assert_eq!(slices, (0..count).collect::<Vec<_>>(), "dimension {dimension}, seed {seed}");
            }
        }
        assert_eq!(points(9, 2, 4), points(9, 2, 4));
        assert_ne!(points(9, 2, 4), points(9, 2, 5));
    }
}
