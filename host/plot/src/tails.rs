//! `tails.svg`: the angle of every tail over time, four cycles in detail and the whole run beside it.
//!
//! Tails turn on and on, so their unwrapped angles drift away by whole turns. Each cycle, transition included, is
//! shifted by a multiple of 2π: the one of the cycle before while that keeps its centerline φ₀ within ±3π/2, so that
//! a centerline near ±π does not flicker, and otherwise the one that brings it into (−π, π]. Where the shift
//! changes, the line is lifted, since nothing moved there.

use std::f64::consts::{PI, TAU};

use firmware::modboat::transition::Transition;
use protocol::TransitionLaw;
use protocol::time::Duration;
use protocol::units::Radians;
use quantity::wrap_rad;
use record::{CycleRecord, RunRecord};

use super::axis::{Axis, extent};
use super::lines::{self, Point};
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style;

/// Width of the picture, px.
const WIDTH: f64 = 1200.0;
/// Most modules shown.
const MOST: usize = 9;
/// A centerline is left where it is shown while it lies no farther out than this, rad.
const STAY_RAD: f64 = 1.5 * PI;
/// Cycles shown in detail.
const DETAIL: usize = 4;
/// Width of the detailed panel, px.
const DETAIL_WIDTH: f64 = 760.0;

/// Draws the picture of tail angles over time, as SVG.
pub fn svg(record: &RunRecord) -> Result<String, DrawError> {
    let count = record.cells.len();
    let modules = chosen(count);
    let rows = modules.len().max(1);
    let chart_height = match rows {
        1 => 300.0,
        2 => 230.0,
        3 => 180.0,
        4 | 5 => 130.0,
        _ => 92.0,
    };
    let row = chart_height + picture::around(false, false);
    let last_row = chart_height + picture::around(false, true);
    let line = if modules.len() < count {
        format!("{} of {count} modules, evenly chosen. {}", modules.len(), record.description)
    } else {
        record.description.clone()
    };
    let heading = Heading { name: &record.name, subject: "tail angles", line };
    let height = picture::height_for(row * (rows - 1) as f64 + last_row);

    let first = record.cycles.len().saturating_sub(DETAIL) / 2;
    let detail: Vec<CycleRecord> = record.cycles.iter().skip(first).take(DETAIL).cloned().collect();
    let curves: Vec<Curves> = modules.iter().map(|&m| Curves::new(record, m)).collect();
    let (low, high) = extent(curves.iter().flat_map(Curves::values)).unwrap_or((-PI, PI));
    let angles = (low.min(-PI) - 0.25, high.max(PI) + 0.25);

    picture::render((WIDTH, height), &heading, |area| {
        for (index, strip) in picture::stacked(area, rows).iter().enumerate() {
            let (Some(curves), Some(&module)) = (curves.get(index), modules.get(index)) else { continue };
            let place =
                Place { module, is_first: index == 0, is_last: index + 1 == rows, angles, chart_height };
            let (left, right) = strip.split_horizontally(style::px(DETAIL_WIDTH));
            draw_detail(&left, curves, &detail, place)?;
            draw_whole(&right, curves, record, &detail, place)?;
        }
        Ok(())
    })
}

/// At most nine modules, evenly spread over all of them.
fn chosen(count: usize) -> Vec<usize> {
    if count <= MOST {
        return (0..count).collect();
    }
    (0..MOST).map(|n| (n * (count - 1) + (MOST - 1) / 2) / (MOST - 1)).collect()
}

#[derive(Clone, Copy)]
struct Place {
    module: usize,
    is_first: bool,
    is_last: bool,
    angles: (f64, f64),
    chart_height: f64,
}

impl Place {
    fn axis(&self) -> Axis {
        // Ticks every π, or every 2π where those would stand closer than 26 px.
        let half_turns = (self.angles.1 - self.angles.0) / PI;
        Axis::radians(self.angles.0, self.angles.1, if self.chart_height < 26.0 * half_turns { 4 } else { 2 })
    }
}

/// The nearest whole number of microseconds.
fn micros(t_s: f64) -> Duration {
    Duration((t_s * 1e6).round() as u32)
}

/// What is drawn of one tail.
struct Curves {
    /// Runs of samples with one shift each, in order.
    actual: Vec<Vec<Point>>,
    /// (start, end, φ₀ shifted) of every cycle.
    centerlines: Vec<(f64, f64, f64)>,
    /// What the plan says, one run a cycle: transition and swim.
    planned: Vec<Vec<Point>>,
}

