//! Structures found from noisy bodies: subsets, swapped labels, modules that have broken away.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Rotation2, UnitQuaternion, Vector2, Vector3};
use pose::axes::Pose;
use pose::frame::Label;
use pose::roster::{Entry, Name, Roster};
use pose::structure::{Found, Outcome, PlanarPose, Structure, Tolerances};
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

const PITCH_M: f64 = 0.15;

/// A structure, its roster, and the truth about where it is.
struct Lab {
    structure: Structure,
    roster: Roster,
    places: Vec<(u16, Vector2<f64>)>,
    truth: PlanarPose,
    random: ChaCha8Rng,
}

impl Lab {
    /// `columns` × `rows` modules with bodies mounted anywhere on them, somewhere in the water.
    fn new(columns: u16, rows: u16, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let cells: Vec<Vector2<f64>> = (0..columns * rows)
            .map(|at| PITCH_M * Vector2::new(f64::from(at % columns), f64::from(at / columns)))
            .collect();
        let mean = cells.iter().sum::<Vector2<f64>>() / f64::from(columns * rows);
        let places: Vec<(u16, Vector2<f64>)> = (1..).zip(cells.iter().map(|cell| cell - mean)).collect();
        let entries = places.iter().map(|&(module, _)| Entry {
            module,
            body: Name::Name(format!("boat {module}")),
            offset_m: Vector3::new(
                random.random_range(-0.05..0.05),
                random.random_range(-0.05..0.05),
                random.random_range(0.0..0.1),
            ),
            // Two bodies turned against each other by half a turn could be exchanged and the structure turned about, unseen.
            turn_rad: random.random_range(-1.0..1.0),
        });
        let roster = Roster::new(entries.collect()).expect("a sound roster");
        let truth = PlanarPose {
            position_m: Vector2::new(random.random_range(-3.0..3.0), random.random_range(-3.0..3.0)),
            heading_rad: random.random_range(-PI..PI),
        };
        let structure = Structure::new(roster.clone(), &places, Tolerances::default());
        Self { structure, roster, places, truth, random }
    }

