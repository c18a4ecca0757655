//! What is still to be paid at least: the heuristic of the searches.
//!
//! [`Remaining::Assigned`]: the cheapest assignment of the robots that wait to the empty slots, each pair at its bound in
//! whatever state, or what [`extra`](super::extra) makes of it. Enough where bounds do not depend on the state.
//!
//! [`Remaining::Relaxed`]: where they do, since what others draw to balance depends on where they rest, the least sum over
//! all orders with every hop at its bound in its state, that is with nothing in the way, or the dearest single detour. It is
//! found by dynamic programming from the end, over all states, so only for up to [`STATES_MOST`] of them, and without parking.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::OnceLock;

use super::assignment::{Assignment, Costs};
use super::extra::Extra;
use super::{DESKS, GoesOn, Hop, Layout, MOST, MoveCosts, State, Workers};

/// Most states of the relaxed problem: those of eight equal robots are 12 870.
pub const STATES_MOST: usize = 20_000;
/// States of one job.
const CHUNK: usize = 16;

/// See the module's documentation.
#[derive(Debug)]
pub enum Remaining {
    /// By assignment, and above it where that is known.
    Assigned(Option<Box<Extra>>),
    /// What is left to be paid in every state from which the relaxed goal can be reached, and what hops cost there.
    Relaxed(HashMap<State, f64>, Option<Box<Extra>>),
}

/// A hop and what is known of its costs before it is priced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// The hop.
    pub hop: Hop,
    /// What it costs at least.
    pub bound: f64,
    /// What is to be paid after it at least.
    pub rest: f64,
}

impl Ahead {
    /// Both.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.bound + self.rest
    }
}

type Edges = Vec<(Hop, State, f64)>;

impl Remaining {
    /// The best that is affordable; `relax` says whether the second kind may be made.
    pub fn new<C: MoveCosts>(
        costs: &C,
        workers: &dyn Workers,
        relax: bool,
        goes_on: &mut GoesOn<'_>,
    ) -> ControlFlow<(), Self> {
        let extra = costs.extra(workers, goes_on)?.map(Box::new);
        let may_relax = relax && costs.depends_on_state();
        let relaxed = if may_relax { relaxed(costs, extra.as_deref(), workers, goes_on)? } else { None };
        ControlFlow::Continue(match relaxed {
            Some(known) => Self::Relaxed(known, extra),
            None => Self::Assigned(extra),
        })
    }

    /// The least that is still to be paid in a state; infinite if its goal is out of reach.
    pub fn of(&self, costs: &impl MoveCosts, state: &State) -> f64 {
        match self {
            Self::Relaxed(known, _) => known.get(state).copied().unwrap_or(f64::INFINITY),
            Self::Assigned(extra) => {
                let least = assigned(costs, state).map_or(f64::INFINITY, |(_, _, found)| found.cost);
                extra.as_ref().map_or(least, |extra| least.max(extra_of(extra, costs.layout(), state)))
            }
        }
    }

    /// Every hop of a state, least sum first.
    pub fn ahead(&self, costs: &impl MoveCosts, state: &State, found: &mut Vec<Ahead>) {
        found.clear();
        let layout = costs.layout();
        let fits = |hop: Hop| costs.may_fill(layout.filled(&layout.after(state, hop)));
        match self {
            Self::Relaxed(known, extra) => {
                for (hop, _) in layout.hops(state) {
                    let Some(rest) = known.get(&layout.after(state, hop)) else { continue };
                    if let Some(bound) = bound_in(costs, extra.as_deref(), state, hop) {
                        found.push(Ahead { hop, bound, rest: *rest });
                    }
                }
            }
            Self::Assigned(extra) => {
                let (taken, filled) = (layout.unmoved(state), layout.filled(state));
                let Some((rows, columns, best)) = assigned(costs, state) else { return };
                let forced = best.forced();
                for (row, &(from, kind)) in rows.iter().enumerate() {
                    for (column, &to) in columns.iter().enumerate() {
                        let hop = Hop::new(from, to);
                        let sum = forced[row][column];
                        if let Some(bound) = costs.bound(from, kind, to)
                            && sum.is_finite()
                            && fits(hop)
                        {
                            let (mut above, mut rest) = (0.0, (sum - bound).max(0.0));
                            if let Some(extra) = extra {
                                above = extra.of_hop((from, to - layout.robots()), taken, filled);
                                rest = rest.max(extra_of(extra, layout, &layout.after(state, hop)));
                            }
                            found.push(Ahead { hop, bound: bound + above, rest });
                        }
                    }
                    let parks = layout.hops(state).filter(|(hop, _)| hop.ends().0 == from);
                    for (hop, _) in parks.filter(|(hop, _)| layout.slot(hop.ends().1).is_none()) {
                        if let Some(bound) = costs.bound(from, kind, hop.ends().1) {
                            // A way round is no shorter than what was bounded.
                            found.push(Ahead { hop, bound, rest: (best.cost - bound).max(0.0) });
                        }
                    }
                }
            }
        }
        found.sort_by(|a, b| a.sum().total_cmp(&b.sum()).then(a.hop.cmp(&b.hop)));
    }
}

