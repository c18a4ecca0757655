//! A 3D map of free and blocked cells; vertices are the centres of cells.
//!
//! A leg between two centres is free when every cell that it touches is free: those it crosses, and those of which it
//! meets a face, an edge or a corner only. So nothing cuts a corner: of the 26 moves to a neighbour, one along an axis
//! needs two free cells, one across a face diagonal four, and one across the space diagonal all eight. Outside the map
//! everything is blocked.
//!
//! Decided in integers. Along axis a the leg meets plane k (k = 0, 1, …) between two layers of cells at
//!
//! ```text
//! t = (2k + 1) / (2·|Δa|)
//! ```
//!
//! and between such times it is inside one cell: a centre is no multiple of a cell away from any plane, so a leg never
//! runs within one. Planes met at the same t meet in an edge (two of them) or a corner (three), and the cells around it,
//! four or eight, are touched. Comparing t across axes multiplies by 2·|Δx|·|Δy|·|Δz|, less than 2⁴⁹.
//!
//! Limits: [`SIDE_MAX`] cells along a side, [`CELLS_MAX`] in all.

use super::theta::Space;
use super::{Bits, CELLS_MAX, Map, SIDE_MAX};

/// A move to a neighbour: the step along each axis, and which of the 27 cells around (x fastest, then y, then z) must be
/// free.
type Move = ([i32; 3], u32);

/// A 3D map of free and blocked cells.
#[derive(Clone, Debug)]
pub struct Volume {
    size: [u32; 3],
    /// Cells with a blocked rim.
    free: Bits,
    moves: [Move; 26],
}

impl Volume {
    /// A map of that many cells along x, y and z, all free; `None` if a side is zero or the map is too large.
    #[must_use]
    pub fn new(size: [u32; 3]) -> Option<Self> {
        if size.iter().any(|side| !(1..=SIDE_MAX).contains(side)) {
            return None;
        }
        let rimmed = size.iter().map(|&side| u64::from(side) + 2).product::<u64>();
        if rimmed > CELLS_MAX {
            return None;
        }
        let mut volume = Self { size, free: Bits::none(rimmed as usize), moves: moves() };
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    volume.free.set(volume.number([x, y, z]), true);
                }
            }
        }
        Some(volume)
    }

    /// Blocks a cell; whether it is on the map.
    pub fn block(&mut self, cell: [u32; 3]) -> bool {
        let vertex = self.vertex(cell);
        if let Some(vertex) = vertex {
            self.free.set(vertex, false);
        }
        vertex.is_some()
    }

    fn number(&self, [x, y, z]: [u32; 3]) -> usize {
        let [row, layer] = self.strides();
        (z as usize + 1) * layer + (y as usize + 1) * row + x as usize + 1
    }

    /// From one row to the next, and from one layer to the next.
    fn strides(&self) -> [usize; 2] {
        let row = self.size[0] as usize + 2;
        [row, row * (self.size[1] as usize + 2)]
    }

    fn difference(&self, from: usize, to: usize) -> [i64; 3] {
        let (a, b) = (self.place(from), self.place(to));
        std::array::from_fn(|axis| i64::from(b[axis]) - i64::from(a[axis]))
    }

    fn distance(&self, from: usize, to: usize) -> f64 {
        (self.difference(from, to).iter().map(|d| d * d).sum::<i64>() as f64).sqrt()
    }

    /// Whether the straight leg between two centres is free.
    fn is_clear(&self, from: usize, to: usize) -> bool {
        let difference = self.difference(from, to);
        let [row, layer] = self.strides();
        let [dx, dy, dz] = difference.map(i64::abs);
        let step: [isize; 3] = std::array::from_fn(|axis| {
            difference[axis].signum() as isize * [1, row as isize, layer as isize][axis]
        });
        // t·2·|Δx|·|Δy|·|Δz|, where an axis without motion counts as 1 and is never next.
        let [wx, wy, wz] = [dx, dy, dz].map(|d| d.max(1));
        let per_plane = [2 * wy * wz, 2 * wx * wz, 2 * wx * wy];
        let mut next: [i64; 3] =
            std::array::from_fn(|axis| if difference[axis] == 0 { i64::MAX } else { per_plane[axis] / 2 });
        let mut left = dx + dy + dz;
        let mut cell = from as isize;
        if !self.free.is_set(from) {
            return false;
        }
        while left > 0 {
            let [x, y, z] = next;
            let t = x.min(y).min(z);
            // Most planes are met alone; those met together are crossed together, and all cells around are touched.
            let met = [x == t, y == t, z == t];
            let before = cell;
            for axis in 0..3 {
                if met[axis] {
                    cell += step[axis];
                    next[axis] += per_plane[axis];
                    left -= 1;
                }
            }
            let single = u8::from(met[0]) + u8::from(met[1]) + u8::from(met[2]) == 1;
            if !self.free.is_set(cell as usize) || (!single && !self.is_box_free(before, step, met)) {
                return false;
            }
        }
        true
    }

    /// Whether all cells around an edge or a corner are free.
    #[cold]
    fn is_box_free(&self, cell: isize, step: [isize; 3], met: [bool; 3]) -> bool {
        (0..8_usize).all(|choice| {
            let taken = (0..3).filter(|axis| choice >> axis & 1 == 1);
            let inside = taken.clone().all(|axis| met[axis]);
            !inside || self.free.is_set((cell + taken.map(|axis| step[axis]).sum::<isize>()) as usize)
        })
    }
}

