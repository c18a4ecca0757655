//! The collision region of two tails in phase space (φᵢ, φⱼ), as a polygon (§II-A, Fig. 2).
//!
//! Let a and b be the angles of tail i and tail j off the line between their motor axes, zero where both point at each
//! other, and K the set of points within one width of centre line i. Tail j collides exactly when its centre line meets K.
//! K is convex and does not hold j's axis, so that the part of K within L of j's axis is convex too, and is seen from
//! that axis under one interval of directions:
//!
//! R = { (a, b) : abs(a) < reach, lo(a) < b < hi(a) }
//!
//! So there is at most one polygon in each period, without holes. It is traced with the exact test
//! ([`Tail::clearance_m`]) in slices that crowd towards both ends, where hi − lo vanishes like a square root; in each
//! slice hi is enclosed by the ITP method (Oliveira and Takahashi 2020) from where the slices before it point. The traced
//! curve is then moved inwards by δ and thinned out to chords that leave it by at most τ < δ. A chord then lies between the
//! depths δ − τ and δ + τ below the true boundary: it holds no free pose, and misses none deeper than δ + τ.
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | φᵢ, φⱼ | rad | tail angles, counter-clockwise from x_S; both 2π-periodic |
//! | reach | rad | greatest angle off the line at which a tail can touch the other ([`Tail::reach_rad`]) |
//! | δ, τ | rad | inset 0.5e-3 and thinning 0.4e-3, Euclidean in phase space; less for a tiny region |
//!
//! Assumptions: length + width < distance between the axes, which [`Parameters::validate`] demands. Without it a tail has
//! poses in which the other finds no free one, and the whole torus is returned as the region. Limits: tails thinner than
//! about a hundredth of their length pinch the region towards a bow tie whose neck the tracing does not resolve.
//!
//! [`Parameters::validate`]: super::parameters::Parameters::validate

use std::f64::consts::{PI, TAU};

use super::tail::Tail;

/// The polygon misses no collision that lies deeper than this below the boundary of the region, rad.
pub const DEPTH_RAD: f64 = 1e-3;
/// Inset δ, rad.
const INSET_RAD: f64 = 0.5 * DEPTH_RAD;
/// Thinning τ as a share of δ: what is left over covers the tracing itself.
const THINNING: f64 = 0.8;
/// Slices traced; in the middle of the default region they lie 0.6e-3 rad apart.
const SLICES: usize = 4096;
/// The boundary is enclosed to this, rad.
const ENCLOSED_RAD: f64 = 1e-7;

/// Where in phase space the tails of two modules at a fixed lattice offset collide.
#[derive(Clone, Debug)]
pub struct CollisionRegion {
    offset: [i32; 2],
    centre: [f64; 2],
    polygons: Vec<Vec<[f64; 2]>>,
}

impl CollisionRegion {
    /// Traces the region of tail i at the origin and tail j at `offset`. Empty if they cannot touch.
    #[must_use]
    pub fn new(tail: &Tail, offset: [i32; 2]) -> Self {
        Self::placed(offset, &local_polygons(tail, offset))
    }

    /// The regions of many offsets. Those of the same length differ by a rotation only, and are traced once.
    #[must_use]
    pub fn all(tail: &Tail, offsets: &[[i32; 2]]) -> Vec<Self> {
        let mut traced: Vec<(i64, Vec<Vec<[f64; 2]>>)> = Vec::new();
        let region = |&offset: &[i32; 2]| {
            let square = offset.iter().map(|&cells| i64::from(cells).pow(2)).sum();
            if let Some((_, polygons)) = traced.iter().find(|known| known.0 == square) {
                return Self::placed(offset, polygons);
            }
            let polygons = local_polygons(tail, offset);
            let region = Self::placed(offset, &polygons);
            traced.push((square, polygons));
            region
        };
        offsets.iter().map(region).collect()
    }

    /// From polygons in (a, b).
    fn placed(offset: [i32; 2], polygons: &[Vec<[f64; 2]>]) -> Self {
        let centre = centre(offset);
        let polygons = polygons.iter().map(|polygon| polygon.iter().map(|&p| sum(p, centre)).collect());
        Self { offset, centre, polygons: polygons.collect() }
    }

    /// From a polygon that is placed already, for tests of what is made of polygons.
    #[cfg(test)]
    pub(super) fn placed_at(offset: [i32; 2], polygon: Vec<[f64; 2]>) -> Self {
        Self { offset, centre: centre(offset), polygons: vec![polygon] }
    }

    /// The lattice offset cell_j − cell_i.
    #[must_use]
    pub fn offset(&self) -> [i32; 2] {
        self.offset
    }

    /// (φᵢ, φⱼ) of the tails that point at each other, rad: the centre of symmetry of the polygons.
    #[must_use]
    pub fn centre(&self) -> [f64; 2] {
        self.centre
    }

