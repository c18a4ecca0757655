//! The anytime search: beams that widen, and A* that closes in on the least from below.
//!
//! A* goes over states with f = g + h. Pricing is what costs most, so it comes late: a hop waits in the queue at its bound
//! and is priced when it comes up, eight at a time. The least f of the queue is a lower bound of all orders, and the
//! first end that comes up is the least. A beam, four times as wide each time, takes as many prices as A* did since the
//! last one.
//!
//! Memory: a state opens a few of its hops at a time, the queue and the states are limited in number. What has to be
//! dropped is the dearest, and the least f ever dropped stays the bound.

use std::collections::{BinaryHeap, HashMap};

use super::finder::{Finder, Stopped};
use super::paper::NoRule;
use super::remaining::Remaining;
use super::{Answer, DESKS, Hop, InTurn, MoveCosts, Order, State};

/// Hops of a state that are opened at a time.
const OPENED: usize = 8;
/// Most entries of the queue, 80 bytes each.
const QUEUE_MOST: usize = 1_500_000;
/// Most states reached, about 100 bytes each.
const STATES_MOST: usize = 1_000_000;
/// Widths of the beams that look for a first order, until one finds it.
const FIRST: [usize; 4] = [1, 4, 16, 64];
/// Most robots that the paper's rule is applied to before the search.
const RULED_MOST: usize = 8;
/// More robots than these are many.
const MANY: usize = 10;
/// Widest beam.
const WIDEST: usize = 4096;

/// Why no order of moves was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoOrder {
    /// None leads to the end; so many states were reached, all there are.
    Proved {
        /// How many.
        states: usize,
    },
    /// It was stopped before one was found; there may be one.
    Stopped,
}

/// The best order found, and what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The order.
    pub order: Order,
    /// No order costs less.
    pub bound: f64,
    /// Whether it is the least.
    pub proved: bool,
}

/// What waits in the queue of A*.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Next {
    /// A state whose first so many hops have been opened.
    Open(u16),
    /// A hop that is not priced: what is to be paid after it at least, as bits.
    Hop(Hop, u64),
}

/// Least f first, then greatest g, then a fixed order. Costs are not negative, and such floats sort like their bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    f: u64,
    g: u64,
    state: State,
    next: Next,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_f = other.f.cmp(&self.f).then(self.g.cmp(&other.g));
        by_f.then_with(|| other.state.cmp(&self.state)).then_with(|| other.next.cmp(&self.next))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// The cheapest way found to every state: its cost, and the state and the hop it came by.
type Reached = HashMap<State, (f64, Option<(State, Hop)>)>;

/// A* that can be gone on with.
struct BestFirst {
    queue: BinaryHeap<Entry>,
    reached: Reached,
    /// Least f that was dropped.
    dropped: f64,
}

