//! Figures of several planners, such as the time for a plan, against the number of modules; both axes logarithmic.
//!
//! A full line is the 99th percentile, a dashed one the median. Below 10⁻¹⁶ everything is drawn there.

use super::axis::Axis;
use super::lines::Point;
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style::{self, planner_colour as colour};

/// Width of the picture and height of a row of two panels, px.
const WIDTH: f64 = 1100.0;
const ROW: f64 = 350.0;
/// The least figure that is told from none.
const NONE: f64 = 1e-16;

/// One figure of one planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<'n> {
    /// The planner's name.
    pub name: &'n str,
    /// Number of modules, ascending, with median and 99th percentile.
    pub sizes: Vec<(usize, [f64; 2])>,
}

/// Draws one panel for each figure (title, planners), two in a row. `line` goes under the heading.
pub fn svg(line: &str, figures: &[(&str, Vec<Line<'_>>)]) -> Result<String, DrawError> {
    let heading = Heading { name: "Planners", subject: "time and error against size", line: line.to_owned() };
    let rows = figures.len().div_ceil(2).max(1);
    picture::render((WIDTH, picture::height_for(ROW * rows as f64)), &heading, |area| {
        for (area, (title, planners)) in area.split_evenly((rows, 2)).iter().zip(figures) {
            panel(area, title, planners)?;
        }
        Ok(())
    })
}

fn panel(area: &Area<'_>, title: &str, planners: &[Line<'_>]) -> Result<(), DrawError> {
    let sizes = || planners.iter().flat_map(|line| &line.sizes);
    let mut modules: Vec<usize> = sizes().map(|size| size.0).collect();
    modules.sort_unstable();
    modules.dedup();
    let modules: Vec<f64> = modules.into_iter().map(|count| count as f64).collect();
    let legend: Vec<(Key, &str)> = planners
        .iter()
        .enumerate()
        .map(|(index, line)| (Key::Line(colour(index), 1.0, 2.0), line.name))
        .chain([(Key::Dashed(style::DEMAND), "median"), (Key::Line(style::DEMAND, 1.0, 2.0), "99 %")])
        .collect();
    let y = Axis::logarithmic(&powers(sizes().flat_map(|size| size.1).map(|figure| figure.max(NONE))));
    let panel = Panel::new(title, Axis::logarithmic(&modules), y);
    let panel = Panel { legend: &legend, legend_below: true, x_title: Some("Modules"), ..panel };
    let chart = Chart::new(area, &panel)?;
    for (index, line) in planners.iter().enumerate() {
        let points = |which: usize| -> Vec<Point> {
            let point = |&(modules, figures): &(usize, [f64; 2])| {
                ((modules as f64).log10(), figures[which].max(NONE).log10())
            };
            line.sizes.iter().map(point).filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
        };
        let [median, p99] = [points(0), points(1)];
        chart.dashed(&median, style::line(colour(index), 1.0, 1.5))?;
        for &at in &p99 {
            chart.dot(at, 3.0, colour(index))?;
        }
        chart.line(p99, style::line(colour(index), 1.0, 2.0))?;
    }
    Ok(())
}

/// Powers of ten around all positive values: every one, or every second or third where there are many.
fn powers(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let exponents = values.filter(|v| *v > 0.0 && v.is_finite()).map(|v| v.log10());
    let (low, high) = super::axis::extent(exponents).unwrap_or((0.0, 1.0));
    let (low, high) = (low.floor() as i32, high.ceil() as i32);
    let step = 1 + (high - low) / 7;
    // From the top, so that 1 and 10⁻⁶ are likelier than 10⁻⁷.
    let count = (high - low + step - 1) / step;
    (0..=count).rev().map(|k| 10f64.powi(high - k * step)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_size_of_every_planner_is_drawn_and_nothing_else() {
        let line = |name, sizes: &[(usize, [f64; 2])]| Line { name, sizes: sizes.to_vec() };
        let figures = [
            (
                "time",
                vec![line("exact", &[(3, [0.01, 0.1])]), line("field", &[(3, [0.3, 1.0]), (25, [4.0, 9.0])])],
            ),
            ("error", vec![line("exact", &[(3, [0.0, 1e-11]), (1024, [0.0, 0.0])])]),
            ("nothing", Vec::new()),
        ];
        let drawn = svg("some demands", &figures).expect("drawn");
        for word in ["exact", "field", "Modules", "25", "1024", "some demands", "time", "error", "nothing"] {
            assert!(drawn.contains(word), "no {word}");
        }
        assert!(!drawn.contains("NaN") && !drawn.contains("inf"));
        // A dot and its rim for every size.
        assert_eq!(drawn.matches("<circle").count(), 2 * 5);
        assert!(svg("", &[]).is_ok());
    }

    #[test]
    fn powers_of_ten_enclose_what_they_are_for() {
        let near = |found: Vec<f64>, told: &[f64]| {
            assert_eq!(found.len(), told.len(), "{found:?}");
            assert!(found.iter().zip(told).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{found:?}");
        };
        near(powers([0.02, 40.0].into_iter()), &[0.01, 0.1, 1.0, 10.0, 100.0]);
        near(powers([1e-16, 0.5].into_iter()), &[1e-18, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0]);
        near(powers([0.0, f64::NAN].into_iter()), &[1.0, 10.0]);
    }
}
