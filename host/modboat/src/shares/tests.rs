//! Shares found of a body that is integrated here: thrust by law (2), constant over each cycle, and quadratic drag.

use std::f64::consts::TAU;

use quantity::wrap_rad;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;

/// What the body is like, and how it is seen.
#[derive(Clone)]
struct Boat {
    shares: Vec<f64>,
    /// World, m/s.
    current_m_s: [f64; 2],
    /// Poses are so much older than their stamp, s.
    delay_s: f64,
    /// Standard deviation of poses, m and rad.
    noise: f64,
    /// The world is turned by this, rad, and moved, m.
    turned_rad: f64,
    moved_m: [f64; 2],
    /// m.
    munk: f64,
    /// Cycles are all alike.
    monotonous: bool,
}

impl Boat {
    fn of(shares: &[f64]) -> Self {
        Self {
            shares: shares.to_vec(),
            current_m_s: [0.0; 2],
            delay_s: 0.0,
            noise: 2e-4,
            turned_rad: 0.0,
            moved_m: [0.0; 2],
            munk: 0.0,
            monotonous: false,
        }
    }

    /// Swims `cycles` random cycles from `seed`; what is found in the end.
    fn swim(&self, word: &str, cycles: usize, seed: u64) -> Vec<Found> {
        self.swum(word, cycles, seed).relative().collect()
    }

    fn swum(&self, word: &str, cycles: usize, seed: u64) -> ShareEstimator {
        let (structure, parameters) = (Structure::from_word(word).expect("valid"), Parameters::default());
        let observer = ObserverParameters::default();
        let mut estimator =
            ShareEstimator::new(&structure, &parameters, &observer, (0.2, 0.0)).expect("modules");
        let positions_m = structure.positions_m(parameters.pitch_m);
        let mass_kg = structure.mass_kg(&parameters) * (1.0 + observer.added_mass);
        let inertia = structure.inertia_kg_m2(&parameters) * (1.0 + observer.added_inertia);
        let (drag, yaw_drag) =
            (structure.len() as f64 * parameters.drag_n_s2_m2, structure.yaw_drag_n_m_s2(&parameters));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut pose, mut rate) = ([0.0, 0.0, 0.4 + self.turned_rad], [0.0; 3]);
        let (sin_w, cos_w) = self.turned_rad.sin_cos();
        let water = [
            self.current_m_s[0] * cos_w - self.current_m_s[1] * sin_w,
            self.current_m_s[0] * sin_w + self.current_m_s[1] * cos_w,
        ];
        let dt_s = 0.01;
        let mut cycle: Vec<Swing> = Vec::new();
        for number in 0..cycles {
            if number == 0 || !self.monotonous {
                let mut swing = |_| Swing {
                    centerline_rad: rng.random_range(0.0..TAU),
                    amplitude_rad: rng.random_range(1.2..2.4),
                };
                cycle = (0..structure.len()).map(&mut swing).collect();
            }
            let start_s = number as f64 * parameters.period_s;
            estimator.swum(&Swum { start_s, interval_s: parameters.period_s, cycle: &cycle, about_rad: 0.0 });
            for step in 0..(parameters.period_s / dt_s).round() as usize {
                let (sin, cos) = f64::sin_cos(pose[2]);
                let slip = [rate[0] - water[0], rate[1] - water[1]];
                let through = [sin * slip[0] - cos * slip[1], cos * slip[0] + sin * slip[1]];
                let mut force =
                    [-drag * through[0] * through[0].abs(), -drag * through[1] * through[1].abs()];
                let mut torque =
                    -yaw_drag * rate[2] * rate[2].abs() - self.munk * mass_kg * through[0] * through[1];
                for ((swing, &at), share) in cycle.iter().zip(&positions_m).zip(&self.shares) {
                    let [x, y, tau] = swing.wrench(&parameters, at).to_array();
                    force = [force[0] + share * x, force[1] + share * y];
                    torque += share * tau;
                }
                let push = [sin * force[0] + cos * force[1], -cos * force[0] + sin * force[1]];
                rate = [
                    rate[0] + dt_s * push[0] / mass_kg,
                    rate[1] + dt_s * push[1] / mass_kg,
                    rate[2] + dt_s * torque / inertia,
                ];
                (0..3).for_each(|axis| pose[axis] += dt_s * rate[axis]);
                let t_s = start_s + (step + 1) as f64 * dt_s + self.delay_s;
                let noise: [f64; 3] = std::array::from_fn(|_| self.noise * rng.random_range(-1.7..1.7));
                estimator.update(&Fix {
                    t_s,
                    position_m: [0, 1].map(|k| pose[k] + self.moved_m[k] + noise[k]),
                    heading_rad: wrap_rad(pose[2] + noise[2]),
                });
            }
        }
        estimator
    }
}

