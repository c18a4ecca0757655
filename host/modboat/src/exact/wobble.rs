//! How far one cycle turns the structure to and fro.
//!
//! With all tails at one phase ωt of waveform (1), the structure keeps the angular momentum that rotors and strokes do not have:
//!
//! ```text
//! I·Ω = −J·Σφ̇ᵢ + Σ rᵢ × Pᵢ − t·τ,   Pᵢ = −(T/2)·max(0, ½·slope·sᵢ − offset)·u(mᵢ)                 (w1)
//! W² = mean of (Θ − mean of Θ)² over the cycle                                                     (w2)
//! ```
//!
//! sᵢ is what the tail has swept in its stroke, mᵢ the middle of that, u(m) = (cos m, sin m), and τ the mean torque of the cycle. That the impulse grows
//! so within a stroke is *assumed*: flippers open some 1.7 rad after a turn. I is that of the modules without water, so that the structure turns
//! less than W: it is for comparing.

use std::f64::consts::PI;

use quantity::wrap_rad;

use super::neighbours::Cycle;
use crate::parameters::Parameters;

/// Samples of one stroke.
const SAMPLES: usize = 16;

/// What a turn that is over in some cycles counts beside what lasts. *Assumed.*
const ONCE: f64 = 0.3;

/// What (w1) needs of the modules.
#[derive(Clone, Debug)]
pub struct Wobble {
    positions_m: Vec<[f64; 2]>,
    /// Each module's share of law (2).
    shares: Vec<f64>,
    period_s: f64,
    slope_n_rad: f64,
    offset_n: f64,
    /// J, kg·m².
    tail_inertia_kg_m2: f64,
    /// I of the structure without water, kg·m².
    inertia_kg_m2: f64,
}

impl Wobble {
    /// Of modules at `positions_m` (m, in S).
    #[must_use]
    pub fn new(positions_m: &[[f64; 2]], parameters: &Parameters) -> Self {
        let inertia = |[x_m, y_m]: &[f64; 2]| {
            parameters.module_inertia_kg_m2 + parameters.module_mass_kg * (x_m * x_m + y_m * y_m)
        };
        Self {
            positions_m: positions_m.to_vec(),
            shares: (0..positions_m.len()).map(|module| parameters.share(module)).collect(),
            period_s: parameters.period_s,
            slope_n_rad: parameters.force_slope_n_rad,
            offset_n: parameters.force_offset_n,
            tail_inertia_kg_m2: parameters.tail_inertia_kg_m2,
            inertia_kg_m2: positions_m.iter().map(inertia).sum(),
        }
    }

    /// W of these cycles, by module, rad.
    #[must_use]
    pub fn rms_rad(&self, cycles: &[Cycle]) -> f64 {
        let net_rad: f64 = cycles.iter().map(|cycle| cycle.amplitude_rad).sum();
        let step_s = 0.5 * self.period_s / SAMPLES as f64;
        let whole = self.struck_n_m_s(cycles, 1.0, PI);
        // Both strokes end with the impulse of law (2).
        let torque_nm = whole / (0.5 * self.period_s);
        let (mut turned, mut last, mut sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
        let mut turns = [0.0; 2 * SAMPLES];
        // The mean of what is left of the strokes is a steady rate, which the structure does not have.
        let mut rate = 0.0;
        for (sample, turn) in turns.iter_mut().enumerate() {
            let (stroke, at) = (sample / SAMPLES, (sample % SAMPLES + 1) as f64 / SAMPLES as f64);
            let side = if stroke == 0 { 1.0 } else { -1.0 };
            // Σ rᵢ × Pᵢ − t·τ                                                                      (w1)
            let t_s = (stroke as f64 + at) * 0.5 * self.period_s;
            let now = self.struck_n_m_s(cycles, side, PI * at) + stroke as f64 * whole - torque_nm * t_s;
            turned += 0.5 * (last + now) * step_s;
            (last, rate) = (now, rate + now / (2 * SAMPLES) as f64);
            *turn = turned - self.tail_inertia_kg_m2 * net_rad * side * (PI * at).cos();
        }
        for (sample, turn) in turns.iter_mut().enumerate() {
            *turn -= rate * (sample + 1) as f64 * step_s;
            sum += *turn / (2 * SAMPLES) as f64;
            squares += *turn * *turn / (2 * SAMPLES) as f64;
        }
        // W²                                                                                       (w2)
        (squares - sum * sum).max(0.0).sqrt() / self.inertia_kg_m2
    }

    /// W, and a share of the turn, once, that comes of tails which swing about other angles than before: about `about_rad` altogether,
    /// unwrapped, and then about these cycles' when the tails, now at `tails_rad`, have turned the short way. For comparing.
    #[must_use]
    pub fn unrest_rad(&self, cycles: &[Cycle], tails_rad: &[f64], about_rad: f64) -> f64 {
        let about = |(cycle, tail_rad): (&Cycle, &f64)| {
            tail_rad + wrap_rad(cycle.rest_rad - tail_rad) - cycle.amplitude_rad
        };
        let turned_rad = cycles.iter().zip(tails_rad).map(about).sum::<f64>() - about_rad;
        self.rms_rad(cycles) + ONCE * self.tail_inertia_kg_m2 / self.inertia_kg_m2 * turned_rad.abs()
    }

    /// Σ rᵢ × Pᵢ of the stroke that begins on this side of the centre lines, when its phase is `angle` of π.
    fn struck_n_m_s(&self, cycles: &[Cycle], side: f64, angle: f64) -> f64 {
        let swept = 1.0 - angle.cos();
        let one = |((cycle, [x_m, y_m]), share): ((&Cycle, &[f64; 2]), &f64)| {
            let amplitude_rad = side * cycle.amplitude_rad;
            let mean_n = 0.5 * self.slope_n_rad * amplitude_rad.abs() * swept - self.offset_n;
            if mean_n <= 0.0 {
                return 0.0;
            }
            let centre_rad = cycle.rest_rad - cycle.amplitude_rad;
            let (sin, cos) = (centre_rad + amplitude_rad * (1.0 - 0.5 * swept)).sin_cos();
            -0.5 * self.period_s * share * mean_n * (x_m * sin - y_m * cos)
        };
        cycles.iter().zip(&self.positions_m).zip(&self.shares).map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Wobble {
        Wobble::new(&[[-0.15, 0.0], [0.0, 0.0], [0.15, 0.0]], &Parameters::default())
    }

    fn cycles(all: [(f64, f64); 3]) -> Vec<Cycle> {
        let one = |(rest_rad, amplitude_rad)| Cycle { rest_rad, amplitude_rad, free: true, turns: false };
        all.map(one).to_vec()
    }

    #[test]
    fn amplitudes_that_cancel_in_a_mirrored_row_hold_it_still() {
        let still = row().rms_rad(&cycles([(1.9, 1.25), (0.65 - 2.5, -2.5), (1.9, 1.25)]));
        let wobbles = row().rms_rad(&cycles([(1.9, 1.25), (3.15, 2.5), (1.9, 1.25)]));
        assert!(still < 0.1 * wobbles, "{still} {wobbles}");
    }

    /// Rotors alone: J·|ΣA|/√2. Amplitudes too small to push.
    #[test]
    fn rotors_alone_turn_it_by_their_own_momentum() {
        let found = row().rms_rad(&cycles([(0.3, 0.8), (1.0, -0.5), (2.0, 0.6)]));
        let expected = 1.5e-4 * 0.9 / std::f64::consts::SQRT_2 / 0.054;
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }
}
