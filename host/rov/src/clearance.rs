//! Clearance of one robot from the others at rest: condition v3 with (19).
//!
//! ```text
//! d = k·max(L, W, H), k = 3/2          (19)
//! ```
//!
//! The paper says d between "the current location and the goal location"; taken at its word no robot could dock. It is
//! read so: farther than d from its own start and from its own slot (outside the *dock zones*) the mover's centre keeps
//! at least d to the centre of every resting body; nearer, hulls may touch and not overlap.
//!
//! **Headings.** Inside its dock zones a mover holds the heading that it undocks or docks with, and turns only where it has room: where
//! the upright cylinder around its hull is free of every resting hull and lies in the water ([`Clearance::turn_is_free`]). That holds in both
//! zones, where they overlap, and outside. By the paper's rules, which do not look at turns, the hull is taken as at the start where its centre is nearer to the
//! start and as in the slot where it is nearer to the slot; where the two headings differ, the way crosses from one to the other
//! where there is room ([`Clearance::docked_leg_is_free`]).
//!
//! Both parts are exact along a straight leg, without sampling. Outside the zones: the distance from a point to a
//! segment. Inside: hulls are level boxes, so two of them overlap if and only if their heights overlap and their
//! outlines do, and the outlines, two rectangles, overlap if and only if they do on each of their four normals
//! (separating axes). While one moves at a constant heading, it overlaps on each of the five axes for one interval of
//! the leg; a leg is blocked where the five intervals have a common interior.

use quantity::wrap_rad;
use reconfiguration::pose::Pose;

use super::vector::{dot, offset};
use super::water::Water;

/// Headings that differ by less are the same, rad.
const SAME_RAD: f64 = 1e-9;

/// Hulls may overlap by this much on their way past each other, m: rounding of poses that touch.
pub const TOUCH_M: f64 = 1e-6;

/// A body at rest that the mover keeps clear of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resting {
    /// Where.
    pub pose: Pose,
    /// Half its length, width and height, m.
    pub half_m: [f64; 3],
}

/// Bodies at rest around one mover, and the distance that it keeps from them.
#[derive(Clone, Debug)]
pub struct Clearance {
    /// Bodies at rest.
    pub resting: Vec<Resting>,
    /// Half the mover's length, width and height, m.
    pub half_m: [f64; 3],
    /// Where it starts.
    pub start: Pose,
    /// Where it is to go.
    pub slot: Pose,
    /// d of (19), m; also the radius of the dock zones.
    pub distance_m: f64,
    /// The water: no part of a hull leaves it.
    pub water: Water,
}

/// Part of a leg, in shares of its length.
type Interval = (f64, f64);

impl Clearance {
    /// Whether the straight leg is free for the hull at heading `yaw_rad`.
    #[must_use]
    pub fn leg_is_free(&self, from_m: [f64; 3], to_m: [f64; 3], yaw_rad: f64) -> bool {
        if !self.water.holds_leg([from_m, to_m], self.half_m, yaw_rad, TOUCH_M) {
            return false;
        }
        // Most of the water is far from all bodies: only those near the leg are looked at closely.
        let leg_m = offset(from_m, to_m);
        let per_length = 1.0 / dot(leg_m, leg_m).max(f64::MIN_POSITIVE);
        let own_m2 = dot(self.half_m, self.half_m);
        let is_near = |body: &&Resting| {
            let there_m = offset(from_m, body.pose.position_m);
            let share = (dot(there_m, leg_m) * per_length).clamp(0.0, 1.0);
            let apart_m: [f64; 3] = std::array::from_fn(|k| there_m[k] - share * leg_m[k]);
            // (|a| + |b|)² ≤ 2(|a|² + |b|²)
            let touching_m2 = 2.0 * (own_m2 + dot(body.half_m, body.half_m));
            dot(apart_m, apart_m) < touching_m2.max(self.distance_m * self.distance_m)
        };
        let mut zones = None;
        self.resting.iter().filter(is_near).all(|body| {
            let zones = zones.get_or_insert_with(|| self.outside_zones(from_m, leg_m));
            self.keeps_distance(body, from_m, leg_m, zones) && !self.overlaps(body, from_m, leg_m, yaw_rad)
        })
    }

