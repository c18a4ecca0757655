//! Lower bound of what a move costs, for any power of the others, without a cache.
//!
//! ```text
//! q_k(λ) = min over d of r(d, λ)/(n_k·d),   r(d, λ) = min over v of (P(v·d) + λ)/v
//! h(x, λ) = max over k of q_k(λ)·(n_k·x)
//! ```
//!
//! as in [`cost_per_metre`](super::super::cost_per_metre), for a robot that is free to choose its heading: r depends on the elevation of d alone,
//! and so the n_k lie in one upright plane, the one that x lies in. A leg's part along n_k is at most its part in that plane, so
//! that turning it into the plane takes nothing from the bound.
//!
//! Each q_k is a least value of functions that are linear in λ, and so concave: the straight line between two of its values is
//! below it. It is kept at [`POWERS`] values of λ.
//!
//! What is left out takes nothing away: ramps take longer than the same way at full speed, turns cost. At speeds below the
//! least one that may be asked for, in ramps, the force that accelerates is greater than the drag that is saved.

use std::f64::consts::PI;

use super::super::cost_per_metre::PowerMap;

/// Values of λ, the n_k, and samples of the elevation of d.
const POWERS: usize = 40;
const PLANES: usize = 32;
const SAMPLES: usize = 96;
/// What is left for directions between the samples.
const SAMPLING: f64 = 0.995;
/// The least λ above zero, W, and the greatest: beyond it q goes on as it ends, which is below it too.
const LEAST_W: f64 = 0.05;
const GREATEST_W: f64 = 2000.0;

/// Bounds of one kind of robot.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    /// [λ][k], J/m.
    reaches: Vec<[f64; PLANES]>,
    /// Level and downward part of each n_k.
    normals: [[f64; 2]; PLANES],
}

impl Bound {
    /// For the heading along the leg, or the cheapest one.
    pub fn new(map: &PowerMap, along: bool) -> Self {
        let angle = |n: usize, count: usize| (n as f64 / count as f64 - 0.5) * PI;
        let normals = std::array::from_fn(|k| {
            let (sin, cos) = angle(k, PLANES - 1).sin_cos();
            [cos, sin]
        });
        let reaches = (0..POWERS).map(|n| {
            let costs = map.least_costs_per_metre(power_w(n), along);
            let cells = costs.len() - 1;
            // n_k·d over r(d), greatest: one division a sample.
            let samples: Vec<[f64; 2]> = (0..=SAMPLES)
                .map(|sample| {
                    let at = (sample * cells) as f64 / SAMPLES as f64;
                    let low = (at as usize).min(cells - 1);
                    let share = at - low as f64;
                    let cost = (1.0 - share) * costs[low] + share * costs[low + 1];
                    let (sin, cos) = angle(sample, SAMPLES).sin_cos();
                    [cos / cost, sin / cost]
                })
                .collect();
            normals.map(|[level, down]: [f64; 2]| {
                let most = samples.iter().map(|[x, z]| level * x + down * z).fold(0.0, f64::max);
                SAMPLING / most
            })
        });
        Self { reaches: reaches.collect(), normals }
    }

    /// Bounds at one λ.
    pub fn at(&self, lambda_w: f64) -> BoundAt {
        // The last node that is not above it.
        let node = if lambda_w < LEAST_W {
            0
        } else {
            let step = (GREATEST_W / LEAST_W).ln() / (POWERS - 2) as f64;
            (1 + ((lambda_w / LEAST_W).ln() / step) as usize).min(POWERS - 1)
        };
        let next = (node + 1).min(POWERS - 1);
        let [low, high] = [power_w(node), power_w(next)];
        let share = if next > node { ((lambda_w - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        BoundAt {
            planes: std::array::from_fn(|k| {
                let reach = (1.0 - share) * self.reaches[node][k] + share * self.reaches[next][k];
                self.normals[k].map(|component| reach * component)
            }),
        }
    }
}

fn power_w(node: usize) -> f64 {
    let step = (GREATEST_W / LEAST_W).ln() / (POWERS - 2) as f64;
    if node == 0 { 0.0 } else { LEAST_W * (step * (node - 1) as f64).exp() }
}

/// Bounds of one kind of robot while others draw so much.
#[derive(Clone, Debug)]
pub(super) struct BoundAt {
    planes: [[f64; 2]; PLANES],
}

impl BoundAt {
    /// Of every path that leads along `way_m` in the end, J.
    pub fn of(&self, [x, y, z]: [f64; 3]) -> f64 {
        let level = (x * x + y * y).sqrt();
        self.planes.iter().map(|[a, b]| a * level + b * z).fold(0.0, f64::max)
    }
}
