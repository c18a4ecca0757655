//! `phase-space.svg`: the plane (φᵢ, φⱼ) of two neighbouring tails with everything the run swam in it; after the
//! paper's Fig. 2.
//!
//! One panel per kind of neighbours with tails that can touch. Poses that collide are vermilion, all else is free. A swim
//! cycle is a straight segment between (φ₀ᵢ ± Aᵢ, φ₀ⱼ ± Aⱼ), drawn where its middle lies within (−π, π]²; one cycle of
//! the run stands out, with the transition before it. Everything repeats every 2π along both axes.

use std::collections::HashMap;
use std::f64::consts::TAU;

use plotters::style::WHITE;
use quantity::wrap_rad;
use record::{CycleRecord, RunRecord};

use super::axis::{Axis, number};
use super::lines::{self, Point, Window};
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style;

/// Width of the picture with two kinds of neighbours, px.
const WIDTH: f64 = 1200.0;
/// Most swim segments drawn in one panel.
const SEGMENTS: usize = 1200;
/// What is shown along both axes, rad.
const WINDOW: Window = Window { x: (-TAU, TAU), y: (-TAU, TAU) };

/// Two modules at a fixed offset, and where in the plane of their tail angles they collide.
#[derive(Clone, Debug, PartialEq)]
pub struct NeighbourKind {
    /// Lattice offset [columns, rows] from the first module to the second.
    pub offset: [i32; 2],
    /// Collision region as polygons of (φᵢ, φⱼ), rad; each stands for its copies shifted by 2π too.
    pub region: Vec<Vec<[f64; 2]>>,
}

impl NeighbourKind {
    /// What the panel and its axes are called.
    fn titles(&self) -> [String; 3] {
        let of = |which: &str, name: &str| format!("{which} of the {name} module, rad");
        match self.offset {
            [1, 0] => ["Side by side".to_owned(), of("φ₁", "left"), of("φ₂", "right")],
            [0, 1] => ["One behind the other".to_owned(), of("φ₁", "rear"), of("φ₂", "front")],
            [columns, rows] => {
                let [columns, rows] = [columns, rows].map(|n| number(f64::from(n), 0));
                [format!("{columns} right, {rows} ahead"), of("φ₁", "first"), of("φ₂", "second")]
            }
        }
    }

    /// Every pair of modules at this offset.
    fn pairs(&self, cells: &[[i32; 2]]) -> Vec<(usize, usize)> {
        let by_cell: HashMap<[i32; 2], usize> = cells.iter().enumerate().map(|(i, &c)| (c, i)).collect();
        let across =
            |c: [i32; 2]| Some([c[0].checked_add(self.offset[0])?, c[1].checked_add(self.offset[1])?]);
        let ahead = |(i, &c): (usize, &[i32; 2])| by_cell.get(&across(c)?).map(|&j| (i, j));
        cells.iter().enumerate().filter_map(ahead).collect()
    }
}

/// Draws the picture: one panel for each of `kinds` that the structure has, at most four.
pub fn svg(record: &RunRecord, kinds: &[NeighbourKind]) -> Result<String, DrawError> {
    let present: Vec<(&NeighbourKind, Vec<(usize, usize)>)> = kinds
        .iter()
        .map(|kind| (kind, kind.pairs(&record.cells)))
        .filter(|(_, pairs)| !pairs.is_empty())
        .take(4)
        .collect();
    let columns = present.len().clamp(1, 2);
    let rows = present.len().div_ceil(2).max(1);
    let width = if columns == 1 { 0.68 * WIDTH } else { WIDTH };
    let (body_width, _) = picture::body_size((width, 0.0));
    // Square charts: both angles at the same scale.
    let panel_width = body_width / columns as f64;
    let is_narrow = columns > 1;
    let panel_height = picture::chart_width(panel_width) + picture::around(is_narrow, true);
    let line = if present.is_empty() {
        "No two tails of this structure can touch.".to_owned()
    } else {
        record.description.clone()
    };
    let heading = Heading { name: &record.name, subject: "swim cycles in phase space", line };
    let body_height = if present.is_empty() { 20.0 } else { panel_height * rows as f64 };
    picture::render((width, picture::height_for(body_height)), &heading, |area| {
        let panels = area.split_evenly((rows, columns));
        for ((kind, pairs), panel) in present.iter().zip(&panels) {
            draw(panel, record, kind, pairs, is_narrow)?;
        }
        Ok(())
    })
}

