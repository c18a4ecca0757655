//! The repulsive field of §II-C: whether the step that the attractive field asks for leads a module out of
//! collisions or into them.
//!
//! ```text
//! D₀ = D(φ₀ᵢ, Aᵢ, φ₀ⱼ, Aⱼ),  D_φ = D(φ₀ᵢ + dφ, Aᵢ, …),  D_A = D(φ₀ᵢ, Aᵢ + dA, …)    (11)
//! U_φ = Σⱼ sgn(D_φ − D₀)·S(D₀),   U_A = Σⱼ sgn(D_A − D₀)·S(D₀)                       (12)
//! ```
//!
//! S(D) is the stepped function of the paper's Fig. 4. Its numbers are not in the text, those here are
//! *assumed*: each level doubles, so that one bad collision outweighs three of the level below and, with at
//! most four neighbours, the worst collision mostly decides.
//!
//! | D, rad | S |
//! |---|---|
//! | ≥ margin | 0 |
//! | 0 … margin | 1 |
//! | −0.25 … 0 | 2 |
//! | −0.75 … −0.25 | 4 |
//! | −1.5 … −0.75 | 8 |
//! | below −1.5 | 16 |

/// S(D) for a distance to collision in rad (negative inside), zero from `margin_rad` on.
#[must_use]
pub fn strength(distance_rad: f64, margin_rad: f64) -> f64 {
    if distance_rad >= margin_rad {
        0.0
    } else if distance_rad >= 0.0 {
        1.0
    } else if distance_rad >= -0.25 {
        2.0
    } else if distance_rad >= -0.75 {
        4.0
    } else if distance_rad >= -1.5 {
        8.0
    } else {
        16.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strength_never_grows_with_distance_and_ends_at_the_margin() {
        let margin = 0.1;
        let mut last = f64::INFINITY;
        for k in -4000..1000 {
            let s = strength(f64::from(k) * 1e-3, margin);
            assert!(s <= last);
            last = s;
        }
        assert!(strength(margin - 1e-9, margin) > 0.0);
        assert!(strength(margin, margin) == 0.0);
        assert!(strength(-3.0, margin) > strength(-0.1, margin));
    }
}
