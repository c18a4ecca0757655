//! Paths in 3D: each leg judged cell by cell, and their lengths against the 26-neighbour lengths that scenarios give.

use grid::Map;
use grid::any_angle::{AnyAngle, Shortest};
use grid::read;
use grid::theta::Search;
use grid::volume::Volume;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::figures::{Quantiles, mean};
use tests::public_maps::{self, Benchmark};

/// Whether a leg between the centres of two cells touches free cells only. Along its longest axis it is taken in slabs of one
/// cell; in each, the cells that its box touches are tried one by one.
fn is_clear(volume: &Volume, from: [u32; 3], to: [u32; 3]) -> bool {
    let [from, to] = [from, to].map(|at| at.map(i64::from));
    let d: [i64; 3] = std::array::from_fn(|k| to[k] - from[k]);
    let long = (0..3).max_by_key(|&k| d[k].abs()).expect("three axes");
    let count = d[long].abs();
    if count == 0 {
        return is_free(volume, from);
    }
    (0..=count).all(|slab| {
        // Doubled times from the middle of the slab before to that of the one after, within the leg.
        let [begin, end] = [(2 * slab - 1).max(0), (2 * slab + 1).min(2 * count)];
        // Cells of each axis whose closed intervals the leg is in between those times: it is at c + d·t / 2·count.
        let span: [[i64; 2]; 3] = std::array::from_fn(|k| {
            let ends = [begin, end].map(|t| 2 * from[k] * count + d[k] * t);
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            [-(count - low).div_euclid(2 * count), (high + count).div_euclid(2 * count)]
        });
        let axis = |k: usize| span[k][0]..=span[k][1];
        axis(0).all(|x| {
            axis(1).all(|y| axis(2).all(|z| is_free(volume, [x, y, z]) || !touches(from, d, [x, y, z])))
        })
    })
}

fn is_free(volume: &Volume, cell: [i64; 3]) -> bool {
    let [Ok(x), Ok(y), Ok(z)] = cell.map(u32::try_from) else { return false };
    volume.vertex([x, y, z]).is_some_and(|vertex| volume.is_open(vertex))
}

/// Whether the closed cell meets the closed leg: the times that it spends between each pair of planes have one in common.
fn touches(from: [i64; 3], d: [i64; 3], cell: [i64; 3]) -> bool {
    // Latest entry and earliest exit as fractions.
    let (mut entry, mut exit) = ((0, 1), (1, 1));
    for k in 0..3 {
        let planes = [2 * (cell[k] - from[k]) - 1, 2 * (cell[k] - from[k]) + 1];
        if d[k] == 0 {
            if planes[0] > 0 || planes[1] < 0 {
                return false;
            }
            continue;
        }
        let [first, last] = if d[k] > 0 { planes } else { [-planes[1], -planes[0]] };
        let per = 2 * d[k].abs();
        if first * entry.1 > entry.0 * per {
            entry = (first, per);
        }
        if last * exit.1 < exit.0 * per {
            exit = (last, per);
        }
    }
    entry.0 * exit.1 <= exit.0 * entry.1
}

/// The length of the path found, judged leg by leg.
fn judged(volume: &Volume, scratch: &mut AnyAngle, start: [u32; 3], goal: [u32; 3]) -> Option<f64> {
    let vertex = |at| volume.vertex(at).expect("on the map");
    let found = volume.shortest(scratch, vertex(start), vertex(goal))?;
    let path: Vec<_> = found.path.iter().map(|&vertex| volume.place(vertex)).collect();
    assert_eq!((path.first(), path.last()), (Some(&start), Some(&goal)));
    let length = |leg: &[[u32; 3]]| {
        let squared = leg[0].iter().zip(leg[1]).map(|(&a, b)| u64::from(a.abs_diff(b)).pow(2)).sum::<u64>();
        (squared as f64).sqrt()
    };
    for leg in path.windows(2) {
        assert!(
            is_clear(volume, leg[0], leg[1]),
            "{start:?} to {goal:?}: no leg from {:?} to {:?}",
            leg[0],
            leg[1]
        );
    }
    let length: f64 = path.windows(2).map(length).sum();
    assert!(
        (length - found.cost).abs() <= 1e-11 * length,
        "{start:?} to {goal:?}: {} for {length}",
        found.cost
    );
    Some(length)
}

