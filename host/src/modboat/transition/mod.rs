//! The transition solver of §II-E: which way round each tail turns from the end of one cycle to the start of
//! the next, without a collision and with the least total travel.
//!
//! ```text
//! rotation ∈ {δ, δ ∓ 2π},  δ = wrap(φ₀ + A − φ_from)      clockwise or counter-clockwise
//! rotation = 0             if the tail is there already
//! ```
//!
//! Turns take all of t_trans at constant speed, so the motion of a pair is a straight segment in its phase
//! space (φᵢ, φⱼ). As in the paper, the amplitudes of all modules may be negated at once, which moves every
//! start to the other end of its swing and changes no force.
//!
//! As in the paper's Fig. 5, rows and columns are sub-problems whose arc-consistent sets are intersected. The
//! paper then enumerates what is left, exponential in the number of modules; here a branch and bound with
//! propagation over *all* pairs takes its place (see [`search`]), which also covers pairs that are neither in
//! a row nor in a column.

pub mod domain;
pub mod search;

use std::f64::consts::TAU;

use super::motion::{Swing, Turn};
use super::pairs::Pairs;
use crate::quantity::wrap_rad;
use domain::{Allowed, Domain, propagate};
use search::Problem;

/// A rotation below this is none at all, rad.
pub const STILL_RAD: f64 = 1e-9;

/// Branches after which the least travel need not be proved.
const NODE_LIMIT: usize = 2000;

/// A transition for every module.
#[derive(Clone, Debug, PartialEq)]
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

impl Transition {
    /// True if nothing moves.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.turns.iter().all(|turn| turn.rotation_rad().abs() < STILL_RAD)
    }
}

/// Rotations by the short and the long way, rad, and which of them are open within `limit_rad`.
fn ways(from_rad: f64, to_rad: f64, limit_rad: f64) -> ([f64; 2], Domain) {
    let short = wrap_rad(to_rad - from_rad);
    if short.abs() < STILL_RAD {
        return ([0.0, 0.0], Domain::only(0));
    }
    let long = if short > 0.0 { short - TAU } else { short + TAU };
    let mut open = Domain::EMPTY;
    for (way, rotation) in [short, long].into_iter().enumerate() {
        if rotation.abs() <= limit_rad + STILL_RAD {
            open = open.union(Domain::only(way));
        }
    }
    ([short, long], open)
}

/// The transition with the least travel from the poses `from_rad` into `cycle`, over both signs of the
/// amplitudes; `None` if it is proved that there is none.
///
/// `cells` are the lattice cells by module, `limit_rad` the greatest |rotation|, and `clear(offset, from, to)`
/// says whether two neighbours at that offset index may turn along the segment from → to of (φᵢ, φⱼ).
#[must_use]
pub fn solve(
    pairs: &Pairs,
    cells: &[[i32; 2]],
    from_rad: &[f64],
    cycle: &[Swing],
    limit_rad: f64,
    clear: impl Fn(usize, [f64; 2], [f64; 2]) -> bool,
) -> Option<Transition> {
    let mut best: Option<Transition> = None;
    for negated in [false, true] {
        let sign = if negated { -1.0 } else { 1.0 };
        let to_rad = |swing: &Swing| swing.centerline_rad + sign * swing.amplitude_rad;
        let (rotations, domains): (Vec<_>, Vec<_>) =
            from_rad.iter().zip(cycle).map(|(&from, swing)| ways(from, to_rad(swing), limit_rad)).unzip();
        if domains.iter().any(|d| d.is_empty()) {
            continue;
        }
        let Some(answer) = one_sign(pairs, cells, from_rad, &rotations, &domains, &clear) else { continue };
        let turns: Vec<Turn> = (from_rad.iter().zip(&rotations).zip(&answer.ways))
            .map(|((&from, rotation), &way)| Turn { from_rad: from, to_rad: from + rotation[way] })
            .collect();
        let travel_rad = turns.iter().map(|turn| turn.rotation_rad().abs()).sum();
        if best.as_ref().is_none_or(|best| travel_rad < best.travel_rad) {
            best = Some(Transition { turns, negated, travel_rad, exact: answer.exact });
        }
    }
    best
}

fn one_sign(
    pairs: &Pairs,
    cells: &[[i32; 2]],
    from_rad: &[f64],
    rotations: &[[f64; 2]],
    domains: &[Domain],
    clear: &impl Fn(usize, [f64; 2], [f64; 2]) -> bool,
) -> Option<search::Answer> {
    let allowed: Vec<Allowed> = pairs
        .all()
        .iter()
        .map(|pair| {
            let from = [from_rad[pair.i], from_rad[pair.j]];
            let mut allowed = Allowed::default();
            for way_i in (0..2).filter(|&way| domains[pair.i].has(way)) {
                for way_j in (0..2).filter(|&way| domains[pair.j].has(way)) {
                    let to = [from[0] + rotations[pair.i][way_i], from[1] + rotations[pair.j][way_j]];
                    if clear(pair.offset, from, to) {
                        allowed.allow(way_i, way_j);
                    }
                }
            }
            allowed
        })
        .collect();
    // Rows, then columns, each from the full sets; what both leave goes on.
    let mut remaining = domains.to_vec();
    for axis in [1, 0] {
        let same_line = |index: usize| {
            let pair = pairs.all()[index];
            cells[pair.i][axis] == cells[pair.j][axis]
        };
        let mut line = domains.to_vec();
        let (mut queue, mut trail) = ((0..line.len()).collect(), Vec::new());
        if !propagate(pairs, &allowed, &mut line, &mut queue, &mut trail, same_line) {
            return None;
        }
        for (kept, line) in remaining.iter_mut().zip(line) {
            *kept = kept.intersect(line);
        }
    }
    let travel_rad: Vec<[f64; 2]> = rotations.iter().map(|r| r.map(f64::abs)).collect();
    Problem { pairs, allowed: &allowed, travel_rad: &travel_rad, node_limit: NODE_LIMIT }.solve(remaining)
}

#[cfg(test)]
mod tests;
