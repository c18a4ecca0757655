//! `scene.svg`: the cluster in three dimensions at the start and after each move, after the paper's Fig. 3.
//!
//! One row (or more, five pictures each) a record. A parallel projection looks along the world's shorter side and down;
//! everything is painted from far to near ([`super::solid`]). The floor lies under the deepest hull, with a grid of half
//! a metre; hulls above it throw their outline on it. On the floor stands the clearance (19): the discs of radius
//! d = 1.5·max(L, W, H) about the resting modules, and with dashes those about the mover's start and slot, within which
//! hulls may come nearer and touch.

use reconfiguration::plan::destination;
use std::f64::consts::TAU;

use plotters::element::PathElement;
use plotters::style::{RGBColor, WHITE};
use record::reconfigure::Record;

use super::bodies::{self, ARRIVED, SENSOR, WAITING};
use super::executed_move;
use super::floor::{self, GRID_M, KEEP_OUT, World};
use super::solid::{Vec3, View};
use super::stage::Stage;
use super::step::{Rest, Way, rests};
use super::stroke::{self, Pattern, Sign};
use crate::axis::{extent, number};
use crate::lines::{Point, Window};
use crate::picture::{self, Area, DrawError};
use crate::style::{self, Anchor};

/// Width of the picture, px.
const WIDTH: f64 = 1600.0;
/// Most pictures in a row.
const MOST: usize = 5;
/// Height of the line over the pictures of a record, px.
const TITLE: f64 = 30.0;
/// Height of the words over one picture, px.
const CAPTION: f64 = 24.0;
/// Greatest height of one picture, px.
const HIGHEST: f64 = 460.0;
/// How far the view looks down, rad.
const ELEVATION_RAD: f64 = 0.68;
/// How far it is turned from looking along an axis, rad.
const ASIDE_RAD: f64 = 0.62;
/// Floor around everything, m.
const AIR_M: f64 = 0.1;

/// Draws the picture of the reconfiguration step by step, as SVG.
pub fn svg(records: &[Record]) -> Result<String, DrawError> {
    let rows: Vec<Vec<Rest>> = records.iter().map(rests).collect();
    let world = world(&rows);
    let (width, _) = picture::body_size((WIDTH, 0.0));
    let most = rows.iter().map(Vec::len).max().unwrap_or(1).clamp(1, MOST);
    let cell_px = (width - 20.0) / most as f64;
    let across = world.seen.x.1 - world.seen.x.0;
    let up = world.seen.y.1 - world.seen.y.0;
    let scale = ((cell_px - 14.0) / across).min(HIGHEST / up);
    let cell_height = CAPTION + scale * up + 12.0;
    let legend = legend(&rows);
    let row_px = |rests: &Vec<Rest>| TITLE + cell_height * rests.len().div_ceil(MOST) as f64;
    let height = rows.iter().map(row_px).sum::<f64>();
    let svg =
        stroke::render(records, "reconfiguration in steps", WIDTH, height, &legend, |area, legend_px| {
            let mut top = legend_px;
            for (record, rests) in records.iter().zip(&rows) {
                draw_title(area, top, record)?;
                for (n, rest) in rests.iter().enumerate() {
                    let left = 10.0 + cell_px * (n % MOST) as f64;
                    let down = top + TITLE + cell_height * (n / MOST) as f64;
                    let cell = area.clone().shrink(
                        (style::px(left), style::px(down)),
                        (style::px(cell_px), style::px(cell_height)),
                    );
                    draw_caption(&cell, n, rest)?;
                    let middle = 0.5 * (world.seen.x.0 + world.seen.x.1);
                    let origin = (0.5 * cell_px - scale * middle, CAPTION + scale * world.seen.y.1);
                    let stage = Stage { area: &cell, view: world.view, scale, origin };
                    floor::draw(&stage, &world, rest)?;
                    bodies::draw(&stage, rest)?;
                    if n == 0 {
                        draw_triad(&cell, &world.view, (34.0, cell_height - 34.0))?;
                    }
                }
                top += row_px(rests);
            }
            Ok(())
        })?;
    // Stretches of a path are painted apart: round ends close the joints.
    let RGBColor(r, g, b) = style::SKY;
    let sky = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
    Ok(svg.replace(&sky, &format!("{sky} stroke-linecap=\"round\"")))
}

