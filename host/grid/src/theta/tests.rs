use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;

/// A graph by its tables: edges, and what legs cost. The bound is a share of the true cost along edges or legs.
struct Table {
    vertices: usize,
    edge: Vec<bool>,
    leg: Vec<Option<f64>>,
    bound: Vec<f64>,
}

impl Table {
    /// Random, with costs that differ by direction and keep no triangle inequality. Some legs are blocked; every edge
    /// has a leg. Bounds are admissible and, being random shares of the truth, not consistent.
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let n = rng.random_range(2..25);
        let leg: Vec<_> =
            (0..n * n).map(|_| rng.random_bool(0.7).then(|| rng.random_range(0.1..10.0))).collect();
        let edge = leg.iter().map(|leg| leg.is_some() && rng.random_bool(0.25)).collect();
        let mut bound = shortest(n, |k| leg[k]);
        for b in &mut bound {
            *b = if b.is_finite() { *b * rng.random_range(0.0..1.0) } else { rng.random_range(0.0..50.0) };
        }
        Self { vertices: n, edge, leg, bound }
    }
}

impl Space for Table {
    fn vertices(&self) -> usize {
        self.vertices
    }
    fn for_neighbours(&self, vertex: usize, mut visit: impl FnMut(usize, f64)) {
        for next in 0..self.vertices {
            let k = vertex * self.vertices + next;
            if let Some(cost) = self.leg[k].filter(|_| self.edge[k]) {
                visit(next, cost);
            }
        }
    }
    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64> {
        self.leg[from * self.vertices + to].filter(|&cost| cost < limit)
    }
    fn bound(&self, vertex: usize, goal: usize) -> f64 {
        if vertex == goal { 0.0 } else { self.bound[vertex * self.vertices + goal] }
    }
}

/// Floyd and Warshall: least costs between all pairs.
fn shortest(n: usize, cost: impl Fn(usize) -> Option<f64>) -> Vec<f64> {
    let mut least: Vec<f64> = (0..n * n).map(|k| cost(k).unwrap_or(f64::INFINITY)).collect();
    for k in 0..n {
        least[k * n + k] = 0.0;
    }
    for via in 0..n {
        for from in 0..n {
            for to in 0..n {
                least[from * n + to] = least[from * n + to].min(least[from * n + via] + least[via * n + to]);
            }
        }
    }
    least
}

#[test]
fn a_star_is_exact_and_theta_star_adds_up_whatever_the_costs() {
    // One scratch for all: what an earlier search left must not show.
    let mut search = Search::new();
    let mut unreachable = 0;
    for seed in 0..400 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let table = Table::random(&mut rng);
        let n = table.vertices;
        let along_edges = shortest(n, |k| table.leg[k].filter(|_| table.edge[k]));
        let along_legs = shortest(n, |k| table.leg[k]);
        for _ in 0..20 {
            let (start, goal) = (rng.random_range(0..n), rng.random_range(0..n));
            let least = along_edges[start * n + goal];
            let exact = search.a_star(&table, start, goal);
            let theta = search.theta_star(&table, start, goal);
            assert_eq!(theta, Search::new().theta_star(&table, start, goal), "seed {seed}: scratch shows");
            let (Some(exact), Some(theta)) = (&exact, &theta) else {
                assert!(exact.is_none() && theta.is_none() && least.is_infinite(), "seed {seed}");
                unreachable += 1;
                continue;
            };
            assert!((exact.cost - least).abs() <= 1e-9 * least, "seed {seed}: {} for {least}", exact.cost);
            for found in [exact, theta] {
                let sum = cost(&table, &found.path).expect("free legs");
                assert!((found.cost - sum).abs() <= 1e-12 * sum, "seed {seed}: {} for {sum}", found.cost);
                assert_eq!((found.path[0], *found.path.last().expect("a goal")), (start, goal));
            }
            let optimum = along_legs[start * n + goal];
            assert!(theta.cost >= optimum * (1.0 - 1e-9), "seed {seed}: {} below {optimum}", theta.cost);
            let smoothed = smooth(&table, &exact.path);
            let sum = cost(&table, &smoothed).expect("free legs");
            assert!(sum <= exact.cost * (1.0 + 1e-9), "seed {seed}: smoothing made it dearer");
            assert_eq!((smoothed[0], *smoothed.last().expect("a goal")), (start, goal));
        }
    }
    assert!((100..4000).contains(&unreachable), "{unreachable} of 8000 unreachable: no test of both");
}

