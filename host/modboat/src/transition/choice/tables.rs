//! Dynamic programming over a frontier: nodes are eliminated one after the other, each into a table over those it still
//! touches (bucket elimination, Dechter 1999).
//!
//! ```text
//! T_v(S) = min over x_v of [ c_v(x_v) + Σ T_u(…) over the tables that mention v ]   subject to the edges of v
//! ```
//!
//! S, the frontier, are the nodes not yet eliminated that share an edge or a table with v. A table has Π_{s∈S} m_s entries, m_s the
//! number of options. Which order keeps the tables smallest is NP-hard; taken is the node with the smallest table next.
//! The last table is one number, the least cost.
//!
//! Where the tables would take more than the limit, what v takes part in is shared out among several smaller tables, each
//! the least by itself (mini-buckets, Dechter and Rish 2003). As x_v may then differ between them, the sum is a lower bound:
//! for the whole, and for every partial choice in reverse order of elimination, which is what branch and bound asks for.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::graph::{Graph, bits};
use super::{OPTIONS_MAX, refill};

/// Room made beforehand: nodes on a frontier, entries of tables a node, shares of a node.
const FRONTIER: usize = 16;
const ENTRIES: usize = 256;
const SHARES: usize = 4;

/// One table: its frontier `scope[first..first + width]`, its entries from `values` on.
#[derive(Clone, Copy, Debug)]
struct Table {
    first: usize,
    width: usize,
    values: usize,
}

/// What goes into one table.
#[derive(Clone, Debug, Default)]
struct Share {
    scope: Vec<usize>,
    entries: usize,
    tables: Vec<usize>,
    edges: Vec<usize>,
}

/// The tables of one graph, and the workspace to make them.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// Nodes by order of elimination.
    pub order: Vec<usize>,
    /// The place of a node in that order.
    pub position: Vec<usize>,
    /// True if nothing was shared out: then the bounds are the least costs.
    pub exact: bool,
    /// The least cost, or a lower bound of it; infinite if there is no choice.
    pub least: f64,
    tables: Vec<Table>,
    /// Nodes of the frontiers, with what one option more adds to the index.
    scope: Vec<(usize, usize)>,
    values: Vec<f64>,
    /// Tables made at a position are `made[position]..made[position + 1]`.
    made: Vec<usize>,
    /// Tables to be used at a position, as a chain.
    placed: Vec<Option<usize>>,
    chain: Vec<Option<usize>>,
    neighbours: Vec<Vec<usize>>,
    heap: BinaryHeap<Reverse<(usize, usize)>>,
    bucket: Vec<usize>,
    shares: Vec<Share>,
    step: Vec<usize>,
    base: Vec<(usize, usize)>,
    gate: Vec<[u16; OPTIONS_MAX]>,
    open: Vec<u16>,
    digit: Vec<usize>,
}

impl Tables {
    /// Makes room for so many nodes and edges, and for frontiers as groups mostly have them.
    pub fn reserve(&mut self, nodes: usize, edges: usize) {
        self.order.reserve(nodes);
        self.position.reserve(nodes);
        self.tables.reserve(2 * nodes);
        self.chain.reserve(2 * nodes);
        self.made.reserve(nodes + 1);
        self.placed.reserve(nodes);
        self.scope.reserve(FRONTIER * nodes);
        self.values.reserve(ENTRIES * nodes);
        self.neighbours.resize_with(nodes, || Vec::with_capacity(FRONTIER));
        self.heap.reserve(2 * (nodes + edges) + FRONTIER * nodes);
        self.bucket.reserve(FRONTIER);
        self.shares.resize_with(SHARES, Share::default);
        for Share { scope, tables, edges, .. } in &mut self.shares {
            [scope, tables, edges].into_iter().for_each(|list| list.reserve(FRONTIER));
        }
        self.step.reserve(FRONTIER * FRONTIER);
        self.base.reserve(FRONTIER);
        self.gate.reserve(FRONTIER);
        self.open.reserve(FRONTIER + 1);
        self.digit.reserve(FRONTIER);
    }

    /// Makes all tables; `limit` is on their entries together, times the options that each is the least of.
    pub fn make(&mut self, graph: &Graph, limit: usize) {
        self.find_order(graph, limit);
        let cap = if self.exact { usize::MAX } else { limit / (2 * graph.nodes.len()) };
        self.tables.clear();
        self.scope.clear();
        self.values.clear();
        self.chain.clear();
        self.made.clear();
        refill(&mut self.placed, graph.nodes.len(), None);
        self.exact = true;
        self.least = 0.0;
        for position in 0..self.order.len() {
            self.made.push(self.tables.len());
            let shares = self.share_out(graph, position, cap);
            self.exact &= shares == 1;
            for share in 0..shares {
                self.eliminate(graph, self.order[position], share);
            }
        }
        self.made.push(self.tables.len());
    }

