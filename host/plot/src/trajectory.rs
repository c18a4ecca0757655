//! `trajectory.svg`: path, velocity and heading of the structure; after the paper's Fig. 6.
//!
//! A map with equal axes shows the path of the centre of mass, the demanded course of each leg from where the
//! structure was when the leg began, and the structure itself at equal times. Three panels show both components
//! of the velocity and the heading against their demands. The structure swims in strokes, so beside the velocity
//! itself stands its mean over one cycle, which is what the demand is about.

use record::{PoseSample, RunRecord};

use quantity::wrap_rad;

use super::axis::{Axis, extent, number};
use super::lines::{self, Point};
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style::{self, Anchor};

/// Width of the picture, px.
const WIDTH: f64 = 1200.0;
/// Height of the body when map and panels stand side by side, px.
const BESIDE: f64 = 700.0;
/// Height of the panels under a wide map, px.
const PANELS: f64 = 320.0;
/// Least space between what a map shows and its frame, px.
const MAP_AIR: f64 = 26.0;
/// Half width of the band about the demanded velocity, of its magnitude.
const VELOCITY_BAND: f64 = 0.05;
/// Opacity of these bands.
const BAND_OPACITY: f64 = 0.12;
/// Half width of the band about the demanded heading, rad.
const HEADING_BAND_RAD: f64 = 0.15;

/// Draws the picture of the structure's trajectory, as SVG.
pub fn svg(record: &RunRecord) -> Result<String, DrawError> {
    let poses: Vec<PoseSample> = finite(&record.poses).copied().collect();
    let bounds = bounds(record, &poses);
    let (across, up) = (bounds.0.1 - bounds.0.0, bounds.1.1 - bounds.1.0);
    let is_wide = across > 1.7 * up;
    let (body_width, _) = picture::body_size((WIDTH, 0.0));
    // A wide map gets the height that its own shape asks for.
    let room_px = picture::chart_width(body_width) - 2.0 * MAP_AIR;
    let chart_height = (room_px * up / across + 2.0 * MAP_AIR).clamp(190.0, 440.0);
    let map_height = chart_height + picture::around(false, true);
    let body_height = if is_wide { map_height + PANELS } else { BESIDE };
    let heading = Heading { name: &record.name, subject: "trajectory", line: record.description.clone() };
    picture::render((WIDTH, picture::height_for(body_height)), &heading, |area| {
        if is_wide {
            let (top, below) = area.split_vertically(style::px(map_height));
            map(&top, record, &poses, bounds)?;
            let panels = below.split_evenly((1, 3));
            history(&panels, record, &poses, true)
        } else {
            let (left, right) = area.split_horizontally(style::px(660.0));
            map(&left, record, &poses, bounds)?;
            let panels = picture::stacked(&right, 3);
            history(&panels, record, &poses, false)
        }
    })
}

/// Those with finite numbers.
pub(super) fn finite(poses: &[PoseSample]) -> impl Iterator<Item = &PoseSample> {
    let is_finite = |p: &&PoseSample| {
        [p.t_s, p.position_m[0], p.position_m[1], p.heading_rad].iter().all(|v| v.is_finite())
    };
    poses.iter().filter(is_finite)
}

fn is_finite(at: [f64; 2]) -> bool {
    at.iter().all(|coordinate| coordinate.is_finite())
}

/// Where each leg began, and where its demand alone would have led.
pub(super) fn courses(record: &RunRecord, poses: &[PoseSample]) -> Vec<[Point; 2]> {
    record
        .legs
        .iter()
        .filter_map(|leg| {
            let start = poses.iter().find(|p| p.t_s >= leg.start_s - 1e-9)?;
            let duration_s = leg.end_s - leg.start_s;
            let [x, y] = start.position_m;
            // On the way to a station, the demand is the line to it.
            if let Some(station_m) = leg.station_m {
                return is_finite(station_m).then_some([(x, y), (station_m[0], station_m[1])]);
            }
            let end = (x + leg.velocity_m_s[0] * duration_s, y + leg.velocity_m_s[1] * duration_s);
            is_finite(end.into()).then_some([(x, y), end])
        })
        .collect()
}

/// Distance from the centre of mass to the furthest corner of a module, m.
fn reach_m(record: &RunRecord) -> f64 {
    let half_m = 0.5 * record.parameters.pitch_m;
    let furthest =
        extent(record.positions_m.iter().map(|p| (p[0].abs() + half_m).hypot(p[1].abs() + half_m)));
    furthest.map_or(half_m, |(_, far)| far)
}

