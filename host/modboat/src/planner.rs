//! The planner chosen by the configuration: from a demanded wrench and the tails' present angles to one [`Plan`].

use std::sync::Arc;

use super::distance::DistanceToCollision;
use super::distance_table::DistanceTable;
use super::exact::ExactPlanner;
use super::motion::{Swing, Wrench};
use super::parameters::Parameters;
use super::plan::{Plan, Previous};
use super::planner_config::PlannerConfig;
use super::planner_kind::PlannerKind;
use super::potential_field::planner::FieldPlanner;
use super::setting::{Participation, Reach, Setting};
use super::structure::Structure;

/// A planner of one structure, exact or potential field.
#[derive(Clone, Debug)]
pub struct Planner {
    modules: usize,
    which: Which,
}

#[derive(Clone, Debug)]
enum Which {
    Exact(Box<ExactPlanner>),
    PotentialField(Box<FieldPlanner>),
}

impl Planner {
    /// The planner that `config` names, with the collision regions of these very `parameters`. The potential field searches by
    /// them until it is given a table.
    #[must_use]
    pub fn with_distance(
        structure: &Structure,
        parameters: &Parameters,
        config: &PlannerConfig,
        distance: Arc<DistanceToCollision>,
    ) -> Self {
        let setting = Setting::new(structure, parameters, config, distance);
        let which = match config.kind {
            PlannerKind::Exact => Which::Exact(Box::new(ExactPlanner::new(setting))),
            PlannerKind::PotentialField => Which::PotentialField(Box::new(FieldPlanner::new(setting))),
        };
        Self { modules: structure.len(), which }
    }

    /// An exact planner for a structure in which some modules are not active, whichever planner `config` names. `None` if no
    /// module is active.
    #[must_use]
    pub fn among(
        structure: &Structure,
        parameters: &Parameters,
        config: &PlannerConfig,
        distance: Arc<DistanceToCollision>,
        participation: Vec<Participation>,
    ) -> Option<Self> {
        if participation.len() != structure.len() || !participation.contains(&Participation::Active) {
            return None;
        }
        let setting = Setting::new(structure, parameters, config, distance).with_participation(participation);
        Some(Self { modules: structure.len(), which: Which::Exact(Box::new(ExactPlanner::new(setting))) })
    }

    /// Writes each module's participation when some tail angles are unknown: a module with a known angle is active, unless its tail
    /// rests within reach of an unknown one; then it is held. `poses_rad` are the tails' angles by module, rad, `None` if unknown.
    pub fn participation(
        structure: &Structure,
        distance: &DistanceToCollision,
        poses_rad: &[Option<f64>],
        participation: &mut Vec<Participation>,
    ) {
        let of = |pose: &Option<f64>| pose.map_or(Participation::Unknown, |_| Participation::Active);
        participation.clear();
        participation.extend(poses_rad.iter().map(of));
        // The rule, at every decision.
        if poses_rad.iter().all(Option::is_some) {
            return;
        }
        for &offset in distance.offsets() {
            let reach = Reach::new(distance, offset);
            for (i, j) in structure.neighbours(offset) {
                match (poses_rad.get(i).copied().flatten(), poses_rad.get(j).copied().flatten()) {
                    (Some(pose), None) if !reach.clears(0, pose) => {
                        participation[i] = Participation::Held(pose);
                    }
                    (None, Some(pose)) if !reach.clears(1, pose) => {
                        participation[j] = Participation::Held(pose);
                    }
                    _ => {}
                }
            }
        }
    }

    /// The same planner; a potential field searches by the table of these very parameters from now on.
    #[must_use]
    pub fn with_table(mut self, table: Arc<DistanceTable>) -> Self {
        if let Which::PotentialField(field) = self.which {
            self.which = Which::PotentialField(Box::new(field.with_table(table)));
        }
        self
    }

    /// Whether the demand has settled, from now on: then the exact planner gives a transition, where that costs no error, for cycles
    /// that any module may stop in, as one does that loses its power.
    pub fn settle(&mut self, settled: bool) {
        if let Which::Exact(exact) = &mut self.which {
            exact.settle(settled);
        }
    }

    /// Forgets at what earlier decisions aimed: the next one is as that of a planner that was just made.
    pub fn forget(&mut self) {
        if let Which::Exact(exact) = &mut self.which {
            exact.forget();
        }
    }

    /// Writes into `plan` a transition out of the neighbours' reach, and a rest there, from `tails` at rest (rad, may be unwrapped): one that
    /// any module may miss, and if possible stop in. It goes towards where a swim for `demand` would best begin. False, with `plan` as
    /// it was, where no tail rests in a neighbour's reach, nothing is asked of tolerance, or there is no such way.
    pub fn leave_into(&mut self, demand: Wrench, tails: &[f64], plan: &mut Plan) -> bool {
        match &mut self.which {
            Which::Exact(exact) if tails.len() == self.modules => exact.leave_into(demand, tails, plan),
            _ => false,
        }
    }

    /// The decision for `demand`. `tails` are the present angles (rad, may be unwrapped), `previous` the cycle before, that no turn
    /// came before. Either counts as unknown if its length is not the number of modules.
    ///
    /// With unknown angles there is no transition, and a cycle that is held is at the end of the previous one, or at
    /// zero.
    pub fn plan(&mut self, demand: Wrench, tails: Option<&[f64]>, previous: Option<&[Swing]>) -> Plan {
        let mut plan = Plan::default();
        self.plan_into(demand, tails, previous.map(Previous::cycle), &mut plan);
        plan
    }

    /// The same after any decision, written into `plan`: what that held before is used again. Once a planner is warm, and is given back what it gave,
    /// a decision allocates nothing.
    pub fn plan_into(
        &mut self,
        demand: Wrench,
        tails: Option<&[f64]>,
        previous: Option<Previous<'_>>,
        plan: &mut Plan,
    ) {
        let tails = tails.filter(|t| t.len() == self.modules);
        let previous = previous.filter(|p| p.is_of(self.modules));
        match &mut self.which {
            Which::Exact(exact) => exact.plan_into(demand, tails, previous, plan),
            Which::PotentialField(field) => field.plan_into(demand, tails, previous, plan),
        }
    }
}

#[cfg(test)]
mod tests;
