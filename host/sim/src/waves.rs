//! Small waves on deep water: a regular one, and an irregular sea with the spectrum of JONSWAP.
//!
//! ```text
//! η = a·cos(k·x − ωt + ε),   u = aω·cos(k·x − ωt + ε),   u̇ = aω²·sin(k·x − ωt + ε),   k = ω²/g             (w1)
//! S(f) ∝ f⁻⁵·exp(−5/4·(f/f_p)⁻⁴)·γ^exp(−(f/f_p − 1)²/(2σ²)),   σ = 0.07 (f ≤ f_p), 0.09 (f > f_p)           (w2)
//! aᵢ = √(2·S(fᵢ)·Δf),   H_s = 4·√(∫S df)                                                                    (w3)
//! ```
//!
//! (w1) is linear wave theory (Airy) at the surface; u goes along the wave's direction. (w2) is the spectrum of Hasselmann et al.,
//! *Measurements of wind-wave growth and swell decay during the Joint North Sea Wave Project*, 1973, scaled to the significant
//! height H_s by (w3). [`COMPONENTS`] waves stand for it, each at a frequency drawn within its own share of 0.5 f_p to 3 f_p, so that
//! the sea does not repeat.
//!
//! A floating module that displaces its own mass feels (m + m_a)·u̇ (Froude-Krylov force and added mass), and drag by its velocity
//! through the water. Assumptions and limits: waves are low against their length and the structure does not change them; no heave, pitch
//! or roll, no drift of second order; every wave of a sea goes the same way.

use std::f64::consts::TAU;

use quantity::{ParameterError, Range, check_ranges};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

/// Acceleration of gravity g, m/s².
const GRAVITY_M_S2: f64 = 9.81;
/// Height over length at which waves on deep water break (Michell 1893).
const BREAKING: f64 = 0.142;
/// Waves that stand for an irregular sea.
pub const COMPONENTS: usize = 48;
/// Where they lie, in peak frequencies: 99 % of the energy of (w2).
const BAND: [f64; 2] = [0.5, 3.0];

/// What both kinds of waves have: height, m, period, s, and direction, rad.
fn check(height_m: f64, period_s: f64, direction_rad: f64) -> Result<(), ParameterError> {
    check_ranges(&[
        ("height_m", height_m, "m", Range::NonNegative),
        ("period_s", period_s, "s", Range::Positive),
        ("direction_rad", direction_rad, "rad", Range::Finite),
    ])
}

/// One regular wave. *Assumed.*
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaveParameters {
    /// From trough to crest, m; zero: none.
    pub(crate) height_m: f64,
    /// Period, s.
    pub(crate) period_s: f64,
    /// Where it goes, rad counter-clockwise from world x.
    pub(crate) direction_rad: f64,
}

impl Default for WaveParameters {
    fn default() -> Self {
        Self { height_m: 0.0, period_s: 1.0, direction_rad: 0.0 }
    }
}

impl WaveParameters {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        check(self.height_m, self.period_s, self.direction_rad)?;
        does_not_break("height_m", self.height_m, self.period_s)
    }
}

/// An irregular sea. *Assumed.*
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JonswapParameters {
    /// Significant height H_s, m; zero: none.
    pub(crate) height_m: f64,
    /// Period of the peak 1/f_p, s.
    pub(crate) period_s: f64,
    /// Peakedness γ. JONSWAP's mean.
    pub(crate) peakedness: f64,
    /// Where the waves go, rad counter-clockwise from world x.
    pub(crate) direction_rad: f64,
}

impl Default for JonswapParameters {
    fn default() -> Self {
        Self { height_m: 0.0, period_s: 1.0, peakedness: 3.3, direction_rad: 0.0 }
    }
}

impl JonswapParameters {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        check(self.height_m, self.period_s, self.direction_rad)?;
        if !(1.0..=10.0).contains(&self.peakedness) {
            let reason = "must lie between 1 and 10";
            return Err(ParameterError { key: "peakedness", value: self.peakedness, unit: "", reason });
        }
        does_not_break("height_m", self.height_m, self.period_s)
    }

    /// (w2) at `ratio` = f/f_p, but for a factor.
    fn shape(&self, ratio: f64) -> f64 {
        let width: f64 = if ratio <= 1.0 { 0.07 } else { 0.09 };
        // f⁻⁵·exp(−5/4·(f/f_p)⁻⁴)·γ^exp(−(f/f_p − 1)²/(2σ²))                                        (w2)
        let peak = (-(ratio - 1.0).powi(2) / (2.0 * width * width)).exp();
        ratio.powi(-5) * (-1.25 * ratio.powi(-4)).exp() * self.peakedness.powf(peak)
    }
}

