//! How records are told apart: solid, dashed and dotted lines as in the paper's Figs. 4–6, with a colour each.
//!
//! Plotters knows no dash pattern. It is carried through as a mark in the lowest bits of a colour's blue, which the
//! eye does not see, and `dashes` turns the marked strokes into dashed ones. Colours that carry a mark are those of
//! `MARKED` and no others.

use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::RGBColor;
use record::reconfigure::Record;

use crate::picture::{self, Area, DrawError, Heading};
use crate::style::{self, Anchor};

/// Pattern of a line: solid, dashed or dotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Without a gap.
    Solid,
    /// In dashes.
    Dashed,
    /// In dots.
    Dotted,
}

/// Colours that occur dashed or dotted.
const MARKED: [RGBColor; 6] =
    [style::BLUE, style::VERMILION, style::GREEN, style::PURPLE, style::INK, style::MUTED];
/// Patterns, their marks, and their lengths on the drawing grid.
const PATTERNS: [(Pattern, u8, &str); 2] = [(Pattern::Dashed, 1, "26 14"), (Pattern::Dotted, 2, "8 8")];

/// The colour and the pattern of record `index`; after the third they begin again.
#[must_use]
pub fn of_record(index: usize) -> (RGBColor, Pattern) {
    match index % 3 {
        0 => (style::BLUE, Pattern::Solid),
        1 => (style::VERMILION, Pattern::Dashed),
        _ => (style::GREEN, Pattern::Dotted),
    }
}

/// A colour that carries a pattern to `dashes`.
#[must_use]
pub fn marked(colour: RGBColor, pattern: Pattern) -> RGBColor {
    let mark = PATTERNS.iter().find(|p| p.0 == pattern).map_or(0, |p| p.1);
    RGBColor(colour.0, colour.1, colour.2 ^ mark)
}

/// Turns marked strokes into dashed ones.
fn dashes(svg: &str) -> String {
    let mut svg = svg.to_owned();
    for colour in MARKED {
        for (pattern, _, lengths) in PATTERNS {
            let RGBColor(r, g, b) = marked(colour, pattern);
            let from = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
            if svg.contains(&from) {
                let RGBColor(r, g, b) = colour;
                let to = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\" stroke-dasharray=\"{lengths}\"");
                svg = svg.replace(&from, &to);
            }
        }
    }
    svg
}

/// The sign before an entry of a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// A line of that opacity and width, px.
    Line(RGBColor, Pattern, f64, f64),
    /// A filled box of that opacity, with an edge if one is given.
    Box(RGBColor, f64, Option<(RGBColor, Pattern)>),
    /// A full disc.
    Disc(RGBColor),
    /// A diagonal cross.
    Cross(RGBColor),
}

/// Width of a sign, px.
const SIGN: f64 = 26.0;
/// Space after it, px.
const AFTER: f64 = 7.0;
/// Space between two entries of a legend, px.
const GAP: f64 = 22.0;
/// Height of a row of a legend, px.
pub const LEGEND_ROW: f64 = 22.0;

/// Where each entry of a legend begins (right, down), px, when rows are `width` px wide.
fn places(texts: &[(Sign, String)], width: f64) -> Vec<(f64, f64)> {
    let (mut x, mut y) = (0.0, 0.5 * LEGEND_ROW);
    texts
        .iter()
        .map(|(_, text)| {
            let entry = SIGN + AFTER + style::text_width(text, style::SIZE_TEXT);
            if x > 0.0 && x + entry > width {
                (x, y) = (0.0, y + LEGEND_ROW);
            }
            let place = (x, y);
            x += entry + GAP;
            place
        })
        .collect()
}

/// The height of a legend in rows of `width` px.
fn legend_height(entries: &[(Sign, String)], width: f64) -> f64 {
    places(entries, width).last().map_or(0.0, |p| p.1 + 0.5 * LEGEND_ROW)
}

