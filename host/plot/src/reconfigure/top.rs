//! `top.svg`: all paths of a plan from above, north up, with the order of the moves in words, after the paper's Fig. 7b.

use plotters::style::RGBColor;
use reconfiguration::plan::destination;
use record::reconfigure::Record;

use super::executed_move;
use super::solid::{Solid, Vec3};
use super::step::{Rest, Resting, from_above, rests};
use super::stroke::{self, Pattern, Sign};
use crate::axis::{Axis, extent, number};
use crate::lines::Point;
use crate::picture::{self, Area, Chart, DrawError, Panel};
use crate::style::{self, Anchor};

/// Greatest height of a chart, px.
const HIGHEST: f64 = 640.0;
/// Greatest width of a chart with its axes, px.
const MOST_WIDE: f64 = 720.0;
/// Space around what is shown, m.
const AIR_M: f64 = 0.15;

/// Draws the picture of the paths seen from above, as SVG.
pub fn svg(records: &[Record]) -> Result<String, DrawError> {
    let all: Vec<Vec<Rest>> = records.iter().map(rests).collect();
    let (width, _) = picture::body_size((picture::WIDE, 0.0));
    let count = records.len().max(1);
    let each_px = (width / count as f64).min(MOST_WIDE);
    let (east, north) = bounds(&all);
    let chart_px = picture::chart_width(each_px);
    let chart_height = (chart_px * (north.1 - north.0) / (east.1 - east.0)).clamp(220.0, HIGHEST);
    let legend = [
        (Sign::Line(style::MUTED, Pattern::Solid, 1.0, 3.0), "path executed".to_owned()),
        (Sign::Line(style::INK, Pattern::Solid, 0.8, 1.0), "planned".to_owned()),
        (
            Sign::Box(style::MUTED, 0.0, Some((style::MUTED, Pattern::Dotted))),
            "start, with the robot's number; the upper of two first".to_owned(),
        ),
        (Sign::Box(style::MUTED, 0.4, None), "robot at the end".to_owned()),
        (Sign::Disc(style::HULL), "tool".to_owned()),
    ];
    let moves = all.iter().map(|rests| rests.iter().map(|rest| rest.ways.len()).sum()).max().unwrap_or(0);
    let list_px = stroke::LEGEND_ROW * moves as f64 + 16.0;
    let panel_px = chart_height + picture::around(false, true);
    let height = panel_px + list_px;
    stroke::render(records, "paths from above", picture::WIDE, height, &legend, |area, legend_px| {
        for (n, (record, rests)) in records.iter().zip(&all).enumerate() {
            let corner = (style::px(each_px * n as f64), style::px(legend_px));
            let cell = area.clone().shrink(corner, (style::px(each_px), style::px(panel_px + list_px)));
            let (panel, list) = cell.split_vertically(style::px(panel_px));
            draw_map(&panel, record, rests, (east, north), chart_height)?;
            draw_list(&list, rests)?;
        }
        Ok(())
    })
}

/// East and north of everything.
fn bounds(all: &[Vec<Rest>]) -> (Point, Point) {
    let hulls = all.iter().flatten().flat_map(|rest| {
        let robots = rest.robots.iter().map(|r| r.hull);
        let all = robots.chain(rest.tools.iter().copied()).chain(rest.slots.iter().map(|s| s.1));
        all.flat_map(|hull| hull.corners())
    });
    let paths = all.iter().flatten().flat_map(|rest| &rest.ways);
    let paths = paths.flat_map(|way| way.planned.iter().chain(&way.executed).copied());
    let points: Vec<Vec3> = hulls.chain(paths).collect();
    let along = |axis: usize| {
        let (low, high) = extent(points.iter().map(|p| p[axis])).unwrap_or((-0.5, 0.5));
        (low - AIR_M, high + AIR_M)
    };
    (along(1), along(0))
}

/// The outline of a hull from above (east, north).
fn foot(hull: &Solid) -> Vec<Point> {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
    corners.map(|(a, b)| hull.at([a, b, 0.0])).map(|p| (p[1], p[0])).to_vec()
}

