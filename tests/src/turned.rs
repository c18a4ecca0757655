//! Seeded reconfigurations of clusters that no lattice holds: robots of two kinds docked by any face at any quarter turn, stacked at any
//! heading, the goal at any heading.
//!
//! A cluster grows from its first body by docking each next one to a random face of a body that is there: centres are half the
//! sum of both boxes apart, and the boxes must not overlap others. With a tool, start and goal both grow from it.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::{Rng, RngExt};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::Vehicle;
use rov::configuration::LevelBox;

/// Kinds of robots; what each is called in `requires`.
const KINDS: [(&str, &str); 2] = [("bluerov1", "light"), ("bluerov2-heavy", "heavy")];
const TOOL: usize = 2;

type Placed = (usize, Pose);

/// A pose of `kind` docked to a random face of `host`.
fn docked(host: &Placed, kind: usize, vehicles: &[Vehicle], spatial: bool, rng: &mut impl Rng) -> Pose {
    let axis = rng.random_range(0..if spatial { 3 } else { 2 });
    let quarter = rng.random_range(0..4_u8);
    let (own, other) = (vehicles[kind].box_m, vehicles[host.0].box_m);
    let facing = if axis < 2 && quarter % 2 == 1 { 1 - axis } else { axis };
    let apart_m = (other[axis] + own[facing]) / 2.0 * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let relative_rad = if axis == 2 && rng.random_bool(0.5) {
        rng.random_range(-PI..PI)
    } else {
        f64::from(quarter) * FRAC_PI_2
    };
    let (sin, cos) = host.1.yaw_rad.sin_cos();
    let [x, y, z] = host.1.position_m;
    let position_m = match axis {
        0 => [x + cos * apart_m, y + sin * apart_m, z],
        1 => [x - sin * apart_m, y + cos * apart_m, z],
        _ => [x, y, z + apart_m],
    };
    Pose { position_m, yaw_rad: host.1.yaw_rad + relative_rad }
}

/// A cluster of `kinds` around `first`, which stays in front.
fn grown(
    first: Placed,
    kinds: &[usize],
    vehicles: &[Vehicle],
    spatial: bool,
    rng: &mut impl Rng,
) -> Vec<Placed> {
    let mut cluster = vec![first];
    for &kind in kinds {
        loop {
            let host = cluster[rng.random_range(0..cluster.len())];
            let pose = docked(&host, kind, vehicles, spatial, rng);
            let own = LevelBox::around(pose, &vehicles[kind]);
            if cluster.iter().all(|(other, at)| own.gap_m(&LevelBox::around(*at, &vehicles[*other])) > -1e-6)
            {
                cluster.push((kind, pose));
                break;
            }
        }
    }
    cluster
}

/// A random problem of three to eight robots.
///
/// # Panics
/// If the built-in vehicles are not there.
pub fn problem(rng: &mut impl Rng) -> Problem {
    let built_in = |name: &str| Vehicle::built_in(name).expect("a built-in vehicle");
    let vehicles = vec![built_in(KINDS[0].0), built_in(KINDS[1].0), built_in("tool-20n")];
    let robots = rng.random_range(3..=8_usize);
    let (mixed, with_tool, spatial) = (rng.random_bool(0.5), rng.random_bool(0.5), rng.random_bool(0.5));
    let mut kinds: Vec<usize> =
        (0..robots).map(|_| if mixed { rng.random_range(0..KINDS.len()) } else { 0 }).collect();
    let mut heading = || rng.random_range(-PI..PI);
    let (here, there) = (heading(), heading());
    let first = (TOOL, Pose { position_m: [0.0; 3], yaw_rad: here });
    let (start, goal) = if with_tool {
        let start = grown(first, &kinds, &vehicles, spatial, rng);
        kinds.reverse();
        let goal = grown(first, &kinds, &vehicles, spatial, rng);
        (start[1..].to_vec(), goal[1..].to_vec())
    } else {
        let mut away = || rng.random_range(-2.5..2.5);
        let position_m = [away(), away(), if spatial { away() } else { 0.0 }];
        let start = grown((kinds[0], first.1), &kinds[1..], &vehicles, spatial, rng);
        kinds.reverse();
        let far = (kinds[0], Pose { position_m, yaw_rad: there });
        (start, grown(far, &kinds[1..], &vehicles, spatial, rng))
    };
    let robot = |(index, &(vehicle, start)): (usize, &Placed)| Robot {
        id: u16::try_from(index + 1).expect("a handful of robots"),
        vehicle,
        start,
        capabilities: vec![KINDS[vehicle].1.to_owned()],
    };
    let slot = |&(kind, pose): &Placed| Slot { pose, requires: vec![KINDS[kind].1.to_owned()] };
    Problem {
        name: format!("turned-{robots}"),
        description: format!("mixed {mixed}, tool {with_tool}, spatial {spatial}"),
        vehicles,
        robots: start.iter().enumerate().map(robot).collect(),
        tools: if with_tool { vec![Tool { vehicle: TOOL, pose: first.1 }] } else { Vec::new() },
        slots: goal.iter().map(slot).collect(),
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
    fn two_hundred_turned_problems_are_sound() {
        let mut counts = [0; 9];
        for seed in 0..200 {
            let problem = problem(&mut ChaCha8Rng::seed_from_u64(seed));
            problem.check().unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            counts[problem.robots.len()] += 1;
        }
        assert!(counts[3..].iter().all(|&count| count > 10), "{counts:?}");
    }
}
