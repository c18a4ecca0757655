//! Basic Theta* over any graph and any criterion that is a sum over straight legs; A* and its smoothing to compare with.
//!
//! A path along the edges of a grid turns where the grid does, not where the obstacles do. Basic Theta* \[1\] searches like
//! A*, but the parent of a vertex need not be its neighbour: any vertex with a free straight leg to it will do. When `s`
//! is expanded, each neighbour `s'` is offered two ways from the start:
//!
//! ```text
//! path 1      g(s) + c(s, s')                        parent(s') = s
//! path 2      g(parent(s)) + c(parent(s), s')        parent(s') = parent(s)        [1], procedure UpdateVertex
//! ```
//!
//! \[1\] takes path 2 whenever the leg is free, since by the triangle inequality it is never the longer one. Energy does
//! not keep that inequality exactly, so the cheaper of the two is taken here; where they are equal, as on a straight
//! line, path 2. For distances that is \[1\] to the letter.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | c(s, s') | cost of the straight leg from s to s', direction included ([`Space::leg`]) | the criterion's |
//! | turn(r, s, s') | cost of changing direction at s, added to either way ([`Space::turn`]) | " |
//! | g(s) | cost of the cheapest path found from the start to s | " |
//! | h(s) | lower bound of the cost from s to the goal ([`Space::bound`]) | " |
//! | f(s) | g(s) + h(s): the vertex with the least is expanded next | " |
//!
//! Ties: of two equal f the greater g goes first (nearer the goal, as in \[1\]), of two equal g (to single precision) the
//! lower vertex number. So a search depends on its arguments alone.
//!
//! Assumptions and limits. Costs are not negative; a leg whose cost is NaN or infinite counts as blocked. A* is exact when
//! the bound is admissible, consistent or not, and turns cost nothing: it opens a vertex again when a cheaper way turns
//! up. Where turns cost, g depends on the way that a vertex was reached, of which one is kept. Basic Theta* opens nothing
//! again, as in \[1\], and is not exact: its path is one of the cheapest, not the cheapest, and a finer grid may give a worse one;
//! it may even be dearer than that of A*. [`Search::theta_star_again`] opens again. Where turns cost nothing its path never costs
//! more than that of A*: path 1 bounds g(s') by g(s) + c(s, s') whenever s is expanded, so that until the goal is closed some
//! vertex of the cheapest path along edges is open with a g no greater than along it, as in the proof for A*.
//! At most 2³² − 1 vertices. One vertex takes 16 bytes of scratch, one entry of the open list another 16.
//!
//! \[1\] A. Nash, K. Daniel, S. Koenig and A. Felner, *Theta\*: Any-Angle Path Planning on Grids*, Journal of Artificial
//! Intelligence Research 39 (2010), 533–579.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

mod smooth;

pub use smooth::smooth;

/// Two costs that differ by less than this share of them are equal: what rounding can do along a path.
const ROUNDING: f64 = 1e-12;

/// A graph whose vertices have places, so that straight legs run between any two of them.
pub trait Space {
    /// Number of vertices; vertices are `0..vertices()`.
    fn vertices(&self) -> usize;

    /// Calls `visit` with every neighbour of `vertex` that may be entered from it, and what the leg there costs.
    fn for_neighbours(&self, vertex: usize, visit: impl FnMut(usize, f64));

    /// Cost of the straight leg, or `None` if it is blocked.
    fn leg(&self, from: usize, to: usize) -> Option<f64> {
        self.leg_below(from, to, f64::INFINITY)
    }

    /// The same, or `None` if it costs `limit` or more: where the cost is known before the leg is found free, that
    /// saves looking.
    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64>;

    /// Whether a path may start or end at `vertex`, but not pass it.
    fn is_dead_end(&self, _vertex: usize) -> bool {
        false
    }

    /// What changing direction at `at` costs, from the leg that came from `before` to the leg that goes to `to`; at the
    /// start of the search `before` is `at`.
    fn turn(&self, _before: usize, _at: usize, _to: usize) -> f64 {
        0.0
    }

    /// Lower bound of the cost from `vertex` to `goal`: admissible, never above what any path costs.
    fn bound(&self, vertex: usize, goal: usize) -> f64;
}

/// The path that a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundPath {
    /// The sum of its legs' and turns' costs.
    pub cost: f64,
    /// Its vertices, start and goal included.
    pub path: Vec<usize>,
    /// Vertices whose neighbours were looked at on the way to finding it.
    pub expanded: usize,
}

/// What a search knows about one vertex: g, parent, and a stamp. The stamp is the search's generation while the vertex is
/// open and one more when it is closed; anything else is from an earlier search. A tuple, because a vector of zero tuples
/// is memory that the system hands out as it is touched: a large space costs only the part that is searched.
type Node = (f64, u32, u32);

/// Scratch of searches, to be used again: once it has grown to a space it allocates for the path it returns only.
#[derive(Clone, Debug, Default)]
pub struct Search {
    nodes: Vec<Node>,
    open: BinaryHeap<Reverse<u128>>,
    generation: u32,
    expanded: usize,
}

/// Parents: the vertex expanded only (A*), or its parent too (Theta*), which opens a vertex again or does not.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parents {
    Neighbours,
    Visible,
    VisibleAgain,
}

