//! A figure of a campaign: means with their intervals over a parameter, or every run over what was sampled.

use std::path::{Path, PathBuf};

use super::axis::{Axis, extent};
use super::picture::{self, Area, Chart, DrawError, Heading, Key};
use super::style::{self, module_colour as colour};
use super::{PlotError, write_named};

/// Width of the picture and height of a row of panels, px.
const WIDTH: f64 = 1100.0;
const ROW: f64 = 350.0;
/// Series beyond this many have no entry in the legend.
const NAMED: usize = 7;

/// A value and the interval around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where.
    pub x: f64,
    /// The value.
    pub y: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Points of one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// In the legend; empty for none.
    pub name: String,
    /// The points.
    pub points: Vec<Point>,
    /// Whether a line joins them.
    pub is_line: bool,
}

/// Series over one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The parameter.
    pub x_title: String,
    /// What is drawn.
    pub series: Vec<Series>,
}

/// Draws `figure` of `campaign`, a panel for each parameter.
pub fn svg(campaign: &str, figure: &str, panels: &[Panel]) -> Result<String, DrawError> {
    let is_mean = panels
        .iter()
        .flat_map(|panel| &panel.series)
        .flat_map(|series| &series.points)
        .any(|p| p.low < p.high);
    let line = if is_mean { "means and shares with 95 % intervals" } else { "every run" }.to_owned();
    let heading = Heading { name: campaign, subject: figure, line };
    let columns = if panels.len() > 1 { 2 } else { 1 };
    let rows = panels.len().div_ceil(columns).max(1);
    picture::render((WIDTH, picture::height_for(ROW * rows as f64)), &heading, |area| {
        for (area, panel) in area.split_evenly((rows, columns)).iter().zip(panels) {
            draw(area, figure, panel)?;
        }
        Ok(())
    })
}

/// Writes pictures by their names into an existing directory; what became of each, in order.
pub fn write(
    pictures: impl IntoIterator<Item = (String, Result<String, DrawError>)>,
    directory: &Path,
) -> Vec<Result<PathBuf, PlotError>> {
    pictures.into_iter().map(|(name, picture)| write_named(&name, picture, directory)).collect()
}

fn draw(area: &Area<'_>, figure: &str, panel: &Panel) -> Result<(), DrawError> {
    let is_finite =
        |point: &&Point| [point.x, point.y, point.low, point.high].iter().all(|value| value.is_finite());
    let points = || panel.series.iter().flat_map(|series| &series.points).filter(is_finite);
    let (left, right) = extent(points().map(|point| point.x)).unwrap_or((0.0, 1.0));
    let (low, high) = extent(points().flat_map(|point| [point.low, point.high])).unwrap_or((0.0, 1.0));
    let named = panel.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()).take(NAMED);
    let legend: Vec<(Key, &str)> =
        named.map(|(index, series)| (Key::Dot(colour(index)), series.name.as_str())).collect();
    let frame = picture::Panel::new(figure, Axis::padded(left, right, 8), Axis::padded(low, high, 7));
    let frame =
        picture::Panel { legend: &legend, legend_below: true, x_title: Some(&panel.x_title), ..frame };
    let chart = Chart::new(area, &frame)?;
    for (index, series) in panel.series.iter().enumerate() {
        let colour = colour(index);
        for point in series.points.iter().filter(is_finite).filter(|point| point.low < point.high) {
            chart.line(vec![(point.x, point.low), (point.x, point.high)], style::line(colour, 0.6, 1.5))?;
        }
        let line: Vec<(f64, f64)> =
            series.points.iter().filter(is_finite).map(|point| (point.x, point.y)).collect();
        for &at in &line {
            chart.dot(at, 3.0, colour)?;
        }
        if series.is_line {
            chart.line(line, style::line(colour, 1.0, 2.0))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_drawn_and_what_is_no_number_is_not() {
        let point = |x: f64, y: f64| Point { x, y, low: y - 0.5, high: y + 0.5 };
        let series = |name: &str, is_line| Series {
            name: name.to_owned(),
            points: vec![point(0.0, 1.0), point(0.5, 2.0), point(1.0, f64::NAN)],
            is_line,
        };
        let panel = Panel {
            x_title: "radio.loss".to_owned(),
            series: vec![series("one", true), series("another", false)],
        };
        let empty = Panel { x_title: "tank.gust_m_s".to_owned(), series: Vec::new() };
        let drawn = svg("c", "passed", &[panel, empty]).expect("drawn");
        for word in ["one", "another", "radio.loss", "tank.gust_m_s", "passed"] {
            assert!(drawn.contains(word), "no {word}");
        }
        assert!(!drawn.contains("NaN") && !drawn.contains("inf"));
        // A dot and its rim for each of four points, and one for each name in the legend.
        assert_eq!(drawn.matches("<circle").count(), 2 * 4 + 2);
        assert!(svg("c", "nothing", &[]).is_ok());
    }
}
