use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::theta::{Space, cost};

/// Shortest lengths from `start`: Dijkstra over all legs between any two vertices.
fn optima(plane: &Plane, start: usize) -> Vec<f64> {
    let count = plane.vertices();
    let mut length = vec![f64::INFINITY; count];
    let mut done = vec![false; count];
    length[start] = 0.0;
    loop {
        let next = (0..count).filter(|&k| !done[k] && length[k].is_finite());
        let Some(at) = next.min_by(|&a, &b| length[a].total_cmp(&length[b])) else { return length };
        done[at] = true;
        if at != start && plane.is_dead_end(at) {
            continue;
        }
        for to in (0..count).filter(|&to| to != at && plane.place(to)[0] <= plane.width()) {
            if !done[to]
                && let Some(leg) = plane.leg_below(at, to, length[to] - length[at])
            {
                length[to] = length[at] + leg;
            }
        }
    }
}

#[test]
fn exact_on_random_maps() {
    let mut taut = Taut::new();
    let (mut found, mut unreachable) = (0, 0);
    for seed in 0..400 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (width, height) = (rng.random_range(1..14), rng.random_range(1..14));
        let share = rng.random_range(0.03..0.6);
        let blocked: Vec<bool> = (0..width * height).map(|_| rng.random_bool(share)).collect();
        let plane = Plane::new(width, height, |x, y| !blocked[(y * width + x) as usize]).expect("a map");
        for _ in 0..3 {
            let start =
                plane.vertex([rng.random_range(0..=width), rng.random_range(0..=height)]).expect("on it");
            let optima = optima(&plane, start);
            for goal in (0..plane.vertices()).filter(|&v| plane.place(v)[0] <= width) {
                let optimum = optima[goal];
                let Some(path) = taut.shortest(&plane, start, goal) else {
                    assert!(
                        optimum.is_infinite(),
                        "seed {seed}: {:?} to {:?} takes {optimum}",
                        plane.place(start),
                        plane.place(goal)
                    );
                    unreachable += 1;
                    continue;
                };
                let sum = cost(&plane, &path.path);
                assert!(
                    sum.is_some_and(|sum| (sum - optimum).abs() < 1e-9 && (path.cost - sum).abs() < 1e-9),
                    "seed {seed}: {:?} to {:?}: {optimum}, {:?} is {sum:?} on\n{}",
                    plane.place(start),
                    plane.place(goal),
                    path.path.iter().map(|&v| plane.place(v)).collect::<Vec<_>>(),
                    (0..height)
                        .map(|y| (0..width)
                            .map(|x| if plane.is_free(x, y) { '.' } else { '#' })
                            .collect::<String>()
                            + "\n")
                        .collect::<String>()
                );
                found += 1;
            }
        }
    }
    assert!(found > 10_000 && unreachable > 1000, "{found}, {unreachable}");
}

#[test]
fn warm_it_allocates_for_the_path_only() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let blocked: Vec<bool> = (0..200 * 200).map(|_| rng.random_bool(0.15)).collect();
    let plane = Plane::new(200, 200, |x, y| !blocked[(y * 200 + x) as usize]).expect("a map");
    let [start, goal] = [[3, 3], [190, 180]].map(|at| plane.vertex(at).expect("on it"));
    let mut taut = Taut::new();
    let cold = taut.shortest(&plane, start, goal).expect("a way");
    let mut warm = None;
    let counted = allocation_counter::measure(|| warm = taut.shortest(&plane, start, goal));
    assert_eq!(warm.as_ref(), Some(&cold));
    // The path grows by doubling.
    assert!(
        cold.expanded > 1000 && counted.count_total <= 8,
        "{} for {}",
        counted.count_total,
        cold.expanded
    );
    assert_eq!(counted.count_current, 1, "the path is kept");
}
