//! From the host's types to the checker's numbers, so that the checker need not know the host.

use host::modboat::motion::{Swing, Turn};
use host::modboat::plan::Plan;
use host::run::record::{CycleRecord, RunRecord};

use crate::checker::{Answer, Request};

/// (φ₀, A) by module.
#[must_use]
pub fn swings(cycle: &[Swing]) -> Vec<[f64; 2]> {
    cycle.iter().map(|swing| [swing.centerline_rad, swing.amplitude_rad]).collect()
}

fn turns(transition: &[Turn]) -> Vec<[f64; 2]> {
    transition.iter().map(|turn| [turn.from_rad, turn.to_rad]).collect()
}

/// What a planner answered.
#[must_use]
pub fn of_plan(plan: &Plan) -> Answer {
    Answer {
        outcome: plan.outcome.name().to_owned(),
        cycle: swings(&plan.cycle),
        transition: plan.transition.as_deref().map(turns),
        via_rad: plan.via_rad.clone(),
        turning_s: plan.transition.is_some().then_some(plan.transition_s),
        wrench: plan.wrench.to_array(),
        error: plan.error,
        travel_rad: plan.travel_rad,
        clearance_m: plan.clearance_m.is_finite().then_some(plan.clearance_m),
        loss_tolerant: plan.loss_tolerant,
    }
}

/// What a run asked its planner and was answered.
#[must_use]
pub fn of_cycle(record: &RunRecord, cycle: &CycleRecord) -> (Request, Answer) {
    let request = Request {
        cells: record.cells.clone(),
        demand: cycle.demand.to_array(),
        tail_rad: Some(cycle.turns.iter().map(|turn| turn.from_rad).collect()),
        previous: None,
    };
    let answer = Answer {
        outcome: cycle.outcome.to_owned(),
        cycle: swings(&cycle.swings),
        transition: (cycle.transition_s > 0.0).then(|| turns(&cycle.turns)),
        via_rad: cycle.via.as_ref().map(|via| via.via_rad.clone()),
        turning_s: (cycle.transition_s > 0.0)
            .then(|| cycle.transition_s - cycle.via.as_ref().map_or(0.0, |via| via.rest_s)),
        wrench: cycle.commanded.to_array(),
        error: cycle.error,
        travel_rad: cycle.travel_rad,
        clearance_m: cycle.clearance_m.is_finite().then_some(cycle.clearance_m),
        loss_tolerant: cycle.loss_tolerant,
    };
    (request, answer)
}
