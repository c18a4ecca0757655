//! Searches before an oracle that tries every order, on costs drawn at random.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::paper::NoRule;
use super::search::{Found, NoOrder, exact};
use super::*;

/// Costs drawn from a hash of everything they may depend on, some moves impossible.
struct Drawn {
    seed: u64,
    layout: Layout,
    depends: bool,
    priced: AtomicUsize,
}

impl Drawn {
    fn new(seed: u64, robots: usize, slots: usize, kinds: u8) -> Self {
        let of_robots = (0..robots).map(|robot| robot as u8 % kinds).collect();
        let layout = Layout::new(of_robots, (0..kinds).collect(), slots);
        Self { seed, layout, depends: seed.is_multiple_of(2), priced: AtomicUsize::new(0) }
    }

    fn parking(self, berths: usize, moves: usize) -> Self {
        Self { layout: self.layout.with_berths(berths, moves), ..self }
    }

    fn draw(&self, what: impl Hash) -> f64 {
        let mut hasher = DefaultHasher::new();
        (self.seed, what).hash(&mut hasher);
        (hasher.finish() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn price(&self, state: &State, hop: Hop) -> Option<f64> {
        match self.cost(0, state, hop, f64::INFINITY) {
            Answer::Price(price) => Some(price).filter(|price| price.is_finite()),
            Answer::AtLeast(bound) => panic!("at least {bound}, not a price"),
        }
    }

    /// What others make a hop cost more, known before it is priced.
    fn others(&self, state: &State, hop: Hop) -> f64 {
        if self.depends { self.draw((state, hop, 2)) } else { 0.0 }
    }
}

impl MoveCosts for Drawn {
    fn layout(&self) -> &Layout {
        &self.layout
    }
    fn bound(&self, from: usize, kind: u8, to: usize) -> Option<f64> {
        let stop = self.layout.slot(to).is_none();
        // A way round by a parking place costs 1 to 2 twice, a straight one 1 to 2 at least.
        (stop || self.draw((kind, to)) > 0.1).then(|| 1.0 + if stop { 0.0 } else { self.draw((from, to, 1)) })
    }
    fn bound_from(&self, state: &State, hop: Hop) -> Option<f64> {
        let (from, to) = hop.ends();
        let kind = self.layout.occupant(state, from)?;
        Some(self.bound(from, kind, to)? + self.others(state, hop))
    }
    fn cost(&self, _: usize, state: &State, hop: Hop, _: f64) -> Answer {
        self.priced.fetch_add(1, Ordering::Relaxed);
        let extra = self.draw((state, hop));
        // With parking, direct ways are often impossible.
        let shut =
            if self.layout.berths() > 0 && self.layout.slot(hop.ends().1).is_some() { 0.5 } else { 0.15 };
        let bound = self.bound_from(state, hop).filter(|_| extra > shut);
        Answer::Price(bound.map_or(f64::INFINITY, |bound| bound + 3.0 * extra))
    }
    fn depends_on_state(&self) -> bool {
        self.depends
    }
    fn may_fill(&self, filled: u32) -> bool {
        // More slots than robots: the first and the last one do not go together.
        let (robots, slots) = (self.layout.robots(), self.layout.slots());
        slots == robots || filled & 1 == 0 || filled >> (slots - 1) & 1 == 0
    }
}

/// The least that is still to be paid, over every order and assignment.
fn oracle(costs: &Drawn, state: State, known: &mut HashMap<State, Option<f64>>) -> Option<f64> {
    if costs.layout.is_done(&state) {
        return Some(0.0);
    }
    if let Some(known) = known.get(&state) {
        return *known;
    }
    let hops: Vec<Hop> = costs.layout.hops(&state).map(|(hop, _)| hop).collect();
    let mut least: Option<f64> = None;
    for hop in hops {
        let after = costs.layout.after(&state, hop);
        if !costs.may_fill(costs.layout.filled(&after)) {
            continue;
        }
        let Some(cost) = costs.price(&state, hop) else { continue };
        if let Some(rest) = oracle(costs, after, known) {
            least = Some(least.map_or(cost + rest, |least| least.min(cost + rest)));
        }
    }
    known.insert(state, least);
    least
}

/// The moves lead to the end and cost what is said.
fn check(costs: &Drawn, order: &Order, what: &str) {
    let (mut state, mut sum) = (State::default(), 0.0);
    for &hop in &order.moves {
        assert!(costs.layout.hops(&state).any(|(other, _)| other == hop), "{what}: {hop:?}");
        sum += costs.price(&state, hop).expect("possible");
        state = costs.layout.after(&state, hop);
    }
    assert!(costs.layout.is_done(&state), "{what}: not at the end");
    assert!((sum - order.cost).abs() < 1e-9 * sum.max(1.0), "{what}: {sum} {}", order.cost);
}

fn agrees(costs: &Drawn, what: &str) -> Option<f64> {
    let truth = oracle(costs, State::default(), &mut HashMap::new());
    for relax in [false, true] {
        let mut progress = Patience(usize::MAX);
        let mut finder = Finder::new(costs, &InTurn, &mut progress);
        match (truth, finder.search(relax)) {
            (None, Err(NoOrder::Proved { states })) => assert!(states > 0, "{what}"),
            (Some(truth), Ok(Found { order, bound, proved })) => {
                assert!(
                    proved && (order.cost - truth).abs() < 1e-9 * truth,
                    "{what}: {} {truth}",
                    order.cost
                );
                assert!(bound <= truth * (1.0 + 1e-9) && bound >= truth * (1.0 - 1e-8), "{what}: {bound}");
                check(costs, &order, what);
            }
            (truth, found) => panic!("{what}: {truth:?} {found:?}"),
        }
    }
    truth
}

#[test]
fn the_least_order_is_that_of_the_oracle_over_two_hundred_tables_and_never_above_the_rule() {
    let (mut solved, mut below, mut dead_ends) = (0, 0, 0);
    for seed in 0..240_u64 {
        let robots = 1 + (seed % 4) as usize;
        let slots = robots + (seed / 4 % 3) as usize;
        let costs = Drawn::new(seed, robots, slots, 1 + (seed % 3) as u8);
        let what = format!("seed {seed}");
        let truth = agrees(&costs, &what);
        let mut progress = Patience(usize::MAX);
        let mut finder = Finder::new(&costs, &InTurn, &mut progress);
        match (truth, finder.by_paper()) {
            (Some(truth), Ok(rule)) => {
                check(&costs, &rule, &what);
                (solved, below) = (solved + 1, below + usize::from(truth < rule.cost - 1e-9));
                assert!(rule.cost >= truth - 1e-9, "{what}");
            }
            (Some(_), Err(NoRule::DeadEnd(_))) => (solved, dead_ends) = (solved + 1, dead_ends + 1),
            (None, Err(NoRule::DeadEnd(_))) => {}
            (truth, rule) => panic!("{what}: {truth:?} {rule:?}"),
        }
    }
    assert!(solved > 150 && below > 50 && dead_ends > 0, "{solved} solved, {below} below, {dead_ends}");
}

#[test]
fn parking_is_searched_whole_over_two_hundred_tables() {
    let (mut solved, mut only_parked, mut impossible) = (0, 0, 0);
    for seed in 0..200_u64 {
        let robots = 1 + (seed % 3) as usize;
        let make = || Drawn::new(seed, robots, robots, 1 + (seed % 3) as u8);
        let moves = 2 + (seed / 3 % 2) as usize;
        let costs = make().parking(1 + (seed % 2) as usize, moves);
        match agrees(&costs, &format!("seed {seed}, {moves} moves")) {
            Some(_) => solved += 1,
            None => impossible += 1,
        }
        // The same costs without parking places.
        let direct = Drawn { layout: make().layout, ..make().parking(1, 2) };
        only_parked += usize::from(oracle(&direct, State::default(), &mut HashMap::new()).is_none());
    }
    assert!(solved > 100 && only_parked > 10 && impossible > 0, "{solved} {only_parked} {impossible}");
}

#[test]
fn moves_are_priced_late_and_an_early_end_gives_the_best_known() {
    let costs = Drawn::new(3, 6, 6, 1);
    let found = exact(&costs, usize::MAX).expect("an order");
    let priced = costs.priced.load(Ordering::Relaxed);
    // Σ over k of C(6, k)²·(6 − k)² moves there are.
    assert!(found.proved && priced < 9_000, "{priced} of 16 632");
    let mut last = f64::INFINITY;
    for patience in [50, 100, 200, 400, 800, 1600] {
        match exact(&costs, patience) {
            Ok(early) => {
                assert!(
                    early.order.cost <= last && early.bound <= found.order.cost * (1.0 + 1e-9),
                    "{patience}"
                );
                check(&costs, &early.order, &format!("{patience} priced"));
                last = early.order.cost;
            }
            Err(none) => assert!(none == NoOrder::Stopped && patience < 200, "{patience}"),
        }
    }
    assert!(last < 1.2 * found.order.cost, "{last} {}", found.order.cost);
    assert_eq!(exact(&costs, 3), Err(NoOrder::Stopped));
}

/// Runs jobs backwards: the result must not depend on which is done first.
struct Backwards;

impl Workers for Backwards {
    fn run(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).rev().for_each(job);
    }
}

#[test]
fn reports_close_in_and_the_order_of_jobs_does_not_matter() {
    struct Heard(Vec<Known>);
    impl Progress for Heard {
        fn report(&mut self, known: &Known) -> ControlFlow<()> {
            self.0.push(*known);
            ControlFlow::Continue(())
        }
    }
    let costs = Drawn::new(8, 5, 5, 2);
    let search = |workers: &dyn Workers| {
        let mut heard = Heard(Vec::new());
        let found = Finder::new(&costs, workers, &mut heard).search(true).expect("an order");
        (found, heard.0)
    };
    let (found, heard) = search(&InTurn);
    assert_eq!((found.clone(), heard.clone()), search(&Backwards));
    assert!(heard.len() > 10, "{} reports", heard.len());
    for pair in heard.windows(2) {
        let (Some(before), Some(after)) =
            (pair[0].best.or(Some(f64::INFINITY)), pair[1].best.or(Some(f64::INFINITY)))
        else {
            continue;
        };
        assert!(after <= before && pair[1].bound >= pair[0].bound, "{pair:?}");
        assert!(pair[1].bound <= found.order.cost * (1.0 + 1e-9), "{pair:?}");
    }
}
