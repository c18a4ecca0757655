//! Merit of a cycle's rest poses for demands that may come next; it counts where few modules have little to spare.
//!
//! ```text
//! merit = (share of the demands about this one that can be met without turning) − b·|ΣA|/Σ|A|
//! ```
//!
//! *What it can be at most* is known without Newton's method: what the poses cannot push in some direction, by the support
//! functions of [`Orientation`](super::orientation), they cannot give. So candidates are looked at in the order of that bound, and
//! one is left as soon as it cannot be the best any more. Which is best does not change by that.
//!
//! The demands about one lie along the axes of the wrench and between them, at two distances. The second term is for the
//! rotors: the structure turns by −(J/I)·Σφᵢ against them, so that amplitudes that cancel keep its heading still.

use super::allocation::{Aim, Allocation};
use super::law::{Law, SUPPORT_ERROR, Sign};
use super::neighbours::Rules;
use super::orientation::Orientation;
use super::rest::RestPoses;
use crate::parameters::Parameters;

/// Distances to the demands about one, as shares of the envelope along each axis, the farthest first. One that is met stands for
/// the nearer one in the same direction.
const ABOUT: [f64; 2] = [0.25, 0.1];
/// What a net amplitude costs, b.
const BALANCE: f64 = 0.2;
/// Relative error with which a demand about one counts as met: Newton's method is as good as there.
const NEAR: f64 = 1e-4;

/// Merit of rest poses: demands near the present one, and workspace.
#[derive(Clone, Debug)]
pub struct Merit {
    /// From a weighted demand to those about it, N, by direction; each [`ABOUT`] so far.
    steps_n: Vec<[[f64; 3]; 2]>,
    /// What each takes of the slack in each direction of the orientation.
    takes: Vec<f64>,
    /// The directions in the order in which they are tried: the one that failed last comes first.
    order: Vec<usize>,
}

impl Merit {
    /// For modules at `positions_m` (m, in S) with these weights of Fx, Fy and τ.
    #[must_use]
    pub fn new(
        positions_m: &[[f64; 2]],
        parameters: &Parameters,
        weights: [f64; 3],
        orientation: &Orientation,
    ) -> Self {
        let thrust_max_n = parameters.thrust_n(parameters.amplitude_max_rad);
        let each = || positions_m.iter().enumerate().map(|(module, at)| (parameters.share(module), at));
        let levers_m: f64 = each().map(|(share, [x, y])| share * x.hypot(*y)).sum();
        let modules: f64 = each().map(|(share, _)| share).sum();
        let extent_n = [modules, modules, levers_m];
        let mut steps_n = Vec::new();
        for code in 0..27 {
            let way = [code % 3, code / 3 % 3, code / 9].map(|digit| f64::from(digit) - 1.0);
            // The six ways along the axes and the eight between them all.
            let axes = way.iter().filter(|x| **x != 0.0).count();
            if matches!(axes, 1 | 3) {
                let length = f64::sqrt(axes as f64);
                let step = |k: usize| way[k] / length * weights[k] * thrust_max_n * extent_n[k];
                steps_n.push(ABOUT.map(|radius| [0, 1, 2].map(|k| radius * step(k))));
            }
        }
        let take = |step_n: &[f64; 3], n: &[f64; 3]| (0..3).map(|k| n[k] * step_n[k] / weights[k]).sum();
        let takes = steps_n
            .iter()
            .flatten()
            .flat_map(|step_n| orientation.directions().iter().map(move |n| take(step_n, n)))
            .collect();
        let order = (0..steps_n.len()).collect();
        Self { steps_n, takes, order }
    }

    /// How many demands in this direction may be met where the one has these slacks.
    fn may_meet(&self, way: usize, slacks: &[f64]) -> usize {
        let mut takes = self.takes[ABOUT.len() * way * slacks.len()..].chunks_exact(slacks.len());
        let holds =
            |takes: &[f64]| slacks.iter().zip(takes).all(|(slack, take)| slack - take >= -SUPPORT_ERROR);
        let beyond = takes.by_ref().take(ABOUT.len()).take_while(|takes| !holds(takes)).count();
        ABOUT.len() - beyond
    }

    fn share(&self, met: usize) -> f64 {
        met as f64 / (ABOUT.len() * self.steps_n.len()) as f64
    }

    /// The most that it can be where the demand has these slacks.
    #[must_use]
    pub fn at_most(&self, slacks: &[f64]) -> f64 {
        self.share((0..self.steps_n.len()).map(|way| self.may_meet(way, slacks)).sum())
    }

    /// Of the cycles of an allocation that meets `aim`, for `demand`. `None` if it is no more than `least`.
    #[expect(clippy::too_many_arguments, reason = "the parts of a search, which it borrows one by one")]
    pub fn of(
        &mut self,
        allocation: &mut Allocation,
        orientation: &mut Orientation,
        rules: &Rules<'_>,
        rest: &RestPoses,
        law: &Law,
        (aim, demand): (&Aim, [f64; 3]),
        least: f64,
    ) -> Option<f64> {
        let cycles = &allocation.cycles;
        let net_rad: f64 = cycles.iter().map(|cycle| cycle.amplitude_rad).sum();
        let all_rad: f64 = cycles.iter().map(|cycle| cycle.amplitude_rad.abs()).sum();
        let unbalanced = if all_rad > 0.0 { net_rad.abs() / all_rad } else { 0.0 };
        let value = |merit: &Self, met: usize| merit.share(met) - BALANCE * unbalanced;
        let modules = cycles.iter().map(|cycle| (cycle.rest_rad, Sign::of(cycle.amplitude_rad)));
        let slacks = orientation.slacks(law, modules, demand);
        let mut open: usize = (0..self.steps_n.len()).map(|way| self.may_meet(way, slacks)).sum();
        let mut met = 0;
        for place in 0..self.order.len() {
            if value(self, met + open) <= least {
                return None;
            }
            let way = self.order[place];
            let most = self.may_meet(way, slacks);
            let mut steps_n = self.steps_n[way].iter().skip(ABOUT.len() - most);
            let reached = steps_n.position(|step_n| {
                let target_n = [0, 1, 2].map(|k| aim.target_n[k] + step_n[k]);
                let about = Aim { target_n, recentre: 0.0, goal: NEAR, ..*aim };
                allocation.reaches(rules, rest, law, &about)
            });
            met += reached.map_or(0, |beyond| most - beyond);
            open -= most;
            if reached != Some(0) {
                self.order[..=place].rotate_right(1);
            }
        }
        Some(value(self, met)).filter(|own| *own > least)
    }
}
