//! What others see of a pilot: logs, consoles, tests.

use modboat::observer::{Estimate, Fix};

use super::phase::Phase;
use super::{Asked, Decision, Pilot, SentCycle, Targets};

impl Pilot {
    /// How far the last decision has come.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// All decisions so far.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// How the structure moves, as observed.
    pub fn estimate(&self) -> Option<Estimate> {
        self.observer.estimate()
    }

    /// How often a module refused a cycle.
    pub fn refusals(&self) -> u32 {
        self.refusals
    }

    /// How often a cycle that no module may miss was given up because a module might have missed it.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// What is asked for `t_s` after time zero, if anything is.
    pub fn asked(&self, t_s: f64) -> Option<Asked> {
        self.targets.asked(&self.scenario, t_s)
    }

    /// What it is steered by.
    pub fn targets(&self) -> &Targets {
        &self.targets
    }

    /// What was sent lately: reports are about it.
    pub fn sent_lately(&self) -> Vec<SentCycle> {
        self.decisions.iter().rev().take(3).flat_map(Decision::sent_cycles).collect()
    }

    /// The newest pose.
    pub fn fix(&self) -> Option<&Fix> {
        self.fix.as_ref()
    }
}
