//! One option for every node of a graph at the least total cost, where neighbours forbid each other some combinations: exact
//! within [`Limits`]. A problem on graphs only.
//!
//! ```text
//! least Σᵢ cᵢ(xᵢ)   over xᵢ ∈ {0 … mᵢ − 1}   subject to   (xᵢ, xⱼ) allowed for every pair (i, j)
//! ```
//!
//! - *Verdicts are asked for when they matter.* Every node takes its cheapest option. Only pairs that the present choice breaks
//!   become constraints, with all their verdicts; what they join is solved again, until nothing is broken. The constraints so
//!   far are a relaxation: a choice that is least for them and breaks no other pair is least. Where the cheapest options
//!   agree with each other, the first look at every pair is all the work.
//! - *Arc consistency* (AC-3, Mackworth 1977, \[16\] of the paper) drops the options that go with none of a neighbour's.
//! - *Groups.* Modules with one option left and constraints that forbid nothing any more drop out; what still hangs together
//!   is a group and solved by itself.
//! - *A group* is solved by dynamic programming over a frontier, see [`tables`], and where its tables would become too
//!   large by branch and bound with smaller tables as the bound, see [`descent`]. With two options each, [`two_sat`] settles
//!   beforehand whether there is an answer.
//!
//! Limits: the least cost is NP-hard in general. Beyond [`Limits`] the answer is the best that was met, with a proved lower
//! bound; whether there is an answer at all stays decided as long as no node of the group has more than two options. Costs within
//! 1e-9 of each other count as equal.
//!
//! *What is exact*, by the limits that are the default, two options each:
//!
//! | squares where | exact | beyond |
//! |---|---|---|
//! | every side forbids one combination of four, all in one group | up to 11 × 11 | gap 2 % (12 × 12) to 5 % (32 × 32) |
//! | tails of the default geometry turn between unrelated cycles, four to sixteen options too | all up to 32 × 32 | |
//!
//! The second holds because verdicts that do not matter are never asked for: the groups stay narrow. Lines are exact at any length.

pub mod descent;
pub mod graph;
pub mod tables;
pub mod two_sat;

use self::descent::{Descent, DescentOutcome};
use self::graph::Graph;
use crate::pairs::Pairs;

/// The most options of one module.
pub const OPTIONS_MAX: usize = 16;

/// Limits of the effort for one group.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Entries of all tables together, times the options that each is the least of.
    pub entries: usize,
    /// Choices tried by branch and bound beyond the first answer.
    pub nodes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { entries: 1 << 19, nodes: 4096 }
    }
}

/// Result of a search for one option per module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The choice in [`Chooser::chosen`].
    Best {
        /// Its total cost.
        cost: f64,
        /// No choice costs less than this; the cost itself where the search was exact.
        bound: f64,
    },
    /// Proved: there is no choice.
    Impossible,
    /// The limits ran out before a choice was met. Never where no node has more than two options.
    Unknown,
}

/// The solver, with its workspace: it allocates nothing once it has met a problem of the size.
#[derive(Clone, Debug, Default)]
pub struct Chooser {
    limits: Limits,
    /// The costs of module m are `costs[first[m]..first[m + 1]]`.
    costs: Vec<f64>,
    first: Vec<usize>,
    /// Options still open, by module, one bit each.
    domains: Vec<u16>,
    chosen: Vec<u8>,
    /// Cost above the proved bound of the group that a module came first in.
    slack: Vec<f64>,
    /// Of a pair that is a constraint: where its rows start, by option of i the options of j that go with it.
    constraint: Vec<Option<usize>>,
    rows: Vec<u16>,
    /// The combination last found allowed of a pair that is no constraint.
    agreed: Vec<Option<[u8; 2]>>,
    queue: Vec<usize>,
    dirty: Vec<usize>,
    changed: Vec<usize>,
    /// Round in which a module was last put in a group, and its place there.
    seen: Vec<usize>,
    local: Vec<usize>,
    round: usize,
    group: Vec<usize>,
    graph: Graph,
    descent: Descent,
}

