//! Distance to collision against one polygon and its copies, 2π apart.
//!
//! With u the length along the line AB from A (so that B lies at u = abs(AB)), the paper's four cases (Fig. 3) are
//!
//! 1. AB outside: the least distance between AB and the polygon;
//! 2. AB enters at G and B lies inside: −abs(BG);
//! 3. AB inside, its extensions leave at G behind A and H ahead of B: −(abs(AB) + min(abs(AG), abs(BH)));
//! 4. AB crosses from G to H: −(abs(GH) + min(abs(AG), abs(BH))).
//!
//! Cases 2 to 4 are one: how far AB must be pushed along its own line until it is clear of the stretch from G to H,
//!
//! DoC = −min(u_H, abs(AB) − u_G)
//!
//! A line may cut a polygon that is not convex more than twice. G is then the first entry along AB, or, if A lies inside,
//! the nearest boundary point behind A; H is the last exit, or, if B lies inside, the nearest boundary point ahead of B.
//! What lies between G and H counts as inside. A motion that is no motion (A = B) has no line; inside the polygon its DoC is
//! minus its distance from the boundary.
//!
//! The planner calls this tens of thousands of times a second. So the outline is held in runs of edges with a
//! bounding circle each, by which most of it is rejected, and its inside in a row of [`COVERS`] circles along its longer
//! axis, by which most of its copies are. The result is exact all the same.

use std::f64::consts::TAU;

use super::{floor, nearest_whole};

/// Edges in one run of an outline.
const RUN: usize = 8;
/// Circles that cover the inside of an outline.
pub const COVERS: usize = 4;
/// Lower bounds are given up to this beyond the margin, rad.
const BOUND_AHEAD_RAD: f64 = 1.0;
/// Where the circles do not decide, the distance is worked out up to this beyond the margin, rad.
const EXACT_AHEAD_RAD: f64 = 0.4;
/// Runs whose distances are kept from one pass to the next; the default outline has 17.
const KEPT: usize = 32;
/// A shorter motion than this is a pose, rad.
const POSE_RAD: f64 = 1e-9;

/// Eight consecutive edges within a circle.
#[derive(Clone, Copy, Debug)]
struct Run {
    centre: [f64; 2],
    radius: f64,
    first: usize,
    last: usize,
}

/// A closed polygon, ready for distances to segments.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Middle of the bounding box; vertices and runs are relative to it.
    pub(super) centre: [f64; 2],
    radius: f64,
    /// The vertices, the first once more at the end.
    vertices: Vec<[f64; 2]>,
    edges: Vec<Edge>,
    runs: Vec<Run>,
    /// Circles that cover the inside.
    covers: Vec<Circle>,
}

type Circle = ([f64; 2], f64);

/// The segment AB with its direction.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    from: [f64; 2],
    to: [f64; 2],
    along: [f64; 2],
    length: f64,
}

impl Segment {
    pub(super) fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let step = [to[0] - from[0], to[1] - from[1]];
        let length = (step[0] * step[0] + step[1] * step[1]).sqrt();
        if length < POSE_RAD {
            return Self { from, to: from, along: [1.0, 0.0], length: 0.0 };
        }
        Self { from, to, along: [step[0] / length, step[1] / length], length }
    }

    fn moved(self, by: [f64; 2]) -> Self {
        let shift = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
        Self { from: shift(self.from), to: shift(self.to), ..self }
    }

    /// (u, v): length along the line from A, and to the left of it.
    #[inline]
    fn frame(&self, p: [f64; 2]) -> (f64, f64) {
        let (x, y) = (p[0] - self.from[0], p[1] - self.from[1]);
        (x * self.along[0] + y * self.along[1], y * self.along[0] - x * self.along[1])
    }

    /// Squared distance of the point at (u, v) from the segment.
    #[inline]
    fn square(&self, u: f64, v: f64) -> f64 {
        let beyond = (-u).max(u - self.length).max(0.0);
        beyond * beyond + v * v
    }
}

/// An edge from its first vertex, and 1 / length².
#[derive(Clone, Copy, Debug)]
struct Edge {
    start: [f64; 2],
    vector: [f64; 2],
    inverse_square: f64,
}

impl Edge {
    fn new(start: [f64; 2], end: [f64; 2]) -> Self {
        let vector = [end[0] - start[0], end[1] - start[1]];
        let square = vector[0] * vector[0] + vector[1] * vector[1];
        Self { start, vector, inverse_square: 1.0 / square.max(f64::MIN_POSITIVE) }
    }

    /// Squared distance of `p` from the edge.
    #[inline]
    fn square(&self, p: [f64; 2]) -> f64 {
        let off = [p[0] - self.start[0], p[1] - self.start[1]];
        let share = (off[0] * self.vector[0] + off[1] * self.vector[1]) * self.inverse_square;
        let share = share.clamp(0.0, 1.0);
        let (x, y) = (off[0] - share * self.vector[0], off[1] - share * self.vector[1]);
        x * x + y * y
    }
}

