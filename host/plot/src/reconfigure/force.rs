//! `force.svg`: what the movers' thrusters exert, and the restoring moment M that the waiting cluster has to balance
//! meanwhile (5), after the paper's Fig. 5. Sway force Y, heave force Z and the cluster's K where there is any.

use record::reconfigure::{Record, Sample};

use super::panels::{self, Row, Table};
use super::velocity::greatest;
use crate::picture::DrawError;

/// A force below this everywhere is not worth a row, N.
const UNSEEN_N: f64 = 0.3;
/// The same of a moment, N·m.
const UNSEEN_NM: f64 = 0.02;

/// Draws the picture.
///
/// # Errors
/// What plotters reports.
pub fn svg(records: &[Record]) -> Result<String, DrawError> {
    let thrust = |title: &str, axis: usize| Row {
        value: Box::new(move |sample: &Sample, robot| Some(*sample.robots.get(robot)?.tau.get(axis)?)),
        ..row(title)
    };
    let restoring = |title: &str, axis: usize| Row {
        value: Box::new(move |sample: &Sample, _| sample.restoring_nm.get(axis).copied()),
        ..row(title)
    };
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

fn row(title: &str) -> Row {
    Row {
        title: title.to_owned(),
        value: Box::new(|_, _| None),
        holds: (-0.05, 0.05),
        shaded: None,
        is_stepped: false,
        ticks: 5,
    }
}
