//! A 2D map of free and blocked cells; vertices are the corners of cells, and a leg runs anywhere between them.
//!
//! Cell `[x, y]` is the square from corner `[x, y]` to corner `[x + 1, y + 1]`; x to the right, y down, as in a text file.
//! Outside the map everything is blocked. A vertex may be used if at least one of the four cells around it is free.
//!
//! A leg is free when
//! - every cell whose inside it crosses is free;
//! - along the edge of cells, of the two cells at each unit of it at least one is free;
//! - it passes between no two diagonal blocks: at no vertex inside it are two cells that meet only there free, and the
//!   other two blocked.
//!
//! A vertex of the last kind is a dead end for paths too: they may start or end there, from either side. No shortest path
//! turns there, since it would have to come and leave within the same free cell.
//!
//! All of this is decided in integers. With i vertical and j horizontal grid lines crossed on a leg (Δx, Δy), the next
//! vertical one is met at t = (i + 1)/|Δx| and the next horizontal one at t = (j + 1)/|Δy|, so the sign of
//!
//! ```text
//! e = (i + 1)·|Δy| − (j + 1)·|Δx|
//! ```
//!
//! says which comes first, and e = 0 is a vertex exactly.
//!
//! Limits: [`SIDE_MAX`] cells along each side, [`CELLS_MAX`] in all.

use std::f64::consts::SQRT_2;

use super::theta::Space;
use super::{Bits, CELLS_MAX, Map, SIDE_MAX};

/// A 2D map of free and blocked cells.
#[derive(Clone, Debug)]
pub struct Plane {
    width: u32,
    height: u32,
    /// Cells with a blocked rim; the index of a cell is that of the vertex at its lower right corner.
    free: Bits,
}

/// The four cells around a vertex, as bits.
const UP_LEFT: u32 = 1;
const UP_RIGHT: u32 = 2;
const DOWN_LEFT: u32 = 4;
const DOWN_RIGHT: u32 = 8;

impl Plane {
    /// A map of `width` × `height` cells; `None` if a side is zero or the map is too large.
    #[must_use]
    pub fn new(width: u32, height: u32, is_free: impl Fn(u32, u32) -> bool) -> Option<Self> {
        if [width, height].iter().any(|side| !(1..=SIDE_MAX).contains(side)) {
            return None;
        }
        if (u64::from(width) + 2) * (u64::from(height) + 2) > CELLS_MAX {
            return None;
        }
        let stride = width as usize + 2;
        let mut free = Bits::none(stride * (height as usize + 2));
        for y in 0..height {
            for x in 0..width {
                free.set((y as usize + 1) * stride + x as usize + 1, is_free(x, y));
            }
        }
        Some(Self { width, height, free })
    }

    /// Number of cells along x.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of cells along y.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Whether a cell is on the map and free.
    #[must_use]
    pub fn is_free(&self, x: u32, y: u32) -> bool {
        x < self.width
            && y < self.height
            && self.free.is_set((y as usize + 1) * self.stride() + x as usize + 1)
    }

    /// Bits of the free cells, and where in them the cell `[0, row]` is; cell `[x, row]` is x farther. The rows −1 and
    /// `height` and the cells −1 and `width` of each are blocked.
    pub(crate) fn row(&self, row: i32) -> usize {
        (row + 1) as usize * self.stride() + 1
    }

    pub(crate) fn bits(&self) -> &Bits {
        &self.free
    }

    fn stride(&self) -> usize {
        self.width as usize + 2
    }

    fn coordinates(&self, vertex: usize) -> (i64, i64) {
        // 32-bit division is several times faster.
        let (vertex, stride) = (vertex as u32, self.width + 2);
        (i64::from(vertex % stride), i64::from(vertex / stride))
    }

    /// The free ones of the four cells around a vertex. Its number is that of the cell up and to the left of it.
    fn around(&self, vertex: usize) -> u32 {
        let (up, down) = (self.free.three(vertex), self.free.three(vertex + self.stride()));
        (up & 3) | (down & 3) << 2
    }

    /// Whether two diagonal blocks meet at a vertex, with free cells between them.
    fn is_pinch(&self, vertex: usize) -> bool {
        matches!(self.around(vertex), 0b1001 | 0b0110)
    }

