//! Every thruster of a robot, dead while it pushes; a push of the water that no thruster explains.

use nalgebra::Vector3;
use reconfiguration::vehicle::Vehicle;

use super::*;

const STEP_S: f64 = 0.005;

/// Thrusts in force while a robot moves about, N.
fn thrusts_n(t_s: f64) -> [f64; 6] {
    [0, 1, 2, 3, 4, 5].map(|k| 1.0 + 0.5 * (0.7 * t_s + f64::from(k)).sin())
}

/// Ten seconds of life, then what `after` says that acts beside the thrusts; the observer's own three lags. Which was found, and when.
fn watched(after: impl Fn(f64, &[f64; 6]) -> Vector6<f64>) -> Option<(usize, f64)> {
    let robot = Vehicle::built_in("bluerov1").expect("built in");
    let matrix = ConfigurationMatrix::of_vehicle(&robot).expect("thrusters");
    let mut residual = Residual::new(6);
    let mut lags = [Vector6::zeros(); 3];
    for step in 0..4000 {
        let t_s = f64::from(step) * STEP_S;
        let thrusts_n = thrusts_n(t_s);
        let mut pushed = if t_s < 10.0 { Vector6::zeros() } else { after(t_s, &thrusts_n) };
        for stage in &mut lags {
            *stage += (pushed - *stage) * (BANDWIDTH_RAD_S * STEP_S);
            pushed = *stage;
        }
        if let Some(found) = residual.update(STEP_S, &matrix, &pushed, &thrusts_n) {
            return Some((found, t_s));
        }
    }
    None
}

#[test]
fn every_dead_thruster_is_found_within_five_seconds() {
    let robot = Vehicle::built_in("bluerov1").expect("built in");
    let matrix = ConfigurationMatrix::of_vehicle(&robot).expect("thrusters");
    for dead in 0..6 {
        let column = matrix.matrix().column(dead).into_owned();
        let (found, at_s) = watched(|_, thrusts_n| -column * thrusts_n[dead]).expect("found");
        println!("thruster {dead}: found {found} after {:.2} s", at_s - 10.0);
        assert_eq!(found, dead);
        assert!(at_s < 15.0, "thruster {dead}: {at_s} s");
    }
}

#[test]
fn a_push_of_the_water_is_no_dead_thruster() {
    for push in [Vector3::new(0.8, 0.0, 0.0), Vector3::new(0.0, -0.9, 0.0), Vector3::new(0.3, 0.3, 0.8)] {
        let found = watched(|_, _| Vector6::new(push.x, push.y, push.z, 0.0, 0.0, 0.0));
        assert_eq!(found, None, "{push}");
    }
}