fn does_not_break(key: &'static str, height_m: f64, period_s: f64) -> Result<(), ParameterError> {
    let length_m = GRAVITY_M_S2 * period_s * period_s / TAU;
    if height_m > BREAKING * length_m {
        let reason = "such a wave breaks: it is higher than 0.142 of its length g·T²/2π";
        return Err(ParameterError { key, value: height_m, unit: "m", reason });
    }
    Ok(())
}

/// One wave.
#[derive(Clone, Copy, Debug)]
struct Component {
    amplitude_m: f64,
    frequency_rad_s: f64,
    /// k along its direction, rad/m.
    number_rad_m: [f64; 2],
    direction: [f64; 2],
    phase_rad: f64,
}

impl Component {
    fn new(amplitude_m: f64, frequency_rad_s: f64, direction_rad: f64, phase_rad: f64) -> Self {
        let (sin, cos) = direction_rad.sin_cos();
        // k = ω²/g                                                                                (w1)
        let number_rad_m = [cos, sin].map(|share| share * frequency_rad_s * frequency_rad_s / GRAVITY_M_S2);
        Self { amplitude_m, frequency_rad_s, number_rad_m, direction: [cos, sin], phase_rad }
    }
}

/// All waves of a tank.
#[derive(Clone, Debug, Default)]
pub(crate) struct Waves {
    components: Vec<Component>,
}

impl Waves {
    /// With phases and frequencies drawn from `seed`; that of the regular wave is zero at the origin at time zero.
    pub(crate) fn new(regular: &WaveParameters, sea: &JonswapParameters, seed: u64) -> Self {
        let mut components = Vec::new();
        if regular.height_m > 0.0 {
            let frequency_rad_s = TAU / regular.period_s;
            let amplitude_m = 0.5 * regular.height_m;
            components.push(Component::new(amplitude_m, frequency_rad_s, regular.direction_rad, 0.0));
        }
        if sea.height_m > 0.0 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let share = (BAND[1] - BAND[0]) / COMPONENTS as f64;
            let drawn: Vec<(f64, f64)> = (0..COMPONENTS)
                .map(|k| (BAND[0] + share * (k as f64 + rng.random::<f64>()), TAU * rng.random::<f64>()))
                .collect();
            let whole: f64 = drawn.iter().map(|(ratio, _)| sea.shape(*ratio)).sum();
            for (ratio, phase_rad) in drawn {
                // aᵢ = √(2·S(fᵢ)·Δf),   H_s = 4·√(∫S df)                                          (w3)
                let amplitude_m = 0.25 * sea.height_m * (2.0 * sea.shape(ratio) / whole).sqrt();
                let frequency_rad_s = TAU * ratio / sea.period_s;
                components.push(Component::new(amplitude_m, frequency_rad_s, sea.direction_rad, phase_rad));
            }
        }
        Self { components }
    }

    pub(crate) fn is_calm(&self) -> bool {
        self.components.is_empty()
    }

    /// Velocity, m/s, and acceleration, m/s², of the water at a place in the world.
    pub(crate) fn at(&self, t_s: f64, [x_m, y_m]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let (mut velocity_m_s, mut acceleration_m_s2) = ([0.0; 2], [0.0; 2]);
        for wave in &self.components {
            let along_rad = wave.number_rad_m[0] * x_m + wave.number_rad_m[1] * y_m;
            let (sin, cos) = (along_rad - wave.frequency_rad_s * t_s + wave.phase_rad).sin_cos();
            // u = aω·cos(k·x − ωt + ε),   u̇ = aω²·sin(k·x − ωt + ε)                                (w1)
            let u_m_s = wave.amplitude_m * wave.frequency_rad_s;
            for axis in [0, 1] {
                velocity_m_s[axis] += wave.direction[axis] * u_m_s * cos;
                acceleration_m_s2[axis] += wave.direction[axis] * u_m_s * wave.frequency_rad_s * sin;
            }
        }
        (velocity_m_s, acceleration_m_s2)
    }
}

#[cfg(test)]
mod tests;
