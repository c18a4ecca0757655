//! How often random cycles of square structures can be reached from each other.
//!
//! The paper (II-E): "a valid transition set exists for all boats in over 99% of cases for square configurations of
//! Modboats with 2–5 boats to a side", for random inputs and prior locations. Counted here in two ways: for single cycles
//! drawn at random, as the paper does, and for the planner's decisions, which have several cycles to choose from.

use std::sync::Arc;

use modboat::distance::DistanceToCollision;
use modboat::motion::{Swing, Wrench};
use modboat::pairs::{Pair, Pairs};
use modboat::parameters::Parameters;
use modboat::plan::Outcome;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::potential_field::PotentialField;
use modboat::structure::Structure;
use modboat::transition::solver::Solver;
use modboat::transition::{self, Transition};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::checker::Modboat;
use tests::random;

/// Modules a side, decisions of the planner, single cycles drawn.
const SIZES: [(usize, u64, u64); 4] = [(2, 1000, 400), (3, 600, 300), (4, 400, 200), (5, 300, 200)];
/// Cycles that each drawn cycle is tried to be reached from.
const FROM_EACH: usize = 10;

fn demand(structure: &Structure, seed: u64) -> Wrench {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let share = rng.random_range(0.0..1.0);
    Wrench::from_array(random::border(&Modboat::default(), structure.cells(), &mut rng).map(|f| share * f))
}

/// Decisions with an outcome planned, each from the end of the one before and without resemblance to it.
fn planned(structure: &Structure, distance: &Arc<DistanceToCollision>, decisions: u64) -> u64 {
    let (parameters, config) = (Parameters::default(), PlannerConfig::default());
    let mut planner = Planner::with_distance(structure, &parameters, &config, Arc::clone(distance));
    let mut tails: Option<Vec<f64>> = None;
    let mut planned = 0;
    for seed in 0..=decisions {
        let plan = planner.plan(demand(structure, seed), tails.as_deref(), None);
        // The first has nothing before it and does not count.
        planned += u64::from(plan.outcome == Outcome::Planned && tails.is_some());
        tails = Some(plan.cycle.iter().map(|swing| swing.start_rad()).collect());
    }
    planned
}

/// Random collision-free cycles, the best that Algorithm 1 finds for a random demand each.
fn cycles(
    structure: &Structure,
    distance: &DistanceToCollision,
    pairs: &Pairs,
    count: u64,
) -> Vec<Vec<Swing>> {
    let (parameters, config) = (Parameters::default(), PlannerConfig::default());
    let positions_m = structure.positions_m(parameters.pitch_m);
    let mut field = PotentialField::new(structure.cells(), &positions_m, pairs, &parameters, &config);
    let swim =
        |offset: usize, i: Swing, j: Swing, margin_rad: f64| distance.swim(offset, i, j).min(margin_rad);
    (0..count)
        .map(|seed| {
            // Any of the candidates, so that the patterns of signs are mixed.
            let candidates = field.solve(demand(structure, 1_000_000 + seed), None, &swim);
            assert!(!candidates.is_empty(), "seed {seed}: no collision-free cycle");
            candidates[seed as usize % candidates.len()].cycle.clone()
        })
        .collect()
}

/// Of how many pairs of cycles the second can be reached from the first, and how many were tried.
fn reached(structure: &Structure, distance: &DistanceToCollision, count: u64) -> (u64, u64) {
    let (parameters, config) = (Parameters::default(), PlannerConfig::default());
    let offsets = distance.offsets().iter().enumerate();
    let list = offsets
        .flat_map(|(offset, &cells)| structure.neighbours(cells).map(move |(i, j)| Pair { i, j, offset }));
    let pairs = Pairs::new(structure.len(), list);
    let cycles = cycles(structure, distance, &pairs, count);
    let limit_rad = parameters.tail_speed_max_rad_s * parameters.transition_s;
    let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| {
        distance.clear(offset, from, to, config.transition_margin_rad)
    };
    let (mut found, mut tried) = (0, 0);
    for (index, cycle) in cycles.iter().enumerate() {
        for back in 1..=FROM_EACH {
            let before = &cycles[(index + cycles.len() - back) % cycles.len()];
            let from: Vec<f64> = before.iter().map(|swing| swing.start_rad()).collect();
            tried += 1;
            let (solver, best) = (&mut Solver::default(), &mut Transition::default());
            found += u64::from(transition::solve(solver, &pairs, &from, cycle, limit_rad, clear, best));
        }
    }
    (found, tried)
}

#[test]
fn table_square_structures_have_a_transition_in_99_of_100_cases() {
    let distance = Arc::new(DistanceToCollision::new(&Parameters::default()));
    let figures: Vec<_> = std::thread::scope(|scope| {
        let all = SIZES.map(|(side, decisions, count)| {
            let distance = Arc::clone(&distance);
            scope.spawn(move || {
                let structure = Structure::from_word(&format!("{side}x{side}")).expect("a square");
                let planned = planned(&structure, &distance, decisions);
                (side, planned, decisions, reached(&structure, &distance, count))
            })
        });
        all.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    println!(
        "share of random cases with a transition, margin {} rad",
        PlannerConfig::default().transition_margin_rad
    );
    println!("  size | single cycles            | decisions of the planner");
    let percent = |found: u64, tried: u64| 100.0 * found as f64 / tried as f64;
    for &(side, planned, decisions, (found, tried)) in &figures {
        println!(
            "  {side} x {side} | {found:>5} of {tried:>5} = {:>6.2} % | {planned:>5} of {decisions:>5} = {:>6.2} %",
            percent(found, tried),
            percent(planned, decisions)
        );
    }
    for (side, planned, decisions, (found, tried)) in figures {
        // The paper's 99 %; of small squares all were reached.
        let least = if side <= 3 { 99.9 } else { 99.0 };
        assert!(percent(found, tried) >= least, "{side} x {side}: {found} of {tried} single cycles");
        assert_eq!(planned, decisions, "{side} x {side}: decisions with an outcome planned");
    }
}