    /// Whether the straight leg between two vertices is free.
    fn is_clear(&self, from: usize, to: usize) -> bool {
        let ((x, y), (x_to, y_to)) = (self.coordinates(from), self.coordinates(to));
        let (dx, dy) = (x_to - x, y_to - y);
        if dx == 0 || dy == 0 {
            return self.is_edge_clear(from.min(to), from.max(to), dx == 0);
        }
        let stride = self.stride() as isize;
        let (step_x, step_y) = (if dx > 0 { 1 } else { -1 }, if dy > 0 { stride } else { -stride });
        // The cell up and to the left of the vertex has its number; the leg begins in one of the four.
        let mut cell = from as isize + if dx > 0 { 1 } else { 0 } + if dy > 0 { stride } else { 0 };
        let (dx, dy) = (dx.abs(), dy.abs());
        // e = (i + 1)·|Δy| − (j + 1)·|Δx|
        let mut e = dy - dx;
        // Lines that are yet to be crossed, the end included.
        let mut left = dx + dy;
        loop {
            if !self.free.is_set(cell as usize) {
                return false;
            }
            if e < 0 {
                cell += step_x;
                e += dy;
                left -= 1;
            } else if e > 0 {
                cell += step_y;
                e -= dx;
                left -= 1;
            } else {
                left -= 2;
                if left == 0 {
                    return true;
                }
                let beside = [cell + step_x, cell + step_y];
                if beside.iter().all(|&cell| !self.free.is_set(cell as usize)) {
                    return false;
                }
                cell += step_x + step_y;
                e += dy - dx;
            }
        }
    }

    /// The same along a grid line, from the lower to the higher vertex.
    fn is_edge_clear(&self, from: usize, to: usize, down: bool) -> bool {
        let (step, sides) =
            if down { (self.stride(), DOWN_LEFT | DOWN_RIGHT) } else { (1, UP_RIGHT | DOWN_RIGHT) };
        (from..to)
            .step_by(step)
            .all(|vertex| self.around(vertex) & sides != 0 && (vertex == from || !self.is_pinch(vertex)))
    }

    fn distance(&self, from: usize, to: usize) -> f64 {
        let ((x, y), (x_to, y_to)) = (self.coordinates(from), self.coordinates(to));
        let (dx, dy) = (x_to - x, y_to - y);
        ((dx * dx + dy * dy) as f64).sqrt()
    }
}

impl Space for Plane {
    fn vertices(&self) -> usize {
        self.stride() * (self.height as usize + 1)
    }

    fn for_neighbours(&self, vertex: usize, mut visit: impl FnMut(usize, f64)) {
        let around = self.around(vertex);
        let stride = self.stride();
        let mut offer = |sides: u32, next: usize, cost: f64| {
            if around & sides != 0 {
                visit(next, cost);
            }
        };
        // Around a vertex with a free cell there are four numbers; where subtraction wraps, the cells are blocked.
        offer(UP_LEFT | UP_RIGHT, vertex.wrapping_sub(stride), 1.0);
        offer(UP_LEFT | DOWN_LEFT, vertex.wrapping_sub(1), 1.0);
        offer(UP_RIGHT | DOWN_RIGHT, vertex + 1, 1.0);
        offer(DOWN_LEFT | DOWN_RIGHT, vertex + stride, 1.0);
        offer(UP_LEFT, vertex.wrapping_sub(stride + 1), SQRT_2);
        offer(UP_RIGHT, vertex.wrapping_sub(stride - 1), SQRT_2);
        offer(DOWN_LEFT, vertex + stride - 1, SQRT_2);
        offer(DOWN_RIGHT, vertex + stride + 1, SQRT_2);
    }

    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64> {
        let distance = self.distance(from, to);
        (distance < limit && self.is_clear(from, to)).then_some(distance)
    }

    fn is_dead_end(&self, vertex: usize) -> bool {
        self.is_pinch(vertex)
    }

    fn bound(&self, vertex: usize, goal: usize) -> f64 {
        self.distance(vertex, goal)
    }
}

impl Map<2> for Plane {
    fn vertex(&self, [x, y]: [u32; 2]) -> Option<usize> {
        (x <= self.width && y <= self.height).then(|| y as usize * self.stride() + x as usize)
    }

    fn place(&self, vertex: usize) -> [u32; 2] {
        [vertex as u32 % (self.width + 2), vertex as u32 / (self.width + 2)]
    }

    fn is_open(&self, vertex: usize) -> bool {
        self.around(vertex) != 0
    }

    fn last(&self) -> [u32; 2] {
        [self.width, self.height]
    }
}

#[cfg(test)]
mod tests;