fn extra_of(extra: &Extra, layout: &Layout, state: &State) -> f64 {
    extra.of(layout.unmoved(state), layout.filled(state))
}

/// What a hop costs at least in a state: for what others draw there with nothing in its way, and with the dearest detour.
fn bound_in(costs: &impl MoveCosts, extra: Option<&Extra>, state: &State, hop: Hop) -> Option<f64> {
    let bound = costs.bound_from(state, hop)?;
    let Some(extra) = extra else { return Some(bound) };
    let layout = costs.layout();
    let (from, to) = hop.ends();
    let least = costs.bound(from, layout.occupant(state, from)?, to)?;
    let above = extra.of_hop((from, to - layout.robots()), layout.unmoved(state), layout.filled(state));
    Some(bound.max(least + above))
}

/// The robots that wait (place and kind), the empty slots, and the cheapest assignment.
type Assigned = (Vec<(usize, u8)>, Vec<usize>, Assignment);

fn assigned(costs: &impl MoveCosts, state: &State) -> Option<Assigned> {
    let layout = costs.layout();
    let rows: Vec<(usize, u8)> = layout.waiting(state).collect();
    let slots = layout.robots()..layout.robots() + layout.slots();
    let columns: Vec<usize> = slots.filter(|&slot| layout.occupant(state, slot).is_none()).collect();
    let mut matrix: Costs = [[f64::INFINITY; MOST]; MOST];
    for (row, &(from, kind)) in rows.iter().enumerate() {
        for (column, &to) in columns.iter().enumerate() {
            matrix[row][column] = costs.bound(from, kind, to).unwrap_or(f64::INFINITY);
        }
    }
    let found = Assignment::new(&matrix, rows.len(), columns.len())?;
    Some((rows, columns, found))
}

/// All states by the number of moves made, in a fixed order; `None` for more than [`STATES_MOST`], or with parking.
fn layers<C: MoveCosts>(costs: &C) -> Option<Vec<Vec<State>>> {
    let layout = costs.layout();
    if layout.berths() > 0 {
        return None;
    }
    let mut layers = vec![vec![State::default()]];
    let mut count = 1;
    for _ in 0..layout.robots() {
        let mut next: Vec<State> = Vec::new();
        for state in layers.last()? {
            let hops = layout.hops(state).filter(|&(hop, kind)| {
                let (from, to) = hop.ends();
                costs.bound(from, kind, to).is_some()
            });
            next.extend(hops.map(|(hop, _)| layout.after(state, hop)));
            // Many come more than once.
            if next.len() > 4 * STATES_MOST {
                next.sort_unstable();
                next.dedup();
                if count + next.len() > STATES_MOST {
                    return None;
                }
            }
        }
        next.sort_unstable();
        next.dedup();
        next.retain(|state| costs.may_fill(layout.filled(state)));
        count += next.len();
        if count > STATES_MOST {
            return None;
        }
        layers.push(next);
    }
    Some(layers)
}

/// `None` for too many states.
fn relaxed<C: MoveCosts>(
    costs: &C,
    extra: Option<&Extra>,
    workers: &dyn Workers,
    goes_on: &mut GoesOn<'_>,
) -> ControlFlow<(), Option<HashMap<State, f64>>> {
    let Some(mut layers) = layers(costs) else { return ControlFlow::Continue(None) };
    let layout = costs.layout();
    let last = layers.pop().unwrap_or_default();
    let mut known: HashMap<State, f64> = last.into_iter().map(|state| (state, 0.0)).collect();
    for layer in layers.iter().rev() {
        let chunks: Vec<&[State]> = layer.chunks(CHUNK).collect();
        for group in chunks.chunks(DESKS) {
            let edges: Vec<OnceLock<Vec<Edges>>> = group.iter().map(|_| OnceLock::new()).collect();
            workers.run(group.len(), &|job| {
                let all = group[job].iter().map(|state| {
                    let hops = layout.hops(state).filter_map(|(hop, _)| {
                        let after = layout.after(state, hop);
                        known.contains_key(&after).then_some(())?;
                        Some((hop, after, bound_in(costs, extra, state, hop)?))
                    });
                    hops.collect()
                });
                // Each number comes once.
                let _ = edges[job].set(all.collect());
            });
            for (states, edges) in group.iter().zip(edges) {
                for (state, edges) in states.iter().zip(edges.into_inner().unwrap_or_default()) {
                    let ways = edges.iter().map(|(_, after, bound)| bound + known[after]);
                    let least = ways.fold(f64::INFINITY, f64::min);
                    if least.is_finite() {
                        known.insert(*state, least);
                    }
                }
            }
            goes_on()?;
        }
    }
    ControlFlow::Continue(Some(known))
}
