//! The exact planner: cycles that start where the last ended.

use crate::modboat::motion::{Swing, Wrench};
use crate::modboat::plan::Plan;
use crate::modboat::setting::Setting;

/// Plans for one structure.
#[derive(Clone, Debug)]
pub struct ExactPlanner {
    setting: Setting,
}

impl ExactPlanner {
    /// For one structure.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        Self { setting }
    }

    /// See [`Planner::plan`](crate::modboat::planner::Planner::plan).
    pub fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        self.setting.hold(demand, tails, previous)
    }
}
