//! Theta* against optima that are found by other means: visibility graphs, octile lengths, and the smoothing that it was
//! invented to beat.

use grid::Map;
use grid::plane::Plane;
use grid::read;
use grid::theta::{Search, Space, cost, smooth};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tests::figures::{Quantiles, mean};

/// The octile path is at most 1/cos(π/8) ≈ 1.0824 times as long as the shortest one at any angle: Nash, *Any-Angle Path
/// Planning*, dissertation, University of Southern California, 2012, for eight moves between the same vertices.
const OCTILE_SHARE: f64 = 0.923_879_532_511_286_7;

fn random(rng: &mut ChaCha8Rng, side: u32, share: f64) -> Plane {
    let blocked: Vec<bool> = (0..side * side).map(|_| rng.random_bool(share)).collect();
    Plane::new(side, side, |x, y| !blocked[(y * side + x) as usize]).expect("a map")
}

fn free(plane: &Plane, x: i64, y: i64) -> bool {
    x >= 0 && y >= 0 && plane.is_free(x as u32, y as u32)
}

fn pinches(plane: &Plane, x: i64, y: i64) -> bool {
    let [a, b, c, d] = [(-1, -1), (0, -1), (-1, 0), (0, 0)].map(|(i, j)| free(plane, x + i, y + j));
    a == d && b == c && a != b
}

/// Sight by points: halfway between any two of the grid lines that can be met, and at every vertex on the way.
fn sees(plane: &Plane, (x, y): (i64, i64), (x_to, y_to): (i64, i64)) -> bool {
    let (dx, dy) = (x_to - x, y_to - y);
    let halves = 2 * dx.abs().max(1) * dy.abs().max(1);
    (1..halves).all(|k| {
        let (px, py) = (x * halves + dx * k, y * halves + dy * k);
        let (column, row) = (px.div_euclid(halves), py.div_euclid(halves));
        match (px % halves == 0, py % halves == 0) {
            (true, true) => !pinches(plane, column, row),
            (true, false) if dx == 0 => free(plane, column - 1, row) || free(plane, column, row),
            (false, true) if dy == 0 => free(plane, column, row - 1) || free(plane, column, row),
            (false, false) => free(plane, column, row),
            _ => true,
        }
    })
}

/// Shortest lengths at any angle from `start` to every vertex: Dijkstra on all legs between any two vertices.
fn optima(plane: &Plane, start: (i64, i64)) -> Vec<((i64, i64), f64)> {
    let [width, height] = plane.last().map(i64::from);
    let mut open: Vec<_> = (0..=height).flat_map(|y| (0..=width).map(move |x| (x, y))).collect();
    let mut length = vec![f64::INFINITY; open.len()];
    let mut done = Vec::new();
    length[open.iter().position(|&at| at == start).expect("on the map")] = 0.0;
    while !open.is_empty() {
        let k = (0..open.len()).min_by(|&a, &b| length[a].total_cmp(&length[b])).expect("not empty");
        let (at, so_far) = (open.swap_remove(k), length.swap_remove(k));
        done.push((at, so_far));
        if so_far.is_infinite() || (at != start && pinches(plane, at.0, at.1)) {
            continue;
        }
        for (to, known) in open.iter().zip(&mut length) {
            let along = so_far + ((to.0 - at.0) as f64).hypot((to.1 - at.1) as f64);
            if along < *known && sees(plane, at, *to) {
                *known = along;
            }
        }
    }
    done
}

#[test]
fn never_shorter_than_the_optimum_and_hardly_longer() {
    let mut search = Search::new();
    let (mut ratios, mut smoothed_ratios, mut unreachable) = (Vec::new(), Vec::new(), 0);
    for seed in 0..300 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let share = rng.random_range(0.05..0.45);
        let plane = random(&mut rng, 12, share);
        let start = [rng.random_range(0..=12), rng.random_range(0..=12)];
        let from = plane.vertex(start).expect("on the map");
        for (goal, optimum) in optima(&plane, (start[0].into(), start[1].into())) {
            let to = plane.vertex([goal.0 as u32, goal.1 as u32]).expect("on the map");
            if to == from {
                continue;
            }
            let Some(theta) = search.theta_star(&plane, from, to) else {
                assert!(optimum.is_infinite(), "seed {seed}: {start:?} to {goal:?} takes {optimum}");
                unreachable += 1;
                continue;
            };
            let along = search.a_star(&plane, from, to).expect("Theta* found a way");
            assert!(theta.cost >= optimum * (1.0 - 1e-12), "seed {seed}: {start:?} to {goal:?}");
            assert!(optimum >= OCTILE_SHARE * along.cost - 1e-9, "seed {seed}: {start:?} to {goal:?}");
            ratios.push(theta.cost / optimum);
            let smoothed = cost(&plane, &smooth(&plane, &along.path)).expect("free legs");
            smoothed_ratios.push(smoothed / optimum);
        }
    }
    let (q, s) = (Quantiles::of(ratios.iter().copied()), Quantiles::of(smoothed_ratios.iter().copied()));
    let (theta_mean, smoothed_mean) = (mean(ratios.iter().copied()), mean(smoothed_ratios.iter().copied()));
    println!("300 maps of 12 × 12, {} queries, {unreachable} more without a way", ratios.len());
    println!(
        "  Theta*         {theta_mean:.5} of the optimum on average, {:.4} at the 99th percentile, {:.4} at most",
        q.p99, q.most
    );
    println!(
        "  A*, smoothed   {smoothed_mean:.5}                       {:.4}                        {:.4}",
        s.p99, s.most
    );
    assert!(ratios.len() > 10_000 && unreachable > 1000);
    assert!(theta_mean < 1.0025 && theta_mean < smoothed_mean);
}

