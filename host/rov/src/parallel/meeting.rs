//! Whether two robots keep clear of each other at every instant, without sampling.
//!
//! In a common piece of time the way from one to the other is a polynomial q(t) of second degree, and so is n·q(t) for a
//! fixed direction n: its least value has a closed form.
//!
//! ```text
//! hulls apart      some axis n of the two:   |n·q(t)| ≥ reach(n)           in the whole piece
//! (19)             n = q(m)/|q(m)|:          n·q(t) ≥ d, hence |q(t)| ≥ d   in the whole piece, m its middle
//! ```
//!
//! Where neither holds for the piece, the middle is looked at: if the rule is broken there, the two meet; otherwise both
//! halves are examined. A piece of less than [`RESOLUTION_S`] that is not settled counts as broken, so that what is
//! called clear is clear.
//!
//! A robot in the open keeps d of (19) from every other one, moving or not; within its dock zones hulls may touch.

use super::super::clearance::TOUCH_M;
use super::super::configuration;
use super::super::vector::{dot, length};
use super::track::{Outline, Piece};

/// Shorter pieces of time are not parted, s.
const RESOLUTION_S: f64 = 1e-6;

/// What a robot needs around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Size {
    /// Half its length, width and height, m.
    pub half_m: [f64; 3],
    /// d of (19), m.
    pub distance_m: f64,
}

/// Where it is: a half-open cover of time, in order.
pub(super) type Track = [Piece];

/// Whether the two keep clear of each other as long as both tracks last.
pub(super) fn keep_clear(own: (Size, &Track), other: (Size, &Track)) -> bool {
    let (mut a, mut b) = (0, 0);
    while let (Some(first), Some(second)) = (own.1.get(a), other.1.get(b)) {
        let span_s = [first.from_s.max(second.from_s), first.to_s.min(second.to_s)];
        if span_s[1] > span_s[0] && !pieces_keep_clear((own.0, first), (other.0, second), span_s) {
            return false;
        }
        if first.to_s <= second.to_s {
            a += 1;
        } else {
            b += 1;
        }
    }
    true
}

/// q(t) of two pieces, with t from the beginning of their span.
struct Between {
    coefficients: [[f64; 3]; 3],
}

impl Between {
    fn at(&self, t_s: f64) -> [f64; 3] {
        let [p, v, h] = &self.coefficients;
        [0, 1, 2].map(|k| p[k] + t_s * (v[k] + t_s * h[k]))
    }

    /// The least of n·q over a span.
    fn least(&self, n: [f64; 3], [from_s, to_s]: [f64; 2]) -> f64 {
        let [p, v, h] = self.coefficients.map(|coefficient| dot(n, coefficient));
        let value = |t_s: f64| p + t_s * (v + t_s * h);
        let ends = value(from_s).min(value(to_s));
        // The vertex of a parabola that is open upwards.
        let vertex_s = if h > 0.0 { -v / (2.0 * h) } else { from_s };
        if vertex_s > from_s && vertex_s < to_s { ends.min(value(vertex_s)) } else { ends }
    }

    fn at_rest(&self) -> bool {
        self.coefficients[1..].as_flattened().iter().all(|component| *component == 0.0)
    }
}

fn pieces_keep_clear(own: (Size, &Piece), other: (Size, &Piece), [from_s, to_s]: [f64; 2]) -> bool {
    let (a, b) = (own.1.motion(from_s), other.1.motion(from_s));
    let between = Between { coefficients: [0, 1, 2].map(|n| [0, 1, 2].map(|k| b[n][k] - a[n][k])) };
    let whole_s = [0.0, to_s - from_s];
    // Poses in a file may touch by more than a moving robot does.
    let touch_m = if between.at_rest() { configuration::TOUCH_M } else { TOUCH_M };
    let distance_m = [own, other].into_iter().filter(|of| of.1.open).map(|of| of.0.distance_m);
    let kept_m = distance_m.fold(0.0, f64::max);
    if kept_m > 0.0 && !settled(whole_s, &|span_s| distance(&between, kept_m - TOUCH_M, span_s)) {
        return false;
    }
    let hulls = [(own.0.half_m, own.1.outline), (other.0.half_m, other.1.outline)];
    settled(whole_s, &|span_s| hulls_apart(&between, &hulls, touch_m, span_s))
}

