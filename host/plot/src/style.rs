//! One look for every picture: colours, type sizes, line widths, and the pixel grid.
//!
//! Colours are those of Okabe and Ito (*Color Universal Design*, 2008), which stay apart for every common kind of
//! colour blindness, with a slate for what carries no category. Plotters draws on whole pixels only, so every
//! picture is laid out on a grid of [`SUBPIXELS`] steps a pixel and shown at its real size by the `viewBox`:
//! lines may be 1.25 px wide and curves do not show stairs.

use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, RGBColor, ShapeStyle, TextStyle};

/// Steps of the drawing grid in one pixel.
pub const SUBPIXELS: f64 = 4.0;

/// Colour of text and marks.
pub const INK: RGBColor = RGBColor(0x1F, 0x29, 0x33);
/// Colour of secondary text.
pub const MUTED: RGBColor = RGBColor(0x5F, 0x6B, 0x7A);
/// Colour of axis lines and ticks.
pub const FRAME: RGBColor = RGBColor(0xB4, 0xBD, 0xC8);
/// Colour of grid lines.
pub const GRID: RGBColor = RGBColor(0xE9, 0xED, 0xF1);
/// What was asked for, against which the rest is read.
pub const DEMAND: RGBColor = RGBColor(0x52, 0x5F, 0x6E);
/// Colour of the bodies of modules.
pub const HULL: RGBColor = RGBColor(0x3E, 0x5C, 0x76);

/// Where tails collide: a red whose lightness alone sets it off from free space.
pub const COLLISION: RGBColor = RGBColor(0xE5, 0x8B, 0x7B);
/// Colour of the edge of a collision region.
pub const COLLISION_EDGE: RGBColor = RGBColor(0xB8, 0x3A, 0x26);

/// Okabe–Ito blue.
pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xB2);
/// Okabe–Ito vermilion.
pub const VERMILION: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
/// Okabe–Ito bluish green.
pub const GREEN: RGBColor = RGBColor(0x00, 0x9E, 0x73);
/// Okabe–Ito reddish purple.
pub const PURPLE: RGBColor = RGBColor(0xCC, 0x79, 0xA7);
/// Okabe–Ito orange.
pub const ORANGE: RGBColor = RGBColor(0xE6, 0x9F, 0x00);
/// Okabe–Ito sky blue.
pub const SKY: RGBColor = RGBColor(0x56, 0xB4, 0xE9);

/// The colours of the modules in order; after the last they begin again.
const MODULES: [RGBColor; 7] = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, RGBColor(0x7A, 0x6F, 0x5D)];

/// Size of the heading of a picture, px.
pub const SIZE_HEADING: f64 = 21.0;
/// Size of the title of a panel, px.
pub const SIZE_PANEL: f64 = 13.5;
/// Axis descriptions, legends, the line under the heading, px.
pub const SIZE_TEXT: f64 = 12.5;
/// Size of tick labels, px.
pub const SIZE_TICK: f64 = 11.5;

/// The fonts a viewer is asked for, best first.
pub const FONTS: &str =
    "Inter, Helvetica Neue, Helvetica, Arial, Noto Sans, Liberation Sans, DejaVu Sans, sans-serif";

/// The colour of module `index` in every picture.
#[must_use]
pub fn module_colour(index: usize) -> RGBColor {
    MODULES[index % MODULES.len()]
}

/// The colour of a planner in pictures that compare several.
#[must_use]
pub fn planner_colour(index: usize) -> RGBColor {
    MODULES[index % 4]
}

/// A length in px, in steps of the drawing grid.
#[must_use]
pub fn px(pixels: f64) -> i32 {
    (pixels * SUBPIXELS).round() as i32
}

/// Pixels on the drawing grid where plotters wants a size; negative ones become zero.
#[must_use]
pub fn size(pixels: f64) -> u32 {
    u32::try_from(px(pixels)).unwrap_or(0)
}

/// A line of that colour, opacity (0 to 1) and width.
#[must_use]
pub fn line(colour: RGBColor, opacity: f64, width_px: f64) -> ShapeStyle {
    colour.mix(opacity).stroke_width(size(width_px))
}

/// A filled area of that colour and opacity (0 to 1).
#[must_use]
pub fn fill(colour: RGBColor, opacity: f64) -> ShapeStyle {
    colour.mix(opacity).filled()
}

/// Where a text hangs on its anchor point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred on the point.
    Middle,
}

/// A text style, vertically centred on its anchor point.
#[must_use]
pub fn text(size_px: f64, colour: RGBColor, anchor: Anchor) -> TextStyle<'static> {
    styled(size_px, colour, anchor, FontStyle::Normal)
}

/// A bold text style, vertically centred on its anchor point.
#[must_use]
pub fn bold(size_px: f64, colour: RGBColor, anchor: Anchor) -> TextStyle<'static> {
    styled(size_px, colour, anchor, FontStyle::Bold)
}

fn styled(size_px: f64, colour: RGBColor, anchor: Anchor, weight: FontStyle) -> TextStyle<'static> {
    // The SVG backend divides the size by 1.24 before it writes it.
    let font = FontDesc::new(FontFamily::SansSerif, size_px * SUBPIXELS * 1.24, weight);
    let horizontal = match anchor {
        Anchor::Start => HPos::Left,
        Anchor::Middle => HPos::Center,
    };
    TextStyle { color: colour.to_backend_color(), ..TextStyle::from(font) }
        .pos(Pos::new(horizontal, VPos::Center))
}

/// About how wide a text is, px. The viewer's font is unknown: this errs on the wide side.
#[must_use]
pub fn text_width(text: &str, size_px: f64) -> f64 {
    let ems: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '|' | '\'' | '!' => 0.31,
            'f' | 't' | 'r' | ' ' | '(' | ')' | '/' | '·' | 'I' => 0.40,
            'm' | 'w' | 'M' | 'W' | '—' | '…' => 0.95,
            '±' | '−' | '+' => 0.84,
            c if c.is_uppercase() => 0.70,
            _ => 0.62,
        })
        .sum();
    ems * size_px
}

/// Shortens a text to that width with an ellipsis.
#[must_use]
pub fn fit(text: &str, size_px: f64, width_px: f64) -> String {
    if text_width(text, size_px) <= width_px {
        return text.to_owned();
    }
    let mut short = String::new();
    for c in text.chars() {
        if text_width(&short, size_px) + size_px * 1.5 > width_px {
            break;
        }
        short.push(c);
    }
    format!("{}…", short.trim_end())
}
