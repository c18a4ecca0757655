use std::f64::consts::{PI, TAU};

use quantity::wrap_rad;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::pairs::Pair;

/// A `columns` × `rows` grid with its four-sided neighbours.
fn grid(columns: usize, rows: usize) -> (Vec<[i32; 2]>, Pairs) {
    let cells: Vec<[i32; 2]> =
        (0..rows * columns).map(|k| [(k % columns) as i32, (k / columns) as i32]).collect();
    let mut list = Vec::new();
    for i in 0..cells.len() {
        if i % columns + 1 < columns {
            list.push(Pair { i, j: i + 1, offset: 0 });
        }
        if i + columns < cells.len() {
            list.push(Pair { i, j: i + columns, offset: 1 });
        }
    }
    (cells.clone(), Pairs::new(cells.len(), list))
}

/// A collision test without geometry: a pseudo-random verdict for each motion, `share` of them forbidden.
fn arbitrary(share: f64) -> impl Fn(usize, [f64; 2], [f64; 2]) -> bool {
    move |offset, from, to| {
        let mut hash = offset as u64 ^ 0x9e37_79b9_7f4a_7c15;
        for value in [from[0], from[1], to[0], to[1]] {
            hash = (hash ^ value.to_bits()).wrapping_mul(0xff51_afd7_ed55_8ccd);
            hash ^= hash >> 32;
        }
        (hash >> 11) as f64 / (1_u64 << 53) as f64 >= share
    }
}

/// Least travel over all 2^N ways of both signs, by enumeration.
fn brute_force(
    pairs: &Pairs,
    from: &[f64],
    cycle: &[Swing],
    limit: f64,
    clear: impl Fn(usize, [f64; 2], [f64; 2]) -> bool,
) -> Option<f64> {
    let mut best: Option<f64> = None;
    for sign in [1.0, -1.0] {
        'ways: for ways in 0_u32..1 << from.len() {
            let mut rotations = Vec::new();
            for (module, swing) in cycle.iter().enumerate() {
                let to = swing.centerline_rad + sign * swing.amplitude_rad;
                // The two rotations that lead to `to`, counter-clockwise and clockwise, without using wrap_rad().
                let ccw = (to - from[module]).rem_euclid(TAU);
                let rotation = if ways >> module & 1 == 0 { ccw } else { ccw - TAU };
                if rotation.abs() > limit {
                    continue 'ways;
                }
                rotations.push(rotation);
            }
            let free = pairs.all().iter().all(|p| {
                let start = [from[p.i], from[p.j]];
                // The same floating-point end as the solver computes, for the sake of the pseudo-random verdict.
                let end = [p.i, p.j].map(|m| {
                    let to = cycle[m].centerline_rad + sign * cycle[m].amplitude_rad;
                    let short = wrap_rad(to - from[m]);
                    let long = if short > 0.0 { short - TAU } else { short + TAU };
                    from[m] + if (short - rotations[m]).abs() < 1e-6 { short } else { long }
                });
                clear(p.offset, start, end)
            });
            if free {
                let travel = rotations.iter().map(|r| r.abs()).sum::<f64>();
                best = Some(best.map_or(travel, |b: f64| b.min(travel)));
            }
        }
    }
    best
}

fn least(
    pairs: &Pairs,
    from_rad: &[f64],
    cycle: &[Swing],
    limit_rad: f64,
    clear: impl Fn(usize, [f64; 2], [f64; 2]) -> bool,
) -> Option<Transition> {
    let mut best = Transition::default();
    solve(&mut Solver::default(), pairs, from_rad, cycle, limit_rad, clear, &mut best).then_some(best)
}

