//! The order of moves and the assignment of robots to slots: the paper's rule, and the exact optimum.
//!
//! The cost of a move depends on which robots have moved and which slots are filled, not on the order in which that came
//! about, and not on which of several equal robots fills a slot. So a *state* is the set of robots that have moved and
//! the kind of robot in every slot, and the least total cost is a shortest path over states.
//!
//! The shortest path is found by A*. What costs most is to price a move, a whole path search each time, so moves are
//! priced late: an edge waits in the queue at its lower bound, and is priced only when it comes up. What is still to
//! come is bounded by the cheapest assignment of the robots left to the slots left, each pair at its lower bound.
//!
//! Assumptions and limits: at most [`MOST`] robots and slots. Bounds must not exceed costs; then the first way to the
//! end that comes up is the optimum. `patience` limits how many moves are priced: past it the best known is returned and
//! said not to be proved.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

/// Most robots and slots that an order is found for.
pub const MOST: usize = 16;

/// Costs of moves, and lower bounds of them: what an order is chosen by.
pub trait MoveCosts {
    /// How many robots.
    fn robots(&self) -> usize;
    /// How many slots.
    fn slots(&self) -> usize;
    /// Robots of one kind are equal once they rest.
    fn kind(&self, robot: usize) -> u8;
    /// Lower bound of a robot's move to a slot from any state; `None` where that is not allowed (v2).
    fn bound(&self, robot: usize, slot: usize) -> Option<f64>;
    /// A better bound where the state is known.
    fn bound_from(&mut self, state: &State, robot: usize, slot: usize) -> Option<f64>;
    /// What the move costs; `None` if it is impossible.
    fn cost(&mut self, state: &State, robot: usize, slot: usize) -> Option<f64>;
}

/// Which robots have moved, and what is in the slots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct State {
    /// Bit k: robot k has moved.
    pub moved: u16,
    /// Kind of robot in each slot, from 1; 0 is empty.
    pub filled: [u8; MOST],
}

impl State {
    /// Whether a robot has moved.
    #[must_use]
    pub const fn has_moved(&self, robot: usize) -> bool {
        self.moved >> robot & 1 == 1
    }

    /// The state after a move.
    #[must_use]
    pub const fn after(mut self, robot: usize, slot: usize, kind: u8) -> Self {
        self.moved |= 1 << robot;
        self.filled[slot] = kind + 1;
        self
    }
}

/// An order of moves and an assignment of robots to slots.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Robot and slot of every move, in order.
    pub moves: Vec<(usize, usize)>,
    /// Their sum.
    pub cost: f64,
    /// Whether nothing is cheaper.
    pub proved: bool,
    /// How many moves were priced.
    pub priced: usize,
}

/// The paper's rule: of all robots and slots left, the pair of least cost moves next.
///
/// # Errors
/// How many moves were made before no robot could move.
pub fn by_paper(costs: &mut impl MoveCosts) -> Result<Order, usize> {
    let mut state = State::default();
    let mut order = Order { moves: Vec::new(), cost: 0.0, proved: false, priced: 0 };
    for done in 0..costs.robots() {
        let mut best: Option<(f64, usize, usize)> = None;
        for robot in (0..costs.robots()).filter(|&robot| !state.has_moved(robot)) {
            for slot in (0..costs.slots()).filter(|&slot| state.filled[slot] == 0) {
                if costs.bound(robot, slot).is_none() {
                    continue;
                }
                order.priced += 1;
                let Some(cost) = costs.cost(&state, robot, slot) else { continue };
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, robot, slot));
                }
            }
        }
        let (cost, robot, slot) = best.ok_or(done)?;
        order.moves.push((robot, slot));
        order.cost += cost;
        state = state.after(robot, slot, costs.kind(robot));
    }
    Ok(order)
}

/// A move that waits in the queue and is not priced yet, or without a move a state that has been reached. The greatest comes
/// first: least f, then greatest g, then a fixed order. Costs are not negative, and such floats sort like their bits.
type Entry = (Reverse<u64>, u64, State, Option<(usize, usize)>);

fn entry(f: f64, g: f64, state: State, next: Option<(usize, usize)>) -> Entry {
    (Reverse(f.to_bits()), g.to_bits(), state, next)
}

/// The cheapest way found to every state: its cost, and the state and the move it came by.
type Reached = HashMap<State, (f64, Option<(State, usize, usize)>)>;

/// Why no order of moves was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoOrder {
    /// None leads to the end; so many states were reached, all there are.
    Proved {
        /// How many.
        states: usize,
    },
    /// Patience ran out before one was found; there may be one.
    OutOfPatience,
}

