//! What cones lead to: the row that each sees through, the openings beyond it, and the corners to turn at.

use super::super::Map;
use super::cone::{Cone, Side, distance};
use super::run::Run;

impl Run<'_> {
    fn is_free(&self, row: i32, x: i32) -> bool {
        self.plane.bits().is_set(self.plane.row(row).wrapping_add_signed(x as isize))
    }

    fn vertex(&self, [x, y]: [i32; 2]) -> usize {
        y as usize * (self.plane.width() as usize + 2) + x as usize
    }

    /// All that the start sees: up, down, and along its grid line.
    pub(super) fn start(&mut self, start: usize) {
        let at = self.plane.place(start).map(|c| c as i32);
        self.reaches(start, 0.0, start as u32);
        for step in [1, -1] {
            let row = if step > 0 { at[1] } else { at[1] - 1 };
            let (left, right) = (self.is_free(row, at[0] - 1), self.is_free(row, at[0]));
            if left || right {
                let left = if left { [-1, 0] } else { [0, step] };
                let right = if right { [1, 0] } else { [0, step] };
                self.fan(Cone::fan(0.0, (start as u32, at), step, [left, right], None));
            }
        }
        let fan = Cone::fan(0.0, (start as u32, at), 1, [[0, 1]; 2], None);
        self.walk(&fan, Side::Left);
        self.walk(&fan, Side::Right);
    }

    /// Turns at a corner that the root of a cone sees.
    fn turn(&mut self, cone: &Cone, at: [i32; 2], rays: [[i32; 2]; 2], step: i32, walk: Option<Side>) {
        let vertex = self.vertex(at);
        let g = cone.g + distance(cone.root_at, at);
        if self.reaches(vertex, g, cone.root) {
            self.fan(Cone::fan(g, (vertex as u32, at), step, rays, walk));
        }
    }

    /// Along the grid line from the root of a cone.
    pub(super) fn walk(&mut self, cone: &Cone, side: Side) {
        let [mut x, y] = cone.root_at;
        let toward = side.sign();
        // Cell beside the edge from x on.
        let beside = |x: i32| if toward > 0 { x } else { x - 1 };
        let mut before: Option<[bool; 2]> = None;
        loop {
            let cells = [self.is_free(y - 1, beside(x)), self.is_free(y, beside(x))];
            if let Some(before) = before {
                if self.goal.at == [x, y] {
                    self.arrive(cone);
                }
                match (before, cells) {
                    ([false, true], [true, true]) => {
                        self.turn(cone, [x, y], side.rays([0, -1]), -1, None);
                    }
                    ([true, false], [true, true]) => {
                        self.turn(cone, [x, y], side.rays([0, 1]), 1, None);
                    }
                    ([false, true], [true, false]) | ([true, false], [false, true]) => return,
                    _ => {}
                }
            }
            if cells == [false, false] {
                return;
            }
            before = Some(cells);
            x += toward;
        }
    }

    /// Through the row beyond a cone, to the next line.
    pub(super) fn sweep(&mut self, mut cone: Cone) {
        let step = cone.step;
        let (near, far) = if step > 0 { (cone.line, cone.line + 1) } else { (cone.line - 1, cone.line - 2) };
        let cell = cone.cell();
        let line = cone.line + step;
        let [x, y] = cone.root_at;
        let row = self.plane.row(near);
        let bits = self.plane.bits();
        let at = row.wrapping_add_signed(cell as isize);
        // The free run of the row.
        let low = (bits.last_clear(at) + 1 - row) as i32;
        let high = (bits.next_clear(at) - row) as i32;
        cone.reach(low, high);
        let (a, b) = (cone.a, cone.b);
        if a > b {
            return;
        }
        let [gx, gy] = self.goal.at;
        if gy == line && a <= f64::from(gx) && f64::from(gx) <= b {
            self.arrive(&cone);
        }
        // Corners at the ends of the row.
        if a <= f64::from(low) && self.is_free(far, low - 1) && self.is_free(far, low) {
            self.turn(&cone, [low, line], [[-1, 0], [low - x, line - y]], step, Some(Side::Left));
        }
        if b >= f64::from(high) && self.is_free(far, high - 1) && self.is_free(far, high) {
            self.turn(&cone, [high, line], [[high - x, line - y], [1, 0]], step, Some(Side::Right));
        }
        if a >= b {
            return;
        }
        // Openings to the row beyond.
        let row = self.plane.row(far);
        let first = a.floor() as i32;
        let end = b.ceil() as i32;
        let index = |x: i32| row.wrapping_add_signed(x as isize);
        let mut from = first;
        if self.is_free(far, first) && (a > f64::from(first) || self.is_free(far, first - 1)) {
            // The opening begins before the interval.
            from = i32::MIN;
        }
        loop {
            let bits = self.plane.bits();
            let p =
                if from == i32::MIN { from } else { (bits.next_set(index(from), index(end)) - row) as i32 };
            if p >= end {
                return;
            }
            let q = (bits.next_clear(index(p.max(first))) - row) as i32;
            let mut child = cone;
            if p != i32::MIN {
                if f64::from(p) > a {
                    child.a = f64::from(p);
                    child.rays[0] = [p - x, line - y];
                }
                if p > low && x < p {
                    self.turn(&cone, [p, line], [[0, step], [p - x, line - y]], step, None);
                }
            }
            if f64::from(q) <= b {
                if f64::from(q) < b {
                    child.b = f64::from(q);
                    child.rays[1] = [q - x, line - y];
                }
                if q < high && x > q {
                    self.turn(&cone, [q, line], [[q - x, line - y], [0, step]], step, None);
                }
            }
            let f = child.g + self.goal.past(&child);
            self.push(f, child);
            if q >= end {
                return;
            }
            from = q;
        }
    }
}
