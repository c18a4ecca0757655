//! The bound against paths: it may not exceed any of them, and should not be far below.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::vehicle::Vehicle;

use reconfiguration::problem::Rules;

use super::*;
use crate::power::PowerLaw;
use crate::propulsion::Steady;

const HEADINGS: [Heading; 4] = [Heading::Held(0.0), Heading::Held(0.7), Heading::Along, Heading::Free];

fn map(speeds_m_s: [f64; 2], steady: Steady) -> PowerMap {
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    let law = PowerLaw::fitted(16.0).expect("in the table");
    PowerMap::new(
        &Propulsion::new(&robot, law, &Rules::default(), steady).expect("six thrusters"),
        speeds_m_s,
    )
}

/// The paper's constant speed, and the range that legs may take.
fn maps() -> [PowerMap; 2] {
    [map([0.311; 2], Steady::Published), map([0.1, 0.5], Steady::Whole)]
}

/// Evenly on the sphere.
fn direction(rng: &mut ChaCha8Rng) -> [f64; 3] {
    let z = rng.random_range(-1.0..1.0_f64);
    let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
    let level = (1.0 - z * z).sqrt();
    [level * cos, level * sin, z]
}

fn sum(legs: &[[f64; 3]]) -> [f64; 3] {
    legs.iter().fold([0.0; 3], |sum, leg| std::array::from_fn(|k| sum[k] + leg[k]))
}

#[test]
fn no_path_is_cheaper_than_the_bound() {
    let seed = 1;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut nearest = f64::INFINITY;
    for map in maps() {
        for heading in HEADINGS {
            for lambda_w in [0.0, 0.8, 3.2, 20.0] {
                let cost_per_metre = CostPerMetre::energy(&map, heading, lambda_w);
                for case in 0..1500 {
                    // Anywhere, or to and fro along one way: paths that nearly cancel, and paths that hardly bend.
                    let way = direction(&mut rng);
                    let stray = [0.05, 0.5, 3.0][case % 3];
                    let legs: Vec<[f64; 3]> = (0..rng.random_range(2..=8))
                        .map(|_| {
                            let aside = direction(&mut rng);
                            let size = rng.random_range(0.01..1.0);
                            std::array::from_fn(|k| size * (way[k] + stray * aside[k]))
                        })
                        .collect();
                    let cost: f64 = legs.iter().map(|leg| cost_per_metre.cost(*leg)).sum();
                    let bound = cost_per_metre.bound(sum(&legs));
                    assert!(
                        bound <= cost * (1.0 + 1e-12),
                        "seed {seed}, {heading:?}, λ = {lambda_w} W: bound {bound} J above {cost} J of {legs:?}"
                    );
                    nearest = nearest.min(cost / bound);
                }
            }
        }
    }
    assert!(nearest < 1.02, "nearest {nearest}: these paths do not try the bound");
}

/// At constant speed the straight line itself is no bound: steep ways are cheaper in zigzags.
#[test]
fn a_zigzag_beats_the_straight_leg_at_constant_speed_and_not_the_bound() {
    let [constant, any] = maps();
    let least = |map: &PowerMap, way: [f64; 3]| {
        let cost_per_metre = CostPerMetre::energy(map, Heading::Along, 0.8);
        // Two legs of half the way each, as far aside as they may be.
        let zigzag = |k: u32| {
            let aside = f64::from(k) / 200.0;
            let legs = [1.0, -1.0].map(|sign| [way[0] / 2.0 + sign * aside, way[1] / 2.0, way[2] / 2.0]);
            legs.iter().map(|leg| cost_per_metre.cost(*leg)).sum::<f64>()
        };
        let zigzag = (1..400).map(zigzag).fold(f64::INFINITY, f64::min);
        (zigzag / cost_per_metre.cost(way), cost_per_metre.bound(way) / zigzag)
    };
    let (share, bound) = least(&constant, [0.0, 0.0, 1.0]);
    println!(
        "constant speed, straight down: best zigzag {share:.3} of the straight leg, bound {bound:.3} of the zigzag"
    );
    assert!(share < 0.95, "a zigzag costs {share} of the straight leg");
    assert!(bound <= 1.0 && bound > 0.9, "the bound is {bound} of the zigzag");
    let (share, bound) = least(&any, [0.0, 0.0, 1.0]);
    println!(
        "best speed, straight down: best zigzag {share:.3} of the straight leg, bound {bound:.3} of the zigzag"
    );
    assert!(share > 0.99 && bound <= 1.0, "{share}, {bound}");
}

#[test]
fn at_the_best_speed_the_bound_is_near_the_straight_leg() {
    let seed = 2;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut means = Vec::new();
    for steady in [Steady::Published, Steady::Whole] {
        let any = map([0.1, 0.5], steady);
        for heading in HEADINGS {
            for lambda_w in [0.0, 0.8, 3.2] {
                let cost_per_metre = CostPerMetre::energy(&any, heading, lambda_w);
                let shares = (0..2000)
                    .map(|_| direction(&mut rng))
                    .map(|way| cost_per_metre.bound(way) / cost_per_metre.cost(way));
                let (mean, most) = shares.fold((0.0, 0.0_f64), |(s, m), x| (s + x / 2000.0, m.max(x)));
                let what = format!("{steady:?}, {heading:?}, λ = {lambda_w} W");
                println!("{what}: bound {mean:.3} of the straight leg on average, {most:.3} at most");
                // A thruster that serves two axes makes oblique courses dear for a robot that holds its heading: a
                // zigzag is cheaper there than the straight leg, and no bound can reach that.
                assert!(mean > 0.85 && most <= 1.0, "seed {seed}, {what}: {mean}, {most}");
                means.push(mean);
            }
        }
    }
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    assert!(mean > 0.9, "seed {seed}: {mean} on average");
}

/// Ramps take more than they save by being slow: the steady cost per metre bounds legs from rest to rest too.
#[test]
fn no_leg_from_rest_to_rest_is_cheaper_than_the_bound() {
    let seed = 3;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    let law = PowerLaw::fitted(16.0).expect("in the table");
    let propulsion = Propulsion::new(&robot, law, &Rules::default(), Steady::Whole).expect("six thrusters");
    let any = PowerMap::new(&propulsion, [0.1, 0.5]);
    for lambda_w in [0.0, 0.2, 3.2] {
        let [held, free] =
            [Heading::Held(0.0), Heading::Free].map(|heading| CostPerMetre::energy(&any, heading, lambda_w));
        for _ in 0..400 {
            let (way, way_m) = (direction(&mut rng), rng.random_range(0.05..4.0));
            let leg = propulsion.best_leg(way, way_m, [0.1, 0.5], 0.2, lambda_w).expect("possible");
            let cost = leg.with_others(lambda_w);
            for bound in [&held, &free].map(|cost_per_metre| cost_per_metre.bound(way.map(|x| x * way_m))) {
                let what = format!("seed {seed}, λ = {lambda_w} W, {way_m} m along {way:?}");
                assert!(bound <= cost, "{what}: bound {bound} J above {cost} J");
            }
        }
    }
}

#[test]
fn length_is_its_own_bound() {
    let cost_per_metre = CostPerMetre::euclidean();
    let way = [3.0, -4.0, 12.0];
    assert!(
        (cost_per_metre.cost(way) - 13.0).abs() < 1e-12 && (cost_per_metre.bound(way) - 13.0).abs() < 1e-12
    );
}
