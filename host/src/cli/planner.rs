//! The planners that can be chosen by name.

use clap::ValueEnum;

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum PlannerKind {
    /// The potential field of Qiao, Knizhnik and Yim
    PotentialField,
}

impl PlannerKind {
    /// Its name in a reply.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::PotentialField => "potential-field",
        }
    }
}
