//! From a demanded wrench to the amplitudes of all modules between given rest poses: coordinate descent over a coarse set
//! of amplitudes, of one rest pose or of all on offer, then Newton's method in continuous ones.
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

use quantity::vector::dot;

use super::law::Law;
use super::neighbours::{Cycle, Rules};
use super::rest::RestPoses;
use crate::parameters::Parameters;

/// Relative weighted error that counts as none.
const EXACT: f64 = 1e-9;
/// Relative weighted error to aim at.
pub const GOAL: f64 = 0.01 * EXACT;
/// Weighted error that counts as none whatever the demand, N.
const EXACT_N: f64 = 1e-13;
/// Sweeps of coordinate descent.
const SWEEPS: usize = 2;
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

/// The demand that a search aims at, and the amplitudes that it prefers.
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

/// From which rest poses a descent takes cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Poses {
    /// Each module keeps the one that it has.
    Kept,
    /// From all that are on offer ([`RestPoses::stations_rad`]).
    Offered,
}

/// The search for amplitudes, with the cycles found so far.
#[derive(Clone, Debug, Default)]
pub struct Allocation {
    /// Each module's cycle; always one that the rules allow.
    pub cycles: Vec<Cycle>,
    /// What each gives, Mᵢuᵢ, N, and what is left of the aim, r, N: while amplitudes are descended.
    given_n: Vec<[f64; 3]>,
    residual_n: [f64; 3],
    places: Vec<Place>,
    trial: Vec<Cycle>,
    /// Rows of Jᵀ, by the amplitude and by the rest pose of each module of the trial.
    by_amplitude: Vec<[f64; 3]>,
    by_pose: Vec<[f64; 3]>,
    frozen: Vec<bool>,
    costs: Vec<f64>,
}

/// Mᵢ of one module, times its share of law (2): (w₁, w₂) and w₃·(x, y).
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    weights: [f64; 2],
    lever_m: [f64; 2],
}

impl Place {
    /// Mᵢ u.
    fn give_n(&self, [x_n, y_n]: [f64; 2]) -> [f64; 3] {
        let ([w1, w2], [x_m, y_m]) = (self.weights, self.lever_m);
        [w1 * x_n, w2 * y_n, x_m * y_n - y_m * x_n]
    }
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
    /// For modules at `positions_m` (m, in S), of which none is offered more than so many cycles.
    #[must_use]
    pub fn new(
        positions_m: &[[f64; 2]],
        parameters: &Parameters,
        [w1, w2, w3]: [f64; 3],
        offered: usize,
    ) -> Self {
        let modules = positions_m.len();
        let place = |(module, at_m): (usize, &[f64; 2])| {
            let share = parameters.share(module);
            Place { weights: [share * w1, share * w2], lever_m: at_m.map(|lever_m| share * w3 * lever_m) }
        };
        Self {
            cycles: vec![Cycle::default(); modules],
            given_n: vec![[0.0; 3]; modules],
            residual_n: [0.0; 3],
            places: positions_m.iter().enumerate().map(place).collect(),
            trial: vec![Cycle::default(); modules],
            by_amplitude: vec![[0.0; 3]; modules],
            by_pose: vec![[0.0; 3]; modules],
            frozen: vec![false; modules],
            costs: Vec::with_capacity(offered),
        }
    }