    /// Whether the straight leg is free for a hull that is turned as at the start where it is nearer to the start, and as
    /// in the slot where it is nearer to the slot, with room to turn where that changes.
    #[must_use]
    pub fn docked_leg_is_free(&self, from_m: [f64; 3], to_m: [f64; 3]) -> bool {
        let (start, slot) = (&self.start, &self.slot);
        if wrap_rad(start.yaw_rad - slot.yaw_rad).abs() < SAME_RAD {
            return self.leg_is_free(from_m, to_m, start.yaw_rad);
        }
        let way_m = offset(start.position_m, slot.position_m);
        let half_m2 = 0.5 * dot(way_m, way_m);
        // Below zero nearer to the start, above it nearer to the slot.
        let side = |at_m: [f64; 3]| dot(offset(start.position_m, at_m), way_m) - half_m2;
        let (first, last, rounding) = (side(from_m), side(to_m), 1e-9 * half_m2);
        // An end between the two belongs to both.
        let stays = |value: f64, at_m: [f64; 3]| value.abs() > rounding || self.turn_is_free(at_m);
        if !stays(first, from_m) || !stays(last, to_m) {
            return false;
        }
        let heading = |value: f64| if value > 0.0 { slot.yaw_rad } else { start.yaw_rad };
        if first.abs() <= rounding || last.abs() <= rounding || (first > 0.0) == (last > 0.0) {
            let decisive = if first.abs() > last.abs() { first } else { last };
            return self.leg_is_free(from_m, to_m, heading(decisive));
        }
        let share = first / (first - last);
        let between_m = std::array::from_fn(|k| from_m[k] + share * (to_m[k] - from_m[k]));
        self.turn_is_free(between_m)
            && self.leg_is_free(from_m, between_m, heading(first))
            && self.leg_is_free(between_m, to_m, heading(last))
    }

    /// Whether the robot may turn in place: the upright cylinder around its hull overlaps no body and stays in the water.
    #[must_use]
    pub fn turn_is_free(&self, at_m: [f64; 3]) -> bool {
        let radius_m = self.half_m[0].hypot(self.half_m[1]);
        self.water.holds_cylinder(at_m, radius_m, self.half_m[2], TOUCH_M)
            && self.resting.iter().all(|body| {
                let apart_m = offset(body.pose.position_m, at_m);
                if apart_m[2].abs() >= self.half_m[2] + body.half_m[2] - TOUCH_M {
                    return true;
                }
                let (sin, cos) = body.pose.yaw_rad.sin_cos();
                let [x, y] = [cos * apart_m[0] + sin * apart_m[1], cos * apart_m[1] - sin * apart_m[0]];
                let [dx, dy] = [(x.abs() - body.half_m[0]).max(0.0), (y.abs() - body.half_m[1]).max(0.0)];
                dx.hypot(dy) >= radius_m - TOUCH_M
            })
    }

    /// The parts of a leg outside the dock zones.
    fn outside_zones(&self, from_m: [f64; 3], leg_m: [f64; 3]) -> [Interval; 3] {
        let zones = [&self.start, &self.slot].map(|pose| {
            within(offset(pose.position_m, from_m), leg_m, self.distance_m).unwrap_or((0.0, 0.0))
        });
        // What the two zones leave of [0, 1] is at most three pieces.
        let [first, second] = if zones[0].0 <= zones[1].0 { zones } else { [zones[1], zones[0]] };
        [(0.0, first.0), (first.1, second.0), (first.1.max(second.1), 1.0)]
    }