impl Curves {
    fn new(record: &RunRecord, module: usize) -> Self {
        let mut curves = Self { actual: Vec::new(), centerlines: Vec::new(), planned: Vec::new() };
        let samples: Vec<Point> = record
            .tails
            .iter()
            .filter_map(|s| s.actual_rad.get(module).map(|&angle| (s.t_s, angle)))
            .filter(|p| p.0.is_finite() && p.1.is_finite())
            .collect();
        let mut run: Vec<Point> = Vec::new();
        let mut shift_before: Option<f64> = None;
        // What precedes the first cycle is shown with the first cycle's shift, what follows the last with the last's.
        for (index, cycle) in record.cycles.iter().enumerate() {
            let (Some(swing), Some(turn)) = (cycle.swings.get(module), cycle.turns.get(module)) else {
                continue;
            };
            let swim_s = cycle.start_s + cycle.transition_s;
            let end_s = swim_s + cycle.period_s;
            let wrapped_rad = wrap_rad(swing.centerline_rad);
            let from = if index == 0 { 0 } else { samples.partition_point(|p| p.0 < cycle.start_s) };
            let to = match record.cycles.get(index + 1) {
                Some(next) => samples.partition_point(|p| p.0 < next.start_s),
                None => samples.len(),
            };
            // The tail stands nearest to φ₀ + A when its swim begins: that tells the turns it has made.
            let seen = samples.get(samples.partition_point(|p| p.0 < swim_s).min(to.saturating_sub(1)));
            let start_rad = wrapped_rad + swing.amplitude_rad;
            let home = seen.map_or(0.0, |p| TAU * ((p.1 - start_rad) / TAU).round());
            let shift = shift_before.filter(|s| (wrapped_rad + home - s).abs() <= STAY_RAD).unwrap_or(home);
            let centre_rad = wrapped_rad + home - shift;
            let start_rad = centre_rad + swing.amplitude_rad;
            if shift_before.is_some_and(|s| (s - shift).abs() > 1.0) {
                curves.actual.push(std::mem::take(&mut run));
            }
            shift_before = Some(shift);
            run.extend(
                samples.get(from..to).unwrap_or_default().iter().map(|&(t, angle)| (t, angle - shift)),
            );

            curves.centerlines.push((swim_s, end_s, centre_rad));
            let mut planned = Vec::new();
            const STEPS: u32 = 48;
            let mut turning = |start_s: f64, length_s: f64, ramp_s: f64, [from_rad, to_rad]: [f64; 2]| {
                // A rotation by 1 rad turns by the share that is done.
                let (length, ramp) = (micros(length_s), micros(ramp_s));
                let law = if ramp.0 == 0 {
                    TransitionLaw::ConstantSpeed
                } else {
                    TransitionLaw::RestToRest { ramp }
                };
                let one = Transition::from(Radians(0.0), Radians(1.0), length, law);
                planned.extend((0..=STEPS).map(|n| {
                    let t_s = length_s * f64::from(n) / f64::from(STEPS);
                    let share = f64::from(one.reference(micros(t_s)).angle_rad);
                    (start_s + t_s, from_rad + (to_rad - from_rad) * share)
                }));
            };
            // As they end at the start of the swim.
            let shown = |rad: f64| start_rad - (turn.to_rad - rad);
            match &cycle.via {
                Some(via) => {
                    let via_rad = shown(via.via_rad.get(module).copied().unwrap_or(turn.from_rad));
                    turning(cycle.start_s, via.turning_s, cycle.ramps_s[0], [shown(turn.from_rad), via_rad]);
                    let second_s = cycle.start_s + via.turning_s + via.rest_s;
                    turning(second_s, swim_s - second_s, cycle.ramps_s[1], [via_rad, start_rad]);
                }
                None if cycle.transition_s > 0.0 => {
                    let ends_rad = [shown(turn.from_rad), start_rad];
                    turning(cycle.start_s, cycle.transition_s, cycle.ramps_s[0], ends_rad);
                }
                None => {}
            }
            planned.extend((0..=STEPS).map(|n| {
                let share = f64::from(n) / f64::from(STEPS);
                let angle_rad = centre_rad + swing.amplitude_rad * (TAU * share).cos();
                (swim_s + share * cycle.period_s, angle_rad)
            }));
            curves.planned.push(planned);
        }
        if record.cycles.is_empty() {
            let shift = samples.first().map_or(0.0, |p| p.1 - wrap_rad(p.1));
            run = samples.iter().map(|&(t, angle)| (t, angle - shift)).collect();
        }
        curves.actual.push(run);
        let pieces = curves.actual.iter().flat_map(|run| record.pieces(run, |point| point.0));
        curves.actual = pieces.map(<[Point]>::to_vec).collect();
        curves
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.actual.iter().chain(&self.planned).flatten().map(|p| p.1)
    }
}

