//! One run of a campaign: a scenario with its settings and a seed.

use host::run::scenario::Scenario;
use modboat::planner_kind::PlannerKind;

use super::axis::Set;
use super::base::Base;

/// See the module's documentation.
#[derive(Debug)]
pub struct Run<'s> {
    /// Its number in the campaign, from 0.
    pub number: usize,
    /// The name of what was set together, where the campaign has such.
    pub controller: Option<&'s str>,
    /// The keys that are varied, with their values.
    pub varied: Vec<Set<'s>>,
    pub(super) base: &'s Base,
    pub(super) planner: Option<PlannerKind>,
    pub(super) seed: Option<u64>,
    /// What the controller sets.
    pub(super) set: Vec<Set<'s>>,
}

impl Run<'_> {
    /// The scenario, and its seed.
    ///
    /// # Errors
    /// What the reader of scenarios says of a combination of values that cannot be.
    pub fn scenario(&self) -> Result<(Scenario, u64), String> {
        let mut scenario = self.base.with(&[self.set.as_slice(), &self.varied].concat())?;
        if let Some(kind) = self.planner {
            scenario.planner.kind = kind;
        }
        let seed = self.seed.unwrap_or(scenario.seed);
        Ok((scenario, seed))
    }

    /// The run in words: scenario, controller, planner, seed and what is varied.
    #[must_use]
    pub fn told(&self) -> String {
        let mut told = format!("run {}: {}", self.number, self.base.name());
        let planner = self.planner.map(|kind| kind.name());
        for part in self.controller.into_iter().chain(planner) {
            told = format!("{told}, {part}");
        }
        for (key, value) in &self.varied {
            told = format!("{told}, {key} = {value}");
        }
        self.seed.map_or(told.clone(), |seed| format!("{told}, seed {seed}"))
    }
}
