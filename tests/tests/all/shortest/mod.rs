//! Shortest paths at any angle against exact optima by a visibility graph, on random maps and on maps of public benchmarks.

mod solid;
mod visibility;

use grid::Map;
use grid::any_angle::{AnyAngle, Shortest};
use grid::plane::Plane;
use grid::read;
use grid::theta::Search;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::figures::{Quantiles, mean};
use tests::public_maps::{self, Benchmark};
use visibility::{Cells, Visibility};

/// Lengths that differ by less than this share are equal: sums of a few hundred square roots.
const EQUAL: f64 = 1e-11;

/// Both infinite, or the same length.
fn are_equal(length: f64, optimum: f64) -> bool {
    length.is_infinite() && optimum.is_infinite() || (length - optimum).abs() <= EQUAL * optimum
}

fn cells(plane: &Plane) -> Cells {
    let is_free = |x: i64, y: i64| plane.is_free(x as u32, y as u32);
    Cells::new(plane.width().into(), plane.height().into(), is_free)
}

/// The length of the path found, judged leg by leg.
fn judged(plane: &Plane, cells: &Cells, scratch: &mut AnyAngle, [start, goal]: [[i64; 2]; 2]) -> Option<f64> {
    let vertex = |at: [i64; 2]| plane.vertex(at.map(|c| c as u32)).expect("on the map");
    let found = plane.shortest(scratch, vertex(start), vertex(goal))?;
    let path: Vec<_> = found.path.iter().map(|&vertex| plane.place(vertex).map(i64::from)).collect();
    assert_eq!((path.first(), path.last()), (Some(&start), Some(&goal)));
    let length = cells.length(&path).unwrap_or_else(|| panic!("{start:?} to {goal:?}: {path:?} is no path"));
    assert!(
        (length - found.cost).abs() <= EQUAL * length,
        "{start:?} to {goal:?}: {} for {length}",
        found.cost
    );
    Some(length)
}

fn place(rng: &mut ChaCha8Rng, plane: &Plane) -> [i64; 2] {
    let [width, height] = plane.last();
    [rng.random_range(0..=width).into(), rng.random_range(0..=height).into()]
}

/// The map turned by a quarter as often as that, or its mirror image turned.
fn turned(plane: &Plane, symmetry: usize) -> Plane {
    let [width, height] = plane.last().map(i64::from);
    let [wide, high] = if symmetry.is_multiple_of(2) { [width, height] } else { [height, width] };
    let is_free = |x: u32, y: u32| {
        // The centre of a cell, doubled, is an odd vertex of a map twice as fine.
        let [x, y] =
            turned_back([2 * i64::from(x) + 1, 2 * i64::from(y) + 1], [2 * wide, 2 * high], symmetry);
        plane.is_free((x / 2) as u32, (y / 2) as u32)
    };
    Plane::new(wide as u32, high as u32, is_free).expect("a map")
}

/// Where a vertex of a turned map of that size was before.
fn turned_back([x, y]: [i64; 2], [wide, high]: [i64; 2], symmetry: usize) -> [i64; 2] {
    let x = if symmetry >= 4 { wide - x } else { x };
    match symmetry % 4 {
        0 => [x, y],
        1 => [y, wide - x],
        2 => [wide - x, high - y],
        _ => [high - y, x],
    }
}

#[test]
fn exact_on_random_maps_from_either_end_however_turned() {
    let mut scratch = AnyAngle::new();
    let (mut queries, mut unreachable) = (0, 0);
    for seed in 0..160 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (width, height) = (rng.random_range(1..40), rng.random_range(1..40));
        let share = rng.random_range(0.02..0.5);
        let blocked: Vec<bool> = (0..width * height).map(|_| rng.random_bool(share)).collect();
        let plane = Plane::new(width, height, |x, y| !blocked[(y * width + x) as usize]).expect("a map");
        let cells_of = cells(&plane);
        let visibility = Visibility::new(&cells_of);
        let maps: Vec<_> = (0..8).map(|symmetry| turned(&plane, symmetry)).collect();
        for _ in 0..12 {
            let ends = [place(&mut rng, &plane), place(&mut rng, &plane)];
            let optimum = visibility.shortest(ends[0], ends[1]);
            queries += 1;
            unreachable += u32::from(optimum.is_infinite());
            for [start, goal] in [ends, [ends[1], ends[0]]] {
                let length = judged(&plane, &cells_of, &mut scratch, [start, goal]).unwrap_or(f64::INFINITY);
                let is_exact = are_equal(length, optimum);
                assert!(is_exact, "seed {seed}: {start:?} to {goal:?}: {length} for {optimum}");
            }
            for (symmetry, map) in maps.iter().enumerate() {
                let [wide, high] = map.last().map(i64::from);
                let to = |at: [i64; 2]| {
                    let all = (0..=high).flat_map(|y| (0..=wide).map(move |x| [x, y]));
                    all.into_iter().find(|&p| turned_back(p, [wide, high], symmetry) == at).expect("a vertex")
                };
                let length = judged(map, &cells(map), &mut scratch, ends.map(to)).unwrap_or(f64::INFINITY);
                let is_same = are_equal(length, optimum);
                assert!(is_same, "seed {seed}: {ends:?} turned by {symmetry}: {length} for {optimum}");
            }
        }
    }
    assert!(queries - unreachable > 800 && unreachable > 100, "{unreachable} of {queries} unreachable");
}

