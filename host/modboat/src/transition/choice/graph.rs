//! A group of modules as a graph: nodes with the options still open, renumbered from 0, and edges that forbid something.

use super::OPTIONS_MAX;

/// The places of the bits that are set, lowest first.
pub fn bits(mut mask: u16) -> impl Iterator<Item = u8> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (bit < u16::BITS).then_some(bit as u8)
    })
}

/// One module as a node of the graph.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Number of options.
    pub options: usize,
    /// The cost of each.
    pub cost: [f64; OPTIONS_MAX],
    /// The number that each had before.
    name: [u8; OPTIONS_MAX],
}

/// Two modules that forbid each other something.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// The two nodes.
    pub ends: [usize; 2],
    /// For either end, by its option, the options of the other end that go with it.
    pub goes: [[u16; OPTIONS_MAX]; 2],
}

impl Edge {
    /// Which end of the edge `node` is: 0 or 1.
    #[must_use]
    pub const fn end(&self, node: usize) -> usize {
        (node != self.ends[0]) as usize
    }
}

/// Modules as nodes, and what they ask of each other as edges.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// By node.
    pub nodes: Vec<Node>,
    /// Each once.
    pub edges: Vec<Edge>,
    first: Vec<usize>,
    incident: Vec<usize>,
}

impl Graph {
    /// Makes room for so many nodes and edges.
    pub fn reserve(&mut self, nodes: usize, edges: usize) {
        self.nodes.reserve(nodes);
        self.edges.reserve(edges);
        self.first.reserve(nodes + 2);
        self.incident.reserve(2 * edges);
    }

    /// Removes all nodes and edges.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.edges.clear();
    }

    /// The next node: the options open in `domain`, of those with these costs.
    pub fn node(&mut self, domain: u16, costs: &[f64]) {
        let mut node = Node { options: 0, cost: [0.0; OPTIONS_MAX], name: [0; OPTIONS_MAX] };
        for (name, &cost) in (0..).zip(costs).filter(|&(name, _)| domain & 1 << name != 0) {
            node.cost[node.options] = cost;
            node.name[node.options] = name;
            node.options += 1;
        }
        self.nodes.push(node);
    }

    /// An edge between two nodes; by the former number of a's option the former numbers of b's that go with it.
    pub fn edge(&mut self, a: usize, b: usize, rows: &[u16]) {
        let mut goes = [[0; OPTIONS_MAX]; 2];
        for of_a in 0..self.nodes[a].options {
            let row = rows[usize::from(self.nodes[a].name[of_a])];
            for of_b in 0..self.nodes[b].options {
                if row & 1 << self.nodes[b].name[of_b] != 0 {
                    goes[0][of_a] |= 1 << of_b;
                    goes[1][of_b] |= 1 << of_a;
                }
            }
        }
        self.edges.push(Edge { ends: [a, b], goes });
    }

    /// To be called when all edges are there: makes [`Self::of`] right.
    pub fn index(&mut self) {
        super::refill(&mut self.first, self.nodes.len() + 2, 0);
        for end in self.edges.iter().flat_map(|edge| edge.ends) {
            self.first[end + 2] += 1;
        }
        for node in 2..self.first.len() {
            self.first[node] += self.first[node - 1];
        }
        super::refill(&mut self.incident, 2 * self.edges.len(), 0);
        for (index, edge) in self.edges.iter().enumerate() {
            for end in edge.ends {
                self.incident[self.first[end + 1]] = index;
                self.first[end + 1] += 1;
            }
        }
    }

    /// The edges of a node.
    #[must_use]
    pub fn of(&self, node: usize) -> &[usize] {
        &self.incident[self.first[node]..self.first[node + 1]]
    }

    /// The former number of a node's option.
    #[must_use]
    pub fn option(&self, node: usize, option: u8) -> u8 {
        self.nodes[node].name[usize::from(option)]
    }

    /// All options of a node, one bit each.
    #[must_use]
    pub fn all(&self, node: usize) -> u16 {
        u16::MAX >> (OPTIONS_MAX - self.nodes[node].options)
    }
}