    /// Begins from these cycles, which must be allowed together.
    pub fn begin(&mut self, cycles: impl Iterator<Item = Cycle>) {
        for (own, cycle) in self.cycles.iter_mut().zip(cycles) {
            *own = cycle;
        }
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
                .case
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

    fn refresh(&mut self, law: &Law, target_n: [f64; 3]) {
        self.residual_n = target_n;
        for ((cycle, place), given_n) in self.cycles.iter().zip(&self.places).zip(&mut self.given_n) {
            *given_n = if cycle.amplitude_rad == 0.0 {
                [0.0; 3]
            } else {
                place.give_n(law.push(cycle.rest_rad, cycle.amplitude_rad).thrust_n)
            };
            (0..3).for_each(|k| self.residual_n[k] -= given_n[k]);
        }
    }

    /// A few sweeps of coordinate descent over the modules, in `order` from the place `first` on and round.
    #[expect(clippy::too_many_arguments, reason = "the parts of a search, which it borrows one by one")]
    pub fn descend(
        &mut self,
        rules: &Rules<'_>,
        rest: &RestPoses,
        law: &Law,
        aim: &Aim,
        poses: Poses,
        order: &[usize],
        first: usize,
    ) {
        self.refresh(law, aim.target_n);
        for _ in 0..SWEEPS {
            for &module in order[first..].iter().chain(&order[..first]) {
                let own_rad = self.cycles[module].rest_rad;
                let poses_rad = match poses {
                    Poses::Kept => std::slice::from_ref(&own_rad),
                    Poses::Offered => rest.stations_rad(module),
                };
                self.descend_one(rules, rest, law, aim, module, poses_rad);
            }
        }
    }

    fn descend_one(
        &mut self,
        rules: &Rules<'_>,
        rest: &RestPoses,
        law: &Law,
        aim: &Aim,
        module: usize,
        poses_rad: &[f64],
    ) {
        let own_n = self.given_n[module];
        let without_n = [0, 1, 2].map(|k| self.residual_n[k] + own_n[k]);
        let present = self.cycles[module];
        let pull = |amplitude_rad: f64| {
            let off_rad = amplitude_rad.abs() - aim.amplitude_rad;
            aim.pull_n2_rad2 * off_rad * off_rad
        };
        let present_cost = dot(own_n, own_n) - 2.0 * dot(own_n, without_n) + pull(present.amplitude_rad);
        // M R of a rest pose.
        let place = self.places[module];
        let columns = |pose_rad: f64| {
            let (sin, cos) = pose_rad.sin_cos();
            [[cos, sin], [-sin, cos]].map(|column| place.give_n(column))
        };
        self.costs.clear();
        for &pose_rad in poses_rad {
            // |t − M R u₀|² = |t|² − 2 (Rᵀ Mᵀ t)·u₀ + u₀ᵀ (Rᵀ Mᵀ M R) u₀
            let [a, b] = columns(pose_rad);
            let linear = [dot(a, without_n), dot(b, without_n)];
            let square = [dot(a, a), dot(a, b), dot(b, b)];
            self.costs.extend(law.thrusts_n.iter().zip(&law.amplitudes_rad).map(
                |(&[x, y], &amplitude_rad)| {
                    x * (square[0] * x - 2.0 * linear[0])
                        + y * (2.0 * square[1] * x + square[2] * y - 2.0 * linear[1])
                        + pull(amplitude_rad)
                },
            ));
        }
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
            let amplitudes = law.amplitudes_rad.len();
            let (pose_rad, amplitude) = (poses_rad[best.0 / amplitudes], best.0 % amplitudes);
            let cycle = rest.cycle(module, pose_rad, law.amplitudes_rad[amplitude]);
            let cycle = Cycle { turns: present.turns, ..cycle };
            if rules.allow_among(module, cycle, |other| self.cycles[other]) {
                let ([a, b], [x, y]) = (columns(pose_rad), law.thrusts_n[amplitude]);
                let new_n = [0, 1, 2].map(|k| a[k] * x + b[k] * y);
                self.residual_n = [0, 1, 2].map(|k| without_n[k] - new_n[k]);
                (self.given_n[module], self.cycles[module]) = (new_n, cycle);
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
        let modules = self.trial.len();
        let turning = self.trial.iter().any(|cycle| cycle.turns);
        let mut pull = recentre;
        let (mut last_n, mut slow) = (f64::INFINITY, 0);
        for _ in 0..STEPS {
            let (residual_n, drawn_n) = self.slopes(law, aim, pull);
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
            // J Jᵀ, its upper triangle.
            let mut normal = [0.0; 6];
            let mut add = |a: &[f64; 3]| {
                let products = [a[0] * a[0], a[0] * a[1], a[0] * a[2], a[1] * a[1], a[1] * a[2], a[2] * a[2]];
                normal.iter_mut().zip(products).for_each(|(entry, product)| *entry += product);
            };
            self.by_amplitude.iter().for_each(&mut add);
            if turning {
                self.by_pose.iter().for_each(&mut add);
            }
            let [xx, xy, xz, yy, yz, zz] = normal;
            let damping = DAMPING * (xx + yy + zz) + f64::MIN_POSITIVE;
            let normal = [[xx + damping, xy, xz], [xy, yy + damping, yz], [xz, yz, zz + damping]];
            let wanted_n = [0, 1, 2].map(|k| residual_n[k] - drawn_n[k]);
            let Some(y) = solve(normal, wanted_n) else { return false };
            let mut longest_rad: f64 = 0.0;
            for module in 0..modules {
                longest_rad = longest_rad.max(dot(self.by_amplitude[module], y).abs());
                if turning {
                    longest_rad = longest_rad.max(dot(self.by_pose[module], y).abs());
                }
            }
            let share = if longest_rad > STEP_MAX_RAD { STEP_MAX_RAD / longest_rad } else { 1.0 };
            if self.step(rest, law, aim, y, share, pull) < 1e-13 {
                return false;
            }
            pull = 0.0;
        }
        false
    }

    /// Works out the slopes at the trial. What is left of the aim there, and what the draw towards the middle would change, N.
    fn slopes(&mut self, law: &Law, aim: &Aim, pull: f64) -> ([f64; 3], [f64; 3]) {
        let (mut residual_n, mut drawn_n) = (aim.target_n, [0.0; 3]);
        for (module, cycle) in self.trial.iter().enumerate() {
            (self.by_amplitude[module], self.by_pose[module]) = ([0.0; 3], [0.0; 3]);
            if cycle.amplitude_rad == 0.0 {
                continue;
            }
            let place = &self.places[module];
            let push = law.push(cycle.rest_rad, cycle.amplitude_rad);
            let given_n = place.give_n(push.thrust_n);
            (0..3).for_each(|k| residual_n[k] -= given_n[k]);
            if self.frozen[module] {
                continue;
            }
            let by_amplitude = place.give_n(push.by_amplitude);
            self.by_amplitude[module] = by_amplitude;
            if pull > 0.0 {
                let drawn = pull * (aim.amplitude_rad - cycle.amplitude_rad.abs());
                let drawn = drawn * cycle.amplitude_rad.signum();
                (0..3).for_each(|k| drawn_n[k] += by_amplitude[k] * drawn);
            }
            if cycle.turns {
                // ∂u/∂p turns u by a right angle.
                self.by_pose[module] = place.give_n([-push.thrust_n[1], push.thrust_n[0]]);
            }
        }
        (residual_n, drawn_n)
    }

    /// One step of the trial, within bounds. The most that anything moved, rad.
    fn step(&mut self, rest: &RestPoses, law: &Law, aim: &Aim, y: [f64; 3], share: f64, pull: f64) -> f64 {
        let [least_rad, most_rad] = law.range_rad;
        let mut moved_rad: f64 = 0.0;
        for (module, cycle) in self.trial.iter_mut().enumerate() {
            if cycle.amplitude_rad == 0.0 || self.frozen[module] {
                continue;
            }
            let slope = self.by_amplitude[module];
            let (sign, magnitude_rad) = (cycle.amplitude_rad.signum(), cycle.amplitude_rad.abs());
            let held = pull == 0.0 || dot(slope, slope) == 0.0;
            let drawn = if held { 0.0 } else { pull * (aim.amplitude_rad - magnitude_rad) };
            let to_rad = magnitude_rad + share * (sign * dot(slope, y) + drawn);
            let to_rad = to_rad.clamp(least_rad, most_rad);
            moved_rad = moved_rad.max((to_rad - magnitude_rad).abs());
            cycle.amplitude_rad = sign * to_rad;
            if cycle.turns {
                let [back, on] = aim.room_rad(rest, module, cycle.rest_rad);
                let turn_rad = (share * dot(self.by_pose[module], y)).clamp(back, on);
                moved_rad = moved_rad.max(turn_rad.abs());
                cycle.rest_rad += turn_rad;
            }
        }
        moved_rad
    }

    /// Lets go of what stands at a bound and would be pushed beyond it: its slope counts as zero in this step.
    fn outward(&mut self, rest: &RestPoses, law: &Law, aim: &Aim, residual_n: [f64; 3]) {
        let [least_rad, most_rad] = law.range_rad;
        // The direction of steepest descent stands for that of the step, which is not known yet.
        for (module, cycle) in self.trial.iter().enumerate() {
            let magnitude_rad = cycle.amplitude_rad.abs();
            if magnitude_rad <= least_rad || magnitude_rad >= most_rad {
                let grows = dot(self.by_amplitude[module], residual_n) * cycle.amplitude_rad.signum();
                if (magnitude_rad <= least_rad && grows < 0.0) || (magnitude_rad >= most_rad && grows > 0.0) {
                    self.by_amplitude[module] = [0.0; 3];
                }
            }
            if cycle.turns {
                let [back, on] = aim.room_rad(rest, module, cycle.rest_rad);
                let along = dot(self.by_pose[module], residual_n);
                if (along > 0.0 && on < 1e-12) || (along < 0.0 && back > -1e-12) {
                    self.by_pose[module] = [0.0; 3];
                }
            }
        }
    }

    fn trial_allowed(&self, rules: &Rules<'_>) -> bool {
        let pairs = &rules.case.pairs;
        pairs.all().iter().all(|pair| rules.allow(pair, self.trial[pair.i], self.trial[pair.j]))
    }

    /// Where the trial breaks the rules, both modules go back to what they did; they stay so from now on.
    fn take_back(&mut self, rules: &Rules<'_>) -> bool {
        let pairs = &rules.case.pairs;
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