/// The circle about the middle of the points' bounding box.
fn circle(points: &[[f64; 2]]) -> Circle {
    let centre = [0, 1].map(|k| {
        let least = points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let most = points.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
        least.midpoint(most)
    });
    let radius = points.iter().map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1])).fold(0.0, f64::max);
    // Rounded up, so that rejecting by the circle never rejects the points.
    (centre, radius * (1.0 + 1e-12))
}

/// Circles that cover the inside of a closed polygon: it is cut across its longer axis into slices of equal width, and
/// each lies within the circle about its corners.
fn cover(vertices: &[[f64; 2]]) -> Vec<Circle> {
    let square = |p: &[f64; 2]| p[0] * p[0] + p[1] * p[1];
    let farthest =
        vertices.iter().max_by(|p, q| square(p).total_cmp(&square(q))).copied().unwrap_or_default();
    let along = |p: &[f64; 2]| p[0] * farthest[0] + p[1] * farthest[1];
    let least = vertices.iter().map(along).fold(f64::INFINITY, f64::min);
    let most = vertices.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
    let cut = |k: usize| least + (most - least) * k as f64 / COVERS as f64;
    let slice = |k: usize| {
        // The outermost cuts are drawn a little outside, so that rounding loses no vertex.
        let slack = 1e-9 * (most - least);
        let (low, high) = (cut(k) - slack, cut(k + 1) + slack);
        let mut corners: Vec<[f64; 2]> =
            vertices.iter().filter(|p| (low..=high).contains(&along(p))).copied().collect();
        for edge in vertices.windows(2) {
            let (a, b) = (along(&edge[0]), along(&edge[1]));
            for limit in [low, high] {
                if (a < limit) != (b < limit) {
                    let share = (limit - a) / (b - a);
                    corners.push([0, 1].map(|k| edge[0][k] + share * (edge[1][k] - edge[0][k])));
                }
            }
        }
        circle(&corners)
    };
    (0..COVERS).map(slice).collect()
}

impl Outline {
    /// From the vertices of a simple polygon in order, either way round; the last is joined to the first.
    #[must_use]
    pub fn new(polygon: &[[f64; 2]]) -> Self {
        let (centre, radius) = circle(polygon);
        let closed = polygon.iter().chain(polygon.first());
        let vertices: Vec<_> = closed.map(|p| [p[0] - centre[0], p[1] - centre[1]]).collect();
        let edges: Vec<_> = vertices.windows(2).map(|pair| Edge::new(pair[0], pair[1])).collect();
        let runs = (0..edges.len())
            .step_by(RUN)
            .map(|first| {
                let last = (first + RUN).min(edges.len());
                let (centre, radius) = circle(&vertices[first..=last]);
                Run { centre, radius, first, last }
            })
            .collect();
        let covers = cover(&vertices);
        Self { centre, radius, vertices, edges, runs, covers }
    }

    /// DoC of the motion AB against this polygon alone, without copies; rad.
    #[must_use]
    pub fn distance(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let segment = Segment::new(from, to).moved([-self.centre[0], -self.centre[1]]);
        self.least(&segment, f64::INFINITY)
    }

    /// DoC of a segment relative to the outline's centre, or `best` if it is not below that.
    fn least(&self, segment: &Segment, best: f64) -> f64 {
        let (u, v) = segment.frame([0.0, 0.0]);
        let reach = best.max(0.0) + self.radius;
        let square = segment.square(u, v);
        if square >= reach * reach {
            return best;
        }
        if square < self.radius * self.radius
            && let Some(overlap) = self.overlap(segment)
        {
            let depth = if segment.length > 0.0 { overlap } else { self.clearance(segment, f64::INFINITY) };
            return best.min(-depth);
        }
        if best > 0.0 { self.clearance(segment, best) } else { best }
    }

