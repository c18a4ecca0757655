//! What the panels show of movers: velocities, forces and moments, pulses. A quantity that is small everywhere has no row.

use record::reconfigure::{Record, Sample};

use super::executed_move;
use super::panels::{self, Row, Table};
use super::stroke::Sign;
use crate::axis::extent;
use crate::picture::DrawError;
use crate::style;

/// A velocity below this everywhere is not worth a row, m/s.
const UNSEEN_M_S: f64 = 0.03;
/// The same of a force, N.
const UNSEEN_N: f64 = 0.3;
/// The same of a moment, N·m.
const UNSEEN_NM: f64 = 0.02;
/// Pulses at which a T200 gives no thrust at 16 V, µs (Blue Robotics, September 2019).
const DEAD_US: (f64, f64) = (1472.0, 1528.0);

/// `velocity.svg`: surge velocity u and yaw rate r of every mover, after the paper's Fig. 4; sway v and heave w where
/// a robot uses them.
pub fn velocity(records: &[Record]) -> Result<String, DrawError> {
    let row = |title, axis: usize| Row {
        holds: (-0.01, 0.01),
        ticks: 6,
        ..Row::new(title, move |sample, robot| sample.robots.get(robot)?.nu.get(axis).copied())
    };
    let mut rows = vec![row("Surge velocity u, m/s", 0)];
    for (title, axis) in [("Sway velocity v, m/s", 1), ("Heave velocity w, m/s", 2)] {
        if greatest(records, |s, robot| s.robots.get(robot).map_or(0.0, |r| r.nu[axis])) > UNSEEN_M_S {
            rows.push(row(title, axis));
        }
    }
    rows.push(row("Yaw rate r, rad/s", 5));
    let table = Table { subject: "velocity of the movers", rows, chart_height: 170.0, legend: Vec::new() };
    panels::svg(records, &table)
}

/// `force.svg`: what the movers' thrusters exert, and the restoring moment M that the waiting cluster has to balance
/// meanwhile (5), after the paper's Fig. 5. Sway force Y, heave force Z and the cluster's K where there is any.
pub fn force(records: &[Record]) -> Result<String, DrawError> {
    let thrust = |title, axis: usize| {
        Row::new(title, move |sample, robot| sample.robots.get(robot)?.tau.get(axis).copied())
    };
    let restoring = |title, axis: usize| Row::new(title, move |s, _| s.restoring_nm.get(axis).copied());
    let mut rows = vec![thrust("Surge force X of the mover, N", 0)];
    for (title, axis) in [("Sway force Y of the mover, N", 1), ("Heave force Z of the mover, N", 2)] {
        if greatest(records, |s, robot| s.robots.get(robot).map_or(0.0, |r| r.tau[axis])) > UNSEEN_N {
            rows.push(thrust(title, axis));
        }
    }
    rows.push(thrust("Yaw moment N of the mover, N·m", 5));
    if greatest(records, |s, _| s.restoring_nm[0]) > UNSEEN_NM {
        rows.push(restoring("Restoring moment K, cluster, N·m", 0));
    }
    rows.push(restoring("Restoring moment M, cluster, N·m", 1));
    let table = Table { subject: "forces and moments", rows, chart_height: 150.0, legend: Vec::new() };
    panels::svg(records, &table)
}

/// `pwm.svg`: the pulses that each thruster of each mover was sent, after the paper's Fig. 7c, with the band shaded in
/// which a T200 does not turn.
pub fn pwm(records: &[Record]) -> Result<String, DrawError> {
    let thrusters = |r: &Record| r.problem.vehicles.iter().map(|v| v.thrusters.len()).max();
    let count = records.iter().filter_map(thrusters).max().unwrap_or(0);
    let row = |thruster: usize| Row {
        holds: (DEAD_US.0 - 8.0, DEAD_US.1 + 8.0),
        shaded: Some(DEAD_US),
        is_stepped: true,
        ticks: 4,
        ..Row::new(&format!("Thruster {}, µs", thruster + 1), move |sample, robot| {
            sample.robots.get(robot)?.pulses_us.get(thruster).copied()
        })
    };
    let legend = vec![(Sign::Box(style::DEMAND, 0.13, None), "no thrust, 1472–1528 µs".to_owned())];
    let rows = (0..count).map(row).collect();
    panels::svg(records, &Table { subject: "pulse widths of the movers", rows, chart_height: 84.0, legend })
}

/// The greatest magnitude of a quantity of any mover.
fn greatest(records: &[Record], value: impl Fn(&Sample, usize) -> f64) -> f64 {
    let value = &value;
    let moves = records.iter().flat_map(executed_move::executed_moves);
    let values = moves.flat_map(|c| c.samples.iter().map(move |s| value(s, c.robot).abs()));
    extent(values).map_or(0.0, |(_, high)| high)
}