fn draw_detail(
    area: &Area<'_>,
    curves: &Curves,
    detail: &[CycleRecord],
    place: Place,
) -> Result<(), DrawError> {
    let ends = detail.iter().flat_map(|c| [c.start_s, c.start_s + c.transition_s + c.period_s]);
    let samples = curves.actual.iter().flatten().map(|p| p.0);
    let (start_s, end_s) = extent(ends).or_else(|| extent(samples)).unwrap_or((0.0, 1.0));
    let colour = style::module_colour(place.module);
    let legend = [
        (Key::Line(colour, 1.0, 2.0), "actual φ"),
        (Key::Line(colour, 0.3, 5.0), "plan"),
        (Key::Dashed(style::MUTED), "centerline φ₀"),
        (Key::Band(style::ORANGE, 0.2), "transition"),
    ];
    let title = format!("Module {}, rad", place.module + 1);
    let panel = Panel {
        legend: if place.is_first { &legend } else { &[] },
        x_title: place.is_last.then_some("Time, s"),
        ..Panel::new(&title, Axis::time(start_s, end_s, 9), place.axis())
    };
    let chart = Chart::new(area, &panel)?;
    let (x, y) = (chart.x(), chart.y());
    let within = |t: f64| x.start - 1e-9 <= t && t <= x.end + 1e-9;
    for cycle in detail {
        let swim_s = cycle.start_s + cycle.transition_s;
        chart.band((cycle.start_s, swim_s), (y.start, y.end), style::fill(style::ORANGE, 0.14))?;
    }
    let window = lines::Window { x: (x.start, x.end), y: (y.start, y.end) };
    for planned in &curves.planned {
        if planned.iter().all(|p| within(p.0)) && planned.iter().all(|p| p.1.is_finite()) {
            let cut: Vec<Point> = planned.iter().map(|p| (p.0, p.1.clamp(window.y.0, window.y.1))).collect();
            chart.line(cut, style::line(colour, 0.3, 5.0))?;
        }
    }
    for &(from, to, centre_rad) in &curves.centerlines {
        if within(from) && within(to) && centre_rad.is_finite() {
            chart.dashed(&[(from, centre_rad), (to, centre_rad)], style::line(style::MUTED, 1.0, 1.0))?;
        }
    }
    for run in &curves.actual {
        let seen: Vec<Point> = run.iter().copied().filter(|p| within(p.0)).collect();
        chart.line(lines::thin_series(&seen, DETAIL_WIDTH as usize), style::line(colour, 1.0, 2.0))?;
    }
    Ok(())
}

