//! The search for a transition from the present tail angles to the start of a cycle: in one step if possible, else in two.

use crate::buffers::Buffers;
use crate::motion::{Swing, ends};
use crate::pairs::Pair;
use crate::setting::{Approach, Case};
use crate::transition::solver::{Clearance, Least, Problem, Signs, Solver};

use super::asked::Asked;
use super::rest::RestPoses;

/// What two neighbours may do in a transition.
pub(super) struct Turning<'a> {
    pub(super) case: Case<'a>,
    pub(super) slow: bool,
}

impl Clearance for Turning<'_> {
    fn turn(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        let &Self { case, slow } = self;
        let offset = pair.offset;
        if case.is_unknown(pair) {
            return case.keeps_out(pair, from_rad, to_rad);
        }
        // Beside a tail that rests out of reach, anything goes.
        let still = |k: usize| from_rad[k].to_bits() == to_rad[k].to_bits();
        let reach = &case.reaches[offset];
        (0..2).any(|end| still(end) && reach.clears(end, from_rad[end]))
            || (case.may_turn(offset, from_rad, to_rad)
                || slow && case.may_turn_slowly(offset, from_rad, to_rad))
                && case.may_stop_turning(pair, from_rad, to_rad)
    }

    fn swim(&self, pair: &Pair, i: Swing, j: Swing) -> bool {
        let [from, to] = ends(i, j);
        if self.case.is_unknown(pair) {
            return self.case.keeps_out(pair, from, to);
        }
        let moves = [i, j].map(|swing| swing.amplitude_rad != 0.0);
        self.case.may_swim(pair.offset, moves, [from, to])
    }
}

/// The signs that may be chosen for the way to free rest poses: the other end of a swing from one is hardly free; where there are
/// none, it is as good.
pub fn signs(rest: &RestPoses, modules: usize) -> Signs {
    if (0..modules).all(|module| rest.has_free(module)) { Signs::Given } else { Signs::PerModule }
}

/// Finds the least transition from `tails` into `cycle`, slowly if there is none at the usual speed. Where amplitudes are negated
/// for it, `cycle` is changed: the same forces, from the other end. Where loss tolerance is asked for, no module that misses it is hit.
pub(super) fn find(
    solver: &mut Solver,
    buffers: &mut Buffers,
    rest: &RestPoses,
    asked: &Asked<'_>,
    tails: &[f64],
    cycle: &mut [Swing],
) -> Option<Approach> {
    [false, true].into_iter().find_map(|slow| {
        let clear = Turning { case: asked.case, slow };
        find_by(solver, buffers, &clear, rest, asked, tails, cycle)
    })
}

fn find_by(
    solver: &mut Solver,
    buffers: &mut Buffers,
    clear: &Turning<'_>,
    rest: &RestPoses,
    asked: &Asked<'_>,
    tails: &[f64],
    cycle: &mut [Swing],
) -> Option<Approach> {
    let &Turning { case, slow } = clear;
    let &Asked { signs, loss_tolerant, .. } = asked;
    let free = |module: usize| rest.is_free(module, tails[module]);
    // A module in a free pose may always stay.
    let stranded = loss_tolerant && !(0..tails.len()).all(free);
    let problem =
        Problem { pairs: &case.pairs, from_rad: tails, cycle, limit_rad: case.rotation_max_rad(), stranded };
    let longest = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        pairs.map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
    };
    if let Some(Least { turns, negated, .. }) = solver.one_step(&problem, signs, clear) {
        let longest_rad = longest(&mut turns.iter().map(|turn| (turn.from_rad, turn.to_rad)));
        let approach = Approach {
            turns: buffers.turns(turns.iter().copied()),
            via_rad: None,
            times: [case.step_time(longest_rad, slow); 2],
            slow,
        };
        for (swing, _) in cycle.iter_mut().zip(negated).filter(|(_, negated)| **negated) {
            swing.amplitude_rad = -swing.amplitude_rad;
        }
        return Some(approach);
    }
    let via = |module: usize| if free(module) { &[][..] } else { rest.stations_rad(module) };
    let least = solver.two_steps(&problem, via, clear)?;
    let via_rad = least.via_rad?;
    let first = longest(&mut least.turns.iter().zip(via_rad).map(|(turn, &via)| (turn.from_rad, via)));
    let second = longest(&mut least.turns.iter().zip(via_rad).map(|(turn, &via)| (via, turn.to_rad)));
    Some(Approach {
        turns: buffers.turns(least.turns.iter().copied()),
        via_rad: Some(buffers.poses_rad(via_rad.iter().copied())),
        times: [first, second].map(|longest_rad| case.step_time(longest_rad, slow)),
        slow,
    })
}
