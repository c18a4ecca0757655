//! The distance of two tails' centre lines as the least of a quadratic over a square, clamped one variable at a time
//! (C. Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9).

/// Distance, m, between two segments of `length_m`: one from the origin in the direction `phi_i`, one from `apart_m` in
/// the direction `phi_j`, rad.
///
/// ```text
/// least over s, t ∈ [0, 1] of |s·d₁ − o − t·d₂|²
/// s = clamp((b·f − c·e)/(a·e − b²)),  t = (b·s + f)/e,  and s again where t had to be clamped
/// with r = −o, a = d₁·d₁, b = d₁·d₂, c = d₁·r, e = d₂·d₂, f = d₂·r
/// ```
#[must_use]
pub fn between_tails_m(length_m: f64, apart_m: [f64; 2], phi_i: f64, phi_j: f64) -> f64 {
    let d1 = [length_m * phi_i.cos(), length_m * phi_i.sin()];
    let d2 = [length_m * phi_j.cos(), length_m * phi_j.sin()];
    let product = |u: [f64; 2], v: [f64; 2]| u[0] * v[0] + u[1] * v[1];
    let r = [-apart_m[0], -apart_m[1]];
    let (a, b, c) = (product(d1, d1), product(d1, d2), product(d1, r));
    let (e, f) = (product(d2, d2), product(d2, r));
    let determinant = a * e - b * b;
    // Parallel: any s will do, the clamping of t puts it right.
    let mut s =
        if determinant > 1e-14 * a * e { ((b * f - c * e) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (b * s + f) / e;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((b * t - c) / a).clamp(0.0, 1.0);
    }
    let gap = [0, 1].map(|k| s * d1[k] - apart_m[k] - t * d2[k]);
    product(gap, gap).sqrt()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn hand_worked_distances() {
        let near = |apart, phi_i, phi_j, expected: f64| {
            let distance = between_tails_m(0.09, apart, phi_i, phi_j);
            assert!((distance - expected).abs() < 1e-12, "{apart:?} {phi_i} {phi_j}: {distance}, {expected}");
        };
        // Away from each other, side by side, towards each other; one on the way of the other's tip.
        near([0.15, 0.0], PI, 0.0, 0.15);
        near([0.15, 0.0], FRAC_PI_2, FRAC_PI_2, 0.15);
        near([0.15, 0.0], 0.0, PI, 0.0);
        near([0.15, 0.0], 0.0, FRAC_PI_2, 0.06);
        near([0.0, 0.15], FRAC_PI_2, PI, 0.06);
        near([0.15, 0.15], 0.0, -FRAC_PI_2, 0.06_f64.hypot(0.06));
    }

    #[test]
    fn as_near_as_the_nearest_of_many_points() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..500 {
            let apart = [rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2)];
            let (phi_i, phi_j) = (rng.random_range(-7.0..7.0_f64), rng.random_range(-7.0..7.0_f64));
            let mut least = f64::INFINITY;
            for m in 0..=90 {
                for n in 0..=90 {
                    let (r, q) = (1e-3 * f64::from(m), 1e-3 * f64::from(n));
                    let gap = [
                        r * phi_i.cos() - apart[0] - q * phi_j.cos(),
                        r * phi_i.sin() - apart[1] - q * phi_j.sin(),
                    ];
                    least = least.min(gap[0].hypot(gap[1]));
                }
            }
            let distance = between_tails_m(0.09, apart, phi_i, phi_j);
            // Points a millimetre apart miss the nearest by at most half of that on each segment.
            assert!(distance <= least + 1e-12 && least <= distance + 1e-3, "{apart:?} {phi_i} {phi_j}");
        }
    }
}