    /// min(u_H, abs(AB) − u_G) if AB and the polygon overlap.
    fn overlap(&self, segment: &Segment) -> Option<f64> {
        let (mut behind, mut ahead) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut entry, mut exit) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut from_inside, mut to_inside) = (false, false);
        for run in &self.runs {
            if segment.frame(run.centre).1.abs() > run.radius {
                continue;
            }
            let (mut u, mut v) = segment.frame(self.vertices[run.first]);
            for &vertex in &self.vertices[run.first + 1..=run.last] {
                let (u_next, v_next) = segment.frame(vertex);
                if (v < 0.0) != (v_next < 0.0) {
                    let cut = u + (u_next - u) * (v / (v - v_next));
                    if cut < 0.0 {
                        behind = behind.max(cut);
                        from_inside = !from_inside;
                    } else if cut > segment.length {
                        ahead = ahead.min(cut);
                        to_inside = !to_inside;
                    } else {
                        entry = entry.min(cut);
                        exit = exit.max(cut);
                    }
                }
                (u, v) = (u_next, v_next);
            }
        }
        if !from_inside && !to_inside && entry > exit {
            return None;
        }
        let entry = if from_inside { behind } else { entry };
        let exit = if to_inside { ahead } else { exit };
        Some(exit.min(segment.length - entry))
    }

    /// Least distance between the segment and the boundary, neither crossing the other, or `best` (> 0) if it is not
    /// below that.
    fn clearance(&self, segment: &Segment, best: f64) -> f64 {
        // The run whose circle lies nearest first: it rejects most of the others.
        let nearest = |run: &Run| {
            let (u, v) = segment.frame(run.centre);
            segment.square(u, v)
        };
        let mut least = if best.is_finite() { best * best } else { f64::INFINITY };
        let (mut first, mut first_square) = (0, f64::INFINITY);
        let mut squares = [0.0; KEPT];
        for (k, run) in self.runs.iter().enumerate() {
            let square = nearest(run);
            if let Some(kept) = squares.get_mut(k) {
                *kept = square;
            }
            if square < first_square {
                (first, first_square) = (k, square);
            }
        }
        let before = least;
        if let Some(run) = self.runs.get(first) {
            least = self.clearance_of(run, segment, least);
        }
        let mut reach = least.sqrt();
        for (k, run) in self.runs.iter().enumerate() {
            let near = reach + run.radius;
            let square = squares.get(k).copied().unwrap_or_else(|| nearest(run));
            if k != first && square < near * near {
                least = self.clearance_of(run, segment, least);
                reach = least.sqrt();
            }
        }
        if least < before { reach } else { best }
    }

    /// Least squared distance between the segment and one run's edges, or `least` if it is not below that.
    fn clearance_of(&self, run: &Run, segment: &Segment, mut least: f64) -> f64 {
        for &vertex in &self.vertices[run.first..=run.last] {
            let (u, v) = segment.frame(vertex);
            least = least.min(segment.square(u, v));
        }
        // Where an end of AB is nearest to the middle of an edge. Beside the run that is no question.
        let (u, _) = segment.frame(run.centre);
        let edges = &self.edges[run.first..run.last];
        if u < run.radius {
            least = edges.iter().fold(least, |least, edge| least.min(edge.square(segment.from)));
        }
        if u > segment.length - run.radius {
            least = edges.iter().fold(least, |least, edge| least.min(edge.square(segment.to)));
        }
        least
    }
}

impl Outline {
    /// DoC of a segment relative to the centre over all copies, or `best` if it is not below that.
    pub(super) fn least_of_copies(&self, segment: &Segment, mut best: f64, enough: f64) -> f64 {
        let low = [0, 1].map(|k: usize| segment.from[k].min(segment.to[k]) / TAU);
        let high = [0, 1].map(|k: usize| segment.from[k].max(segment.to[k]) / TAU);
        let back = |period: [i32; 2]| period.map(|k| -TAU * f64::from(k));
        // The copy whose centre lies nearest comes first: it rejects most of the others.
        let (mut nearest, mut nearest_square) = ([0; 2], f64::INFINITY);
        for x in nearest_whole(low[0])..=nearest_whole(high[0]) {
            for y in nearest_whole(low[1])..=nearest_whole(high[1]) {
                let (u, v) = segment.frame([TAU * f64::from(x), TAU * f64::from(y)]);
                let square = segment.square(u, v);
                if square < nearest_square {
                    (nearest, nearest_square) = ([x, y], square);
                }
            }
        }
        best = self.least(&segment.moved(back(nearest)), best);
        // Any other copy that could matter has its centre within best + radius of the segment.
        let near = (best.max(0.0) + self.radius) / TAU;
        for x in -floor(near - low[0])..=floor(high[0] + near) {
            for y in -floor(near - low[1])..=floor(high[1] + near) {
                if best < enough {
                    return best;
                }
                if [x, y] != nearest {
                    best = self.least(&segment.moved(back([x, y])), best);
                }
            }
        }
        best
    }

    /// A lower bound of the distance between the segment and the inside; below zero it says nothing.
    fn bound(&self, segment: &Segment) -> f64 {
        self.covers.iter().fold(f64::INFINITY, |bound, &(centre, radius)| {
            let (u, v) = segment.frame(centre);
            bound.min(segment.square(u, v).sqrt() - radius)
        })
    }

    /// DoC over all copies of a segment relative to the centre if that is below `margin` (≥ 0), otherwise a lower
    /// bound of it that is not.
    pub(super) fn bounded_over_copies(&self, segment: &Segment, margin: f64) -> f64 {
        // What is further away than this is not looked at.
        let mut bound = margin + BOUND_AHEAD_RAD;
        let near = (bound + self.radius) / TAU;
        let periods = |k: usize| {
            let (low, high) =
                (segment.from[k].min(segment.to[k]) / TAU, segment.from[k].max(segment.to[k]) / TAU);
            -floor(near - low)..=floor(high + near)
        };
        for (x, y) in periods(0).flat_map(|x| periods(1).map(move |y| (x, y))) {
            let moved = segment.moved([-TAU * f64::from(x), -TAU * f64::from(y)]);
            let apart = self.bound(&moved);
            bound = if apart >= margin {
                bound.min(apart)
            } else {
                self.least(&moved, bound.min(margin + EXACT_AHEAD_RAD))
            };
        }
        bound
    }
}