impl Search {
    /// Scratch without anything in it.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Basic Theta* from `start` to `goal`; `None` when the open list ran empty, which proves that there is no path.
    pub fn theta_star(&mut self, space: &impl Space, start: usize, goal: usize) -> Option<FoundPath> {
        self.run(space, start, goal, Parents::Visible)
    }

    /// Theta* that opens a vertex again when a cheaper way to it turns up; see the module.
    pub fn theta_star_again(&mut self, space: &impl Space, start: usize, goal: usize) -> Option<FoundPath> {
        let found = self.run(space, start, goal, Parents::VisibleAgain)?;
        // A parent may have become cheaper since its g was added to.
        Some(FoundPath { cost: cost(space, &found.path)?, ..found })
    }

    /// A* from `start` to `goal` along edges of the graph, at least cost; `None` proves that there is no path.
    pub fn a_star(&mut self, space: &impl Space, start: usize, goal: usize) -> Option<FoundPath> {
        self.run(space, start, goal, Parents::Neighbours)
    }

    /// Vertices that the last search expanded, whether it found a path or proved that there is none.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.expanded
    }

    /// Bytes of scratch set aside for spaces as large as the largest so far, and for the longest open list.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.open.capacity() * size_of::<u128>()
    }

    fn run(&mut self, space: &impl Space, start: usize, goal: usize, parents: Parents) -> Option<FoundPath> {
        self.expanded = 0;
        if start.max(goal) >= space.vertices() {
            return None;
        }
        self.begin(space.vertices());
        let (open, closed) = (self.generation, self.generation + 1);
        self.nodes[start] = (0.0, start as u32, open);
        self.open.push(key(0.0, space.bound(start, goal), start));
        while let Some(Reverse(entry)) = self.open.pop() {
            let vertex = entry as u32 as usize;
            let (g, parent, stamp) = self.nodes[vertex];
            // A vertex has one queue entry for every cheaper way found to it; the first to come closes it.
            if stamp == closed {
                continue;
            }
            if vertex == goal {
                return Some(FoundPath { cost: g, path: self.path(start, goal), expanded: self.expanded });
            }
            self.nodes[vertex].2 = closed;
            if vertex != start && space.is_dead_end(vertex) {
                continue;
            }
            self.expanded += 1;
            let grandparent = (parents != Parents::Neighbours && vertex != start).then_some(parent as usize);
            let grandparent = grandparent.map(|p| (p, self.nodes[p].0));
            space.for_neighbours(vertex, |next, cost| {
                let (known_g, _, stamp) = self.nodes[next];
                let known_g = if stamp == open || stamp == closed { known_g } else { f64::INFINITY };
                if stamp == closed && parents == Parents::Visible {
                    return;
                }
                // path 1: g(s) + c(s, s')
                let g_1 = g + cost + space.turn(parent as usize, vertex, next);
                // path 2: g(parent(s)) + c(parent(s), s')
                let most = (known_g * (1.0 - ROUNDING)).min(g_1 * (1.0 + ROUNDING));
                let second = grandparent.and_then(|(p, g_p)| {
                    let g_p = g_p + space.turn(self.nodes[p].1 as usize, p, next);
                    let leg = space.leg_below(p, next, most - g_p)?;
                    Some((g_p + leg, p))
                });
                let (g_next, from) = second.unwrap_or((g_1, vertex));
                if g_next < known_g * (1.0 - ROUNDING) {
                    self.nodes[next] = (g_next, from as u32, open);
                    self.open.push(key(g_next, space.bound(next, goal), next));
                }
            });
        }
        None
    }

    /// Forgets the last search without touching its vertices.
    fn begin(&mut self, vertices: usize) {
        self.open.clear();
        // Generations go up by two: open and closed.
        if self.nodes.len() < vertices || self.generation >= u32::MAX - 3 {
            self.nodes = vec![(0.0, 0, 0); vertices.max(self.nodes.len())];
            self.generation = 0;
        }
        self.generation += 2;
    }

    fn path(&self, start: usize, goal: usize) -> Vec<usize> {
        let mut path = vec![goal];
        let mut vertex = goal;
        while vertex != start {
            vertex = self.nodes[vertex].1 as usize;
            path.push(vertex);
        }
        path.reverse();
        path
    }
}

/// Place in the open list: f first, then the greater g, then the lower vertex. Floats that are not negative sort like
/// their bits.
pub(crate) fn key(g: f64, h: f64, vertex: usize) -> Reverse<u128> {
    // Adding zero makes a negative zero positive.
    let f = (g + h + 0.0).to_bits();
    let nearer = !(g as f32 + 0.0).to_bits();
    Reverse((u128::from(f) << 64) | (u128::from(nearer) << 32) | vertex as u128)
}

/// Cost of a path, turns included, or `None` if a leg of it is blocked.
#[must_use]
pub fn cost(space: &impl Space, path: &[usize]) -> Option<f64> {
    let mut before = *path.first()?;
    let mut sum = 0.0;
    for leg in path.windows(2) {
        sum += space.turn(before, leg[0], leg[1]) + space.leg(leg[0], leg[1])?;
        before = leg[0];
    }
    Some(sum)
}

#[cfg(test)]
mod tests;
