//! Whether the cycles of two neighbours are free of collisions: the constraint that every search here prunes by.

use crate::motion::{Swing, ends};
use crate::pairs::Pair;
use crate::setting::{Case, Participation};

/// One module's cycle as the search sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cycle {
    /// Rest pose, where it starts and ends, rad.
    pub rest_rad: f64,
    /// Signed amplitude, rad; 0: it rests.
    pub amplitude_rad: f64,
    /// Whether the rest pose is free: out of every neighbour's reach.
    pub free: bool,
    /// Whether it may still be turned, within its free arc.
    pub turns: bool,
}

impl Cycle {
    /// Its waveform (1): φ₀ = p − A.
    #[must_use]
    pub fn swing(self) -> Swing {
        Swing { centerline_rad: self.rest_rad - self.amplitude_rad, amplitude_rad: self.amplitude_rad }
    }
}

/// Constraints between the cycles of neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Rules<'a> {
    /// The structure, and what is asked of the plan.
    pub case: Case<'a>,
    /// Whether any module may miss the cycle and stay where it rests.
    pub loss_tolerant: bool,
}

impl Rules<'_> {
    /// Whether i and j of `pair` keep the margin in these cycles.
    #[must_use]
    pub fn allow(&self, pair: &Pair, i: Cycle, j: Cycle) -> bool {
        let stays_i = Cycle { amplitude_rad: 0.0, ..i };
        let stays_j = Cycle { amplitude_rad: 0.0, ..j };
        let active = |module: usize| self.case.participation[module] == Participation::Active;
        if (!active(pair.i) && i.amplitude_rad != 0.0) || (!active(pair.j) && j.amplitude_rad != 0.0) {
            return false;
        }
        let [from, to] = ends(i.swing(), j.swing());
        if self.case.is_unknown(pair) {
            return self.case.keeps_out(pair, from, to);
        }
        if !self.case.may_stop_swinging(pair, [i.swing(), j.swing()]) {
            return false;
        }
        // A module at rest in a free pose is in no other's way.
        match (i.amplitude_rad != 0.0, j.amplitude_rad != 0.0) {
            (false, false) => true,
            (true, false) => j.free || self.clear(pair, i, stays_j),
            (false, true) => i.free || self.clear(pair, stays_i, j),
            (true, true) => {
                self.clear(pair, i, j)
                    && (!self.loss_tolerant
                        || (j.free || self.clear(pair, i, stays_j))
                            && (i.free || self.clear(pair, stays_i, j)))
            }
        }
    }

    fn clear(&self, pair: &Pair, i: Cycle, j: Cycle) -> bool {
        let moves = [i, j].map(|cycle| cycle.amplitude_rad != 0.0);
        self.case.may_swim(pair.offset, moves, ends(i.swing(), j.swing()))
    }

    /// Whether `module` may do `cycle` beside what its neighbours do by `others`.
    pub fn allow_among(&self, module: usize, cycle: Cycle, others: impl Fn(usize) -> Cycle) -> bool {
        let pairs = &self.case.pairs;
        pairs.of(module).iter().all(|&index| {
            let pair = &pairs.all()[index];
            if pair.i == module {
                self.allow(pair, cycle, others(pair.j))
            } else {
                self.allow(pair, others(pair.i), cycle)
            }
        })
    }
}
