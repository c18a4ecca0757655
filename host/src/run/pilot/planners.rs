//! The planners of a run: of all modules, and of those that take part while some are missing.

use std::sync::Arc;

use modboat::distance::DistanceToCollision;
use modboat::distance_table::DistanceTable;
use modboat::parameters::Parameters;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::setting::Participation;
use modboat::structure::Structure;

use super::super::scenario::Scenario;

/// The planner that `config` names, for all modules.
pub(super) fn planner_of(
    structure: &Structure,
    modboat: &Parameters,
    config: &PlannerConfig,
    distance: &Arc<DistanceToCollision>,
    table: Option<Arc<DistanceTable>>,
) -> Planner {
    let planner = Planner::with_distance(structure, modboat, config, Arc::clone(distance));
    match table {
        Some(table) => planner.with_table(table),
        None => planner,
    }
}

/// The planner for the modules that take part; made again when they change. `None` where no module takes part.
pub(super) fn planner_for<'a>(
    whole: &'a mut Planner,
    partial: &'a mut Option<(Vec<Participation>, Planner)>,
    scenario: &Scenario,
    distance: &Arc<DistanceToCollision>,
    participation: &[Participation],
) -> Option<&'a mut Planner> {
    if participation.iter().all(|module| *module == Participation::Active) {
        return Some(whole);
    }
    if partial.as_ref().is_none_or(|(known, _)| known != participation) {
        let Scenario { structure, modboat, planner, .. } = scenario;
        let among =
            Planner::among(structure, modboat, planner, Arc::clone(distance), participation.to_vec())?;
        *partial = Some((participation.to_vec(), among));
    }
    partial.as_mut().map(|(_, planner)| planner)
}
