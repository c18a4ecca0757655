//! One search: cones in the order of f, what each of them leads to, and the ways to vertices.

use std::cmp::Reverse;

use super::super::Map;
use super::super::plane::Plane;
use super::super::theta::key;
use super::Taut;
use super::cone::{Cone, Goal, Side, distance};

/// Lengths that differ by less than this share of them are equal.
const ROUNDING: f64 = 1e-12;

/// Stands for the goal in the open list.
const GOAL: u32 = u32::MAX;

/// One search under way.
pub(super) struct Run<'r> {
    plane: &'r Plane,
    goal: Goal,
    goal_vertex: usize,
    least: f64,
    held: Option<(u128, Cone)>,
    taut: &'r mut Taut,
}

impl<'r> Run<'r> {
    /// A search that has not begun.
    pub(super) fn new(taut: &'r mut Taut, plane: &'r Plane, goal: usize) -> Self {
        let at = plane.place(goal).map(|c| c as i32);
        Self { plane, goal: Goal { at }, goal_vertex: goal, least: f64::INFINITY, held: None, taut }
    }

    /// Searches; whether there is a path.
    pub(super) fn finds(mut self, start: usize) -> bool {
        self.start(start);
        self.is_reached()
    }

    fn is_free(&self, row: i32, x: i32) -> bool {
        self.plane.bits().is_set(self.plane.row(row).wrapping_add_signed(x as isize))
    }

    fn vertex(&self, [x, y]: [i32; 2]) -> usize {
        y as usize * (self.plane.width() as usize + 2) + x as usize
    }

    /// Notes a way to a vertex; whether it is shorter than what is known.
    fn reaches(&mut self, vertex: usize, g: f64, from: u32) -> bool {
        let known = &mut self.taut.known[vertex];
        let is_shorter = known.2 != self.taut.generation || g < known.0 * (1.0 - ROUNDING);
        if is_shorter {
            *known = (g, from, self.taut.generation);
        }
        is_shorter
    }

    fn start(&mut self, start: usize) {
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

    fn fan(&mut self, cone: Cone) {
        let f = cone.g + self.goal.distance(cone.root_at);
        self.push(f, cone);
    }

    fn push(&mut self, f: f64, cone: Cone) {
        if f >= self.least {
            return;
        }
        let Reverse(mut entry) = key(cone.g, f - cone.g, 0);
        let mut cone = cone;
        if let Some((held, other)) = &mut self.held {
            if entry < *held {
                std::mem::swap(&mut entry, held);
                std::mem::swap(&mut cone, other);
            }
            self.queue(entry, cone);
        } else {
            self.held = Some((entry, cone));
        }
    }

    fn queue(&mut self, entry: u128, cone: Cone) {
        let index = match self.taut.unused.pop() {
            Some(index) => {
                self.taut.cones[index as usize] = cone;
                index
            }
            None => {
                self.taut.cones.push(cone);
                self.taut.cones.len() as u32 - 1
            }
        };
        self.taut.open.push(Reverse(entry | u128::from(index)));
    }

    fn is_reached(&mut self) -> bool {
        loop {
            let top = self.taut.open.peek().map(|&Reverse(entry)| entry);
            let cone = match (self.held.take(), top) {
                (Some((entry, cone)), top) if top.is_none_or(|top| entry <= top) => cone,
                (held, Some(_)) => {
                    let Some(Reverse(entry)) = self.taut.open.pop() else { return false };
                    let index = entry as u32;
                    if index == GOAL {
                        return true;
                    }
                    let cone = self.taut.cones[index as usize];
                    self.taut.unused.push(index);
                    if let Some((entry, cone)) = held {
                        self.queue(entry, cone);
                    }
                    cone
                }
                (_, None) => return false,
            };
            // A shorter way to its root has been found since.
            if cone.g > self.taut.known[cone.root as usize].0 {
                continue;
            }
            self.taut.expanded += 1;
            if let Some(side) = cone.walk {
                self.walk(&cone, side);
            }
            self.sweep(cone);
        }
    }

    fn arrive(&mut self, cone: &Cone) {
        let g = cone.g + self.goal.distance(cone.root_at);
        if self.reaches(self.goal_vertex, g, cone.root) {
            self.least = g;
            let Reverse(entry) = key(g, 0.0, 0);
            self.taut.open.push(Reverse(entry | u128::from(GOAL)));
        }
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
    fn walk(&mut self, cone: &Cone, side: Side) {
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
    fn sweep(&mut self, mut cone: Cone) {
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
        if a == f64::from(low) && self.is_free(far, low - 1) && self.is_free(far, low) {
            self.turn(&cone, [low, line], [[-1, 0], [low - x, line - y]], step, Some(Side::Left));
        }
        if b == f64::from(high) && self.is_free(far, high - 1) && self.is_free(far, high) {
            self.turn(&cone, [high, line], [[high - x, line - y], [1, 0]], step, Some(Side::Right));
        }
        if a == b {
            return;
        }
        // Openings to the row beyond.
        let row = self.plane.row(far);
        let first = a.floor() as i32;
        let end = b.ceil() as i32;
        let index = |x: i32| row.wrapping_add_signed(x as isize);
        let mut from = first;
        if self.is_free(far, first) && !(f64::from(first) == a && !self.is_free(far, first - 1)) {
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
