//! Thrust that one module can give from a given rest pose: that of a cycle which starts and ends there.
//!
//! With the tail resting at p and a cycle of signed amplitude A, φ₀ = p − A (so that φ₀ + A = p), law (7) gives
//!
//! ```text
//! u(p, A) = −F(|A|)·(cos(p − A), sin(p − A)) = R(p)·u₀(A),   u₀(A) = −F(|A|)·(cos A, −sin A)
//! ∂u/∂A   = −F'·sgn A·(cos φ₀, sin φ₀) + F·(−sin φ₀, cos φ₀)
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

use crate::parameters::Parameters;

/// Amplitudes of each sign in the coarse set.
const STEPS: usize = 12;
/// Directions in which the support function is tabulated: a power of two.
const DIRECTIONS: usize = 256;
/// So many directions, beyond what any angle has.
const POSITIVE: f64 = (1_u64 << 36) as f64;
/// What the tabulated support may be too small by, as a share of the greatest thrust: half a step of the direction costs 0.0123 at
/// most, half a step of the amplitude 0.003.
pub const SUPPORT_ERROR: f64 = 0.016;

/// The coarse set of amplitudes with their thrusts, and what they reach.
#[derive(Clone, Debug)]
pub struct Law {
    /// Amplitudes of the coarse set, rad; the first is rest.
    pub amplitudes_rad: Vec<f64>,
    /// Their thrusts u₀, N.
    pub thrusts_n: Vec<[f64; 2]>,
    /// Greatest thrust in each of evenly spaced directions, by the signs allowed, N.
    support_n: [Vec<f64>; 3],
    slope_n_rad: f64,
    offset_n: f64,
    /// Range of |A|, rad.
    pub range_rad: [f64; 2],
}

impl Law {
    /// The law of modules with these parameters.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let range_rad = [parameters.amplitude_min_rad, parameters.amplitude_max_rad];
        let step_rad = (range_rad[1] - range_rad[0]) / (STEPS - 1) as f64;
        let magnitudes = (0..STEPS).map(|k| range_rad[0] + k as f64 * step_rad);
        let amplitudes_rad: Vec<f64> = std::iter::once(0.0).chain(magnitudes.flat_map(|a| [a, -a])).collect();
        let mut law = Self {
            amplitudes_rad,
            thrusts_n: Vec::new(),
            support_n: Default::default(),
            slope_n_rad: parameters.force_slope_n_rad,
            offset_n: parameters.force_offset_n,
            range_rad,
        };
        law.thrusts_n = law.amplitudes_rad.iter().map(|&a| law.thrust_n(a)).collect();
        let towards = |[x, y]: [f64; 2], k: usize| {
            let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            x * cos + y * sin
        };
        law.support_n = [Sign::Minus, Sign::Plus, Sign::Any].map(|sign| {
            let pushes = || law.amplitudes_rad.iter().zip(&law.thrusts_n).filter(|(a, _)| sign.allows(**a));
            let most = |k: usize| pushes().map(|(_, &u)| towards(u, k)).fold(f64::NEG_INFINITY, f64::max);
            (0..DIRECTIONS).map(most).collect()
        });
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

    /// What a cycle from this pose pushes, and how that changes with its amplitude, which must not be zero.
    #[must_use]
    pub fn push(&self, rest_rad: f64, amplitude_rad: f64) -> Push {
        let thrust_n = self.slope_n_rad * amplitude_rad.abs() - self.offset_n;
        let grows = self.slope_n_rad * amplitude_rad.signum();
        let (sin, cos) = (rest_rad - amplitude_rad).sin_cos();
        // ∂u/∂A = −F'·sgn A·(cos φ₀, sin φ₀) + F·(−sin φ₀, cos φ₀)
        Push {
            thrust_n: [-thrust_n * cos, -thrust_n * sin],
            by_amplitude: [-grows * cos - thrust_n * sin, -grows * sin + thrust_n * cos],
        }
    }

    /// The most that an amplitude of this sign pushes in a direction off the rest pose, N, to [`SUPPORT_ERROR`]. Where any sign
    /// will do, zero, by resting, where all push away.
    #[must_use]
    pub fn support_n(&self, sign: Sign, off_rad: f64) -> f64 {
        // The nearest direction; the low bits take off whole turns. What is added makes it positive, where a cast rounds down, and is
        // a whole number of turns.
        let nearest = (off_rad * (DIRECTIONS as f64 / TAU) + 0.5 + POSITIVE) as i64;
        self.support_n[sign as usize][(nearest & (DIRECTIONS as i64 - 1)) as usize]
    }
}

/// u(p, A) in S, N, and ∂u/∂A, N/rad.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// u.
    pub thrust_n: [f64; 2],
    /// ∂u/∂A.
    pub by_amplitude: [f64; 2],
}

/// Which amplitudes a module may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Negative ones.
    Minus,
    /// Positive ones.
    Plus,
    /// Either, or rest.
    Any,
}

impl Sign {
    /// That of an amplitude; `None` for rest, which pushes nothing.
    #[must_use]
    pub fn of(amplitude_rad: f64) -> Option<Self> {
        match amplitude_rad {
            0.0 => None,
            _ if amplitude_rad < 0.0 => Some(Self::Minus),
            _ => Some(Self::Plus),
        }
    }

    fn allows(self, amplitude_rad: f64) -> bool {
        self == Self::Any || Self::of(amplitude_rad) == Some(self)
    }
}