#[test]
fn as_good_as_trying_everything() {
    let (mut found, mut none) = (0, 0);
    for seed in 0..600 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (columns, rows) = [(3, 1), (2, 2), (4, 2), (1, 5), (3, 2), (7, 1)][seed as usize % 6];
        let (cells, pairs) = grid(columns, rows);
        let from: Vec<f64> = cells.iter().map(|_| rng.random_range(-9.0..9.0)).collect();
        let cycle: Vec<Swing> = cells
            .iter()
            .map(|_| Swing {
                centerline_rad: rng.random_range(-PI..PI),
                amplitude_rad: rng.random_range(0.9..2.6),
            })
            .collect();
        let limit = if seed % 3 == 0 { 5.0 } else { 6.5 };
        let clear = arbitrary(rng.random_range(0.0..0.8));
        let expected = brute_force(&pairs, &from, &cycle, limit, &clear);
        let answer = least(&pairs, &from, &cycle, limit, &clear);
        assert_eq!(answer.is_some(), expected.is_some(), "seed {seed}");
        let (Some(answer), Some(expected)) = (answer, expected) else {
            none += 1;
            continue;
        };
        found += 1;
        assert!(answer.exact, "seed {seed}");
        assert!((answer.travel_rad - expected).abs() < 1e-9, "seed {seed}: {} {expected}", answer.travel_rad);
        // The answer does what it says.
        let sign = if answer.negated { -1.0 } else { 1.0 };
        for ((turn, from), swing) in answer.turns.iter().zip(&from).zip(&cycle) {
            assert!((turn.from_rad - from).abs() < 1e-15 && turn.rotation_rad().abs() <= limit);
            let away = wrap_rad(turn.to_rad - swing.centerline_rad - sign * swing.amplitude_rad);
            assert!(away.abs() < 1e-9, "seed {seed}");
        }
        for pair in pairs.all() {
            let (a, b) = (answer.turns[pair.i], answer.turns[pair.j]);
            assert!(clear(pair.offset, [a.from_rad, b.from_rad], [a.to_rad, b.to_rad]), "seed {seed}");
        }
    }
    assert!(found > 100 && none > 100, "{found} with and {none} without a transition: both must be tried");
}

#[test]
fn a_tail_already_there_stays() {
    let (_, pairs) = grid(2, 1);
    let cycle = [Swing { centerline_rad: 0.5, amplitude_rad: 1.0 }; 2];
    // Unwrapped by two turns: still there.
    let from = [1.5, 1.5 + 2.0 * TAU];
    let answer = least(&pairs, &from, &cycle, 6.5, |_, _, _| true).expect("nothing forbids it");
    assert!(answer.turns.iter().all(|turn| turn.rotation_rad().abs() < STILL_RAD) && !answer.negated);
    assert!((answer.turns[1].to_rad - from[1]).abs() < 1e-12);
}

#[test]
fn speed_limits_the_long_way() {
    let (_, pairs) = grid(1, 1);
    let cycle = [Swing { centerline_rad: 1.0, amplitude_rad: 2.0 }];
    // To 3.0 or to −1.0 from 0: one radian clockwise is the least; with a limit below it nothing is left.
    let answer = least(&pairs, &[0.0], &cycle, 1.5, |_, _, _| true).expect("within the limit");
    assert!(answer.negated && (answer.travel_rad - 1.0).abs() < 1e-12);
    assert!(least(&pairs, &[0.0], &cycle, 0.9, |_, _, _| true).is_none());
}

#[test]
fn a_hundred_modules_do_not_blow_up() {
    // Ten by ten, from sparse to impossible: ends at all, and every answer is valid.
    let (cells, pairs) = grid(10, 10);
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let from: Vec<f64> = cells.iter().map(|_| rng.random_range(-PI..PI)).collect();
        let cycle: Vec<Swing> = cells
            .iter()
            .map(|_| Swing { centerline_rad: rng.random_range(-PI..PI), amplitude_rad: 1.5 })
            .collect();
        let clear = arbitrary(f64::from(seed as u32) * 0.01);
        if let Some(answer) = least(&pairs, &from, &cycle, 6.5, &clear) {
            for pair in pairs.all() {
                let (a, b) = (answer.turns[pair.i], answer.turns[pair.j]);
                assert!(clear(pair.offset, [a.from_rad, b.from_rad], [a.to_rad, b.to_rad]), "seed {seed}");
            }
        } else {
            assert!(seed > 0, "nothing is forbidden, yet no transition was found");
        }
    }
}
