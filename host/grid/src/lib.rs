//! Paths on regular grids, at least cost: the search of §VII-A of the paper on ROVs, shortest paths, and maps from files.
//!
//! | module | what |
//! |---|---|
//! | [`any_angle`] | the shortest path at any angle on a map, in 2D or in 3D |
//! | [`taut`] | exact in 2D: intervals of sight |
//! | [`theta`] | Basic Theta* and A* over any graph, with any criterion that is a sum over straight legs |
//! | [`corridor`] | a path made cheaper near itself |
//! | [`plane`] | 2D maps of free and blocked cells: vertices on the corners of cells |
//! | [`volume`] | 3D maps: vertices at the centres of cells |
//! | [`read`] | the text formats of maps and scenarios |
//!
//! Lengths are in cells. Everything here is a pure function of its arguments: no clock, no file, no thread.

pub mod any_angle;
pub mod corridor;
pub mod plane;
pub mod read;
pub mod taut;
pub mod theta;
pub mod volume;

/// Most cells of a map, a rim of one cell around it included: a search's scratch takes 16 bytes for each that it reaches.
pub const CELLS_MAX: u64 = 1 << 29;
/// Greatest number of cells along a side.
pub const SIDE_MAX: u32 = 65_535;

/// A map whose vertices have integer coordinates.
pub trait Map<const N: usize>: theta::Space {
    /// Vertex at a place, or `None` outside the map.
    fn vertex(&self, place: [u32; N]) -> Option<usize>;

    /// Place of a vertex.
    fn place(&self, vertex: usize) -> [u32; N];

    /// Whether anything may be at that vertex at all.
    fn is_open(&self, vertex: usize) -> bool;

    /// The greatest coordinates of a vertex.
    fn last(&self) -> [u32; N];
}

/// One bit for every cell, set where it is free.
#[derive(Clone, Debug)]
struct Bits(Vec<u64>);

impl Bits {
    /// `count` cells, none free.
    fn none(count: usize) -> Self {
        // A word more than needed, so that three bits can be read anywhere.
        Self(vec![0; count / 64 + 2])
    }

    fn set(&mut self, index: usize, free: bool) {
        let bit = 1 << (index % 64);
        if free {
            self.0[index / 64] |= bit;
        } else {
            self.0[index / 64] &= !bit;
        }
    }

    fn is_set(&self, index: usize) -> bool {
        self.0[index / 64] >> (index % 64) & 1 == 1
    }

    /// The first index from `index` on that is not set; there must be one.
    fn next_clear(&self, index: usize) -> usize {
        let mut word = index / 64;
        let mut found = !self.0[word] >> (index % 64) << (index % 64);
        while found == 0 {
            word += 1;
            found = !self.0[word];
        }
        word * 64 + found.trailing_zeros() as usize
    }

    /// The first index from `index` on that is set, or anything from `end` on if there is none before it.
    fn next_set(&self, index: usize, end: usize) -> usize {
        let mut word = index / 64;
        let mut found = self.0[word] >> (index % 64) << (index % 64);
        while found == 0 {
            word += 1;
            if word * 64 >= end {
                return end;
            }
            found = self.0[word];
        }
        word * 64 + found.trailing_zeros() as usize
    }

    /// The last index up to `index` that is not set; there must be one.
    fn last_clear(&self, index: usize) -> usize {
        let mut word = index / 64;
        let mut found = !self.0[word] << (63 - index % 64) >> (63 - index % 64);
        while found == 0 {
            word -= 1;
            found = !self.0[word];
        }
        word * 64 + 63 - found.leading_zeros() as usize
    }

    /// The bits at `index`, `index + 1` and `index + 2`.
    fn three(&self, index: usize) -> u32 {
        let (word, shift) = (index / 64, index % 64);
        // Shifted by one first: a shift by 64 is none.
        let both = (self.0[word] >> shift) | (self.0[word + 1] << 1 << (63 - shift));
        both as u32 & 7
    }
}