impl<C: MoveCosts> Finder<'_, C> {
    /// A first order at once, and that of the paper's rule where robots are few.
    ///
    /// # Errors
    /// [`NoOrder::Stopped`] if it was stopped before there was one.
    pub fn first(&mut self) -> Result<(), NoOrder> {
        let layout = self.costs().layout();
        let mut stopped = false;
        for width in FIRST {
            if stopped || self.best().is_some() {
                break;
            }
            stopped = self.beam(&Remaining::Assigned(None), width).is_err();
        }
        // For many robots the rule takes more prices than a beam.
        let is_ruled = layout.moves() == 1 && (layout.robots() <= RULED_MOST || self.best().is_none());
        stopped |= !stopped && is_ruled && self.by_paper() == Err(NoRule::Stopped);
        // What was found is told before anything else is worked out.
        stopped |= self.report().is_err();
        if stopped && self.best().is_none() { Err(NoOrder::Stopped) } else { Ok(()) }
    }

    /// Searches until the least order is proved or the progress ends it; `relax` as for [`Remaining::new`].
    ///
    /// # Errors
    /// [`NoOrder`]; never when an order is known already.
    pub fn search(&mut self, relax: bool) -> Result<Found, NoOrder> {
        let least = Remaining::Assigned(None).of(self.costs(), &State::default());
        if least.is_finite() {
            self.bounded(least);
        }
        let states = self.remaining(relax).and_then(|remaining| self.alternate(&remaining));
        match states {
            Ok(states) => match self.best() {
                Some(order) => {
                    let bound = self.known().bound.min(order.cost);
                    let proved = self.known().gap() == Some(0.0);
                    Ok(Found { order: order.clone(), bound, proved })
                }
                None => Err(NoOrder::Proved { states }),
            },
            Err(Stopped) => match self.best() {
                Some(order) => Ok(Found { order: order.clone(), bound: self.known().bound, proved: false }),
                None => Err(NoOrder::Stopped),
            },
        }
    }

    /// How many states were reached when all that is affordable has been looked at.
    fn alternate(&mut self, remaining: &Remaining) -> Result<usize, Stopped> {
        let start = State::default();
        let least = remaining.of(self.costs(), &start);
        let mut best_first =
            BestFirst { queue: BinaryHeap::new(), reached: HashMap::new(), dropped: f64::INFINITY };
        best_first.reached.insert(start, (0.0, None));
        if least.is_finite() {
            self.bounded(least);
            best_first.queue.push(Entry {
                f: least.to_bits(),
                g: 0.0_f64.to_bits(),
                state: start,
                next: Next::Open(0),
            });
        }
        let mut width = 1;
        loop {
            let before = self.known().priced;
            if width <= WIDEST {
                self.beam(remaining, width)?;
                width *= 4;
            }
            // Of many robots A* sees little of all states: beams find the better orders.
            let part = if self.costs().layout().robots() > MANY { 4 } else { 1 };
            let share = ((self.known().priced - before) / part).max(16 * DESKS);
            if best_first.reached.len() > STATES_MOST {
                // No memory is left for A*: what is known is all there will be.
                if width > WIDEST {
                    return Err(Stopped);
                }
            } else if self.best_first(remaining, &mut best_first, share)? {
                return Ok(best_first.reached.len());
            }
        }
    }

    /// A* until so many moves more are priced, or its memory is full; whether it has come to its end.
    fn best_first(
        &mut self,
        remaining: &Remaining,
        on: &mut BestFirst,
        share: usize,
    ) -> Result<bool, Stopped> {
        let costs = self.costs();
        let layout = costs.layout();
        let until = self.known().priced + share;
        let mut ahead = Vec::new();
        while self.known().priced < until && on.reached.len() <= STATES_MOST {
            let mut batch: Vec<(Entry, Hop, f64)> = Vec::with_capacity(DESKS);
            while batch.len() < DESKS {
                let Some(top) = on.queue.peek().copied() else { break };
                let (f, g) = (f64::from_bits(top.f), f64::from_bits(top.g));
                if f >= self.limit() {
                    break;
                }
                on.queue.pop();
                if on.reached.get(&top.state).is_some_and(|(least, _)| *least < g) {
                    continue;
                }
                match top.next {
                    Next::Hop(hop, rest) => batch.push((top, hop, f64::from_bits(rest))),
                    Next::Open(opened) => {
                        remaining.ahead(costs, &top.state, &mut ahead);
                        let opened = usize::from(opened);
                        for of in ahead.iter().skip(opened).take(OPENED) {
                            let next = Next::Hop(of.hop, of.rest.to_bits());
                            let f = (g + of.sum()).max(f);
                            on.queue.push(Entry { f: f.to_bits(), next, ..top });
                        }
                        if let Some(of) = ahead.get(opened + OPENED) {
                            let next = Next::Open((opened + OPENED) as u16);
                            let f = (g + of.sum()).max(f);
                            on.queue.push(Entry { f: f.to_bits(), next, ..top });
                        }
                    }
                }
            }
            let limit = self.limit();
            let next = on.queue.peek().map_or(f64::INFINITY, |top| f64::from_bits(top.f));
            let least = batch.first().map_or(next, |(top, ..)| f64::from_bits(top.f)).min(on.dropped);
            self.bounded(least.min(limit));
            if batch.is_empty() {
                if least >= limit {
                    // All that is left is dearer than what is known.
                    if let Some(best) = self.known().best {
                        self.bounded(best);
                    }
                }
                return Ok(true);
            }
            let hops: Vec<(State, Hop)> = batch.iter().map(|(top, hop, _)| (top.state, *hop)).collect();
            let most = next.min(limit);
            let slack = batch.iter().map(|(top, _, rest)| most - f64::from_bits(top.g) - rest);
            let slack: Vec<f64> =
                slack.enumerate().map(|(k, slack)| if k == 0 { f64::INFINITY } else { slack }).collect();
            let answers = self.answers(&hops, &slack)?;
            for ((top, hop, rest), answer) in batch.into_iter().zip(answers) {
                let (f, g) = (f64::from_bits(top.f), f64::from_bits(top.g));
                match answer {
                    Answer::Price(price) if price.is_finite() => {
                        let after = layout.after(&top.state, hop);
                        let g = g + price;
                        if on.reached.get(&after).is_none_or(|(before, _)| g < *before) {
                            let f = (g + remaining.of(costs, &after)).max(f);
                            if f < self.limit() {
                                on.reached.insert(after, (g, Some((top.state, hop))));
                                if layout.is_done(&after) {
                                    self.learn(&Order { moves: trace(&on.reached, after), cost: g });
                                    continue;
                                }
                                on.queue.push(Entry {
                                    f: f.to_bits(),
                                    g: g.to_bits(),
                                    state: after,
                                    next: Next::Open(0),
                                });
                            }
                        }
                    }
                    Answer::Price(_) => {}
                    Answer::AtLeast(bound) => {
                        let f = (g + bound + rest).max(f);
                        on.queue.push(Entry { f: f.to_bits(), ..top });
                    }
                }
            }
            on.shrink();
        }
        Ok(false)
    }
}

impl BestFirst {
    /// Drops the dearer half of a queue that is too long.
    fn shrink(&mut self) {
        if self.queue.len() > QUEUE_MOST {
            let mut all = std::mem::take(&mut self.queue).into_vec();
            all.sort_unstable_by(|a, b| b.cmp(a));
            if let Some(first) = all.get(QUEUE_MOST / 2) {
                self.dropped = self.dropped.min(f64::from_bits(first.f));
            }
            all.truncate(QUEUE_MOST / 2);
            self.queue = all.into();
        }
    }
}

fn trace(reached: &Reached, end: State) -> Vec<Hop> {
    let mut moves = Vec::new();
    let mut state = end;
    while let Some((_, Some((before, hop)))) = reached.get(&state) {
        moves.push(*hop);
        state = *before;
    }
    moves.reverse();
    moves
}

/// The least order of all, or the best one within `patience` moves priced, one move priced after the other.
///
/// # Errors
/// As for [`Finder::search`].
pub fn exact<C: MoveCosts>(costs: &C, patience: usize) -> Result<Found, NoOrder> {
    let mut progress = super::Patience(patience);
    Finder::new(costs, &InTurn, &mut progress).search(true)
}
