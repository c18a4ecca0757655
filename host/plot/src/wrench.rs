//! `wrench.svg`: the wrench of every cycle as demanded by the controller, as the plan yields it by law (7), and as
//! the tails exerted it on the water. In real water nothing measures that: there is no such curve then, and the legend says so.

use record::{CycleRecord, RunRecord};

use super::axis::{Axis, extent, number};
use super::lines::Point;
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style::{self, Anchor};
use super::trajectory::leg_marks;

/// Size of the picture, px.
const SIZE: (f64, f64) = (1200.0, 800.0);

/// Draws the picture of demanded, planned and achieved wrenches, as SVG.
pub fn svg(record: &RunRecord) -> Result<String, DrawError> {
    let heading = Heading { name: &record.name, subject: "wrench per cycle", line: summary(record) };
    picture::render(SIZE, &heading, |area| {
        for (component, panel) in picture::stacked(area, 3).iter().enumerate() {
            draw(panel, record, component)?;
        }
        Ok(())
    })
}

/// The figures first: a long description is cut at its end.
fn summary(record: &RunRecord) -> String {
    let rms = |component: usize| {
        let misses = record.cycles.iter().filter_map(|cycle| {
            let miss = cycle.achieved? - cycle.commanded;
            miss.to_array().get(component).copied().filter(|m| m.is_finite())
        });
        let (count, sum) = misses.fold((0, 0.0), |(n, sum), miss| (n + 1, sum + miss * miss));
        number((sum / f64::from(count.max(1))).sqrt() * 1e3, 2)
    };
    let (count, s) = (record.cycles.len(), if record.cycles.len() == 1 { "" } else { "s" });
    if !is_measured(record) {
        return format!(
            "{count} cycle{s}; nothing measures the wrench that was achieved · {}",
            record.description
        );
    }
    format!(
        "{count} cycle{s}; rms of achieved − plan {} mN, {} mN, {} mN·m · {}",
        rms(0),
        rms(1),
        rms(2),
        record.description
    )
}

/// Whether anything measured the wrench on the water.
fn is_measured(record: &RunRecord) -> bool {
    record.cycles.is_empty() || record.cycles.iter().any(|cycle| cycle.achieved.is_some())
}

/// A step line: one value over each cycle, transition included.
fn steps(cycles: &[CycleRecord], value: impl Fn(&CycleRecord) -> f64) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::with_capacity(2 * cycles.len());
    for cycle in cycles {
        let (start_s, value) = (cycle.start_s, value(cycle));
        let end_s = start_s + cycle.transition_s + cycle.period_s;
        if [start_s, end_s, value].iter().all(|v| v.is_finite()) {
            points.push((start_s, value));
            points.push((end_s, value));
        }
    }
    points
}

fn draw(area: &Area<'_>, record: &RunRecord, component: usize) -> Result<(), DrawError> {
    let milli = |cycle: &CycleRecord, which: usize| {
        let wrench = match which {
            0 => cycle.demand,
            1 => cycle.commanded,
            // What is no number is not drawn.
            _ => match cycle.achieved {
                Some(wrench) => wrench,
                None => return f64::NAN,
            },
        };
        1e3 * wrench.to_array().get(component).copied().unwrap_or_default()
    };
    let [demand, commanded, achieved] = [0, 1, 2].map(|which| steps(&record.cycles, |c| milli(c, which)));
    let all = || demand.iter().chain(&commanded).chain(&achieved);
    // Zero belongs on every one of these axes.
    let (low, high) = extent(all().map(|p| p.1)).map_or((-1.0, 1.0), |(l, h)| (l.min(0.0), h.max(0.0)));
    // The names of the legs stand above the curves of the first panel.
    let names_legs = component == 0 && record.legs.len() > 1;
    let high = if names_legs { high + 0.1 * (high - low) } else { high };
    let legs = record.legs.iter().map(|leg| leg.end_s);
    let (start_s, end_s) = extent(all().map(|p| p.0).chain(legs)).unwrap_or((0.0, 1.0));
    let on_the_water = match is_measured(record) {
        true => "achieved on the water",
        false => "achieved: not measured",
    };
    let legend = [
        (Key::Line(style::DEMAND, 0.3, 6.0), "demand"),
        (Key::Line(style::BLUE, 1.0, 2.0), "plan, law (7)"),
        (Key::Line(style::ORANGE, 1.0, 1.75), on_the_water),
    ];
    let is_last = component == 2;
    let title = ["Sway force Fx, mN", "Surge force Fy, mN", "Yaw torque τ, mN·m"][component.min(2)];
    let panel = Panel {
        legend: if component == 0 { &legend } else { &[] },
        x_title: is_last.then_some("Time, s"),
        ..Panel::new(title, Axis::time(start_s.min(0.0), end_s, 13), Axis::padded(low, high, 6))
    };
    let chart = Chart::new(area, &panel)?;
    let across = chart.x();
    chart.line(vec![(across.start, 0.0), (across.end, 0.0)], style::line(style::FRAME, 1.0, 1.0))?;
    leg_marks(&chart, record)?;
    if names_legs {
        let label = style::text(style::SIZE_TICK, style::MUTED, Anchor::Start);
        for (index, leg) in record.legs.iter().enumerate() {
            if across.contains(&leg.start_s) {
                let top = (leg.start_s, chart.y().end);
                chart.text(&format!("leg {}", index + 1), top, (6.0, 9.0), &label)?;
            }
        }
    }
    // Steps of a few px in a long run need finer lines.
    let step_px = chart.scale().0 * record.mean_interval_s();
    let fine = (step_px / 8.0).clamp(0.5, 1.0);
    chart.line(demand, style::line(style::DEMAND, 0.3, 6.0 * fine))?;
    chart.line(commanded, style::line(style::BLUE, 1.0, 2.0 * fine))?;
    chart.line(achieved, style::line(style::ORANGE, 1.0, 1.75 * fine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_span_transition_and_swim() {
        let mut record = crate::sample::run(3, 1, 4.0, [[0.04, 0.0]; 2]);
        let achieved = |cycle: &CycleRecord| cycle.achieved.map_or(f64::NAN, |wrench| wrench.fy_n);
        record.cycles[1].achieved = None;
        let points = steps(&record.cycles, achieved);
        let values: Vec<f64> = [0, 2, 3].map(|k| achieved(&record.cycles[k])).to_vec();
        let times: Vec<f64> = points.iter().map(|p| p.0).collect();
        assert_eq!(times, [0.0, 2.0, 4.0, 6.0, 6.0, 8.0]);
        assert_eq!(points.iter().step_by(2).map(|p| p.1).collect::<Vec<_>>(), values);
        assert_eq!(points.iter().skip(1).step_by(2).map(|p| p.1).collect::<Vec<_>>(), values);
    }
    /// A picture of real water has two curves, and says why there is no third.
    #[test]
    fn what_was_not_measured_is_not_drawn_as_zero() {
        let measured = crate::sample::run(3, 1, 4.0, [[0.04, 0.0]; 2]);
        let mut real = measured.clone();
        for cycle in &mut real.cycles {
            cycle.achieved = None;
        }
        let [measured, real] = [&measured, &real].map(|record| svg(record).expect("a picture"));
        let curves = |svg: &str| svg.matches("<polyline").count();
        assert!(measured.contains("achieved on the water") && measured.contains("rms of achieved"));
        assert!(real.contains("achieved: not measured") && real.contains("nothing measures the wrench"));
        // One a panel, and the one in the legend stays.
        assert_eq!(curves(&measured) - curves(&real), 3, "{} {}", curves(&measured), curves(&real));
    }
}