#[test]
fn never_longer_than_along_the_26_moves_on_random_maps() {
    let (mut scratch, mut search) = (AnyAngle::new(), Search::new());
    let (mut ratios, mut of_theta) = (Vec::new(), Vec::new());
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let size: [u32; 3] = std::array::from_fn(|_| rng.random_range(8..28));
        let mut volume = Volume::new(size).expect("a map");
        // Single cells and boxes: up to a third of all cells.
        for _ in 0..rng.random_range(0..40) {
            let corner: [u32; 3] = std::array::from_fn(|k| rng.random_range(0..size[k]));
            let side: [u32; 3] = std::array::from_fn(|_| rng.random_range(1..9));
            for cell in 0..side.iter().product::<u32>() {
                let cell = [cell % side[0], cell / side[0] % side[1], cell / (side[0] * side[1])];
                volume.block(std::array::from_fn(|k| corner[k] + cell[k]));
            }
        }
        for _ in 0..size.iter().product::<u32>() / 30 {
            volume.block(std::array::from_fn(|k| rng.random_range(0..size[k])));
        }
        for _ in 0..12 {
            let [start, goal] = [(); 2].map(|()| std::array::from_fn(|k| rng.random_range(0..size[k])));
            let (from, to) = (volume.vertex(start).expect("on it"), volume.vertex(goal).expect("on it"));
            let along = search.a_star(&volume, from, to);
            let length = judged(&volume, &mut scratch, start, goal);
            assert_eq!(along.is_some(), length.is_some(), "seed {seed}: {start:?} to {goal:?}");
            if let (Some(along), Some(length)) = (along.filter(|along| along.cost > 0.0), length) {
                assert!(length <= along.cost * (1.0 + 1e-11), "seed {seed}: {start:?} to {goal:?}: {length}");
                ratios.push(length / along.cost);
                let theta = search.theta_star(&volume, from, to).expect("there is a way");
                of_theta.push(theta.cost / along.cost);
            }
        }
    }
    let (ours, theta) = (mean(ratios.iter().copied()), mean(of_theta));
    println!("{} queries: {ours:.5} of the length along 26 moves, Basic Theta* {theta:.5}", ratios.len());
    assert!(ratios.len() > 300 && ours < theta);
}

fn against_a_scenario(Benchmark { name, map, scenario }: &Benchmark, count: usize) -> f64 {
    let volume = read::volume(map).expect("a map");
    let queries = read::volume_scenario(scenario, volume.last()).expect("a scenario");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut scratch = AnyAngle::new();
    let ratios: Vec<f64> = (0..count)
        .map(|_| {
            let query = &queries[rng.random_range(0..queries.len())];
            let length = judged(&volume, &mut scratch, query.start, query.goal).expect("there is a way");
            // The scenario's lengths have eight decimals.
            assert!(
                length <= query.length + 1e-7,
                "{name}, line {}: {length} above {}",
                query.line,
                query.length
            );
            length / query.length
        })
        .collect();
    let average = mean(ratios.iter().copied());
    println!(
        "{name}: {count} queries, {average:.5} of the length along 26 moves on average, {:.5} at most",
        Quantiles::of(ratios).most
    );
    average
}

#[test]
fn never_longer_than_the_26_neighbour_lengths_of_public_scenarios() {
    let folder = public_maps::of_the_crate();
    let average = against_a_scenario(&public_maps::benchmark(&folder, "A1.3dmap"), 10);
    assert!(average <= 0.926, "{average}");
    for map in public_maps::of_the_environment(".3dmap") {
        against_a_scenario(&map, 300);
    }
}
