//! Why a plan is held: what kept the planner from any motion.

/// Why a plan is [`held`](super::plan::Outcome::Held). Modules are counted from 0, in the order of the structure; a clearance is
/// that between the surfaces of two tails, m.
#[derive(Clone, Copy, Debug, thiserror::Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum Reason {
    #[error("the demand is not finite")]
    Demand,
    #[error("the tail angle of module {module} is not finite")]
    Tail { module: usize },
    #[error("tails of modules {} and {} touch at {:.1} mm", .modules[0], .modules[1], 1e3 * .clearance_m)]
    Touch { modules: [usize; 2], clearance_m: f64 },
    #[error("tails of modules {} and {} rest {:.1} mm apart: a module may be off by more", .modules[0], .modules[1], 1e3 * .clearance_m)]
    Near { modules: [usize; 2], clearance_m: f64 },
    #[error("{modules} modules take no part, and the others found no plan beside them")]
    Missing { modules: usize },
    #[error("no plan was found that any module may miss")]
    NotTolerant,
    #[error("no cycle was found that the tails can reach")]
    NoWay,
}