impl Chooser {
    /// A solver with these limits.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self { limits, ..Self::default() }
    }

    /// Makes room for problems of these pairs, so that they allocate nothing from the first on, unless a group needs more tables than
    /// groups mostly do.
    pub fn reserve(&mut self, pairs: &Pairs) {
        let (modules, count) = (pairs.modules(), pairs.all().len());
        self.costs.reserve(OPTIONS_MAX * modules);
        for list in [&mut self.first, &mut self.seen, &mut self.local, &mut self.group, &mut self.changed] {
            list.reserve(modules + 1);
        }
        self.domains.reserve(modules);
        self.chosen.reserve(modules);
        self.slack.reserve(modules);
        self.constraint.reserve(count);
        self.rows.reserve(OPTIONS_MAX * count);
        self.agreed.reserve(count);
        // Both ends of every pair, and a module once for each option that it loses.
        for list in [&mut self.queue, &mut self.dirty] {
            list.reserve(2 * count + OPTIONS_MAX * modules);
        }
        self.graph.reserve(modules, count);
        self.descent.reserve(modules, count);
    }

    /// Removes all nodes from the problem.
    pub fn clear(&mut self) {
        self.costs.clear();
        self.first.clear();
        self.first.push(0);
    }

    /// The next module, with the costs of its options; those beyond [`OPTIONS_MAX`] are not looked at.
    pub fn module(&mut self, costs: impl IntoIterator<Item = f64>) {
        self.costs.extend(costs.into_iter().take(OPTIONS_MAX));
        self.first.push(self.costs.len());
    }

    /// The option chosen for each module.
    #[must_use]
    pub fn chosen(&self) -> &[u8] {
        &self.chosen
    }

    /// The least choice for the modules given; `allowed(index, a, b)` says whether option a of module i and option b of module j
    /// of the pair at that index go together.
    pub fn choose(&mut self, pairs: &Pairs, mut allowed: impl FnMut(usize, usize, usize) -> bool) -> Answer {
        if !self.reset(pairs) {
            return Answer::Impossible;
        }
        for index in 0..pairs.all().len() {
            self.look(pairs, index, &mut allowed);
        }
        while !self.queue.is_empty() {
            if !self.propagate(pairs) {
                return Answer::Impossible;
            }
            if let Some(failed) = self.solve_dirty(pairs) {
                return failed;
            }
            while let Some(module) = self.changed.pop() {
                for &index in pairs.of(module) {
                    self.look(pairs, index, &mut allowed);
                }
            }
        }
        let cost = (0..self.chosen.len()).map(|m| self.cost(m, self.chosen[m])).sum();
        Answer::Best { cost, bound: cost - self.slack.iter().sum::<f64>() }
    }

    fn cost(&self, module: usize, option: u8) -> f64 {
        self.costs[self.first[module] + usize::from(option)]
    }

    /// The cheapest option still open, the first of equals.
    fn cheapest(&self, module: usize) -> u8 {
        let less = |a: &u8, b: &u8| self.cost(module, *a).total_cmp(&self.cost(module, *b));
        graph::bits(self.domains[module]).min_by(less).unwrap_or(0)
    }

    /// Opens all options, and puts every node at its cheapest. False if a node has no option at all.
    fn reset(&mut self, pairs: &Pairs) -> bool {
        let modules = pairs.modules();
        if self.first.len() != modules + 1 || self.first.windows(2).any(|ends| ends[0] == ends[1]) {
            return false;
        }
        self.domains.clear();
        self.domains
            .extend(self.first.windows(2).map(|ends| u16::MAX >> (OPTIONS_MAX - (ends[1] - ends[0]))));
        self.chosen.clear();
        for module in 0..modules {
            let cheapest = self.cheapest(module);
            self.chosen.push(cheapest);
        }
        refill(&mut self.slack, modules, 0.0);
        refill(&mut self.constraint, pairs.all().len(), None);
        refill(&mut self.agreed, pairs.all().len(), None);
        refill(&mut self.seen, modules, 0);
        refill(&mut self.local, modules, 0);
        self.round = 0;
        for list in [&mut self.queue, &mut self.dirty, &mut self.changed] {
            list.clear();
        }
        self.rows.clear();
        true
    }

    /// Makes a constraint of a pair that the present choice breaks.
    fn look(&mut self, pairs: &Pairs, index: usize, allowed: &mut impl FnMut(usize, usize, usize) -> bool) {
        let pair = pairs.all()[index];
        let [a, b] = [self.chosen[pair.i], self.chosen[pair.j]];
        if self.constraint[index].is_some() || self.agreed[index] == Some([a, b]) {
            return;
        }
        if allowed(index, a.into(), b.into()) {
            self.agreed[index] = Some([a, b]);
            return;
        }
        self.constraint[index] = Some(self.rows.len());
        let options = |module: usize| self.first[module + 1] - self.first[module];
        for of_i in 0..options(pair.i) {
            let mut row = 0_u16;
            for of_j in graph::bits(self.domains[pair.j]) {
                let open = self.domains[pair.i] & 1 << of_i != 0 && (of_i != usize::from(a) || of_j != b);
                if open && allowed(index, of_i, of_j.into()) {
                    row |= 1 << of_j;
                }
            }
            self.rows.push(row);
        }
        self.queue.extend([pair.i, pair.j]);
        self.dirty.extend([pair.i, pair.j]);
    }

    /// AC-3 over the constraints, from the modules in the queue. False if a module is left without an option.
    fn propagate(&mut self, pairs: &Pairs) -> bool {
        while let Some(module) = self.queue.pop() {
            let domain = self.domains[module];
            for &index in pairs.of(module) {
                let (pair, Some(start)) = (pairs.all()[index], self.constraint[index]) else { continue };
                let other = pair.other(module);
                let before = self.domains[other];
                let supported = if other == pair.j {
                    graph::bits(domain).fold(0, |all, a| all | self.rows[start + usize::from(a)])
                } else {
                    let goes = |a: &u8| self.rows[start + usize::from(*a)] & domain != 0;
                    graph::bits(before).filter(goes).fold(0, |all, a| all | 1 << a)
                };
                let after = before & supported;
                if after == 0 {
                    return false;
                }
                if after != before {
                    self.domains[other] = after;
                    self.queue.push(other);
                    self.dirty.push(other);
                }
            }
        }
        true
    }

    /// True if a pair still forbids something that is open.
    fn constrains(&self, pairs: &Pairs, index: usize) -> bool {
        let pair = pairs.all()[index];
        let of_j = self.domains[pair.j];
        self.constraint[index].is_some_and(|start| {
            graph::bits(self.domains[pair.i]).any(|a| self.rows[start + usize::from(a)] & of_j != of_j)
        })
    }

    /// Solves every group that a dirty module, or a neighbour by a constraint, belongs to. What kept it from that, if anything.
    fn solve_dirty(&mut self, pairs: &Pairs) -> Option<Answer> {
        self.round += 1;
        for place in 0..self.dirty.len() {
            let module = self.dirty[place];
            for &index in pairs.of(module) {
                if self.constraint[index].is_some() {
                    self.dirty.push(pairs.all()[index].other(module));
                }
            }
        }
        while let Some(start) = self.dirty.pop() {
            if self.seen[start] == self.round {
                continue;
            }
            self.gather(pairs, start);
            for place in 0..self.group.len() {
                self.slack[self.group[place]] = 0.0;
            }
            if self.group.len() == 1 {
                self.take(start, self.cheapest(start));
                continue;
            }
            let gap = match self.descent.solve(&mut self.graph, self.limits) {
                DescentOutcome::Best { gap } => gap,
                DescentOutcome::Nothing { proved: true } => return Some(Answer::Impossible),
                DescentOutcome::Nothing { proved: false } => return Some(Answer::Unknown),
            };
            self.slack[start] = gap;
            for place in 0..self.group.len() {
                let option = self.graph.option(place, self.descent.best()[place]);
                self.take(self.group[place], option);
            }
        }
        None
    }

    /// The group of `start`, as a graph of its own.
    fn gather(&mut self, pairs: &Pairs, start: usize) {
        self.group.clear();
        self.group.push(start);
        self.seen[start] = self.round;
        self.graph.clear();
        let mut next = 0;
        while let Some(&module) = self.group.get(next) {
            self.local[module] = next;
            next += 1;
            let costs = &self.costs[self.first[module]..self.first[module + 1]];
            self.graph.node(self.domains[module], costs);
            for &index in pairs.of(module) {
                let other = pairs.all()[index].other(module);
                if self.seen[other] != self.round && self.constrains(pairs, index) {
                    self.seen[other] = self.round;
                    self.group.push(other);
                }
            }
        }
        for &module in &self.group {
            for &index in pairs.of(module) {
                let (pair, Some(row)) = (pairs.all()[index], self.constraint[index]) else { continue };
                if pair.i == module && self.constrains(pairs, index) {
                    self.graph.edge(self.local[pair.i], self.local[pair.j], &self.rows[row..]);
                }
            }
        }
    }

    fn take(&mut self, module: usize, option: u8) {
        if self.chosen[module] != option {
            self.chosen[module] = option;
            self.changed.push(module);
        }
    }
}

/// `list` with so many values, all the same.
fn refill<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    list.clear();
    list.resize(len, value);
}

#[cfg(test)]
mod tests;
