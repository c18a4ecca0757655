//! `trajectories.svg` and `heading.svg`: runs of several planners on one scenario.
//!
//! On the map the path of every run of every planner, the first seed's strong and the others' pale, over the demanded
//! course of the first. Below each other, or rather in one panel, the heading errors of the first seed: as they are,
//! with the yaw of every stroke, and as means over one decision.

use quantity::wrap_rad;
use record::RunRecord;

use super::axis::{Axis, extent};
use super::lines::{self, Point};
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style;
use super::style::planner_colour as colour;
use super::trajectory::{courses, finite, leg_marks};

/// Size of the map, px.
const MAP: (f64, f64) = (900.0, 720.0);
/// Size of the picture of the heading errors, px.
const HEADING: (f64, f64) = (1100.0, 420.0);
/// Least space between what the map shows and its frame, px.
const AIR: f64 = 26.0;
/// Opacity of the paths of all seeds but the first.
const PALE: f64 = 0.3;

/// Runs of several planners on one scenario.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// Scenario name.
    pub scenario: &'a str,
    /// Name of each planner and its runs by seed, the same seeds for all.
    pub planners: &'a [(String, &'a [RunRecord])],
}

fn heading<'h>(compared: &Compared<'h>, subject: &'h str) -> Heading<'h> {
    let description = compared.planners.first().and_then(|(_, records)| records.first());
    let line = description.map_or_else(String::new, |record| record.description.clone());
    Heading { name: compared.scenario, subject, line }
}

/// Draws the paths on a map with equal axes.
pub fn trajectories(compared: &Compared<'_>) -> Result<String, DrawError> {
    picture::render(MAP, &heading(compared, "trajectories"), |area| map(area, compared))
}

fn map(area: &Area<'_>, compared: &Compared<'_>) -> Result<(), DrawError> {
    let records = || compared.planners.iter().flat_map(|(_, records)| *records);
    let first = records().next();
    let courses = first.map_or_else(Vec::new, |record| courses(record, &record.poses));
    let bounds = |axis: usize| {
        let been = records().flat_map(|record| &record.poses).map(|pose| pose.position_m[axis]);
        let meant = courses.iter().flatten().map(|at| if axis == 0 { at.0 } else { at.1 });
        extent(been.chain(meant)).unwrap_or((-1.0, 1.0))
    };
    let (panel, m_per_px) = Panel::map("Centre of mass", area, (bounds(0), bounds(1)), AIR);
    let mut legend = lines_of(compared);
    legend.push((Key::Dashed(style::DEMAND), "demand"));
    let chart = Chart::new(area, &Panel { legend: &legend, ..panel })?;
    for [from, to] in courses {
        chart.dashed(&[from, to], style::line(style::DEMAND, 1.0, 1.5))?;
    }
    for strong in [false, true] {
        for (planner, (_, records)) in compared.planners.iter().enumerate() {
            for (seed, record) in records.iter().enumerate().filter(|(seed, _)| (*seed == 0) == strong) {
                let (opacity, width_px) = if seed == 0 { (1.0, 2.0) } else { (PALE, 1.0) };
                let path: Vec<Point> =
                    finite(&record.poses).map(|p| (p.position_m[0], p.position_m[1])).collect();
                let path = lines::thin_path(&path, 0.6 * m_per_px);
                chart.line(path, style::line(colour(planner), opacity, width_px))?;
            }
        }
    }
    for &[x, y] in first.iter().flat_map(|record| &record.legs).filter_map(|leg| leg.station_m.as_ref()) {
        chart.ring((x, y), 7.0, style::DEMAND)?;
    }
    Ok(())
}

