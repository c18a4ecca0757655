//! The planners, and what they are told, by name.

use clap::ValueEnum;
use modboat::planner_config::{LossTolerance, PlannerConfig};
use modboat::planner_kind::PlannerKind;

/// Options of every command that plans.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct PlannerArguments {
    /// Which planner, instead of the scenario's [default: exact]
    #[arg(long, value_enum)]
    planner: Option<Kind>,
    /// Whether any modules may miss a plan without a collision, instead of the scenario's [default: prefer]
    #[arg(long, value_enum, value_name = "HOW")]
    loss_tolerant: Option<Tolerance>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Kind {
    /// Cycles that start where the last ended; exact transitions
    Exact,
    /// The potential field of Qiao, Knizhnik and Yim
    PotentialField,
}

impl From<Kind> for PlannerKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Exact => Self::Exact,
            Kind::PotentialField => Self::PotentialField,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Tolerance {
    /// Where it costs no accuracy
    Prefer,
    /// Whatever the wrench error
    Require,
    /// The same, and any module may lose its power at any time
    Power,
    /// Nothing is asked
    Off,
}

impl PlannerArguments {
    /// Puts what was given into a scenario's settings.
    pub(super) fn apply(&self, config: &mut PlannerConfig) {
        if let Some(kind) = self.planner {
            config.kind = kind.into();
        }
        if let Some(how) = self.loss_tolerant {
            config.loss_tolerant = match how {
                Tolerance::Prefer => LossTolerance::Prefer,
                Tolerance::Require => LossTolerance::Require,
                Tolerance::Power => LossTolerance::Power,
                Tolerance::Off => LossTolerance::Off,
            };
        }
    }
}
