//! The cheapest path whose corners are near those of a path that was found: what a search on a grid leaves to gain.
//!
//! Theta* puts a corner where its search came past, not where it is best, and a corner that touches nothing may have a better
//! place a cell away, or be better as two. The corners of a path are given candidates, all vertices at most two moves away,
//! each corner twice, and of all paths with one candidate for each the cheapest is found layer by layer:
//!
//! ```text
//! g(v) = min g(u) + c(u, v)     over u in layer k − 1, for every v of layer k
//! ```
//!
//! where a vertex that is in both layers is one corner less. That is repeated around the new corners for as long as it gains,
//! each time after corners were taken out that a free leg passes by, and moved to a neighbour for as long as that gains: a
//! path of many corners becomes one of few first, since n layers take n·125² looks at a leg at most, most of them cut short by
//! the cost of the path so far and the lower bound to the goal.
//!
//! Assumptions and limits. Turns cost nothing. The path stays near the one it began with: a cheaper one on the other side of
//! an obstacle is not found. It never costs more than that.

use super::theta::{FoundPath, Space, cost};

/// A gain of less than this share of a length is none.
const GAIN: f64 = 1e-9;

/// How many moves a candidate may be away from its corner.
const MOVES: usize = 2;

/// Scratch, to be used again.
#[derive(Clone, Debug, Default)]
pub struct Corridor {
    /// Candidates of all layers, with the least cost from the start and the candidate before.
    candidates: Vec<(usize, f64, u32)>,
    /// Where each layer begins, and the end of the last.
    layers: Vec<usize>,
    /// The corners that they are around.
    corners: Vec<usize>,
}

impl Corridor {
    /// Scratch without anything in it.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes a path cheaper where it can be.
    pub fn tighten(&mut self, space: &impl Space, found: &mut FoundPath) {
        loop {
            pull(space, &mut found.path);
            let Some(cost) = cost(space, &found.path) else { return };
            found.cost = found.cost.min(cost);
            if found.path.len() < 3 || !self.is_cheaper(space, found) {
                return;
            }
        }
    }

    /// The cheapest path by candidates for the corners, if it is cheaper.
    fn is_cheaper(&mut self, space: &impl Space, found: &mut FoundPath) -> bool {
        let FoundPath { path, cost, .. } = found;
        let [start, corners @ .., goal] = &path[..] else { return false };
        let (start, goal) = (*start, *goal);
        self.corners.clear();
        self.corners.extend(corners.iter().flat_map(|&corner| [corner; 2]));
        self.candidates.clear();
        self.candidates.push((start, 0.0, 0));
        self.layers.clear();
        self.layers.push(0);
        for k in 0..=self.corners.len() {
            let (before, begin) = (self.layers[k], self.candidates.len());
            self.layers.push(begin);
            self.candidates.push((self.corners.get(k).copied().unwrap_or(goal), f64::INFINITY, 0));
            if k < self.corners.len() {
                self.add_around(space, begin);
            }
            let (known, layer) = self.candidates.split_at_mut(begin);
            for (at, g, from) in layer {
                let limit = *cost * (1.0 - GAIN) - space.bound(*at, goal);
                for (index, &(earlier, g_earlier, _)) in known.iter().enumerate().skip(before) {
                    let most = limit.min(*g) - g_earlier;
                    let leg = if earlier == *at { Some(0.0) } else { space.leg_below(earlier, *at, most) };
                    if let Some(leg) = leg.filter(|&leg| leg < most) {
                        (*g, *from) = (g_earlier + leg, index as u32);
                    }
                }
            }
        }
        let Some(&(_, least, _)) = self.candidates.last().filter(|(_, least, _)| least.is_finite()) else {
            return false;
        };
        *cost = least;
        path.clear();
        let mut index = self.candidates.len() - 1;
        while index > 0 {
            let (at, _, from) = self.candidates[index];
            path.push(at);
            index = from as usize;
        }
        path.push(start);
        path.reverse();
        path.dedup();
        true
    }

    /// Adds the vertices at most that many moves away to the layer that begins with a corner.
    fn add_around(&mut self, space: &impl Space, begin: usize) {
        let mut ring = begin..self.candidates.len();
        for _ in 0..MOVES {
            for index in ring.clone() {
                space.for_neighbours(self.candidates[index].0, |next, _| {
                    let is_known = self.candidates[begin..].iter().any(|&(at, ..)| at == next);
                    if !is_known && !space.is_dead_end(next) {
                        self.candidates.push((next, f64::INFINITY, 0));
                    }
                });
            }
            ring = ring.end..self.candidates.len();
        }
    }
}

/// Takes corners out that a free leg passes by, and moves corners to a neighbour, for as long as that makes the path cheaper.
fn pull(space: &impl Space, path: &mut Vec<usize>) {
    let mut is_cheaper = true;
    while is_cheaper {
        is_cheaper = false;
        let mut k = 1;
        while k + 1 < path.len() {
            let [before, at, after] = [path[k - 1], path[k], path[k + 1]];
            let (Some(first), Some(second)) = (space.leg(before, at), space.leg(at, after)) else { return };
            // A straight line is one leg, whatever rounding says.
            if space.leg_below(before, after, (first + second) * (1.0 + GAIN)).is_some() {
                path.remove(k);
                k = (k - 1).max(1);
                continue;
            }
            let mut least = (first + second) * (1.0 - GAIN);
            let mut moved = at;
            space.for_neighbours(at, |next, _| {
                if !space.is_dead_end(next)
                    && let Some(first) = space.leg_below(before, next, least)
                    && let Some(second) = space.leg_below(next, after, least - first)
                {
                    (least, moved) = (first + second, next);
                }
            });
            if moved == at {
                k += 1;
            } else {
                path[k] = moved;
                is_cheaper = true;
            }
        }
    }
}

#[cfg(test)]
mod tests;
