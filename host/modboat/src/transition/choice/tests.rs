use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::two_sat::TwoSat;
use super::*;
use crate::pairs::Pair;

/// A random problem: costs by module and option, and verdicts by pair.
struct Case {
    pairs: Pairs,
    costs: Vec<Vec<f64>>,
    allowed: Vec<Vec<Vec<bool>>>,
}

impl Case {
    fn new(pairs: Pairs, options: usize, share: f64, rng: &mut ChaCha8Rng) -> Self {
        let mut cost = |_| rng.random_range(0.0..3.0);
        let costs: Vec<Vec<f64>> =
            (0..pairs.modules()).map(|_| (0..options).map(&mut cost).collect()).collect();
        let mut verdict = |_| (0..options).map(|_| !rng.random_bool(share)).collect();
        let allowed = pairs.all().iter().map(|_| (0..options).map(&mut verdict).collect()).collect();
        Self { pairs, costs, allowed }
    }

    fn random(rng: &mut ChaCha8Rng, modules: usize, options: usize) -> Self {
        let edges = rng.random_range(0.1..1.0);
        let every = (0..modules).flat_map(|i| (i + 1..modules).map(move |j| (i, j)));
        // Both ways round: j may come before i.
        let list: Vec<Pair> = every
            .filter(|_| rng.random_bool(edges))
            .enumerate()
            .map(|(k, (a, b))| if k % 3 == 0 { (b, a) } else { (a, b) })
            .map(|(i, j)| Pair { i, j, offset: 0 })
            .collect();
        let share = rng.random_range(0.0..0.7);
        Self::new(Pairs::new(modules, list), options, share, rng)
    }

    fn square(side: usize, rng: &mut ChaCha8Rng, share: f64) -> Self {
        let mut list = Vec::new();
        for i in 0..side * side {
            if i % side + 1 < side {
                list.push(Pair { i, j: i + 1, offset: 0 });
            }
            if i + side < side * side {
                list.push(Pair { i, j: i + side, offset: 1 });
            }
        }
        Self::new(Pairs::new(side * side, list), 2, share, rng)
    }

    fn solve(&self, chooser: &mut Chooser) -> Answer {
        chooser.clear();
        for costs in &self.costs {
            chooser.module(costs.iter().copied());
        }
        chooser.choose(&self.pairs, |index, a, b| self.allowed[index][a][b])
    }

    fn is_allowed(&self, chosen: &[usize]) -> bool {
        let mut pairs = self.pairs.all().iter().zip(&self.allowed);
        pairs.all(|(pair, allowed)| allowed[chosen[pair.i]][chosen[pair.j]])
    }

    fn cost(&self, chosen: &[usize]) -> f64 {
        chosen.iter().zip(&self.costs).map(|(&option, costs)| costs[option]).sum()
    }

    /// The least cost by trying everything.
    fn brute_force(&self) -> Option<f64> {
        let options = self.costs[0].len();
        let mut least: Option<f64> = None;
        for number in 0..options.pow(self.costs.len() as u32) {
            let digit = |module: usize| number / options.pow(module as u32) % options;
            let chosen: Vec<usize> = (0..self.costs.len()).map(digit).collect();
            if self.is_allowed(&chosen) {
                let cost = self.cost(&chosen);
                least = Some(least.map_or(cost, |least| least.min(cost)));
            }
        }
        least
    }

    /// Checks a choice and gives its cost and bound.
    fn checked(&self, chooser: &Chooser, answer: Answer, seed: u64) -> Option<(f64, f64)> {
        let Answer::Best { cost, bound } = answer else { return None };
        let chosen: Vec<usize> = chooser.chosen().iter().map(|&option| option.into()).collect();
        assert!(self.is_allowed(&chosen), "seed {seed}");
        assert!((self.cost(&chosen) - cost).abs() < 1e-9 && bound <= cost, "seed {seed}");
        Some((cost, bound))
    }
}

#[test]
fn as_good_as_trying_everything() {
    let (mut found, mut none) = (0, 0);
    // One solver for all: what is left of a problem must not leak into the next.
    let mut chooser = Chooser::default();
    for seed in 0..4000 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (most, options) = [(10, 2), (6, 3), (5, 4), (3, 16)][seed as usize % 4];
        let modules = rng.random_range(1..=most);
        let case = Case::random(&mut rng, modules, options);
        let answer = case.solve(&mut chooser);
        match case.brute_force() {
            None => {
                assert_eq!(answer, Answer::Impossible, "seed {seed}");
                none += 1;
            }
            Some(least) => {
                let (cost, bound) = case.checked(&chooser, answer, seed).expect("there is one");
                assert!((cost - least).abs() < 1e-9, "seed {seed}: {cost} {least}");
                assert!((bound - cost).abs() < 1e-12, "seed {seed}: not proved");
                found += 1;
            }
        }
    }
    assert!(found > 500 && none > 300, "{found} with and {none} without a choice: both must be tried");
}

