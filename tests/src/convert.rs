//! From the host's types to the checker's numbers, so that the checker need not know the host.

use host::run::pilot::Decision;
use modboat::motion::{Swing, Turn};
use modboat::parameters::Parameters;
use modboat::plan::Plan;
use record::{CycleRecord, RunRecord};

use crate::checker::{Answer, Modboat, Request};
use crate::execution::{Course, Step};

/// The checker's module with the numbers of a scenario's.
#[must_use]
pub fn of_parameters(parameters: &Parameters) -> Modboat {
    Modboat {
        pitch_m: parameters.pitch_m,
        tail_length_m: parameters.tail_length_m,
        tail_width_m: parameters.tail_width_m,
        ..Modboat::default()
    }
}

/// What modules are to do by a decision.
#[must_use]
pub fn of_decision(decision: &Decision) -> Course {
    let seconds = |us: u32| f64::from(us) * 1e-6;
    let to_rad: Vec<f64> = decision.turns.iter().map(|turn| turn.to_rad).collect();
    let ramps_s = decision.plan.step_times.map(|step| step.ramp_s);
    let all_s = seconds(decision.transition.0);
    let steps = match &decision.via {
        None => vec![Step { to_rad, turning_s: all_s, ramp_s: ramps_s[0], rest_s: 0.0 }],
        Some(via) => {
            let (turning_s, rest_s) = (seconds(via.turning.0), seconds(via.rest.0));
            vec![
                Step { to_rad: via.rad.clone(), turning_s, ramp_s: ramps_s[0], rest_s },
                Step { to_rad, turning_s: all_s - turning_s - rest_s, ramp_s: ramps_s[1], rest_s: 0.0 },
            ]
        }
    };
    Course {
        number: decision.number,
        start_s: decision.start.as_secs_f64(),
        from_rad: decision.turns.iter().map(|turn| turn.from_rad).collect(),
        steps,
        swings: swings(&decision.plan.cycle),
        period_s: seconds(decision.period.0),
        guarantee_m: decision.plan.guarantee_m,
        power_tolerant: decision.plan.power_tolerant,
    }
}

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
