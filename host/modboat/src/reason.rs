//! Why nothing moves: what kept a planner from any plan.

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
