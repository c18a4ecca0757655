//! The water of a problem: a level box that may be turned against the axes that the problem is given in.
//!
//! Corners in a file lie along the axes of the world, planning does not ([`frame`](super::frame)). Seen from there the box
//! is turned; what it holds stays the same to rounding.
//!
//! ```text
//! v = R_z(−ψ)·p        a place p in the axes of the box, which are turned by ψ
//! low ≤ v ± reach ≤ high
//! ```
//!
//! Besides, the edge of the water may be a polygon, seen from above: no part of a hull comes nearer to it than its margin. Along a straight
//! leg the hull sweeps the convex outline around its two ends.

use std::sync::Arc;

use quantity::bounds::Bounds;

use super::vector::turned;

/// A level box of water.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    /// Its corners along its own axes, m, from the origin that places are given from.
    low_m: [f64; 3],
    high_m: [f64; 3],
    /// Heading of its first axis, rad.
    yaw_rad: f64,
    /// Cosine and sine of it.
    turn: [f64; 2],
    /// The edge, if it is a polygon.
    edge: Option<Arc<Bounds>>,
}

impl From<[[f64; 3]; 2]> for Water {
    /// Between two corners, along the axes that places are given in.
    fn from(corners_m: [[f64; 3]; 2]) -> Self {
        Self::new(corners_m, 0.0)
    }
}

impl Water {
    /// Between two corners along axes that are turned by `yaw_rad`, m.
    #[must_use]
    pub fn new([low_m, high_m]: [[f64; 3]; 2], yaw_rad: f64) -> Self {
        let (sin, cos) = yaw_rad.sin_cos();
        Self { low_m, high_m, yaw_rad, turn: [cos, sin], edge: None }
    }

    /// The part of it within a polygon.
    #[must_use]
    pub fn within(self, edge: Option<Bounds>) -> Self {
        Self { edge: edge.map(Arc::new), ..self }
    }

    /// The edge of the water, if it is a polygon.
    #[must_use]
    pub fn edge(&self) -> Option<&Bounds> {
        self.edge.as_deref()
    }

    /// Whether a level box that swims straight from one place to another, its heading held, stays in it; `touch_m` may stick out.
    #[must_use]
    pub fn holds_leg(
        &self,
        [from_m, to_m]: [[f64; 3]; 2],
        half_m: [f64; 3],
        yaw_rad: f64,
        touch_m: f64,
    ) -> bool {
        self.fits([from_m, to_m], half_m, yaw_rad, touch_m)
            && self.edge.as_ref().is_none_or(|edge| {
                let rim = swept([from_m, to_m], half_m, yaw_rad);
                edge.room_m(&rim) >= edge.margin_m - touch_m
            })
    }

    /// Whether a level box of half edges `half_m` at heading `yaw_rad` lies in it; `touch_m` may stick out.
    #[must_use]
    pub fn holds(&self, at_m: [f64; 3], half_m: [f64; 3], yaw_rad: f64, touch_m: f64) -> bool {
        self.holds_leg([at_m; 2], half_m, yaw_rad, touch_m)
    }

    /// Whether a level box lies between the corners at both places.
    fn fits(&self, places_m: [[f64; 3]; 2], half_m: [f64; 3], yaw_rad: f64, touch_m: f64) -> bool {
        let ([length, width, height], (sin, cos)) = (half_m, (yaw_rad - self.yaw_rad).sin_cos());
        let reach_m =
            [length * cos.abs() + width * sin.abs(), length * sin.abs() + width * cos.abs(), height];
        places_m.into_iter().all(|at_m| self.reaches_no_edge(at_m, reach_m, touch_m))
    }

    /// Whether an upright cylinder lies in it; `touch_m` may stick out.
    #[must_use]
    pub fn holds_cylinder(&self, at_m: [f64; 3], radius_m: f64, half_height_m: f64, touch_m: f64) -> bool {
        self.reaches_no_edge(at_m, [radius_m, radius_m, half_height_m], touch_m)
            && self
                .edge
                .as_ref()
                .is_none_or(|edge| edge.distance_m([at_m[0], at_m[1]]) >= radius_m + edge.margin_m - touch_m)
    }

    fn reaches_no_edge(&self, at_m: [f64; 3], reach_m: [f64; 3], touch_m: f64) -> bool {
        let ([cos, sin], [x, y, z]) = (self.turn, at_m);
        // v = R_z(−ψ)·p
        let own = [cos * x + sin * y, cos * y - sin * x, z];
        (0..3).all(|k| {
            own[k] - reach_m[k] >= self.low_m[k] - touch_m && own[k] + reach_m[k] <= self.high_m[k] + touch_m
        })
    }