    /// The region of one period as closed polygons, counter-clockwise, the last vertex joined to the first, rad.
    #[must_use]
    pub fn polygons(&self) -> &[Vec<[f64; 2]>] {
        &self.polygons
    }

    /// True if the pose (φᵢ, φⱼ) lies in a polygon or in one of its copies, rad.
    #[must_use]
    pub fn contains(&self, pose_rad: [f64; 2]) -> bool {
        let near = [0, 1].map(|k| {
            let off = pose_rad[k] - self.centre[k];
            self.centre[k] + off - TAU * (off / TAU).round()
        });
        self.polygons.iter().any(|polygon| inside(polygon, near))
    }

    /// The copies of the polygons, 2π apart, whose bounding boxes meet the box from `low` to `high`, rad. For the paper's
    /// \[−2π, 2π\]² and for plots.
    #[must_use]
    pub fn copies(&self, low: [f64; 2], high: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let mut copies = Vec::new();
        for polygon in &self.polygons {
            let periods = |k: usize| {
                let least = polygon.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
                let most = polygon.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
                ((low[k] - most) / TAU).ceil() as i32..=((high[k] - least) / TAU).floor() as i32
            };
            for (x, y) in periods(0).flat_map(|x| periods(1).map(move |y| (x, y))) {
                let shift = [TAU * f64::from(x), TAU * f64::from(y)];
                copies.push(polygon.iter().map(|&p| sum(p, shift)).collect());
            }
        }
        copies
    }
}

fn sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Tails that point at each other: φᵢ along the offset, φⱼ against it.
fn centre(offset: [i32; 2]) -> [f64; 2] {
    let axis = f64::from(offset[1]).atan2(f64::from(offset[0]));
    [axis, axis + PI]
}

/// The region's polygons in (a, b).
fn local_polygons(tail: &Tail, offset: [i32; 2]) -> Vec<Vec<[f64; 2]>> {
    let reach = tail.reach_rad(offset);
    if reach <= 0.0 {
        Vec::new()
    } else if reach >= PI {
        vec![vec![[-PI, -PI], [PI, -PI], [PI, PI], [-PI, PI]]]
    } else {
        let (curve, inset) = trace(tail, offset);
        vec![thin(&shrink(&curve, inset), THINNING * inset)]
    }
}

/// Even-odd rule; a polygon's own boundary may count either way.
fn inside(polygon: &[[f64; 2]], p: [f64; 2]) -> bool {
    let mut odd = false;
    for (k, a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            odd = !odd;
        }
    }
    odd
}

/// The true boundary in (a, b), counter-clockwise from its leftmost point, and the inset that suits its size.
fn trace(tail: &Tail, offset: [i32; 2]) -> (Vec<[f64; 2]>, f64) {
    let (reach, centre) = (tail.reach_rad(offset), centre(offset));
    // The direction in which tail j points at the nearest point of tail i, the lines between the axes lying on x.
    let distance_m = f64::from(offset[0]).hypot(f64::from(offset[1])) * tail.pitch_m;
    let pointing = |a: f64| {
        let along_m = (distance_m * a.cos()).clamp(0.0, tail.length_m);
        -(along_m * a.sin()).atan2(distance_m - along_m * a.cos())
    };
    // The outermost colliding b from `pointing` towards the reach, beyond which nothing collides.
    let edge = |a: f64, guess: f64, slack: f64| {
        let clearance = |b: f64| tail.clearance_m(offset, centre[0] + a, centre[1] + b);
        enclose(clearance, pointing(a), reach * (1.0 + 1e-9), guess, slack)
    };
    let slice = |k: usize| -reach * (PI * k as f64 / SLICES as f64).cos();
    // From the right, where it begins at `pointing`; each slice continues the two before it.
    let (mut before, mut last, mut missed) = (pointing(reach), pointing(reach), reach);
    let upper: Vec<_> = (1..SLICES)
        .rev()
        .map(|k| {
            let guess = 2.0 * last - before;
            let b = edge(slice(k), guess, missed);
            missed = (b - guess).abs();
            (before, last) = (last, b);
            [slice(k), b]
        })
        .collect();
    // Both tails are alike on both sides, so that their mirror images collide too: lo(a) = −hi(−a).
    let lower = upper.iter().map(|&[a, b]| [-a, -b]);
    let curve = [[-reach, pointing(-reach)]]
        .into_iter()
        .chain(lower)
        .chain([[reach, pointing(reach)]])
        .chain(upper.iter().copied())
        .collect();
    // A tiny region is as round as its reach is small; a thin tail pinches it in the middle.
    let inset = INSET_RAD.min(0.02 * reach).min(0.05 * edge(0.0, 0.0, reach));
    (curve, inset)
}

