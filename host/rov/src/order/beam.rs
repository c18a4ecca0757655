//! Beam search: a first order at once, and better ones with a wider beam.
//!
//! One move after the other, the states of least g + h are kept, as many as the beam is wide. Hops are priced in the order of
//! their bounds, until no other one can be among the best. Slots are filled while the rest stays open, where they can be.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

use super::finder::{Finder, Stopped};
use super::remaining::{Ahead, Remaining};
use super::{Answer, DESKS, Hop, MoveCosts, Order, State};

/// A state of one layer: the sum so far, and where it came from.
struct Node {
    state: State,
    g: f64,
    came: Option<(usize, Hop)>,
}

/// A hop that waits for its price, or has it and waits for its place in the next layer.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    node: usize,
    hop: Hop,
    /// Before the hop, or after it where it is priced.
    g: f64,
    /// What is to be paid after it at least.
    rest: f64,
    priced: bool,
}

/// Least f first, then those that are priced, then a fixed order. Such floats, not negative, sort like their bits.
type Entry = (Reverse<(u64, bool, usize, Hop)>, Bits);

/// What an entry carries; no part of its order.
#[derive(Clone, Copy, Debug)]
struct Bits(Candidate);

impl PartialEq for Bits {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
impl Eq for Bits {}
impl PartialOrd for Bits {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Bits {
    fn cmp(&self, _: &Self) -> std::cmp::Ordering {
        std::cmp::Ordering::Equal
    }
}

fn entry(f: f64, of: Candidate) -> Entry {
    (Reverse((f.to_bits(), !of.priced, of.node, of.hop)), Bits(of))
}

fn f_of((Reverse((f, ..)), _): &Entry) -> f64 {
    f64::from_bits(*f)
}

impl<C: MoveCosts> Finder<'_, C> {
    /// One beam from the start to the end.
    pub(super) fn beam(&mut self, remaining: &Remaining, width: usize) -> Result<(), Stopped> {
        let layout = self.costs().layout();
        let mut nodes = vec![Node { state: State::default(), g: 0.0, came: None }];
        let mut layer = 0..1;
        for _ in 0..layout.robots() * layout.moves() {
            let first = nodes.len();
            self.layer(remaining, width, &mut nodes, layer)?;
            layer = first..nodes.len();
            if layer.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// The next layer of a beam, after all nodes.
    fn layer(
        &mut self,
        remaining: &Remaining,
        width: usize,
        nodes: &mut Vec<Node>,
        layer: std::ops::Range<usize>,
    ) -> Result<(), Stopped> {
        let costs = self.costs();
        let layout = costs.layout();
        let mut queue: BinaryHeap<Entry> = BinaryHeap::new();
        let mut ahead: Vec<Ahead> = Vec::new();
        for node in layer {
            let Node { state, g, .. } = nodes[node];
            remaining.ahead(costs, &state, &mut ahead);
            let is_open = costs.stays_open(layout.filled(&state));
            for &Ahead { hop, bound, rest } in &ahead {
                if is_open && !costs.stays_open(layout.filled(&layout.after(&state, hop))) {
                    continue;
                }
                if g + bound + rest < self.limit() {
                    queue.push(entry(g + bound + rest, Candidate { node, hop, g, rest, priced: false }));
                }
            }
        }
        let first = nodes.len();
        let mut seen = HashSet::new();
        while nodes.len() - first < width {
            let Some(top) = queue.pop() else { break };
            if f_of(&top) >= self.limit() {
                break;
            }
            let Candidate { node, hop, g, priced, .. } = top.1.0;
            if priced {
                let state = layout.after(&nodes[node].state, hop);
                if seen.insert(state) {
                    nodes.push(Node { state, g, came: Some((node, hop)) });
                    if layout.is_done(&state) {
                        self.learn(&Order { moves: trace(nodes), cost: g });
                        nodes.pop();
                    }
                }
                continue;
            }
            // A batch of the best ones that are not priced.
            let mut batch = vec![top.1.0];
            while batch.len() < DESKS.min(2 * width) && queue.peek().is_some_and(|next| !next.1.0.priced) {
                batch.extend(queue.pop().map(|next| next.1.0));
            }
            let most = queue.peek().map_or(f64::INFINITY, f_of).min(self.limit());
            let hops: Vec<(State, Hop)> = batch.iter().map(|of| (nodes[of.node].state, of.hop)).collect();
            // The first is priced in any case.
            let slack = batch
                .iter()
                .enumerate()
                .map(|(k, of)| if k == 0 { f64::INFINITY } else { most - of.g - of.rest });
            let answers = self.answers(&hops, &slack.collect::<Vec<_>>())?;
            for ((of, (state, hop)), answer) in batch.iter().zip(&hops).zip(answers) {
                match answer {
                    Answer::Price(price) if price.is_finite() => {
                        let g = of.g + price;
                        let rest = remaining.of(costs, &layout.after(state, *hop));
                        if g + rest < self.limit() {
                            queue.push(entry(g + rest, Candidate { g, rest, priced: true, ..*of }));
                        }
                    }
                    Answer::Price(_) => {}
                    Answer::AtLeast(bound) => queue.push(entry(of.g + bound + of.rest, *of)),
                }
            }
        }
        Ok(())
    }
}

fn trace(nodes: &[Node]) -> Vec<Hop> {
    let mut moves = Vec::new();
    let mut next = nodes.last();
    while let Some((before, hop)) = next.and_then(|node| node.came) {
        moves.push(hop);
        next = nodes.get(before);
    }
    moves.reverse();
    moves
}