/// One swim cycle of one pair, shifted so that its middle lies within (−π, π]².
#[derive(Clone, Copy)]
struct Swim {
    ends: [Point; 2],
    middle: Point,
}

fn swim(cycle: &CycleRecord, (i, j): (usize, usize)) -> Option<Swim> {
    let (a, b) = (cycle.swings.get(i)?, cycle.swings.get(j)?);
    let middle = (wrap_rad(a.centerline_rad), wrap_rad(b.centerline_rad));
    let half = (a.amplitude_rad, b.amplitude_rad);
    let ends = [(middle.0 + half.0, middle.1 + half.1), (middle.0 - half.0, middle.1 - half.1)];
    ends.iter().all(|p| p.0.is_finite() && p.1.is_finite()).then_some(Swim { ends, middle })
}

/// Every how many segments one is drawn, so that a panel gets at most [`SEGMENTS`] or so, of every pair alike.
fn stride(total: usize, pairs: usize) -> usize {
    fn share_a_divisor(a: usize, b: usize) -> bool {
        if b == 0 { a != 1 } else { share_a_divisor(b, a % b) }
    }
    let mut every = total.div_ceil(SEGMENTS).max(1);
    // Segments come pair by pair: a stride that shares a divisor with their number would drop some pairs.
    while every > 1 && share_a_divisor(every, pairs) {
        every += 1;
    }
    every
}

/// A cycle to show on its own, near the middle of the run: with a transition that stays inside the window, neither
/// a mere twitch nor a whole turn, if there is one.
fn example<'r>(record: &'r RunRecord, pairs: &[(usize, usize)]) -> Option<(&'r CycleRecord, (usize, usize))> {
    let middle = record.cycles.len() as f64 / 2.0;
    let score = |index: usize, cycle: &CycleRecord, pair: (usize, usize)| {
        let swim = swim(cycle, pair)?;
        let [start, _] = swim.ends;
        let half = (start.0 - swim.middle.0, start.1 - swim.middle.1);
        let turned = [pair.0, pair.1].map(|m| cycle.turns.get(m).map_or(0.0, |t| t.rotation_rad()));
        let length = turned[0].hypot(turned[1]);
        let from = (start.0 - turned[0], start.1 - turned[1]);
        let fits = from.0.abs() < TAU && from.1.abs() < TAU;
        // Its transition is to stand clear of its swim.
        let (along, across) = (half.0.hypot(half.1), turned[0] * half.1 - turned[1] * half.0);
        let readable = fits && (0.5..2.5).contains(&length) && across.abs() > 0.4 * along;
        let moves = half.0.hypot(half.1) > 1e-6;
        Some((index as f64 - middle).abs() + if readable { 0.0 } else { 1e6 } + if moves { 0.0 } else { 1e9 })
    };
    let all = record.cycles.iter().enumerate().flat_map(|(index, cycle)| {
        pairs.iter().filter_map(move |&pair| Some((score(index, cycle, pair)?, cycle, pair)))
    });
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, cycle, pair)| (cycle, pair))
}

fn draw(
    area: &Area<'_>,
    record: &RunRecord,
    kind: &NeighbourKind,
    pairs: &[(usize, usize)],
    legend_below: bool,
) -> Result<(), DrawError> {
    let total = record.cycles.len() * pairs.len();
    let every = stride(total, pairs.len());
    let swims = if every == 1 { "swim cycles".to_owned() } else { format!("swim cycles, 1 in {every}") };
    let example = example(record, pairs);
    let named =
        example.map(|(cycle, (i, j))| format!("cycle {}, modules {}, {}", cycle.number, i + 1, j + 1));
    let mut legend = vec![
        (Key::Band(style::COLLISION, 1.0), "collision"),
        (Key::Line(style::HULL, 0.6, 1.25), swims.as_str()),
    ];
    if let Some(named) = &named {
        legend.push((Key::Line(style::BLUE, 1.0, 2.75), named.as_str()));
    }
    let [title, x_title, y_title] = kind.titles();
    let angles = Axis::radians(-TAU, TAU, 2);
    let panel = Panel {
        legend: &legend,
        legend_below,
        x_title: Some(&x_title),
        y_title: Some(&y_title),
        ..Panel::new(&title, angles.clone(), angles)
    };
    let chart = Chart::new(area, &panel)?;
    draw_region(&chart, kind)?;

    let all = record.cycles.iter().flat_map(|cycle| pairs.iter().filter_map(move |&pair| swim(cycle, pair)));
    let opacity = if total / every > 400 { 0.2 } else { 0.38 };
    for swim in all.step_by(every) {
        if let Some((a, b)) = lines::clip_segment(WINDOW, swim.ends[0], swim.ends[1]) {
            chart.line(vec![a, b], style::line(style::HULL, opacity, 1.0))?;
        }
    }
    if let Some((cycle, pair)) = example {
        draw_example(&chart, cycle, pair)?;
    }
    Ok(())
}