/// What every picture shows.
fn world(rows: &[Vec<Rest>]) -> World {
    let all = || rows.iter().flatten();
    let bodies = || {
        all().flat_map(|rest| {
            let robots = rest.robots.iter().map(|r| r.hull);
            robots.chain(rest.tools.iter().copied()).chain(rest.slots.iter().map(|s| s.1))
        })
    };
    let on_the_way = all().flat_map(|r| &r.ways).flat_map(|way| {
        let half = bodies().next().map_or([0.0; 3], |b| b.half);
        let path = way.planned.iter().chain(&way.executed).copied();
        path.flat_map(move |p| [-1.0, 1.0].map(|s: f64| std::array::from_fn(|k| p[k] + s * half[k])))
    });
    let points: Vec<Vec3> = bodies().flat_map(|b| b.corners()).chain(on_the_way).collect();
    let along = |axis: usize| extent(points.iter().map(|p| p[axis])).unwrap_or((-0.5, 0.5));
    let (north, east, down) = (along(0), along(1), along(2));
    let floor = Window { x: (north.0 - AIR_M, north.1 + AIR_M), y: (east.0 - AIR_M, east.1 + AIR_M) };
    let is_long = north.1 - north.0 > east.1 - east.0;
    // The longer side runs to the right.
    let azimuth_rad = if is_long { 0.75 * TAU + ASIDE_RAD } else { TAU - ASIDE_RAD };
    let view = View::new(azimuth_rad, ELEVATION_RAD);
    let (n0, n1, e0, e1) = (floor.x.0, floor.x.1, floor.y.0, floor.y.1);
    let rim = [[n0, e0, down.1], [n1, e0, down.1], [n1, e1, down.1], [n0, e1, down.1]];
    let seen: Vec<Point> = points.iter().chain(&rim).map(|&p| view.project(p)).collect();
    let side = |pick: fn(&Point) -> f64| extent(seen.iter().map(pick)).unwrap_or((-0.5, 0.5));
    World { floor, depth_m: down.1, view, seen: Window { x: side(|p| p.0), y: side(|p| p.1) } }
}

fn legend(rows: &[Vec<Rest>]) -> Vec<(Sign, String)> {
    let mut legend = vec![
        (Sign::Box(WAITING, 1.0, None), "robot before its move".to_owned()),
        (Sign::Box(ARRIVED, 1.0, None), "robot in its slot".to_owned()),
        (Sign::Box(WHITE, 1.0, Some((style::MUTED, Pattern::Dashed))), "empty slot, its number".to_owned()),
    ];
    let start = rows.first().and_then(|rests| rests.first());
    if start.is_some_and(|rest| !rest.tools.is_empty()) {
        legend.push((Sign::Disc(style::HULL), "tool".to_owned()));
    }
    if start.is_some_and(|rest| rest.robots.iter().any(|r| r.has_sensor)) {
        legend.push((Sign::Box(SENSOR, 1.0, None), "sensor".to_owned()));
    }
    legend.push((Sign::Cross(style::COLLISION_EDGE), "start left".to_owned()));
    legend.push((Sign::Line(style::SKY, Pattern::Solid, 1.0, 4.0), "path executed".to_owned()));
    legend.push((Sign::Line(style::INK, Pattern::Solid, 0.8, 1.0), "planned".to_owned()));
    let mut ways = rows.iter().flatten().flat_map(|rest| &rest.ways);
    if let Some(clearance_m) = ways.next().map(|way| way.clearance_m) {
        let clearance = format!("clearance (19), {} m", number(clearance_m, 2));
        legend.push((Sign::Box(KEEP_OUT, 1.0, Some((style::PURPLE, Pattern::Solid))), clearance));
        let zone = Sign::Box(WHITE, 1.0, Some((style::PURPLE, Pattern::Dashed)));
        legend.push((zone, "as far from the mover's start and slot".to_owned()));
    }
    legend
}

