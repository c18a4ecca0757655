//! The envelope of a structure, in three planes of the space of wrenches, with demands in it and what there is of them.
//!
//! Each panel shows the section of the envelope with a plane through zero (a line: there the third component is zero)
//! and its shadow on that plane (shaded: there the third component may be anything). Where a structure is symmetric the
//! two coincide. A demand is a dot, blue inside the envelope and vermilion outside, wherever its third component
//! is; a dashed line leads to the ring on the border in its direction.
//!
//! The shadow is drawn as the polygon of its tangents, by the support function; it is wider by 2·10⁻⁵ of itself at most.

use std::f64::consts::TAU;

use modboat::envelope::{Envelope, ON_BORDER};
use modboat::motion::Wrench;

use super::axis::{Axis, number};
use super::lines::{self, Point, Window};
use super::picture::{self, Area, Chart, DrawError, Heading, Key, Panel};
use super::style;

/// Width of the picture, px.
const WIDTH: f64 = 1200.0;
/// Directions in which a panel's border is computed.
const DIRECTIONS: usize = 720;
/// What lies beyond this multiple of the envelope is not shown.
const REACH: f64 = 2.5;
/// What the three components are called.
const TITLES: [&str; 3] = ["Sway force Fx, mN", "Surge force Fy, mN", "Yaw torque τ, mN·m"];
/// The components across and up in each panel, and its title.
const PANELS: [([usize; 2], &str); 3] = [
    ([0, 1], "Fx and Fy, section at τ = 0"),
    ([0, 2], "Fx and τ, section at Fy = 0"),
    ([1, 2], "Fy and τ, section at Fx = 0"),
];

/// Draws the picture of the envelope of `name`, with these demands.
pub fn svg(name: &str, envelope: &Envelope, demands: &[Wrench]) -> Result<String, DrawError> {
    let extremes = extremes(envelope);
    let outside = demands.iter().filter(|demand| envelope.gauge(**demand) > ON_BORDER).count();
    let told = match (demands.len(), outside) {
        (0, _) => String::new(),
        (count, outside) => format!(" · demands {count}, outside {outside}"),
    };
    let [fx, fy, tau] = extremes.map(|v| number(1e3 * v, 1));
    let line = format!("Fx ±{fx} mN, Fy ±{fy} mN, τ ±{tau} mN·m, collisions ignored{told}");
    let heading = Heading { name, subject: "envelope of wrenches", line };
    let (body_width, _) = picture::body_size((WIDTH, 0.0));
    // Square charts: forces at the same scale.
    let height = picture::chart_width(body_width / 3.0) + picture::around(true, true);
    picture::render((WIDTH, picture::height_for(height)), &heading, |area| {
        let panels = area.split_evenly((1, 3));
        for (index, panel) in panels.iter().enumerate() {
            draw(panel, index, envelope, demands)?;
        }
        Ok(())
    })
}

/// The greatest force and torque along each axis.
fn extremes(envelope: &Envelope) -> [f64; 3] {
    [0, 1, 2].map(|axis| envelope.support([0, 1, 2].map(|k| if k == axis { 1.0 } else { 0.0 })))
}

fn direction(index: usize) -> (f64, f64) {
    (TAU * index as f64 / DIRECTIONS as f64).sin_cos()
}

/// The border of the section, N and N·m, closed.
fn section(envelope: &Envelope, [across, up]: [usize; 2]) -> Vec<Point> {
    let half = extremes(envelope);
    let border = (0..=DIRECTIONS).map(|index| {
        let (sin, cos) = direction(index);
        let mut demand = [0.0; 3];
        (demand[across], demand[up]) = (half[across] * cos, half[up] * sin);
        let border = envelope.boundary(Wrench::from_array(demand)).to_array();
        (border[across], border[up])
    });
    border.collect()
}

