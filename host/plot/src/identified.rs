//! `foretold.svg` and `residuals.svg`: how well identified constants fit.
//!
//! The first shows velocities over a short span, as measured in data that were held back and as predicted from tail angles or thrusts
//! alone: a panel a component, a line a prediction. The second shows what is left of each pose once it is predicted from the one before.

use std::path::{Path, PathBuf};

use super::PlotError;
use super::axis::{Axis, extent};
use super::lines::{self, Point};
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style;

/// Size of a picture, px.
const SIZE: (f64, f64) = (1200.0, 800.0);

/// Velocities over a short span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocities<const N: usize> {
    /// Middle of the span, s.
    pub t_s: f64,
    /// As measured, m/s; the last one is yaw, rad/s.
    pub measured: [f64; N],
    /// As predicted.
    pub predicted: [f64; N],
    /// Which prediction it is of.
    pub start: usize,
}

/// What there is to show.
#[derive(Clone, Copy, Debug)]
pub struct Identified<'a, const N: usize> {
    /// What was identified.
    pub name: &'a str,
    /// How well, in a line.
    pub line: &'a str,
    /// What velocities are predicted from.
    pub from: &'a str,
    /// What the components of a velocity are, with thousandths of their units.
    pub velocity_titles: [&'a str; N],
    /// Predictions in the order of their starts.
    pub velocities: &'a [Velocities<N>],
    /// What the coordinates of a pose are, with thousandths of their units.
    pub residual_titles: [&'a str; N],
    /// Times, s, and what is left of each coordinate, m; the last one is an angle, rad.
    pub residuals: &'a [(f64, [f64; N])],
}

/// Writes both pictures into an existing directory; what became of each.
pub fn write<const N: usize>(
    identified: &Identified<'_, N>,
    directory: &Path,
) -> Vec<Result<PathBuf, PlotError>> {
    let pictures = [("foretold.svg", foretold(identified)), ("residuals.svg", residuals(identified))];
    super::write(pictures, directory)
}

/// Measured and predicted velocities.
pub fn foretold<const N: usize>(identified: &Identified<'_, N>) -> Result<String, DrawError> {
    let &Identified { name, line, from, velocities, velocity_titles: titles, .. } = identified;
    let foretold = format!("foretold from {from}");
    let heading = Heading { name, subject: "velocity measured and foretold", line: line.to_owned() };
    picture::render(SIZE, &heading, |area| {
        for (component, panel) in picture::stacked(area, N).iter().enumerate() {
            let milli = |values: &[f64; N]| values.get(component).map_or(f64::NAN, |value| 1e3 * value);
            let both = velocities.iter().flat_map(|v| [milli(&v.measured), milli(&v.predicted)]);
            let legend = [
                (Key::Line(style::BLUE, 1.0, 2.0), "measured"),
                (Key::Line(style::VERMILION, 1.0, 1.5), foretold.as_str()),
            ];
            let times = velocities.iter().map(|v| v.t_s);
            let chart =
                frame(panel, titles.get(component).unwrap_or(&""), &legend, (component, N), times, both)?;
            for run in velocities.chunk_by(|a, b| a.start == b.start && a.t_s < b.t_s) {
                let curve = |of: fn(&Velocities<N>) -> &[f64; N]| -> Vec<Point> {
                    run.iter().map(|v| (v.t_s, milli(of(v)))).collect()
                };
                chart.line(curve(|v| &v.measured), style::line(style::BLUE, 1.0, 2.0))?;
                chart.line(curve(|v| &v.predicted), style::line(style::VERMILION, 0.8, 1.5))?;
            }
        }
        Ok(())
    })
}

/// What is left of the poses.
pub fn residuals<const N: usize>(identified: &Identified<'_, N>) -> Result<String, DrawError> {
    let &Identified { name, line, residuals, residual_titles: titles, .. } = identified;
    let heading = Heading { name, subject: "residuals", line: line.to_owned() };
    picture::render(SIZE, &heading, |area| {
        let columns = picture::chart_width(picture::area_size(area).0) as usize;
        for (component, panel) in picture::stacked(area, N).iter().enumerate() {
            let curve: Vec<Point> = residuals
                .iter()
                .map(|(t_s, values)| (*t_s, values.get(component).map_or(f64::NAN, |value| 1e3 * value)))
                .collect();
            let (times, values) = (curve.iter().map(|p| p.0), curve.iter().map(|p| p.1));
            let chart =
                frame(panel, titles.get(component).unwrap_or(&""), &[], (component, N), times, values)?;
            for run in curve.chunk_by(|a, b| a.0 < b.0) {
                chart.line(lines::thin_series(run, columns), style::line(style::BLUE, 0.9, 1.0))?;
            }
        }
        Ok(())
    })
}

/// A panel over time with a line at zero; the lowest one has its axis written out.
fn frame<'a, 'c>(
    area: &Area<'a>,
    title: &str,
    legend: &[(Key, &str)],
    (row, rows): (usize, usize),
    times: impl Iterator<Item = f64>,
    values: impl Iterator<Item = f64>,
) -> Result<Chart<'a, 'c>, DrawError> {
    let (low, high) = extent(values).unwrap_or((-1.0, 1.0));
    let (start_s, end_s) = extent(times).unwrap_or((0.0, 1.0));
    let (width, _) = picture::area_size(area);
    let x = Axis::time(start_s, end_s, (picture::chart_width(width) / 65.0) as usize);
    let panel = Panel::new(title, x, Axis::padded(low.min(0.0), high.max(0.0), 5));
    let x_title = (row + 1 == rows).then_some("Time, s");
    let legend = if row == 0 { legend } else { &[] };
    let chart = Chart::new(area, &Panel { legend, x_title, ..panel })?;
    chart.line(vec![(start_s, 0.0), (end_s, 0.0)], style::line(style::FRAME, 1.0, 1.0))?;
    Ok(chart)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_pictures_are_drawn_and_survive_having_nothing_to_show() {
        let at = |n: usize| Velocities {
            t_s: n as f64,
            measured: [0.01 * n as f64, 0.04, -0.1],
            predicted: [0.011 * n as f64, 0.05, -0.1],
            start: n / 5,
        };
        let velocities: Vec<Velocities<3>> = (0..10).map(at).collect();
        let residuals: Vec<(f64, [f64; 3])> = (0..50).map(|n| (f64::from(n), [1e-3, -1e-3, 2e-3])).collect();
        let full = Identified {
            name: "boat",
            line: "3 %",
            from: "tail angles",
            velocity_titles: ["Sway, mm/s", "Surge, mm/s", "Yaw rate, mrad/s"],
            velocities: &velocities,
            residual_titles: ["East, mm", "North, mm", "Heading, mrad"],
            residuals: &residuals,
        };
        let empty = Identified { velocities: &[], residuals: &[], ..full };
        for identified in [full, empty] {
            for svg in [foretold(&identified), super::residuals(&identified)].map(|svg| svg.expect("drawn")) {
                assert!(svg.contains("boat") && !svg.contains("NaN") && !svg.contains("inf"));
            }
        }
        // Two predictions in each of three panels.
        let curves = |identified: &Identified<'_, 3>| {
            let svg = foretold(identified).expect("drawn");
            svg.split("<polyline")
                .skip(1)
                .filter(|line| line.split("/>").next().is_some_and(|l| l.contains("#D55E00")))
                .count()
        };
        assert_eq!(curves(&full), curves(&empty) + 6);
    }
}
