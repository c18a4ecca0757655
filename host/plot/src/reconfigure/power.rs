//! `power.svg`: electric power over the whole plan, after the paper's Fig. 6.
//!
//! One panel a record: what the waiting robots draw to balance, on top of it what the mover draws, and the planned sum
//! of both as steps, one for each action. Bands tell the moves apart and carry the number of the mover. The last panel
//! shows the energy of all records, executed and planned.

use reconfiguration::plan::Plan;
use record::reconfigure::{Record, Sample};

use super::executed_move::{self, ExecutedMove};
use super::stroke::{self, Pattern, Sign};
use crate::axis::{Axis, extent, number};
use crate::lines::{self, Point};
use crate::picture::{self, Area, Chart, DrawError, Panel};
use crate::style::{self, Anchor};

/// Height of the chart of one record, px.
const POWER: f64 = 165.0;
/// Height of the chart of energies, px.
const ENERGY: f64 = 260.0;
/// An axis of power ends at this multiple of what is exceeded 2 % of the time, if peaks go further.
const HEADROOM: f64 = 1.6;

/// Draws the picture of power over time, as SVG.
pub fn svg(records: &[Record]) -> Result<String, DrawError> {
    let power_px = POWER + picture::around(false, false);
    let energy_px = ENERGY + picture::around(false, true);
    let height = power_px * records.len() as f64 + energy_px;
    let times = records.iter().flat_map(|r| {
        r.samples.iter().map(|s| s.t_s).chain(planned_w(&r.plan).into_iter().map(|(t_s, _)| t_s))
    });
    let end_s = extent(times).map_or(1.0, |(_, end_s)| end_s.max(1e-3));
    let most_w = most_w(records);
    let legend = legend(records);
    stroke::render(records, "electric power", picture::WIDE, height, &legend, |area, legend_px| {
        let (_, mut rest) = area.split_vertically(style::px(legend_px));
        for record in records {
            let (panel, below) = rest.split_vertically(style::px(power_px));
            draw_power(&panel, record, end_s, most_w)?;
            rest = below;
        }
        draw_energy(&rest, records, end_s)
    })
}

fn legend(records: &[Record]) -> Vec<(Sign, String)> {
    let mut legend = vec![
        (Sign::Box(style::SKY, 0.55, None), "mover".to_owned()),
        (Sign::Box(style::ORANGE, 0.75, None), "balancing".to_owned()),
        (Sign::Line(style::INK, Pattern::Dashed, 1.0, 1.5), "planned, both".to_owned()),
    ];
    for (n, record) in records.iter().enumerate() {
        let (colour, pattern) = stroke::of_record(n);
        let label = executed_move::label(&record.plan);
        let executed = executed_move::cumulated_j(record.samples.iter()).last().map_or(0.0, |last| last.1);
        let planned = record.plan.energy_total_j;
        let text = format!("{label}: {} J executed, {} J planned", number(executed, 1), number(planned, 1));
        legend.push((Sign::Line(colour, pattern, 1.0, 2.0), text));
    }
    legend
}

/// What the waiting robots and what all robots draw, W.
fn powers(samples: &[Sample], moved: Option<&ExecutedMove<'_>>) -> (Vec<Point>, Vec<Point>) {
    let total = |s: &Sample| executed_move::total_w(s);
    let mover = |s: &Sample| moved.and_then(|c| s.robots.get(c.robot)).map_or(0.0, |r| r.power_w);
    let waiting = samples.iter().map(|s| (s.t_s, total(s) - mover(s))).collect();
    (waiting, samples.iter().map(|s| (s.t_s, total(s))).collect())
}

/// The planned power of mover and waiting robots, one step for each action, W.
fn planned_w(plan: &Plan) -> Vec<Point> {
    let steps = plan.moves.iter().flat_map(|m| {
        m.actions.iter().filter(|a| a.duration_s > 0.0).flat_map(move |a| {
            let power_w = a.energy_j / a.duration_s + m.balance_w;
            [(a.start_s, power_w), (a.start_s + a.duration_s, power_w)]
        })
    });
    steps.filter(|p| p.0.is_finite() && p.1.is_finite()).collect()
}

/// The planned energy since the beginning of the plan at both ends of every action, J.
fn planned_j(plan: &Plan) -> Vec<Point> {
    let mut energy_j = 0.0;
    planned_w(plan)
        .chunks_exact(2)
        .flat_map(|step| {
            let before = (step[0].0, energy_j);
            energy_j += step[0].1 * (step[1].0 - step[0].0);
            [before, (step[1].0, energy_j)]
        })
        .collect()
}

/// Where the axes of power end, and the greatest power where that lies beyond.
fn most_w(records: &[Record]) -> (f64, Option<f64>) {
    let executed = records.iter().flat_map(|r| r.samples.iter().map(executed_move::total_w));
    let mut values: Vec<f64> = executed.collect();
    values.sort_by(f64::total_cmp);
    let planned = records.iter().flat_map(|r| planned_w(&r.plan)).map(|p| p.1);
    let planned = extent(planned).map_or(0.0, |(_, most)| most);
    let greatest = values.last().copied().unwrap_or(0.0).max(planned).max(1.0);
    let usual = values.get(values.len().saturating_mul(98) / 100).copied().unwrap_or(greatest).max(planned);
    let shown = HEADROOM * usual;
    if shown > 0.0 && greatest > shown { (shown, Some(greatest)) } else { (greatest, None) }
}