/// Queries of a map's scenario, and as many more between places of the map.
fn ends(plane: &Plane, scenario: &str, count: usize) -> Vec<[[i64; 2]; 2]> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let queries = if scenario.is_empty() {
        Vec::new()
    } else {
        read::plane_scenario(scenario, plane).expect("a scenario")
    };
    let of_scenario = |rng: &mut ChaCha8Rng| {
        let query = &queries[rng.random_range(0..queries.len())];
        [query.start, query.goal].map(|at| at.map(i64::from))
    };
    let mut ends: Vec<_> =
        (0..if queries.is_empty() { 0 } else { count }).map(|_| of_scenario(&mut rng)).collect();
    ends.extend((0..count).map(|_| [place(&mut rng, plane), place(&mut rng, plane)]));
    ends
}

/// Judges all queries on a map, and prints how much longer than the optimum the paths of Basic Theta* are.
fn exact_on(Benchmark { name, map, scenario }: &Benchmark, count: usize) {
    let plane = read::plane(map).expect("a map");
    let cells = cells(&plane);
    let visibility = Visibility::new(&cells);
    let (mut scratch, mut search) = (AnyAngle::new(), Search::new());
    let (mut ratios, mut of_theta, mut unreachable) = (Vec::new(), Vec::new(), 0);
    for [start, goal] in ends(&plane, scenario, count) {
        let optimum = visibility.shortest(start, goal);
        let Some(length) = judged(&plane, &cells, &mut scratch, [start, goal]) else {
            assert!(optimum.is_infinite(), "{name}: {start:?} to {goal:?} takes {optimum}");
            unreachable += 1;
            continue;
        };
        if start != goal {
            assert!(
                length >= optimum * (1.0 - EQUAL),
                "{name}: {start:?} to {goal:?}: {length} below {optimum}"
            );
            ratios.push(length / optimum);
            let vertex = |at: [i64; 2]| plane.vertex(at.map(|c| c as u32)).expect("on the map");
            let theta = search.theta_star(&plane, vertex(start), vertex(goal)).expect("there is a way");
            of_theta.push(theta.cost / optimum);
        }
    }
    let (q, t) = (Quantiles::of(ratios.iter().copied()), Quantiles::of(of_theta.iter().copied()));
    println!(
        "{name}: {} corners, {} queries, {unreachable} without a way: over the optimum {:.9} on average, {:.9} at most; \
         Basic Theta* {:.6}, {:.5}",
        visibility.corners.len(),
        ratios.len(),
        mean(ratios.iter().copied()),
        q.most,
        mean(of_theta),
        t.most
    );
    assert!(ratios.len() > count / 4, "{name}: {} of {count} have a way", ratios.len());
    assert!(q.most <= 1.0 + EQUAL, "{name}: {} of the optimum", q.most);
}

#[test]
fn exact_on_public_maps() {
    let folder = public_maps::of_the_crate();
    let mut maps = vec![
        public_maps::benchmark(&folder, "arena.map"),
        public_maps::benchmark(&folder, "maze512-32-9.map"),
    ];
    let voxels = std::fs::read_to_string(folder.join("A1.3dmap")).expect("a map");
    for z in [123, 130] {
        let (name, map) = (format!("A1.3dmap, layer {z}"), public_maps::layer(&voxels, z));
        maps.push(Benchmark { name, map, scenario: String::new() });
    }
    maps.extend(public_maps::of_the_environment(".map"));
    for map in &maps {
        exact_on(map, 100);
    }
}
