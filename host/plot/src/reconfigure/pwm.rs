//! `pwm.svg`: the pulses that each thruster of each mover was sent, after the paper's Fig. 7c, with the band shaded in
//! which a T200 does not turn.

use record::reconfigure::{Record, Sample};

use super::panels::{self, Row, Table};
use super::stroke::Sign;
use crate::picture::DrawError;
use crate::style;

/// Pulses at which a T200 gives no thrust at 16 V, µs (Blue Robotics, September 2019).
const DEAD_US: (f64, f64) = (1472.0, 1528.0);

/// Draws the picture.
///
/// # Errors
/// What plotters reports.
pub fn svg(records: &[Record]) -> Result<String, DrawError> {
    let thrusters = |r: &Record| r.problem.vehicles.iter().map(|v| v.thrusters.len()).max();
    let count = records.iter().filter_map(thrusters).max().unwrap_or(0);
    let rows = (0..count)
        .map(|thruster| Row {
            title: format!("Thruster {}, µs", thruster + 1),
            value: Box::new(move |sample: &Sample, robot| {
                sample.robots.get(robot)?.pulses_us.get(thruster).copied()
            }),
            holds: (DEAD_US.0 - 8.0, DEAD_US.1 + 8.0),
            shaded: Some(DEAD_US),
            is_stepped: true,
            ticks: 4,
        })
        .collect();
    let legend = vec![(Sign::Box(style::DEMAND, 0.13, None), "no thrust, 1472–1528 µs".to_owned())];
    panels::svg(records, &Table { subject: "pulse widths of the movers", rows, chart_height: 84.0, legend })
}
