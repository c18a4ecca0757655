//! Balances by hand: the tool of the paper asks for 0.6 N·m of pitch.

use super::*;
use crate::power;

const BATTERY_V: f64 = 16.0;

fn vehicle(name: &str) -> Vehicle {
    Vehicle::built_in(name).expect("it comes with the program")
}

fn balanced(bodies: &[(Pose, &Vehicle)]) -> Result<Balance, Unbalanced> {
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    balance(bodies, &law, power::limits_n(BATTERY_V).expect("in the table"), &Rules::default())
}

fn at(x: f64, y: f64) -> Pose {
    [x, y, 0.0, 0.0].into()
}

#[test]
fn one_robot_holds_the_tool_with_its_upright_thrusters() {
    let (robot, tool) = (vehicle("bluerov1"), vehicle("tool-20n"));
    let balance = balanced(&[(at(0.0, 0.0), &tool), (at(-0.483, 0.0), &robot)]).expect("a balance");
    // 2a + b = 0 and 0.165·2a − 0.185·b = −0.6 N·m: the two before lift, the one behind pushes down.
    let [a, b] = [-0.3 / 0.35, 0.6 / 0.35];
    let expected = [0.0, 0.0, a, a, b, 0.0];
    let [none, found] = balance.thrusts_n.as_slice() else { panic!("two bodies: {balance:?}") };
    assert!(none.is_empty());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{:?} {expected}", balance.thrusts_n);
    }
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    let power_w = 2.0 * law.power_w(a) + law.power_w(b);
    assert!((balance.power_w - power_w).abs() < 1e-4 && (power_w - 3.2).abs() < 0.05, "{balance:?}");
    // More robots need less power: a second robot in line halves the arms.
    let two = [(at(0.0, 0.0), &tool), (at(-0.483, 0.0), &robot), (at(0.483, 0.0), &robot)];
    let two = balanced(&two).expect("a balance");
    assert!(two.power_w > 0.0 && two.power_w < 0.5 * power_w, "{two:?}");
}

#[test]
fn what_feels_nothing_draws_nothing() {
    let robot = vehicle("bluerov1");
    let bodies = [(at(0.0, 0.0), &robot), (at(0.483, 0.0), &robot), (at(3.0, 0.0), &robot)];
    let balance = balanced(&bodies).expect("a balance");
    assert_eq!(balance, Balance { power_w: 0.0, thrusts_n: vec![vec![0.0; 6]; 3] });
}

#[test]
fn clusters_are_balanced_each_on_its_own() {
    let (robot, tool) = (vehicle("bluerov1"), vehicle("tool-20n"));
    let near = [(at(0.0, 0.0), &tool), (at(-0.483, 0.0), &robot)];
    let alone = balanced(&near).expect("a balance");
    // A robot that is docked to no other is no help.
    let apart = [near[0], near[1], (at(3.0, 0.0), &robot)];
    let apart = balanced(&apart).expect("a balance");
    assert!((apart.power_w - alone.power_w).abs() < 1e-12);
    assert_eq!(apart.thrusts_n, [alone.thrusts_n, vec![vec![0.0; 6]]].concat());
}

#[test]
fn a_tool_alone_and_a_tool_too_heavy_are_refused() {
    let (robot, mut tool) = (vehicle("bluerov1"), vehicle("tool-20n"));
    let alone = balanced(&[(at(3.0, 0.0), &robot), (at(0.0, 0.0), &tool)]);
    assert_eq!(alone, Err(Unbalanced::Alone(1)));
    // 20 N at 5 m: 100 N·m. The thruster behind, 0.35 m behind the two before, gives 51.4 N at most: 18.0 N·m.
    tool.body.r_g_m = [5.0, 0.0, 0.0];
    match balanced(&[(at(0.0, 0.0), &tool), (at(-0.483, 0.0), &robot)]) {
        Err(Unbalanced::OutOfReach { body: 0, served }) => {
            assert!((served - 0.18).abs() < 1e-3, "{served}");
        }
        other => panic!("{other:?}"),
    }
}

