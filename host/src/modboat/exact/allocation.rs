//! From a demanded wrench to the amplitudes of all modules between given rest poses: coordinate descent over a coarse set
//! of amplitudes, then Newton's method in continuous ones.
//!
//! ```text
//! W∘F = Σ Mᵢ uᵢ(pᵢ, Aᵢ),   Mᵢ = ( w₁      0     )            weighted wrench, from (7)
//!                                ( 0       w₂    )
//!                                ( −w₃ yᵢ  w₃ xᵢ )
//! r = W∘(F_des − F)                                            residual
//! descend:  Aᵢ ← argmin |r + Mᵢuᵢ(Aᵢ) − Mᵢu|² + λ (abs(A) − A*)²   over the coarse set, one module after another
//! polish:   ΔA = z + Jᵀ(J Jᵀ + μ)⁻¹ (r − J z),   J = ∂(W∘F)/∂A       least change that removes r
//! ```
//!
//! z draws amplitudes towards the middle A* of their range within the null space of J, so that a cycle keeps room for the
//! next demand. Whatever a step changes keeps to the [`Rules`] of neighbours: modules whose new amplitudes would break
//! them stay as they were, and the others make up for it.
//!
//! Both run in time linear in the modules and allocate nothing.

use super::law::{Law, turned};
use super::neighbours::{Cycle, Rules};
use super::rest::RestPoses;

/// Relative weighted error that counts as none.
const EXACT: f64 = 1e-9;
/// Relative weighted error to aim at.
pub const GOAL: f64 = 0.01 * EXACT;
/// Weighted error that counts as none whatever the demand, N.
const EXACT_N: f64 = 1e-13;
/// Newton steps at most.
const STEPS: usize = 14;
/// Steps in a row that do not halve the residual, after which no more are tried.
const SLOW_STEPS: usize = 3;
/// Rounds of taking back what neighbours do not allow.
const ROUNDS: usize = 4;
/// The longest Newton step, rad.
const STEP_MAX_RAD: f64 = 0.5;
/// μ as a share of the trace of J Jᵀ.
const DAMPING: f64 = 1e-9;
/// Candidates of one module that are tried against its neighbours at most.
const TRIES: usize = 8;

/// What a search is after.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    /// W∘F_des, N.
    pub target_n: [f64; 3],
    /// The amplitude A* that costs least, rad.
    pub amplitude_rad: f64,
    /// Weight λ of amplitudes off it, N²/rad².
    pub pull_n2_rad2: f64,
    /// Share of the way to it that a polish goes.
    pub recentre: f64,
    /// Relative weighted error that a polish is done with.
    pub goal: f64,
    /// Whether a cycle that turns may leave its free arc.
    pub roams: bool,
}

impl Aim {
    /// How far a pose may turn, clockwise and counter-clockwise, rad.
    fn room_rad(&self, rest: &RestPoses, module: usize, pose_rad: f64) -> [f64; 2] {
        if self.roams { [-STEP_MAX_RAD, STEP_MAX_RAD] } else { rest.room_rad(module, pose_rad) }
    }
}

/// Whether an aim is met to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// It is.
    Yes,
    /// The cycles are the nearest found.
    No,
}

