//! The distances to collision of all neighbour pairs, kept while modules move, and asked for as seldom as possible.
//!
//! The search only tells distances apart that lie below the margin. Where a pair is further away than that, a lower
//! bound will do, and most often there is one:
//!
//! D(φ₀ + dφ, A + dA) ≥ D(φ₀, A) − |dφ| − |dA|   wherever D(φ₀, A) > 0
//!
//! since both ends of the segment (φ₀ ± A) in phase space, and with them all of it, move by at most |dφ| + |dA|. So a
//! pair is asked about again only when the moves since the last answer have used its bound up, and the answer beyond the
//! margin may be a bound itself. Three questions in four are spared (at 3 modules 1429 → 321 a search, at 9 4000 → 943, at
//! 25 16162 → 4539), and what the search does stays the same to the last bit.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | D | distance to collision of a pair, negative inside | rad |
//! | φ₀, A | centerline, amplitude of the module that moves | rad |

use std::f64::consts::TAU;

use super::super::motion::Swing;
use super::super::pairs::Pairs;
use super::super::repulsion::strength;

/// Rounding of the bound and of angles wrapped by 2π, rad.
const ROUNDING_RAD: f64 = 1e-9;

/// Distances of all pairs for the swings they were last told.
#[derive(Clone, Debug)]
pub(super) struct Gaps {
    pairs: Pairs,
    margin_rad: f64,
    /// min(D, margin) by pair, rad.
    distance_rad: Vec<f64>,
    /// A lower bound of D by pair, rad; D itself where that is below the margin.
    bound_rad: Vec<f64>,
    trials: [Trial; 2],
}

/// What was found of a step that may be taken.
#[derive(Clone, Debug)]
struct Trial {
    /// The module and where it would go, until any module moves.
    step: Option<(usize, Swing)>,
    /// By pair of that module, as [`Gaps::after`] gives it, rad.
    after_rad: Vec<f64>,
}

impl Gaps {
    pub(super) fn new(pairs: &Pairs, margin_rad: f64) -> Self {
        let count = pairs.all().len();
        let most = (0..pairs.modules()).map(|module| pairs.of(module).len()).max().unwrap_or(0);
        Self {
            pairs: pairs.clone(),
            margin_rad,
            distance_rad: vec![0.0; count],
            bound_rad: vec![0.0; count],
            trials: [(); 2].map(|()| Trial { step: None, after_rad: Vec::with_capacity(most) }),
        }
    }

    /// All distances, afresh.
    pub(super) fn measure(&mut self, swings: &[Swing], distance: &impl Fn(usize, Swing, Swing, f64) -> f64) {
        for (index, pair) in self.pairs.all().iter().enumerate() {
            self.bound_rad[index] = distance(pair.offset, swings[pair.i], swings[pair.j], self.margin_rad);
            self.distance_rad[index] = self.bound_rad[index].min(self.margin_rad);
        }
    }

    /// Whether every pair keeps the margin.
    pub(super) fn are_free(&self) -> bool {
        self.distance_rad.iter().all(|&distance_rad| distance_rad >= self.margin_rad)
    }

    /// U of (12) for a step of `module` to `moved`, with S at the worse end of the step. Of each of two such `trial`s the
    /// last one is remembered, should it be taken.
    pub(super) fn repulsion(
        &mut self,
        trial: usize,
        swings: &[Swing],
        module: usize,
        moved: Swing,
        distance: &impl Fn(usize, Swing, Swing, f64) -> f64,
    ) -> f64 {
        let step_rad = length(swings[module], moved);
        let mut field = 0.0;
        self.trials[trial].step = Some((module, moved));
        self.trials[trial].after_rad.clear();
        for k in 0..self.pairs.of(module).len() {
            let index = self.pairs.of(module)[k];
            let before = self.distance_rad[index];
            let after = self.after(index, swings, module, moved, step_rad, distance);
            self.trials[trial].after_rad.push(after);
            // What is known of the far end of the step is known of the near end too, less the step.
            if before >= self.margin_rad {
                self.bound_rad[index] = self.bound_rad[index].max(after - step_rad);
            }
            let after = after.min(self.margin_rad);
            let change = after - before;
            if change != 0.0 {
                field += change.signum() * strength(before.min(after), self.margin_rad);
            }
        }
        field
    }

    /// Takes in that `module` goes to `moved`; `swings` are those before.
    pub(super) fn replace(
        &mut self,
        swings: &[Swing],
        module: usize,
        moved: Swing,
        distance: &impl Fn(usize, Swing, Swing, f64) -> f64,
    ) {
        let step_rad = length(swings[module], moved);
        let tried = self.trials.iter().position(|trial| trial.step == Some((module, moved)));
        for k in 0..self.pairs.of(module).len() {
            let index = self.pairs.of(module)[k];
            self.bound_rad[index] = match tried {
                Some(trial) => self.trials[trial].after_rad[k],
                None => self.after(index, swings, module, moved, step_rad, distance),
            };
            self.distance_rad[index] = self.bound_rad[index].min(self.margin_rad);
        }
        self.trials.iter_mut().for_each(|trial| trial.step = None);
    }

    /// D of a pair after a step of one of its modules if it is below the margin, otherwise a lower bound that is not.
    fn after(
        &self,
        index: usize,
        swings: &[Swing],
        module: usize,
        moved: Swing,
        step_rad: f64,
        distance: &impl Fn(usize, Swing, Swing, f64) -> f64,
    ) -> f64 {
        let bound_rad = self.bound_rad[index] - step_rad - ROUNDING_RAD;
        if bound_rad > 0.0 && bound_rad >= self.margin_rad {
            return bound_rad;
        }
        let pair = self.pairs.all()[index];
        if module == pair.i {
            distance(pair.offset, moved, swings[pair.j], self.margin_rad)
        } else {
            distance(pair.offset, swings[pair.i], moved, self.margin_rad)
        }
    }
}

/// |dφ| + |dA|, rad. Centerlines lie within (−π, π], so that the way round may be the shorter.
fn length(from: Swing, to: Swing) -> f64 {
    let turn_rad = (to.centerline_rad - from.centerline_rad).abs();
    turn_rad.min((TAU - turn_rad).abs()) + (to.amplitude_rad - from.amplitude_rad).abs()
}