/// The collision region with its copies, over a faint green for what is free.
fn draw_region(chart: &Chart<'_, '_>, kind: &NeighbourKind) -> Result<(), DrawError> {
    chart.band(WINDOW.x, WINDOW.y, style::fill(style::GREEN, 0.07))?;
    let mut drawn: Vec<Point> = Vec::new();
    for polygon in &kind.region {
        for (across, up) in (-2..=2).flat_map(|a| (-2..=2).map(move |u| (f64::from(a), f64::from(u)))) {
            let shifted: Vec<Point> =
                polygon.iter().map(|p| (p[0] + across * TAU, p[1] + up * TAU)).collect();
            // Where the region already comes with its copies, draw each place once.
            let Some(&first) = shifted.first() else { continue };
            if drawn.iter().any(|p| (p.0 - first.0).abs() + (p.1 - first.1).abs() < 1e-6) {
                continue;
            }
            drawn.push(first);
            let seen = lines::clip_polygon(WINDOW, &shifted);
            chart.polygon(seen.clone(), style::fill(style::COLLISION, 1.0))?;
            let outline: Vec<Point> = seen.iter().chain(seen.first()).copied().collect();
            chart.line(outline, style::line(style::COLLISION_EDGE, 1.0, 1.0))?;
        }
    }
    Ok(())
}

fn draw_example(chart: &Chart<'_, '_>, cycle: &CycleRecord, pair: (usize, usize)) -> Result<(), DrawError> {
    let Some(swim) = swim(cycle, pair) else { return Ok(()) };
    let [start, end] = swim.ends;
    let turned = [pair.0, pair.1].map(|m| cycle.turns.get(m).map_or(0.0, |t| t.rotation_rad()));
    let from = (start.0 - turned[0], start.1 - turned[1]);
    if let Some((a, b)) = lines::clip_segment(WINDOW, from, start)
        && (a.0 - b.0).hypot(a.1 - b.1) > 1e-3
    {
        chart.line(vec![a, b], style::line(WHITE, 0.8, 4.0))?;
        chart.dashed(&[a, b], style::line(style::BLUE, 1.0, 2.0))?;
        chart.ring(a, 4.5, style::BLUE)?;
    }
    if let Some((a, b)) = lines::clip_segment(WINDOW, start, end) {
        chart.line(vec![a, b], style::line(WHITE, 0.8, 5.5))?;
        chart.line(vec![a, b], style::line(style::BLUE, 1.0, 2.75))?;
        chart.dot(a, 4.5, style::BLUE)?;
        chart.dot(b, 4.5, style::BLUE)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn segments_have_their_middle_in_the_first_copy() {
        let record = crate::sample::run(3, 1, 60.0, [[0.04, 0.0], [0.0, 0.04]]);
        for cycle in &record.cycles {
            let shown = swim(cycle, (0, 1)).expect("three modules");
            for (middle, module) in [(shown.middle.0, 0), (shown.middle.1, 1)] {
                assert!(-PI < middle && middle <= PI);
                let turns = (cycle.swings[module].centerline_rad - middle) / TAU;
                assert!((turns - turns.round()).abs() < 1e-9);
            }
            assert!(shown.ends.iter().all(|p| p.0.abs() < TAU && p.1.abs() < TAU));
        }
    }

    #[test]
    fn pairs_are_those_at_the_offset() {
        let cells = [[0, 0], [1, 0], [2, 0], [1, 1]];
        let kind = |offset| NeighbourKind { offset, region: Vec::new() };
        assert_eq!(kind([1, 0]).pairs(&cells), [(0, 1), (1, 2)]);
        assert_eq!(kind([0, 1]).pairs(&cells), [(1, 3)]);
        assert!(kind([2, 2]).pairs(&cells).is_empty());
    }
}
