//! The reference of the servo at one instant, and angles on the circle: wrapping, sine and cosine.
//!
//! A pose is a point on the circle: φ and φ + 2π are the same tail. Every cycle expresses its angles from its
//! own end pose, wrapped into (−π, π], so that single precision never decays however many turns a tail has
//! made. Between two cycles a reference may therefore step by whole turns; [`wrap`] the difference of two
//! angles before using it. Within a cycle it does not step.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | φ | tail angle, counter-clockwise from the sway axis x_S | rad |
//! | φ̇, φ̈ | its rate and acceleration, relative to the body | rad/s, rad/s² |

use core::f32::consts::{FRAC_PI_2, PI, TAU};

/// Angle, rate and acceleration of the tail at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// Tail angle φ, rad, counter-clockwise from x_S; continuous modulo 2π.
    pub angle_rad: f32,
    /// Rate φ̇, rad/s.
    pub rate_rad_s: f32,
    /// Acceleration φ̈, rad/s².
    pub acceleration_rad_s2: f32,
}

impl Reference {
    /// Standing still at `angle_rad` (rad).
    #[must_use]
    pub const fn at_rest(angle_rad: f32) -> Self {
        Self { angle_rad, rate_rad_s: 0.0, acceleration_rad_s2: 0.0 }
    }

    /// True when it stands still.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        libm::fabsf(self.rate_rad_s) + libm::fabsf(self.acceleration_rad_s2) <= 0.0
    }

    /// True when no component is NaN or infinite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.angle_rad.is_finite() && self.rate_rad_s.is_finite() && self.acceleration_rad_s2.is_finite()
    }
}

/// 2π in two parts (Cody and Waite): the first has so few bits that its product with a number of turns below
/// 2¹⁶ is exact, the second is the rest.
const TAU_HIGH: f32 = 6.281_25;
const TAU_LOW: f32 = 0.001_935_307_2;

/// The nearest whole number, for |x| < 2²². Adding 1.5·2²³ leaves no bits for a fraction: two additions, where
/// `libm::roundf` takes the number apart.
fn nearest(x: f32) -> f32 {
    const NO_FRACTION: f32 = 12_582_912.0;
    (x + NO_FRACTION) - NO_FRACTION
}

/// `value` between `low` and `high`. It takes any bounds, where `f32::clamp` panics: `high` wins. NaN gives `low`.
///
/// Not by `max` and `min`, which a Cortex-M4F calls a function for.
pub(crate) const fn limit(value: f32, low: f32, high: f32) -> f32 {
    let raised = if value > low { value } else { low };
    if raised < high { raised } else { high }
}

/// The same pose in (−π, π], rad. NaN for NaN and the infinities.
///
/// Good to 1e-6 rad up to 1000 turns; beyond 10⁴ turns the spacing of `f32` itself leaves nothing to wrap.
#[must_use]
pub fn wrap(angle_rad: f32) -> f32 {
    let turns = nearest(angle_rad / TAU);
    let wrapped_rad = (angle_rad - turns * TAU_HIGH) - turns * TAU_LOW;
    // Rounding may leave it one step outside.
    if wrapped_rad > PI {
        (wrapped_rad - TAU).max(-PI)
    } else if wrapped_rad <= -PI {
        (wrapped_rad + TAU).min(PI)
    } else {
        wrapped_rad
    }
}

