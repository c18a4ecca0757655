//! Least total travel over the ways that arc consistency left, by branch and bound with propagation.
//!
//! ```text
//! least Σᵢ |rotationᵢ(wayᵢ)|   subject to   (wayᵢ, wayⱼ) allowed for every pair
//! ```
//!
//! - *Feasibility does not backtrack.* Two ways a module and constraints between two modules are 2-SAT: a
//!   choice whose propagation meets no contradiction never has to be taken back. So the first answer is found,
//!   or its absence proved, in polynomial time whatever the size.
//! - *Only conflicts are branched on.* If no two open neighbours forbid (short, short), then everybody open
//!   going the short way is allowed, and nothing is shorter.
//! - *Bound*: the decided ways, the short way for everybody open, and for disjoint conflicting pairs the
//!   lesser of the two detours.
//! - The problem falls apart into components that share no constraint between open modules.
//!
//! Finding the least is NP-hard in general; past `node_limit` branches the best answer so far is kept, marked
//! as not proved least.

use super::domain::{Allowed, Domain, propagate};
use crate::modboat::pairs::Pairs;

/// The problem to search.
pub struct Problem<'a> {
    /// Neighbours.
    pub pairs: &'a Pairs,
    /// What goes together, by pair.
    pub allowed: &'a [Allowed],
    /// |rotation| of the short and the long way, rad, by module.
    pub travel_rad: &'a [[f64; 2]],
    /// Branches after which the search settles for the best answer so far.
    pub node_limit: usize,
}

/// The ways to take.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// 0 short, 1 long, by module.
    pub ways: Vec<usize>,
    /// True if proved to be the least travel.
    pub exact: bool,
}

struct State<'p> {
    problem: &'p Problem<'p>,
    domains: Vec<Domain>,
    trail: Vec<(usize, Domain)>,
    queue: Vec<usize>,
    /// Round in which a module was matched in the bound.
    matched: Vec<usize>,
    round: usize,
    nodes: usize,
    exact: bool,
    best: Vec<usize>,
    best_rad: f64,
}

impl Problem<'_> {
    /// The ways with the least total travel; `None` if it is proved that there are none.
    #[must_use]
    pub fn solve(&self, mut domains: Vec<Domain>) -> Option<Answer> {
        let modules = self.pairs.modules();
        let (mut queue, mut trail) = ((0..modules).collect(), Vec::new());
        if domains.iter().any(|d| d.is_empty())
            || !propagate(self.pairs, self.allowed, &mut domains, &mut queue, &mut trail, |_| true)
        {
            return None;
        }
        trail.clear();
        let components = self.components(&domains);
        let mut state = State {
            problem: self,
            domains,
            trail,
            queue,
            matched: vec![0; modules],
            round: 0,
            nodes: 0,
            exact: true,
            best: vec![0; modules],
            best_rad: f64::INFINITY,
        };
        for component in &components {
            state.nodes = 0;
            state.best_rad = f64::INFINITY;
            state.branch(component);
            if state.best_rad.is_infinite() {
                return None;
            }
            for &module in component {
                state.domains[module] = Domain::only(state.best[module]);
            }
        }
        let ways = state.domains.iter().map(|d| usize::from(!d.has(0))).collect();
        Some(Answer { ways, exact: state.exact })
    }

    /// Groups of open modules that constrain each other; open modules that nothing constrains are in none.
    fn components(&self, domains: &[Domain]) -> Vec<Vec<usize>> {
        let mut seen = vec![false; domains.len()];
        let mut components = Vec::new();
        for start in 0..domains.len() {
            if seen[start] || !domains[start].is_open() {
                continue;
            }
            seen[start] = true;
            let mut component = vec![start];
            let mut next = 0;
            while let Some(&module) = component.get(next) {
                next += 1;
                for &index in self.pairs.of(module) {
                    let other = self.pairs.all()[index].other(module);
                    if domains[other].is_open() && !self.allowed[index].is_all() && !seen[other] {
                        seen[other] = true;
                        component.push(other);
                    }
                }
            }
            if component.len() > 1 {
                components.push(component);
            }
        }
        components
    }

    fn detour_rad(&self, module: usize) -> f64 {
        self.travel_rad[module][1] - self.travel_rad[module][0]
    }
}

impl State<'_> {
    fn undo(&mut self, mark: usize) {
        while self.trail.len() > mark {
            if let Some((module, before)) = self.trail.pop() {
                self.domains[module] = before;
            }
        }
    }

    /// Lower bound of this component, and the open module with the most conflicts if there is any conflict.
    fn bound(&mut self, component: &[usize]) -> (f64, Option<usize>) {
        let problem = self.problem;
        self.round += 1;
        let (mut bound, mut pick, mut most) = (0.0, None, 0);
        for &module in component {
            let domain = self.domains[module];
            bound += problem.travel_rad[module][usize::from(!domain.has(0))];
            if !domain.is_open() {
                continue;
            }
            let mut conflicts = 0;
            for &index in problem.pairs.of(module) {
                let other = problem.pairs.all()[index].other(module);
                if problem.allowed[index].has(0, 0) || !self.domains[other].is_open() {
                    continue;
                }
                conflicts += 1;
                if self.matched[module] != self.round && self.matched[other] != self.round {
                    self.matched[module] = self.round;
                    self.matched[other] = self.round;
                    bound += problem.detour_rad(module).min(problem.detour_rad(other));
                }
            }
            if conflicts > most {
                (pick, most) = (Some(module), conflicts);
            }
        }
        (bound, pick)
    }

    /// Depth-first; true if this subtree holds an answer or was cut off by the bound.
    fn branch(&mut self, component: &[usize]) -> bool {
        let (bound, pick) = self.bound(component);
        if bound >= self.best_rad - 1e-12 {
            return true;
        }
        let Some(module) = pick else {
            // Nobody who is open is in anybody's way: all go short, and the bound is what it costs.
            for &module in component {
                self.best[module] = usize::from(!self.domains[module].has(0));
            }
            self.best_rad = bound;
            return true;
        };
        self.nodes += 1;
        // Whose detour is the lesser: this module's, or that of all it stands against?
        let problem = self.problem;
        let against: f64 = problem
            .pairs
            .of(module)
            .iter()
            .map(|&index| (index, problem.pairs.all()[index].other(module)))
            .filter(|&(index, other)| !problem.allowed[index].has(0, 0) && self.domains[other].is_open())
            .map(|(_, other)| problem.detour_rad(other))
            .sum();
        let first = usize::from(problem.detour_rad(module) < against);
        let mut feasible = false;
        for way in [first, 1 - first] {
            if feasible && self.nodes >= problem.node_limit {
                self.exact = false;
                break;
            }
            let mark = self.trail.len();
            self.trail.push((module, self.domains[module]));
            self.domains[module] = Domain::only(way);
            self.queue.push(module);
            if propagate(
                problem.pairs,
                problem.allowed,
                &mut self.domains,
                &mut self.queue,
                &mut self.trail,
                |_| true,
            ) {
                feasible |= self.branch(component);
            }
            self.undo(mark);
        }
        feasible
    }
}