    /// The body of a module that is `moved` and `turned` from its place, tilted a little by waves, seen with noise.
    fn body(&mut self, at: usize, moved: Vector2<f64>, turned: f64) -> (Label, Pose) {
        let (module, place) = self.places[at];
        let angle = self.truth.heading_rad - FRAC_PI_2;
        let pivot = self.truth.position_m + Rotation2::new(angle) * place + moved;
        let tilt = UnitQuaternion::from_euler_angles(
            self.random.random_range(-0.02..0.02),
            self.random.random_range(-0.02..0.02),
            0.0,
        );
        let module_pose = Pose {
            position: Vector3::new(pivot.x, pivot.y, 0.0),
            attitude: UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle + turned) * tilt,
        };
        let mut body = self.roster.entries()[at].body_of_boat(&module_pose);
        let mut noise = |sigma| Normal::new(0.0, sigma).expect("a width").sample(&mut self.random);
        body.position += Vector3::new(noise(0.002), noise(0.002), noise(0.002));
        body.attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), noise(0.01)) * body.attitude;
        (Label::named(&format!("boat {module}")), body)
    }

    fn bodies(&mut self) -> Vec<(Label, Pose)> {
        (0..self.places.len()).map(|at| self.body(at, Vector2::zeros(), 0.0)).collect()
    }

    /// Where the run thinks the structure is: a few centimetres off.
    fn expected(&mut self) -> PlanarPose {
        let mut pose = self.truth;
        pose.position_m += Vector2::new(self.random.random_range(-0.03..0.03), 0.02);
        pose.heading_rad += self.random.random_range(-0.1..0.1);
        pose
    }

    fn found(&self, bodies: &[(Label, Pose)], expected: Option<&PlanarPose>, seed: u64) -> Found {
        match self.structure.locate(bodies, expected) {
            Outcome::Found(found) => found,
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

fn off(found: &PlanarPose, right: &PlanarPose) -> (f64, f64) {
    let turned = (found.heading_rad - right.heading_rad + PI).rem_euclid(TAU) - PI;
    ((found.position_m - right.position_m).norm(), turned.abs())
}

#[test]
fn any_subset_from_one_body_on_gives_the_pose() {
    for seed in 0..200 {
        let mut lab = Lab::new(3, 2, seed);
        let mut bodies = lab.bodies();
        bodies.shuffle(&mut lab.random);
        for count in 1..=bodies.len() {
            let found = lab.found(&bodies[..count], None, seed);
            let (off_m, off_rad) = off(&found.pose, &lab.truth);
            // One body's heading noise of 0.01 rad acts over 0.2 m.
            assert!(off_m < 0.015 && off_rad < 0.05, "seed {seed}, {count} bodies: {off_m} m, {off_rad} rad");
            assert_eq!(found.used.len(), count, "seed {seed}");
            assert!(found.swapped.is_empty() && found.astray.is_empty(), "seed {seed}: {found:?}");
        }
    }
}

#[test]
fn more_bodies_make_it_more_exact() {
    let (mut one, mut all) = (0.0, 0.0);
    for seed in 0..200 {
        let mut lab = Lab::new(3, 3, seed);
        let bodies = lab.bodies();
        one += off(&lab.found(&bodies[..1], None, seed).pose, &lab.truth).0.powi(2);
        all += off(&lab.found(&bodies, None, seed).pose, &lab.truth).0.powi(2);
    }
    let [one_m, all_m] = [one, all].map(|squares: f64| (squares / 200.0).sqrt());
    // Nine bodies of 2 mm noise in two axes: 2·√2/3 mm.
    assert!(all_m < 0.0013, "{all_m} m");
    assert!(one_m > 2.0 * all_m, "{one_m} m and {all_m} m");
}

#[test]
fn swapped_labels_are_named_and_the_pose_stays() {
    for seed in 0..200 {
        for (columns, rows) in [(2, 1), (3, 1), (2, 2), (4, 3)] {
            let mut lab = Lab::new(columns, rows, seed);
            let mut bodies = lab.bodies();
            let count = bodies.len();
            let (a, b) = (lab.random.random_range(0..count), lab.random.random_range(1..count));
            let b = (a + b) % count;
            let (first, second) = (bodies[a].0.clone(), bodies[b].0.clone());
            (bodies[a].0, bodies[b].0) = (second, first);
            let expected = lab.expected();
            for expected in [None, Some(&expected)] {
                let found = lab.found(&bodies, expected, seed);
                let pair = (lab.places[a.min(b)].0, lab.places[a.max(b)].0);
                assert_eq!(found.swapped, [pair], "seed {seed}, {columns}×{rows}");
                assert!(found.astray.is_empty(), "seed {seed}: {found:?}");
                let (off_m, off_rad) = off(&found.pose, &lab.truth);
                assert!(off_m < 0.01 && off_rad < 0.03, "seed {seed}: {off_m} m, {off_rad} rad");
            }
        }
    }
}

#[test]
fn a_module_that_has_broken_away_is_named_and_the_pose_stays() {
    for seed in 0..200 {
        for (columns, rows) in [(3, 1), (2, 2), (4, 3)] {
            let mut lab = Lab::new(columns, rows, seed);
            let mut bodies = lab.bodies();
            let gone = lab.random.random_range(0..bodies.len());
            let turned = lab.random.random_range(0.3..PI);
            bodies[gone] = lab.body(gone, Vector2::new(0.06, -0.05), turned);
            let found = lab.found(&bodies, None, seed);
            let astray: Vec<u16> = found.astray.iter().map(|one| one.module).collect();
            assert_eq!(astray, [lab.places[gone].0], "seed {seed}, {columns}×{rows}: {found:?}");
            assert!((found.astray[0].off_m - 0.078).abs() < 0.03, "seed {seed}: {found:?}");
            assert!(found.swapped.is_empty(), "seed {seed}: {found:?}");
            let (off_m, off_rad) = off(&found.pose, &lab.truth);
            assert!(off_m < 0.01 && off_rad < 0.03, "seed {seed}: {off_m} m, {off_rad} rad");
        }
    }
}

#[test]
fn of_two_bodies_that_contradict_each_other_the_expected_one_is_right() {
    for seed in 0..200 {
        let mut lab = Lab::new(2, 1, seed);
        let bodies = vec![lab.body(0, Vector2::zeros(), 0.0), lab.body(1, Vector2::new(0.3, 0.4), 0.5)];
        assert_eq!(lab.structure.locate(&bodies, None), Outcome::Contradiction(vec![1, 2]), "seed {seed}");
        let expected = lab.expected();
        let found = lab.found(&bodies, Some(&expected), seed);
        assert_eq!(found.used, [1], "seed {seed}");
        assert_eq!(found.astray.iter().map(|one| one.module).collect::<Vec<_>>(), [2], "seed {seed}");
    }
}

#[test]
fn a_structure_that_has_broken_in_two_halves_is_a_contradiction() {
    for seed in 0..50 {
        let mut lab = Lab::new(2, 2, seed);
        let bodies: Vec<(Label, Pose)> = (0..4)
            .map(|at| lab.body(at, if at < 2 { Vector2::zeros() } else { Vector2::new(0.2, 0.3) }, 0.0))
            .collect();
        assert_eq!(
            lab.structure.locate(&bodies, None),
            Outcome::Contradiction(vec![1, 2, 3, 4]),
            "seed {seed}"
        );
    }
}

#[test]
fn bodies_of_others_are_left_aside() {
    let lab = Lab::new(2, 1, 1);
    assert_eq!(lab.structure.locate(&[], None), Outcome::Unseen);
    let stranger = Pose { position: Vector3::zeros(), attitude: UnitQuaternion::identity() };
    assert_eq!(lab.structure.locate(&[(Label::named("chair"), stranger)], None), Outcome::Unseen);
}

#[test]
fn a_thousand_modules_with_one_astray_and_two_swapped() {
    let mut lab = Lab::new(40, 25, 3);
    let mut bodies = lab.bodies();
    bodies[17] = lab.body(17, Vector2::new(0.1, 0.0), 0.0);
    let (first, second) = (bodies[500].0.clone(), bodies[720].0.clone());
    (bodies[500].0, bodies[720].0) = (second, first);
    let found = lab.found(&bodies, None, 3);
    assert_eq!(found.swapped, [(501, 721)]);
    assert_eq!(found.astray.iter().map(|one| one.module).collect::<Vec<_>>(), [18]);
    let (off_m, off_rad) = off(&found.pose, &lab.truth);
    assert!(off_m < 1e-3 && off_rad < 1e-3, "{off_m} m, {off_rad} rad");
}
