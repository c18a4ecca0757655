//! The shortest path at any angle on a map of either kind, each by what serves it best.
//!
//! | map | how | length |
//! |---|---|---|
//! | [`Plane`] | intervals of sight, [`taut`](super::taut) | the least there is |
//! | [`Volume`] | Theta* that opens vertices again, then [`corridor`](super::corridor) | never above that along the 26 moves |
//!
//! In 3D the shortest path turns at edges, anywhere along them; between centres of cells no method is exact that is not a
//! visibility graph.

use super::Map;
use super::corridor::Corridor;
use super::plane::Plane;
use super::taut::Taut;
use super::theta::{FoundPath, Search};
use super::volume::Volume;

/// Scratch of searches on maps of either kind, to be used again.
#[derive(Clone, Debug, Default)]
pub struct AnyAngle {
    taut: Taut,
    search: Search,
    corridor: Corridor,
    expanded: usize,
}

impl AnyAngle {
    /// Scratch without anything in it.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Intervals or vertices that the last search expanded, whether it found a path or proved that there is none.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.expanded
    }
}

/// A map on which shortest paths at any angle are found.
pub trait Shortest<const N: usize>: Map<N> {
    /// The shortest path; `None` proves that there is none.
    fn shortest(&self, scratch: &mut AnyAngle, start: usize, goal: usize) -> Option<FoundPath>;
}

impl Shortest<2> for Plane {
    fn shortest(&self, scratch: &mut AnyAngle, start: usize, goal: usize) -> Option<FoundPath> {
        let found = scratch.taut.shortest(self, start, goal);
        scratch.expanded = scratch.taut.expanded();
        found
    }
}

impl Shortest<3> for Volume {
    fn shortest(&self, scratch: &mut AnyAngle, start: usize, goal: usize) -> Option<FoundPath> {
        let found = scratch.search.theta_star_again(self, start, goal);
        scratch.expanded = scratch.search.expanded();
        let mut found = found?;
        scratch.corridor.tighten(self, &mut found);
        Some(found)
    }
}