fn draw_power(
    area: &Area<'_>,
    record: &Record,
    end_s: f64,
    (shown_w, peak_w): (f64, Option<f64>),
) -> Result<(), DrawError> {
    let (width, _) = picture::area_size(area);
    let mut title = format!("{}: power, W", executed_move::label(&record.plan));
    if let Some(peak_w) = peak_w {
        title += &format!(" (peaks up to {} W are cut)", number(peak_w, 0));
    }
    // The numbers of the movers stand above the curves.
    let panel = Panel::new(&title, Axis::time(0.0, end_s, 15), Axis::exact(0.0, 1.22 * shown_w, 5));
    let chart = Chart::new(area, &panel)?;
    let (across, up) = (chart.x(), chart.y());
    let moves = executed_move::executed_moves(record);
    for (number, moved) in moves.iter().enumerate() {
        let (from_s, to_s) = moved.span_s();
        let opacity = if number.is_multiple_of(2) { 0.10 } else { 0.04 };
        chart.band((from_s, to_s), (up.start, up.end), style::fill(style::DEMAND, opacity))?;
    }
    let columns = picture::chart_width(width) as usize;
    let cut = |points: Vec<Point>| -> Vec<Point> {
        let thin = lines::thin_series(&points, columns);
        thin.into_iter()
            .map(|(t_s, w)| (t_s.clamp(across.start, across.end), w.clamp(0.0, shown_w)))
            .collect()
    };
    let gaps = moves.iter().filter_map(|c| Some((c.samples.first()?.t_s, c)));
    for (_, moved) in gaps {
        let (waiting, total) = powers(moved.samples, Some(moved));
        let (waiting, total) = (cut(waiting), cut(total));
        let base = [waiting.last(), waiting.first()].into_iter().flatten().map(|p| (p.0, 0.0));
        let below: Vec<Point> = waiting.iter().copied().chain(base).collect();
        let above: Vec<Point> = total.iter().copied().chain(waiting.iter().rev().copied()).collect();
        chart.polygon(above, style::fill(style::SKY, 0.55))?;
        chart.polygon(below, style::fill(style::ORANGE, 0.75))?;
        chart.line(total, style::line(style::BLUE, 1.0, 1.0))?;
    }
    chart.line(
        cut(planned_w(&record.plan)),
        style::line(stroke::marked(style::INK, Pattern::Dashed), 1.0, 1.25),
    )?;
    for moved in &moves {
        let (from_s, to_s) = moved.span_s();
        let room_px = (to_s - from_s) * chart.scale().0 - 8.0;
        let robot = moved.planned.robot;
        let whole = format!("robot {robot}");
        let fits = style::text_width(&whole, style::SIZE_TEXT) * 1.08 < room_px;
        let text = if fits { whole } else { robot.to_string() };
        let label = style::bold(style::SIZE_TEXT, style::INK, Anchor::Start);
        if from_s.is_finite() {
            chart.text(&text, (from_s, up.end), (6.0, 11.0), &label)?;
        }
    }
    Ok(())
}

fn draw_energy(area: &Area<'_>, records: &[Record], end_s: f64) -> Result<(), DrawError> {
    let executed: Vec<Vec<Point>> =
        records.iter().map(|r| executed_move::cumulated_j(r.samples.iter())).collect();
    let planned: Vec<Vec<Point>> = records.iter().map(|r| planned_j(&r.plan)).collect();
    let values = executed.iter().chain(&planned).flatten().map(|p| p.1);
    let most_j = extent(values).map_or(1.0, |(_, most)| most.max(1e-3));
    let title = "Energy since the beginning, J: executed, and planned as a thin line to a ring";
    let panel = Panel::new(title, Axis::time(0.0, end_s, 15), Axis::exact(0.0, 1.08 * most_j, 6));
    let chart = Chart::new(area, &Panel { x_title: Some("Time, s"), ..panel })?;
    for (n, (executed, planned)) in executed.iter().zip(&planned).enumerate() {
        let (colour, pattern) = stroke::of_record(n);
        chart.line(planned.clone(), style::line(colour, 0.55, 1.0))?;
        chart.line(
            lines::thin_path(executed, 0.05),
            style::line(stroke::marked(colour, pattern), 1.0, 2.25),
        )?;
        if let Some(&end) = planned.last() {
            chart.ring(end, 4.5, colour)?;
        }
        if let Some(&end) = executed.last() {
            chart.dot(end, 4.0, colour)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconfigure::sample;

    #[test]
    fn planned_steps_hold_the_planned_energy() {
        for record in sample::far() {
            let end = *planned_j(&record.plan).last().expect("steps");
            assert!((end.1 - record.plan.energy_total_j).abs() < 1e-9 * end.1);
            assert!((end.0 - record.plan.time_s).abs() < 1e-9);
        }
    }

    #[test]
    fn a_lone_peak_does_not_set_the_axis() {
        let mut records = sample::far();
        let (usual, peak) = most_w(&records);
        assert_eq!(peak, None);
        records[0].samples[20].robots[0].power_w = 900.0;
        let (shown, peak) = most_w(&records);
        assert!(shown < 2.0 * usual && peak.is_some_and(|w| w > 900.0), "{shown} {peak:?}");
    }

    #[test]
    fn waiting_and_mover_make_the_total() {
        let record = &sample::far()[0];
        for moved in executed_move::executed_moves(record) {
            let (waiting, total) = powers(moved.samples, Some(&moved));
            for ((sample, w), t) in moved.samples.iter().zip(waiting).zip(total) {
                assert!((w.1 + sample.robots[moved.robot].power_w - t.1).abs() < 1e-9);
            }
        }
    }
}
