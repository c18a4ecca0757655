//! From tables to a choice: backwards through the order of elimination, depth first, the least bound first.
//!
//! ```text
//! f = Σ costs so far + Σ tables that were made by nodes not yet chosen and used by nodes already chosen
//! ```
//!
//! is the least cost of what is left where the tables are exact; then the first descent is the answer. Otherwise f is a lower
//! bound: a branch that cannot beat the best answer is left, and every choice is propagated at once (arc consistency), so
//! that with two options each no descent meets a dead end ([`super::two_sat`] tells why).

use super::graph::{Graph, bits};
use super::tables::Tables;
use super::two_sat::TwoSat;
use super::{Limits, OPTIONS_MAX, refill};

/// Costs closer than this count as equal.
pub const SAME_COST: f64 = 1e-9;
/// How many times the limit of nodes may be spent to meet a first answer.
const PATIENCE: usize = 16;

/// What became of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// The choice in [`Descent::best`].
    Best {
        /// Its cost is at most this much above the least.
        gap: f64,
    },
    /// No choice.
    Nothing {
        /// True if there is none; otherwise the limit of nodes ran out.
        proved: bool,
    },
}

/// A node that is being chosen for: its options by ascending bound.
#[derive(Clone, Copy, Debug)]
struct Level {
    bounds: [(f64, u8); OPTIONS_MAX],
    count: usize,
    next: usize,
    trail: usize,
}

/// The search, with its workspace.
#[derive(Clone, Debug, Default)]
pub struct Descent {
    tables: Tables,
    two_sat: TwoSat,
    levels: Vec<Level>,
    domains: Vec<u16>,
    trail: Vec<(usize, u16)>,
    queue: Vec<usize>,
    chosen: Vec<u8>,
    best: Vec<u8>,
}

impl Descent {
    /// Makes room for so many nodes and edges.
    pub fn reserve(&mut self, nodes: usize, edges: usize) {
        self.tables.reserve(nodes, edges);
        self.two_sat.reserve(nodes);
        self.levels.reserve(nodes);
        self.domains.reserve(nodes);
        // A node leaves each of its options at most once, and once more is chosen.
        self.trail.reserve((OPTIONS_MAX + 1) * nodes);
        self.queue.reserve((OPTIONS_MAX + 1) * nodes);
        self.chosen.reserve(nodes);
        self.best.reserve(nodes);
    }

    /// The options of the best choice, by node.
    #[must_use]
    pub fn best(&self) -> &[u8] {
        &self.best
    }

    /// The least choice for an arc-consistent graph.
    pub fn solve(&mut self, graph: &mut Graph, limits: Limits) -> Found {
        graph.index();
        self.tables.make(graph, limits.entries);
        if self.tables.least.is_infinite() {
            return Found::Nothing { proved: true };
        }
        if !self.tables.exact && self.two_sat.satisfiable(graph) == Some(false) {
            return Found::Nothing { proved: true };
        }
        let nodes = graph.nodes.len();
        self.domains.clear();
        self.domains.extend((0..nodes).map(|node| graph.all(node)));
        refill(&mut self.chosen, nodes, 0);
        self.trail.clear();
        self.levels.clear();
        self.descend(graph, limits.nodes)
    }

    fn descend(&mut self, graph: &Graph, limit: usize) -> Found {
        let (nodes, mut tried, mut best) = (graph.nodes.len(), 0, f64::INFINITY);
        self.push(graph, self.tables.least);
        while let Some(level) = self.levels.last_mut() {
            let (next, mark) = (level.next, level.trail);
            let (bound, option) = level.bounds[next.min(OPTIONS_MAX - 1)];
            let spent = next < level.count && bound < best - SAME_COST;
            level.next += 1;
            while self.trail.len() > mark
                && let Some((node, domain)) = self.trail.pop()
            {
                self.domains[node] = domain;
            }
            if !spent {
                self.levels.pop();
                continue;
            }
            tried += 1;
            let allowance = if best.is_finite() { limit } else { PATIENCE.saturating_mul(limit) };
            if tried > allowance.saturating_add(2 * nodes) {
                return if best.is_finite() {
                    Found::Best { gap: (best - self.tables.least).max(0.0) }
                } else {
                    Found::Nothing { proved: false }
                };
            }
            let node = self.tables.order[nodes - self.levels.len()];
            self.chosen[node] = option;
            if !self.tables.exact && !self.propagate(graph, node, option) {
                continue;
            }
            if self.levels.len() < nodes {
                self.push(graph, bound);
                continue;
            }
            best = bound;
            self.best.clone_from(&self.chosen);
            if self.tables.exact {
                break;
            }
        }
        if best.is_finite() { Found::Best { gap: 0.0 } } else { Found::Nothing { proved: true } }
    }

    /// The next node's options, by ascending bound; `bound` is that of everything before.
    fn push(&mut self, graph: &Graph, bound: f64) {
        let position = graph.nodes.len() - 1 - self.levels.len();
        let node = self.tables.order[position];
        let rest = bound - self.tables.made(position, &self.chosen);
        let mut level = Level { bounds: [(0.0, 0); OPTIONS_MAX], count: 0, next: 0, trail: self.trail.len() };
        let mut open = self.domains[node];
        for &index in graph.of(node) {
            let edge = &graph.edges[index];
            let end = 1 - edge.end(node);
            if self.tables.position[edge.ends[end]] > position {
                open &= edge.goes[end][usize::from(self.chosen[edge.ends[end]])];
            }
        }
        for option in bits(open) {
            self.chosen[node] = option;
            let cost = graph.nodes[node].cost[usize::from(option)];
            let bound = rest + cost + self.tables.used(position, &self.chosen);
            if bound.is_finite() {
                level.bounds[level.count] = (bound, option);
                level.count += 1;
            }
        }
        level.bounds[..level.count].sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.levels.push(level);
    }

    /// A node takes an option, and everybody else what goes with that. False if somebody is left without an option.
    fn propagate(&mut self, graph: &Graph, node: usize, option: u8) -> bool {
        self.trail.push((node, self.domains[node]));
        self.domains[node] = 1 << option;
        self.queue.clear();
        self.queue.push(node);
        while let Some(node) = self.queue.pop() {
            for &index in graph.of(node) {
                let edge = &graph.edges[index];
                let end = edge.end(node);
                let other = edge.ends[1 - end];
                let goes = bits(self.domains[node]).fold(0, |all, a| all | edge.goes[end][usize::from(a)]);
                let before = self.domains[other];
                if before & goes == before {
                    continue;
                }
                self.trail.push((other, before));
                self.domains[other] = before & goes;
                if before & goes == 0 {
                    return false;
                }
                self.queue.push(other);
            }
        }
        true
    }
}
