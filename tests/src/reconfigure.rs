//! Seeded reconfigurations: random clusters of BlueROV1, with a tool or without, in one layer or in space.
//!
//! Start and goal are connected sets of cells of the docking lattice, whose cell is the box of the robot, grown from one
//! cell by docking each next to a random free side. The goal lies apart from the start or overlaps it in part. With a
//! tool, both grow from the tool's cell, so that it is held throughout.

use rand::{Rng, RngExt};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::Vehicle;

type Cell = [i32; 3];

/// What kind of reconfiguration is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// How many robots.
    pub robots: usize,
    /// With the 20 N tool, or without any.
    pub tool: bool,
    /// In space, or in one layer.
    pub spatial: bool,
}

impl Kind {
    /// Three to eight robots, with and without tool, planar and spatial.
    pub fn random(rng: &mut impl Rng) -> Self {
        Self { robots: rng.random_range(3..=8), tool: rng.random_bool(0.5), spatial: rng.random_bool(0.5) }
    }
}

/// `count` cells beside `seed` that form one cluster with it.
fn grown(seed: Cell, count: usize, spatial: bool, rng: &mut impl Rng) -> Vec<Cell> {
    let mut cells = vec![seed];
    while cells.len() <= count {
        let mut cell = cells[rng.random_range(0..cells.len())];
        let axis = rng.random_range(0..if spatial { 3 } else { 2 });
        cell[axis] += if rng.random_bool(0.5) { 1 } else { -1 };
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    cells.split_off(1)
}

/// A random problem of that kind which passes [`check`](rov::conditions::Conditions::check).
///
/// # Panics
/// If the built-in vehicles are not there.
pub fn problem(kind: Kind, rng: &mut impl Rng) -> Problem {
    let vehicles =
        ["bluerov1", "tool-20n"].map(|name| Vehicle::built_in(name).expect("a built-in vehicle")).to_vec();
    let box_m = vehicles[0].box_m;
    let pose = |cell: Cell| -> Pose {
        let [x, y, z] = std::array::from_fn(|k| f64::from(cell[k]) * box_m[k]);
        [x, y, z, 0.0].into()
    };
    let (start, goal) = loop {
        // Without a tool, a robot is the first cell, and the goal may be anywhere near.
        let others = kind.robots - usize::from(!kind.tool);
        let mut away = || if kind.tool { 0 } else { rng.random_range(-4..=4) };
        let seed = [away(), away(), if kind.spatial { away() } else { 0 }];
        let mut start = grown([0; 3], others, kind.spatial, rng);
        let mut goal = grown(seed, others, kind.spatial, rng);
        if !kind.tool {
            start.push([0; 3]);
            goal.push(seed);
        }
        // At least one robot has to move.
        if goal.iter().any(|cell| !start.contains(cell)) {
            break (start, goal);
        }
    };
    let robot = |(index, cell): (usize, &Cell)| Robot {
        id: u16::try_from(index + 1).expect("a handful of robots"),
        vehicle: 0,
        start: pose(*cell),
        capabilities: Vec::new(),
    };
    Problem {
        name: format!("random-{}", kind.robots),
        description: format!("{kind:?}"),
        vehicles,
        robots: start.iter().enumerate().map(robot).collect(),
        tools: if kind.tool { vec![Tool { vehicle: 1, pose: pose([0; 3]) }] } else { Vec::new() },
        slots: goal.iter().map(|cell| Slot { pose: pose(*cell), requires: Vec::new() }).collect(),
        rules: Rules::default(),
        bounds: None,
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use rov::conditions::Conditions;

    use super::*;

    #[test]
    fn two_hundred_random_problems_are_sound_and_of_every_kind() {
        let (mut tools, mut spatial, mut overlapping, mut counts) = (0, 0, 0, [0; 9]);
        for seed in 0..200 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let kind = Kind::random(&mut rng);
            let problem = problem(kind, &mut rng);
            problem.check().unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            assert_eq!(
                (problem.robots.len(), problem.slots.len()),
                (kind.robots, kind.robots),
                "seed {seed}"
            );
            let level = problem.robots.iter().all(|robot| robot.start.position_m[2].abs() < 1e-12);
            assert!(kind.spatial || level, "seed {seed}");
            let stays = |slot: &Slot| problem.robots.iter().any(|robot| robot.start == slot.pose);
            assert!(!problem.slots.iter().all(stays), "seed {seed}: no robot has to move");
            overlapping += usize::from(problem.slots.iter().any(stays));
            (tools, spatial) = (tools + usize::from(kind.tool), spatial + usize::from(kind.spatial));
            counts[kind.robots] += 1;
        }
        assert!(
            (50..150).contains(&tools) && (50..150).contains(&spatial),
            "{tools} tools, {spatial} in space"
        );
        assert!((20..200).contains(&overlapping), "{overlapping} overlap in part");
        assert!(counts[3..].iter().all(|&count| count > 10), "{counts:?}");
    }

    #[test]
    fn the_same_seed_gives_the_same_problem() {
        let draw = |seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            problem(Kind { robots: 6, tool: true, spatial: true }, &mut rng)
        };
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
    }
}
