//! What the page draws that does not move: the structure, its water and its legs; ROVs, and their plan.

use reconfiguration::pose::Pose;
use runlog::flotilla;
use serde_json::{Value, json};

use crate::run::log::rovs::Document;
use crate::run::pilot::speed_max_m_s;
use crate::run::scenario::{Demand, Scenario};

/// The scene of a run, by the first message of its log.
pub(in crate::cli) fn stage(head: &flotilla::Scenario) -> Result<Value, String> {
    match head.fleet.as_str() {
        "modboats" => {
            let scenario = Scenario::parse("/scenario", &head.document).map_err(|error| error.to_string())?;
            Ok(boats(&scenario))
        }
        "rovs" => {
            let document: Document =
                serde_json::from_str(&head.document).map_err(|error| error.to_string())?;
            Ok(rovs(&document))
        }
        fleet => Err(format!("a fleet of {fleet:?}")),
    }
}

fn boats(scenario: &Scenario) -> Value {
    let Scenario { structure, modboat, bounds, .. } = scenario;
    let mut end_s = 0.0;
    let legs = scenario.legs.iter().map(|leg| {
        let start_s = end_s;
        end_s += leg.duration_s;
        let (velocity_m_s, station_m) = match leg.demand {
            Demand::Velocity(velocity_m_s) => (Some(velocity_m_s), None),
            Demand::Station(station_m) => (None, Some(station_m)),
        };
        json!({
            "start_s": start_s,
            "duration_s": leg.duration_s,
            "velocity_m_s": velocity_m_s,
            "station_m": station_m,
            "heading_rad": leg.heading_rad,
        })
    });
    let legs: Vec<Value> = legs.collect();
    let edge =
        bounds.as_ref().map(|bounds| json!({ "corners_m": bounds.edge_m, "margin_m": bounds.margin_m }));
    json!({
        "duration_s": scenario.duration_s(),
        "interactive": scenario.legs.is_empty(),
        "boats": {
            "pitch_m": modboat.pitch_m,
            "cells": structure.cells(),
            "centres_m": structure.positions_m(modboat.pitch_m),
            "tail_m": modboat.tail_length_m,
            "tail_width_m": modboat.tail_width_m,
            "speed_max_m_s": speed_max_m_s(modboat),
            "bounds": edge,
            "legs": legs,
        },
    })
}

fn rovs(Document { problem, plan, .. }: &Document) -> Value {
    let place = |pose: &Pose| <[f64; 4]>::from(*pose);
    // Forward and reverse.
    let most = rov::power::limits_n(problem.rules.battery_v)
        .ok()
        .map(|(reverse_n, forward_n)| [forward_n, -reverse_n]);
    let robots = problem.robots.iter().map(|robot| {
        let vehicle = problem.vehicles.get(robot.vehicle);
        json!({
            "id": robot.id,
            "box_m": vehicle.map(|vehicle| vehicle.box_m),
            "thrusters": vehicle.map(|vehicle| &vehicle.thrusters),
            "thrust_max_n": most,
        })
    });
    let tools = problem.tools.iter().map(|tool| {
        let vehicle = problem.vehicles.get(tool.vehicle);
        json!({ "box_m": vehicle.map(|vehicle| vehicle.box_m), "pose": place(&tool.pose) })
    });
    let moves = plan.moves.iter().map(|one| {
        json!({
            "robot": one.robot,
            "slot": one.slot,
            "start_s": one.start_s,
            "duration_s": one.duration_s,
            "path": one.path,
            "energy_j": one.energy_navigate_j + one.energy_balance_j,
            "navigate_j": one.energy_navigate_j,
            "balance_j": one.energy_balance_j,
        })
    });
    json!({
        "duration_s": plan.time_s,
        "interactive": false,
        "rovs": {
            "robots": robots.collect::<Vec<Value>>(),
            "tools": tools.collect::<Vec<Value>>(),
            "slots": plan.slots.iter().map(place).collect::<Vec<[f64; 4]>>(),
            "plan": {
                "criterion": plan.criterion,
                "time_s": plan.time_s,
                "energy_total_j": plan.energy_total_j,
                "moves": moves.collect::<Vec<Value>>(),
            },
        },
    })
}
