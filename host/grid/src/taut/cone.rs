//! What a vertex sees through an interval of a grid line.

/// Toward lower or higher x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

impl Side {
    pub(super) fn sign(self) -> i32 {
        match self {
            Self::Left => -1,
            Self::Right => 1,
        }
    }

    /// A ray along the grid line on this side and another, the left one first.
    pub(super) fn rays(self, other: [i32; 2]) -> [[i32; 2]; 2] {
        match self {
            Self::Left => [[-1, 0], other],
            Self::Right => [other, [1, 0]],
        }
    }
}

/// All that a root sees between two rays, from a grid line on; the root's own line for one that nothing is known of yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// Length of the way to the root.
    pub g: f64,
    pub root: u32,
    pub root_at: [i32; 2],
    /// y of the grid line.
    pub line: i32,
    /// Toward higher (1) or lower (−1) y.
    pub step: i32,
    /// Directions of the left and the right ray, both closed; along the line itself at the root's own line only.
    pub rays: [[i32; 2]; 2],
    /// The interval of the line between them.
    pub a: f64,
    pub b: f64,
    /// Along the root's line too.
    pub walk: Option<Side>,
}

impl Cone {
    /// Around a root, between two rays.
    pub(super) fn fan(
        g: f64,
        (root, at): (u32, [i32; 2]),
        step: i32,
        rays: [[i32; 2]; 2],
        walk: Option<Side>,
    ) -> Self {
        let x = f64::from(at[0]);
        Self { g, root, root_at: at, line: at[1], step, rays, a: x, b: x, walk }
    }

    /// A cell of the row beyond the line that the cone enters.
    pub(super) fn cell(&self) -> i32 {
        if self.line != self.root_at[1] {
            self.a.floor() as i32
        } else if self.rays[0][0] < 0 {
            self.root_at[0] - 1
        } else {
            self.root_at[0]
        }
    }

    /// Goes on to the next line, within the run of free cells from `low` to `high`.
    pub(super) fn reach(&mut self, low: i32, high: i32) {
        self.line += self.step;
        self.walk = None;
        let [x, y] = self.root_at;
        let far = self.line - y;
        // Exact about which cell an end is in, and whether it is a vertex: the products are below 2³³, and a fraction whose
        // denominator is below 2¹⁶ is no closer to a whole number than 2⁻¹⁶ unless it is one, far more than rounding does.
        let meets = |[dx, dy]: [i32; 2]| f64::from(x) + f64::from(dx) * f64::from(far) / f64::from(dy);
        let [left, right] = self.rays;
        let a = if left[1] == 0 { f64::NEG_INFINITY } else { meets(left) };
        let b = if right[1] == 0 { f64::INFINITY } else { meets(right) };
        (self.a, self.b) = (a, b);
        if a < f64::from(low) {
            self.a = f64::from(low);
            self.rays[0] = [low - x, far];
        }
        if b > f64::from(high) {
            self.b = f64::from(high);
            self.rays[1] = [high - x, far];
        }
    }
}

/// Where a search ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    pub at: [i32; 2],
}

impl Goal {
    /// Length of the shortest way from the root of a cone through its interval to the goal if there were no obstacles.
    pub(super) fn past(&self, cone: &Cone) -> f64 {
        let [x, y] = cone.root_at.map(f64::from);
        let [gx, gy] = self.at.map(f64::from);
        let line = f64::from(cone.line);
        let to_line = (line - y).abs();
        // A goal before the line is as far as its mirror image.
        let on = (gy - line).abs();
        let straight = x + (gx - x) * to_line / (to_line + on);
        let through = straight.clamp(cone.a, cone.b);
        length(through - x, to_line) + length(gx - through, on)
    }

    pub(super) fn distance(&self, from: [i32; 2]) -> f64 {
        distance(from, self.at)
    }
}

pub(super) fn distance(from: [i32; 2], to: [i32; 2]) -> f64 {
    length(f64::from(to[0] - from[0]), f64::from(to[1] - from[1]))
}

fn length(dx: f64, dy: f64) -> f64 {
    (dx * dx + dy * dy).sqrt()
}
