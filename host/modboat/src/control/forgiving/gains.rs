//! State feedback for one axis, from the model: mass or inertia, and drag linearised at the speed.
//!
//! ```text
//! x⁺ = x + g v + b₁ a,   v⁺ = ε v + b₂ a,   ε = e^(−λh),  g = b₂ = (1 − ε)/λ,  b₁ = (h − g)/λ       (g1)
//! (z − p)² = det(zI − A + BK):   K₁ = (1 − p)²/(b₁(1 − ε) + b₂ g),   K₂ = (1 + ε − 2p − b₁K₁)/b₂   (g2)
//! p = e^(−h/τ)
//! ```
//!
//! with a held over the interval h, and λ the slope of the drag over the mass, 1/s. τ is the time constant of the double pole.

/// K of a = −K₁·x − K₂·v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gains {
    /// K₁, 1/s².
    pub position_1_s2: f64,
    /// K₂, 1/s.
    pub velocity_1_s: f64,
}

impl Gains {
    /// For an interval of `interval_s`, drag of slope `drag_1_s`, and the time constant `time_s`.
    pub(super) fn placed(interval_s: f64, drag_1_s: f64, time_s: f64) -> Self {
        let h = interval_s;
        let p = (-h / time_s).exp();
        // As λ → 0: g = h, b₁ = h²/2.
        let lambda = drag_1_s.max(1e-4);
        let epsilon = (-lambda * h).exp();
        let g = (1.0 - epsilon) / lambda;
        let (b_1, b_2) = ((h - g) / lambda, g);
        // K₁ = (1 − p)²/(b₁(1 − ε) + b₂ g),   K₂ = (1 + ε − 2p − b₁K₁)/b₂                            (g2)
        let position_1_s2 = (1.0 - p).powi(2) / (b_1 * (1.0 - epsilon) + b_2 * g);
        Self { position_1_s2, velocity_1_s: (1.0 + epsilon - 2.0 * p - b_1 * position_1_s2) / b_2 }
    }

    /// The acceleration against an error of position and velocity.
    pub(super) fn against(self, position: f64, velocity: f64) -> f64 {
        -self.position_1_s2 * position - self.velocity_1_s * velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_decays_with_the_placed_pole_at_any_drag() {
        for (h, drag, time_s) in [(1.5, 0.0, 3.0), (2.0, 0.3, 3.0), (1.5, 1.0, 5.0)] {
            let gains = Gains::placed(h, drag, time_s);
            let (mut x, mut v) = (1.0, 0.0);
            let mut last = [1.0, 0.0];
            for _ in 0..40 {
                let a = gains.against(x, v);
                for _ in 0..3000 {
                    let dt = h / 3000.0;
                    let mean_v = v + 0.5 * dt * (a - drag * v);
                    x += dt * mean_v;
                    v += dt * (a - drag * mean_v);
                }
                last = [x, last[0]];
            }
            // A double pole: x ~ (α + β·n)·pⁿ.
            let p = (-h / time_s).exp();
            assert!((last[0] / last[1] / p - 1.0).abs() < 0.05, "{h} {drag} {time_s}: {last:?}");
        }
    }
}
