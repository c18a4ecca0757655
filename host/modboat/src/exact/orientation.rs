//! Which way tails should rest, so that the demand, and those that may come next, can be met without moving them.
//!
//! Collisions aside, what all modules together push from given rest poses is about a convex set, the sum of what each
//! pushes. How far a demand lies inside it is, over directions n of the wrench,
//!
//! ```text
//! m(p) = minₙ [ Σᵢ |nᵢ|·S(∠nᵢ − pᵢ) − n·F_des ] / h(n),   nᵢ = (n_x − n_τ yᵢ, n_y + n_τ xᵢ)
//! ```
//!
//! with S the support function of one module's two spirals ([`Law::support_n`]) and h that of the envelope: 1 would be a
//! demand of zero that could be raised to the envelope's border in every direction. Poses are chosen module by module to
//! raise it, by multiplicative weights: directions in which the margin is small count more.
//!
//! Linear in the modules; allocates nothing once made.

use super::law::{Law, SUPPORT_ERROR, Sign};
use super::rest::RestPoses;
use crate::parameters::Parameters;

/// Sharpness of the weights: a margin smaller by 0.1 counts e² as much.
const SHARPNESS: f64 = 20.0;
/// Sweeps over all modules.
const SWEEPS: usize = 2;
/// Weights are recomputed so many times a sweep.
const REFRESHES: usize = 8;

/// Whether a demand with these slacks may be within what can be pushed.
#[must_use]
pub fn may_hold(slacks: &[f64]) -> bool {
    slacks.iter().all(|&slack| slack >= -SUPPORT_ERROR)
}

/// Margins of a structure's rest poses.
#[derive(Clone, Debug)]
pub struct Orientation {
    /// Directions n, scaled to h(n) = 1.
    directions: Vec<[f64; 3]>,
    /// |nᵢ| and ∠nᵢ by module and direction.
    levers: Vec<(f64, f64)>,
    /// |nᵢ|·S(∠nᵢ − p) by station and direction.
    gains: Vec<f64>,
    sums: Vec<f64>,
    weights: Vec<f64>,
}

impl Orientation {
    /// For modules at `positions_m` (m, in S).
    #[must_use]
    pub fn new(positions_m: &[[f64; 2]], parameters: &Parameters, rest: &RestPoses, law: &Law) -> Self {
        let thrust_max_n = parameters.thrust_n(parameters.amplitude_max_rad);
        let radius_m = {
            let square: f64 = positions_m.iter().map(|[x, y]| x * x + y * y).sum();
            (square / positions_m.len() as f64).sqrt()
        };
        // nᵢ, times the module's share of law (2).
        let lever = |n: [f64; 3], (module, &[x_m, y_m]): (usize, &[f64; 2])| {
            [n[0] - n[2] * y_m, n[1] + n[2] * x_m].map(|part| parameters.share(module) * part)
        };
        let mut directions = Vec::new();
        for code in 0..27 {
            let [a, b, c] = [code % 3, code / 3 % 3, code / 9].map(|digit| f64::from(digit) - 1.0);
            // Torque in units of force times the radius of gyration; a lone module has none.
            if radius_m == 0.0 && c != 0.0 {
                continue;
            }
            let n = [a, b, if c == 0.0 { 0.0 } else { c / radius_m }];
            let modules = positions_m.iter().enumerate();
            let support: f64 = modules.map(|at| lever(n, at)).map(|[x, y]| thrust_max_n * x.hypot(y)).sum();
            if support > 0.0 {
                directions.push(n.map(|component| component / support));
            }
        }
        let levers: Vec<(f64, f64)> = positions_m
            .iter()
            .enumerate()
            .flat_map(|at| directions.iter().map(move |&n| lever(n, at)))
            .map(|[x, y]| (x.hypot(y), y.atan2(x)))
            .collect();
        let count = directions.len();
        let mut gains = Vec::new();
        for module in 0..positions_m.len() {
            for &pose_rad in rest.stations_rad(module) {
                let levers = &levers[module * count..(module + 1) * count];
                gains.extend(
                    levers
                        .iter()
                        .map(|&(size, angle_rad)| size * law.support_n(Sign::Any, angle_rad - pose_rad)),
                );
            }
        }
        Self { sums: vec![0.0; count], weights: vec![0.0; count], directions, levers, gains }
    }

