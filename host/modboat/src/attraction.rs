//! The attractive field of §II-B: which way each module's centerline and amplitude go to bring the structure's
//! wrench to the demanded one.
//!
//! ```text
//! e = F_des − F                                                              (3)
//! w = (w_x, w_y, w_τ)                                                        (4)
//! E = ½ Σₖ (wₖ eₖ)²                    printed: E = e·w
//! ∂E/∂φ₀ᵢ = − Σₖ wₖ² eₖ ∂Fₖ/∂φ₀ᵢ       printed: −(∇F) w                     (5)
//! ∂E/∂Aᵢ  = − Σₖ wₖ² eₖ ∂Fₖ/∂Aᵢ        printed: −(∇F) w                     (6)
//! d = −Δd · sgn(∇E)                    printed without the minus            (10)
//! ```
//!
//! The printed E is signed: it has no least value and its gradient does not contain the demand. Half the square
//! of the weighted error is descended instead, the same ‖w∘e‖ by which plans are judged.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | F, e | wrench, its error, frame S | N, N, N·m |
//! | w | weights, (1, 1, 10) in the paper | 1, 1, 1/m |
//! | φ₀, A | centerline, amplitude | rad |
//! | Δd | step | rad |

use super::motion::{Swing, Wrench};
use super::parameters::Parameters;

/// (∂E/∂φ₀, ∂E/∂A) for the module at (x, y), N²/rad, where `error` is that of the whole structure.
#[must_use]
pub fn gradient(
    swing: Swing,
    [x_m, y_m]: [f64; 2],
    error: Wrench,
    weights: [f64; 3],
    parameters: &Parameters,
) -> [f64; 2] {
    let (sin, cos) = swing.centerline_rad.sin_cos();
    let thrust_n = parameters.thrust_n(swing.amplitude_rad);
    // ∂Fᵢ/∂φ₀ᵢ = (Fᵢ sin φ₀, −Fᵢ cos φ₀, −Fᵢ cos φ₀·x − Fᵢ sin φ₀·y)                    (8)
    let by_centerline = [thrust_n * sin, -thrust_n * cos, -thrust_n * (cos * x_m + sin * y_m)];
    // ∂Fᵢ/∂Aᵢ = sgn(A)·0.022·(−cos φ₀, −sin φ₀, −sin φ₀·x + cos φ₀·y)                   (9)
    // The paper prints it without sgn(A), but (2) depends on |A|.
    let slope = parameters.force_slope_n_rad * swing.amplitude_rad.signum();
    let by_amplitude = [-slope * cos, -slope * sin, -slope * (sin * x_m - cos * y_m)];
    let error = error.to_array();
    let weighted = [0, 1, 2].map(|k| weights[k] * weights[k] * error[k]);
    let dot =
        |column: [f64; 3]| -(column[0] * weighted[0] + column[1] * weighted[1] + column[2] * weighted[2]);
    [dot(by_centerline), dot(by_amplitude)]
}

/// The step (10): −Δd·sgn(∇E) by component, zero where the gradient is.
#[must_use]
pub fn step(gradient: [f64; 2], step_rad: f64) -> [f64; 2] {
    gradient.map(|g| if g == 0.0 { 0.0 } else { -step_rad * g.signum() })
}

/// A + dA, kept in \[min, max\] in magnitude; a step through zero jumps from −min to +min and back.
#[must_use]
pub fn step_amplitude(amplitude_rad: f64, step_rad: f64, parameters: &Parameters) -> f64 {
    let (min, max) = (parameters.amplitude_min_rad, parameters.amplitude_max_rad);
    let next = amplitude_rad + step_rad;
    if next.abs() >= min {
        return next.clamp(-max, max);
    }
    // Inside the gap: on to the far side if the step leads towards zero, else (coming from rest) out.
    let outward = if step_rad == 0.0 { amplitude_rad } else { step_rad };
    min.copysign(outward)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEIGHTS: [f64; 3] = [1.0, 1.0, 10.0];

    fn energy(error: Wrench) -> f64 {
        0.5 * error.weighted_norm(WEIGHTS).powi(2)
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let parameters = Parameters::default();
        let demand = Wrench { fx_n: 0.013, fy_n: -0.021, tau_nm: 0.004 };
        let at = [0.15, -0.225];
        let cost = |swing: Swing| energy(demand - swing.wrench(&parameters, at));
        let h = 1e-6;
        for centerline_rad in [-3.0, -1.2, 0.0, 0.7, 2.4] {
            for amplitude_rad in [-2.5, -1.0, 0.95, 1.7] {
                let swing = Swing { centerline_rad, amplitude_rad };
                let shifted = |dc: f64, da: f64| Swing {
                    centerline_rad: centerline_rad + dc,
                    amplitude_rad: amplitude_rad + da,
                };
                let expected = [
                    (cost(shifted(h, 0.0)) - cost(shifted(-h, 0.0))) / (2.0 * h),
                    (cost(shifted(0.0, h)) - cost(shifted(0.0, -h))) / (2.0 * h),
                ];
                let error = demand - swing.wrench(&parameters, at);
                let gradient = gradient(swing, at, error, WEIGHTS, &parameters);
                for k in 0..2 {
                    assert!((gradient[k] - expected[k]).abs() < 1e-9, "{swing:?}: {gradient:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn a_small_step_lowers_the_energy() {
        let parameters = Parameters::default();
        let demand = Wrench { fx_n: -0.02, fy_n: 0.01, tau_nm: -0.001 };
        let at = [-0.15, 0.0];
        let swing = Swing { centerline_rad: 0.4, amplitude_rad: -1.5 };
        let error = demand - swing.wrench(&parameters, at);
        let [dc, da] = step(gradient(swing, at, error, WEIGHTS, &parameters), 1e-3);
        let moved = Swing {
            centerline_rad: swing.centerline_rad + dc,
            amplitude_rad: step_amplitude(swing.amplitude_rad, da, &parameters),
        };
        let after = demand - moved.wrench(&parameters, at);
        assert!(energy(after) < energy(error));
    }

    #[test]
    fn amplitudes_jump_over_the_gap_and_stop_at_the_ends() {
        let p = Parameters::default();
        let check = |a: f64, d: f64, expected: f64| {
            assert!((step_amplitude(a, d, &p) - expected).abs() < 1e-12, "{a} + {d}");
        };
        check(-0.95, 0.1, 0.9);
        check(0.95, -0.1, -0.9);
        check(2.55, 0.1, 2.6);
        check(-2.55, -0.1, -2.6);
        check(1.0, 0.1, 1.1);
        check(0.0, 0.0, 0.9);
    }
}