/// The exact optimum; `known` is an order to start from, returned if nothing better turns up.
///
/// # Errors
/// [`NoOrder`]; never when one is known.
pub fn exact(costs: &mut impl MoveCosts, known: Option<Order>, patience: usize) -> Result<Order, NoOrder> {
    let all = ((1_u32 << costs.robots()) - 1) as u16;
    let mut remaining = Remaining::new(costs);
    // What is not better than the order known is not worth a look; rounding apart.
    let limit = known.as_ref().map_or(f64::INFINITY, |order| order.cost * (1.0 - 1e-9));
    let mut reached = Reached::new();
    let mut expanded = HashSet::new();
    let mut queue = BinaryHeap::new();
    let mut priced = 0;
    let start = State::default();
    reached.insert(start, (0.0, None));
    let f = remaining.bound(&start);
    queue.push(entry(f, 0.0, start, None));
    while let Some((Reverse(f), g, state, next)) = queue.pop() {
        let (f, g) = (f64::from_bits(f), f64::from_bits(g));
        if f >= limit {
            break;
        }
        let Some((robot, slot)) = next else {
            if state.moved == all {
                return Ok(Order { moves: trace(&reached, state), cost: g, proved: true, priced });
            }
            if !expanded.insert(state) {
                continue;
            }
            for robot in (0..costs.robots()).filter(|&robot| !state.has_moved(robot)) {
                for slot in (0..costs.slots()).filter(|&slot| state.filled[slot] == 0) {
                    let Some(bound) = costs.bound_from(&state, robot, slot) else { continue };
                    let after = state.after(robot, slot, costs.kind(robot));
                    let f = (g + bound + remaining.bound(&after)).max(f);
                    if f < limit {
                        queue.push(entry(f, g, state, Some((robot, slot))));
                    }
                }
            }
            continue;
        };
        if priced >= patience {
            return known.map(|order| Order { priced, ..order }).ok_or(NoOrder::OutOfPatience);
        }
        priced += 1;
        let Some(cost) = costs.cost(&state, robot, slot) else { continue };
        let after = state.after(robot, slot, costs.kind(robot));
        let g = g + cost;
        if reached.get(&after).is_none_or(|(before, _)| g < *before) {
            reached.insert(after, (g, Some((state, robot, slot))));
            let f = (g + remaining.bound(&after)).max(f);
            queue.push(entry(f, g, after, None));
        }
    }
    let proved = |order| Order { proved: true, priced, ..order };
    known.map(proved).ok_or(NoOrder::Proved { states: reached.len() })
}

fn trace(reached: &Reached, end: State) -> Vec<(usize, usize)> {
    let mut moves = Vec::new();
    let mut state = end;
    while let Some((_, Some((before, robot, slot)))) = reached.get(&state) {
        moves.push((*robot, *slot));
        state = *before;
    }
    moves.reverse();
    moves
}

/// The cheapest assignment of the robots left to the slots left, each pair at its lower bound.
struct Remaining {
    robots: usize,
    slots: usize,
    bounds: Vec<Option<f64>>,
    known: HashMap<(u16, u16), f64>,
}

impl Remaining {
    fn new(costs: &impl MoveCosts) -> Self {
        let (robots, slots) = (costs.robots(), costs.slots());
        let pairs = (0..robots).flat_map(|robot| (0..slots).map(move |slot| (robot, slot)));
        let bounds = pairs.map(|(robot, slot)| costs.bound(robot, slot)).collect();
        Self { robots, slots, bounds, known: HashMap::new() }
    }

    fn bound(&mut self, state: &State) -> f64 {
        let filled = (0..self.slots).filter(|&slot| state.filled[slot] != 0);
        let filled = filled.fold(0_u16, |mask, slot| mask | 1 << slot);
        self.cheapest(state.moved, filled)
    }

    /// Infinite where there is none.
    fn cheapest(&mut self, moved: u16, filled: u16) -> f64 {
        let Some(robot) = (0..self.robots).find(|&robot| moved >> robot & 1 == 0) else { return 0.0 };
        if let Some(&known) = self.known.get(&(moved, filled)) {
            return known;
        }
        let mut least = f64::INFINITY;
        for slot in (0..self.slots).filter(|&slot| filled >> slot & 1 == 0) {
            if let Some(bound) = self.bounds[robot * self.slots + slot] {
                least = least.min(bound + self.cheapest(moved | 1 << robot, filled | 1 << slot));
            }
        }
        self.known.insert((moved, filled), least);
        least
    }
}

#[cfg(test)]
mod tests {
    use std::hash::{DefaultHasher, Hash, Hasher};

    use super::*;

    /// Costs drawn from a hash of everything they may depend on, some moves impossible.
    struct Drawn {
        seed: u64,
        robots: usize,
        slots: usize,
        kinds: u8,
        priced: usize,
    }