/// Vertices 0 … n on a line, legs between all of them at `cost(distance)`.
struct Line(usize, fn(f64) -> f64);

impl Space for Line {
    fn vertices(&self) -> usize {
        self.0
    }
    fn for_neighbours(&self, vertex: usize, mut visit: impl FnMut(usize, f64)) {
        for next in [vertex.wrapping_sub(1), vertex + 1] {
            if next < self.0 {
                visit(next, self.1(1.0));
            }
        }
    }
    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64> {
        Some(self.1(from.abs_diff(to) as f64)).filter(|&cost| cost < limit)
    }
    fn bound(&self, _: usize, _: usize) -> f64 {
        0.0
    }
}

#[test]
fn a_straight_line_is_one_leg_unless_short_legs_are_cheaper() {
    let mut search = Search::new();
    // A tenth is not a binary fraction: adding up and multiplying differ by rounding, which must not cost vertices.
    let line = Line(100, |distance| 0.1 * distance);
    assert_eq!(search.theta_star(&line, 3, 97).expect("a path").path, [3, 97]);
    assert_eq!(search.a_star(&line, 3, 97).expect("a path").path.len(), 95);
    assert_eq!(smooth(&line, &(3..98).collect::<Vec<_>>()), [3, 97]);
    // Drag over a long leg at a speed that grows with it: the triangle inequality fails, short legs are right.
    let steep = Line(100, |distance| distance * distance);
    let found = search.theta_star(&steep, 3, 9).expect("a path");
    assert_eq!((found.cost, found.path.len()), (6.0, 7));
    assert_eq!(smooth(&steep, &[3, 4, 5]), [3, 4, 5]);
}

#[test]
fn ends_of_the_search() {
    let line = Line(5, |distance| distance);
    let mut search = Search::new();
    assert_eq!(search.theta_star(&line, 2, 2), Some(FoundPath { cost: 0.0, path: vec![2], expanded: 0 }));
    assert_eq!(search.theta_star(&line, 2, 5), None);
    assert_eq!(search.a_star(&line, 5, 2), None);
    assert!(smooth(&line, &[]).is_empty());
    assert_eq!(smooth(&line, &[4]), [4]);
    // A cost that is no number blocks.
    assert_eq!(search.theta_star(&Line(5, |_| f64::NAN), 0, 4), None);
    assert_eq!(search.theta_star(&Line(5, |_| f64::INFINITY), 0, 4), None);
    // The last generation before the stamps run over, and the first after it.
    for generation in [u32::MAX - 5, u32::MAX - 4, u32::MAX - 3, u32::MAX - 2] {
        search.generation = generation & !1;
        for _ in 0..3 {
            assert_eq!(search.theta_star(&line, 0, 4).expect("a path").path, [0, 4]);
        }
    }
}

#[test]
fn of_equal_promise_the_farther_and_then_the_lower_vertex_goes_first() {
    let (near, far) = (key(1.0, 2.0, 7), key(2.0, 1.0, 9));
    assert!(far > near, "a maximum heap: greater goes first");
    assert!(key(1.0, 2.0, 3) > key(1.0, 2.0, 4));
    assert!(key(0.5, 0.5, 4) > key(1.0, 2.0, 3));
    assert_eq!(key(-0.0, -0.0, 1), key(0.0, 0.0, 1));
}
