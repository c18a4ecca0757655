//! The frame of every picture: heading, panels, legends, and the SVG around what plotters draws.
//!
//! A panel is one chart with its title above the upper left corner, its legend above the upper right one (so that
//! no legend ever covers data), a thin grid, and the description of its axes outside. Lengths are px; the drawing
//! grid is finer ([`super::style::SUBPIXELS`]).

use std::ops::Range;

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::prelude::SVGBackend;
use plotters::style::{RGBColor, ShapeStyle, WHITE};

use super::axis::Axis;
use super::lines::Point;
use super::style::{self, Anchor};

/// The error of plotters when it cannot draw.
pub type DrawError = DrawingAreaErrorKind<std::io::Error>;
/// A rectangle of the picture, in steps of the drawing grid from its own upper left corner.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width of pictures with panels beside each other, px.
pub(super) const WIDE: f64 = 1500.0;
/// Empty border of a picture, px.
const MARGIN: f64 = 26.0;
/// Height of the heading, px.
const HEADING: f64 = 56.0;
/// Height of a row of title or legend above a chart, px.
const ROW: f64 = 28.0;
/// Width of the sign before an entry of a legend, px.
const SIGN: f64 = 22.0;
/// Space between two entries of a legend, px.
const GAP: f64 = 18.0;
/// Width left of a chart for the labels of its y axis, px.
pub(super) const LEFT: f64 = 52.0;
/// Width right of a chart, so that the last label of its x axis fits, px.
const RIGHT: f64 = 16.0;
/// Height below a chart for labels and description of its x axis, px.
const BELOW: f64 = 42.0;
/// Height below a chart whose x axis is written out by the chart under it, px.
const BELOW_BARE: f64 = 8.0;

/// Title, description and line above a picture.
#[derive(Clone, Debug)]
pub struct Heading<'h> {
    /// Name of the run.
    pub name: &'h str,
    /// What the picture shows.
    pub subject: &'h str,
    /// One line under the heading.
    pub line: String,
}

/// Draws a picture of `width` × `height` px: heading, then what `draw` puts in the area under it.
pub fn render(
    (width, height): (f64, f64),
    heading: &Heading<'_>,
    draw: impl FnOnce(&Area<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let mut svg = String::new();
    {
        let root =
            SVGBackend::with_string(&mut svg, (style::size(width), style::size(height))).into_drawing_area();
        root.fill(&WHITE)?;
        let x = style::px(MARGIN);
        let room_px = width - 2.0 * MARGIN;
        let subject = format!(" · {}", heading.subject);
        let subject_px = style::text_width(&subject, style::SIZE_HEADING);
        let name = style::fit(&printable(heading.name), style::SIZE_HEADING, room_px - subject_px);
        let title = style::bold(style::SIZE_HEADING, style::INK, Anchor::Start);
        root.draw_text(&format!("{name}{subject}"), &title, (x, style::px(MARGIN + 8.0)))?;
        let line = style::fit(&printable(&heading.line), style::SIZE_TEXT, room_px);
        let muted = style::text(style::SIZE_TEXT, style::MUTED, Anchor::Start);
        root.draw_text(&line, &muted, (x, style::px(MARGIN + 32.0)))?;
        let body = root.margin(
            style::px(MARGIN + HEADING),
            style::px(0.6 * MARGIN),
            style::px(0.5 * MARGIN),
            style::px(0.5 * MARGIN),
        );
        draw(&body)?;
        root.present()?;
    }
    Ok(finish(&svg, (width, height), &format!("{} · {}", heading.name, heading.subject)))
}

/// The size of the area under the heading of a picture of `width` × `height` px.
#[must_use]
pub fn body_size((width, height): (f64, f64)) -> (f64, f64) {
    (width - MARGIN, height - HEADING - 1.6 * MARGIN)
}

/// The height of a picture whose body is `body` px high.
#[must_use]
pub fn height_for(body: f64) -> f64 {
    body + HEADING + 1.6 * MARGIN
}

/// The width of the chart itself, px, in a panel of `panel` px.
#[must_use]
pub fn chart_width(panel: f64) -> f64 {
    panel - LEFT - RIGHT
}

/// What a panel needs above and below its chart, px: the legend in a row of its own or not, and the x axis written
/// out or not.
#[must_use]
pub fn around(legend_below: bool, x_axis_written: bool) -> f64 {
    title_height(legend_below) + if x_axis_written { BELOW } else { BELOW_BARE }
}

fn title_height(legend_below: bool) -> f64 {
    if legend_below { 1.9 * ROW } else { ROW }
}

/// Cuts an area into `rows` panels with equally high charts, of which the last also carries the x axis.
#[must_use]
pub fn stacked<'a>(area: &Area<'a>, rows: usize) -> Vec<Area<'a>> {
    let (_, height) = area_size(area);
    let each = (height - (BELOW - BELOW_BARE)) / rows.max(1) as f64;
    let breaks: Vec<i32> = (1..rows).map(|n| style::px(each * n as f64)).collect();
    area.split_by_breakpoints([0i32; 0], breaks)
}