    /// Its four upright edges, seen from above, m.
    #[must_use]
    pub fn outline_m(&self) -> [[f64; 2]; 4] {
        let (low, high) = (self.low_m, self.high_m);
        [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]].map(|[x, y]| {
            let [x, y, _] = turned([x, y, 0.0], self.yaw_rad);
            [x, y]
        })
    }

    /// Corners of the least box around it, along the axes that places are given in, m.
    #[must_use]
    pub fn extent_m(&self) -> [[f64; 3]; 2] {
        let outline = self.outline_m();
        let over = |pick: fn(f64, f64) -> f64, k: usize| {
            outline.iter().map(|corner| corner[k]).reduce(pick).unwrap_or_default()
        };
        [
            [over(f64::min, 0), over(f64::min, 1), self.low_m[2]],
            [over(f64::max, 0), over(f64::max, 1), self.high_m[2]],
        ]
    }
}

/// The convex outline of a box at two places, seen from above: its corners in order, those of the way between included.
fn swept([from_m, to_m]: [[f64; 3]; 2], [length, width, _]: [f64; 3], yaw_rad: f64) -> Vec<[f64; 2]> {
    let (sin, cos) = yaw_rad.sin_cos();
    let way = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
    // The way in the box's own axes says which corners lead.
    let (ahead, aside) = (cos * way[0] + sin * way[1], cos * way[1] - sin * way[0]);
    let corner = |[x, y]: [f64; 2], at: [f64; 3]| {
        let [x, y] = [x * length, y * width];
        [at[0] + cos * x - sin * y, at[1] + sin * x + cos * y]
    };
    let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let mut rim = Vec::with_capacity(8);
    for [x, y] in corners {
        let (leads, trails) = (x * ahead > 0.0 || y * aside > 0.0, x * ahead < 0.0 || y * aside < 0.0);
        match (leads, trails) {
            // A side corner: it leaves a line from its first place to its last.
            (true, true) => {
                let (first, last) = (corner([x, y], from_m), corner([x, y], to_m));
                // Counter-clockwise, a corner to the right of the way is passed along it.
                let side = x * length * -aside + y * width * ahead;
                rim.extend(if side < 0.0 { [first, last] } else { [last, first] });
            }
            (false, true) => rim.push(corner([x, y], from_m)),
            _ => rim.push(corner([x, y], to_m)),
        }
    }
    rim
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    const HALF_M: [f64; 3] = [0.2, 0.1, 0.05];

    #[test]
    fn a_hull_fits_by_hand() {
        let water = Water::from([[0.0, 0.0, 0.0], [2.0, 1.0, 1.0]]);
        let holds = |at: [f64; 3], yaw: f64| water.holds(at, HALF_M, yaw, 1e-9);
        assert!(holds([0.2, 0.1, 0.05], 0.0) && holds([1.8, 0.9, 0.95], 0.0));
        assert!(!holds([0.2, 0.1, 0.05], FRAC_PI_2) && holds([0.1, 0.2, 0.05], FRAC_PI_2));
        assert!(!holds([0.2, 0.1, 0.049], 0.0) && !holds([0.2, 0.91, 0.5], 0.0));
        assert!(water.holds_cylinder([0.3, 0.3, 0.5], 0.3, 0.5, 1e-9));
        assert!(!water.holds_cylinder([0.3, 0.29, 0.5], 0.3, 0.5, 1e-9));
    }

    /// The same places in turned axes are held or not as they are in the world's.
    #[test]
    fn turned_water_holds_what_it_held() {
        let corners = [[-1.0, -0.5, 0.0], [1.5, 0.7, 1.0]];
        let world = Water::from(corners);
        let (mut inside, mut outside) = (0, 0);
        for step in 0..4000_u32 {
            // Places of a lattice of irrational steps: the oracle is the box that is not turned.
            let draw = |prime: f64| (f64::from(step) * prime.sqrt()).fract();
            let at = [4.0 * draw(2.0) - 2.0, 3.0 * draw(3.0) - 1.5, draw(5.0)];
            let (yaw, frame) = (6.0 * draw(7.0), 6.0 * draw(11.0) - 3.0);
            let expected = world.holds(at, HALF_M, yaw, 0.0);
            let seen = Water::new(corners, -frame).holds(turned(at, -frame), HALF_M, yaw - frame, 0.0);
            assert_eq!(seen, expected, "{at:?} at {yaw} from {frame}");
            (inside, outside) = (inside + u32::from(expected), outside + u32::from(!expected));
        }
        assert!(inside > 500 && outside > 500, "{inside} inside, {outside} outside");
    }

    #[test]
    fn its_extent_reaches_to_the_corners() {
        let [low, high] = Water::new([[-1.0, -1.0, -2.0], [1.0, 1.0, 3.0]], FRAC_PI_4).extent_m();
        let far = 2.0_f64.sqrt();
        for (value, expected) in low.iter().chain(&high).zip([-far, -far, -2.0, far, far, 3.0]) {
            assert!((value - expected).abs() < 1e-12, "{value} for {expected}");
        }
    }
}