/// Draws the heading errors over time.
pub fn headings(compared: &Compared<'_>) -> Result<String, DrawError> {
    picture::render(HEADING, &heading(compared, "heading error"), |area| {
        let firsts: Vec<&RunRecord> =
            compared.planners.iter().filter_map(|(_, records)| records.first()).collect();
        let errors: Vec<Vec<Point>> = firsts.iter().map(|record| heading_errors(record)).collect();
        let all = || errors.iter().flatten();
        let (low, high) = extent(all().map(|p| p.1)).unwrap_or((-1.0, 1.0));
        let (start_s, end_s) = extent(all().map(|p| p.0)).unwrap_or((0.0, 1.0));
        let (width, _) = picture::area_size(area);
        let title = "Heading error, mrad, and its mean over a decision";
        let x = Axis::time(start_s, end_s, (picture::chart_width(width) / 65.0) as usize);
        let panel = Panel::new(title, x, Axis::padded(low.min(0.0), high.max(0.0), 7));
        let chart =
            Chart::new(area, &Panel { legend: &lines_of(compared), x_title: Some("Time, s"), ..panel })?;
        chart.line(vec![(start_s, 0.0), (end_s, 0.0)], style::line(style::FRAME, 1.0, 1.0))?;
        if let Some(record) = firsts.first() {
            leg_marks(&chart, record)?;
        }
        let columns = picture::chart_width(width) as usize;
        for (planner, errors) in errors.iter().enumerate() {
            chart.line(lines::thin_series(errors, columns), style::line(colour(planner), PALE, 1.0))?;
        }
        for (planner, (errors, record)) in errors.iter().zip(&firsts).enumerate() {
            let mean = lines::moving_mean(errors, record.mean_interval_s());
            chart.line(lines::thin_series(&mean, columns), style::line(colour(planner), 1.0, 2.0))?;
        }
        Ok(())
    })
}

fn lines_of<'a>(compared: &Compared<'a>) -> Vec<(Key, &'a str)> {
    let names = compared.planners.iter().map(|(name, _)| name.as_str());
    names.enumerate().map(|(planner, name)| (Key::Line(colour(planner), 1.0, 2.0), name)).collect()
}

/// Heading less that of the leg, wrapped, mrad over s.
fn heading_errors(record: &RunRecord) -> Vec<Point> {
    let demanded = |t_s: f64| {
        let leg = record.legs.iter().find(|leg| t_s < leg.end_s).or(record.legs.last());
        leg.map_or(0.0, |leg| leg.heading_rad)
    };
    finite(&record.poses).map(|p| (p.t_s, 1e3 * wrap_rad(p.heading_rad - demanded(p.t_s)))).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::sample;

    fn runs(shift_m: f64) -> Vec<RunRecord> {
        let mut record = sample::run(3, 1, 20.0, [[0.04, 0.0], [0.0, 0.04]]);
        record.poses.iter_mut().for_each(|pose| pose.position_m[0] += shift_m);
        vec![record.clone(), record]
    }

    #[test]
    fn both_pictures_name_every_planner_and_survive_runs_without_poses() {
        let (mut one, another) = (runs(0.0), runs(0.3));
        for _ in 0..2 {
            let planners = [("one".to_owned(), one.as_slice()), ("another".to_owned(), another.as_slice())];
            let compared = Compared { scenario: "holonomic-4", planners: &planners };
            for svg in [trajectories(&compared), headings(&compared)].map(|svg| svg.expect("drawn")) {
                assert!(svg.contains("one") && svg.contains("another"), "{svg}");
                assert!(!svg.contains("NaN") && !svg.contains("inf"));
            }
            one.iter_mut().for_each(|record| record.poses.clear());
        }
        let compared = Compared { scenario: "holonomic-4", planners: &[] };
        assert!(trajectories(&compared).is_ok() && headings(&compared).is_ok());
    }

    #[test]
    fn the_heading_error_is_against_the_running_leg_and_the_short_way() {
        let mut record = sample::run(3, 1, 20.0, [[0.04, 0.0], [0.0, 0.04]]);
        (record.legs[0].heading_rad, record.legs[1].heading_rad) = (PI, 0.0);
        record.poses.iter_mut().for_each(|pose| pose.heading_rad = -PI + 0.01);
        let errors = heading_errors(&record);
        let at = |t_s: f64| errors.iter().find(|p| p.0 >= t_s).expect("a pose").1;
        assert!((at(5.0) - 10.0).abs() < 1e-9, "{}", at(5.0));
        assert!((at(25.0) - 1e3 * (0.01 - PI)).abs() < 1e-9, "{}", at(25.0));
    }
}