/// The size of an area, px.
#[must_use]
pub fn area_size(area: &Area<'_>) -> (f64, f64) {
    let (width, height) = area.dim_in_pixel();
    (f64::from(width) / style::SUBPIXELS, f64::from(height) / style::SUBPIXELS)
}

/// The sign before an entry of a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Key {
    /// A line of that width, px.
    Line(RGBColor, f64, f64),
    /// A dashed line.
    Dashed(RGBColor),
    /// A dashed line within a shaded area of that opacity.
    Tolerance(RGBColor, f64),
    /// A shaded area with that opacity.
    Band(RGBColor, f64),
    /// A full dot.
    Dot(RGBColor),
    /// A ring.
    Ring(RGBColor),
}

/// What stands around a chart; [`Panel::new`] has neither legend nor descriptions of axes.
#[derive(Clone, Debug)]
pub struct Panel<'p> {
    /// Title; where the y axis has no description of its own, with its unit.
    pub title: &'p str,
    /// Legend, from left to right.
    pub legend: &'p [(Key, &'p str)],
    /// Whether the legend has a row of its own under the title.
    pub legend_below: bool,
    /// Interval and ticks along x.
    pub x: Axis,
    /// Interval and ticks along y.
    pub y: Axis,
    /// Description of the x axis; `None`: neither labels nor description.
    pub x_title: Option<&'p str>,
    /// Description of the y axis, written along it.
    pub y_title: Option<&'p str>,
}

impl<'p> Panel<'p> {
    /// With that title and those axes.
    #[must_use]
    pub fn new(title: &'p str, x: Axis, y: Axis) -> Self {
        Self { title, x, y, legend: &[], legend_below: false, x_title: None, y_title: None }
    }

    /// A map that holds east (low, high) and north, m, in `area` with at least `air` px around them: equal axes, the tighter
    /// direction sets the scale, and that is 0.02 mm a px at least. The panel, and the metres of a px.
    #[must_use]
    pub fn map(title: &'p str, area: &Area<'_>, (east, north): (Point, Point), air: f64) -> (Self, f64) {
        let (width, height) = area_size(area);
        let (width_px, height_px) = (chart_width(width), height - around(false, true));
        let m_per_px = ((east.1 - east.0) / (width_px - 2.0 * air))
            .max((north.1 - north.0) / (height_px - 2.0 * air))
            .max(2e-5);
        let axis = |(low, high): Point, px: f64| {
            let (centre, half) = (0.5 * (low + high), 0.5 * px * m_per_px);
            Axis::spaced(centre - half, centre + half, 55.0 * m_per_px)
        };
        let panel = Self::new(title, axis(east, width_px), axis(north, height_px));
        (Self { x_title: Some("East, m"), y_title: Some("North, m"), ..panel }, m_per_px)
    }
}

/// A panel ready to be drawn in, in the units of its axes.
pub struct Chart<'a, 'c> {
    context: ChartContext<'c, SVGBackend<'a>, Cartesian2d<Axis, Axis>>,
}

