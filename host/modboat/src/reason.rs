//! Why nothing moves: what kept a planner from any plan.

use super::motion::Wrench;
use super::pairs::Pair;
use super::setting::{Presence, Setting};

/// Why a plan is [`held`](super::plan::Outcome::Held). Modules are counted from 0, in the order of the structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The demand is no number, or has no square.
    Demand,
    /// A tail's angle is no number.
    Tail {
        /// Of this module.
        module: usize,
    },
    /// Two tails touch as they are.
    Touch {
        /// Whose.
        modules: [usize; 2],
        /// Between their surfaces, m.
        clearance_m: f64,
    },
    /// Two tails rest so near each other that a module's errors could make them touch.
    Near {
        /// Whose.
        modules: [usize; 2],
        /// Between their surfaces, m.
        clearance_m: f64,
    },
    /// Not all modules take part, and what is left finds no plan beside those that do not.
    Missing {
        /// So many.
        modules: usize,
    },
    /// There are plans, but none found that any module may miss.
    NotTolerant,
    /// No cycle was found that the tails can get to.
    NoWay,
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Demand => write!(f, "the demand is not finite"),
            Self::Tail { module } => write!(f, "the tail angle of module {module} is not finite"),
            Self::Touch { modules: [i, j], clearance_m } => {
                write!(f, "tails of modules {i} and {j} touch at {:.1} mm", 1e3 * clearance_m)
            }
            Self::Near { modules: [i, j], clearance_m } => write!(
                f,
                "tails of modules {i} and {j} rest {:.1} mm apart: a module may be off by more",
                1e3 * clearance_m
            ),
            Self::Missing { modules } => {
                write!(f, "{modules} modules take no part, and the others found no plan beside them")
            }
            Self::NotTolerant => write!(f, "no plan was found that any module may miss"),
            Self::NoWay => write!(f, "no cycle was found that the tails can reach"),
        }
    }
}

impl Setting {
    /// Why nothing moves, with the tails at these angles; `guarantee_m` is what modules keep between them there.
    #[must_use]
    pub fn why_held(&self, demand: Wrench, tails: Option<&[f64]>, guarantee_m: Option<f64>) -> Reason {
        if !demand.weighted_norm(self.config.weights).is_finite() {
            return Reason::Demand;
        }
        if let Some(module) = tails.and_then(|tails| tails.iter().position(|tail| !tail.is_finite())) {
            return Reason::Tail { module };
        }
        let missing = self.presence.iter().filter(|presence| **presence != Presence::Takes).count();
        let nearest = tails.and_then(|tails| self.nearest(tails));
        match nearest {
            Some((modules, clearance_m)) if clearance_m <= 0.0 => Reason::Touch { modules, clearance_m },
            Some((modules, clearance_m)) if guarantee_m.is_some_and(|m| m <= 0.0) => {
                Reason::Near { modules, clearance_m }
            }
            _ if missing > 0 => Reason::Missing { modules: missing },
            _ if self.config.loss_tolerant.is_required() => Reason::NotTolerant,
            _ => Reason::NoWay,
        }
    }

    /// The pair of tails with the least clearance at these angles, and that, m.
    fn nearest(&self, tails: &[f64]) -> Option<([usize; 2], f64)> {
        let (tail, offsets) = (self.distance.tail(), self.distance.offsets());
        let clearance_m = |pair: &Pair| tail.clearance_m(offsets[pair.offset], tails[pair.i], tails[pair.j]);
        let known = self.pairs.all().iter().filter(|pair| !self.is_unknown(pair));
        known.map(|pair| ([pair.i, pair.j], clearance_m(pair))).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