/// Parts a span until every part of it is decided.
fn settled(span_s: [f64; 2], decide: &impl Fn([f64; 2]) -> Option<bool>) -> bool {
    match decide(span_s) {
        Some(clear) => clear,
        None if span_s[1] - span_s[0] < RESOLUTION_S => false,
        None => {
            let middle_s = 0.5 * (span_s[0] + span_s[1]);
            settled([span_s[0], middle_s], decide) && settled([middle_s, span_s[1]], decide)
        }
    }
}

fn distance(between: &Between, least_m: f64, span_s: [f64; 2]) -> Option<bool> {
    let middle_m = between.at(0.5 * (span_s[0] + span_s[1]));
    let apart_m = length(middle_m);
    if apart_m < least_m {
        return Some(false);
    }
    let n = middle_m.map(|component| component / apart_m);
    (between.least(n, span_s) >= least_m).then_some(true)
}

type Hull = ([f64; 3], Outline);

/// Half of what a hull takes up along a level direction.
fn support_m(([x, y, _], outline): &Hull, n: [f64; 3]) -> f64 {
    match outline {
        Outline::Turning => x.hypot(*y),
        Outline::Held(yaw_rad) => {
            let (sin, cos) = yaw_rad.sin_cos();
            x * (cos * n[0] + sin * n[1]).abs() + y * (cos * n[1] - sin * n[0]).abs()
        }
    }
}

fn hulls_apart(between: &Between, hulls: &[Hull; 2], touch_m: f64, span_s: [f64; 2]) -> Option<bool> {
    let middle_m = between.at(0.5 * (span_s[0] + span_s[1]));
    let mut apart = false;
    // Whether an axis separates the two all the time; whether it does in the middle is noted.
    let mut separates = |n: [f64; 3], reach_m: f64| {
        let reach_m = reach_m - touch_m;
        let side = if dot(n, middle_m) < 0.0 { n.map(|component| -component) } else { n };
        apart |= dot(side, middle_m) >= reach_m;
        between.least(side, span_s) >= reach_m
    };
    if separates([0.0, 0.0, 1.0], hulls[0].0[2] + hulls[1].0[2]) {
        return Some(true);
    }
    let mut level = |n: [f64; 3]| separates(n, support_m(&hulls[0], n) + support_m(&hulls[1], n));
    for (_, outline) in hulls {
        if let Outline::Held(yaw_rad) = outline {
            let (sin, cos) = yaw_rad.sin_cos();
            if level([cos, sin, 0.0]) || level([-sin, cos, 0.0]) {
                return Some(true);
            }
        }
    }
    // A circle is separated from a box along the way from the box's nearest point, from a circle from its centre.
    if let Some(n) = towards_circle(middle_m, hulls)
        && level(n)
    {
        return Some(true);
    }
    (!apart).then_some(false)
}

/// The level direction from the nearest point of one outline to the centre of a circle; `None` for two boxes.
fn towards_circle(middle_m: [f64; 3], hulls: &[Hull; 2]) -> Option<[f64; 3]> {
    let [x, y, _] = middle_m;
    let from = match hulls.map(|(_, outline)| outline) {
        [Outline::Held(_), Outline::Held(_)] => return None,
        [Outline::Turning, Outline::Turning] => [x, y],
        // From the box to the circle, whichever is the first.
        [Outline::Held(yaw_rad), Outline::Turning] => beyond(hulls[0].0, yaw_rad, [x, y]),
        [Outline::Turning, Outline::Held(yaw_rad)] => beyond(hulls[1].0, yaw_rad, [-x, -y]),
    };
    let size_m = from[0].hypot(from[1]);
    (size_m > 0.0).then(|| [from[0] / size_m, from[1] / size_m, 0.0])
}

/// What of a way from the centre of a box lies beyond the box.
fn beyond(half_m: [f64; 3], yaw_rad: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = yaw_rad.sin_cos();
    let past = |value: f64, half: f64| value - value.clamp(-half, half);
    let (ahead, aside) = (past(cos * x + sin * y, half_m[0]), past(cos * y - sin * x, half_m[1]));
    [cos * ahead - sin * aside, sin * ahead + cos * aside]
}

#[cfg(test)]
mod tests;