impl<'a, 'c> Chart<'a, 'c> {
    /// Draws title, legend, grid and axes of a panel that fills `area`.
    pub fn new(area: &Area<'a>, panel: &Panel<'_>) -> Result<Self, DrawError> {
        let (width, _) = area_size(area);
        let legend_px = if panel.legend_below { 0.0 } else { legend_width(panel.legend) };
        // Bold type is some 8 % wider.
        let room_px = (chart_width(width) - legend_px) / 1.08;
        let title = style::fit(&printable(panel.title), style::SIZE_PANEL, room_px);
        let title_style = style::bold(style::SIZE_PANEL, style::INK, Anchor::Start);
        area.draw_text(&title, &title_style, (style::px(LEFT), style::px(0.5 * ROW)))?;
        // Beside the title the legend ends with the chart; in a row of its own it begins with it.
        let above = title_height(panel.legend_below);
        let legend_px = if panel.legend_below { LEFT } else { width - RIGHT - legend_px };
        draw_legend(area, (legend_px, above - 0.5 * ROW), panel.legend)?;

        let below = if panel.x_title.is_some() { BELOW } else { BELOW_BARE };
        let mut context = ChartBuilder::on(area)
            .margin_top(style::px(above))
            .margin_right(style::px(RIGHT))
            .x_label_area_size(style::px(below))
            .y_label_area_size(style::px(LEFT))
            .build_cartesian_2d(panel.x.clone(), panel.y.clone())?;
        let x_label = |value: &f64| {
            if panel.x_title.is_some() { panel.x.label(*value) } else { String::new() }
        };
        let y_label = |value: &f64| panel.y.label(*value);
        let tick = style::text(style::SIZE_TICK, style::MUTED, Anchor::Start);
        let description = style::text(style::SIZE_TEXT, style::MUTED, Anchor::Middle);
        context
            .configure_mesh()
            .bold_line_style(style::line(style::GRID, 1.0, 1.0))
            .light_line_style(style::line(style::GRID, 1.0, 1.0))
            .axis_style(style::line(style::FRAME, 1.0, 1.0))
            .set_all_tick_mark_size(style::px(3.5))
            .label_style(tick)
            .axis_desc_style(description)
            .x_desc(panel.x_title.unwrap_or_default())
            .y_desc(panel.y_title.unwrap_or_default())
            .x_label_formatter(&x_label)
            .y_label_formatter(&y_label)
            .draw()?;
        Ok(Self { context })
    }

    /// The interval shown along x.
    #[must_use]
    pub fn x(&self) -> Range<f64> {
        self.context.x_range()
    }

    /// The interval shown along y.
    #[must_use]
    pub fn y(&self) -> Range<f64> {
        self.context.y_range()
    }

    /// px of a unit along x and along y.
    #[must_use]
    pub fn scale(&self) -> (f64, f64) {
        let (width, height) = self.context.plotting_area().dim_in_pixel();
        let (x, y) = (self.x(), self.y());
        (
            f64::from(width) / style::SUBPIXELS / (x.end - x.start),
            f64::from(height) / style::SUBPIXELS / (y.end - y.start),
        )
    }

    /// A line through the points.
    pub fn line(&self, points: Vec<Point>, line: ShapeStyle) -> Result<(), DrawError> {
        if points.len() < 2 {
            return Ok(());
        }
        self.context.plotting_area().draw(&PathElement::new(points, line))
    }

    /// A dashed line through the points.
    pub fn dashed(&self, points: &[Point], line: ShapeStyle) -> Result<(), DrawError> {
        let dashes = DashedPathElement::new(points.iter().copied(), style::size(6.0), style::size(4.0), line);
        self.context.plotting_area().draw(&dashes)
    }

    /// A filled polygon.
    pub fn polygon(&self, points: Vec<Point>, fill: ShapeStyle) -> Result<(), DrawError> {
        if points.len() < 3 {
            return Ok(());
        }
        self.context.plotting_area().draw(&Polygon::new(points, fill))
    }

    /// A shaded rectangle between two corners.
    pub fn band(&self, x: (f64, f64), y: (f64, f64), fill: ShapeStyle) -> Result<(), DrawError> {
        let (across, up) = (self.x(), self.y());
        let cut = |v: f64, r: &Range<f64>| v.clamp(r.start, r.end);
        let corners = [(cut(x.0, &across), cut(y.0, &up)), (cut(x.1, &across), cut(y.1, &up))];
        self.context.plotting_area().draw(&Rectangle::new(corners, fill))
    }

    /// A dot of that radius in px with a white rim.
    pub fn dot(&self, at: Point, radius_px: f64, colour: RGBColor) -> Result<(), DrawError> {
        let plot = self.context.plotting_area();
        plot.draw(&Circle::new(at, style::size(radius_px + 1.5), style::fill(WHITE, 1.0)))?;
        plot.draw(&Circle::new(at, style::size(radius_px), style::fill(colour, 1.0)))
    }