/// Hardly any table and hardly any search: the least cost lies between bound and cost, and a solution is found where there
/// is one.
#[test]
fn the_gap_is_honest() {
    let limits = [(0, 0), (8, 0), (64, 2)].map(|(entries, nodes)| Limits { entries, nodes });
    let mut choosers = limits.map(Chooser::new);
    let (mut open, mut worse) = (0, 0);
    for seed in 0..3000 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let options = if seed % 3 == 0 { 3 } else { 2 };
        let modules = rng.random_range(6..=if options == 3 { 7 } else { 11 });
        let case = Case::random(&mut rng, modules, options);
        let chooser = &mut choosers[seed as usize % 3];
        let answer = case.solve(chooser);
        if options == 3 && answer == Answer::Unknown {
            continue;
        }
        let Some(least) = case.brute_force() else {
            assert_eq!(answer, Answer::Impossible, "seed {seed}");
            continue;
        };
        let (cost, bound) = case.checked(chooser, answer, seed).expect("there is one");
        assert!(bound <= least + 1e-9 && least <= cost + 1e-9, "seed {seed}: {bound} {least} {cost}");
        open += usize::from(cost > bound + 1e-9);
        worse += usize::from(cost > least + 1e-9);
    }
    assert!(open > 40 && worse > 10, "{open} not proved, {worse} not least: the limits must bite");
}

#[test]
fn two_sat_agrees_with_trying_everything() {
    let (mut two_sat, mut verdicts) = (TwoSat::default(), [0; 2]);
    for seed in 0..3000 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let modules = rng.random_range(1..=9);
        let case = Case::random(&mut rng, modules, 2);
        let mut graph = Graph::default();
        for costs in &case.costs {
            graph.node(0b11, costs);
        }
        for (pair, allowed) in case.pairs.all().iter().zip(&case.allowed) {
            let row = |verdicts: &Vec<bool>| u16::from(verdicts[0]) | u16::from(verdicts[1]) << 1;
            graph.edge(pair.i, pair.j, &allowed.iter().map(row).collect::<Vec<_>>());
        }
        graph.index();
        let satisfiable = two_sat.satisfiable(&graph);
        assert_eq!(satisfiable, Some(case.brute_force().is_some()), "seed {seed}");
        verdicts[usize::from(satisfiable == Some(true))] += 1;
    }
    assert!(verdicts.iter().all(|&count| count > 300), "{verdicts:?}");
}

/// Where every pair forbids the cheapest two options to go together: the largest square that is proved least.
#[test]
fn squares_that_are_exact() {
    let mut chooser = Chooser::default();
    for side in [2, 4, 8, 10, 11, 12, 13, 14, 16, 20, 24, 32] {
        let (mut exact, mut gap, mut share) = (0, 0.0_f64, 0.0_f64);
        for seed in 0..8 {
            let mut case = Case::square(side, &mut ChaCha8Rng::seed_from_u64(seed), 0.0);
            for costs in &mut case.costs {
                costs.sort_by(f64::total_cmp);
            }
            for verdicts in &mut case.allowed {
                verdicts[0][0] = false;
            }
            let answer = case.solve(&mut chooser);
            let (cost, bound) =
                case.checked(&chooser, answer, seed).expect("every node may take its other option");
            exact += usize::from(cost - bound < 1e-9);
            gap = gap.max(cost - bound);
            share = share.max((cost - bound) / cost);
        }
        eprintln!("{side} × {side}: exact {exact} of 8, gap up to {gap:.3} ({:.2} %)", 100.0 * share);
        assert!(exact == 8 || side > 11, "{side} × {side}");
        assert!(share < 0.2, "{side} × {side}: {share}");
    }
}

#[test]
fn a_thousand_modules_end() {
    let mut chooser = Chooser::default();
    for seed in 0..40 {
        let case = Case::square(32, &mut ChaCha8Rng::seed_from_u64(seed), 0.01 * seed as f64);
        let answer = case.solve(&mut chooser);
        let checked = case.checked(&chooser, answer, seed);
        eprintln!("{seed:2} % forbidden: {checked:?}");
        assert!(seed > 0 || checked.is_some());
        assert_ne!(answer, Answer::Unknown, "seed {seed}");
    }
}
