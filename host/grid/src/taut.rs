//! The shortest path at any angle on a 2D map, exactly: intervals of sight from row to row.
//!
//! A shortest path turns at corners of obstacles only, where one of the four cells around a vertex is blocked, and around them:
//! it is taut. So it is enough to know what each such corner sees. As in \[1\], sight moves on from grid line to grid line: a
//! cone is a root r, two rays and the interval I between them on a line of the grid. Beyond the line the free
//! cells of the row bound it, and the free cells of the row after that part it into the cones that follow.
//!
//! ```text
//!   r ·               root, at g(r) from the start
//!      \  ·
//!   ----a-----b----   line y: the interval I = [a, b]
//!        \       ·
//!   ------a'##b'---   the next: parted by what is blocked beyond it
//! ```
//!
//! | where a path may turn | the new cone |
//! |---|---|
//! | the end of a row of free cells, if the row beyond goes on | between the ray to the corner and the grid line; along the line too |
//! | the end of an opening to the row beyond, if seen from the side of what is blocked | between the ray to the corner and the vertical |
//! | along a grid line, where what is blocked beside it ends | between the grid line and the vertical |
//!
//! Cones are expanded by the least f first, where for a goal before the line its mirror image in the line is taken:
//!
//! ```text
//! f = g(r) + min |r − p| + |p − goal|     over p in I
//! ```
//!
//! No path through the cone is shorter, so the first that reaches the goal is the shortest. A corner is turned at only if the
//! way to it is the shortest yet; ways of equal length need one cone only, since where the one is taut the other can be cut
//! short. \[1\] keeps g by root alike, \[2\] does the same with the polygons of a mesh, here the rows of free cells; nothing is
//! prepared, so that a map may change between two searches.
//!
//! Sight is exact: rays are kept as differences of whole numbers, see `Cone::reach`. Lengths are sums of
//! square roots; two that differ by less than 10⁻¹² of themselves are equal. A path through the touching corners of two
//! diagonal blocks is none, since no opening is there, and a turn needs three free cells.
//!
//! Assumptions and limits: cost is length. One vertex takes 16 bytes of scratch, one cone 72 and 16 more in the open list. On
//! maps of scattered single cells there are about as many cones as Theta* expands vertices; on all others far fewer.
//!
//! \[1\] D. Harabor, A. Grastien, D. Öz and V. Aksakalli, *Optimal Any-Angle Pathfinding In Practice*, Journal of Artificial
//! Intelligence Research 56 (2016), 89–118.
//!
//! \[2\] M. Cui, D. Harabor and A. Grastien, *Compromise-free Pathfinding on a Navigation Mesh*, IJCAI 2017, 496–502.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Map;
use super::plane::Plane;
use super::theta::{FoundPath, Space};

mod cone;
mod run;
mod sight;

use cone::Cone;
use run::Run;

/// What a search knows of a vertex: the least length found to it, the vertex before it, and the search that said so.
type Known = (f64, u32, u32);

/// Scratch of searches, to be used again.
#[derive(Clone, Debug, Default)]
pub struct Taut {
    known: Vec<Known>,
    cones: Vec<Cone>,
    /// Cones that are done with.
    unused: Vec<u32>,
    /// Keys as of Theta*, with a cone for a vertex.
    open: BinaryHeap<Reverse<u128>>,
    generation: u32,
    expanded: usize,
}

impl Taut {
    /// Scratch without anything in it.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Cones that the last search expanded, whether it found a path or proved that there is none.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.expanded
    }

    /// The shortest path from `start` to `goal`; `None` proves that there is none.
    pub fn shortest(&mut self, plane: &Plane, start: usize, goal: usize) -> Option<FoundPath> {
        self.begin(plane);
        if start.max(goal) >= plane.vertices() {
            return None;
        }
        if start == goal {
            return Some(FoundPath { cost: 0.0, path: vec![start], expanded: 0 });
        }
        Run::new(self, plane, goal).finds(start).then(|| FoundPath {
            cost: self.known[goal].0,
            path: self.path(plane, start, goal),
            expanded: self.expanded,
        })
    }

    /// Forgets the last search without touching its vertices.
    fn begin(&mut self, plane: &Plane) {
        self.open.clear();
        self.cones.clear();
        self.unused.clear();
        self.expanded = 0;
        if self.known.len() < plane.vertices() || self.generation == u32::MAX {
            self.known = vec![(0.0, 0, 0); plane.vertices().max(self.known.len())];
            self.generation = 0;
        }
        self.generation += 1;
    }

    /// The way to the goal, without the corners that it passes straight.
    fn path(&self, plane: &Plane, start: usize, goal: usize) -> Vec<usize> {
        let mut path = vec![goal];
        let mut vertex = goal;
        while vertex != start {
            vertex = self.known[vertex].1 as usize;
            // Three in a line are two.
            if let [.., before, last] = path[..] {
                let [a, b, c] = [before, last, vertex].map(|v| plane.place(v).map(i64::from));
                if (b[0] - a[0]) * (c[1] - b[1]) == (b[1] - a[1]) * (c[0] - b[0]) {
                    path.pop();
                }
            }
            path.push(vertex);
        }
        path.reverse();
        path
    }
}

#[cfg(test)]
mod tests;
