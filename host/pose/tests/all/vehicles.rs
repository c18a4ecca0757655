//! Vehicles by their bodies: velocities, swapped labels, one that is carried.

use nalgebra::{UnitQuaternion, Vector3};
use pose::axes::{Pose, swap_world_and_ned};
use pose::frame::Label;
use pose::gate::Fix;
use pose::roster::{Entry, Name, Roster};
use pose::vehicles::{Limits, Sighting, Vehicles};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

const COUNT: u16 = 4;

fn roster(random: &mut ChaCha8Rng) -> Roster {
    let entries = (1..=COUNT).map(|module| Entry {
        module,
        body: Name::Number(i32::from(module)),
        offset_m: Vector3::new(random.random_range(-0.1..0.1), random.random_range(-0.1..0.1), -0.1),
        turn_rad: random.random_range(-1.0..1.0),
    });
    Roster::new(entries.collect()).expect("a sound roster")
}

/// The vehicles in north-east-down: half a metre apart, all under way, one of them turning.
fn truth(module: u16, at_s: f64) -> Pose {
    let n = f64::from(module);
    Pose {
        position: Vector3::new(0.5 * n + 0.1 * at_s, -0.05 * at_s, 1.0 + 0.02 * n * at_s),
        attitude: UnitQuaternion::from_euler_angles(0.05, -0.1, 0.3 * n + 0.2 * at_s),
    }
}

struct Lab {
    roster: Roster,
    vehicles: Vehicles,
    random: ChaCha8Rng,
    at_s: f64,
}

impl Lab {
    fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let roster = roster(&mut random);
        Self { vehicles: Vehicles::new(roster.clone(), Limits::default()), roster, random, at_s: 0.0 }
    }

    /// The next fix, where the body of module i comes with the label of module `label(i)` and is moved by `moved(i)`.
    fn step(&mut self, label: impl Fn(u16) -> u16, moved: impl Fn(u16) -> Vector3<f64>) -> Sighting {
        self.at_s += 0.01;
        let normal = |sigma: f64| Normal::new(0.0, sigma).expect("a width");
        let bodies = (1..=COUNT).zip(self.roster.entries()).map(|(module, entry)| {
            let mut vehicle = truth(module, self.at_s);
            vehicle.position += moved(module);
            let mut body = entry.body_of_vehicle(&vehicle);
            body.position += Vector3::from_fn(|_, _| normal(0.002).sample(&mut self.random));
            let noise = Vector3::from_fn(|_, _| normal(0.01).sample(&mut self.random));
            body.attitude *= UnitQuaternion::from_scaled_axis(noise);
            (Label::new(i32::from(label(module)), "rov"), swap_world_and_ned(&body))
        });
        let bodies = bodies.collect();
        self.vehicles.take(&Fix {
            number: None,
            captured_s: self.at_s,
            arrived_s: self.at_s,
            late_s: 0.0,
            bodies,
        })
    }

    /// Every vehicle is where it should be, as fast as it should be.
    fn right(&self, seen: &Sighting, seed: u64) {
        assert_eq!(seen.seen.len(), usize::from(COUNT), "seed {seed}");
        for (module, motion) in &seen.seen {
            let pose = truth(*module, self.at_s);
            let off_m = (motion.pose.position - pose.position).norm();
            let off_rad = motion.pose.attitude.angle_to(&pose.attitude);
            assert!(off_m < 0.01 && off_rad < 0.05, "seed {seed}, module {module}: {off_m} m, {off_rad} rad");
            let velocity = Vector3::new(0.1, -0.05, 0.02 * f64::from(*module));
            let off_m_s = (motion.velocity_m_s - velocity).norm();
            assert!(off_m_s < 0.06, "seed {seed}, module {module}: {off_m_s} m/s");
        }
    }
}

fn still(_: u16) -> Vector3<f64> {
    Vector3::zeros()
}

/// Modules 2 and 3 with each other's label.
fn swap(module: u16) -> u16 {
    match module {
        2 => 3,
        3 => 2,
        other => other,
    }
}

#[test]
fn swapped_labels_are_named_and_the_vehicles_followed_until_they_are_swapped_back() {
    for seed in 0..50 {
        let mut lab = Lab::new(seed);
        for _ in 0..200 {
            let seen = lab.step(|module| module, still);
            assert!(seen.swapped.is_empty() && seen.carried.is_empty(), "seed {seed}: {seen:?}");
        }
        for _ in 0..100 {
            let seen = lab.step(swap, still);
            assert_eq!(
                (seen.swapped.as_slice(), seen.carried.len()),
                ([(2, 3)].as_slice(), 0),
                "seed {seed}"
            );
            lab.right(&seen, seed);
        }
        for _ in 0..100 {
            let seen = lab.step(|module| module, still);
            assert!(seen.swapped.is_empty() && seen.carried.is_empty(), "seed {seed}: {seen:?}");
            lab.right(&seen, seed);
        }
    }
}

#[test]
fn a_vehicle_that_is_carried_is_named_once_and_followed_from_there() {
    for seed in 0..50 {
        let mut lab = Lab::new(seed);
        for _ in 0..200 {
            lab.step(|module| module, still);
        }
        let away = |module| if module == 1 { Vector3::new(0.0, 2.0, 0.0) } else { Vector3::zeros() };
        let first = lab.step(|module| module, away);
        assert_eq!((first.carried.as_slice(), first.swapped.len()), ([1].as_slice(), 0), "seed {seed}");
        for _ in 0..200 {
            let seen = lab.step(|module| module, away);
            assert!(seen.carried.is_empty() && seen.swapped.is_empty(), "seed {seed}: {seen:?}");
        }
        let motion = lab.vehicles.at(1, lab.at_s).expect("a motion");
        let right = truth(1, lab.at_s).position + Vector3::new(0.0, 2.0, 0.0);
        assert!((motion.pose.position - right).norm() < 0.01, "seed {seed}");
        assert_eq!(lab.vehicles.at(9, 0.0), None);
    }
}
