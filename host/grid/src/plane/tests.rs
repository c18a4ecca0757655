use std::collections::VecDeque;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::theta::Search;

/// A map drawn with `#` for blocked cells.
fn drawn(rows: &[&str]) -> Plane {
    let is_free = |x: u32, y: u32| rows[y as usize].as_bytes()[x as usize] != b'#';
    Plane::new(rows[0].len() as u32, rows.len() as u32, is_free).expect("a map")
}

fn random(rng: &mut ChaCha8Rng, side_max: u32) -> Plane {
    let (width, height) = (rng.random_range(1..=side_max), rng.random_range(1..=side_max));
    let share = rng.random_range(0.1..0.6);
    let blocked: Vec<bool> = (0..width * height).map(|_| rng.random_bool(share)).collect();
    Plane::new(width, height, |x, y| !blocked[(y * width + x) as usize]).expect("a map")
}

fn corners(plane: &Plane) -> Vec<[u32; 2]> {
    let [width, height] = plane.last();
    (0..=height).flat_map(|y| (0..=width).map(move |x| [x, y])).collect()
}

fn vertex(plane: &Plane, place: [u32; 2]) -> usize {
    plane.vertex(place).expect("on the map")
}

/// Whether the cell with that upper left corner is free, by the public face of the map.
fn free(plane: &Plane, x: i64, y: i64) -> bool {
    x >= 0 && y >= 0 && plane.is_free(x as u32, y as u32)
}

/// Two cells that meet at a corner only are free, the other two blocked.
fn pinches(plane: &Plane, x: i64, y: i64) -> bool {
    let [a, b, c, d] = [(-1, -1), (0, -1), (-1, 0), (0, 0)].map(|(i, j)| free(plane, x + i, y + j));
    a == d && b == c && a != b
}

/// Sight, point by point. All grid lines are met at multiples of 1/(|Δx|·|Δy|): halfway between two of them every point
/// lies inside a cell, and every cell crossed has such a point.
fn sampled_sight(plane: &Plane, [x, y]: [u32; 2], [x_to, y_to]: [u32; 2]) -> bool {
    let (x, y) = (i64::from(x), i64::from(y));
    let (dx, dy) = (i64::from(x_to) - x, i64::from(y_to) - y);
    let (wx, wy) = (dx.abs().max(1), dy.abs().max(1));
    let halves = 2 * wx * wy;
    (0..=halves).all(|k| {
        // The point is (x, y) + (Δx, Δy)·k/halves.
        let (px, py) = (x * halves + dx * k, y * halves + dy * k);
        let (column, row) = (px.div_euclid(halves), py.div_euclid(halves));
        let (on_x, on_y) = (px % halves == 0, py % halves == 0);
        match (on_x, on_y) {
            (true, true) => k == 0 || k == halves || !pinches(plane, column, row),
            (true, false) if dx == 0 => free(plane, column - 1, row) || free(plane, column, row),
            (false, true) if dy == 0 => free(plane, column, row - 1) || free(plane, column, row),
            (false, false) => free(plane, column, row),
            // Crossing a line between two cells, both of which have points of their own.
            _ => true,
        }
    })
}

#[test]
fn sight_is_exact() {
    let (mut seen, mut hidden) = (0, 0);
    for seed in 0..120 {
        let plane = random(&mut ChaCha8Rng::seed_from_u64(seed), 7);
        let corners = corners(&plane);
        for &from in &corners {
            for &to in corners.iter().filter(|&&to| to != from) {
                let expected = sampled_sight(&plane, from, to);
                let leg = plane.leg(vertex(&plane, from), vertex(&plane, to));
                assert_eq!(leg.is_some(), expected, "seed {seed}: {from:?} to {to:?} on {plane:?}");
                *(if expected { &mut seen } else { &mut hidden }) += 1;
            }
        }
    }
    assert!(seen > 10_000 && hidden > 10_000, "{seen} seen, {hidden} hidden");
}

#[test]
fn neighbours_are_the_free_legs_to_them() {
    for seed in 0..200 {
        let plane = random(&mut ChaCha8Rng::seed_from_u64(seed), 6);
        for &from in &corners(&plane) {
            let mut offered = Vec::new();
            plane.for_neighbours(vertex(&plane, from), |next, cost| offered.push((plane.place(next), cost)));
            offered.sort_by_key(|&([x, y], _)| (y, x));
            let mut expected = Vec::new();
            for to in corners(&plane) {
                let apart = from[0].abs_diff(to[0]).max(from[1].abs_diff(to[1]));
                if apart == 1 && sampled_sight(&plane, from, to) {
                    let far = from[0] != to[0] && from[1] != to[1];
                    expected.push((to, if far { 2.0_f64.sqrt() } else { 1.0 }));
                }
            }
            assert_eq!(offered, expected, "seed {seed}: {from:?} on {plane:?}");
        }
    }
}

/// Least lengths along the eight moves, by Dijkstra without a heap.
fn octile(plane: &Plane, start: [u32; 2]) -> Vec<f64> {
    let corners = corners(plane);
    let mut length = vec![f64::INFINITY; corners.len()];
    let mut done = vec![false; corners.len()];
    let number = |[x, y]: [u32; 2]| y as usize * (plane.width() as usize + 1) + x as usize;
    length[number(start)] = 0.0;
    loop {
        let next = (0..corners.len()).filter(|&k| !done[k] && length[k].is_finite());
        let Some(k) = next.min_by(|&a, &b| length[a].total_cmp(&length[b])) else { return length };
        done[k] = true;
        let [x, y] = corners[k].map(i64::from);
        if corners[k] != start && pinches(plane, x, y) {
            continue;
        }
        for (i, j) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            let to = [x + i, y + j];
            if to[0] < 0 || to[1] < 0 || to[0] > plane.width().into() || to[1] > plane.height().into() {
                continue;
            }
            let to = to.map(|c| c as u32);
            if sampled_sight(plane, corners[k], to) {
                let along = length[k] + ((i * i + j * j) as f64).sqrt();
                length[number(to)] = length[number(to)].min(along);
            }
        }
    }
}

