//! The planners by name.

use serde::{Deserialize, Serialize};

/// Which planner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlannerKind {
    /// Exact allocation between free rest poses, exact transitions; see [`exact`](super::exact).
    #[default]
    Exact,
    /// The potential field of Qiao, Knizhnik and Yim; see [`potential_field`](super::potential_field).
    PotentialField,
}

impl PlannerKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Exact, Self::PotentialField];

    /// `exact` or `potential-field`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::PotentialField => "potential-field",
        }
    }
}