    /// (19) on those parts.
    fn keeps_distance(
        &self,
        body: &Resting,
        from_m: [f64; 3],
        leg_m: [f64; 3],
        outside: &[Interval; 3],
    ) -> bool {
        let near = within(offset(body.pose.position_m, from_m), leg_m, self.distance_m - TOUCH_M);
        near.is_none_or(|near| !outside.iter().any(|piece| has_interior(near, *piece)))
    }

    /// Whether the hulls overlap anywhere on the leg.
    fn overlaps(&self, body: &Resting, from_m: [f64; 3], leg_m: [f64; 3], yaw_rad: f64) -> bool {
        let start_m = offset(body.pose.position_m, from_m);
        let mut common = (0.0, 1.0);
        let mut meet = |along: f64, motion: f64, reach: f64| {
            common = intersection(common, slab(along, motion, reach - TOUCH_M));
            has_interior(common, (0.0, 1.0))
        };
        if !meet(start_m[2], leg_m[2], self.half_m[2] + body.half_m[2]) {
            return false;
        }
        let relative_rad = yaw_rad - body.pose.yaw_rad;
        let (sin, cos) = (relative_rad.sin().abs(), relative_rad.cos().abs());
        let [a, b] = [self.half_m, body.half_m];
        let reaches = [
            // Normals of the mover's outline, then of the resting body's.
            (yaw_rad, a[0] + b[0] * cos + b[1] * sin, a[1] + b[0] * sin + b[1] * cos),
            (body.pose.yaw_rad, b[0] + a[0] * cos + a[1] * sin, b[1] + a[0] * sin + a[1] * cos),
        ];
        reaches.into_iter().all(|(yaw, forward, sideways)| {
            let (sin, cos) = yaw.sin_cos();
            let ahead = |v: [f64; 3]| cos * v[0] + sin * v[1];
            let right = |v: [f64; 3]| cos * v[1] - sin * v[0];
            meet(ahead(start_m), ahead(leg_m), forward) && meet(right(start_m), right(leg_m), sideways)
        })
    }
}

