//! What a run of Modboats is told as.

use modboat::motion::Wrench;
use protocol::time::FleetInstant;
use record::PoseSample;
use runlog::flotilla;

use super::super::super::pilot::{Asked, Decision, Targets};
use super::super::super::scenario::{Demand, Scenario};
use super::super::stamp;

/// What is told first of a run of Modboats.
#[must_use]
pub fn head(scenario: &Scenario, seed: u64, modules: Vec<u16>) -> flotilla::Scenario {
    super::super::head("modboats", &scenario.name, seed, modules, scenario.document())
}

pub(super) fn state(now: FleetInstant, pose: &PoseSample) -> flotilla::BoatState {
    flotilla::BoatState {
        stamp: stamp(now),
        position_m: pose.position_m,
        heading_rad: pose.heading_rad,
        velocity_m_s: pose.velocity_m_s,
        yaw_rate_rad_s: pose.yaw_rate_rad_s,
    }
}

/// What the fleet is steered by: what is `asked`, if anything is.
pub(super) fn goal(now: FleetInstant, asked: Option<&Asked>, targets: &Targets) -> flotilla::Goal {
    let (waypoints_x_m, waypoints_y_m) = targets.waypoints().map(|[x, y]| (*x, *y)).unzip();
    let source = if targets.is_given() { "console" } else { "leg" };
    let mut goal = flotilla::Goal {
        stamp: stamp(now),
        kind: "none".to_owned(),
        source: source.to_owned(),
        waypoints_x_m,
        waypoints_y_m,
        ..flotilla::Goal::default()
    };
    if let Some(&Asked { demand, heading_rad, .. }) = asked {
        goal.heading_rad = heading_rad;
        let kind = match demand {
            Demand::Velocity(velocity_m_s) => {
                goal.velocity_m_s = velocity_m_s.to_vec();
                "velocity"
            }
            Demand::Station(station_m) => {
                goal.station_m = station_m.to_vec();
                if goal.waypoints_x_m.is_empty() { "station" } else { "waypoints" }
            }
        };
        kind.clone_into(&mut goal.kind);
    }
    goal
}

pub(super) fn wrench(wrench: Wrench) -> flotilla::Wrench {
    let Wrench { fx_n, fy_n, tau_nm } = wrench;
    flotilla::Wrench { fx_n, fy_n, tau_nm }
}

pub(super) fn message(now: FleetInstant, index: usize, decision: &Decision) -> flotilla::Decision {
    let (plan, via) = (&decision.plan, decision.via.as_ref());
    flotilla::Decision {
        stamp: stamp(now),
        index: index as u32,
        number: decision.number,
        start_us: decision.start.0,
        transition_us: decision.transition.0,
        via_turning_us: via.map_or(0, |via| via.turning.0),
        via_rest_us: via.map_or(0, |via| via.rest.0),
        ramps_s: plan.step_times.map(|step| step.ramp_s),
        period_us: decision.period.0,
        outcome: plan.outcome.name().to_owned(),
        reason: plan.reason.map_or_else(String::new, |reason| reason.to_string()),
        demand: wrench(decision.demand),
        commanded: wrench(plan.wrench),
        error: plan.error,
        travel_rad: plan.travel_rad,
        clearance_m: plan.clearance_m,
        guarantee_m: plan.guarantee_m,
        outside_envelope: plan.outside_envelope,
        bounded: decision.bounded,
        loss_tolerant: plan.loss_tolerant,
        power_tolerant: plan.power_tolerant,
        solve_us: decision.solve_us,
        missing: decision.missing.clone(),
        from_rad: decision.turns.iter().map(|turn| turn.from_rad).collect(),
        via_rad: via.map_or_else(Vec::new, |via| via.rad.clone()),
        to_rad: decision.turns.iter().map(|turn| turn.to_rad).collect(),
        centerline_rad: plan.cycle.iter().map(|swing| swing.centerline_rad).collect(),
        amplitude_rad: plan.cycle.iter().map(|swing| swing.amplitude_rad).collect(),
    }
}
