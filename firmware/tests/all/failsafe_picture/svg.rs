//! The picture. Colours, type sizes and fonts are those of `host/plot/src/style.rs`, which this crate cannot import.

use std::fmt::Write as _;

use protocol::ModuleState;

use super::layout::{Anchor, Area, FRAME, HALF, NODES, Node, Point, ROUTES, Route, START};
use super::{arrows, come_to, words};

const INK: &str = "#1F2933";
const MUTED: &str = "#5F6B7A";
const LINE: &str = "#525F6E";
const EDGE: &str = "#B4BDC8";
const GROUND: &str = "#F6F8FA";
const BLUE: &str = "#0072B2";
const GREEN: &str = "#009E73";
const RED: &str = "#B83A26";

const SIZE_HEADING: f64 = 21.0;
const SIZE_NAME: f64 = 15.0;
const SIZE_TEXT: f64 = 12.5;
const FONTS: &str =
    "Inter, Helvetica Neue, Helvetica, Arial, Noto Sans, Liberation Sans, DejaVu Sans, sans-serif";

/// Between two lines of a label.
const LEADING: f64 = 16.0;

/// The whole picture.
pub const CANVAS: Area = Area { left: 0.0, top: 0.0, right: 1260.0, bottom: 762.0 };

/// Estimated width of a text: on the wide side, as the viewer's font is unknown.
fn text_width(text: &str, size: f64) -> f64 {
    let ems: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | '.' | ',' | ':' => 0.31,
            'f' | 't' | 'r' | ' ' => 0.40,
            'm' | 'w' | 'M' | 'W' => 0.95,
            c if c.is_uppercase() => 0.70,
            _ => 0.62,
        })
        .sum();
    ems * size
}

fn label(route: &Route) -> Vec<String> {
    arrows()
        .iter()
        .filter(|(from, to, _)| route.from.first() == Some(from) && route.to == *to)
        .flat_map(|(_, _, events)| events.iter().map(words))
        .collect()
}

/// What a label covers.
pub fn label_area(route: &Route) -> Area {
    let lines = label(route);
    let width = lines.iter().map(|line| text_width(line, SIZE_TEXT)).fold(0.0, f64::max);
    let half = LEADING * lines.len() as f64 / 2.0;
    let (x, y) = route.label;
    let left = match route.anchor {
        Anchor::Start => x,
        Anchor::Middle => x - width / 2.0,
        Anchor::End => x - width,
    };
    Area { left, top: y - half, right: left + width, bottom: y + half }
}

/// The colour of a state says what the code permits in it.
fn colour(state: ModuleState) -> &'static str {
    let failsafe = come_to(state);
    match (state, failsafe.may_drive(), failsafe.takes_cycles()) {
        (ModuleState::Stopped, ..) => RED,
        (_, false, _) => MUTED,
        (_, true, Err(_)) => BLUE,
        (_, true, Ok(())) => GREEN,
    }
}

const LEGEND: [(&str, &str); 4] = [
    (MUTED, "drives nothing, says nothing"),
    (BLUE, "holds its pose"),
    (GREEN, "takes cycles"),
    (RED, "latched"),
];

/// An arrow head with its tip at `tip`, coming from `from`.
fn head(svg: &mut String, from: Point, tip: Point, colour: &str) {
    let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
    let length = dx.hypot(dy);
    let (ux, uy) = (dx / length, dy / length);
    let corner = |along: f64, aside: f64| (tip.0 - along * ux - aside * uy, tip.1 - along * uy + aside * ux);
    let [(ax, ay), (bx, by), (cx, cy)] = [corner(10.0, 4.2), corner(7.6, 0.0), corner(10.0, -4.2)];
    let (x, y) = tip;
    writeln!(
        svg,
        r#"<path d="M{x:.1} {y:.1}L{ax:.1} {ay:.1}L{bx:.1} {by:.1}L{cx:.1} {cy:.1}Z" fill="{colour}"/>"#
    )
    .expect("a string");
}

fn text(
    svg: &mut String,
    (x, y): Point,
    anchor: Anchor,
    (size, colour): (f64, &str),
    weight: &str,
    content: &str,
) {
    let anchor = match anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    // Centred by hand: not every viewer knows `dominant-baseline`.
    let y = y + size * 0.36;
    writeln!(
        svg,
        r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" fill="{colour}" text-anchor="{anchor}"{weight}>{content}</text>"#
    )
    .expect("a string");
}

const BOLD: &str = r#" font-weight="600""#;

