//! How modules are, as messages of ROS: diagnostics, and batteries.

use link::dispatcher::{Dispatcher, ModuleLink};
use protocol::ModuleState;
use protocol::time::{Duration, FleetInstant};
use runlog::ros::{BatteryState, Byte, DiagnosticArray, DiagnosticStatus, Header, KeyValue};

use super::super::stamp;

/// A module that was not heard for this time is stale: fifty of its reports. *Assumed.*
const SILENCE: Duration = Duration(1_000_000);
/// `POWER_SUPPLY_STATUS_UNKNOWN` and `_DISCHARGING`.
const POWER: [u8; 2] = [0, 2];

fn level<A: Copy>(now: FleetInstant, link: &ModuleLink<A>) -> (u8, &'static str) {
    match link.state() {
        _ if link.is_doubled() => (2, "two modules have its number"),
        None => (3, "not heard"),
        _ if now.since(link.heard()) > SILENCE => (3, "silent"),
        Some(ModuleState::Stopped) => (2, "stopped"),
        Some(ModuleState::Unprovisioned) => (2, "not provisioned"),
        Some(ModuleState::Unsynchronised) => (1, "does not know the fleet time"),
        Some(_) if link.faults().0 != 0 => (1, "faulty"),
        Some(ModuleState::Boot) => (1, "starting"),
        Some(ModuleState::Arming) => (0, "arming"),
        Some(ModuleState::Ready) => (0, "ready"),
        Some(ModuleState::Executing) => (0, "executing"),
        Some(ModuleState::Holding) => (0, "holding"),
    }
}

/// Of all modules.
pub fn diagnostics<A: Copy>(now: FleetInstant, ids: &[u16], links: &Dispatcher<A>) -> DiagnosticArray {
    let pair = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let status = links.modules().iter().zip(ids).map(|(link, id)| {
        let (level, message) = level(now, link);
        let faults: Vec<&str> = link.faults().names().collect();
        let mut values = vec![
            pair("faults", faults.join(", ")),
            pair("boots", link.boots().to_string()),
            pair("cycles acknowledged", link.ledger().acknowledged.to_string()),
        ];
        if let Some(health) = link.health() {
            values.push(pair("clock uncertainty, us", health.uncertainty.0.to_string()));
        }
        DiagnosticStatus {
            level: Byte(level),
            name: format!("module {id}"),
            message: message.to_owned(),
            hardware_id: link.id().0.to_string(),
            values,
        }
    });
    let status = status.collect();
    DiagnosticArray { header: Header { stamp: stamp(now), frame_id: String::new() }, status }
}

/// Of one module. What it does not measure is not a number, as ROS has it.
pub fn battery<A: Copy>(now: FleetInstant, id: u16, link: &ModuleLink<A>) -> BatteryState {
    let boat = link.telemetry().map(|report| (report.battery, report.current));
    let measured = boat.or(link.rov_telemetry().map(|report| (report.battery, report.current)));
    let nan = f32::NAN;
    BatteryState {
        header: Header { stamp: stamp(now), frame_id: format!("module_{id}") },
        voltage: measured.map_or(nan, |(voltage, _)| voltage.0),
        temperature: nan,
        // Discharging is negative.
        current: measured.map_or(nan, |(_, current)| -current.0),
        charge: nan,
        capacity: nan,
        design_capacity: nan,
        percentage: nan,
        power_supply_status: POWER[usize::from(measured.is_some())],
        present: measured.is_some(),
        location: format!("module {id}"),
        ..BatteryState::default()
    }
}
