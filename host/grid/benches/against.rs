//! Criterion bench against others: shortest paths at any angle by this crate and by Theta* of condor-pathfinding-grid, on the
//! same queries in one run. Prints how long each takes for a query and how much longer its paths are than the shortest.
//!
//! `FLOTILLA_MAPS=folder` takes every `x.map` with its `x.map.scen` of that folder too.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use condor_grid::{AnyAnglePathfinder, AnyAngleSearchRequest, Cell, Grid, Point, Point2, ThetaStar};
use criterion::{Criterion, criterion_group, criterion_main};
use grid::Map;
use grid::any_angle::{AnyAngle, Shortest};
use grid::plane::Plane;
use grid::read;
use grid::theta::Search;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Queries on each map.
const QUERIES: usize = 60;

type Ends = [[u32; 2]; 2];

/// A map, and queries between vertices with a free cell beside them.
fn random(name: &str, side: u32, share: f64) -> (String, Plane, Vec<Ends>) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let blocked: Vec<bool> = (0..side * side).map(|_| rng.random_bool(share)).collect();
    let plane = Plane::new(side, side, |x, y| !blocked[(y * side + x) as usize]).expect("a map");
    let mut open = || loop {
        let place = [rng.random_range(0..=side), rng.random_range(0..=side)];
        if plane.vertex(place).is_some_and(|vertex| plane.is_open(vertex)) {
            return place;
        }
    };
    let ends = (0..QUERIES).map(|_| [open(), open()]).collect();
    (name.to_owned(), plane, ends)
}

/// A map from a file, and queries of its scenario.
fn public(file: &Path) -> (String, Plane, Vec<Ends>) {
    let text =
        |file: &Path| std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let plane = read::plane(&text(file)).expect("a map");
    let queries = read::plane_scenario(&text(&file.with_extension("map.scen")), &plane).expect("a scenario");
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let any = |_| &queries[rng.random_range(0..queries.len())];
    let ends = (0..QUERIES).map(any).map(|query| [query.start, query.goal]).collect();
    (file.file_name().unwrap_or_default().to_string_lossy().into_owned(), plane, ends)
}

fn condor(plane: &Plane) -> Grid {
    let mut grid = Grid::new(plane.width() as usize, plane.height() as usize).expect("a map");
    for y in 0..plane.height() {
        for x in (0..plane.width()).filter(|&x| !plane.is_free(x, y)) {
            grid.set_cell(Point::new(x as usize, y as usize), Cell::Blocked).expect("on the map");
        }
    }
    grid
}

fn by_condor(grid: &Grid, [start, goal]: Ends) -> Option<f64> {
    let [start, goal] = [start, goal].map(|[x, y]| Point2::new(x.into(), y.into()));
    let found = ThetaStar.search(grid, AnyAngleSearchRequest::new(start, goal)).ok()?;
    found.path().map(|path| path.cost())
}

fn compare(criterion: &mut Criterion, (name, plane, ends): (String, Plane, Vec<Ends>)) {
    let vertices: Vec<_> =
        ends.iter().map(|ends| ends.map(|at| plane.vertex(at).expect("on the map"))).collect();
    let (mut scratch, mut search) = (AnyAngle::new(), Search::new());
    let grid = condor(&plane);
    let mut shortest =
        |[start, goal]: [usize; 2]| plane.shortest(&mut scratch, start, goal).map(|found| found.cost);
    let mut theta =
        |[start, goal]: [usize; 2]| search.theta_star(&plane, start, goal).map(|found| found.cost);
    // Once each, in turns, for the lengths and the ratio.
    let (mut took, mut over, mut most) = ([0.0; 3], [0.0; 2], [0f64; 2]);
    let mut count = 0.0;
    black_box((shortest(vertices[0]), theta(vertices[0])));
    for (&ends, &vertices) in ends.iter().zip(&vertices) {
        let mut timed = |k: usize, find: &mut dyn FnMut() -> Option<f64>| {
            let began = Instant::now();
            let length = find();
            took[k] += began.elapsed().as_secs_f64();
            length
        };
        let ours = timed(0, &mut || shortest(vertices));
        let others = [timed(1, &mut || theta(vertices)), timed(2, &mut || by_condor(&grid, ends))];
        let Some(ours) = ours.filter(|&ours| ours > 0.0) else { continue };
        count += 1.0;
        for k in 0..2 {
            // Condor's paths may pass where two blocks touch: shorter than the shortest here.
            let ratio = others[k].unwrap_or(f64::NAN) / ours;
            over[k] += ratio;
            most[k] = most[k].max(ratio);
        }
    }
    let micros = took.map(|s| s * 1e6 / ends.len() as f64);
    println!("{name}: {} queries, {count} with a way", ends.len());
    println!("  shortest      {:9.1} µs, {:.4} of condor's time", micros[0], took[0] / took[2]);
    println!(
        "  Basic Theta*  {:9.1} µs, {:.6} of the shortest, {:.5} at most",
        micros[1],
        over[0] / count,
        most[0]
    );
    println!(
        "  condor Theta* {:9.1} µs, {:.6} of the shortest, {:.5} at most",
        micros[2],
        over[1] / count,
        most[1]
    );
    let mut group = criterion.benchmark_group(&name);
    group.sample_size(10);
    group.bench_function(format!("shortest, {QUERIES} queries"), |b| {
        b.iter(|| vertices.iter().filter_map(|&ends| shortest(ends)).count());
    });
    group.finish();
}

fn all(criterion: &mut Criterion) {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/maps");
    compare(criterion, public(&maps.join("arena.map")));
    compare(criterion, random("128 × 128, 20 % blocked", 128, 0.2));
    compare(criterion, random("128 × 128, 40 % blocked", 128, 0.4));
    if let Some(folder) = std::env::var_os("FLOTILLA_MAPS") {
        let entries = std::fs::read_dir(&folder).expect("the folder of FLOTILLA_MAPS");
        let files = entries.map(|entry| entry.expect("an entry").path());
        let mut files: Vec<_> =
            files.filter(|file| file.extension().is_some_and(|end| end == "map")).collect();
        files.sort();
        for file in files {
            compare(criterion, public(&file));
        }
    }
}

criterion_group!(benches, all);
criterion_main!(benches);
