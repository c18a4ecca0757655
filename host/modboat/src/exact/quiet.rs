//! Structures of few modules kept still: other rest poses once a demand has settled, if cycles from there turn the structure much less.

use super::asked::Quiet;
use super::search::{CycleCandidate, Search, Staying};
use crate::motion::{Swing, Wrench};
use crate::planner_config::LossTolerance;
use crate::setting::Case;

/// Cycles that turn the structure to and fro by less than this share of what it does now are worth a transition. *Assumed.*
const QUIETER: f64 = 0.75;
/// What turns the structure by less than this, rad, is not made quieter. *Assumed.*
const QUIET_RAD: f64 = 8e-4;
/// Room about the demand, a merit, that cycles must have, and what turning the structure costs against it, 1/rad: cycles with more room first,
/// for those with little are soon left when the demand changes a little. *Assumed.*
const WAYS: [(f64, f64); 3] = [(0.3, 100.0), (0.15, 200.0), (f64::NEG_INFINITY, 500.0)];

impl Search {
    /// Once the demand of few modules has settled: cycles that turn the structure much less to and fro than those that start where the tails
    /// rest, if there are any. Those that any module may stop in first.
    ///
    /// `near`: from which amplitudes the search begins where the tails stay; `previous`: the cycle before.
    pub fn keep_still(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        (tails, near): (&[f64], Option<&[Swing]>),
        previous: &[Swing],
    ) -> Option<CycleCandidate> {
        // Where the tails are unwrapped otherwise, they swing about the same.
        let about_rad: f64 = previous.iter().zip(tails).map(|(swing, tail)| tail - swing.amplitude_rad).sum();
        let here = self.stay(case, demand, tails, near, true, Staying::Searched)?;
        let now_rad = self.wobble.unrest_rad(&self.allocation.cycles, tails, about_rad);
        let now_rad = if here.met { now_rad } else { f64::INFINITY };
        here.discard(&mut self.buffers);
        if now_rad < QUIET_RAD {
            return None;
        }
        let tolerances = [LossTolerance::Power, LossTolerance::Prefer];
        for ((room, price_1_rad), tolerance) in
            WAYS.into_iter().flat_map(|way| tolerances.map(|kept| (way, kept)))
        {
            let case = Case { tolerance, before: None, ..case };
            let quiet = Quiet { about_rad, price_1_rad, room };
            for search in [Self::stay_still, Self::quietest] {
                let Some(found) = search(self, case, demand, tails, quiet) else { continue };
                if found.met && self.unrest_rad(&found.cycle, tails, about_rad) < QUIETER * now_rad {
                    return Some(found);
                }
                found.discard(&mut self.buffers);
            }
        }
        None
    }
}
