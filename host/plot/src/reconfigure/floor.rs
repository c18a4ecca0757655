//! The floor of `scene.svg`: its grid, the clearance (19) of a move, and the outlines of what is above it.

use std::f64::consts::TAU;

use plotters::style::{RGBColor, ShapeStyle};

use super::solid::{Vec3, View};
use super::stage::Stage;
use super::step::Rest;
use super::stroke::{self, Pattern};
use crate::axis::extent;
use crate::lines::{Point, Window, clip_polygon, clip_segment};
use crate::picture::DrawError;
use crate::style;

/// Colour of the area that a mover must keep out of.
pub const KEEP_OUT: RGBColor = RGBColor(0xF3, 0xE6, 0xEE);
/// Distance of the lines on the floor, m.
pub const GRID_M: f64 = 0.5;

/// The floor of a scene, and the part of the world that is shown.
pub struct World {
    /// What is seen, north and east.
    pub floor: Window,
    /// How deep the floor lies, m.
    pub depth_m: f64,
    /// From where it is seen.
    pub view: View,
    /// Corners of what is seen (right, up), m.
    pub seen: Window,
}

/// A circle (north, east), closed.
fn circle(centre: Vec3, radius_m: f64) -> Vec<Point> {
    (0..=72)
        .map(|n| (f64::from(n) / 72.0 * TAU).sin_cos())
        .map(|(sin, cos)| (centre[0] + radius_m * cos, centre[1] + radius_m * sin))
        .collect()
}

/// What of a circle lies on the floor.
fn draw_arcs(
    stage: &Stage<'_, '_>,
    world: &World,
    circle: &[Point],
    line: ShapeStyle,
) -> Result<(), DrawError> {
    let onto = |p: Point| [p.0, p.1, world.depth_m];
    let mut arc: Vec<Vec3> = Vec::new();
    for ends in circle.windows(2) {
        match clip_segment(world.floor, ends[0], ends[1]) {
            Some((a, b)) => {
                if arc.last() != Some(&onto(a)) {
                    stage.line(&std::mem::take(&mut arc), line)?;
                    arc.push(onto(a));
                }
                arc.push(onto(b));
            }
            None => stage.line(&std::mem::take(&mut arc), line)?,
        }
    }
    stage.line(&arc, line)
}

/// Draws the floor and what lies on it.
pub fn draw(stage: &Stage<'_, '_>, world: &World, rest: &Rest) -> Result<(), DrawError> {
    let Window { x: north, y: east } = world.floor;
    let at = |n: f64, e: f64| [n, e, world.depth_m];
    let rim = [at(north.0, east.0), at(north.1, east.0), at(north.1, east.1), at(north.0, east.1)];
    stage.polygon(&rim, style::fill(RGBColor(0xFA, 0xFB, 0xFC), 1.0))?;
    if let Some(way) = rest.ways.first() {
        let moves = |n: usize| rest.ways.iter().any(|way| way.robot == n);
        let resting = rest.robots.iter().enumerate().filter(|(n, _)| !moves(*n)).map(|(_, r)| r.hull);
        let circles: Vec<Vec<Point>> = resting
            .chain(rest.tools.iter().copied())
            .map(|hull| circle(hull.centre, way.clearance_m))
            .collect();
        // First every edge, then every area: what is left of the edges goes around them all.
        for circle in &circles {
            draw_arcs(stage, world, circle, style::line(style::PURPLE, 0.8, 2.0))?;
        }
        for circle in &circles {
            let disc: Vec<Vec3> =
                clip_polygon(world.floor, circle).into_iter().map(|(n, e)| at(n, e)).collect();
            stage.polygon(&disc, style::fill(KEEP_OUT, 1.0))?;
        }
    }
    let lines = |(from, to): (f64, f64)| {
        let first = (from / GRID_M).ceil() as i64;
        let last = ((to / GRID_M).floor() as i64).min(first + 200);
        (first..=last).map(|n| n as f64 * GRID_M)
    };
    let faint = style::line(style::FRAME, 0.45, 0.75);
    for n in lines(north) {
        stage.line(&[at(n, east.0), at(n, east.1)], faint)?;
    }
    for e in lines(east) {
        stage.line(&[at(north.0, e), at(north.1, e)], faint)?;
    }
    stage.ring(&rim, style::line(style::FRAME, 1.0, 1.0))?;
    for way in &rest.ways {
        for end in way.ends {
            let dashed = style::line(stroke::marked(style::PURPLE, Pattern::Dashed), 1.0, 1.0);
            draw_arcs(stage, world, &circle(end, way.clearance_m), dashed)?;
        }
    }
    draw_shadows(stage, world, rest)
}

/// Outlines on the floor of what is above it.
fn draw_shadows(stage: &Stage<'_, '_>, world: &World, rest: &Rest) -> Result<(), DrawError> {
    let onto = |p: Vec3| [p[0], p[1], world.depth_m];
    let hulls = rest.robots.iter().map(|r| r.hull).chain(rest.tools.iter().copied());
    for hull in hulls.filter(|h| h.at([0.0, 0.0, 1.0])[2] < world.depth_m - 0.02) {
        let foot = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| hull.at([a, b, 1.0]));
        stage.polygon(&foot.map(onto), style::fill(style::DEMAND, 0.16))?;
        for corner in foot {
            stage.line(&[corner, onto(corner)], style::line(style::MUTED, 0.35, 0.75))?;
        }
    }
    for way in &rest.ways {
        let depths = extent(way.executed.iter().chain(&way.planned).map(|p| p[2]));
        if depths.is_none_or(|(high, low)| low - high <= 0.05) {
            continue;
        }
        let path = if way.executed.is_empty() { &way.planned } else { &way.executed };
        let shadow: Vec<Vec3> = path.iter().copied().map(onto).collect();
        stage.line(&shadow, style::line(style::DEMAND, 0.25, 2.5))?;
        for &corner in way.planned.iter() {
            stage.line(&[corner, onto(corner)], style::line(style::MUTED, 0.55, 0.75))?;
        }
    }
    Ok(())
}