/// Where |start + s·leg| ≤ radius for s in [0, 1].
fn within(start: [f64; 3], leg: [f64; 3], radius: f64) -> Option<Interval> {
    // |start|² + 2s start·leg + s²|leg|² ≤ radius²
    let (a, b, c) = (dot(leg, leg), dot(start, leg), dot(start, start) - radius * radius);
    if a == 0.0 {
        return (c <= 0.0).then_some((0.0, 1.0));
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let span = intersection((0.0, 1.0), ((-b - root) / a, (-b + root) / a));
    (span.0 <= span.1).then_some(span)
}

/// Where |along + s·motion| < reach.
fn slab(along: f64, motion: f64, reach: f64) -> Interval {
    if motion.abs() < 1e-12 {
        return if along.abs() < reach { (f64::NEG_INFINITY, f64::INFINITY) } else { (1.0, 0.0) };
    }
    let (s, t) = ((-reach - along) / motion, (reach - along) / motion);
    if s < t { (s, t) } else { (t, s) }
}

fn intersection(a: Interval, b: Interval) -> Interval {
    (a.0.max(b.0), a.1.min(b.1))
}

/// Whether the two have more than a point in common.
fn has_interior(a: Interval, b: Interval) -> bool {
    let (low, high) = intersection(a, b);
    low < high - 1e-12
}

#[cfg(test)]
mod tests {
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use super::super::vector::length;
    use super::*;

    const HALF_M: [f64; 3] = [0.2415, 0.165, 0.1335];

    fn clearance(resting: Vec<Resting>) -> Clearance {
        Clearance {
            resting,
            half_m: HALF_M,
            start: Pose::from([-1.0, 0.0, 0.0, 0.0]),
            slot: Pose::from([1.5, 0.0, 0.0, 0.0]),
            distance_m: 0.7245,
            water: [[-4.0; 3], [4.0; 3]].into(),
        }
    }

    /// Corners of a hull's outline.
    fn corners(at: [f64; 3], half: [f64; 3], yaw: f64) -> [[f64; 2]; 4] {
        let (sin, cos) = yaw.sin_cos();
        [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]].map(|[a, b]| {
            let (x, y) = (a * half[0], b * half[1]);
            [at[0] + cos * x - sin * y, at[1] + sin * x + cos * y]
        })
    }

    /// Area that two convex outlines share, by clipping one against the other's edges.
    fn shared_area(a: [[f64; 2]; 4], b: [[f64; 2]; 4]) -> f64 {
        let mut polygon = a.to_vec();
        for k in 0..4 {
            let (p, q) = (b[k], b[(k + 1) % 4]);
            // The outlines run clockwise: inside is to the right.
            let side = |v: [f64; 2]| (q[0] - p[0]) * (v[1] - p[1]) - (q[1] - p[1]) * (v[0] - p[0]);
            let mut kept = Vec::new();
            for n in 0..polygon.len() {
                let (v, w) = (polygon[n], polygon[(n + 1) % polygon.len()]);
                let (s, t) = (side(v), side(w));
                if s <= 0.0 {
                    kept.push(v);
                }
                if (s < 0.0 && t > 0.0) || (s > 0.0 && t < 0.0) {
                    let u = s / (s - t);
                    kept.push([v[0] + u * (w[0] - v[0]), v[1] + u * (w[1] - v[1])]);
                }
            }
            polygon = kept;
        }
        let turns = |n: usize| {
            let (v, w) = (polygon[n], polygon[(n + 1) % polygon.len()]);
            v[0] * w[1] - v[1] * w[0]
        };
        0.5 * (0..polygon.len()).map(turns).sum::<f64>().abs()
    }

    #[test]
    fn a_leg_is_blocked_exactly_where_samples_of_it_overlap_or_come_too_near() {
        let seed = 7;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut blocked, mut free) = (0, 0);
        for case in 0..4000 {
            let mut point = |spread: f64| [0.0; 3].map(|_: f64| spread * (2.0 * rng.random::<f64>() - 1.0));
            let (position_m, from_m, to_m) = (point(1.0), point(2.0), point(2.0));
            let yaws = point(3.2);
            let body = Resting { pose: Pose { position_m, yaw_rad: yaws[0] }, half_m: HALF_M };
            let water = clearance(vec![body]);
            let exact = water.leg_is_free(from_m, to_m, yaws[1]);
            let (mut least_m, mut most_m3) = (f64::INFINITY, 0.0_f64);
            for n in 0..=400 {
                let s = f64::from(n) / 400.0;
                let at: [f64; 3] = std::array::from_fn(|k| from_m[k] + s * (to_m[k] - from_m[k]));
                let apart_m = length(offset(at, position_m));
                let near = |pose: &Pose| length(offset(pose.position_m, at)) <= water.distance_m;
                if !near(&water.start) && !near(&water.slot) {
                    least_m = least_m.min(apart_m);
                }
                let height = (2.0 * HALF_M[2] - (at[2] - position_m[2]).abs()).max(0.0);
                let area = shared_area(corners(at, HALF_M, yaws[1]), corners(position_m, HALF_M, yaws[0]));
                most_m3 = most_m3.max(area * height);
            }
            // Between two samples a leg moves at most 0.02 m.
            if exact {
                free += 1;
                assert!(least_m > water.distance_m - 1e-5, "seed {seed}, case {case}: {least_m} m");
                assert!(most_m3 < 1e-6, "seed {seed}, case {case}: {most_m3} m³");
            } else {
                blocked += 1;
                let grazed = least_m < water.distance_m + 0.02 || most_m3 > 0.0 || {
                    // A graze between samples.
                    let slim = |half: [f64; 3]| half.map(|h| h + 0.02);
                    (0..=400).any(|n| {
                        let s = f64::from(n) / 400.0;
                        let at: [f64; 3] = std::array::from_fn(|k| from_m[k] + s * (to_m[k] - from_m[k]));
                        (at[2] - position_m[2]).abs() < 2.0 * HALF_M[2] + 0.02
                            && shared_area(
                                corners(at, slim(HALF_M), yaws[1]),
                                corners(position_m, HALF_M, yaws[0]),
                            ) > 0.0
                    })
                };
                assert!(grazed, "seed {seed}, case {case}: {least_m} m, {most_m3} m³");
            }
        }
        assert!(blocked > 500 && free > 500, "{blocked} blocked, {free} free");
    }

    #[test]
    fn a_docked_leg_is_free_where_its_hull_is_at_the_heading_of_the_nearer_end() {
        let seed = 8;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut free, mut blocked, mut grazed, mut turning) = (0, 0, 0, 0);
        for case in 0..3000 {
            let mut point = |spread: f64| [0.0; 3].map(|_: f64| spread * (2.0 * rng.random::<f64>() - 1.0));
            let (position_m, from_m, to_m, yaws) = (point(0.8), point(1.2), point(1.2), point(3.2));
            let mut water =
                clearance(vec![Resting { pose: Pose { position_m, yaw_rad: yaws[0] }, half_m: HALF_M }]);
            water.start = Pose::from([-0.4, 0.1, 0.0, yaws[1]]);
            water.slot = Pose::from([0.5, -0.2, 0.1, yaws[2]]);
            let at = |n: u32| {
                let s = f64::from(n) / 400.0;
                std::array::from_fn(|k| from_m[k] + s * (to_m[k] - from_m[k]))
            };
            let is_nearer_to_slot = |at_m: [f64; 3]| {
                let [start, slot] =
                    [&water.start, &water.slot].map(|pose| length(offset(pose.position_m, at_m)));
                slot < start
            };
            let open = |at_m: [f64; 3]| {
                let nearer = if is_nearer_to_slot(at_m) { &water.slot } else { &water.start };
                water.leg_is_free(at_m, at_m, nearer.yaw_rad)
            };
            let change = (0..400).find(|&n| is_nearer_to_slot(at(n)) != is_nearer_to_slot(at(n + 1)));
            let samples_are_open = (0..=400).all(|n| open(at(n)));
            let what = format!("seed {seed}, case {case}");
            if water.docked_leg_is_free(from_m, to_m) {
                free += 1;
                assert!(samples_are_open, "{what}");
                // Within a step of where the one heading becomes the other there is room.
                let near =
                    |n: u32| (n.saturating_sub(1)..=(n + 2).min(400)).any(|n| water.turn_is_free(at(n)));
                assert!(change.is_none_or(near), "{what}: no room to turn");
                turning += usize::from(change.is_some());
            } else {
                blocked += 1;
                let has_room =
                    change.is_none_or(|n| water.turn_is_free(at(n)) && water.turn_is_free(at(n + 1)));
                grazed += usize::from(samples_are_open && has_room);
            }
        }
        assert!(
            free > 300 && blocked > 300 && turning > 100,
            "{free} free, {blocked} blocked, {turning} turning"
        );
        assert!(grazed < blocked / 50, "{grazed} of {blocked} are open at every sample");
    }

    #[test]
    fn docked_hulls_slide_along_each_other_and_do_not_turn() {
        let neighbour = Resting { pose: Pose::from([-1.0, 0.33, 0.0, 0.0]), half_m: HALF_M };
        let water = clearance(vec![neighbour]);
        let start = [-1.0, 0.0, 0.0];
        assert!(water.leg_is_free(start, [-1.5, 0.0, 0.0], 0.0), "backwards");
        assert!(water.leg_is_free(start, [-1.0, -0.5, 0.0], 0.0), "sideways, away");
        assert!(!water.leg_is_free(start, [-1.0, 0.1, 0.0], 0.0), "sideways, into it");
        assert!(!water.turn_is_free(start));
        // Half a diagonal and half a width apart they do.
        assert!(water.turn_is_free([-1.0, -0.13, 0.0]) && !water.turn_is_free([-1.0, -0.12, 0.0]));
    }
}