fn draw_route(svg: &mut String, route: &Route) {
    let [a, b, c, d] = route.curve;
    let colour = match route.to {
        ModuleState::Stopped => RED,
        _ => LINE,
    };
    writeln!(
        svg,
        r#"<path d="M{} {}C{:.1} {:.1} {:.1} {:.1} {} {}" fill="none" stroke="{colour}" stroke-width="1.5"/>"#,
        a.0, a.1, b.0, b.1, c.0, c.1, d.0, d.1
    )
    .expect("a string");
    head(svg, c, d, colour);
    let lines = label(route);
    for (k, line) in lines.iter().enumerate() {
        let y = route.label.1 + LEADING * (k as f64 - (lines.len() as f64 - 1.0) / 2.0);
        text(svg, (route.label.0, y), route.anchor, (SIZE_TEXT, INK), "", line);
    }
}

fn draw_node(svg: &mut String, node: &Node) {
    let Node { state, at: (x, y), does } = node;
    let (colour, Area { left, top, .. }, (w, h)) = (colour(*state), node.area(), HALF);
    writeln!(
        svg,
        concat!(
            r##"<rect x="{}" y="{}" width="{}" height="{}" rx="9" fill="#FFFFFF"/>"##,
            "\n",
            r##"<rect x="{}" y="{}" width="{}" height="{}" rx="9" fill="{}" fill-opacity="0.10" stroke="{}" stroke-width="1.75"/>"##
        ),
        left,
        top,
        2.0 * w,
        2.0 * h,
        left,
        top,
        2.0 * w,
        2.0 * h,
        colour,
        colour
    )
    .expect("a string");
    text(svg, (*x, y - 9.0), Anchor::Middle, (SIZE_NAME, INK), BOLD, &format!("{state:?}"));
    text(svg, (*x, y + 11.0), Anchor::Middle, (SIZE_TEXT, MUTED), "", does);
}

/// The picture of [`TRANSITIONS`](firmware::link::failsafe::TRANSITIONS).
pub fn picture() -> String {
    let Area { right: width, bottom: height, .. } = CANVAS;
    let mut svg = format!(
        concat!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}" font-family="{fonts}">"##,
            "\n<title>The failsafe of a module</title>\n",
            r##"<rect width="{w}" height="{h}" fill="#FFFFFF"/>"##,
            "\n"
        ),
        w = width,
        h = height,
        fonts = FONTS
    );
    text(&mut svg, (28.0, 34.0), Anchor::Start, (SIZE_HEADING, INK), BOLD, "The failsafe of a module");
    let below = "Every arrow is a line of TRANSITIONS in firmware/src/link/failsafe/transitions.rs; every other event changes nothing.";
    text(&mut svg, (28.0, 62.0), Anchor::Start, (SIZE_TEXT, MUTED), "", below);
    let mut right = FRAME.right;
    for (colour, meaning) in LEGEND.into_iter().rev() {
        let x = right - text_width(meaning, SIZE_TEXT) - 20.0;
        text(&mut svg, (x + 20.0, 34.0), Anchor::Start, (SIZE_TEXT, MUTED), "", meaning);
        writeln!(
            svg,
            r#"<rect x="{x:.1}" y="27.5" width="13" height="13" rx="3.5" fill="{colour}" fill-opacity="0.18" stroke="{colour}" stroke-width="1.5"/>"#
        )
        .expect("a string");
        right = x - 22.0;
    }
    let Area { left, top, right, bottom } = FRAME;
    writeln!(
        svg,
        r#"<rect x="{left}" y="{top}" width="{}" height="{}" rx="16" fill="{GROUND}" stroke="{EDGE}" stroke-width="1.25" stroke-dasharray="5 4"/>"#,
        right - left,
        bottom - top
    )
    .expect("a string");
    text(&mut svg, (778.0, 556.0), Anchor::End, (SIZE_TEXT, MUTED), "", "from every state in the frame");
    let (x, y) = START;
    writeln!(svg, r#"<circle cx="{x}" cy="{y}" r="6.5" fill="{INK}"/>"#).expect("a string");
    let boot = NODES[0].area().left;
    writeln!(svg, r#"<path d="M{x} {y}L{boot} {y}" stroke="{LINE}" stroke-width="1.5"/>"#).expect("a string");
    head(&mut svg, START, (boot, y), LINE);
    ROUTES.iter().for_each(|route| draw_route(&mut svg, route));
    NODES.iter().for_each(|node| draw_node(&mut svg, node));
    svg += "</svg>\n";
    svg
}
