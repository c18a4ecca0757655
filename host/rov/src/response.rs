//! The motion of a body under a constant wrench, to a known accuracy whatever the body.
//!
//! Steps of [`STEP_S`] suit vehicles; a light body with heavy damping is stiffer. So the motion is computed with a
//! step and with half of it, and the step halved until both agree.

use nalgebra::Vector6;
use thiserror::Error;

use super::dynamics::{Dynamics, STEP_S, State};

/// Both agree: difference in m, m/s, rad/s and quaternion parts, relative to what is larger than one.
const AGREED: f64 = 1e-8;
/// What is still taken when halving has come to its end.
const TAKEN: f64 = 1e-6;
/// Halvings at most: steps down to 1/64 ms.
const HALVINGS: u32 = 6;

/// Why a motion cannot be computed.
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ResponseError {
    /// Steps of 1/64 ms do not settle it.
    #[error(
        "not resolved up to {t_s} s: steps of {step_s:e} s and of half of it differ by {difference:e} (m, rad, m/s, rad/s)"
    )]
    Unresolved { t_s: f64, step_s: f64, difference: f64 },
}

/// States at the times `at_s`, each zero or later and in any order, from `start` at time zero.
///
/// # Errors
/// [`ResponseError`] when steps that fine do not settle it.
pub fn response(
    dynamics: &Dynamics,
    start: &State,
    tau: &Vector6<f64>,
    at_s: &[f64],
) -> Result<Vec<State>, ResponseError> {
    let mut order: Vec<usize> = (0..at_s.len()).collect();
    order.sort_by(|&a, &b| at_s[a].total_cmp(&at_s[b]));
    let run = |parts: u32| {
        let (mut state, mut t_s) = (*start, 0.0);
        let mut states = vec![*start; at_s.len()];
        for &index in &order {
            if at_s[index] > t_s {
                // Of a short wait too the half is the half.
                let whole = ((at_s[index] - t_s) / STEP_S).ceil() * f64::from(parts);
                for _ in 0..whole as u64 {
                    dynamics.step(&mut state, tau, (at_s[index] - t_s) / whole);
                }
                t_s = at_s[index];
            }
            states[index] = state;
        }
        states
    };
    let mut coarse = run(1);
    let mut difference = f64::INFINITY;
    for halving in 1..=HALVINGS {
        let fine = run(1 << halving);
        difference = coarse.iter().zip(&fine).map(|(a, b)| apart(a, b)).fold(0.0, f64::max);
        if difference <= AGREED || (halving == HALVINGS && difference <= TAKEN) {
            return Ok(fine);
        }
        coarse = fine;
    }
    let t_s = at_s.iter().copied().fold(0.0, f64::max);
    Err(ResponseError::Unresolved { t_s, step_s: STEP_S / f64::from(1_u32 << (HALVINGS - 1)), difference })
}

/// Greatest difference between two states; infinite if one of them is no number.
fn apart(a: &State, b: &State) -> f64 {
    let (q, r) = (a.attitude.coords, b.attitude.coords);
    // q and −q are one attitude.
    let turned = (q - r).amax().min((q + r).amax());
    let moved = (a.position_m - b.position_m).amax() / (1.0 + b.position_m.amax());
    let faster = (a.nu - b.nu).amax() / (1.0 + b.nu.amax());
    let sum = turned + moved + faster;
    if sum.is_finite() { turned.max(moved).max(faster) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use reconfiguration::body::Body;
    use reconfiguration::vehicle::Vehicle;

    use super::*;
    use crate::cluster::Cluster;

    fn dynamics(change: impl Fn(&mut Body)) -> Dynamics {
        let mut body = Vehicle::built_in("bluerov1").expect("it comes with the program").body;
        change(&mut body);
        Dynamics::new(&Cluster::of(&body)).expect("massive")
    }

    /// Surge alone with linear damping, 60 times too stiff for the default step: u = X/d (1 − exp(−d t/m)).
    #[test]
    fn a_stiff_body_is_followed_with_finer_steps() {
        let d = 3e4;
        let stiff = dynamics(|body| {
            body.linear_damping[0] = d;
            body.quadratic_damping[0] = 0.0;
        });
        let start = State::from_eta(&[0.0; 6], &[0.0; 6]);
        let tau = Vector6::new(d, 0.0, 0.0, 0.0, 0.0, 0.0);
        let at_s = [1.0, 0.0, 2e-4];
        let states = response(&stiff, &start, &tau, &at_s).expect("resolved");
        let rate = d / (3.73 + 5.4);
        for (state, t_s) in states.iter().zip(at_s) {
            let expected = 1.0 - (-rate * t_s).exp();
            assert!((state.nu[0] - expected).abs() < 1e-6, "at {t_s} s: {} m/s, {expected} m/s", state.nu[0]);
        }
    }

    #[test]
    fn what_cannot_be_resolved_is_refused() {
        let impossible = dynamics(|body| body.linear_damping[0] = 1e6);
        let start = State::from_eta(&[0.0; 6], &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let refused = response(&impossible, &start, &Vector6::zeros(), &[1.0]).expect_err("too stiff");
        assert!(refused.to_string().starts_with("not resolved up to 1 s: steps of"), "{refused}");
    }
}
