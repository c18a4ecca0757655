//! The reason why a plan is held.

use super::{Case, Participation, Setting};
use crate::motion::Wrench;
use crate::pairs::Pair;
use crate::reason::Reason;

impl Case<'_> {
    /// Why nothing moves, with the tails at these angles; `guarantee_m` is what modules keep between them there.
    #[must_use]
    pub fn why_held(&self, demand: Wrench, tails: Option<&[f64]>, guarantee_m: Option<f64>) -> Reason {
        if !demand.weighted_norm(self.config.weights).is_finite() {
            return Reason::Demand;
        }
        if let Some(module) = tails.and_then(|tails| tails.iter().position(|tail| !tail.is_finite())) {
            return Reason::Tail { module };
        }
        let missing = self
            .participation
            .iter()
            .filter(|participation| **participation != Participation::Active)
            .count();
        let nearest = tails.and_then(|tails| self.nearest(tails));
        match nearest {
            Some((modules, clearance_m)) if clearance_m <= 0.0 => Reason::Touch { modules, clearance_m },
            Some((modules, clearance_m)) if guarantee_m.is_some_and(|m| m <= 0.0) => {
                Reason::Near { modules, clearance_m }
            }
            _ if missing > 0 => Reason::Missing { modules: missing },
            _ if self.tolerance.is_required() => Reason::NotTolerant,
            _ => Reason::NoWay,
        }
    }
}

impl Setting {
    /// The pair of tails with the least clearance at these angles, and that, m.
    fn nearest(&self, tails: &[f64]) -> Option<([usize; 2], f64)> {
        let (tail, offsets) = (self.distance.tail(), self.distance.offsets());
        let clearance_m = |pair: &Pair| tail.clearance_m(offsets[pair.offset], tails[pair.i], tails[pair.j]);
        let known = self.pairs.all().iter().filter(|pair| !self.is_unknown(pair));
        known.map(|pair| ([pair.i, pair.j], clearance_m(pair))).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