/// What the map must show, m.
fn bounds(record: &RunRecord, poses: &[PoseSample]) -> (Point, Point) {
    let reach = reach_m(record) + 0.5 * record.parameters.pitch_m;
    let courses = courses(record, poses);
    let along = |axis: usize| {
        let pick = move |p: &Point| if axis == 0 { p.0 } else { p.1 };
        let been = poses.iter().flat_map(move |p| [p.position_m[axis] - reach, p.position_m[axis] + reach]);
        let meant = courses.iter().flatten().map(pick);
        extent(been.chain(meant)).unwrap_or((-1.0, 1.0))
    };
    (along(0), along(1))
}

fn map(
    area: &Area<'_>,
    record: &RunRecord,
    poses: &[PoseSample],
    bounds: (Point, Point),
) -> Result<(), DrawError> {
    let every_s = ghost_interval_s(record, poses);
    let ghosts = ghosts(poses, every_s);
    let title = if ghosts.len() > 2 {
        format!("Structure every {} s", number(every_s, 0))
    } else {
        "Structure".to_owned()
    };
    let mut legend = vec![
        (Key::Line(style::ORANGE, 1.0, 2.5), "centre of mass"),
        (Key::Dashed(style::DEMAND), "demand"),
        (Key::Ring(style::INK), "start"),
        (Key::Dot(style::INK), "end"),
    ];
    let stations = record.legs.iter().filter_map(|leg| leg.station_m).filter(|&at| is_finite(at));
    let stations: Vec<Point> = stations.map(|[x, y]| (x, y)).collect();
    if !stations.is_empty() {
        legend.push((Key::Ring(style::DEMAND), "station"));
    }
    let (panel, m_per_px) = Panel::map(&title, area, bounds, MAP_AIR);
    let chart = Chart::new(area, &Panel { legend: &legend, ..panel })?;

    for (n, pose) in ghosts.iter().enumerate() {
        // The past fades: the first is the palest.
        let age = (n + 1) as f64 / ghosts.len() as f64;
        draw_structure(&chart, record, pose, 0.08 + 0.20 * age, n + 1 == ghosts.len())?;
    }
    for [from, to] in courses(record, poses) {
        chart.dashed(&[from, to], style::line(style::DEMAND, 1.0, 1.5))?;
    }
    for &station in &stations {
        chart.ring(station, 9.0, style::DEMAND)?;
    }
    let path: Vec<Point> = poses.iter().map(|p| (p.position_m[0], p.position_m[1])).collect();
    for piece in record.pieces(poses, |pose| pose.t_s) {
        let path: Vec<Point> = piece.iter().map(|p| (p.position_m[0], p.position_m[1])).collect();
        chart.line(lines::thin_path(&path, 0.6 * m_per_px), style::line(style::ORANGE, 1.0, 2.5))?;
    }
    for pose in &ghosts {
        draw_surge_arrow(&chart, record, pose, m_per_px)?;
    }
    if let (Some(&first), Some(&last)) = (path.first(), path.last()) {
        chart.ring(first, 5.0, style::INK)?;
        chart.dot(last, 4.0, style::INK)?;
    }
    Ok(())
}

/// A round time step that shows the structure some two to twelve times, and not on top of itself.
fn ghost_interval_s(record: &RunRecord, poses: &[PoseSample]) -> f64 {
    const STEPS_S: [f64; 12] = [1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0, 100.0, 120.0, 300.0, 600.0];
    let (Some(first), Some(last)) = (poses.first(), poses.last()) else { return 1.0 };
    let length_m: f64 = poses
        .windows(2)
        .map(|w| match w {
            [a, b] => (b.position_m[0] - a.position_m[0]).hypot(b.position_m[1] - a.position_m[1]),
            _ => 0.0,
        })
        .sum();
    let copies = (length_m / (1.7 * reach_m(record))).clamp(1.0, 11.0);
    let least_s = (last.t_s - first.t_s) / copies;
    STEPS_S.into_iter().find(|&s| s >= least_s).unwrap_or((least_s / 600.0).ceil() * 600.0)
}