/// The 26 moves.
fn moves() -> [Move; 26] {
    std::array::from_fn(|k| {
        // Without the one in the middle, which is no move.
        let k = k as i32 + i32::from(k >= 13);
        let step = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
        let mut needed = 0;
        for z in step[2].min(0)..=step[2].max(0) {
            for y in step[1].min(0)..=step[1].max(0) {
                for x in step[0].min(0)..=step[0].max(0) {
                    needed |= 1 << ((z + 1) * 9 + (y + 1) * 3 + x + 1);
                }
            }
        }
        (step, needed)
    })
}

impl Space for Volume {
    fn vertices(&self) -> usize {
        self.strides()[1] * (self.size[2] as usize + 2)
    }

    fn for_neighbours(&self, vertex: usize, mut visit: impl FnMut(usize, f64)) {
        const LENGTH: [f64; 4] = [0.0, 1.0, std::f64::consts::SQRT_2, 1.732_050_807_568_877_2];
        // The rim is blocked: no edge starts there, and a free cell has all 27 around it.
        if !self.free.is_set(vertex) {
            return;
        }
        let [row, layer] = self.strides();
        let corner = vertex - layer - row - 1;
        let mut around = 0;
        for k in 0..9 {
            around |= self.free.three(corner + k / 3 * layer + k % 3 * row) << (3 * k);
        }
        for &([x, y, z], needed) in &self.moves {
            if around & needed == needed {
                let step = x as isize + y as isize * row as isize + z as isize * layer as isize;
                let axes = (x * x + y * y + z * z) as usize;
                visit(vertex.wrapping_add_signed(step), LENGTH[axes]);
            }
        }
    }

    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64> {
        let distance = self.distance(from, to);
        (distance < limit && self.is_clear(from, to)).then_some(distance)
    }

    fn bound(&self, vertex: usize, goal: usize) -> f64 {
        self.distance(vertex, goal)
    }
}

impl Map<3> for Volume {
    fn vertex(&self, cell: [u32; 3]) -> Option<usize> {
        cell.iter().zip(&self.size).all(|(at, side)| at < side).then(|| self.number(cell))
    }

    fn place(&self, vertex: usize) -> [u32; 3] {
        // 32-bit division is several times faster.
        let (vertex, row, column) = (vertex as u32, self.size[0] + 2, self.size[1] + 2);
        let rows = vertex / row;
        // A cell of the rim wraps around.
        [vertex % row, rows % column, rows / column].map(|c| c.wrapping_sub(1))
    }

    fn is_open(&self, vertex: usize) -> bool {
        self.free.is_set(vertex)
    }

    fn last(&self) -> [u32; 3] {
        self.size.map(|side| side - 1)
    }
}

#[cfg(test)]
mod tests;
