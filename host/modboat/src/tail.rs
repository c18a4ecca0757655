//! One Modboat's tail as a capsule, and the exact collision test of two of them.
//!
//! A tail's centre line runs from the motor axis at the module's centre, `length` far, in the direction φ
//! (counter-clockwise from x_S); every point within half a `width` of it belongs to the tail. Two tails overlap
//! exactly when their centre lines come closer than one width:
//!
//! clearance(φᵢ, φⱼ) = dist(centre line i, centre line j) − width
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | φᵢ, φⱼ | rad | tail angles of module i (at the origin) and module j (at offset·pitch) |
//! | o | m | vector from module i to module j, offset·pitch |
//! | e(φ) | – | (cos φ, sin φ) |
//! | L, w, D | m | length, width, length of o |
//!
//! Assumptions: rigid tails in one horizontal plane; a tail meets tails only, never a hull. The paper leaves tail
//! geometry to its reference \[9\]; the capsule and its measures are *assumed*.

use std::f64::consts::TAU;

use quantity::vector::dot;

use super::parameters::Parameters;

/// How exact [`Tail::least_along_m`] is, m.
pub const CLEARANCE_TOLERANCE_M: f64 = 1e-5;
/// The longest turn that is looked at, rad; a longer one counts as colliding, with a clearance of −∞.
pub const TURN_MAX_RAD: f64 = 1e3;
/// Stretches between the poses of [`Tail::nearest_sample`].
const SAMPLES: usize = 4;
/// Halvings at most, and so intervals held at once: 40 take the longest turn down to 1e-9 rad.
const STACK: usize = 40;

/// The capsule that every module of a fleet swings about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tail {
    /// Lattice pitch d, m.
    pub pitch_m: f64,
    /// Length of the centre line from the motor axis, m.
    pub length_m: f64,
    /// Full width, m.
    pub width_m: f64,
}

