//! Velocities from noisy fixes against motions whose velocities are known.

use nalgebra::{UnitQuaternion, Vector3};
use pose::axes::Pose;
use pose::velocity::{Motion, Tracker};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};

const BANDWIDTH: f64 = 10.0;
const PERIOD_S: f64 = 0.01;

/// Steady turn about an axis of its own and constant acceleration.
fn truth(at_s: f64) -> Motion {
    let (velocity, acceleration) = (Vector3::new(0.3, -0.1, 0.05), Vector3::new(0.02, 0.05, -0.01));
    let rates = Vector3::new(0.1, -0.2, 0.6);
    Motion {
        at_s,
        pose: Pose {
            position: Vector3::new(1.0, 2.0, 3.0) + velocity * at_s + acceleration * (at_s * at_s / 2.0),
            attitude: UnitQuaternion::from_euler_angles(0.3, 0.2, -2.0)
                * UnitQuaternion::from_scaled_axis(rates * at_s),
        },
        velocity_m_s: velocity + acceleration * at_s,
        rates_rad_s: rates,
    }
}

fn noisy(pose: &Pose, random: &mut ChaCha8Rng, sigma_m: f64, sigma_rad: f64) -> Pose {
    let mut three = |sigma: f64| {
        let normal = Normal::new(0.0, sigma).expect("a width");
        Vector3::from_fn(|_, _| normal.sample(random))
    };
    Pose {
        position: pose.position + three(sigma_m),
        attitude: pose.attitude * UnitQuaternion::from_scaled_axis(three(sigma_rad)),
    }
}

#[test]
fn constant_acceleration_and_a_steady_turn_are_followed_without_lag() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut tracker = Tracker::new(BANDWIDTH);
    let mut at_s = 0.0;
    for _ in 0..1000 {
        tracker.take(at_s, &truth(at_s).pose);
        // The rate of frames is not steady, and one in ten is lost.
        at_s += PERIOD_S * random.random_range(0.5..1.5) * if random.random_bool(0.1) { 2.0 } else { 1.0 };
    }
    assert!(tracker.is_settled());
    let (found, right) = (tracker.at(at_s).expect("a motion"), truth(at_s));
    assert!((found.velocity_m_s - right.velocity_m_s).norm() < 1e-3, "{found:?} for {right:?}");
    assert!((found.rates_rad_s - right.rates_rad_s).norm() < 1e-3, "{found:?} for {right:?}");
    assert!((found.pose.position - right.pose.position).norm() < 1e-4);
    assert!(found.pose.attitude.angle_to(&right.pose.attitude) < 1e-4);
}

#[test]
fn noise_of_the_velocity_is_as_documented() {
    let (sigma_m, sigma_rad) = (0.002, 0.01);
    let theta: f64 = (-BANDWIDTH * PERIOD_S).exp();
    let share =
        (1.0 - theta).powi(3) * (49.0 + 50.0 * theta + 13.0 * theta * theta) / (2.0 * (1.0 + theta).powi(5));
    let documented = sigma_m / PERIOD_S * share.sqrt();
    assert!((documented - 0.0087).abs() < 1e-3, "{documented} m/s");
    for seed in 0..5 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut tracker = Tracker::new(BANDWIDTH);
        let (mut squares, mut turns, mut count) = (0.0, 0.0, 0.0);
        for frame in 0..20_000 {
            let at_s = PERIOD_S * f64::from(frame);
            tracker.take(at_s, &noisy(&truth(at_s).pose, &mut random, sigma_m, sigma_rad));
            if frame > 500 {
                let (found, right) = (tracker.at(at_s).expect("a motion"), truth(at_s));
                squares += (found.velocity_m_s - right.velocity_m_s).norm_squared() / 3.0;
                turns += (found.rates_rad_s - right.rates_rad_s).norm_squared() / 3.0;
                count += 1.0;
            }
        }
        let [found, turning] = [squares, turns].map(|sum: f64| (sum / count).sqrt());
        assert!((found / documented - 1.0).abs() < 0.1, "seed {seed}: {found} m/s for {documented}");
        let documented_turning = documented * sigma_rad / sigma_m;
        assert!((turning / documented_turning - 1.0).abs() < 0.1, "seed {seed}: {turning} rad/s");
    }
}

#[test]
fn the_first_second_is_better_than_fading_gains_from_rest_would_be() {
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut tracker = Tracker::new(2.0);
        for frame in 0..100 {
            let at_s = PERIOD_S * f64::from(frame);
            tracker.take(at_s, &noisy(&truth(at_s).pose, &mut random, 0.002, 0.01));
        }
        let (found, right) = (tracker.at(0.99).expect("a motion"), truth(0.99));
        assert!(!tracker.is_settled(), "two radians a second need more than one second");
        assert!(
            (found.velocity_m_s - right.velocity_m_s).norm() < 0.02,
            "seed {seed}: {found:?} for {right:?}"
        );
        assert!((found.rates_rad_s - right.rates_rad_s).norm() < 0.1, "seed {seed}: {found:?} for {right:?}");
    }
}

#[test]
fn doubled_and_older_fixes_are_left_aside_and_a_long_gap_begins_again() {
    let mut tracker = Tracker::new(BANDWIDTH);
    assert_eq!(tracker.at(0.0), None);
    for frame in 0..200 {
        let at_s = PERIOD_S * f64::from(frame);
        tracker.take(at_s, &truth(at_s).pose);
        tracker.take(at_s, &truth(0.0).pose);
        tracker.take(at_s - 0.05, &truth(at_s - 0.05).pose);
    }
    assert!((tracker.at(1.99).expect("a motion").velocity_m_s - truth(1.99).velocity_m_s).norm() < 1e-6);
    tracker.take(4.0, &truth(4.0).pose);
    let again = tracker.at(4.0).expect("a motion");
    assert_eq!((again.velocity_m_s, again.pose), (Vector3::zeros(), truth(4.0).pose));
    assert!(!tracker.is_settled());
}