/// The same moves with the octile distance for a bound: fewer expansions, other paths of the same length.
struct Octile<'p>(&'p Plane);

impl Space for Octile<'_> {
    fn vertices(&self) -> usize {
        self.0.vertices()
    }
    fn for_neighbours(&self, vertex: usize, visit: impl FnMut(usize, f64)) {
        self.0.for_neighbours(vertex, visit);
    }
    fn leg_below(&self, from: usize, to: usize, limit: f64) -> Option<f64> {
        self.0.leg_below(from, to, limit)
    }
    fn is_dead_end(&self, vertex: usize) -> bool {
        self.0.is_dead_end(vertex)
    }
    fn bound(&self, vertex: usize, goal: usize) -> f64 {
        let ([x, y], [goal_x, goal_y]) = (self.0.place(vertex), self.0.place(goal));
        let (dx, dy) = (f64::from(x.abs_diff(goal_x)), f64::from(y.abs_diff(goal_y)));
        dx.max(dy) + (2f64.sqrt() - 1.0) * dx.min(dy)
    }
}

#[test]
fn beats_smoothed_a_star_on_random_maps() {
    // [1] in grid::theta quotes 70 % for 500 × 500 cells, 20 % of them blocked.
    let mut search = Search::new();
    let mut scores = [("straight-line bound", 0, 0, 0, Vec::new()), ("octile bound", 0, 0, 0, Vec::new())];
    let (mut expanded, mut expanded_along) = (0, 0);
    for seed in 0..10 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let plane = random(&mut rng, 500, 0.2);
        let mut queries = 0;
        while queries < 10 {
            let mut any =
                || plane.vertex([rng.random_range(0..=500), rng.random_range(0..=500)]).expect("on it");
            let (from, to) = (any(), any());
            let Some(theta) = search.theta_star(&plane, from, to) else { continue };
            if from == to {
                continue;
            }
            queries += 1;
            expanded += theta.expanded;
            let straight = search.a_star(&plane, from, to).expect("Theta* found a way");
            let octile = search.a_star(&Octile(&plane), from, to).expect("Theta* found a way");
            expanded_along += octile.expanded;
            assert!((straight.cost - octile.cost).abs() < 1e-6, "seed {seed}: two lengths of A*");
            for (score, along) in scores.iter_mut().zip([straight, octile]) {
                let smoothed = cost(&plane, &smooth(&plane, &along.path)).expect("free legs");
                let (_, wins, ties, losses, ratios) = score;
                let ahead = (smoothed - theta.cost) / theta.cost;
                *(if ahead > 1e-9 {
                    wins
                } else if ahead < -1e-9 {
                    losses
                } else {
                    ties
                }) += 1;
                ratios.push(theta.cost / smoothed);
            }
        }
    }
    println!("100 queries on ten maps of 500 × 500 cells, 20 % blocked: Theta* against A* with smoothing");
    for (bound, wins, ties, losses, ratios) in &scores {
        println!(
            "  {bound:<20} shorter in {wins} %, equal in {ties} %, longer in {losses} %; {:.5} of the length",
            mean(ratios.iter().copied())
        );
    }
    println!("  expanded: {expanded} against {expanded_along} (octile bound)");
    for (bound, wins, _, _, ratios) in scores {
        assert!(wins >= 98, "{bound}: shorter in {wins} of 100, where 99 were seen");
        assert!(mean(ratios) < 0.989, "where 0.978 and 0.974 were seen");
    }
}

#[test]
fn no_longer_than_the_octile_lengths_of_a_scenario() {
    let plane = read::plane(include_str!("../../../host/data/maps/arena.map")).expect("a map");
    let scenario = include_str!("../../../host/data/maps/arena.map.scen");
    let queries = read::plane_scenario(scenario, &plane).expect("a scenario");
    assert_eq!(queries.len(), 160);
    let mut search = Search::new();
    let (mut sum, mut octile_sum, mut smoothed_sum) = (0.0, 0.0, 0.0);
    for query in &queries {
        let (from, to) =
            (plane.vertex(query.start).expect("on it"), plane.vertex(query.goal).expect("on it"));
        let theta = search.theta_star(&plane, from, to).expect("a way");
        let along = search.a_star(&plane, from, to).expect("a way");
        // The scenario's paths join centres and cut no corners: moved by half a cell they are paths between corners.
        assert!(
            along.cost <= query.length + 1e-4,
            "line {}: {} for {}",
            query.line,
            along.cost,
            query.length
        );
        assert!(
            theta.cost <= query.length + 1e-4,
            "line {}: {} for {}",
            query.line,
            theta.cost,
            query.length
        );
        assert!(theta.cost >= OCTILE_SHARE * along.cost - 1e-9, "line {}", query.line);
        sum += theta.cost;
        octile_sum += query.length;
        smoothed_sum += cost(&plane, &smooth(&plane, &along.path)).expect("free legs");
    }
    println!(
        "arena.map, 160 queries: {sum:.2} cells against {octile_sum:.2} octile ({:.4}), {smoothed_sum:.2} smoothed",
        sum / octile_sum
    );
    assert!(sum <= smoothed_sum);
}
