//! Algorithm 1: a potential-field search for a collision-free swim cycle that yields a demanded wrench.
//!
//! ```text
//! for each epoch
//!     N₁ times        apply the attractive field
//!     N₂ − N₁ times   apply it where the repulsive field does not object
//!     N₃ − N₂ times   apply the repulsive field alone
//! ```
//!
//! The best collision-free sets met on the way are the answer. "Collision-free" means that every pair keeps a
//! distance to collision of at least the margin, so that a servo that lags does not touch either.
//!
//! Departures from the paper, each because the search works better with it:
//! - *Modules move one after another*, in an order shuffled each time, and each sees the error that those
//!   before it left. Stepped all at once by the sign of the same error they overshoot together, and chatter.
//! - *The step shrinks* from epoch to epoch: the last one decides how near the demand is met, the first how far
//!   the search gets.
//! - *Strength at the worse end.* In (12), S is taken at the lesser of the distances before and after the step;
//!   by S(D₀) alone, a module that is free would step into a collision unhindered. A field of zero is no objection.
//! - *Stage three* also takes attractive steps that lead out of a collision, not only the opposite of those that
//!   lead in.
//! - *Several starts*: the previous cycle; the least-norm sharing of the demand among the modules, which yields the
//!   demand exactly and only has to be freed of collisions, with different patterns of amplitude signs; then
//!   random ones around it. The search ends as soon as enough sets meet the goal.
//!
//! The same input gives the same answer: randomness comes from the seed in the settings alone.

use std::f64::consts::{PI, TAU};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::attraction::{gradient, step, step_amplitude};
use super::motion::{Swing, Wrench};
use super::pairs::Pairs;
use super::parameters::Parameters;
use super::planner_config::PlannerConfig;
use gaps::Gaps;
use quantity::wrap_rad;

mod gaps;
pub mod planner;

/// Sets whose every centerline and amplitude lie nearer than this count as the same, rad.
const DISTINCT_RAD: f64 = 0.3;

/// Part of the greatest thrust below which a demand is judged as if it were that large: a demand near zero would
/// otherwise never be met.
const SMALL_DEMAND: f64 = 0.1;

/// A collision-free swim cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Candidate {
    /// Each module's parameters of (1).
    pub cycle: Vec<Swing>,
    /// ‖w∘(F_des − F)‖, N.
    pub error_n: f64,
}

/// Algorithm 1 for one structure, with its workspace.
#[derive(Clone, Debug)]
pub struct PotentialField {
    parameters: Parameters,
    config: PlannerConfig,
    cells: Vec<[i32; 2]>,
    positions_m: Vec<[f64; 2]>,
    /// Σ |rᵢ|², m².
    square_radius_m2: f64,
    swings: Vec<Swing>,
    /// The wrench of each module's swing.
    wrenches: Vec<Wrench>,
    gaps: Gaps,
    order: Vec<usize>,
    error: Wrench,
    best: Candidate,
    candidates: Vec<Candidate>,
    /// Candidates of former searches, to be written over.
    spare: Vec<Candidate>,
}

/// One of the three stages of an epoch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Attract,
    AttractAndRepel,
    Repel,
}

impl PotentialField {
    /// A search for one structure, given by its cells, module positions (m, in S) and neighbours.
    #[must_use]
    pub fn new(
        cells: &[[i32; 2]],
        positions_m: &[[f64; 2]],
        pairs: &Pairs,
        parameters: &Parameters,
        config: &PlannerConfig,
    ) -> Self {
        let blank = || Candidate { cycle: Vec::with_capacity(cells.len()), error_n: f64::INFINITY };
        Self {
            parameters: parameters.clone(),
            config: config.clone(),
            cells: cells.to_vec(),
            square_radius_m2: positions_m.iter().map(|[x, y]| x * x + y * y).sum(),
            positions_m: positions_m.to_vec(),
            swings: vec![Swing::default(); cells.len()],
            wrenches: vec![Wrench::default(); cells.len()],
            gaps: Gaps::new(pairs, config.margin_rad),
            order: (0..cells.len()).collect(),
            error: Wrench::default(),
            best: blank(),
            candidates: Vec::with_capacity(config.candidates + 1),
            spare: (0..=config.candidates).map(|_| blank()).collect(),
        }
    }

    /// Error that counts as meeting `demand`, N.
    #[must_use]
    pub fn goal_n(&self, demand: Wrench) -> f64 {
        let small_n = SMALL_DEMAND * self.parameters.thrust_n(self.parameters.amplitude_max_rad);
        self.config.error_goal * demand.weighted_norm(self.config.weights).max(small_n)
    }

