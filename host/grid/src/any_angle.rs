//! The shortest path at any angle on a map of either kind, each by what serves it best.
//!
//! | map | how | length |
//! |---|---|---|
//! | [`Plane`] | intervals of sight, [`taut`](super::taut) | the least there is |
//! | [`Volume`] | Theta* that opens vertices again, then [`corridor`](super::corridor) | never above that along the 26 moves |
//!
//! In 3D the shortest path turns at edges, anywhere along them; between centres of cells no method is exact that is not a
//! visibility graph.

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

    /// On a 2D map.
    pub(super) fn on_plane(&mut self, plane: &Plane, start: usize, goal: usize) -> Option<FoundPath> {
        let found = self.taut.shortest(plane, start, goal);
        self.expanded = self.taut.expanded();
        found
    }

    /// On a 3D map.
    pub(super) fn on_volume(&mut self, volume: &Volume, start: usize, goal: usize) -> Option<FoundPath> {
        let found = self.search.theta_star_again(volume, start, goal);
        self.expanded = self.search.expanded();
        let mut found = found?;
        self.corridor.tighten(volume, &mut found);
        Some(found)
    }
}