    /// A ring of that radius in px.
    pub fn ring(&self, at: Point, radius_px: f64, colour: RGBColor) -> Result<(), DrawError> {
        self.dot(at, radius_px, colour)?;
        let inside = Circle::new(at, style::size(radius_px - 2.0), style::fill(WHITE, 1.0));
        self.context.plotting_area().draw(&inside)
    }

    /// A text with `offset` px (right, down) from a point.
    pub fn text(
        &self,
        text: &str,
        at: Point,
        offset: (f64, f64),
        style: &plotters::style::TextStyle<'_>,
    ) -> Result<(), DrawError> {
        let plot = self.context.plotting_area();
        let (x, y) = plot.map_coordinate(&at);
        let place = (x + style::px(offset.0), y + style::px(offset.1));
        let (x0, y0) = plot.get_base_pixel();
        let screen = plot.strip_coord_spec();
        screen.draw_text(&printable(text), style, (place.0 - x0, place.1 - y0))
    }
}

/// The width of an entry of a legend without the space after it, px.
fn entry_width(text: &str) -> f64 {
    SIGN + 6.0 + style::text_width(text, style::SIZE_TEXT)
}

fn legend_width(legend: &[(Key, &str)]) -> f64 {
    let entries: f64 = legend.iter().map(|(_, text)| entry_width(text) + GAP).sum();
    (entries - GAP).max(0.0)
}

/// Draws the legend from a point (right, down) in px on.
fn draw_legend(area: &Area<'_>, (mut x, y): (f64, f64), legend: &[(Key, &str)]) -> Result<(), DrawError> {
    let y = style::px(y);
    let words = style::text(style::SIZE_TEXT, style::MUTED, Anchor::Start);
    for (key, text) in legend {
        let (from, to) = (style::px(x), style::px(x + SIGN));
        let middle = (style::px(x + SIGN - 7.0), y);
        let dashes = |colour| {
            let line = style::line(colour, 1.0, 1.5);
            let ends = [(from, y), (to, y)].into_iter();
            area.draw(&DashedPathElement::new(ends, style::size(6.0), style::size(2.0), line))
        };
        let band = |colour, opacity| {
            let half = style::px(5.5);
            area.draw(&Rectangle::new([(from, y - half), (to, y + half)], style::fill(colour, opacity)))
        };
        match *key {
            Key::Line(colour, opacity, width_px) => area
                .draw(&PathElement::new(vec![(from, y), (to, y)], style::line(colour, opacity, width_px)))?,
            Key::Dashed(colour) => dashes(colour)?,
            Key::Tolerance(colour, opacity) => {
                band(colour, opacity)?;
                dashes(colour)?;
            }
            Key::Band(colour, opacity) => band(colour, opacity)?,
            Key::Dot(colour) => {
                area.draw(&Circle::new(middle, style::size(4.5), style::fill(colour, 1.0)))?;
            }
            Key::Ring(colour) => {
                area.draw(&Circle::new(middle, style::size(4.5), style::fill(colour, 1.0)))?;
                area.draw(&Circle::new(middle, style::size(2.5), style::fill(WHITE, 1.0)))?;
            }
        }
        area.draw_text(text, &words, (style::px(x + SIGN + 6.0), y))?;
        x += entry_width(text) + GAP;
    }
    Ok(())
}

/// Without control characters, which XML does not know.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Gives the picture its real size, a title that a screen reader finds, fonts and round joins for all of it, and
/// drops what plotters repeats on every element.
fn finish(svg: &str, (width, height): (f64, f64), title: &str) -> String {
    let body = svg.split_once(">\n").map_or(svg, |(_, body)| body);
    let body = body.replace(" opacity=\"1\"", "").replace(" font-family=\"sans-serif\"", "");
    let title: String = printable(title)
        .chars()
        .map(|c| match c {
            '<' => "&lt;".to_owned(),
            '>' => "&gt;".to_owned(),
            '&' => "&amp;".to_owned(),
            other => other.to_string(),
        })
        .collect();
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {} {}\" font-family=\"{}\" stroke-linejoin=\"round\">\n<title>{title}</title>\n{body}",
        style::size(width),
        style::size(height),
        style::FONTS,
    )
}
