//! The transition with the least total travel, in one step or in two, exactly.
//!
//! ```text
//! one step    φ_from → φ_to                φ_to ≡ φ₀ + A, or φ₀ − A where the amplitude is negated (the force is the same)
//! two steps   φ_from → φ_via → φ_to        φ_via = φ_to (turns first), φ_from (turns second), or a pose of the caller's
//! ```
//!
//! In each step all tails turn for the same time by one law of time, so a pair moves along a segment of (φᵢ, φⱼ). Every turn goes
//! the short way round or the long way, δ or δ ∓ 2π, within the speed limit. Each combination of two neighbours' ways collides
//! or does not, which makes it a problem for [`super::choice`]; with the signs as given, every module has at most two ways, and
//! whether there is a transition is 2-SAT.
//!
//! *Two steps are always enough between poses out of every neighbour's reach.* Colour the cells of the lattice black and white like a
//! chessboard. White rests out of reach while black turns, then black while white turns. Neighbours side by side have different
//! colours, so in either step a pair has one tail at rest, out of the other's reach wherever that is. All of that is among the
//! choices, so the planner is never stuck there, as long as only tails side by side can touch.
//!
//! *Loss.* `stranded` asks further that no tails collide when any subset of the modules misses the transition and stays where it
//! is. Collisions are between two, so it is enough that of each pair both turn, only i turns, or only j turns. Whether i may swim
//! beside a j that stayed behind does not depend on the ways taken, nor on signs: that is for the planner to ask beforehand.
//!
//! Assumption: `cycle` itself is free of collisions. Then so is the cycle with all amplitudes negated, which sweeps the same
//! segments, and a swim needs a look only where one of a pair is negated.

use std::f64::consts::TAU;

use quantity::wrap_rad;

use super::STILL_RAD;
use super::choice::{Answer, Chooser, Limits, OPTIONS_MAX};
use crate::motion::{Swing, Turn};
use crate::pairs::{Pair, Pairs};

/// Which motions of two neighbours are free of collisions.
pub trait Clearance {
    /// Both turn by one law of time from (φᵢ, φⱼ) to (φᵢ, φⱼ).
    fn turn(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool;

    /// Both swim.
    fn swim(&self, pair: &Pair, i: Swing, j: Swing) -> bool;
}

/// The transition that the solver is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The neighbours.
    pub pairs: &'a Pairs,
    /// Where the tails rest, by module, unwrapped, rad.
    pub from_rad: &'a [f64],
    /// The cycle to start, by module.
    pub cycle: &'a [Swing],
    /// Greatest |rotation| in one step: the tail's speed limit times the step's time, rad.
    pub limit_rad: f64,
    /// Also ask that no tails collide when any subset of the modules stays where it is.
    pub stranded: bool,
}

/// Which amplitudes may be negated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    /// None.
    Given,
    /// All are.
    Negated,
    /// Any, where the neighbours' cycles stay clear of each other.
    PerModule,
}

/// A transition of least travel; it stays in the solver until the next is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least<'a> {
    /// Each module's turn; of two steps, from the first's start to the second's end.
    pub turns: &'a [Turn],
    /// Of two steps, the poses between them, unwrapped, rad.
    pub via_rad: Option<&'a [f64]>,
    /// Modules with an amplitude to be negated.
    pub negated: &'a [bool],
    /// Σ |rotation|, rad.
    pub travel_rad: f64,
    /// Proved: no transition has less than this, rad. The travel itself where it is proved least.
    pub bound_rad: f64,
}

/// One way for one module.
#[derive(Clone, Copy, Debug)]
struct Way {
    via_rad: f64,
    to_rad: f64,
    negated: bool,
    travel_rad: f64,
}

/// The transition solver with its workspace: it allocates nothing once it has met a problem of the size.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    chooser: Chooser,
    /// The ways of module m are `ways[first[m]..first[m + 1]]`, least travel first.
    ways: Vec<Way>,
    first: Vec<usize>,
    turns: Vec<Turn>,
    via_rad: Vec<f64>,
    negated: Vec<bool>,
}

