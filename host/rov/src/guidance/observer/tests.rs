//! Against a body of the equations of motion alone: noise from a seed, fixes that come late.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use reconfiguration::vehicle::Vehicle;

use super::super::super::cluster::Cluster;
use super::*;

const STEP_S: f64 = 0.005;

/// Follows a body that `push` (body, N and N·m) acts on, which the observer does not know, by fixes of the given noise and latency. Both at the end.
fn followed(push: [f64; 6], noise: [f64; 2], late: usize, seed: u64) -> (State, Observer) {
    let robot = Vehicle::built_in("bluerov1").expect("built in");
    let dynamics = Dynamics::new(&Cluster::of(&robot.body)).expect("a body");
    let matrix = ConfigurationMatrix::of_vehicle(&robot).expect("thrusters");
    let mut truth = State::from_eta(&[1.0, 2.0, 3.0, 0.0, 0.0, 0.5], &[0.0; 6]);
    let mut observer = Observer::new(dynamics.clone(), matrix.clone(), truth);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut fixes = VecDeque::new();
    for step in 1..4000_u32 {
        let now_s = f64::from(step) * STEP_S;
        // Surge to and fro, as a leg does.
        let ahead_n = if (step / 400) % 2 == 0 { 1.5 } else { -1.5 };
        let thrusts_n = [ahead_n, ahead_n, 0.0, 0.0, 0.0, 0.0];
        let tau = Vector6::from(matrix.wrench(&thrusts_n)) + Vector6::from(push);
        dynamics.advance(&mut truth, &tau, STEP_S, STEP_S);
        observer.advance(now_s, STEP_S, Some(&thrusts_n));
        if step.is_multiple_of(2) {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            let position_m = truth.position_m + Vector3::from_fn(|_, _| noise[0] * normal());
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| noise[1] * normal()));
            fixes.push_back((now_s, position_m, truth.attitude * turn));
        }
        if fixes.len() > late {
            let (at_s, position_m, attitude) = fixes.pop_front().expect("one more");
            observer.take(at_s, &position_m, &attitude);
        }
    }
    (truth, observer)
}

/// With the right model and no noise nothing is left, however late the fixes are: planned accelerations cost no lag.
#[test]
fn a_known_body_is_known_exactly() {
    let (truth, observer) = followed([0.0; 6], [0.0; 2], 6, 1);
    let off_m = (observer.state().position_m - truth.position_m).norm();
    let off_nu = (observer.state().nu - truth.nu).norm();
    assert!(off_m < 1e-9 && off_nu < 1e-9, "{off_m} m, {off_nu}");
    assert!(observer.unknown().norm() < 1e-9);
}

/// A push that no model knows is found by its size, by late and noisy fixes.
#[test]
fn an_unknown_push_is_found() {
    for seed in 0..5 {
        let push = [0.0, 0.4, -0.6, 0.0, 0.0, 0.05];
        let (truth, observer) = followed(push, [0.002, 0.01], 3, seed);
        let found = observer.unknown_wrench();
        let off_m = (observer.state().position_m - truth.position_m).norm();
        println!("seed {seed}: {off_m:.4} m, wrench {found}");
        assert!(off_m < 5e-3, "seed {seed}: {off_m} m");
        for axis in 0..3 {
            assert!((found[axis] - push[axis]).abs() < 0.25, "seed {seed}, axis {axis}: {found}");
        }
        assert!((found[5] - push[5]).abs() < 0.03, "seed {seed}: {found}");
    }
}