fn draw_map(
    area: &Area<'_>,
    record: &Record,
    rests: &[Rest],
    (east, north): (Point, Point),
    height_px: f64,
) -> Result<(), DrawError> {
    let (width, _) = picture::area_size(area);
    let width_px = picture::chart_width(width);
    // Equal axes: the tighter direction sets the scale.
    let scale = (width_px / (east.1 - east.0)).min(height_px / (north.1 - north.0));
    let around = |(low, high): Point, px: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * px / scale);
        (middle - half, middle + half)
    };
    let (east, north) = (around(east, width_px), around(north, height_px));
    let plan = &record.plan;
    let total = number(plan.energy_total_j, 1);
    let title =
        format!("{}: {total} J in {} s as planned", executed_move::label(plan), number(plan.time_s, 1));
    let tick_m = 60.0 / scale;
    let panel = Panel {
        x_title: Some("East, m"),
        y_title: Some("North, m"),
        ..Panel::new(&title, Axis::spaced(east.0, east.1, tick_m), Axis::spaced(north.0, north.1, tick_m))
    };
    let chart = Chart::new(area, &panel)?;
    let (Some(start), Some(end)) = (rests.first(), rests.last()) else { return Ok(()) };
    let size_px = (0.16 * scale).clamp(8.5, 14.0);
    for robot in &start.robots {
        let dotted = style::line(stroke::marked(style::MUTED, Pattern::Dotted), 1.0, 1.25);
        chart.line(foot(&robot.hull), dotted)?;
    }
    // The deepest first; a tool over the robot under it.
    let robots = end.robots.iter().enumerate().filter(|(_, r)| r.arrived);
    let mut bodies: Vec<(&Solid, Option<usize>)> = robots.map(|(n, r)| (&r.hull, Some(n))).collect();
    bodies.extend(end.tools.iter().map(|tool| (tool, None)));
    bodies.sort_by(|a, b| b.0.centre[2].total_cmp(&a.0.centre[2]));
    for (hull, robot) in bodies {
        let (colour, opacity) = robot.map_or((style::HULL, 0.18), |n| (style::module_colour(n), 0.4));
        chart.polygon(foot(hull), style::fill(colour, opacity))?;
        chart.line(foot(hull), style::line(colour, 1.0, 1.25))?;
        if robot.is_none() {
            chart.dot((hull.centre[1], hull.centre[0]), 0.5 * hull.half[1] * scale, colour)?;
        }
    }
    for way in rests.iter().flat_map(|rest| &rest.ways) {
        let colour = style::module_colour(way.robot);
        chart.line(from_above(&way.executed), style::line(colour, 0.85, 3.0))?;
        chart.line(from_above(&way.planned), style::line(style::INK, 0.75, 1.0))?;
    }
    for (robots, colour) in [(&start.robots, style::MUTED), (&end.robots, style::INK)] {
        let look = style::bold(size_px, colour, Anchor::Middle);
        let shown: Vec<&Resting> = robots.iter().filter(|r| r.arrived || colour == style::MUTED).collect();
        for (ids, hull) in stacks(&shown) {
            // Beside the middle, where the path ends.
            let at = hull.at([-0.62, 0.55, 0.0]);
            chart.text(&ids, (at[1], at[0]), (0.0, 0.0), &look)?;
        }
    }
    Ok(())
}

/// Robots that lie over each other, seen from above: their numbers, the upper first, and the upper hull.
fn stacks(robots: &[&Resting]) -> Vec<(String, Solid)> {
    let mut robots = robots.to_vec();
    robots.sort_by(|a, b| a.hull.centre[2].total_cmp(&b.hull.centre[2]));
    let mut stacks: Vec<(String, Solid)> = Vec::new();
    for robot in robots {
        let [x, y, _] = robot.hull.centre;
        let is_here = |hull: &Solid| (hull.centre[0] - x).hypot(hull.centre[1] - y) < 0.5 * hull.half[1];
        match stacks.iter_mut().find(|(_, hull)| is_here(hull)) {
            Some((ids, _)) => *ids += &format!("/{}", robot.id),
            None => stacks.push((robot.id.to_string(), robot.hull)),
        }
    }
    stacks
}

/// The moves in order.
fn draw_list(area: &Area<'_>, rests: &[Rest]) -> Result<(), DrawError> {
    let (width, _) = picture::area_size(area);
    let ways = rests.iter().flat_map(|rest| rest.ways.iter().map(move |way| (rest, way)));
    for (n, (rest, way)) in ways.enumerate() {
        let id = rest.robots.get(way.robot).map_or(0, |r| r.id);
        let (to, seconds, joules) =
            (destination(way.slot), number(way.duration_s, 1), number(way.energy_j, 1));
        let text = format!("{}. robot {id} to {to}: {seconds} s, {joules} J", n + 1);
        let colour: RGBColor = style::module_colour(way.robot);
        let entry = [(Sign::Line(colour, Pattern::Solid, 0.85, 3.0), text)];
        let top = 8.0 + stroke::LEGEND_ROW * n as f64;
        stroke::legend(area, (picture::LEFT, top), width - picture::LEFT, &entry)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconfigure::sample;

    #[test]
    fn robots_over_each_other_share_a_label() {
        let mut robots = rests(&sample::far()[0])[0].robots.clone();
        assert_eq!(stacks(&robots.iter().collect::<Vec<_>>()).len(), robots.len());
        // The last one dives under the first, the second rises over it.
        let [x, y, z] = robots[0].hull.centre;
        (robots[3].hull.centre, robots[1].hull.centre) = ([x + 0.01, y, z + 0.267], [x, y, z - 0.267]);
        let ids = |n: usize| robots[n].id;
        let labels = stacks(&robots.iter().collect::<Vec<_>>());
        let expected = format!("{}/{}/{}", ids(1), ids(0), ids(3));
        assert_eq!((labels.len(), labels[0].0.as_str()), (2, expected.as_str()));
    }
}