/// The poses at which the structure is shown: every `every_s` seconds, and the last one.
fn ghosts(poses: &[PoseSample], every_s: f64) -> Vec<PoseSample> {
    let Some(last) = poses.last() else { return Vec::new() };
    let mut next_s = f64::NEG_INFINITY;
    let mut shown = Vec::new();
    for pose in poses {
        // The last pose is always shown; one that would almost coincide with it is not.
        if pose.t_s >= next_s && (shown.is_empty() || last.t_s - pose.t_s > 0.6 * every_s) {
            shown.push(*pose);
            next_s = pose.t_s + every_s;
        }
    }
    if poses.len() > 1 {
        shown.push(*last);
    }
    shown
}

/// From the structure frame S into the world: x_S = (sin Θ, −cos Θ), y_S = (cos Θ, sin Θ).
fn to_world(pose: &PoseSample, [x_m, y_m]: [f64; 2]) -> Point {
    let (sin, cos) = pose.heading_rad.sin_cos();
    (pose.position_m[0] + x_m * sin + y_m * cos, pose.position_m[1] - x_m * cos + y_m * sin)
}

fn draw_structure(
    chart: &Chart<'_, '_>,
    record: &RunRecord,
    pose: &PoseSample,
    opacity: f64,
    by_module: bool,
) -> Result<(), DrawError> {
    // A hair less than the pitch, so that modules are told apart.
    let half_m = 0.47 * record.parameters.pitch_m;
    for (index, centre) in record.positions_m.iter().enumerate() {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(right, up)| to_world(pose, [centre[0] + right * half_m, centre[1] + up * half_m]));
        let colour = if by_module { style::module_colour(index) } else { style::HULL };
        let opacity = if by_module { 0.55 } else { opacity };
        chart.polygon(corners.to_vec(), style::fill(colour, opacity))?;
        let mut outline = corners.to_vec();
        outline.push(corners[0]);
        chart.line(outline, style::line(colour, (1.6 * opacity).min(1.0), 1.0))?;
    }
    let module_px = record.parameters.pitch_m * chart.scale().0;
    if by_module && module_px >= 22.0 {
        // In a corner of the module: the mark of the centre of mass often sits on its middle.
        let label = style::bold((0.30 * module_px).clamp(8.0, 12.0), style::INK, Anchor::Middle);
        let aside_m = -0.32 * record.parameters.pitch_m;
        for (index, centre) in record.positions_m.iter().enumerate() {
            let corner = to_world(pose, [centre[0] + aside_m, centre[1] + aside_m]);
            chart.text(&(index + 1).to_string(), corner, (0.0, 0.0), &label)?;
        }
    }
    Ok(())
}

/// An arrow from the centre of mass along the surge axis y_S.
fn draw_surge_arrow(
    chart: &Chart<'_, '_>,
    record: &RunRecord,
    pose: &PoseSample,
    m_per_px: f64,
) -> Result<(), DrawError> {
    let front_m = extent(record.positions_m.iter().map(|p| p[1])).map_or(0.0, |(_, front)| front);
    let tip_m = front_m + (0.95 * record.parameters.pitch_m).clamp(16.0 * m_per_px, 60.0 * m_per_px);
    let head_m = 9.0 * m_per_px;
    let at = |x, y| to_world(pose, [x, y]);
    chart.line(vec![at(0.0, 0.0), at(0.0, tip_m - 0.9 * head_m)], style::line(style::HULL, 0.85, 1.5))?;
    let head = vec![at(0.0, tip_m), at(-0.45 * head_m, tip_m - head_m), at(0.45 * head_m, tip_m - head_m)];
    chart.polygon(head, style::fill(style::HULL, 0.85))
}

