use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;
use crate::Map;
use crate::theta::Search;
use crate::volume::Volume;

fn vertex(volume: &Volume, cell: [u32; 3]) -> usize {
    volume.vertex(cell).expect("on the map")
}

/// Least cost by all legs between any two free cells: Dijkstra without a heap.
fn least(volume: &Volume, start: usize, goal: usize) -> f64 {
    let mut open: Vec<_> =
        (0..volume.vertices()).filter(|&v| volume.is_open(v)).map(|v| (v, f64::INFINITY)).collect();
    open.push((start, 0.0));
    loop {
        let k = (0..open.len()).min_by(|&a, &b| open[a].1.total_cmp(&open[b].1)).expect("a way");
        let (at, g) = open.swap_remove(k);
        if at == goal {
            return g;
        }
        for (to, known) in &mut open {
            if let Some(leg) = volume.leg_below(at, *to, *known - g) {
                *known = g + leg;
            }
        }
    }
}

#[test]
fn a_corner_that_touches_nothing_goes_and_one_beside_an_edge_moves_to_it() {
    let mut volume = Volume::new([11, 9, 3]).expect("a map");
    let path = |volume: &Volume, cells: &[[u32; 3]]| {
        let path: Vec<_> = cells.iter().map(|&cell| vertex(volume, cell)).collect();
        FoundPath { cost: cost(volume, &path).expect("free legs"), path, expanded: 0 }
    };
    let mut open = path(&volume, &[[0, 0, 1], [3, 5, 0], [7, 2, 2], [10, 0, 1]]);
    Corridor::new().tighten(&volume, &mut open);
    assert_eq!((open.path.len(), open.cost), (2, 10.0));
    // A wall across the whole of the map up to y = 4: over it by the cells beside its edge, in the layer of both ends.
    for z in 0..3 {
        for y in 0..5 {
            volume.block([5, y, z]);
        }
    }
    let mut over = path(&volume, &[[0, 0, 1], [4, 7, 0], [6, 7, 2], [10, 0, 1]]);
    Corridor::new().tighten(&volume, &mut over);
    // Twice from the end to the cell above the edge, √13 + √13: the straight leg there would touch the edge.
    let optimum = least(&volume, over.path[0], vertex(&volume, [10, 0, 1]));
    assert!((optimum - 4.0 * 13f64.sqrt()).abs() < 1e-12, "{optimum}");
    assert!((over.cost - optimum).abs() < 1e-12, "{}", over.cost);
}

#[test]
fn never_dearer_and_done_when_done() {
    let (mut search, mut corridor, mut shorter) = (Search::new(), Corridor::new(), 0);
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut volume = Volume::new([14; 3]).expect("a map");
        for _ in 0..14 {
            let corner: [u32; 3] = std::array::from_fn(|_| rng.random_range(0..14));
            for k in 0..125 {
                volume.block([corner[0] + k % 5, corner[1] + k / 5 % 5, corner[2] + k / 25]);
            }
        }
        for _ in 0..5 {
            let [start, goal] =
                [(); 2].map(|()| vertex(&volume, std::array::from_fn(|_| rng.random_range(0..14))));
            let Some(found) = search.a_star(&volume, start, goal) else { continue };
            let mut tight = found.clone();
            corridor.tighten(&volume, &mut tight);
            let sum = cost(&volume, &tight.path).expect("free legs");
            assert!((sum - tight.cost).abs() <= 1e-12 * sum, "seed {seed}: {} for {sum}", tight.cost);
            assert!(
                tight.cost <= found.cost * (1.0 + 1e-12),
                "seed {seed}: {} from {}",
                tight.cost,
                found.cost
            );
            assert_eq!((tight.path[0], *tight.path.last().expect("a goal")), (start, goal), "seed {seed}");
            shorter += u32::from(tight.cost < found.cost * 0.99);
            let mut again = tight.clone();
            corridor.tighten(&volume, &mut again);
            assert_eq!(again, tight, "seed {seed}");
        }
    }
    assert!(shorter > 50, "{shorter} of 300 shorter by a hundredth");
}
