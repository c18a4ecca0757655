//! What is known to work: the paper's controller, and a planner that finds cycles for the wrench it demands.
//!
//! The controller sees what an observation shows: the mean velocity and the mean yaw rate since the last decision, and the pose now. In
//! `flotilla run` it has an observer between 120 fixes a second and itself, and by default another controller that learns; figures of a
//! run and of a baseline are not the same.

use std::sync::Arc;

use host::run::scenario::{Demand, Scenario};
use modboat::control::paper::Controller;
use modboat::control::{Observation, Target};
use modboat::distance::DistanceToCollision;
use modboat::motion::{Swing, Wrench};
use modboat::plan::{Plan, Previous};
use modboat::planner::Planner;
use modboat::planner_config::{LawOfTime, PlannerConfig};
use modboat::planner_kind::PlannerKind;
use record::PoseSample;

use crate::command::Command;
use crate::goal::{Asked, mean_velocity_m_s, mean_yaw_rate_rad_s};

/// From a wrench to a command.
pub struct Allocator {
    planner: Planner,
    plan: Plan,
}

impl Allocator {
    /// By the planner of this kind, with the scenario's settings; turns go from rest to rest in either.
    ///
    /// `distance` has the collision regions of the scenario's modules, which all that is alike shares.
    #[must_use]
    pub fn new(scenario: &Scenario, kind: PlannerKind, distance: Arc<DistanceToCollision>) -> Self {
        let config =
            PlannerConfig { kind, transition_law: Some(LawOfTime::RestToRest), ..scenario.planner.clone() };
        let planner = Planner::with_distance(&scenario.structure, &scenario.modboat, &config, distance);
        Self { planner, plan: Plan::default() }
    }

    /// Writes the cycle for `demand` into `command`: from tails at rest at `tails_rad`, after the cycle `before`.
    pub fn allocate(
        &mut self,
        demand: Wrench,
        tails_rad: &[f64],
        before: &[Swing],
        scenario: &Scenario,
        command: &mut Command,
    ) {
        let previous = (before.len() == tails_rad.len()).then(|| Previous::cycle(before));
        self.planner.plan_into(demand, Some(tails_rad), previous, &mut self.plan);
        command.take_plan(&self.plan, tails_rad, &scenario.modboat);
    }
}

/// See the module's documentation.
pub struct Baseline {
    /// Which planner it has.
    pub kind: PlannerKind,
    control: Controller,
    /// Finds the command for a wrench.
    pub allocator: Allocator,
}

impl Baseline {
    /// At the start of an episode.
    #[must_use]
    pub fn new(scenario: &Scenario, kind: PlannerKind, distance: Arc<DistanceToCollision>) -> Self {
        Self { kind, control: control(scenario), allocator: Allocator::new(scenario, kind, distance) }
    }

    /// Another episode begins.
    pub fn forget(&mut self, scenario: &Scenario) {
        self.control = control(scenario);
    }

    /// The wrench for what is `asked`, as the structure came from the pose `before` to `now`; `last` is the command that runs.
    pub fn demand(
        &mut self,
        asked: &Asked,
        (before, now): (&PoseSample, &PoseSample),
        last: &Command,
        scenario: &Scenario,
    ) -> Wrench {
        let observed = Observation {
            velocity_m_s: mean_velocity_m_s(before, now),
            heading_rad: now.heading_rad,
            yaw_rate_rad_s: mean_yaw_rate_rad_s(before, now),
            ..Observation::default()
        };
        // Of the cycle that is decided on only the last one's length is known.
        let period_s = scenario.modboat.period_s;
        let interval_s = f64::from(last.length().as_secs_f32()).max(period_s);
        let horizon_s = scenario.timing.lead_s + interval_s;
        let velocity_m_s = match asked.demand {
            Demand::Velocity(velocity_m_s) => velocity_m_s,
            Demand::Station(station_m) => {
                scenario.control.towards(station_m, now.position_m, &observed, horizon_s)
            }
        };
        let target = Target { velocity_m_s, heading_rad: asked.heading_rad };
        self.control.demand(&target, &observed, interval_s, horizon_s)
    }
}

fn control(scenario: &Scenario) -> Controller {
    Controller::new(&scenario.structure, &scenario.modboat, &scenario.control)
}