/// The corners of the shadow, N and N·m: where the tangents of neighbouring directions cross.
fn shadow(envelope: &Envelope, [across, up]: [usize; 2]) -> Vec<Point> {
    let half = extremes(envelope);
    // In units of the extremes, so that forces and torques weigh alike. One module alone has no torque.
    let weight = half.map(|half| if half > 0.0 { 1.0 / half } else { 0.0 });
    let height = |(sin, cos): (f64, f64)| {
        let mut normal = [0.0; 3];
        (normal[across], normal[up]) = (weight[across] * cos, weight[up] * sin);
        envelope.support(normal)
    };
    let turn = (TAU / DIRECTIONS as f64).sin();
    let corner = |index: usize| {
        let (here, next) = (direction(index), direction(index + 1));
        let (h_here, h_next) = (height(here), height(next));
        let x = (h_here * next.0 - h_next * here.0) / turn;
        let y = (h_next * here.1 - h_here * next.1) / turn;
        (half[across] * x, half[up] * y)
    };
    (0..DIRECTIONS).map(corner).collect()
}

fn draw(area: &Area<'_>, index: usize, envelope: &Envelope, demands: &[Wrench]) -> Result<(), DrawError> {
    let (axes, title) = PANELS[index];
    let milli = |wrench: Wrench| {
        let [across, up] = axes.map(|axis| 1e3 * wrench.to_array()[axis]);
        (across, up)
    };
    let half = extremes(envelope);
    // As far as the demands go, on both sides and alike for both forces.
    let reach = |axis: usize| {
        let seen = demands.iter().map(|demand| demand.to_array()[axis].abs());
        let most = seen.fold(half[axis], f64::max).min(REACH * half[axis]);
        1.12e3 * if most > 0.0 { most } else { 1e-3 }
    };
    let reach = axes.map(|axis| if axis < 2 { reach(0).max(reach(1)) } else { reach(2) });
    let window = Window { x: (-reach[0], reach[0]), y: (-reach[1], reach[1]) };
    let legend: &[(Key, &str)] = match (index, demands.is_empty()) {
        (0, _) => &[
            (Key::Line(style::HULL, 1.0, 2.0), "section"),
            (Key::Band(style::SKY, 0.3), "shadow, third free"),
        ],
        (1, false) => &[(Key::Dot(style::BLUE), "demand inside"), (Key::Dot(style::VERMILION), "outside")],
        (2, false) => &[(Key::Ring(style::HULL), "border in its direction")],
        _ => &[],
    };
    let [x, y] = [window.x, window.y].map(|(low, high)| Axis::exact(low, high, 5));
    let [x_title, y_title] = axes.map(|axis| Some(TITLES[axis]));
    let panel = Panel { legend, legend_below: true, x_title, y_title, ..Panel::new(title, x, y) };
    let chart = Chart::new(area, &panel)?;
    chart.line(vec![(window.x.0, 0.0), (window.x.1, 0.0)], style::line(style::FRAME, 1.0, 1.0))?;
    chart.line(vec![(0.0, window.y.0), (0.0, window.y.1)], style::line(style::FRAME, 1.0, 1.0))?;
    let in_milli = |points: Vec<Point>| points.into_iter().map(|p| (1e3 * p.0, 1e3 * p.1)).collect();
    chart.polygon(in_milli(shadow(envelope, axes)), style::fill(style::SKY, 0.3))?;
    chart.line(in_milli(section(envelope, axes)), style::line(style::HULL, 1.0, 2.0))?;
    let inside = |p: Point| p.0.abs() <= window.x.1 && p.1.abs() <= window.y.1;
    for &demand in demands {
        let gauge = envelope.gauge(demand);
        let at = milli(demand);
        if gauge > 0.0 && gauge.is_finite() {
            let border = milli(envelope.boundary(demand));
            if let Some((from, to)) = lines::clip_segment(window, at, border) {
                chart.dashed(&[from, to], style::line(style::MUTED, 0.8, 1.0))?;
            }
            chart.ring(border, 4.0, style::HULL)?;
        }
        if inside(at) {
            chart.dot(at, 3.5, if gauge <= ON_BORDER { style::BLUE } else { style::VERMILION })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use modboat::parameters::Parameters;
    use modboat::structure::Structure;

    use super::*;
    use crate::tests::assert_sound;

    /// 0.022·2.6 − 0.019 N.
    const F: f64 = 0.0382;

    fn envelope(picture: &str) -> Envelope {
        let structure = Structure::from_picture(picture).expect("a structure");
        Envelope::new(&structure.positions_m(0.15), &Parameters::default())
    }

    #[test]
    fn forces_without_torque_fill_a_disc() {
        for (picture, modules) in [("#", 1.0), ("###", 3.0), ("#.\n##", 3.0)] {
            for points in [section(&envelope(picture), [0, 1]), shadow(&envelope(picture), [0, 1])] {
                for p in points {
                    assert!((p.0.hypot(p.1) / (modules * F) - 1.0).abs() < 2e-5, "{picture}: {p:?}");
                }
            }
        }
    }

    /// A line is its own mirror image: shadow and section are one. A corner is not: freed of the demand that no force be
    /// left over, it has the torque of all its levers about the centre of mass, 0.15·(√2 + 2·√5)/3 m.
    #[test]
    fn a_shadow_holds_the_section() {
        let most = |points: &[Point]| points.iter().map(|p| p.1).fold(0.0, f64::max);
        for axes in [[0, 2], [1, 2]] {
            for picture in ["###", "#.\n##", "####\n#..#"] {
                let envelope = envelope(picture);
                let half = extremes(&envelope);
                let corners = shadow(&envelope, axes);
                for p in section(&envelope, axes) {
                    let mut wrench = [0.0; 3];
                    (wrench[axes[0]], wrench[axes[1]]) = p;
                    let gauge = envelope.gauge(Wrench::from_array(wrench));
                    assert!((gauge - 1.0).abs() < 1e-9, "{picture}: {p:?} has gauge {gauge}");
                    for pair in corners.windows(2) {
                        let [a, b] = [pair[0], pair[1]];
                        let turn = (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0);
                        assert!(turn > -1e-9 * half[axes[0]] * half[axes[1]], "{picture}: {p:?}");
                    }
                }
            }
            let line = envelope("###");
            assert!((most(&shadow(&line, axes)) / most(&section(&line, axes)) - 1.0).abs() < 1e-4);
            let corner = envelope("#.\n##");
            let levers_m = 0.15 * (2.0_f64.sqrt() + 2.0 * 5.0_f64.sqrt()) / 3.0;
            assert!((most(&shadow(&corner, axes)) / (F * levers_m) - 1.0).abs() < 1e-4);
            assert!(most(&section(&corner, axes)) < 0.995 * F * levers_m);
        }
    }

    #[test]
    fn every_panel_is_labelled_and_any_demand_can_be_drawn() {
        let wrench = |fx_n, fy_n, tau_nm| Wrench { fx_n, fy_n, tau_nm };
        let demands =
            [wrench(0.02, 0.0, 0.001), wrench(0.3, 0.0, 0.0), Wrench::default(), wrench(1e6, 0.0, -1e6)];
        let picture = svg("3 <modules>", &envelope("###"), &demands).expect("a picture");
        assert_sound("envelope", &picture);
        for label in TITLES.iter().chain(&[
            "3 &lt;modules&gt; · envelope of wrenches",
            "outside 2",
            "section at τ = 0",
        ]) {
            assert!(picture.contains(label), "{label} is missing");
        }
        // All but the last lie within 2.5 times the envelope: a dot in each panel, drawn with a radius of 3.5 px.
        assert_eq!(picture.matches("r=\"14\"").count(), 3 * 3, "dots");
        let lone = svg("one", &envelope("#"), &demands).expect("a picture");
        assert_sound("one alone", &lone);
        assert!(!svg("one", &envelope("#"), &[]).expect("a picture").contains("outside"));
    }
}