    impl Drawn {
        fn draw(&self, what: impl Hash) -> f64 {
            let mut hasher = DefaultHasher::new();
            (self.seed, what).hash(&mut hasher);
            (hasher.finish() >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    impl MoveCosts for Drawn {
        fn robots(&self) -> usize {
            self.robots
        }
        fn slots(&self) -> usize {
            self.slots
        }
        fn kind(&self, robot: usize) -> u8 {
            robot as u8 % self.kinds
        }
        fn bound(&self, robot: usize, slot: usize) -> Option<f64> {
            (self.draw((robot, slot)) > 0.1).then(|| 1.0 + self.draw((robot, slot, 1)))
        }
        fn bound_from(&mut self, _: &State, robot: usize, slot: usize) -> Option<f64> {
            self.bound(robot, slot)
        }
        fn cost(&mut self, state: &State, robot: usize, slot: usize) -> Option<f64> {
            self.priced += 1;
            let extra = self.draw((state, robot, slot));
            self.bound(robot, slot).filter(|_| extra > 0.15).map(|bound| bound + 3.0 * extra)
        }
    }

    /// Every order and assignment, one after the other.
    fn brute_force(costs: &mut Drawn, state: State) -> Option<f64> {
        if (0..costs.robots).all(|robot| state.has_moved(robot)) {
            return Some(0.0);
        }
        let mut least: Option<f64> = None;
        for robot in (0..costs.robots).filter(|&robot| !state.has_moved(robot)) {
            for slot in (0..costs.slots).filter(|&slot| state.filled[slot] == 0) {
                let Some(cost) = costs.cost(&state, robot, slot) else { continue };
                let after = state.after(robot, slot, costs.kind(robot));
                if let Some(rest) = brute_force(costs, after) {
                    least = Some(least.map_or(cost + rest, |least| least.min(cost + rest)));
                }
            }
        }
        least
    }

    #[test]
    fn the_exact_order_is_the_best_of_all_and_never_above_the_rule() {
        let (mut solved, mut below, mut dead_ends) = (0, 0, 0);
        for seed in 0..300_u64 {
            let robots = 1 + (seed % 4) as usize;
            let slots = robots + (seed / 4 % 2) as usize;
            let mut costs = Drawn { seed, robots, slots, kinds: 1 + (seed % 3) as u8, priced: 0 };
            let truth = brute_force(&mut costs, State::default());
            let rule = by_paper(&mut costs);
            let alone = exact(&mut costs, None, usize::MAX);
            let helped = exact(&mut costs, rule.clone().ok(), usize::MAX);
            match truth {
                None => {
                    let proved = |result| matches!(result, Err(NoOrder::Proved { states }) if states > 0);
                    assert!(proved(alone) && proved(helped) && rule.is_err(), "seed {seed}");
                }
                Some(truth) => {
                    solved += 1;
                    for order in [alone.expect("an order"), helped.expect("an order")] {
                        assert!((order.cost - truth).abs() < 1e-9 * truth && order.proved, "seed {seed}");
                        let mut state = State::default();
                        let mut sum = 0.0;
                        for (robot, slot) in order.moves {
                            assert!(!state.has_moved(robot) && state.filled[slot] == 0, "seed {seed}");
                            sum += costs.cost(&state, robot, slot).expect("possible");
                            state = state.after(robot, slot, costs.kind(robot));
                        }
                        assert!((sum - truth).abs() < 1e-9 * truth, "seed {seed}: {sum} {truth}");
                    }
                    match rule {
                        Ok(rule) => {
                            assert!(rule.cost >= truth - 1e-9, "seed {seed}");
                            below += usize::from(truth < rule.cost - 1e-9);
                        }
                        Err(_) => dead_ends += 1,
                    }
                }
            }
        }
        assert!(
            solved > 200 && below > 50 && dead_ends > 0,
            "{solved} solved, {below} below the rule, {dead_ends}"
        );
    }

    #[test]
    fn moves_are_priced_late() {
        let mut costs = Drawn { seed: 3, robots: 6, slots: 6, kinds: 1, priced: 0 };
        let order = exact(&mut costs, None, usize::MAX).expect("an order");
        // Σ over k of C(6, k)²·(6 − k)² moves there are.
        assert!(order.priced < 15_000 && costs.priced == order.priced, "{} of 16 632", order.priced);
        // One move less is not enough for a proof: then the one known is returned, however dear.
        let known = Order { moves: Vec::new(), cost: 1e9, proved: false, priced: 0 };
        let impatient = exact(&mut costs, Some(known.clone()), order.priced - 1).expect("the known one");
        assert_eq!(impatient, Order { priced: order.priced - 1, ..known.clone() });
        let helpless = exact(&mut costs, None, order.priced - 1);
        assert_eq!(helpless, Err(NoOrder::OutOfPatience));
        assert_eq!(exact(&mut costs, Some(known), order.priced).expect("an order"), order);
    }
}
