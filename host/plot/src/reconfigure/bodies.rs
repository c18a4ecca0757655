//! The bodies of `scene.svg`, painted from far to near: hulls, tools, empty slots, the executed path and the starts
//! that were left. The planned path and the numbers of the robots come last, over everything.

use plotters::style::{RGBColor, WHITE};

use super::solid::{Solid, Vec3, is_inside, painting_order};
use super::stage::{Stage, blend};
use super::step::{Rest, Resting};
use super::stroke::{self, Pattern};
use crate::lines::Point;
use crate::picture::DrawError;
use crate::style::{self, Anchor};

/// Colour of a robot in its slot.
pub const ARRIVED: RGBColor = style::GREEN;
/// Colour of a robot that is not in its slot.
pub const WAITING: RGBColor = style::VERMILION;
/// Colour of sensors and other special services.
pub const SENSOR: RGBColor = RGBColor(0xF0, 0xE4, 0x42);

/// What is painted from far to near.
enum Body<'r> {
    Robot(&'r Resting),
    Tool,
    Slot(usize),
    /// A stretch of an executed path: which path, and the number of its end.
    Path(usize, usize),
    /// Half a cross where a robot was; the last one stands out.
    Cross(Vec3, Vec3, bool),
}

/// Draws all bodies of one step.
pub fn draw(stage: &Stage<'_, '_>, rest: &Rest) -> Result<(), DrawError> {
    let mut bodies: Vec<(Body<'_>, Solid)> = Vec::new();
    bodies.extend(rest.robots.iter().map(|r| (Body::Robot(r), r.hull)));
    bodies.extend(rest.tools.iter().map(|&tool| (Body::Tool, tool)));
    // A slot in which a robot still waits for its own move is not shown.
    let taken = |slot: &Solid| {
        let near = |p: Vec3| (0..3).all(|k| (p[k] - slot.centre[k]).abs() < slot.half[k]);
        rest.robots.iter().any(|r| near(r.hull.centre))
    };
    let free = rest.slots.iter().filter(|(_, solid)| !taken(solid));
    bodies.extend(free.map(|&(n, solid)| (Body::Slot(n), solid)));
    for (way, path) in rest.ways.iter().map(|way| way.executed.as_slice()).enumerate() {
        let stretches = path.windows(2).enumerate();
        bodies.extend(stretches.map(|(n, ends)| (Body::Path(way, n + 1), Solid::stretch(ends[0], ends[1]))));
    }
    for (n, &[x, y, z]) in rest.left.iter().enumerate() {
        let arm_m = 0.11;
        for side in [-arm_m, arm_m] {
            let (a, b) = ([x - arm_m, y - side, z], [x + arm_m, y + side, z]);
            bodies.push((
                Body::Cross(a, b, n + rest.ways.len().max(1) >= rest.left.len()),
                Solid::stretch(a, b),
            ));
        }
    }
    let solids: Vec<Solid> = bodies.iter().map(|b| b.1).collect();
    let order = painting_order(&stage.view, &solids);
    // Stretches that follow each other are joined, so that corners are round.
    let mut joined: (usize, Vec<usize>) = (0, Vec::new());
    for &index in &order {
        let Some((body, solid)) = bodies.get(index) else { continue };
        if let Body::Path(way, end) = *body {
            let (same, ends) = (joined.0 == way, &mut joined.1);
            if same && ends.last().is_some_and(|&last| last + 1 == end) {
                ends.push(end);
                continue;
            }
            if same && ends.first().is_some_and(|&first| end + 1 == first) {
                ends.insert(0, end);
                continue;
            }
        }
        draw_path(stage, rest, &joined)?;
        joined.1.clear();
        match *body {
            Body::Path(way, end) => joined = (way, vec![end]),
            Body::Robot(robot) => draw_robot(stage, robot)?,
            Body::Tool => draw_tool(stage, solid)?,
            Body::Slot(n) => draw_slot(stage, solid, n)?,
            Body::Cross(a, b, is_new) => {
                let opacity = if is_new { 1.0 } else { 0.45 };
                stage.line(&[a, b], style::line(style::COLLISION_EDGE, opacity, 2.5))?;
            }
        }
    }
    draw_path(stage, rest, &joined)?;
    for way in &rest.ways {
        stage.line(&way.planned, style::line(style::INK, 0.7, 1.0))?;
    }
    // Last of all, so that no path crosses them.
    for (place, &index) in order.iter().enumerate() {
        if let Some((Body::Robot(robot), _)) = bodies.get(index) {
            let nearer = order.iter().skip(place + 1).filter_map(|&i| bodies.get(i));
            let covering = nearer.filter(|b| matches!(b.0, Body::Robot(_) | Body::Tool)).map(|b| b.1);
            draw_number(stage, robot, &covering.collect::<Vec<_>>())?;
        }
    }
    Ok(())
}

fn draw_path(stage: &Stage<'_, '_>, rest: &Rest, (way, ends): &(usize, Vec<usize>)) -> Result<(), DrawError> {
    let (Some(&first), Some(&last)) = (ends.first(), ends.last()) else { return Ok(()) };
    let path = rest.ways.get(*way).map_or(&[][..], |way| &way.executed);
    let points = path.get(first.saturating_sub(1)..=last).unwrap_or_default();
    stage.line(points, style::line(style::SKY, 1.0, 4.0))
}

fn draw_robot(stage: &Stage<'_, '_>, robot: &Resting) -> Result<(), DrawError> {
    let hull = &robot.hull;
    stage.hull(hull, if robot.arrived { ARRIVED } else { WAITING })?;
    let faces = hull.faces(&stage.view);
    let shows = |axis: usize, high: bool| faces[2 * axis + usize::from(!high)].is_seen;
    if robot.has_sensor {
        let square = |p: [Vec3; 4]| p.map(|share| hull.at(share));
        let colour = style::fill(SENSOR, 1.0);
        if shows(0, true) {
            let front = [[1.0, -0.5, -1.0], [1.0, 0.5, -1.0], [1.0, 0.5, 0.1], [1.0, -0.5, 0.1]];
            stage.polygon(&square(front), style::fill(blend(SENSOR, style::INK, 0.15), 1.0))?;
        }
        if shows(2, false) {
            let top = [[0.68, -0.5, -1.0], [1.0, -0.5, -1.0], [1.0, 0.5, -1.0], [0.68, 0.5, -1.0]];
            stage.polygon(&square(top), colour)?;
        }
    } else if shows(2, false) && stage.scale > 60.0 {
        // Forward.
        let bow = [[0.62, -0.45, -1.0], [0.86, 0.0, -1.0], [0.62, 0.45, -1.0]].map(|share| hull.at(share));
        stage.line(&bow, style::line(WHITE, 0.75, 1.25))?;
    }
    Ok(())
}

/// The number of a robot on the first face whose middle no nearer body covers: the top, or the side seen largest.
/// A robot that is quite hidden has it on top all the same.
fn draw_number(stage: &Stage<'_, '_>, robot: &Resting, covering: &[Solid]) -> Result<(), DrawError> {
    let hull = &robot.hull;
    let faces = hull.faces(&stage.view);
    let outlines: Vec<Vec<Vec<Point>>> = covering
        .iter()
        .map(|solid| {
            let seen = solid.faces(&stage.view).into_iter().filter(|f| f.is_seen);
            seen.map(|f| f.corners.map(|c| stage.at(c)).to_vec()).collect()
        })
        .collect();
    let size_px = (0.21 * stage.scale).clamp(9.0, 17.0);
    let is_free = |p: Vec3| {
        let (x, y) = stage.at(p);
        let reach = 0.4 * size_px;
        let around = [(0.0, 0.0), (-reach, 0.0), (reach, 0.0), (0.0, -reach), (0.0, reach)];
        let points = around.map(|(right, down)| (x + right, y + down));
        !outlines.iter().flatten().any(|face| points.iter().any(|&p| is_inside(face, p)))
    };
    let mut seen: Vec<usize> = [5, 4, 2, 3, 0, 1].into_iter().filter(|&f| faces[f].is_seen).collect();
    let area = |f: usize| stage.view.nearness(hull.axes[f / 2]).abs() / hull.half[f / 2].max(1e-9);
    seen.sort_by(|&a, &b| (b >= 4).cmp(&(a >= 4)).then(area(b).total_cmp(&area(a))));
    let middle = |f: usize| if f == 5 { hull.at([-0.08, 0.0, -1.0]) } else { faces[f].centre };
    let places: Vec<Vec3> = seen.into_iter().map(middle).collect();
    let free = places.iter().copied().find(|&p| is_free(p));
    let Some(at) = free.or_else(|| places.first().copied()) else { return Ok(()) };
    let look = style::bold(size_px, WHITE, Anchor::Middle);
    stage.text(&robot.id.to_string(), at, (0.0, 0.0), &look)
}

/// A ball in a glass box.
fn draw_tool(stage: &Stage<'_, '_>, solid: &Solid) -> Result<(), DrawError> {
    let glass = style::fill(style::HULL, 0.16);
    let faces = solid.faces(&stage.view);
    for face in faces.iter().filter(|f| !f.is_seen) {
        stage.polygon(&face.corners, glass)?;
    }
    let radius_px = 0.92 * solid.half.iter().copied().fold(f64::INFINITY, f64::min) * stage.scale;
    for n in 0..5 {
        let share = f64::from(n) / 5.0;
        let aside_px = -0.32 * share * radius_px;
        let colour = blend(style::HULL, WHITE, 0.6 * share * share);
        stage.disc(solid.centre, (aside_px, aside_px), radius_px * (1.0 - share), colour)?;
    }
    for face in faces.iter().filter(|f| f.is_seen) {
        stage.polygon(&face.corners, glass)?;
    }
    stage.edges(solid, style::line(style::HULL, 0.7, 1.0))
}

fn draw_slot(stage: &Stage<'_, '_>, solid: &Solid, number_of_slot: usize) -> Result<(), DrawError> {
    for face in solid.faces(&stage.view).iter().filter(|f| f.is_seen) {
        stage.polygon(&face.corners, style::fill(WHITE, 0.35))?;
    }
    stage.edges(solid, style::line(stroke::marked(style::MUTED, Pattern::Dashed), 1.0, 1.0))?;
    let size_px = (0.15 * stage.scale).clamp(8.5, 12.0);
    let look = style::text(size_px, style::MUTED, Anchor::Middle);
    let top = solid.faces(&stage.view)[5].centre;
    stage.text(&(number_of_slot + 1).to_string(), top, (0.0, 0.0), &look)
}