/// Two centre lines in one pose: their distance, and the direction n from i's nearest point to j's.
struct Pose {
    distance_m: f64,
    normal: [f64; 2],
    tail_i: [f64; 2],
    tail_j: [f64; 2],
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// e(φ).
fn unit(phi_rad: f64) -> [f64; 2] {
    let (sin, cos) = phi_rad.sin_cos();
    [cos, sin]
}

/// e(φ + δ) from e(φ) and e(δ).
fn turned(along: [f64; 2], by: [f64; 2]) -> [f64; 2] {
    [along[0] * by[0] - along[1] * by[1], along[1] * by[0] + along[0] * by[1]]
}

/// e(φ − δ) from e(φ) and e(δ).
fn unturned(along: [f64; 2], by: [f64; 2]) -> [f64; 2] {
    turned(along, [by[0], -by[1]])
}

/// The vector from the segment `0 … end` to `point`, by the shortest way.
fn from_segment(point: [f64; 2], end: [f64; 2]) -> [f64; 2] {
    let square = dot(end, end);
    let share = if square > 0.0 { (dot(point, end) / square).clamp(0.0, 1.0) } else { 0.0 };
    [point[0] - share * end[0], point[1] - share * end[1]]
}

impl Tail {
    /// The tail that parameters describe.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            pitch_m: parameters.pitch_m,
            length_m: parameters.tail_length_m,
            width_m: parameters.tail_width_m,
        }
    }

    /// The vector o from module i to module j, m.
    fn vector_m(&self, offset: [i32; 2]) -> [f64; 2] {
        [f64::from(offset[0]) * self.pitch_m, f64::from(offset[1]) * self.pitch_m]
    }

    /// Distance D between the motor axes, m.
    fn distance_m(&self, offset: [i32; 2]) -> f64 {
        let [x_m, y_m] = self.vector_m(offset);
        x_m.hypot(y_m)
    }

    /// Both tails with the directions e(φᵢ), e(φⱼ).
    fn pose(&self, vector_m: [f64; 2], along: [[f64; 2]; 2]) -> Pose {
        let [tail_i, tail_j] = along.map(|e| [self.length_m * e[0], self.length_m * e[1]]);
        // Two segments o₁ + s·e₁ and o₂ + t·e₂ cross where s·(e₁×e₂) = o×e₂ and t·(e₁×e₂) = o×e₁ with s, t ∈ [0, 1].
        let determinant = cross(tail_i, tail_j);
        if determinant != 0.0 {
            let along_i = cross(vector_m, tail_j) / determinant;
            let along_j = cross(vector_m, tail_i) / determinant;
            if (0.0..=1.0).contains(&along_i) && (0.0..=1.0).contains(&along_j) {
                return Pose { distance_m: 0.0, normal: [1.0, 0.0], tail_i, tail_j };
            }
        }
        // Otherwise an end of one of them is nearest: root and tip of j against i, of i against j.
        let tip_j = [vector_m[0] + tail_j[0], vector_m[1] + tail_j[1]];
        let root_i = from_segment([-vector_m[0], -vector_m[1]], tail_j);
        let tip_i = from_segment([tail_i[0] - vector_m[0], tail_i[1] - vector_m[1]], tail_j);
        let mut nearest = from_segment(vector_m, tail_i);
        let mut least = dot(nearest, nearest);
        for candidate in [from_segment(tip_j, tail_i), [-root_i[0], -root_i[1]], [-tip_i[0], -tip_i[1]]] {
            let square = dot(candidate, candidate);
            if square < least {
                (nearest, least) = (candidate, square);
            }
        }
        let distance_m = least.sqrt();
        let normal =
            if distance_m > 0.0 { [nearest[0] / distance_m, nearest[1] / distance_m] } else { [1.0, 0.0] };
        Pose { distance_m, normal, tail_i, tail_j }
    }

    /// Distance between the surfaces of tail i at the origin and tail j at `offset`, m; negative: they overlap.
    #[must_use]
    pub fn clearance_m(&self, offset: [i32; 2], phi_i_rad: f64, phi_j_rad: f64) -> f64 {
        self.pose(self.vector_m(offset), [phi_i_rad, phi_j_rad].map(unit)).distance_m - self.width_m
    }

    /// The lattice offsets at which two tails can touch at all, one of each ± pair: the one with col > 0, or with col = 0
    /// and row > 0. Nearest first.
    ///
    /// Two tails that point at each other come as close as D − 2L, and no pose is closer: D < 2L + w.
    #[must_use]
    pub fn reachable_offsets(&self) -> Vec<[i32; 2]> {
        // Nearest first, so that the sides come before the diagonals.
        let most = ((2.0 * self.length_m + self.width_m) / self.pitch_m).min(1e3) as i32 + 1;
        let mut offsets: Vec<[i32; 2]> = (0..=most)
            .flat_map(|col| (-most..=most).map(move |row| [col, row]))
            .filter(|&[col, row]| col > 0 || row > 0)
            .filter(|&offset| self.distance_m(offset) < 2.0 * self.length_m + self.width_m)
            .collect();
        offsets.sort_by_key(|&[col, row]| (col * col + row * row, -col, -row));
        offsets
    }

    /// The greatest angle off the line between the two motor axes at which a tail can still touch the other, rad; zero if
    /// it never can.
    ///
    /// Tail j reaches every point within L + w of its axis (a width counts once, between the centre lines). Beyond the
    /// foot of the perpendicular that is a matter of the tip, before it of the perpendicular:
    ///
    /// cos φ = (D² + L² − (L + w)²) / (2·D·L)   if D·cos φ ≥ L,   otherwise   sin φ = (L + w) / D
    #[must_use]
    pub fn reach_rad(&self, offset: [i32; 2]) -> f64 {
        let (d_m, l_m, r_m) = (self.distance_m(offset), self.length_m, self.length_m + self.width_m);
        if d_m >= l_m + r_m {
            return 0.0;
        }
        if d_m <= r_m {
            return std::f64::consts::PI;
        }
        let cos = (d_m.powi(2) + l_m.powi(2) - r_m.powi(2)) / (2.0 * d_m * l_m);
        if d_m * cos >= l_m { cos.clamp(-1.0, 1.0).acos() } else { (r_m / d_m).asin() }
    }

    /// Least clearance while both tails turn from `from` to `to` (φᵢ, φⱼ in rad) along the straight segment between them, or
    /// `known_m` if it is not below that, m; exact to [`CLEARANCE_TOLERANCE_M`]. The less is known, the less is looked at.
    ///
    /// For any fixed direction n, the distance is at least the width of the slab across n that separates the tails:
    ///
    /// dist ≥ n·o − max(0, L·n·e(φᵢ)) − max(0, −L·n·e(φⱼ))
    ///
    /// With n from the nearest points at the middle of an interval this bounds the distance over the whole of it, and
    /// never worse than that each tip moves at most L·Δφ. Intervals that could hold less than the least so far are
    /// halved.
    #[must_use]
    pub fn least_along_m(&self, offset: [i32; 2], from_rad: [f64; 2], to_rad: [f64; 2], known_m: f64) -> f64 {
        self.search_m(offset, from_rad, to_rad, known_m, f64::NEG_INFINITY)
    }

    /// True if the tails keep at least `margin_m` between their surfaces from `from` to `to`. Leaves at the first pose that
    /// does not. A pose within [`CLEARANCE_TOLERANCE_M`] of the margin may be called either way.
    #[must_use]
    pub fn clears_along(
        &self,
        offset: [i32; 2],
        from_rad: [f64; 2],
        to_rad: [f64; 2],
        margin_m: f64,
    ) -> bool {
        self.search_m(offset, from_rad, to_rad, f64::INFINITY, margin_m) >= margin_m
    }

    /// True if the tails overlap anywhere from `from` to `to`, by the exact test to [`CLEARANCE_TOLERANCE_M`].
    #[must_use]
    pub fn collides_along(&self, offset: [i32; 2], from_rad: [f64; 2], to_rad: [f64; 2]) -> bool {
        !self.clears_along(offset, from_rad, to_rad, 0.0)
    }

    /// The nearest of five poses evenly spread from `from` to `to`: clearance, m, and the angles (φᵢ, φⱼ), rad. Not below the
    /// least clearance along the way.
    #[must_use]
    pub fn nearest_sample(&self, offset: [i32; 2], from_rad: [f64; 2], to_rad: [f64; 2]) -> (f64, [f64; 2]) {
        let vector_m = self.vector_m(offset);
        let step = [0, 1].map(|k| (to_rad[k] - from_rad[k]) / SAMPLES as f64);
        let by = step.map(unit);
        let mut along = from_rad.map(unit);
        let mut nearest = (f64::INFINITY, from_rad);
        for sample in 0..=SAMPLES {
            let distance_m = self.pose(vector_m, along).distance_m;
            if distance_m < nearest.0 {
                nearest = (distance_m, [0, 1].map(|k| from_rad[k] + sample as f64 * step[k]));
            }
            along = [turned(along[0], by[0]), turned(along[1], by[1])];
        }
        (nearest.0 - self.width_m, nearest.1)
    }

    /// Least clearance over the tube about the motion from `from` to `to`: both tails anywhere within ±`error_rad` of where they
    /// are planned to be, or `known_m` if it is not below that, m. Exact to [`CLEARANCE_TOLERANCE_M`] where it is below
    /// D − L − w, the distance from a tip to the other's axis.
    ///
    /// The tube is a hexagon in phase space. The poses closer than some distance r < D − L are a connected set about the pose in
    /// which the tails point at each other (see [`region`](super::region)), so that within a hexagon without that pose the
    /// clearance is least on its edges.
    #[must_use]
    pub fn tube_clearance_m(
        &self,
        offset: [i32; 2],
        from_rad: [f64; 2],
        to_rad: [f64; 2],
        error_rad: f64,
        known_m: f64,
    ) -> f64 {
        let step = [0, 1].map(|k| to_rad[k] - from_rad[k]);
        if self.points_at_each_other(offset, from_rad, step, error_rad) {
            return known_m.min(-self.width_m);
        }
        // Corners of the box in the direction of the motion: ahead, to either side, behind.
        let ahead = [0, 1].map(|k| if step[k] < 0.0 { -error_rad } else { error_rad });
        let at = |pose: [f64; 2], signs: [f64; 2]| [0, 1].map(|k| pose[k] + signs[k] * ahead[k]);
        let (behind, left, right, front) = ([-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]);
        let corners = [
            at(from_rad, left),
            at(to_rad, left),
            at(to_rad, front),
            at(to_rad, right),
            at(from_rad, right),
            at(from_rad, behind),
            at(from_rad, left),
        ];
        corners
            .windows(2)
            .fold(known_m, |least_m, edge| self.least_along_m(offset, edge[0], edge[1], least_m))
    }

    /// Whether the pose in which the tails point at each other lies in the tube. So does a motion that is none.
    fn points_at_each_other(
        &self,
        offset: [i32; 2],
        from_rad: [f64; 2],
        step: [f64; 2],
        error_rad: f64,
    ) -> bool {
        let axis = f64::from(offset[1]).atan2(f64::from(offset[0]));
        let centre = [axis, axis + std::f64::consts::PI];
        let sound = |k: usize| step[k].abs() <= TURN_MAX_RAD && from_rad[k].is_finite();
        if !(sound(0) && sound(1)) {
            return true;
        }
        // The copies within the span of each angle.
        let copies = |k: usize| {
            let (low, high) = (step[k].min(0.0) - error_rad, step[k].max(0.0) + error_rad);
            let off = (centre[k] - from_rad[k] - low).rem_euclid(TAU) + low;
            std::iter::successors(Some(off), |off| Some(off + TAU)).take_while(move |&off| off <= high)
        };
        // The stretch of the motion in which angle k is within its error of that copy.
        let during = |k: usize, off: f64| {
            if step[k] == 0.0 {
                return if off.abs() <= error_rad { [0.0, 1.0] } else { [1.0, 0.0] };
            }
            let ends = [(off - error_rad) / step[k], (off + error_rad) / step[k]];
            [ends[0].min(ends[1]).max(0.0), ends[0].max(ends[1]).min(1.0)]
        };
        copies(0).any(|i| {
            let first = during(0, i);
            copies(1).any(|j| {
                let second = during(1, j);
                first[0].max(second[0]) <= first[1].min(second[1])
            })
        })
    }

    /// The least clearance if it is below `known_m`, or the first one found below `enough_m`.
    fn search_m(
        &self,
        offset: [i32; 2],
        from_rad: [f64; 2],
        to_rad: [f64; 2],
        known_m: f64,
        enough_m: f64,
    ) -> f64 {
        let vector_m = self.vector_m(offset);
        let step = [to_rad[0] - from_rad[0], to_rad[1] - from_rad[1]];
        // A NaN, an infinity or an absurd turn never clears.
        if !(step[0].abs() <= TURN_MAX_RAD && step[1].abs() <= TURN_MAX_RAD) {
            return f64::NEG_INFINITY;
        }
        let mut least_m = known_m + self.width_m;
        // An interval's half-length as a share of the whole, how often it was halved, and the directions in its middle. Halving
        // turns those by the same angles for all intervals of a depth: e(step·2^−(depth + 2)).
        let middle = [0, 1].map(|k| unit(from_rad[k] + 0.5 * step[k]));
        let mut stack = [(0.5, 0, middle); STACK];
        let mut held = 1;
        let mut turns: [[[f64; 2]; 2]; STACK] = [[[0.0; 2]; 2]; STACK];
        let mut deepest = 0;
        while held > 0 && least_m > 0.0 && least_m - self.width_m >= enough_m {
            held -= 1;
            let (half, depth, along) = stack[held];
            let pose = self.pose(vector_m, along);
            least_m = least_m.min(pose.distance_m);
            let reach_i = extent_m(pose.tail_i, pose.normal, half * step[0].abs());
            let back = [-pose.normal[0], -pose.normal[1]];
            let reach_j = extent_m(pose.tail_j, back, half * step[1].abs());
            let bound_m = dot(pose.normal, vector_m) - reach_i - reach_j;
            // What is certainly above the least so far or the margin asked for needs no closer look.
            let above = bound_m >= least_m - CLEARANCE_TOLERANCE_M
                || (enough_m.is_finite() && bound_m - self.width_m >= enough_m);
            if !above && depth == 0 {
                // What is certainly above as a whole needs no look at its ends.
                for end_rad in [from_rad, to_rad] {
                    least_m = least_m.min(self.pose(vector_m, end_rad.map(unit)).distance_m);
                }
            }
            if !above && held + 2 <= STACK && depth < STACK {
                let quarter = 0.5 * half;
                if depth == deepest {
                    turns[depth] = [0, 1].map(|k| unit(quarter * step[k]));
                    deepest += 1;
                }
                let [i, j] = turns[depth];
                let earlier = [unturned(along[0], i), unturned(along[1], j)];
                let later = [turned(along[0], i), turned(along[1], j)];
                stack[held] = (quarter, depth + 1, earlier);
                stack[held + 1] = (quarter, depth + 1, later);
                held += 2;
            }
        }
        least_m - self.width_m
    }
}

/// The most that a tail reaches along `direction` (unit) from its motor axis while it turns by up to ±`turn_rad`, m:
///
/// cos(x ± δ) ≤ cos x + δ·|sin x|, and if cos x < 0 at most ½δ²·|cos x| more
fn extent_m(tail_m: [f64; 2], direction: [f64; 2], turn_rad: f64) -> f64 {
    let (along, across) = (dot(tail_m, direction), cross(tail_m, direction).abs());
    let curved = if along < 0.0 { -along * turn_rad * turn_rad / 2.0 } else { 0.0 };
    (along + across * turn_rad + curved).max(0.0)
}
