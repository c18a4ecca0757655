//! One column a slot, one row a quantity, the records over each other: robots that go to the same slot are compared,
//! as in the paper's Figs. 4 and 5, each over the time since its own move began.
//!
//! Over each column stands a bar for every record, as long as its move, with the number of the robot. More than four
//! slots go on in further blocks under the first.

use plotters::element::{PathElement, Rectangle};
use plotters::style::RGBColor;
use reconfiguration::plan::destination;
use record::reconfigure::{Record, Sample};

use super::executed_move::{self, ExecutedMove};
use super::stroke::{self, Pattern, Sign};
use crate::axis::{Axis, extent, number};
use crate::lines::{self, Point};
use crate::picture::{self, Area, Chart, DrawError, Panel};
use crate::style::{self, Anchor};

/// Most columns of a block.
const MOST: usize = 4;
/// Height of the title over a column, px.
const TITLE: f64 = 24.0;
/// Height of the bar of one move, px.
const BAR: f64 = 19.0;

/// A quantity of a robot, given by its index, at an instant; `None` where it has none.
pub type Quantity = Box<dyn Fn(&Sample, usize) -> Option<f64>>;

/// One row of panels: a quantity of every robot.
pub struct Row {
    /// Its quantity with the unit.
    pub title: String,
    /// That quantity.
    pub value: Quantity,
    /// Values that the axis holds in any case.
    pub holds: (f64, f64),
    /// A shaded interval.
    pub shaded: Option<(f64, f64)>,
    /// Whether a value lasts until the next one, so that the line has steps.
    pub is_stepped: bool,
    /// About how many ticks stand along y.
    pub ticks: usize,
}

impl Row {
    /// A line that joins its values, on an axis about zero with some five ticks.
    pub fn new(title: &str, value: impl Fn(&Sample, usize) -> Option<f64> + 'static) -> Self {
        let (title, value) = (title.to_owned(), Box::new(value));
        Self { title, value, holds: (-0.05, 0.05), shaded: None, is_stepped: false, ticks: 5 }
    }
}

/// A picture of several quantities, a row of panels for each.
pub struct Table<'t> {
    /// What it shows.
    pub subject: &'t str,
    /// Its rows.
    pub rows: Vec<Row>,
    /// Height of each chart, px.
    pub chart_height: f64,
    /// What stands in the legend beside the records.
    pub legend: Vec<(Sign, String)>,
}

/// One slot: the move into it in each record (number of the record, the move).
struct Column<'r> {
    slot: Option<usize>,
    moves: Vec<(usize, ExecutedMove<'r>)>,
}

fn columns(records: &[Record]) -> Vec<Column<'_>> {
    let all: Vec<(usize, ExecutedMove<'_>)> = records
        .iter()
        .enumerate()
        .flat_map(|(n, record)| executed_move::executed_moves(record).into_iter().map(move |c| (n, c)))
        .collect();
    let slots = all.iter().filter_map(|(_, c)| Some(c.planned.slot? + 1)).max().unwrap_or(0);
    // Moves that park come last.
    (0..slots)
        .map(Some)
        .chain([None])
        .map(|slot| {
            let moves = all.iter().filter(|(_, c)| c.planned.slot == slot).copied().collect();
            Column { slot, moves }
        })
        .filter(|column| !column.moves.is_empty())
        .collect()
}

/// The curve of a row along a move, over the time since the move began.
fn curve(row: &Row, moved: &ExecutedMove<'_>) -> Vec<Point> {
    let (start_s, _) = moved.span_s();
    let points = moved.samples.iter().filter_map(|sample| {
        let value = (row.value)(sample, moved.robot)?;
        (value.is_finite() && sample.t_s.is_finite()).then_some((sample.t_s - start_s, value))
    });
    if !row.is_stepped {
        return points.collect();
    }
    let mut steps: Vec<Point> = Vec::new();
    for (t_s, value) in points {
        match steps.last() {
            // What stays the same needs no corner.
            Some(&(_, before)) if (before - value).abs() < 1e-12 => {}
            Some(&(_, before)) => steps.extend([(t_s, before), (t_s, value)]),
            None => steps.push((t_s, value)),
        }
    }
    if let Some(&(_, last)) = steps.last() {
        let (from_s, to_s) = moved.span_s();
        steps.push((to_s - from_s, last));
    }
    steps
}