/// One robot in a current along its x axis: two thrusters ahead hold 4.03·v + 18.18·v², worked by hand; its moment, 2 cm of arm, goes to
/// the upright ones. In a row of three each has the same drag.
#[test]
fn what_waits_in_a_current_holds_against_its_drag() {
    let robot = vehicle("bluerov1");
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    let limits_n = power::limits_n(BATTERY_V).expect("in the table");
    let drag_n = 4.03 * 0.2 + 18.18 * 0.2 * 0.2;
    let alone = balance_in([0.2, 0.0, 0.0], &[(at(0.0, 0.0), &robot)], &law, limits_n, &Rules::default())
        .expect("a balance");
    let thrusts_n = &alone.thrusts_n[0];
    // The water comes from behind: they push back.
    assert!((thrusts_n[0] + 0.5 * drag_n).abs() < 1e-9 && (thrusts_n[1] + 0.5 * drag_n).abs() < 1e-9);
    // Turned about, the same robot pushes ahead, and a current is one whichever way the world is turned.
    for turn in [0.0, 1.0, -2.5_f64] {
        let current = [-0.2 * turn.cos(), -0.2 * turn.sin(), 0.0];
        let there = [0.3, -0.2, 0.0, turn].into();
        let turned =
            balance_in(current, &[(there, &robot)], &law, limits_n, &Rules::default()).expect("a balance");
        assert!((turned.thrusts_n[0][0] - 0.5 * drag_n).abs() < 1e-9, "{turned:?}");
    }
    let row = [(at(0.0, 0.0), &robot), (at(0.483, 0.0), &robot), (at(0.966, 0.0), &robot)];
    let row = balance_in([0.2, 0.0, 0.0], &row, &law, limits_n, &Rules::default()).expect("a balance");
    let ahead_n: f64 = row.thrusts_n.iter().map(|own| own[0] + own[1]).sum();
    assert!((ahead_n + 3.0 * drag_n).abs() < 1e-6, "{row:?}");
    let still = balance_in([0.0; 3], &[(at(0.0, 0.0), &robot)], &law, limits_n, &Rules::default())
        .expect("a balance");
    assert!(still.power_w.abs() < 1e-15, "{still:?}");
}

#[test]
fn two_clusters_are_refused_where_one_is_asked_for() {
    let robot = vehicle("bluerov1");
    let bodies = [(at(0.0, 0.0), &robot), (at(0.483, 0.0), &robot), (at(3.0, 0.0), &robot)];
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    let limits_n = power::limits_n(BATTERY_V).expect("in the table");
    let rules = Rules { one_cluster: true, ..Rules::default() };
    assert_eq!(balance(&bodies, &law, limits_n, &rules), Err(Unbalanced::Apart(0, 2)));
    assert!(balance(&bodies[..2], &law, limits_n, &rules).is_ok());
}

#[test]
fn stability_takes_the_pitch_that_no_thruster_of_a_bluerov2_can() {
    // A tool that pitches by 0.3 N·m under a robot of 112.8 N with its centre of gravity 2 cm down: sin θ = 0.3/2.2556.
    let (robot, mut tool) = (vehicle("bluerov2"), vehicle("tool-20n"));
    tool.body.r_g_m = [0.015, 0.0, 0.0];
    let bodies = [(at(0.0, 0.0), &tool), (at(-0.47, 0.0), &robot)];
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    let limits_n = power::limits_n(BATTERY_V).expect("in the table");
    let with =
        |tilt_limit_rad: f64| balance(&bodies, &law, limits_n, &Rules { tilt_limit_rad, ..Rules::default() });
    // The heave of −2 N of the robot stands 0.47 m behind the tool; about the robot itself it pitches nothing.
    let tilt_rad = (0.3_f64 / (11.5 * 9.80665 * 0.02)).asin();
    let held = with(tilt_rad + 1e-3).expect("within the limit");
    let [_, thrusts_n] = held.thrusts_n.as_slice() else { panic!("two bodies: {held:?}") };
    // Buoyant by 2 N, and up is where the two push: one newton down each.
    assert!((thrusts_n[4] + 1.0).abs() < 1e-6 && (thrusts_n[5] + 1.0).abs() < 1e-6, "{thrusts_n:?}");
    match with(tilt_rad - 1e-3) {
        Err(Unbalanced::OutOfReach { body: 0, served }) => assert!(served > 0.9, "{served}"),
        other => panic!("{other:?}"),
    }
}