    /// Smallest table next. Tells in `exact` whether the tables stay within the limit.
    fn find_order(&mut self, graph: &Graph, limit: usize) {
        let nodes = graph.nodes.len();
        self.order.clear();
        self.heap.clear();
        refill(&mut self.position, nodes, usize::MAX);
        if self.neighbours.len() < nodes {
            self.neighbours.resize(nodes, Vec::new());
        }
        for node in 0..nodes {
            self.neighbours[node].clear();
            for &index in graph.of(node) {
                let edge = &graph.edges[index];
                join(&mut self.neighbours[node], edge.ends[1 - edge.end(node)]);
            }
            self.heap.push(Reverse((work(graph, node, &self.neighbours[node]), node)));
        }
        let mut total = 0_usize;
        while let Some(Reverse((weight, node))) = self.heap.pop() {
            let stale = weight != work(graph, node, &self.neighbours[node]);
            if stale || self.position[node] != usize::MAX {
                continue;
            }
            self.position[node] = self.order.len();
            self.order.push(node);
            total = total.saturating_add(weight);
            let frontier = std::mem::take(&mut self.neighbours[node]);
            for (place, &one) in frontier.iter().enumerate() {
                self.neighbours[one].retain(|&other| other != node);
                // Beyond the limit tables are shared out, and do not join everybody on the frontier.
                for &other in frontier[place + 1..].iter().filter(|_| total <= limit) {
                    join(&mut self.neighbours[one], other);
                    join(&mut self.neighbours[other], one);
                }
            }
            for &one in &frontier {
                self.heap.push(Reverse((work(graph, one, &self.neighbours[one]), one)));
            }
            self.neighbours[node] = frontier;
        }
        self.exact = total <= limit;
    }

    /// Shares out what the node at a position takes part in, so that no table exceeds `cap`. The number of shares.
    fn share_out(&mut self, graph: &Graph, position: usize, cap: usize) -> usize {
        let node = self.order[position];
        self.bucket.clear();
        let mut next = self.placed[position];
        while let Some(table) = next {
            self.bucket.push(table);
            next = self.chain[table];
        }
        self.bucket.sort_unstable_by_key(|&table| (Reverse(self.tables[table].width), table));
        let mut used = 0;
        for &table in &self.bucket {
            let Table { first, width, .. } = self.tables[table];
            let others = self.scope[first..first + width].iter().map(|&(other, _)| other);
            let others = others.filter(|&other| other != node);
            let place = fit(&mut self.shares, &mut used, graph, others, cap / graph.nodes[node].options);
            self.shares[place].tables.push(table);
        }
        for &index in graph.of(node) {
            let edge = &graph.edges[index];
            let other = edge.ends[1 - edge.end(node)];
            if self.position[other] < position {
                continue;
            }
            // What forbids, not what costs, may count in every share.
            let mut counted = false;
            for share in self.shares[..used].iter_mut().filter(|share| share.scope.contains(&other)) {
                share.edges.push(index);
                counted = true;
            }
            if !counted {
                let others = std::iter::once(other);
                let place = fit(&mut self.shares, &mut used, graph, others, cap / graph.nodes[node].options);
                self.shares[place].edges.push(index);
            }
        }
        if used == 0 {
            fit(&mut self.shares, &mut used, graph, std::iter::empty(), cap);
        }
        used
    }