/// Cells from which free cells with a common edge lead to one around `start`.
fn flooded(plane: &Plane, [x, y]: [u32; 2]) -> Vec<(i64, i64)> {
    let (x, y) = (i64::from(x), i64::from(y));
    let mut queue: VecDeque<_> = [(x - 1, y - 1), (x, y - 1), (x - 1, y), (x, y)].into();
    let mut wet = Vec::new();
    while let Some((x, y)) = queue.pop_front() {
        if free(plane, x, y) && !wet.contains(&(x, y)) {
            wet.push((x, y));
            queue.extend([(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)]);
        }
    }
    wet
}

#[test]
fn a_star_is_dijkstra_on_the_eight_moves_and_theta_star_reaches_what_water_reaches() {
    let mut search = Search::new();
    let (mut reached, mut not) = (0, 0);
    for seed in 0..150 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let plane = random(&mut rng, 9);
        let corners = corners(&plane);
        let start = corners[rng.random_range(0..corners.len())];
        let (length, wet) = (octile(&plane, start), flooded(&plane, start));
        for (k, &goal) in corners.iter().enumerate() {
            let (from, to) = (vertex(&plane, start), vertex(&plane, goal));
            let (x, y) = (i64::from(goal[0]), i64::from(goal[1]));
            let is_wet = [(x - 1, y - 1), (x, y - 1), (x - 1, y), (x, y)].iter().any(|c| wet.contains(c));
            let exact = search.a_star(&plane, from, to).map(|found| found.cost);
            let theta = search.theta_star(&plane, from, to);
            if start == goal {
                continue;
            }
            assert_eq!(
                (exact.is_some(), theta.is_some()),
                (is_wet, is_wet),
                "seed {seed}: {start:?} {goal:?}"
            );
            match exact {
                Some(exact) => {
                    assert!((exact - length[k]).abs() < 1e-9, "seed {seed}: {start:?} {goal:?}");
                    reached += 1;
                }
                None => not += 1,
            }
            for pair in theta.iter().flat_map(|found| found.path.windows(2)) {
                let legs = [plane.place(pair[0]), plane.place(pair[1])];
                assert!(sampled_sight(&plane, legs[0], legs[1]), "seed {seed}: {legs:?} on {plane:?}");
            }
        }
    }
    assert!(reached > 2000 && not > 2000, "{reached} reached, {not} not");
}

#[test]
fn corners_are_touched_and_pinches_are_not_passed() {
    let mut search = Search::new();
    let mut length = |plane: &Plane, from, to| {
        search.theta_star(plane, vertex(plane, from), vertex(plane, to)).map(|found| found.cost)
    };
    // Past one corner, straight.
    let plane = drawn(&[".#", ".."]);
    assert_eq!(length(&plane, [0, 0], [2, 2]), Some(8.0_f64.sqrt()));
    // Between two diagonal blocks: neither in one leg, nor by a stop between them; but to the middle, from either side.
    let plane = drawn(&[".#", "#."]);
    assert_eq!(length(&plane, [0, 0], [2, 2]), None);
    assert_eq!(length(&plane, [0, 0], [1, 1]), Some(2.0_f64.sqrt()));
    assert_eq!(length(&plane, [1, 1], [2, 2]), Some(2.0_f64.sqrt()));
    // Along a wall, but not from one side of the line to the other.
    assert_eq!(length(&drawn(&["##", ".."]), [0, 1], [2, 1]), Some(2.0));
    assert_eq!(length(&drawn(&["#.", ".#"]), [0, 1], [2, 1]), None);
    assert_eq!(length(&drawn(&["##", "##"]), [0, 1], [2, 1]), None);
    // Around a block of two: (0, 0) to the corner (2, 1), then to (3, 3).
    let around = length(&drawn(&["...", "##.", "..."]), [0, 1], [0, 2]).expect("a way");
    assert!((around - (2.0 + 1.0 + 2.0)).abs() < 1e-12);
}

#[test]
fn places_and_sizes() {
    let plane = drawn(&["...#", "...#"]);
    assert_eq!((plane.width(), plane.height(), plane.last()), (4, 2, [4, 2]));
    for place in corners(&plane) {
        assert_eq!(plane.place(vertex(&plane, place)), place);
        // The right edge has blocks only.
        assert_eq!(plane.is_open(vertex(&plane, place)), place[0] < 4, "{place:?}");
    }
    assert_eq!((plane.vertex([5, 0]), plane.vertex([0, 3])), (None, None));
    assert!(plane.is_free(2, 1) && !plane.is_free(3, 1) && !plane.is_free(0, 2) && !plane.is_free(4, 0));
    assert!(Plane::new(0, 5, |_, _| true).is_none() && Plane::new(1, SIDE_MAX + 1, |_, _| true).is_none());
    assert!(Plane::new(SIDE_MAX, SIDE_MAX, |_, _| true).is_none());
}
