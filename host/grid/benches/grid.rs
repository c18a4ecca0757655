//! Criterion benches of the searches on grids: time of a query, expansions a second, memory a cell.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use grid::Map;
use grid::plane::Plane;
use grid::theta::{FoundPath, Search};
use grid::volume::Volume;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Queries on each map.
const QUERIES: usize = 10;

/// Either search on a map.
type Find<M> = fn(&mut Search, &M, usize, usize) -> Option<FoundPath>;

fn random_plane(side: u32, share: f64) -> Plane {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let blocked: Vec<bool> = (0..side * side).map(|_| rng.random_bool(share)).collect();
    Plane::new(side, side, |x, y| !blocked[(y * side + x) as usize]).expect("a map")
}

fn random_volume(side: u32, share: f64) -> Volume {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut volume = Volume::new([side; 3]).expect("a map");
    for _ in 0..(f64::from(side).powi(3) * share) as usize {
        volume.block(std::array::from_fn(|_| rng.random_range(0..side)));
    }
    volume
}

fn pairs<const N: usize>(map: &impl Map<N>) -> Vec<(usize, usize)> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut open = || {
        loop {
            let vertex = map.vertex(map.last().map(|last| rng.random_range(0..=last))).expect("on the map");
            if map.is_open(vertex) {
                return vertex;
            }
        }
    };
    (0..QUERIES).map(|_| (open(), open())).collect()
}

fn searches<const N: usize, M: Map<N>>(criterion: &mut Criterion, name: &str, map: &M, cells: f64) {
    let pairs = pairs(map);
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10);
    let algorithms: [(&str, Find<M>); 2] = [("Theta*", Search::theta_star), ("A*", Search::a_star)];
    for (algorithm, find) in algorithms {
        let mut search = Search::new();
        let (mut expanded, began) = (0, Instant::now());
        for &(start, goal) in &pairs {
            black_box(find(&mut search, map, start, goal));
            expanded += search.expanded();
        }
        let rate = expanded as f64 / began.elapsed().as_secs_f64();
        let bytes = search.bytes() as f64 / cells + 0.125;
        println!("{name}, {algorithm}: {rate:.3e} expansions a second, at most {bytes:.1} bytes a cell");
        group.bench_function(format!("{algorithm}, {QUERIES} queries"), |b| {
            b.iter(|| pairs.iter().filter_map(|&(start, goal)| find(&mut search, map, start, goal)).count());
        });
    }
    group.finish();
}

fn all(criterion: &mut Criterion) {
    searches(criterion, "500 × 500, 20 % blocked", &random_plane(500, 0.2), 500.0 * 500.0);
    searches(criterion, "500 × 500, 5 % blocked", &random_plane(500, 0.05), 500.0 * 500.0);
    searches(criterion, "64 × 64 × 64, 10 % blocked", &random_volume(64, 0.1), 64f64.powi(3));
}

criterion_group!(benches, all);
criterion_main!(benches);