/// A picture `width` px wide of what the records share: under the heading a legend, then `height` px that `draw` fills, told how
/// far down they begin.
pub fn render(
    records: &[Record],
    subject: &str,
    width: f64,
    height: f64,
    entries: &[(Sign, String)],
    draw: impl FnOnce(&Area<'_>, f64) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let rows_px = picture::body_size((width, 0.0)).0 - 26.0;
    let legend_px = legend_height(entries, rows_px) + 10.0;
    let (name, description) =
        records.first().map_or(("", ""), |r| (r.problem.name.as_str(), r.problem.description.as_str()));
    let heading = Heading { name, subject, line: description.to_owned() };
    let svg = picture::render((width, picture::height_for(legend_px + height)), &heading, |area| {
        legend(area, (13.0, 0.0), rows_px, entries)?;
        draw(area, legend_px)
    })?;
    Ok(dashes(&svg))
}

/// Draws a legend from a point (right, down) in px on, in rows of `width` px.
pub fn legend(
    area: &Area<'_>,
    (left, top): (f64, f64),
    width: f64,
    entries: &[(Sign, String)],
) -> Result<(), DrawError> {
    let words = style::text(style::SIZE_TEXT, style::MUTED, Anchor::Start);
    for ((sign, text), (right, down)) in entries.iter().zip(places(entries, width)) {
        let (x, y) = (left + right, top + down);
        let at = |right: f64, down: f64| (style::px(x + right), style::px(y + down));
        match *sign {
            Sign::Line(colour, pattern, opacity, width_px) => {
                let line = style::line(marked(colour, pattern), opacity, width_px);
                area.draw(&PathElement::new(vec![at(0.0, 0.0), at(SIGN, 0.0)], line))?;
            }
            Sign::Box(colour, opacity, edge) => {
                let corners = [at(4.0, -6.0), at(SIGN, 6.0)];
                area.draw(&Rectangle::new(corners, style::fill(colour, opacity)))?;
                if let Some((colour, pattern)) = edge {
                    let [(x0, y0), (x1, y1)] = corners;
                    let around = vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)];
                    let line = style::line(marked(colour, pattern), 1.0, 1.25);
                    area.draw(&PathElement::new(around, line))?;
                }
            }
            Sign::Disc(colour) => {
                area.draw(&Circle::new(at(SIGN - 8.0, 0.0), style::size(6.0), style::fill(colour, 1.0)))?;
            }
            Sign::Cross(colour) => {
                for down in [-5.0, 5.0] {
                    let ends = vec![at(SIGN - 13.0, -down), at(SIGN - 3.0, down)];
                    area.draw(&PathElement::new(ends, style::line(colour, 1.0, 2.5)))?;
                }
            }
        }
        area.draw_text(text, &words, at(SIGN + AFTER, 0.0))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_become_dashes_and_leave_no_trace() {
        let RGBColor(r, g, b) = marked(style::VERMILION, Pattern::Dashed);
        let svg = format!("<line stroke=\"#{r:02X}{g:02X}{b:02X}\" x1=\"0\"/><line stroke=\"#0072B2\"/>");
        let expected =
            "<line stroke=\"#D55E00\" stroke-dasharray=\"26 14\" x1=\"0\"/><line stroke=\"#0072B2\"/>";
        assert_eq!(dashes(&svg), expected);
    }

    #[test]
    fn no_mark_is_the_colour_of_something_else() {
        let plain = [style::FRAME, style::GRID, style::HULL, style::DEMAND, style::ORANGE, style::SKY];
        for (n, colour) in MARKED.into_iter().enumerate() {
            for pattern in [Pattern::Dashed, Pattern::Dotted] {
                let found = MARKED.iter().chain(&plain).any(|&c| c == marked(colour, pattern));
                assert!(!found, "colour {n}, {pattern:?}");
            }
        }
    }

    #[test]
    fn long_legends_go_on_in_the_next_row() {
        let entry = (Sign::Cross(style::INK), "a start that was left".to_owned());
        let entries = vec![entry; 5];
        assert!((legend_height(&entries, 1e4) - LEGEND_ROW).abs() < 1e-9);
        assert!((legend_height(&entries, 400.0) - 3.0 * LEGEND_ROW).abs() < 1e-9);
        assert!(places(&entries, 400.0).iter().all(|p| p.0 < 400.0));
    }
}