/// The three panels over time.
fn history(
    areas: &[Area<'_>],
    record: &RunRecord,
    poses: &[PoseSample],
    each_with_time: bool,
) -> Result<(), DrawError> {
    let end_s = extent(poses.iter().map(|p| p.t_s).chain(record.legs.iter().map(|l| l.end_s)));
    let (start_s, end_s) = end_s.map_or((0.0, 1.0), |(low, high)| (low.min(0.0), high));
    let cycle_s = record.mean_interval_s();
    let last = areas.len().saturating_sub(1);
    let headings = unwound(poses);
    for (index, area) in areas.iter().enumerate() {
        let is_heading = index == 2;
        let value = |p: &PoseSample| p.velocity_m_s[usize::from(index == 1)];
        // (from, to, demand, half width of the band)
        let demands: Vec<[f64; 4]> = record
            .legs
            .iter()
            // A structure that keeps a station has no velocity to keep.
            .filter(|leg| is_heading || leg.station_m.is_none())
            .map(|leg| {
                let [vx, vy] = leg.velocity_m_s;
                let (demand, band) = match index {
                    0 => (vx, VELOCITY_BAND * vx.hypot(vy)),
                    1 => (vy, VELOCITY_BAND * vx.hypot(vy)),
                    _ => {
                        let heading_rad = on_nearest_turn(leg.heading_rad, leg.end_s, &headings);
                        (heading_rad.to_degrees(), HEADING_BAND_RAD.to_degrees())
                    }
                };
                [leg.start_s, leg.end_s, demand, band]
            })
            .filter(|d| d.iter().all(|v| v.is_finite()))
            .collect();
        let raw: Vec<Point> = if is_heading {
            headings.iter().map(|&(t_s, heading_rad)| (t_s, heading_rad.to_degrees())).collect()
        } else {
            poses.iter().map(|p| (p.t_s, value(p))).collect()
        };
        let (low, high) =
            extent(raw.iter().map(|p| p.1).chain(demands.iter().flat_map(|d| [d[2] - d[3], d[2] + d[3]])))
                .unwrap_or((-0.1, 0.1));
        let (title, colour, tolerance) = match index {
            0 => ("Velocity east, m/s", style::BLUE, "demand ± 5 %"),
            1 => ("Velocity north, m/s", style::GREEN, "demand ± 5 %"),
            _ => ("Heading Θ, degrees", style::VERMILION, "demand ± 0.15 rad"),
        };
        let mut legend = Vec::new();
        if !is_heading {
            legend.push((Key::Line(colour, 1.0, 2.0), "cycle mean"));
        }
        if !demands.is_empty() {
            legend.push((Key::Tolerance(style::DEMAND, BAND_OPACITY), tolerance));
        }
        let width_px = picture::chart_width(picture::area_size(area).0);
        let y = if is_heading { Axis::degrees(low, high, 6) } else { Axis::padded(low, high, 7) };
        let panel = Panel {
            legend: &legend,
            legend_below: each_with_time,
            x_title: (each_with_time || index == last).then_some("Time, s"),
            ..Panel::new(title, Axis::time(start_s, end_s, (width_px / 65.0) as usize), y)
        };
        let chart = Chart::new(area, &panel)?;
        for [from, to, demand, band] in &demands {
            let height = (demand - band, demand + band);
            chart.band((*from, *to), height, style::fill(style::DEMAND, BAND_OPACITY))?;
        }
        leg_marks(&chart, record)?;
        let columns = width_px as usize;
        for raw in record.pieces(&raw, |point| point.0) {
            if is_heading {
                chart.line(lines::thin_series(raw, columns), style::line(colour, 1.0, 1.75))?;
            } else {
                chart.line(lines::thin_series(raw, columns), style::line(colour, 0.35, 1.0))?;
                let mean = lines::moving_mean(raw, cycle_s);
                chart.line(lines::thin_series(&mean, columns), style::line(colour, 1.0, 2.0))?;
            }
        }
        for [from, to, demand, _] in &demands {
            chart.dashed(&[(*from, *demand), (*to, *demand)], style::line(style::DEMAND, 1.0, 1.5))?;
        }
    }
    Ok(())
}

/// Headings over time, rad, each on the turn that is nearest to the one before.
fn unwound(poses: &[PoseSample]) -> Vec<Point> {
    let mut headings: Vec<Point> = Vec::with_capacity(poses.len());
    for pose in poses {
        let before_rad = headings.last().map_or(pose.heading_rad, |last| last.1);
        headings.push((pose.t_s, before_rad + wrap_rad(pose.heading_rad - before_rad)));
    }
    headings
}

/// A demanded heading on the turn nearest to where the structure pointed at `t_s`, when the leg ended, rad.
fn on_nearest_turn(demand_rad: f64, t_s: f64, headings: &[Point]) -> f64 {
    let there = headings.iter().rev().find(|point| point.0 <= t_s).or(headings.first());
    there.map_or(demand_rad, |(_, heading_rad)| heading_rad + wrap_rad(demand_rad - heading_rad))
}

/// A thin upright line where each leg but the first begins.
pub(super) fn leg_marks(chart: &Chart<'_, '_>, record: &RunRecord) -> Result<(), DrawError> {
    let (x, y) = (chart.x(), chart.y());
    for leg in record.legs.iter().skip(1).filter(|leg| x.contains(&leg.start_s)) {
        let upright = vec![(leg.start_s, y.start), (leg.start_s, y.end)];
        chart.line(upright, style::line(style::MUTED, 0.7, 1.0))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// The path, two velocities and their means, and the heading are lifted where nothing was seen.
    #[test]
    fn no_line_is_drawn_through_a_gap() {
        let whole = crate::sample::run(2, 1, 20.0, [[0.04, 0.0], [0.0, 0.04]]);
        let mut apart = whole.clone();
        // Between two poses.
        let between_s = 0.5 * (whole.poses[200].t_s + whole.poses[201].t_s);
        apart.gaps = vec![[between_s - 0.01, between_s + 0.01]];
        let lines = |record| svg(record).expect("it is drawn").matches("<polyline").count();
        assert_eq!(lines(&apart), lines(&whole) + 6);
    }

    /// From 3.1 rad over south to −3.1 rad: 0.08 rad on, not 6.2 rad back.
    #[test]
    fn headings_and_demands_lie_on_one_turn() {
        let pose = |t_s: f64, heading_rad: f64| PoseSample { t_s, heading_rad, ..PoseSample::default() };
        let poses =
            [pose(0.0, 3.1), pose(1.0, std::f64::consts::PI - 1e-3), pose(2.0, -3.1), pose(3.0, -3.09)];
        let headings = unwound(&poses);
        assert!(headings.windows(2).all(|pair| (pair[1].1 - pair[0].1).abs() < 0.05), "{headings:?}");
        let demand_rad = on_nearest_turn(-3.1, 3.0, &headings);
        assert!((demand_rad - headings[3].1).abs() < 0.02, "{demand_rad} beside {headings:?}");
        // Turned on and on: the demand of the second leg two turns up.
        let spun: Vec<_> = (0..100).map(|n| pose(f64::from(n), wrap_rad(0.126 * f64::from(n)))).collect();
        let headings = unwound(&spun);
        assert!((headings[99].1 - 0.126 * 99.0).abs() < 1e-9);
        assert!((on_nearest_turn(0.0, 99.0, &headings) - 4.0 * std::f64::consts::PI).abs() < 1e-9);
        assert!((on_nearest_turn(0.3, 1.0, &[]) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn the_structure_frame_turns_into_the_world() {
        // Facing north, sway is east and surge north; facing east, sway is south and surge east.
        let facing =
            |heading_rad| PoseSample { heading_rad, position_m: [1.0, 2.0], ..PoseSample::default() };
        for (heading_rad, at, expected) in
            [(FRAC_PI_2, [0.3, 0.1], (1.3, 2.1)), (0.0, [0.3, 0.1], (1.1, 1.7))]
        {
            let (x, y) = to_world(&facing(heading_rad), at);
            assert!((x - expected.0).abs() < 1e-12 && (y - expected.1).abs() < 1e-12, "{x}, {y}");
        }
    }

    #[test]
    fn the_structure_is_shown_at_equal_times_and_at_the_end() {
        let record = crate::sample::run(3, 1, 60.0, [[0.04, 0.0], [0.0, 0.04]]);
        let every_s = ghost_interval_s(&record, &record.poses);
        let times: Vec<f64> = ghosts(&record.poses, every_s).iter().map(|p| p.t_s).collect();
        assert!((3..=13).contains(&times.len()), "{times:?}");
        for (n, t_s) in times.iter().enumerate() {
            assert!((t_s - n as f64 * every_s).abs() < 0.051, "{times:?} every {every_s} s");
        }
        assert_eq!(times.last().copied(), record.poses.last().map(|p| p.t_s));
        assert!(ghosts(&[], 1.0).is_empty());
    }

    #[test]
    fn a_course_starts_where_the_leg_did() {
        let record = crate::sample::run(3, 1, 60.0, [[0.04, 0.0], [0.0, 0.04]]);
        let courses = courses(&record, &record.poses);
        let turn = record.poses.iter().find(|p| p.t_s >= 60.0 - 1e-9).expect("a pose").position_m;
        assert_eq!(courses[1][0], (turn[0], turn[1]));
        assert!((courses[1][1].1 - (turn[1] + 2.4)).abs() < 1e-9);
    }
}
