//! 2-SAT: is there any choice where nobody has more than two options? Decided in time linear in nodes and edges.
//!
//! With two options, "module i takes option x" is a literal, and its negation is "i takes the other option". A forbidden
//! combination (xᵢ, xⱼ) is the clause ¬xᵢ ∨ ¬xⱼ of two literals, so the constraints between pairs are an instance of 2-SAT.
//! Each clause is two implications, xᵢ → ¬xⱼ and xⱼ → ¬xᵢ. A choice exists exactly when no literal lies in one strongly connected
//! component with its negation (Aspvall, Plass and Tarjan 1979); the components are found by Tarjan's algorithm (1972).
//!
//! The same structure makes a search by propagation free of backtracking: once a choice propagates without contradiction,
//! all clauses it touches are satisfied, and what is left is a part of the former clauses, satisfiable as they were.

use super::graph::Graph;

/// Tarjan's algorithm with its stacks.
#[derive(Clone, Debug, Default)]
pub struct TwoSat {
    /// Order of discovery of a literal, 2·node + option; 0 is undiscovered.
    found: Vec<usize>,
    low: Vec<usize>,
    /// The component of a literal that has one, counted from 1.
    component: Vec<usize>,
    open: Vec<usize>,
    /// Literals being explored, with the place of the edge to go on with.
    path: Vec<(usize, usize)>,
}

impl TwoSat {
    /// Makes room for so many nodes.
    pub fn reserve(&mut self, nodes: usize) {
        for list in [&mut self.found, &mut self.low, &mut self.component, &mut self.open] {
            list.reserve(2 * nodes);
        }
        self.path.reserve(2 * nodes);
    }

    /// True if a choice exists that all edges allow. `None` unless every node has two options.
    pub fn satisfiable(&mut self, graph: &Graph) -> Option<bool> {
        if graph.nodes.iter().any(|node| node.options != 2) {
            return None;
        }
        let literals = 2 * graph.nodes.len();
        for list in [&mut self.found, &mut self.low, &mut self.component] {
            super::refill(list, literals, 0);
        }
        let (mut discovered, mut components) = (0, 0);
        for start in 0..literals {
            if self.found[start] != 0 {
                continue;
            }
            self.path.push((start, 0));
            while let Some((literal, next)) = self.path.pop() {
                if next == 0 {
                    discovered += 1;
                    self.found[literal] = discovered;
                    self.low[literal] = discovered;
                    self.open.push(literal);
                }
                if let Some(place) = self.explore(graph, literal, next) {
                    self.path.push((literal, place));
                    self.path.push((implied(graph, literal, place), 0));
                    continue;
                }
                if self.low[literal] == self.found[literal] {
                    components += 1;
                    while let Some(member) = self.open.pop() {
                        self.component[member] = components;
                        if member == literal {
                            break;
                        }
                    }
                }
                if let Some(&(parent, _)) = self.path.last() {
                    self.low[parent] = self.low[parent].min(self.low[literal]);
                }
            }
        }
        Some((0..graph.nodes.len()).all(|node| self.component[2 * node] != self.component[2 * node + 1]))
    }

    /// Goes on with a literal from the edge at `place`; the place after the next that leads to an undiscovered literal.
    fn explore(&mut self, graph: &Graph, literal: usize, mut place: usize) -> Option<usize> {
        while place < graph.of(literal / 2).len() {
            place += 1;
            let to = implied(graph, literal, place);
            if self.found[to] == 0 {
                return Some(place);
            }
            if self.component[to] == 0 {
                self.low[literal] = self.low[literal].min(self.found[to]);
            }
        }
        None
    }
}

/// The literal that follows by the edge before `place`; the literal itself if that edge leaves a choice.
fn implied(graph: &Graph, literal: usize, place: usize) -> usize {
    let (node, option) = (literal / 2, literal % 2);
    let edge = &graph.edges[graph.of(node)[place - 1]];
    let end = edge.end(node);
    let other = edge.ends[1 - end];
    match edge.goes[end][option] {
        0b01 => 2 * other,
        0b10 => 2 * other + 1,
        // Nothing goes with it: its negation follows.
        0b00 => 2 * node + 1 - option,
        _ => literal,
    }
}
