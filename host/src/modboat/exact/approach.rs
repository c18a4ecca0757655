//! The way from where the tails are to where a cycle starts: one step if there is one, else two.

use crate::modboat::motion::Swing;
use crate::modboat::pairs::Pair;
use crate::modboat::setting::ends;
use crate::modboat::setting::{Approach, Setting};
use crate::modboat::transition::solver::{Clearance, Least, Problem, Signs, Solver};

use super::rest::RestPoses;

/// Share of the tail's greatest speed that transitions are planned for. *Assumed*: a servo needs some in hand.
const SPEED_SHARE: f64 = 0.8;
/// Time in which a servo gets up to speed and comes to rest, s. *Assumed*.
const SETTLE_S: f64 = 0.05;

/// What two neighbours may do in a transition.
pub(super) struct Turning<'a>(pub(super) &'a Setting);

impl Clearance for Turning<'_> {
    fn turn(&self, pair: &Pair, from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        let offset = pair.offset;
        if self.0.is_unknown(pair) {
            return self.0.keeps_out(pair, from_rad, to_rad);
        }
        // Beside a tail that rests out of reach, anything goes.
        let still = |k: usize| from_rad[k].to_bits() == to_rad[k].to_bits();
        let reach = &self.0.reaches[offset];
        still(0) && reach.clears_i(from_rad[0])
            || still(1) && reach.clears_j(from_rad[1])
            || self.0.may_turn(offset, from_rad, to_rad) && self.0.may_stop(pair, from_rad, to_rad)
    }

    fn swim(&self, pair: &Pair, i: Swing, j: Swing) -> bool {
        let [from, to] = ends(i, j);
        if self.0.is_unknown(pair) {
            return self.0.keeps_out(pair, from, to);
        }
        let offset = pair.offset;
        self.0.distance.clear(offset, from, to, self.0.config.swim_margin_rad)
    }
}

/// How long tails take that turn by at most `longest_rad`, s: less than a whole transition where they turn little.
pub(super) fn duration_s(setting: &Setting, longest_rad: f64) -> f64 {
    let speed_rad_s = SPEED_SHARE * setting.parameters.tail_speed_max_rad_s;
    (longest_rad / speed_rad_s + SETTLE_S).min(setting.parameters.transition_s)
}

/// The signs that may be chosen for the way to free rest poses: the other end of a swing from one is hardly free; where there are
/// none, it is as good.
pub fn signs(rest: &RestPoses, modules: usize) -> Signs {
    if (0..modules).all(|module| rest.has_free(module)) { Signs::Given } else { Signs::PerModule }
}

/// Finds the least transition from `tails` into `cycle`. Where amplitudes are negated for it, `cycle` is changed: the same
/// forces, from the other end. `loss_tolerant`: nobody who misses it is hit.
pub fn find(
    solver: &mut Solver,
    setting: &Setting,
    rest: &RestPoses,
    tails: &[f64],
    cycle: &mut [Swing],
    signs: Signs,
    loss_tolerant: bool,
) -> Option<Approach> {
    let clear = Turning(setting);
    let free = |module: usize| rest.is_free(module, tails[module]);
    // Who rests in a free pose may always stay.
    let stranded = loss_tolerant && !(0..tails.len()).all(free);
    let problem = Problem {
        pairs: &setting.pairs,
        from_rad: tails,
        cycle,
        limit_rad: setting.rotation_max_rad(),
        stranded,
    };
    let longest = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        pairs.map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
    };
    if let Some(Least { turns, negated, .. }) = solver.one_step(&problem, signs, &clear) {
        let longest_rad = longest(&mut turns.iter().map(|turn| (turn.from_rad, turn.to_rad)));
        let approach =
            Approach { turns: turns.to_vec(), via_rad: None, transition_s: duration_s(setting, longest_rad) };
        for (swing, _) in cycle.iter_mut().zip(negated).filter(|(_, negated)| **negated) {
            swing.amplitude_rad = -swing.amplitude_rad;
        }
        return Some(approach);
    }
    let via = |module: usize| if free(module) { &[][..] } else { rest.stations_rad(module) };
    let least = solver.two_steps(&problem, via, &clear)?;
    let via_rad = least.via_rad?;
    let first = longest(&mut least.turns.iter().zip(via_rad).map(|(turn, &via)| (turn.from_rad, via)));
    let second = longest(&mut least.turns.iter().zip(via_rad).map(|(turn, &via)| (via, turn.to_rad)));
    Some(Approach {
        turns: least.turns.to_vec(),
        via_rad: Some(via_rad.to_vec()),
        transition_s: duration_s(setting, first) + duration_s(setting, second),
    })
}