/// Where `clearance` turns from negative at `hit` to positive at `free`, from the negative side, to [`ENCLOSED_RAD`]. It is
/// looked for about `guess` first, no nearer to it than `slack` suggests.
fn enclose(clearance: impl Fn(f64) -> f64, hit: f64, free: f64, guess: f64, slack: f64) -> f64 {
    // The ends count as what they are said to be; their values are of no use.
    let (mut hit, mut at_hit, mut free, mut at_free) = (hit, f64::NAN, free, f64::NAN);
    // Outwards from the guess, in ever longer steps, until the boundary lies between two points.
    let (mut at, mut step) = (guess, slack.max(ENCLOSED_RAD));
    while at > hit && at < free && (at_hit.is_nan() || at_free.is_nan()) {
        let value = clearance(at);
        if value < 0.0 {
            (hit, at_hit) = (at, value);
            at += step;
        } else {
            (free, at_free) = (at, value);
            at -= step;
        }
        step *= 4.0;
    }
    // ITP with κ₁ = 0.2 / width, κ₂ = 2, n₀ = 1: interpolate, truncate, project onto what bisection would guarantee.
    let (half, width) = (ENCLOSED_RAD / 2.0, free - hit);
    let mut allowed = half * 2.0_f64.powi((width / ENCLOSED_RAD).max(1.0).log2().ceil() as i32 + 1);
    while free - hit > ENCLOSED_RAD {
        let middle = hit.midpoint(free);
        let secant = (at_free * hit - at_hit * free) / (at_free - at_hit);
        let towards = (middle - secant).signum();
        let truncated = 0.2 * (free - hit).powi(2) / width;
        let aim = secant + towards * truncated;
        let radius = (allowed - (free - hit) / 2.0).max(0.0);
        let at = if truncated > (middle - secant).abs() || secant.is_nan() {
            middle
        } else if (aim - middle).abs() <= radius {
            aim
        } else {
            middle - towards * radius
        };
        let value = clearance(at);
        *(if value < 0.0 { &mut hit } else { &mut free }) = at;
        *(if value < 0.0 { &mut at_hit } else { &mut at_free }) = value;
        allowed /= 2.0;
    }
    hit
}

/// Moves every point of a smooth, dense, counter-clockwise curve inwards by `inset`, across the chord of its neighbours.
fn shrink(curve: &[[f64; 2]], inset: f64) -> Vec<[f64; 2]> {
    let n = curve.len();
    (0..n)
        .map(|k| {
            let (before, after) = (curve[(k + n - 1) % n], curve[(k + 1) % n]);
            let chord = [after[0] - before[0], after[1] - before[1]];
            let scale = inset / chord[0].hypot(chord[1]);
            [curve[k][0] - scale * chord[1], curve[k][1] + scale * chord[0]]
        })
        .collect()
}

/// Thins a closed curve out to chords that leave it by at most `tolerance` (Douglas and Peucker 1973), halves between its
/// first point and the one opposite.
fn thin(curve: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let n = curve.len();
    let mut kept = vec![false; n + 1];
    let mut open = vec![(0, n / 2), (n / 2, n)];
    while let Some((first, last)) = open.pop() {
        kept[first] = true;
        let (a, b) = (curve[first], curve[last % n]);
        let apart = (first + 1..last).map(|k| (k, to_segment_square(curve[k], a, b)));
        let worst = apart.max_by(|one, other| one.1.total_cmp(&other.1));
        if let Some((worst, _)) = worst.filter(|worst| worst.1 > tolerance * tolerance) {
            open.push((first, worst));
            open.push((worst, last));
        }
    }
    (0..n).filter(|&k| kept[k]).map(|k| curve[k]).collect()
}

/// Squared distance of a point from the segment between a and b.
fn to_segment_square(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (edge, off) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = edge[0] * edge[0] + edge[1] * edge[1];
    let share =
        if square > 0.0 { ((off[0] * edge[0] + off[1] * edge[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (off[0] - share * edge[0]).powi(2) + (off[1] - share * edge[1]).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_enclosed_from_any_guess_in_few_steps() {
        // Smooth, kinked, flat beside the root, and steep like a square root.
        let curves: [fn(f64) -> f64; 4] =
            [f64::sin, |x| if x < 0.0 { 9.0 * x } else { 0.1 * x }, |x| x.clamp(-1e-3, 1e-3), f64::cbrt];
        for (k, curve) in curves.into_iter().enumerate() {
            for root in [-0.9, 0.0, 0.3, 0.999] {
                for guess in [f64::NAN, -7.0, -0.8, root - 1e-6, root, root + 1e-3, 7.0] {
                    for slack in [0.0, 1e-6, 3.0] {
                        let asked = std::cell::Cell::new(0);
                        let clearance = |x: f64| {
                            asked.set(asked.get() + 1);
                            curve(x - root)
                        };
                        let hit = enclose(clearance, -1.0, 1.0, guess, slack);
                        let off = root - hit;
                        assert!((0.0..=ENCLOSED_RAD).contains(&off), "{k} {root} {guess} {slack}: {off}");
                        // Bisection alone takes 25; what the guess costs comes on top.
                        assert!(asked.get() <= 45, "{k} {root} {guess} {slack}: {} steps", asked.get());
                    }
                }
            }
        }
    }
}
