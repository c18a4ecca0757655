//! Configuration of the planners; a scenario's `[planner]` table overrides it.

use quantity::{ParameterError, check_within};
use serde::{Deserialize, Serialize};

use super::planner_kind::PlannerKind;

/// What the search takes distances to collision from. Plans are checked with the exact geometry either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DistanceSource {
    /// The collision regions themselves: exact, ready in 2 ms, and faster than the table from a dozen modules on.
    #[default]
    Direct,
    /// The paper's table of §II-A, see [`distance_table`](super::distance_table).
    Table,
}

/// Loss tolerance asked of plans: that modules may miss them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LossTolerance {
    /// Loss tolerant where it costs no accuracy; and then, also where it costs none, any module may stop anywhere in its motion.
    #[default]
    Prefer,
    /// Loss tolerant, whatever the wrench error.
    Require,
    /// The same, and any module may stop anywhere in its motion, as one does that loses its power, whatever the wrench error.
    Power,
    /// Nothing is asked.
    Off,
}

impl LossTolerance {
    /// Whether plans without it are refused.
    #[must_use]
    pub const fn is_required(self) -> bool {
        matches!(self, Self::Require | Self::Power)
    }
}

/// By which law of time tails turn in a transition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawOfTime {
    /// From rest to rest, within speed and acceleration of the tail. Plans keep the whole tube free (see [`tube`](super::tube)).
    #[default]
    RestToRest,
    /// The paper's: constant speed, in the same time whatever the turn. No motor follows its jumps of speed, so plans keep the
    /// margins below about planned angles, and nothing is guaranteed.
    ConstantSpeed,
}

/// Settings of Algorithm 1 and of what surrounds it. The paper gives the weights; the rest is *assumed*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlannerConfig {
    /// `"exact"` or `"potential-field"`.
    pub kind: PlannerKind,
    /// `"prefer"`, `"require"` or `"off"`; the potential field knows no preference.
    pub loss_tolerant: LossTolerance,
    /// `"direct"` or `"table"`.
    pub distance: DistanceSource,
    /// Epochs N of Algorithm 1 per start.
    pub epochs: u32,
    /// Iterations of the three stages in each epoch: N₁, N₂ − N₁, N₃ − N₂.
    pub stages: [u32; 3],
    /// Step Δd of (10) in the first epoch, rad.
    pub step_rad: f64,
    /// Step in the last epoch, rad; it shrinks geometrically from epoch to epoch (the paper's is fixed).
    pub last_step_rad: f64,
    /// `"rest-to-rest"` or `"constant-speed"`; if nothing is said, the latter with the potential field, as in the paper.
    pub transition_law: Option<LawOfTime>,
    /// Least distance to collision of every pair in a swim cycle of the potential field, rad. Covers the lag of the tail servo. With the default
    /// geometry 0.2 rad keep tails 16 mm apart and cost no accuracy.
    pub margin_rad: f64,
    /// The same in a transition at constant speed, rad. Here a margin costs choice: of 2000 pairs of random cycles for 5 × 5 modules 96.2 %
    /// have a transition with 0.2 rad, 99.1 % with 0.1 rad, 99.5 % with 0.05 rad, 99.9 % with none. With the default
    /// geometry 0.05 rad keep tails 4 mm apart, and 25 modules in the tank do not touch.
    pub transition_margin_rad: f64,
    /// Least distance to collision of two neighbours that swim a cycle of the exact planner together, rad. The tube about planned
    /// angles wants 0.06 of it; the rest costs no accuracy. Tails that swim
    /// in step lag in step, along the very segment that is kept clear, so that less is needed than by a search that may
    /// turn any tail in between. Free rest poses leave 0.12 rad to have.
    pub swim_margin_rad: f64,
    /// Relative wrench error that a transition as long as the period is worth: with 0 the demand is met whatever the tails
    /// have to travel, with more a little error is taken for a cycle that starts where the last ended.
    pub travel_weight: f64,
    /// Weights w of (4) for Fx, Fy and τ: 1, 1, 1/m.
    pub weights: [f64; 3],
    /// Seed of the random starts and of the order in which modules are updated.
    pub seed: u64,
    /// Starts tried at most: the previous cycle, aligned ones, then random ones.
    pub starts: u32,
    /// Distinct collision-free sets kept, best first, for the transition solver to choose from.
    pub candidates: usize,
    /// Relative weighted error below which sets count as equally good: the search may stop and the least
    /// tail travel decides.
    pub error_goal: f64,
}

impl Default for PlannerConfig {
    fn default() -> Self {
        Self {
            kind: PlannerKind::default(),
            loss_tolerant: LossTolerance::default(),
            distance: DistanceSource::Direct,
            epochs: 5,
            stages: [4, 10, 4],
            step_rad: 0.15,
            last_step_rad: 0.005,
            transition_law: None,
            margin_rad: 0.2,
            transition_margin_rad: 0.05,
            swim_margin_rad: 0.1,
            travel_weight: 1e-7,
            weights: [1.0, 1.0, 10.0],
            seed: 1,
            starts: 12,
            candidates: 4,
            error_goal: 0.01,
        }
    }
}

impl PlannerConfig {
    /// The law of time that transitions follow.
    #[must_use]
    pub fn law(&self) -> LawOfTime {
        self.transition_law.unwrap_or(match self.kind {
            PlannerKind::Exact => LawOfTime::RestToRest,
            PlannerKind::PotentialField => LawOfTime::ConstantSpeed,
        })
    }

    /// Refuses what the planner cannot work with, by the first offending key.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (step, margin) = (self.step_rad, self.margin_rad);
        let count = "must be from 1 to 10000";
        let half = "must be from 0 to 0.5";
        let stage = |stage| ("stages", f64::from(stage), "", 0.0..=1e4, "must each be at most 10000");
        let weight = |weight| ("weights", weight, "", 1e-6..=1e6, "must each be from 1e-6 to 1e6");
        check_within(&[("epochs", f64::from(self.epochs), "", 1.0..=1e4, count)])?;
        check_within(&self.stages.map(stage))?;
        check_within(&[
            ("step_rad", step, "rad", 1e-6..=1.0, "must be from 1e-6 to 1"),
            ("last_step_rad", self.last_step_rad, "rad", 1e-6..=step, "must be from 1e-6 to step_rad"),
            ("margin_rad", margin, "rad", 0.0..=0.5, half),
            (
                "transition_margin_rad",
                self.transition_margin_rad,
                "rad",
                0.0..=margin,
                "must be from 0 to margin_rad",
            ),
            ("swim_margin_rad", self.swim_margin_rad, "rad", 0.0..=0.5, half),
            ("travel_weight", self.travel_weight, "", 0.0..=1e3, "must be from 0 to 1000"),
        ])?;
        check_within(&self.weights.map(weight))?;
        check_within(&[
            ("starts", f64::from(self.starts), "", 1.0..=1e4, count),
            ("candidates", self.candidates as f64, "", 1.0..=1e3, "must be from 1 to 1000"),
            ("error_goal", self.error_goal, "", 0.0..=1.0, "must be from 0 to 1"),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_pass_and_nonsense_is_named() {
        assert_eq!(PlannerConfig::default().validate(), Ok(()));
        let named = |config: PlannerConfig| config.validate().map_err(|e| e.key);
        assert_eq!(named(PlannerConfig { margin_rad: f64::NAN, ..Default::default() }), Err("margin_rad"));
        assert_eq!(named(PlannerConfig { step_rad: 0.001, ..Default::default() }), Err("last_step_rad"));
        assert_eq!(named(PlannerConfig { starts: 0, ..Default::default() }), Err("starts"));
    }
}
