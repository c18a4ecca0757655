//! Two tails: the collision test, the distance to collision direct and from the table, the region itself.

use std::hint::black_box;

use criterion::Criterion;
use modboat::distance::DistanceToCollision;
use modboat::distance_table::DistanceTable;
use modboat::motion::Swing;
use modboat::parameters::Parameters;
use modboat::region::CollisionRegion;
use modboat::tail::Tail;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Random swim cycles of two modules (φ₀ᵢ, Aᵢ, φ₀ⱼ, Aⱼ), rad.
fn swims(parameters: &Parameters) -> Vec<[f64; 4]> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let amplitudes = parameters.amplitude_min_rad..parameters.amplitude_max_rad;
    let mut swim = || {
        let mut swing = || {
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            [rng.random_range(-3.1..3.1), sign * rng.random_range(amplitudes.clone())]
        };
        let ([a, b], [c, d]) = (swing(), swing());
        [a, b, c, d]
    };
    (0..1 << 16).map(|_| swim()).collect()
}

/// One look-up, one evaluation, one region.
pub fn geometry(criterion: &mut Criterion) {
    let parameters = Parameters::default();
    let (tail, doc) = (Tail::new(&parameters), DistanceToCollision::new(&parameters));
    let table = DistanceTable::generate(&parameters);
    let swims = swims(&parameters);
    let ends = |[a, b, c, d]: [f64; 4]| ([a + b, c + d], [a - b, c - d]);
    let swing = |centerline_rad, amplitude_rad| Swing { centerline_rad, amplitude_rad };
    let swings = |[a, b, c, d]: [f64; 4]| [swing(a, b), swing(c, d)];
    let mut next = 0;
    let mut swim = || {
        next = (next + 1) % swims.len();
        swims[next]
    };
    let mut group = criterion.benchmark_group("geometry");
    group.bench_function("collision test of a pose", |b| {
        b.iter(|| {
            let [x, _, y, _] = swim();
            black_box(tail.clearance_m([1, 0], x, y))
        });
    });
    group.bench_function("exact clearance along a swim", |b| {
        b.iter(|| {
            let (from, to) = ends(swim());
            black_box(tail.least_along_m([1, 0], from, to, f64::INFINITY))
        });
    });
    group.bench_function("exact collision along a swim", |b| {
        b.iter(|| {
            let (from, to) = ends(swim());
            black_box(tail.collides_along([1, 0], from, to))
        });
    });
    group.bench_function("DoC direct", |b| {
        b.iter(|| {
            let [i, j] = swings(swim());
            black_box(doc.swim(0, i, j))
        });
    });
    group.bench_function("DoC direct, exact below 0.2 rad, else a bound", |b| {
        b.iter(|| {
            let (from, to) = ends(swim());
            black_box(doc.along_bounded(0, [from, to], 0.2))
        });
    });
    group.bench_function("DoC direct, clear by 0.1 rad?", |b| {
        b.iter(|| {
            let (from, to) = ends(swim());
            black_box(doc.clear(0, from, to, 0.1))
        });
    });
    group.bench_function("DoC from the table, at random", |b| {
        b.iter(|| {
            let [i, j] = swings(swim());
            black_box(table.swim(0, i, j))
        });
    });
    group.bench_function("DoC from the table, near the last", |b| {
        // As a search asks: swims that creep, so that the table's lines are still in the cache.
        let (mut at, mut k) = (swim(), 0_u32);
        b.iter(|| {
            k += 1;
            if k % 64 == 0 {
                at = swim();
            }
            at[k as usize % 4] += if k % 8 < 4 { 0.01 } else { -0.01 };
            let [i, j] = swings(at);
            black_box(table.swim(0, i, j))
        });
    });
    group.bench_function("tracing a region", |b| {
        b.iter(|| black_box(CollisionRegion::new(&tail, [1, 0])));
    });
    group.bench_function("all regions, ready for distances", |b| {
        b.iter(|| black_box(DistanceToCollision::new(&parameters)));
    });
    group.finish();
}
