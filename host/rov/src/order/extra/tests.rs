//! Bounds before every order of small problems drawn at random.

use std::ops::ControlFlow::{self, Continue};

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::super::InTurn;
use super::*;

fn extra_of(pairs: &[Vec<Option<Pair>>]) -> Option<Extra> {
    match Extra::new(pairs, &InTurn, &mut || Continue(())) {
        Continue(extra) => extra,
        ControlFlow::Break(()) => panic!("it was not ended"),
    }
}

/// Costs up to 10, each pair with some detours up to 10; some pairs not allowed, some detours shut.
fn drawn(rng: &mut ChaCha8Rng, count: usize) -> Vec<Vec<Option<Pair>>> {
    let pair = |rng: &mut ChaCha8Rng, start: usize, slot: usize| {
        let places = (0..count).filter(|&k| k != start).map(|k| taken(1 << k, 0));
        let places: Vec<u32> =
            places.chain((0..count).filter(|&k| k != slot).map(|k| taken(0, 1 << k))).collect();
        let above = places.into_iter().filter(|_| rng.random_bool(0.4)).collect::<Vec<_>>();
        let above = above.into_iter().map(|place| {
            (place, if rng.random_bool(0.05) { f64::INFINITY } else { rng.random_range(0.0..10.0) })
        });
        let above = above.collect();
        rng.random_bool(0.9).then(|| Pair { least: rng.random_range(0.0..10.0), above })
    };
    (0..count).map(|start| (0..count).map(|slot| pair(rng, start, slot)).collect()).collect()
}

/// The least over every order and assignment, each hop at its dearest detour, by depth first.
fn least(pairs: &[Vec<Option<Pair>>], starts: u32, filled: u32) -> f64 {
    if starts == 0 {
        return 0.0;
    }
    let count = pairs.len();
    let mut least_of_all = f64::INFINITY;
    for start in (0..count).filter(|start| starts >> start & 1 == 1) {
        for slot in (0..count).filter(|slot| filled >> slot & 1 == 0) {
            let Some(pair) = &pairs[start][slot] else { continue };
            let others = taken(starts & !(1 << start), filled);
            let above = pair.above.iter().filter(|(place, _)| place & others != 0);
            let above = above.map(|(_, more)| *more).fold(0.0, f64::max);
            let rest = least(pairs, starts & !(1 << start), filled | 1 << slot);
            least_of_all = least_of_all.min(pair.least + above + rest);
        }
    }
    least_of_all
}

#[test]
fn where_all_places_are_watched_it_is_the_least_over_all_orders() {
    let mut finite = 0;
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let count = 1 + (seed % 4) as usize;
        let pairs = drawn(&mut rng, count);
        let all = (1 << count) - 1;
        let Some(extra) = extra_of(&pairs) else {
            assert!(least(&pairs, all, 0).is_infinite(), "seed {seed}");
            continue;
        };
        for starts in 0..=all {
            for filled in
                (0..=all).filter(|filled: &u32| filled.count_ones() + starts.count_ones() == count as u32)
            {
                let (truth, bound) = (least(&pairs, starts, filled), extra.of(starts, filled));
                if truth.is_infinite() {
                    assert!(bound.is_infinite(), "seed {seed}: {bound}");
                    continue;
                }
                finite += 1;
                assert!((truth - bound).abs() < 1e-3, "seed {seed}, {starts:b} {filled:b}: {truth} {bound}");
                assert!(bound <= truth + 1e-9, "seed {seed}: {truth} {bound}");
            }
        }
    }
    assert!(finite > 300, "{finite}");
}

#[test]
fn with_fewer_places_watched_it_is_below_all_orders_and_above_the_assignment() {
    let mut above = 0.0;
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let pairs = drawn(&mut rng, 4);
        let watching = |most: usize| match Extra::watching(most, &pairs, &InTurn, &mut || Continue(())) {
            Continue(extra) => extra,
            ControlFlow::Break(()) => panic!("it was not ended"),
        };
        let truth = least(&pairs, 0b1111, 0);
        let Some(none) = watching(0) else { continue };
        let mut last = none.of(0b1111, 0);
        for most in 1..=8 {
            let bound = watching(most).expect("an assignment").of(0b1111, 0);
            assert!(
                bound <= truth + 1e-9 && bound >= last - 1e-3,
                "seed {seed}, {most}: {last} {bound} {truth}"
            );
            last = bound;
        }
        if truth.is_finite() {
            above += last - none.of(0b1111, 0);
        }
    }
    assert!(above > 20.0, "{above}");
}

#[test]
fn it_ends_when_it_is_told_to() {
    let pairs = drawn(&mut ChaCha8Rng::seed_from_u64(3), 3);
    assert!(Extra::new(&pairs, &InTurn, &mut || ControlFlow::Break(())).is_break());
}