/// Rotations within `limit_rad` from one pose to another, the short way first, rad.
pub(crate) fn rotations(from_rad: f64, to_rad: f64, limit_rad: f64) -> impl Iterator<Item = f64> {
    let short = wrap_rad(to_rad - from_rad);
    let still = short.abs() < STILL_RAD;
    let long = if short > 0.0 { short - TAU } else { short + TAU };
    let ways = [Some(if still { 0.0 } else { short }), (!still).then_some(long)];
    ways.into_iter().flatten().filter(move |rotation| rotation.abs() <= limit_rad + STILL_RAD)
}

/// A cycle with the amplitude negated.
const fn negate(swing: Swing) -> Swing {
    Swing { amplitude_rad: -swing.amplitude_rad, ..swing }
}

impl Solver {
    /// A solver that spends no more than `limits`.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self { chooser: Chooser::new(limits), ..Self::default() }
    }

    /// A solver with room for problems of these pairs: see [`Chooser::reserve`].
    #[must_use]
    pub fn with_room(pairs: &Pairs) -> Self {
        let mut solver = Self::default();
        let modules = pairs.modules();
        solver.chooser.reserve(pairs);
        // A module has more ways until those with the most travel are left out.
        solver.ways.reserve(OPTIONS_MAX * (modules + 8));
        solver.first.reserve(modules + 1);
        solver.turns.reserve(modules);
        solver.via_rad.reserve(modules);
        solver.negated.reserve(modules);
        solver
    }

    /// The transition in one step. `None` with [`Signs::Given`] or [`Signs::Negated`] is a proof that there is none; with
    /// [`Signs::PerModule`] that there is none with the signs as given or all negated, and none at all within [`Limits`].
    pub fn one_step(&mut self, problem: &Problem, signs: Signs, clear: &impl Clearance) -> Option<Least<'_>> {
        let free = match self.try_one_step(problem, signs, clear) {
            Answer::Best { cost, bound } => return Some(self.least(problem, false, cost, bound)),
            Answer::Impossible => return None,
            Answer::Unknown => self.ways_alone_rad(),
        };
        // Two ways each, which are always decided.
        [Signs::Given, Signs::Negated]
            .into_iter()
            .find_map(|signs| match self.try_one_step(problem, signs, clear) {
                Answer::Best { cost, .. } => Some(cost),
                _ => None,
            })
            .map(|cost| self.least(problem, false, cost, free))
    }

    /// The transition in two steps, each within `limit_rad`; `via(module)` are the poses that the module may go through beside
    /// those it starts and ends at. Of more than 16 ways of a module, those through a pose with the most travel are left out.
    /// The signs are as given. `None`: there is none of these, or none was met within [`Limits`].
    pub fn two_steps<'v>(
        &mut self,
        problem: &Problem,
        via: impl Fn(usize) -> &'v [f64],
        clear: &impl Clearance,
    ) -> Option<Least<'_>> {
        self.begin();
        for (module, (&from_rad, swing)) in problem.from_rad.iter().zip(problem.cycle).enumerate() {
            let start = self.ways.len();
            for rotation in rotations(from_rad, swing.start_rad(), problem.limit_rad) {
                let (to_rad, travel_rad) = (from_rad + rotation, rotation.abs());
                self.ways.push(Way { via_rad: to_rad, to_rad, negated: false, travel_rad });
                if to_rad.to_bits() != from_rad.to_bits() {
                    self.ways.push(Way { via_rad: from_rad, to_rad, negated: false, travel_rad });
                }
            }
            let direct = self.ways.len();
            for &pose_rad in via(module) {
                let same = |other: f64| wrap_rad(pose_rad - other).abs() < STILL_RAD;
                if same(from_rad) || same(swing.start_rad()) {
                    continue;
                }
                for first in rotations(from_rad, pose_rad, problem.limit_rad) {
                    let via_rad = from_rad + first;
                    for second in rotations(via_rad, swing.start_rad(), problem.limit_rad) {
                        let travel_rad = first.abs() + second.abs();
                        self.ways.push(Way { via_rad, to_rad: via_rad + second, negated: false, travel_rad });
                    }
                }
            }
            self.ways[direct..].sort_unstable_by(|a, b| a.travel_rad.total_cmp(&b.travel_rad));
            self.ways.truncate(start + OPTIONS_MAX);
            self.end_module();
        }
        let (ways, first) = (&self.ways, &self.first);
        let answer = self.chooser.choose(problem.pairs, |index, way_i, way_j| {
            let pair = problem.pairs.all()[index];
            let from = [problem.from_rad[pair.i], problem.from_rad[pair.j]];
            let (i, j) = (ways[first[pair.i] + way_i], ways[first[pair.j] + way_j]);
            let path =
                |via: [f64; 2], to: [f64; 2]| clear.turn(&pair, from, via) && clear.turn(&pair, via, to);
            path([i.via_rad, j.via_rad], [i.to_rad, j.to_rad])
                && (!problem.stranded
                    || path([i.via_rad, from[1]], [i.to_rad, from[1]])
                        && path([from[0], j.via_rad], [from[0], j.to_rad]))
        });
        match answer {
            Answer::Best { cost, bound } => Some(self.least(problem, true, cost, bound)),
            Answer::Impossible | Answer::Unknown => None,
        }
    }

    fn try_one_step(&mut self, problem: &Problem, signs: Signs, clear: &impl Clearance) -> Answer {
        self.begin();
        for (&from_rad, &swing) in problem.from_rad.iter().zip(problem.cycle) {
            let start = self.ways.len();
            for negated in [false, true] {
                let to_rad = if negated { negate(swing) } else { swing }.start_rad();
                let asked = match signs {
                    Signs::Given => !negated,
                    Signs::Negated => negated,
                    // One that rests has only one end.
                    Signs::PerModule => !negated || wrap_rad(to_rad - swing.start_rad()).abs() >= STILL_RAD,
                };
                let rotations = rotations(from_rad, to_rad, problem.limit_rad).filter(|_| asked);
                self.ways.extend(rotations.map(|rotation| {
                    let to_rad = from_rad + rotation;
                    Way { via_rad: to_rad, to_rad, negated, travel_rad: rotation.abs() }
                }));
            }
            // Of equals, the one with the sign as given.
            let least =
                |a: &Way, b: &Way| a.travel_rad.total_cmp(&b.travel_rad).then(a.negated.cmp(&b.negated));
            self.ways[start..].sort_unstable_by(least);
            self.end_module();
        }
        let (ways, first) = (&self.ways, &self.first);
        self.chooser.choose(problem.pairs, |index, way_i, way_j| {
            let pair = problem.pairs.all()[index];
            let [from_i, from_j] = [problem.from_rad[pair.i], problem.from_rad[pair.j]];
            let (i, j) = (ways[first[pair.i] + way_i], ways[first[pair.j] + way_j]);
            let [swing_i, swing_j] = [problem.cycle[pair.i], problem.cycle[pair.j]];
            let turn = |to: [f64; 2]| clear.turn(&pair, [from_i, from_j], to);
            // One that rests is the same negated.
            let mixed =
                i.negated != j.negated && swing_i.amplitude_rad != 0.0 && swing_j.amplitude_rad != 0.0;
            turn([i.to_rad, j.to_rad])
                && (!problem.stranded || turn([i.to_rad, from_j]) && turn([from_i, j.to_rad]))
                && (!mixed || clear.swim(&pair, swing_i, negate(swing_j)))
        })
    }

    fn begin(&mut self) {
        self.chooser.clear();
        self.ways.clear();
        self.first.clear();
        self.first.push(0);
    }

    fn end_module(&mut self) {
        let start = self.first.last().copied().unwrap_or(0);
        self.chooser.module(self.ways[start..].iter().map(|way| way.travel_rad));
        self.first.push(self.ways.len());
    }

    /// The least travel if no tail were in another's way.
    fn ways_alone_rad(&self) -> f64 {
        self.first
            .windows(2)
            .map(|ends| self.ways[ends[0]..ends[1]].first().map_or(0.0, |w| w.travel_rad))
            .sum()
    }

    /// Writes down the ways that were chosen.
    fn least(&mut self, problem: &Problem, two_steps: bool, travel_rad: f64, bound_rad: f64) -> Least<'_> {
        self.turns.clear();
        self.via_rad.clear();
        self.negated.clear();
        for (module, &option) in self.chooser.chosen().iter().enumerate() {
            let way = self.ways[self.first[module] + usize::from(option)];
            self.turns.push(Turn { from_rad: problem.from_rad[module], to_rad: way.to_rad });
            self.via_rad.push(way.via_rad);
            self.negated.push(way.negated);
        }
        let via_rad = two_steps.then_some(self.via_rad.as_slice());
        Least { turns: &self.turns, via_rad, negated: &self.negated, travel_rad, bound_rad }
    }
}

#[cfg(test)]
mod tests;