fn draw_whole(
    area: &Area<'_>,
    curves: &Curves,
    record: &RunRecord,
    detail: &[CycleRecord],
    place: Place,
) -> Result<(), DrawError> {
    let times = curves.actual.iter().flatten().map(|p| p.0);
    let legs = record.legs.iter().map(|leg| leg.end_s);
    let (start_s, end_s) = extent(times.chain(legs)).unwrap_or((0.0, 1.0));
    let legend = [(Key::Band(style::INK, 0.12), "shown on the left")];
    let (title, legend): (_, &[_]) = if place.is_first { ("Whole run", &legend) } else { ("", &[]) };
    let panel = Panel::new(title, Axis::time(start_s.min(0.0), end_s, 5), place.axis());
    let panel = Panel { legend, x_title: place.is_last.then_some("Time, s"), ..panel };
    let chart = Chart::new(area, &panel)?;
    let y = chart.y();
    if let (Some(first), Some(last)) = (detail.first(), detail.last()) {
        let end_s = last.start_s + last.transition_s + last.period_s;
        chart.band((first.start_s, end_s), (y.start, y.end), style::fill(style::INK, 0.12))?;
    }
    let colour = style::module_colour(place.module);
    let width_px = picture::chart_width(picture::area_size(area).0);
    let span_s = (end_s - start_s).max(1e-9);
    for run in &curves.actual {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
        let columns = (width_px * (last.0 - first.0) / span_s).ceil() as usize;
        chart.line(lines::thin_series(run, columns), style::line(colour, 0.7, 0.75))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use record::ViaRecord;

    use super::*;

    #[test]
    fn cycles_come_home_to_one_turn_and_lines_do_not_jump() {
        let record = crate::sample::run(4, 1, 120.0, [[0.04, 0.0], [0.0, 0.04]]);
        let drift =
            record.tails.iter().flat_map(|s| &s.actual_rad).fold(0.0_f64, |most, a| most.max(a.abs()));
        assert!(drift > 3.0 * PI, "the sample must drift over turns, it reaches {drift} rad");
        for module in 0..4 {
            let curves = Curves::new(&record, module);
            assert!(curves.centerlines.iter().all(|c| c.2.abs() <= STAY_RAD));
            assert_eq!(curves.actual.iter().map(Vec::len).sum::<usize>(), record.tails.len());
            for run in &curves.actual {
                for pair in run.windows(2) {
                    assert!((pair[1].1 - pair[0].1).abs() < 0.5, "jump at {} s", pair[1].0);
                }
            }
            // In mid-swim every sample lies within one amplitude of the shifted centerline.
            for (&(from, to, centre), cycle) in curves.centerlines.iter().zip(&record.cycles) {
                let reach = cycle.swings[module].amplitude_rad.abs() + 1e-6;
                for p in curves.actual.iter().flatten().filter(|p| from + 0.1 < p.0 && p.0 < to) {
                    assert!((p.1 - centre).abs() <= reach, "module {module} at {} s", p.0);
                }
            }
        }
    }

    /// A line that was lifted once stays lifted: as many pieces as gaps, and one more, with every sample outside them.
    #[test]
    fn no_line_is_drawn_through_a_gap() {
        let mut record = crate::sample::run(2, 1, 20.0, [[0.04, 0.0], [0.0, 0.04]]);
        let before = Curves::new(&record, 0).actual;
        record.gaps = vec![[5.0, 9.0], [30.0, 31.0]];
        for gap in record.gaps.clone() {
            record.tails.retain(|tail| !(gap[0]..gap[1]).contains(&tail.t_s));
        }
        let after = Curves::new(&record, 0).actual;
        assert_eq!(after.len(), before.len() + 2);
        assert_eq!(after.iter().map(Vec::len).sum::<usize>(), record.tails.len());
        for run in &after {
            assert!(run.windows(2).all(|pair| pair[1].0 - pair[0].0 < 0.1), "drawn through a gap");
        }
    }

    #[test]
    fn a_transition_in_two_steps_is_drawn_by_way_of_its_pose_between() {
        let mut record = crate::sample::run(2, 1, 20.0, [[0.04, 0.0], [0.0, 0.04]]);
        let (before, via_rad) = (record.cycles[0].turns[1], record.cycles[0].turns[1].to_rad + 1.0);
        record.cycles[0].via = Some(ViaRecord { via_rad: vec![0.0, via_rad], turning_s: 0.1, rest_s: 0.2 });
        let planned = &Curves::new(&record, 1).planned[0];
        // From, there, still there, and where the swim begins; all shifted alike.
        let [from, there, still, to] = [0, 48, 49, 97].map(|k| planned[k]);
        for (seen, (t_s, rad)) in [from, there, still, to].iter().zip([
            (0.0, before.from_rad),
            (0.1, via_rad),
            (0.3, via_rad),
            (0.5, before.to_rad),
        ]) {
            assert!((seen.0 - t_s).abs() < 1e-12, "{seen:?} at {t_s} s");
            assert!((seen.1 - from.1 - (rad - before.from_rad)).abs() < 1e-9, "{seen:?} for {rad} rad");
        }
    }

    #[test]
    fn nine_modules_are_chosen_from_end_to_end() {
        assert_eq!(chosen(3), [0, 1, 2]);
        assert_eq!(chosen(25), [0, 3, 6, 9, 12, 15, 18, 21, 24]);
        for count in 10..60 {
            let some = chosen(count);
            assert_eq!((some[0], some[8], some.len()), (0, count - 1, MOST));
            assert!(some.is_sorted_by(|a, b| a < b), "{count}: {some:?}");
        }
    }
}
