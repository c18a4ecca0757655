//! What a cycle's rest poses are worth for what may come next, where few modules have little to spare.
//!
//! ```text
//! merit = (share of the demands about this one that can be met without turning) − b·|ΣA|/Σ|A|
//! ```
//!
//! The demands about one lie along the axes of the wrench and between them, at two distances. The second term is for the
//! rotors: the structure turns by −(J/I)·Σφᵢ against them, so that amplitudes that cancel keep its heading still.

use super::allocation::{Aim, Allocation, Met};
use super::law::Law;
use super::neighbours::{Cycle, Rules};
use super::rest::RestPoses;

/// Distances to the demands about one, as shares of the envelope along each axis.
const ABOUT: [f64; 2] = [0.1, 0.25];
/// What a net amplitude costs, b.
const BALANCE: f64 = 0.2;

/// The demands about one, and memory.
#[derive(Clone, Debug)]
pub struct Merit {
    /// From a weighted demand to those about it, N.
    steps_n: Vec<[f64; 3]>,
    kept: Vec<Cycle>,
}

impl Merit {
    /// For modules at `positions_m` (m, in S) with these weights of Fx, Fy and τ.
    #[must_use]
    pub fn new(positions_m: &[[f64; 2]], thrust_max_n: f64, weights: [f64; 3]) -> Self {
        let levers_m: f64 = positions_m.iter().map(|[x, y]| x.hypot(*y)).sum();
        let modules = positions_m.len() as f64;
        let extent_n = [modules, modules, levers_m];
        let mut steps_n = Vec::new();
        for radius in ABOUT {
            for code in 0..27 {
                let way = [code % 3, code / 3 % 3, code / 9].map(|digit| f64::from(digit) - 1.0);
                // The six ways along the axes and the eight between them all.
                let axes = way.iter().filter(|x| **x != 0.0).count();
                if matches!(axes, 1 | 3) {
                    let length = f64::sqrt(axes as f64);
                    let step = |k: usize| radius * way[k] / length * weights[k] * thrust_max_n * extent_n[k];
                    steps_n.push([0, 1, 2].map(step));
                }
            }
        }
        Self { steps_n, kept: Vec::with_capacity(positions_m.len()) }
    }

    /// Of the cycles of an allocation that meets `aim`; it is left as it was.
    pub fn of(
        &mut self,
        allocation: &mut Allocation,
        rules: &Rules<'_>,
        rest: &RestPoses,
        law: &Law,
        aim: &Aim,
    ) -> f64 {
        self.kept.clear();
        self.kept.extend_from_slice(&allocation.cycles);
        let still = || self.kept.iter().map(|&cycle| Cycle { turns: false, ..cycle });
        let mut met = 0;
        for step_n in &self.steps_n {
            let target_n = [0, 1, 2].map(|k| aim.target_n[k] + step_n[k]);
            let about = Aim { target_n, recentre: 0.0, rounds: 0, ..*aim };
            allocation.begin(still());
            met += usize::from(allocation.polish(rules, rest, law, &about) == Met::Yes);
        }
        allocation.begin(self.kept.iter().copied());
        let net_rad: f64 = self.kept.iter().map(|cycle| cycle.amplitude_rad).sum();
        let all_rad: f64 = self.kept.iter().map(|cycle| cycle.amplitude_rad.abs()).sum();
        let unbalanced = if all_rad > 0.0 { net_rad.abs() / all_rad } else { 0.0 };
        met as f64 / self.steps_n.len() as f64 - BALANCE * unbalanced
    }
}