/// sin and cos of 2π·`turns`, for any number of turns that `f32` can tell apart. NaN for NaN and the infinities.
///
/// In single precision throughout: `libm::sincosf` works in `f64`, which a Cortex-M4F or M33 does in software. Given
/// turns instead of radians the quadrant is split off without rounding. On |r| ≤ π/4 the minimax polynomials
/// of S. Moshier's Cephes library (`sinf.c`), good to 1.5e-7:
///
/// sin r ≈ r + r³·(s₁ + s₂r² + s₃r⁴),   cos r ≈ 1 − r²/2 + r⁴·(c₁ + c₂r² + c₃r⁴)
#[must_use]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    const S: [f32; 3] = [-1.666_665_5e-1, 8.332_161e-3, -1.951_529_6e-4];
    const C: [f32; 3] = [4.166_664_6e-2, -1.388_731_6e-3, 2.443_315_7e-5];

    // Quarter turns from −2 to 2, of which `quadrant` are whole.
    let quarters = 4.0 * (turns - nearest(turns));
    let quadrant = nearest(quarters);
    let r = (quarters - quadrant) * FRAC_PI_2;
    let z = r * r;
    let [s1, s2, s3] = S;
    let sin = r + r * z * (s1 + z * (s2 + z * s3));
    let [c1, c2, c3] = C;
    let cos = 1.0 - 0.5 * z + z * z * (c1 + z * (c2 + z * c3));
    if libm::fabsf(quadrant) > 1.5 {
        (-sin, -cos)
    } else if quadrant > 0.5 {
        (cos, -sin)
    } else if quadrant < -0.5 {
        (-cos, sin)
    } else {
        (sin, cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn wraps_hand_worked_angles() {
        for (angle_rad, expected_rad) in [
            (0.0, 0.0),
            (3.0, 3.0),
            (4.0, 4.0 - core::f64::consts::TAU),
            (-4.0, core::f64::consts::TAU - 4.0),
            (100.0, 100.0 - 16.0 * core::f64::consts::TAU),
            (-1000.0, 159.0 * core::f64::consts::TAU - 1000.0),
        ] {
            let wrapped_rad = f64::from(wrap(angle_rad));
            assert!((wrapped_rad - expected_rad).abs() < 1e-6, "{angle_rad} → {wrapped_rad}");
        }
        // π as f32 lies just beyond π, so either end is right; the range is not negotiable.
        for end in [PI, -PI, 3.0 * PI, -3.0 * PI] {
            let wrapped_rad = wrap(end);
            assert!(wrapped_rad > -PI && wrapped_rad <= PI && wrapped_rad.abs() > PI - 1e-6, "{end}");
        }
        assert!(wrap(f32::NAN).is_nan() && wrap(f32::INFINITY).is_nan());
    }

    #[test]
    fn sine_and_cosine_agree_with_double_precision() {
        let mut worst = 0.0_f64;
        for k in -300_000_i32..300_000 {
            let turns = k as f32 / 100_000.0;
            let (sin, cos) = sin_cos_turns(turns);
            let (sin64, cos64) = (f64::from(turns) * core::f64::consts::TAU).sin_cos();
            worst = worst.max((f64::from(sin) - sin64).abs()).max((f64::from(cos) - cos64).abs());
        }
        assert!(worst < 1.5e-7, "{worst:e}");
        for (turns, exact) in
            [(0.0, (0.0, 1.0)), (0.25, (1.0, 0.0)), (0.5, (0.0, -1.0)), (-0.25, (-1.0, 0.0))]
        {
            assert_eq!(sin_cos_turns(turns), exact, "{turns} turns");
        }
        assert!(sin_cos_turns(f32::NAN).0.is_nan() && sin_cos_turns(f32::INFINITY).1.is_nan());
    }

    proptest! {
        #[test]
        fn stays_on_the_circle(angle_rad in -6000.0_f32..6000.0) {
            let wrapped_rad = wrap(angle_rad);
            prop_assert!(wrapped_rad > -PI && wrapped_rad <= PI);
            let (sin, cos) = f64::from(angle_rad).sin_cos();
            let (sin_wrapped, cos_wrapped) = f64::from(wrapped_rad).sin_cos();
            prop_assert!((sin - sin_wrapped).abs() < 2e-6 && (cos - cos_wrapped).abs() < 2e-6);
        }

        #[test]
        fn takes_any_number(bits in any::<u32>()) {
            let _ = (wrap(f32::from_bits(bits)), sin_cos_turns(f32::from_bits(bits)));
        }
    }
}
