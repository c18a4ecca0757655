//! What one module can push from a given rest pose without leaving it: the thrust of a cycle that starts and ends there.
//!
//! With the tail resting at p and a cycle of signed amplitude A, φ₀ = p − A (so that φ₀ + A = p), law (7) gives
//!
//! ```text
//! u(p, A) = −F(|A|)·(cos(p − A), sin(p − A)) = R(p)·u₀(A),   u₀(A) = −F(|A|)·(cos A, −sin A)
//! ∂u₀/∂A  = −F'·sgn A·(cos A, −sin A) + F·(sin A, cos A)
//! ```
//!
//! two spirals, one for either sign, that R(p) turns to any pose. A resting module (A = 0) pushes nothing.
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | p | rad | rest pose, where the cycle starts and ends |
//! | A | rad | signed amplitude, abs(A) ∈ \[0.9, 2.6\], or 0 |
//! | F | N | thrust of law (2) |
//! | u, u₀ | N | thrust in S, and in the frame of the rest pose |

use std::f64::consts::TAU;

use crate::modboat::parameters::Parameters;

/// Amplitudes of each sign in the coarse set.
const STEPS: usize = 12;
/// Directions in which the support function is tabulated: a power of two.
const DIRECTIONS: usize = 256;

/// The coarse set of amplitudes with their thrusts, and what they reach.
#[derive(Clone, Debug)]
pub struct Law {
    /// Amplitudes of the coarse set, rad; the first is rest.
    pub amplitudes_rad: Vec<f64>,
    /// Their thrusts u₀, N.
    pub thrusts_n: Vec<[f64; 2]>,
    /// Greatest thrust in each of evenly spaced directions, N.
    support_n: Vec<f64>,
    slope_n_rad: f64,
    offset_n: f64,
    /// Range of |A|, rad.
    pub range_rad: [f64; 2],
}

impl Law {
    /// For modules of one kind.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let range_rad = [parameters.amplitude_min_rad, parameters.amplitude_max_rad];
        let step_rad = (range_rad[1] - range_rad[0]) / (STEPS - 1) as f64;
        let magnitudes = (0..STEPS).map(|k| range_rad[0] + k as f64 * step_rad);
        let amplitudes_rad: Vec<f64> = std::iter::once(0.0).chain(magnitudes.flat_map(|a| [a, -a])).collect();
        let mut law = Self {
            amplitudes_rad,
            thrusts_n: Vec::new(),
            support_n: Vec::new(),
            slope_n_rad: parameters.force_slope_n_rad,
            offset_n: parameters.force_offset_n,
            range_rad,
        };
        law.thrusts_n = law.amplitudes_rad.iter().map(|&a| law.thrust_n(a)).collect();
        law.support_n = (0..DIRECTIONS)
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
                law.thrusts_n.iter().map(|u| u[0] * cos + u[1] * sin).fold(0.0, f64::max)
            })
            .collect();
        law
    }

    /// u₀(A), N.
    #[must_use]
    pub fn thrust_n(&self, amplitude_rad: f64) -> [f64; 2] {
        if amplitude_rad == 0.0 {
            return [0.0; 2];
        }
        // u₀(A) = −F(|A|)·(cos A, −sin A)
        let thrust_n = self.slope_n_rad * amplitude_rad.abs() - self.offset_n;
        let (sin, cos) = amplitude_rad.sin_cos();
        [-thrust_n * cos, thrust_n * sin]
    }

    /// The |A| that thrusts by so much (2), within its range, rad.
    #[must_use]
    pub fn amplitude_rad(&self, thrust_n: f64) -> f64 {
        ((thrust_n + self.offset_n) / self.slope_n_rad).clamp(self.range_rad[0], self.range_rad[1])
    }

    /// u₀(A) and ∂u₀/∂A, N and N/rad; the latter zero at rest.
    #[must_use]
    pub fn thrust_and_slope(&self, amplitude_rad: f64) -> ([f64; 2], [f64; 2]) {
        if amplitude_rad == 0.0 {
            return ([0.0; 2], [0.0; 2]);
        }
        let thrust_n = self.slope_n_rad * amplitude_rad.abs() - self.offset_n;
        let grows = self.slope_n_rad * amplitude_rad.signum();
        let (sin, cos) = amplitude_rad.sin_cos();
        // ∂u₀/∂A = −F'·sgn A·(cos A, −sin A) + F·(sin A, cos A)
        ([-thrust_n * cos, thrust_n * sin], [-grows * cos + thrust_n * sin, grows * sin + thrust_n * cos])
    }

    /// The most that any amplitude pushes in a direction off the rest pose, N; zero, by resting, where all push away.
    #[must_use]
    pub fn support_n(&self, off_rad: f64) -> f64 {
        // The nearest direction; the low bits take off whole turns.
        let nearest = (off_rad * (DIRECTIONS as f64 / TAU) + 0.5).floor() as i64;
        self.support_n[(nearest & (DIRECTIONS as i64 - 1)) as usize]
    }
}

/// `vector` turned by the angle with this (sin, cos).
#[must_use]
pub fn turned([x, y]: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    [cos * x - sin * y, sin * x + cos * y]
}