    /// The table of one share of a node. The first share counts the node's cost.
    fn eliminate(&mut self, graph: &Graph, node: usize, place: usize) {
        let share = &self.shares[place];
        let (width, own) = (share.scope.len(), &graph.nodes[node]);
        let cost = if place == 0 { own.cost } else { [0.0; OPTIONS_MAX] };
        let table = Table { first: self.scope.len(), width, values: self.values.len() };
        let mut entries = 1;
        for &other in &share.scope {
            self.scope.push((other, entries));
            entries *= graph.nodes[other].options;
        }
        // For each table that goes in: what an option of the node, and of each on the frontier, adds to its index.
        refill(&mut self.step, share.tables.len() * width, 0);
        self.base.clear();
        for (row, &source) in share.tables.iter().enumerate() {
            let Table { first, width: of_source, values } = self.tables[source];
            self.base.push((values, 0));
            for &(other, step) in &self.scope[first..first + of_source] {
                match share.scope.iter().position(|&on_frontier| on_frontier == other) {
                    Some(digit) => self.step[row * width + digit] = step,
                    None => self.base[row].1 = step,
                }
            }
        }
        // For each on the frontier: what its options leave of the node's.
        refill(&mut self.gate, width, [u16::MAX; OPTIONS_MAX]);
        for &index in &share.edges {
            let edge = &graph.edges[index];
            let end = 1 - edge.end(node);
            if let Some(digit) = share.scope.iter().position(|&other| other == edge.ends[end]) {
                (self.gate[digit].iter_mut().zip(edge.goes[end])).for_each(|(gate, goes)| *gate &= goes);
            }
        }
        refill(&mut self.digit, width, 0);
        refill(&mut self.open, width + 1, graph.all(node));
        let mut turned = width;
        loop {
            // What is open, from the slowest digit that has turned to the fastest.
            for digit in (0..turned).rev() {
                self.open[digit] = self.open[digit + 1] & self.gate[digit][self.digit[digit]];
            }
            let mut least = f64::INFINITY;
            for option in bits(self.open[0]).map(usize::from) {
                let sources = self.base.iter().map(|&(base, step)| self.values[base + step * option]);
                least = least.min(cost[option] + sources.sum::<f64>());
            }
            self.values.push(least);
            turned = 0;
            loop {
                if turned == width {
                    self.keep(table);
                    return;
                }
                let options = graph.nodes[self.shares[place].scope[turned]].options;
                self.digit[turned] += 1;
                let carry = self.digit[turned] == options;
                for (row, (base, _)) in self.base.iter_mut().enumerate() {
                    let step = self.step[row * width + turned];
                    *base = if carry { *base - step * (options - 1) } else { *base + step };
                }
                turned += 1;
                if !carry {
                    break;
                }
                self.digit[turned - 1] = 0;
            }
        }
    }

    /// Puts a table where it will be used: with the first of its frontier to be eliminated.
    fn keep(&mut self, table: Table) {
        let frontier = &self.scope[table.first..table.first + table.width];
        let first = frontier.iter().map(|&(node, _)| self.position[node]).min();
        let index = self.tables.len();
        self.tables.push(table);
        self.chain.push(None);
        match first {
            Some(position) => self.chain[index] = self.placed[position].replace(index),
            None => self.least += self.values[table.values],
        }
    }

    /// The sum of the tables made at a position, with everybody at later positions at `chosen`.
    #[must_use]
    pub fn made(&self, position: usize, chosen: &[u8]) -> f64 {
        (self.made[position]..self.made[position + 1]).map(|table| self.value(table, chosen)).sum()
    }

    /// The sum of the tables used at a position, with its node and everybody at later positions at `chosen`.
    #[must_use]
    pub fn used(&self, position: usize, chosen: &[u8]) -> f64 {
        let (mut sum, mut next) = (0.0, self.placed[position]);
        while let Some(table) = next {
            sum += self.value(table, chosen);
            next = self.chain[table];
        }
        sum
    }

    fn value(&self, table: usize, chosen: &[u8]) -> f64 {
        let Table { first, width, values } = self.tables[table];
        let frontier = self.scope[first..first + width].iter();
        self.values[frontier.fold(values, |index, &(node, step)| index + step * usize::from(chosen[node]))]
    }
}

/// The entries of a node's table times its options.
fn work(graph: &Graph, node: usize, frontier: &[usize]) -> usize {
    frontier
        .iter()
        .fold(graph.nodes[node].options, |work, &other| work.saturating_mul(graph.nodes[other].options))
}

fn join(list: &mut Vec<usize>, node: usize) {
    if !list.contains(&node) {
        list.push(node);
    }
}

/// The first share that takes these nodes within `cap` entries, or else the next new one; they are on its frontier then.
fn fit(
    shares: &mut Vec<Share>,
    used: &mut usize,
    graph: &Graph,
    others: impl Iterator<Item = usize> + Clone,
    cap: usize,
) -> usize {
    let with = |share: &Share| {
        let new = others.clone().filter(|other| !share.scope.contains(other));
        new.fold(share.entries, |entries, other| entries.saturating_mul(graph.nodes[other].options))
    };
    let place = shares[..*used].iter().position(|share| with(share) <= cap).unwrap_or(*used);
    if place == *used {
        if place == shares.len() {
            shares.push(Share::default());
        }
        *used += 1;
        let share = &mut shares[place];
        share.scope.clear();
        share.tables.clear();
        share.edges.clear();
        share.entries = 1;
    }
    shares[place].entries = with(&shares[place]);
    others.for_each(|other| join(&mut shares[place].scope, other));
    place
}
