use std::f64::consts::FRAC_PI_2;

use super::*;

fn bluerov1() -> Vehicle {
    Vehicle::built_in("bluerov1").unwrap()
}

fn near(a: &[f64], b: &[f64]) {
    assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} is not {b:?}");
}

#[test]
fn columns_of_a_bluerov1_are_those_worked_out_by_hand() {
    let t = ConfigurationMatrix::of_vehicle(&bluerov1()).unwrap();
    let column = |k: usize| t.matrix().column(k).iter().copied().collect::<Vec<_>>();
    // Starboard forward thruster, (0, 0.109, 0.02) × (1, 0, 0) = (0, 0.02, −0.109): turns to port.
    near(&column(0), &[1.0, 0.0, 0.0, 0.0, 0.02, -0.109]);
    // Front starboard, pushing down at (0.165, 0.11): rolls to starboard, bow down.
    near(&column(2), &[0.0, 0.0, 1.0, 0.11, -0.165, 0.0]);
    near(&column(4), &[0.0, 0.0, 1.0, 0.0, 0.185, 0.0]);
    // Lateral, pushing to port at (0.028, 0, 0.127).
    near(&column(5), &[0.0, -1.0, 0.0, 0.127, 0.0, -0.028]);
    t.require_full_rank().unwrap();
    near(&t.wrench(&[2.0, 2.0, 0.0, 0.0, 0.0, 0.0]), &[4.0, 0.0, 0.0, 0.0, 0.08, 0.0]);
}

#[test]
fn a_robot_turned_to_starboard_pushes_to_starboard_at_its_place() {
    let robot = bluerov1();
    let pose = Pose { position_m: [2.0, 3.0, 1.0], yaw_rad: FRAC_PI_2 };
    let origin = Pose { position_m: [1.0, 3.0, 0.5], yaw_rad: 0.0 };
    let t = ConfigurationMatrix::of_cluster(&[(&robot, pose)], &origin).unwrap();
    // Thruster 1: e = y, l = (−0.109, 0, 0.02) + (1, 0, 0.5); l × e = (−0.52, 0, 0.891).
    let column: Vec<f64> = t.matrix().column(0).iter().copied().collect();
    near(&column, &[0.0, 1.0, 0.0, -0.52, 0.0, 0.891]);
}

#[test]
fn a_cluster_seen_in_its_own_frame_does_not_depend_on_where_it_lies() {
    let robot = bluerov1();
    let poses = [[0.483, 0.0, 0.0, 0.3], [-0.2, 0.33, 0.1, -1.2]];
    let here = poses.map(|pose| (&robot, Pose::from(pose)));
    let (turn, shift) = (0.7_f64, [4.0, -2.0, 3.0]);
    let there = poses.map(|[x, y, z, yaw]| {
        let (s, c) = turn.sin_cos();
        (&robot, Pose::from([c * x - s * y + shift[0], s * x + c * y + shift[1], z + shift[2], yaw + turn]))
    });
    let a = ConfigurationMatrix::of_cluster(&here, &Pose::default()).unwrap();
    let b = ConfigurationMatrix::of_cluster(&there, &Pose { position_m: shift, yaw_rad: turn }).unwrap();
    assert_eq!(a.thrusters(), 12);
    near(a.matrix().as_slice(), b.matrix().as_slice());
}

#[test]
fn what_cannot_be_pushed_is_named() {
    let mut robot = bluerov1();
    robot.thrusters.remove(5);
    let t = ConfigurationMatrix::of_vehicle(&robot).unwrap();
    let error = t.require_full_rank().unwrap_err();
    assert_eq!(error.to_string(), "thruster matrix of rank 5: cannot push in sway");
    // Both forward thrusters gone: neither surge nor yaw.
    robot = bluerov1();
    robot.thrusters.drain(0..2);
    let error = ConfigurationMatrix::of_vehicle(&robot).unwrap().require_full_rank().unwrap_err();
    assert!(
        error.to_string().starts_with("thruster matrix of rank 4: cannot push in surge, a combination of"),
        "{error}"
    );
    // One vertical thruster lost couples heave, roll and pitch.
    robot = bluerov1();
    robot.thrusters.remove(3);
    let error = ConfigurationMatrix::of_vehicle(&robot).unwrap().require_full_rank().unwrap_err();
    assert!(error.to_string().contains("rank 5") && error.to_string().contains("heave"), "{error}");
    // A tool has none.
    robot.thrusters.clear();
    let error = ConfigurationMatrix::of_vehicle(&robot).unwrap().require_full_rank().unwrap_err();
    let all = "thruster matrix of rank 0: cannot push in surge, sway, heave, roll, pitch, yaw";
    assert_eq!(error.to_string(), all);
}

#[test]
fn bad_thrusters_are_refused_by_name() {
    let mut robot = bluerov1();
    robot.thrusters[1].direction = [0.0, 0.5, 0.0];
    let error = ConfigurationMatrix::of_vehicle(&robot).unwrap_err();
    assert_eq!(
        error.to_string(),
        "thruster 2 of BlueROV1: its direction has length 0.5, a unit vector is asked for"
    );
    robot.thrusters[1].direction = [f64::NAN, 0.0, 0.0];
    assert!(ConfigurationMatrix::of_vehicle(&robot).is_err());
    robot = bluerov1();
    robot.thrusters[3].position_m[2] = f64::INFINITY;
    let error = ConfigurationMatrix::of_vehicle(&robot).unwrap_err();
    assert!(error.to_string().starts_with("thruster 4 of BlueROV1: its position"), "{error}");
}
