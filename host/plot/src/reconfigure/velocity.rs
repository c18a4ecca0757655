//! `velocity.svg`: surge velocity u and yaw rate r of every mover, after the paper's Fig. 4; sway v and heave w where
//! somebody uses them.

use record::reconfigure::{Record, Sample};

use super::course;
use super::panels::{self, Row, Table};
use crate::axis::extent;
use crate::picture::DrawError;

/// A velocity below this everywhere is not worth a row, m/s.
const UNSEEN_M_S: f64 = 0.03;

/// Draws the picture.
///
/// # Errors
/// What plotters reports.
pub fn svg(records: &[Record]) -> Result<String, DrawError> {
    let row = |title: &str, axis: usize| Row {
        title: title.to_owned(),
        value: Box::new(move |sample: &Sample, robot| Some(*sample.robots.get(robot)?.nu.get(axis)?)),
        holds: (-0.01, 0.01),
        shaded: None,
        is_stepped: false,
        ticks: 6,
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

/// The greatest magnitude of a quantity of any mover.
#[must_use]
pub fn greatest(records: &[Record], value: impl Fn(&Sample, usize) -> f64) -> f64 {
    let value = &value;
    let courses = records.iter().flat_map(course::courses);
    let values = courses.flat_map(|c| c.samples.iter().map(move |s| value(s, c.robot).abs()));
    extent(values).map_or(0.0, |(_, high)| high)
}