/// By the mean of all.
fn relative(shares: &[f64]) -> Vec<f64> {
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    shares.iter().map(|share| share / mean).collect()
}

fn judge(boat: &Boat, word: &str, seed: u64) {
    let found = boat.swim(word, 60, seed);
    for (found, share) in found.iter().zip(relative(&boat.shares)) {
        let off = (found.share - share).abs();
        assert!(
            off < 0.08 && off < 4.0 * found.deviation,
            "{word}, seed {seed}: {found:?}, in truth {share}"
        );
        assert!(found.deviation < 0.06, "{word}, seed {seed}: {found:?}");
    }
}

#[test]
fn weak_modules_are_found_by_varied_cycles() {
    for seed in 1..5 {
        judge(&Boat::of(&[1.0, 0.5, 1.0]), "3x1", seed);
        judge(&Boat::of(&[1.0, 1.0, 0.4, 1.1, 0.9, 1.0]), "3x2", seed);
        judge(&Boat { current_m_s: [0.02, -0.01], ..Boat::of(&[1.4, 1.4, 0.7, 1.4]) }, "2x2", seed);
        // All alike, and not as believed: none is weak.
        judge(&Boat::of(&[1.5, 1.5, 1.5]), "3x1", seed);
    }
}

#[test]
fn poses_that_are_older_than_they_say_mislead_no_more() {
    for seed in 1..5 {
        for delay_s in [0.1, 0.35, 0.5] {
            judge(&Boat { delay_s, ..Boat::of(&[1.0, 0.5, 1.0]) }, "3x1", seed);
        }
    }
}

#[test]
fn origin_and_north_do_not_matter() {
    let boat = Boat { noise: 0.0, current_m_s: [0.01, 0.005], ..Boat::of(&[1.0, 0.6, 1.0, 0.9]) };
    let here = boat.swim("2x2", 30, 7);
    let there = Boat { turned_rad: 2.3, moved_m: [40.0, -75.0], ..boat }.swim("2x2", 30, 7);
    for (one, other) in here.iter().zip(&there) {
        assert!((one.share - other.share).abs() < 1e-6 && (one.deviation - other.deviation).abs() < 1e-6);
    }
}

/// What the same cycle over and over cannot tell stays unsure.
#[test]
fn one_cycle_tells_too_little_and_that_is_known() {
    let boat = Boat { monotonous: true, ..Boat::of(&[1.0, 1.0, 0.5, 1.0, 1.0, 1.0]) };
    let unsure = |seed| boat.swim("3x2", 60, seed).iter().map(|found| found.deviation).fold(0.0, f64::max);
    for seed in 1..5 {
        assert!(unsure(seed) > 0.1, "seed {seed}: {}", unsure(seed));
    }
}

/// The Munk moment twists the structure as a module does that pushes less: the two are told apart.
#[test]
fn the_munk_moment_is_not_taken_for_a_weak_module() {
    for seed in 1..5 {
        for munk in [-0.4, 0.3] {
            let boat = Boat { munk, ..Boat::of(&[1.0, 0.6, 1.0]) };
            judge(&boat, "3x1", seed);
            let found = boat.swum("3x1", 60, seed).munk().expect("a filter");
            let off = (found.share - munk).abs();
            assert!(off < 0.12 && off < 4.0 * found.deviation, "seed {seed}: {found:?}, in truth {munk}");
        }
    }
}

#[test]
fn a_lone_module_has_no_share() {
    let parameters = Parameters::default();
    let observer = ObserverParameters::default();
    let structure = Structure::from_word("1x1").expect("valid");
    assert!(ShareEstimator::new(&structure, &parameters, &observer, (0.2, 0.0)).is_none());
    let structure = Structure::from_word("3x1").expect("valid");
    assert!(ShareEstimator::new(&structure, &parameters, &observer, (0.0, 0.0)).is_none());
}

/// Cycles that do not follow each other tell nothing: what was between them is not known.
#[test]
fn a_pause_between_cycles_is_not_bridged() {
    let (structure, parameters) = (Structure::from_word("3x1").expect("valid"), Parameters::default());
    let observer = ObserverParameters::default();
    let mut estimator = ShareEstimator::new(&structure, &parameters, &observer, (0.2, 0.0)).expect("modules");
    let before: Vec<Found> = estimator.relative().collect();
    let cycle = [Swing { centerline_rad: 1.0, amplitude_rad: 2.0 }; 3];
    for number in 0..10 {
        let start_s = 3.0 * f64::from(number);
        estimator.swum(&Swum { start_s, interval_s: 1.5, cycle: &cycle, about_rad: 0.0 });
        for step in 0..300 {
            let t_s = start_s + f64::from(step) * 0.01;
            estimator.update(&Fix { t_s, position_m: [t_s * t_s, 0.0], heading_rad: 0.0 });
        }
    }
    assert_eq!(before, estimator.relative().collect::<Vec<_>>());
}