/// The state of a search.
#[derive(Clone, Debug, Default)]
pub struct Allocation {
    /// Each module's cycle; always one that the rules allow.
    pub cycles: Vec<Cycle>,
    /// r, N.
    residual_n: [f64; 3],
    /// (w₁, w₂, w₃).
    weights: [f64; 3],
    positions_m: Vec<[f64; 2]>,
    turns: Vec<(f64, f64)>,
    trial: Vec<Cycle>,
    slopes: Vec<[[f64; 3]; 2]>,
    frozen: Vec<bool>,
    costs: Vec<f64>,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The solution of a symmetric positive definite 3 × 3 system by Cholesky; `None` if it is not.
fn solve(m: [[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let l00 = m[0][0].sqrt();
    let (l10, l20) = (m[1][0] / l00, m[2][0] / l00);
    let l11 = (m[1][1] - l10 * l10).sqrt();
    let l21 = (m[2][1] - l20 * l10) / l11;
    let l22 = (m[2][2] - l20 * l20 - l21 * l21).sqrt();
    // A NaN is not greater than zero.
    if !(l00 > 0.0 && l11 > 0.0 && l22 > 0.0) {
        return None;
    }
    let y0 = b[0] / l00;
    let y1 = (b[1] - l10 * y0) / l11;
    let y2 = (b[2] - l20 * y0 - l21 * y1) / l22;
    let x2 = y2 / l22;
    let x1 = (y1 - l21 * x2) / l11;
    Some([(y0 - l10 * x1 - l20 * x2) / l00, x1, x2])
}

impl Allocation {
    /// For modules at `positions_m` (m, in S).
    #[must_use]
    pub fn new(positions_m: &[[f64; 2]], weights: [f64; 3]) -> Self {
        let modules = positions_m.len();
        Self {
            cycles: vec![Cycle::default(); modules],
            residual_n: [0.0; 3],
            weights,
            positions_m: positions_m.to_vec(),
            turns: vec![(0.0, 1.0); modules],
            trial: vec![Cycle::default(); modules],
            slopes: vec![[[0.0; 3]; 2]; modules],
            frozen: vec![false; modules],
            costs: Vec::new(),
        }
    }

    /// Begins from these cycles, which must be allowed together.
    pub fn begin(&mut self, cycles: impl Iterator<Item = Cycle>) {
        for ((own, turn), cycle) in self.cycles.iter_mut().zip(&mut self.turns).zip(cycles) {
            *own = cycle;
            *turn = cycle.rest_rad.sin_cos();
        }
    }

    /// Gives one module another cycle, which its neighbours must allow.
    pub fn set(&mut self, module: usize, cycle: Cycle) {
        self.cycles[module] = cycle;
        self.turns[module] = cycle.rest_rad.sin_cos();
    }

    /// Whether the cycles are allowed together, and every amplitude in its range.
    #[must_use]
    pub fn allowed(&self, rules: &Rules<'_>, law: &Law) -> bool {
        let [least_rad, most_rad] = law.range_rad;
        let in_range = |cycle: &Cycle| {
            cycle.amplitude_rad == 0.0 || (least_rad..=most_rad).contains(&cycle.amplitude_rad.abs())
        };
        self.cycles.iter().all(in_range)
            && rules
                .setting
                .pairs
                .all()
                .iter()
                .all(|pair| rules.allow(pair, self.cycles[pair.i], self.cycles[pair.j]))
    }

    /// |r|, N: weighted error of the cycles for the aim last followed.
    #[must_use]
    pub fn error_n(&self) -> f64 {
        dot(self.residual_n, self.residual_n).sqrt()
    }

    /// Mᵢ u.
    fn wrench_n(&self, module: usize, [x_n, y_n]: [f64; 2]) -> [f64; 3] {
        let ([w1, w2, w3], [x_m, y_m]) = (self.weights, self.positions_m[module]);
        [w1 * x_n, w2 * y_n, w3 * (x_m * y_n - y_m * x_n)]
    }

    fn contribution_n(&self, law: &Law, module: usize) -> [f64; 3] {
        let thrust_n = law.thrust_n(self.cycles[module].amplitude_rad);
        self.wrench_n(module, turned(thrust_n, self.turns[module]))
    }

    fn refresh(&mut self, law: &Law, target_n: [f64; 3]) {
        let mut residual_n = target_n;
        for module in 0..self.cycles.len() {
            let own_n = self.contribution_n(law, module);
            (0..3).for_each(|k| residual_n[k] -= own_n[k]);
        }
        self.residual_n = residual_n;
    }

    /// One sweep of coordinate descent over the modules in `order`.
    pub fn descend(&mut self, rules: &Rules<'_>, law: &Law, aim: &Aim, order: impl Iterator<Item = usize>) {
        self.refresh(law, aim.target_n);
        for module in order {
            self.descend_one(rules, law, aim, module);
        }
    }

    fn descend_one(&mut self, rules: &Rules<'_>, law: &Law, aim: &Aim, module: usize) {
        let own_n = self.contribution_n(law, module);
        let without_n = [0, 1, 2].map(|k| self.residual_n[k] + own_n[k]);
        let (sin, cos) = self.turns[module];
        // |t − M R u₀|² = |t|² − 2 (Rᵀ Mᵀ t)·u₀ + u₀ᵀ (Rᵀ Mᵀ M R) u₀
        let columns = [turned([1.0, 0.0], (sin, cos)), turned([0.0, 1.0], (sin, cos))]
            .map(|column| self.wrench_n(module, column));
        let linear = [dot(columns[0], without_n), dot(columns[1], without_n)];
        let square = [dot(columns[0], columns[0]), dot(columns[0], columns[1]), dot(columns[1], columns[1])];
        let cost = |[x, y]: [f64; 2], amplitude_rad: f64| {
            let off_rad = amplitude_rad.abs() - aim.amplitude_rad;
            x * (square[0] * x - 2.0 * linear[0])
                + y * (2.0 * square[1] * x + square[2] * y - 2.0 * linear[1])
                + aim.pull_n2_rad2 * off_rad * off_rad
        };
        let present = self.cycles[module];
        let present_cost = cost(law.thrust_n(present.amplitude_rad), present.amplitude_rad);
        self.costs.clear();
        self.costs.extend(law.thrusts_n.iter().zip(&law.amplitudes_rad).map(|(&u, &a)| cost(u, a)));
        for _ in 0..TRIES {
            let mut best = (0, f64::INFINITY);
            for (index, &cost) in self.costs.iter().enumerate() {
                if cost < best.1 {
                    best = (index, cost);
                }
            }
            // Not worth a change.
            if best.1 >= present_cost - 1e-12 * present_cost.abs() {
                return;
            }
            let cycle = Cycle { amplitude_rad: law.amplitudes_rad[best.0], ..present };
            if rules.allow_among(module, cycle, |other| self.cycles[other]) {
                let new_n = self.wrench_n(module, turned(law.thrusts_n[best.0], (sin, cos)));
                self.residual_n = [0, 1, 2].map(|k| without_n[k] - new_n[k]);
                self.cycles[module] = cycle;
                return;
            }
            self.costs[best.0] = f64::INFINITY;
        }
    }

    /// Newton's method in continuous amplitudes.
    pub fn polish(&mut self, rules: &Rules<'_>, rest: &RestPoses, law: &Law, aim: &Aim) -> Met {
        let norm_n = dot(aim.target_n, aim.target_n).sqrt();
        let goal_n = self.goal_n(aim);
        self.refresh(law, aim.target_n);
        self.frozen.iter_mut().for_each(|frozen| *frozen = false);
        for round in 0..=ROUNDS {
            let before_n = self.error_n();
            self.trial.copy_from_slice(&self.cycles);
            let met = self.newton(rest, law, aim, goal_n, if round == 0 { aim.recentre } else { 0.0 });
            let taken_back = self.take_back(rules);
            std::mem::swap(&mut self.trial, &mut self.cycles);
            for (turn, cycle) in self.turns.iter_mut().zip(&self.cycles).filter(|(_, cycle)| cycle.turns) {
                *turn = cycle.rest_rad.sin_cos();
            }
            self.refresh(law, aim.target_n);
            if self.error_n() <= goal_n {
                return Met::Yes;
            }
            // Nothing was in the way, or taking back cost more than was won: as near as it gets.
            if !taken_back && (met || self.error_n() > 0.9 * before_n) {
                break;
            }
        }
        if self.error_n() <= EXACT * norm_n { Met::Yes } else { Met::No }
    }

    /// Whether Newton's method alone, without turning, leads from the cycles to what meets the aim; they stay as they are.
    pub fn reaches(&mut self, rules: &Rules<'_>, rest: &RestPoses, law: &Law, aim: &Aim) -> bool {
        for (trial, cycle) in self.trial.iter_mut().zip(&self.cycles) {
            *trial = Cycle { turns: false, ..*cycle };
        }
        self.frozen.iter_mut().for_each(|frozen| *frozen = false);
        self.newton(rest, law, aim, self.goal_n(aim), 0.0) && self.trial_allowed(rules)
    }

    fn goal_n(&self, aim: &Aim) -> f64 {
        (aim.goal * dot(aim.target_n, aim.target_n).sqrt()).max(EXACT_N)
    }

    /// Newton steps on the trial, starting from the cycles; true if it meets the goal.
    fn newton(&mut self, rest: &RestPoses, law: &Law, aim: &Aim, goal_n: f64, recentre: f64) -> bool {
        let [least_rad, most_rad] = law.range_rad;
        let modules = self.trial.len();
        let mut pull = recentre;
        let (mut last_n, mut slow) = (f64::INFINITY, 0);
        for _ in 0..STEPS {
            // Residual and slopes at the trial.
            let mut residual_n = aim.target_n;
            let mut normal = [[0.0; 3]; 3];
            let mut drawn_n = [0.0; 3];
            for module in 0..modules {
                let cycle = self.trial[module];
                let turn = if cycle.turns { cycle.rest_rad.sin_cos() } else { self.turns[module] };
                let (thrust_n, slope) = law.thrust_and_slope(cycle.amplitude_rad);
                let thrust_n = turned(thrust_n, turn);
                let own_n = self.wrench_n(module, thrust_n);
                (0..3).for_each(|k| residual_n[k] -= own_n[k]);
                self.slopes[module] = [[0.0; 3]; 2];
                if self.frozen[module] || cycle.amplitude_rad == 0.0 {
                    continue;
                }
                let by_amplitude = self.wrench_n(module, turned(slope, turn));
                self.slopes[module][0] = by_amplitude;
                let drawn = pull * (aim.amplitude_rad - cycle.amplitude_rad.abs());
                let drawn = if pull > 0.0 { drawn * cycle.amplitude_rad.signum() } else { 0.0 };
                for k in 0..3 {
                    drawn_n[k] += by_amplitude[k] * drawn;
                }
                if cycle.turns {
                    // ∂u/∂p turns u by a right angle.
                    self.slopes[module][1] = self.wrench_n(module, [-thrust_n[1], thrust_n[0]]);
                }
            }
            let size_n = dot(residual_n, residual_n).sqrt();
            if size_n <= goal_n && pull == 0.0 {
                return true;
            }
            slow = if size_n > 0.5 * last_n { slow + 1 } else { 0 };
            if slow >= SLOW_STEPS {
                return false;
            }
            last_n = size_n;
            self.outward(rest, law, aim, residual_n);
            for slopes in &self.slopes {
                for slope in slopes {
                    for (row, &a) in normal.iter_mut().zip(slope) {
                        for (entry, &b) in row.iter_mut().zip(slope) {
                            *entry += a * b;
                        }
                    }
                }
            }
            let damping = DAMPING * (normal[0][0] + normal[1][1] + normal[2][2]) + f64::MIN_POSITIVE;
            (0..3).for_each(|k| normal[k][k] += damping);
            let wanted_n = [0, 1, 2].map(|k| residual_n[k] - drawn_n[k]);
            let Some(y) = solve(normal, wanted_n) else { return false };
            let mut longest_rad: f64 = 0.0;
            for module in 0..modules {
                let [a, p] = self.slopes[module];
                longest_rad = longest_rad.max(dot(a, y).abs()).max(dot(p, y).abs());
            }
            let share = if longest_rad > STEP_MAX_RAD { STEP_MAX_RAD / longest_rad } else { 1.0 };
            let mut moved_rad: f64 = 0.0;
            for module in 0..modules {
                let [a, p] = self.slopes[module];
                let cycle = &mut self.trial[module];
                if cycle.amplitude_rad == 0.0 || self.frozen[module] {
                    continue;
                }
                let sign = cycle.amplitude_rad.signum();
                let drawn = if dot(a, a) == 0.0 {
                    0.0
                } else {
                    pull * (aim.amplitude_rad - cycle.amplitude_rad.abs())
                };
                let step = share * (dot(a, y) + sign * drawn);
                let magnitude = (sign * (cycle.amplitude_rad + step)).clamp(least_rad, most_rad);
                moved_rad = moved_rad.max((sign * magnitude - cycle.amplitude_rad).abs());
                cycle.amplitude_rad = sign * magnitude;
                if cycle.turns {
                    let [back, on] = aim.room_rad(rest, module, cycle.rest_rad);
                    let turn_rad = (share * dot(p, y)).clamp(back, on);
                    moved_rad = moved_rad.max(turn_rad.abs());
                    cycle.rest_rad += turn_rad;
                }
            }
            pull = 0.0;
            if moved_rad < 1e-13 {
                return false;
            }
        }
        false
    }

    /// Lets go of what stands at a bound and would be pushed beyond it: its slope counts as zero in this step.
    fn outward(&mut self, rest: &RestPoses, law: &Law, aim: &Aim, residual_n: [f64; 3]) {
        let [least_rad, most_rad] = law.range_rad;
        // The direction of steepest descent stands for that of the step, which is not known yet.
        for (module, slopes) in self.slopes.iter_mut().enumerate() {
            let cycle = self.trial[module];
            let grows = dot(slopes[0], residual_n) * cycle.amplitude_rad.signum();
            let magnitude = cycle.amplitude_rad.abs();
            if (magnitude <= least_rad && grows < 0.0) || (magnitude >= most_rad && grows > 0.0) {
                slopes[0] = [0.0; 3];
            }
            if cycle.turns {
                let [back, on] = aim.room_rad(rest, module, cycle.rest_rad);
                let along = dot(slopes[1], residual_n);
                if (along > 0.0 && on < 1e-12) || (along < 0.0 && back > -1e-12) {
                    slopes[1] = [0.0; 3];
                }
            }
        }
    }

    fn trial_allowed(&self, rules: &Rules<'_>) -> bool {
        let pairs = &rules.setting.pairs;
        pairs.all().iter().all(|pair| rules.allow(pair, self.trial[pair.i], self.trial[pair.j]))
    }

    /// Where the trial breaks the rules, both modules go back to what they did; they stay so from now on.
    fn take_back(&mut self, rules: &Rules<'_>) -> bool {
        let pairs = &rules.setting.pairs;
        let mut any = false;
        loop {
            let mut again = false;
            for pair in pairs.all() {
                let same = |m: usize| self.trial[m] == self.cycles[m];
                if (same(pair.i) && same(pair.j)) || rules.allow(pair, self.trial[pair.i], self.trial[pair.j])
                {
                    continue;
                }
                for module in [pair.i, pair.j] {
                    self.trial[module] = self.cycles[module];
                    self.frozen[module] = true;
                }
                (any, again) = (true, true);
            }
            if !again {
                return any;
            }
        }
    }
}