/// Draws a picture of the records: a column for each slot, a row for each quantity.
pub fn svg(records: &[Record], table: &Table<'_>) -> Result<String, DrawError> {
    let columns = columns(records);
    let blocks: Vec<&[Column<'_>]> = columns.chunks(MOST).collect();
    let (width, _) = picture::body_size((picture::WIDE, 0.0));
    let mut legend: Vec<(Sign, String)> = records
        .iter()
        .enumerate()
        .map(|(n, record)| {
            let (colour, pattern) = stroke::of_record(n);
            (Sign::Line(colour, pattern, 1.0, 2.0), executed_move::label(&record.plan).to_owned())
        })
        .collect();
    legend.extend(table.legend.iter().cloned());
    let bars_px = TITLE + BAR * records.len() as f64 + 4.0;
    let row_px = table.chart_height + picture::around(false, false);
    let block_px = bars_px
        + row_px * table.rows.len() as f64
        + (picture::around(false, true) - picture::around(false, false))
        + 14.0;
    let spans = columns.iter().flat_map(|c| &c.moves).map(|(_, c)| c.span_s().1 - c.span_s().0);
    let longest_s = extent(spans).map_or(1.0, |(_, longest)| longest.max(1e-3));
    let ranges: Vec<(f64, f64)> = table
        .rows
        .iter()
        .map(|row| {
            let values = columns.iter().flat_map(|c| &c.moves).flat_map(|(_, c)| curve(row, c));
            extent(values.map(|p| p.1).chain([row.holds.0, row.holds.1])).unwrap_or((-1.0, 1.0))
        })
        .collect();
    let height = block_px * blocks.len().max(1) as f64;
    stroke::render(records, table.subject, picture::WIDE, height, &legend, |area, legend_px| {
        for (n, block) in blocks.iter().enumerate() {
            let top = style::px(legend_px + block_px * n as f64);
            let bottom = style::px(legend_px + block_px * (n + 1) as f64);
            let wide = style::px(width);
            let each = wide / i32::try_from(block.len().max(1)).unwrap_or(1);
            for (k, column) in (0..).zip(*block) {
                let cell = area.clone().shrink((k * each, top), (each, bottom - top));
                let (bars, charts) = cell.split_vertically(style::px(bars_px));
                draw_bars(&bars, records, column, longest_s)?;
                let strips = picture::stacked(&charts.margin(0, style::px(14.0), 0, 0), table.rows.len());
                for (m, (strip, row)) in strips.iter().zip(&table.rows).enumerate() {
                    let range = ranges.get(m).copied().unwrap_or((-1.0, 1.0));
                    let place = (k == 0, m + 1 == table.rows.len());
                    draw_chart(strip, column, row, (range, longest_s), place)?;
                }
            }
        }
        Ok(())
    })
}

/// Where the slot is, and a bar for every move to it.
fn draw_bars(
    area: &Area<'_>,
    records: &[Record],
    column: &Column<'_>,
    longest_s: f64,
) -> Result<(), DrawError> {
    let (width, _) = picture::area_size(area);
    let chart_px = picture::chart_width(width);
    let left = picture::LEFT;
    let at = records.first().and_then(|r| r.problem.slots.get(column.slot?)).map(|s| s.pose.position_m);
    let mut title = format!("To {}", destination(column.slot));
    if let Some([x, y, z]) = at {
        title += &format!(" at ({}, {}, {}) m", number(x, 2), number(y, 2), number(z, 2));
    }
    let bold = style::bold(style::SIZE_PANEL, style::INK, Anchor::Start);
    let title = style::fit(&title, style::SIZE_PANEL, (width - left) / 1.08);
    area.draw_text(&title, &bold, (style::px(left), style::px(0.5 * TITLE)))?;
    for (n, moved) in &column.moves {
        let (colour, _) = stroke::of_record(*n);
        let (from_s, to_s) = moved.span_s();
        let middle = TITLE + BAR * (*n as f64 + 0.5);
        let end = left + chart_px * ((to_s - from_s) / longest_s).clamp(0.0, 1.0);
        let corners = [
            (style::px(left), style::px(middle - 7.0)),
            (style::px(end.max(left + 2.0)), style::px(middle + 7.0)),
        ];
        area.draw(&Rectangle::new(corners, style::fill(colour, 0.16)))?;
        let edge =
            vec![(style::px(left), style::px(middle - 7.0)), (style::px(left), style::px(middle + 7.0))];
        area.draw(&PathElement::new(edge, style::line(colour, 1.0, 2.5)))?;
        let text = format!("robot {}, {} s", moved.planned.robot, number(to_s - from_s, 1));
        let ink = style::text(style::SIZE_TICK, style::INK, Anchor::Start);
        area.draw_text(&text, &ink, (style::px(left + 8.0), style::px(middle)))?;
    }
    Ok(())
}

fn draw_chart(
    area: &Area<'_>,
    column: &Column<'_>,
    row: &Row,
    ((low, high), longest_s): ((f64, f64), f64),
    (is_first, is_last): (bool, bool),
) -> Result<(), DrawError> {
    let (width, _) = picture::area_size(area);
    let x = Axis::time(0.0, longest_s, (picture::chart_width(width) / 55.0) as usize);
    let panel = Panel::new(if is_first { &row.title } else { "" }, x, Axis::padded(low, high, row.ticks));
    let x_title = is_last.then_some("Time since the move began, s");
    let chart = Chart::new(area, &Panel { x_title, ..panel })?;
    let across = chart.x();
    if let Some(shaded) = row.shaded {
        chart.band((across.start, across.end), shaded, style::fill(style::DEMAND, 0.13))?;
    }
    if chart.y().contains(&0.0) {
        chart.line(vec![(across.start, 0.0), (across.end, 0.0)], style::line(style::FRAME, 1.0, 1.0))?;
    }
    let points = picture::chart_width(width) as usize;
    for (n, moved) in &column.moves {
        let (colour, pattern): (RGBColor, Pattern) = stroke::of_record(*n);
        let curve = lines::thin_series(&curve(row, moved), points);
        chart.line(curve, style::line(stroke::marked(colour, pattern), 1.0, 2.0))?;
    }
    Ok(())
}