    fn count(&self) -> usize {
        self.directions.len()
    }

    /// Directions n, scaled to h(n) = 1.
    #[must_use]
    pub fn directions(&self) -> &[[f64; 3]] {
        &self.directions
    }

    fn gain(&self, law: &Law, sign: Sign, module: usize, pose_rad: f64, direction: usize) -> f64 {
        let (size, angle_rad) = self.levers[module * self.count() + direction];
        size * law.support_n(sign, angle_rad - pose_rad)
    }

    /// m(p) of these poses, beyond 1 − gauge at most.
    pub fn margin(&mut self, law: &Law, poses_rad: impl Iterator<Item = f64>, demand: [f64; 3]) -> f64 {
        self.sum(law, poses_rad.map(|pose_rad| (pose_rad, Some(Sign::Any))), demand);
        self.sums.iter().fold(f64::INFINITY, |least, &m| least.min(m))
    }

    /// By direction, how far the demand is inside what modules of these poses and signs can push; one without a sign rests. What is
    /// below −[`SUPPORT_ERROR`] is certainly out.
    pub fn slacks(
        &mut self,
        law: &Law,
        modules: impl Iterator<Item = (f64, Option<Sign>)>,
        demand: [f64; 3],
    ) -> &[f64] {
        self.sum(law, modules, demand);
        &self.sums
    }

    fn sum(&mut self, law: &Law, modules: impl Iterator<Item = (f64, Option<Sign>)>, demand: [f64; 3]) {
        for (sum, n) in self.sums.iter_mut().zip(&self.directions) {
            *sum = -(n[0] * demand[0] + n[1] * demand[1] + n[2] * demand[2]);
        }
        for (module, (pose_rad, sign)) in modules.enumerate() {
            let Some(sign) = sign else { continue };
            for direction in 0..self.count() {
                let gain = self.gain(law, sign, module, pose_rad, direction);
                self.sums[direction] += gain;
            }
        }
    }

    /// Turns `poses_rad` to stations that raise the margin at `demand` (N, N, N·m). Modules are visited in `order`.
    pub fn orient(
        &mut self,
        law: &Law,
        rest: &RestPoses,
        demand: [f64; 3],
        poses_rad: &mut [f64],
        order: &[usize],
    ) {
        let count = self.count();
        self.sum(law, poses_rad.iter().map(|&pose_rad| (pose_rad, Some(Sign::Any))), demand);
        for _ in 0..SWEEPS {
            let chunk = order.len().div_ceil(REFRESHES).max(2);
            for modules in order.chunks(chunk) {
                let least = self.sums.iter().fold(f64::INFINITY, |least, &m| least.min(m));
                for (weight, &sum) in self.weights.iter_mut().zip(&self.sums) {
                    *weight = (SHARPNESS * (least - sum)).exp();
                }
                for &module in modules {
                    let value =
                        |gains: &[f64]| gains.iter().zip(&self.weights).map(|(g, w)| g * w).sum::<f64>();
                    let mut best = (None, 0.0);
                    for (station, index) in rest.stations(module).enumerate() {
                        let value = value(&self.gains[index * count..(index + 1) * count]);
                        if best.0.is_none() || value > best.1 {
                            best = (Some((station, index)), value);
                        }
                    }
                    let Some((station, index)) = best.0 else { continue };
                    for direction in 0..count {
                        let old = self.gain(law, Sign::Any, module, poses_rad[module], direction);
                        self.sums[direction] += self.gains[index * count + direction] - old;
                    }
                    poses_rad[module] = rest.stations_rad(module)[station];
                }
            }
        }
    }
}