    /// The best collision-free sets met in a search for `demand`, best first; none if there was none.
    ///
    /// `distance(offset, i, j, margin)` is the distance to collision of two neighbours at that offset index, rad; where
    /// that is no less than `margin`, any lower bound of it that is no less either will do.
    pub fn solve(
        &mut self,
        demand: Wrench,
        previous: Option<&[Swing]>,
        distance: &impl Fn(usize, Swing, Swing, f64) -> f64,
    ) -> &[Candidate] {
        let mut rng = ChaCha8Rng::seed_from_u64(self.config.seed);
        let goal_n = self.goal_n(demand);
        self.spare.append(&mut self.candidates);
        for module in 0..self.order.len() {
            self.order[module] = module;
        }
        for start in 0..self.config.starts {
            if !self.begin(start, demand, previous, &mut rng) {
                continue;
            }
            self.best.error_n = f64::INFINITY;
            self.descend(demand, goal_n, distance, &mut rng);
            self.keep();
            if self.candidates.len() >= self.config.candidates
                && self.candidates.iter().all(|c| c.error_n <= goal_n)
            {
                break;
            }
        }
        &self.candidates
    }

    /// Sets the swings of a start; false if it has nothing to start from.
    fn begin(
        &mut self,
        start: u32,
        demand: Wrench,
        previous: Option<&[Swing]>,
        rng: &mut ChaCha8Rng,
    ) -> bool {
        let (min, max) = (self.parameters.amplitude_min_rad, self.parameters.amplitude_max_rad);
        if start == 0 {
            let Some(previous) = previous.filter(|p| p.len() == self.swings.len()) else { return false };
            for (swing, before) in self.swings.iter_mut().zip(previous) {
                swing.centerline_rad = wrap_rad(before.centerline_rad);
                swing.amplitude_rad =
                    before.amplitude_rad.abs().clamp(min, max).copysign(before.amplitude_rad);
            }
            return true;
        }
        let modules = self.swings.len() as f64;
        let lever = if self.square_radius_m2 > 0.0 { demand.tau_nm / self.square_radius_m2 } else { 0.0 };
        let thrust_max_n = self.parameters.thrust_n(max);
        // Patterns of signs first; then the same ones and random ones, ever further from the least norm.
        let spread_n = if start <= 4 { 0.0 } else { thrust_max_n * rng.random_range(0.1..1.0) };
        for module in 0..self.swings.len() {
            let [x_m, y_m] = self.positions_m[module];
            // Least-norm sharing: fᵢ = F/N + τ·(−yᵢ, xᵢ)/Σ|r|²
            let mut force = [demand.fx_n / modules - lever * y_m, demand.fy_n / modules + lever * x_m];
            for component in &mut force {
                *component += spread_n * rng.random_range(-1.0..1.0);
            }
            let thrust_n = force[0].hypot(force[1]);
            let [col, row] = self.cells[module];
            let flip = match start % 5 {
                1 => false,
                2 => (col + row) % 2 != 0,
                3 => col % 2 != 0,
                4 => row % 2 != 0,
                _ => rng.random(),
            };
            // A tail pushes away from where it points (7); |A| from (2).
            // The direction of a step (10) does not depend on a module's share of law (2); where it begins does.
            let thrust_n = thrust_n / self.parameters.share(module);
            let amplitude_rad = ((thrust_n + self.parameters.force_offset_n)
                / self.parameters.force_slope_n_rad)
                .clamp(min, max);
            self.swings[module] = Swing {
                centerline_rad: if thrust_n > 0.0 {
                    (-force[1]).atan2(-force[0])
                } else {
                    rng.random_range(-PI..PI)
                },
                amplitude_rad: if flip { -amplitude_rad } else { amplitude_rad },
            };
        }
        true
    }

    /// Algorithm 1 from the present swings.
    fn descend(
        &mut self,
        demand: Wrench,
        goal_n: f64,
        distance: &impl Fn(usize, Swing, Swing, f64) -> f64,
        rng: &mut ChaCha8Rng,
    ) {
        const STAGES: [Stage; 3] = [Stage::Attract, Stage::AttractAndRepel, Stage::Repel];
        let shrink = self.config.last_step_rad / self.config.step_rad;
        let last = f64::from(self.config.epochs.saturating_sub(1).max(1));
        self.measure(demand, distance);
        self.note();
        for epoch in 0..self.config.epochs {
            let step_rad = self.config.step_rad * shrink.powf(f64::from(epoch) / last);
            for (stage, iterations) in STAGES.into_iter().zip(self.config.stages) {
                for _ in 0..iterations {
                    if self.best.error_n <= goal_n {
                        return;
                    }
                    self.sweep(stage, step_rad, distance, rng);
                    self.measure_error(demand);
                    self.note();
                }
            }
        }
    }