fn draw_title(area: &Area<'_>, top: f64, record: &Record) -> Result<(), DrawError> {
    let plan = &record.plan;
    let y = style::px(top + 0.5 * TITLE);
    let label = executed_move::label(plan);
    let bold = style::bold(style::SIZE_PANEL + 1.5, style::INK, Anchor::Start);
    area.draw_text(label, &bold, (style::px(13.0), y))?;
    let figures = format!(
        "planned {} J to navigate + {} J to balance = {} J in {} s",
        number(plan.energy_navigate_j, 1),
        number(plan.energy_balance_j, 1),
        number(plan.energy_total_j, 1),
        number(plan.time_s, 1),
    );
    let executed = executed_move::cumulated_j(record.samples.iter());
    let executed = match (executed.first(), executed.last()) {
        (Some(first), Some(last)) => {
            format!(", executed {} J in {} s", number(last.1, 1), number(last.0 - first.0, 1))
        }
        _ => String::new(),
    };
    let muted = style::text(style::SIZE_TEXT, style::MUTED, Anchor::Start);
    let left = 13.0 + 1.12 * style::text_width(label, style::SIZE_PANEL + 1.5) + 14.0;
    area.draw_text(&format!("{figures}{executed}"), &muted, (style::px(left), y))
}

fn draw_caption(cell: &Area<'_>, number_of_moves: usize, rest: &Rest) -> Result<(), DrawError> {
    let text = match rest.ways.as_slice() {
        [] => format!("start; grid of {} m", number(GRID_M, 1)),
        [way] => {
            let id = rest.robots.get(way.robot).map_or(0, |r| r.id);
            let (to, seconds, joules) =
                (destination(way.slot), number(way.duration_s, 1), number(way.energy_j, 1));
            format!("{number_of_moves}. robot {id} to {to}: {seconds} s, {joules} J")
        }
        together => {
            let id = |way: &Way| rest.robots.get(way.robot).map_or(0, |r| r.id);
            let each = together.iter().map(|way| format!("{} to {}", id(way), destination(way.slot)));
            format!("{number_of_moves}. together, robots {}", each.collect::<Vec<_>>().join(", "))
        }
    };
    let (width, _) = picture::area_size(cell);
    let text = style::fit(&text, style::SIZE_TEXT, width - 8.0);
    let ink = style::text(style::SIZE_TEXT, style::INK, Anchor::Start);
    cell.draw_text(&text, &ink, (style::px(3.0), style::px(0.5 * CAPTION)))
}

/// The world's axes as arrows from a point (right, down) in px: north, east, down.
fn draw_triad(cell: &Area<'_>, view: &View, (x, y): Point) -> Result<(), DrawError> {
    let stage = Stage { area: cell, view: *view, scale: 26.0, origin: (x, y) };
    for (name, axis) in [("N", [1.0, 0.0, 0.0]), ("E", [0.0, 1.0, 0.0]), ("D", [0.0, 0.0, 1.0])] {
        let tip = stage.at(axis);
        let (dx, dy) = (tip.0 - x, tip.1 - y);
        let length = dx.hypot(dy).max(1e-6);
        let (dx, dy) = (dx / length, dy / length);
        stage.line(&[[0.0; 3], axis], style::line(style::INK, 1.0, 1.5))?;
        for side in [-1.0, 1.0] {
            let barb = (tip.0 - 5.0 * dx + 2.8 * side * dy, tip.1 - 5.0 * dy - 2.8 * side * dx);
            let ends = [tip, barb].map(|p| (style::px(p.0), style::px(p.1)));
            let line = style::line(style::INK, 1.0, 1.5);
            cell.draw(&PathElement::new(ends.to_vec(), line))?;
        }
        let look = style::bold(style::SIZE_TICK, style::INK, Anchor::Middle);
        stage.text(name, axis, (8.0 * dx, 8.0 * dy), &look)?;
    }
    Ok(())
}
