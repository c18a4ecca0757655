//! The transition solver of §II-E: which way round each tail turns from the end of one cycle to the start of
//! the next, without a collision and with the least total travel.
//!
//! ```text
//! rotation ∈ {δ, δ ∓ 2π},  δ = wrap(φ₀ + A − φ_from)      clockwise or counter-clockwise
//! rotation = 0             if the tail is there already
//! ```
//!
//! Turns take all of t_trans by one law of time, so the motion of a pair is a straight segment in its phase
//! space (φᵢ, φⱼ).
//!
//! The paper (Fig. 5) prunes rows and columns and enumerates what is left, exponential in the number of modules. Here the
//! choice is exact at any width that a frontier can pass over and bounded beyond ([`choice`]); amplitudes may be negated
//! one by one, a transition may take two steps, and it may be asked to survive losses ([`solver`]). [`solve`] is the
//! paper's own question: one step, and the amplitudes of all modules negated at once or not at all.

pub mod choice;
pub mod solver;

use super::motion::{Swing, Turn};
use super::pairs::{Pair, Pairs};
use solver::{Clearance, Problem, Signs, Solver};

/// A rotation below this is none at all, rad.
pub const STILL_RAD: f64 = 1e-9;

/// A transition for every module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transition {
    /// Each module's rotation.
    pub turns: Vec<Turn>,
    /// True if the amplitudes of the next cycle are to be negated.
    pub negated: bool,
    /// Σ |rotation|, rad.
    pub travel_rad: f64,
    /// True if proved to be the least travel.
    pub exact: bool,
}

/// Clearance of turns only: swims need no check where all amplitudes keep or change their sign together.
struct Turns<F>(F);

impl<F: Fn(usize, [f64; 2], [f64; 2]) -> bool> Clearance for Turns<F> {
    fn turn(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        self.0(pair.offset, from_rad, to_rad)
    }

    fn swim(&self, _: &Pair, _: Swing, _: Swing) -> bool {
        true
    }
}

/// Writes into `best`, with the memory of `solver`, the transition with the least travel from the poses `from_rad` into `cycle`,
/// over both signs of the amplitudes; false if it is proved that there is none.
///
/// `limit_rad` is the greatest |rotation|, and `clear(offset, from, to)` says whether two neighbours at that offset index
/// may turn along the segment from → to of (φᵢ, φⱼ).
pub fn solve(
    solver: &mut Solver,
    pairs: &Pairs,
    from_rad: &[f64],
    cycle: &[Swing],
    limit_rad: f64,
    clear: impl Fn(usize, [f64; 2], [f64; 2]) -> bool,
    best: &mut Transition,
) -> bool {
    let problem = Problem { pairs, from_rad, cycle, limit_rad, stranded: false };
    let clear = Turns(clear);
    let mut any = false;
    for signs in [Signs::Given, Signs::Negated] {
        let Some(least) = solver.one_step(&problem, signs, &clear) else { continue };
        if !any || least.travel_rad < best.travel_rad {
            best.turns.clear();
            best.turns.extend_from_slice(least.turns);
            best.negated = signs == Signs::Negated;
            best.travel_rad = least.travel_rad;
            best.exact = least.travel_rad <= least.bound_rad;
            any = true;
        }
    }
    any
}

#[cfg(test)]
mod tests;