    /// One step of every module.
    fn sweep(
        &mut self,
        stage: Stage,
        step_rad: f64,
        distance: &impl Fn(usize, Swing, Swing, f64) -> f64,
        rng: &mut ChaCha8Rng,
    ) {
        for last in (1..self.order.len()).rev() {
            self.order.swap(last, rng.random_range(0..=last));
        }
        for turn in 0..self.order.len() {
            let module = self.order[turn];
            let swing = self.swings[module];
            let gradient =
                gradient(swing, self.positions_m[module], self.error, self.config.weights, &self.parameters);
            let towards = step(gradient, step_rad);
            let mut factor = [1.0; 2];
            if stage != Stage::Attract {
                for (k, factor) in factor.iter_mut().enumerate() {
                    let mut only = [0.0; 2];
                    only[k] = towards[k];
                    let moved = self.moved(swing, only);
                    let field = self.gaps.repulsion(k, &self.swings, module, moved, distance);
                    *factor = match stage {
                        Stage::Repel if field != 0.0 => field.signum(),
                        Stage::Repel => 0.0,
                        _ if field >= 0.0 => 1.0,
                        _ => 0.0,
                    };
                }
            }
            if factor.iter().all(|&f| f == 0.0) {
                continue;
            }
            let moved = self.moved(swing, [factor[0] * towards[0], factor[1] * towards[1]]);
            self.replace(module, moved, distance);
        }
    }

    /// The swing after a step, with the centerline wrapped and the amplitude in its range.
    fn moved(&self, swing: Swing, [centerline_rad, amplitude_rad]: [f64; 2]) -> Swing {
        let mut centerline_rad = swing.centerline_rad + centerline_rad;
        if centerline_rad > PI {
            centerline_rad -= TAU;
        } else if centerline_rad <= -PI {
            centerline_rad += TAU;
        }
        let amplitude_rad = if amplitude_rad == 0.0 {
            swing.amplitude_rad
        } else {
            step_amplitude(swing.amplitude_rad, amplitude_rad, &self.parameters)
        };
        Swing { centerline_rad, amplitude_rad }
    }

    fn replace(&mut self, module: usize, swing: Swing, distance: &impl Fn(usize, Swing, Swing, f64) -> f64) {
        let at = self.positions_m[module];
        let wrench = swing.wrench(&self.parameters, at) * self.parameters.share(module);
        self.error = self.error + self.wrenches[module] - wrench;
        self.wrenches[module] = wrench;
        self.gaps.replace(&self.swings, module, swing, distance);
        self.swings[module] = swing;
    }

    /// The error (3), afresh: what the steps since added up to is rounded.
    fn measure_error(&mut self, demand: Wrench) {
        self.error = self.wrenches.iter().fold(demand, |error, &wrench| error - wrench);
    }

    /// Error and distances, afresh.
    fn measure(&mut self, demand: Wrench, distance: &impl Fn(usize, Swing, Swing, f64) -> f64) {
        let modules = self.wrenches.iter_mut().zip(&self.swings).zip(&self.positions_m);
        for (module, ((wrench, swing), &at)) in modules.enumerate() {
            *wrench = swing.wrench(&self.parameters, at) * self.parameters.share(module);
        }
        self.measure_error(demand);
        self.gaps.measure(&self.swings, distance);
    }

    /// Takes the present swings as this start's best if they are free and better.
    fn note(&mut self) {
        let error_n = self.error.weighted_norm(self.config.weights);
        if error_n < self.best.error_n && self.gaps.are_free() {
            self.best.error_n = error_n;
            self.best.cycle.clone_from(&self.swings);
        }
    }

    /// Files this start's best among the candidates, best first, the same set only once.
    fn keep(&mut self) {
        if !self.best.error_n.is_finite() {
            return;
        }
        let same = |c: &Candidate| {
            c.cycle.iter().zip(&self.best.cycle).all(|(a, b)| {
                wrap_rad(a.centerline_rad - b.centerline_rad).abs() < DISTINCT_RAD
                    && (a.amplitude_rad - b.amplitude_rad).abs() < DISTINCT_RAD
            })
        };
        if let Some(twin) = self.candidates.iter().position(same) {
            if self.candidates[twin].error_n <= self.best.error_n {
                return;
            }
            self.spare.push(self.candidates.remove(twin));
        }
        let place = self.candidates.partition_point(|c| c.error_n <= self.best.error_n);
        let mut candidate = self.spare.pop().unwrap_or_default();
        candidate.cycle.clone_from(&self.best.cycle);
        candidate.error_n = self.best.error_n;
        self.candidates.insert(place, candidate);
        self.spare.extend(self.candidates.drain(self.config.candidates.min(self.candidates.len())..));
    }
}

#[cfg(test)]
mod tests;
