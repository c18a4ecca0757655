//! Check of v6: thrusts of the waiting robots against weight and buoyancy of their cluster.
//!
//! ```text
//! F_g = Σ (0, 0, W_i − B_i),   M_g = Σ r_Gi × (0, 0, W_i) − r_Bi × (0, 0, B_i)          (3)–(5), level
//! F_u = Σ R_z(ψ)·e·u,          M_u = Σ (p + R_z(ψ)·l) × R_z(ψ)·e·u                      (16)
//! F_c = Σ R_z(ψ)·(d_l + d_q|c_i|)·c_i,   M_c = Σ p × F_c,i − R_z(ψ)·(c_i × M_A c_i),   c_i = R_z(ψ)ᵀc
//! F_g + F_u + F_c = 0,   M_g + M_u + M_c = 0,   or |M_x, M_y left| ≤ sin θ · Σ (z_G W − z_B B) at the limit of tilt θ
//! ```
//!
//! F_c, M_c are what a current c of the rules does to bodies at rest: drag and the Munk moment. All vectors are in the world (north-east-down), from the mean of the cluster's body origins. With W = m·g and
//! W − B given, B follows. The limits of thrust are the ends of the measured T200 table at the battery's voltage,
//! between two of its voltages in proportion.

use std::collections::BTreeMap;

use reconfiguration::plan::Holding;

use super::{Body, Condition, Judge};

/// Standard gravity, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;
/// What may be left of a balance, as a share of what is balanced and of what is pushed.
const SHARE: f64 = 1e-6;
/// Voltage, pulse width, speed, current, power, thrust in kgf.
const T200: &str = include_str!("../../data/t200_2019.csv");

type Vector = [f64; 3];

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn size(v: Vector) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Looks at what is pushed while `resting` wait: from a time on, in a move or in no single one.
pub(super) fn check(
    judge: &mut Judge<'_>,
    (index, start_s): (Option<usize>, f64),
    balance: &[Holding],
    (resting, cluster): (&[Body<'_>], &[usize]),
) {
    let mut wrong = Vec::new();
    let limits_n = limits_n(judge.problem.rules.battery_v);
    let mut thrusts: Vec<Option<&[f64]>> = vec![None; resting.len()];
    for holding in balance {
        let name = format!("robot {}", holding.robot);
        let Some(body) = resting.iter().position(|body| body.name == name) else {
            wrong.push((Condition::V6, format!("{name} is to balance and does not wait")));
            continue;
        };
        let (given, fitted) = (holding.thrusts_n.len(), resting[body].vehicle.thrusters.len());
        if given != fitted {
            wrong.push((Condition::V6, format!("{name}: {given} thrusts for {fitted} thrusters")));
            continue;
        }
        if thrusts[body].replace(&holding.thrusts_n).is_some() {
            wrong.push((Condition::V6, format!("{name} balances twice")));
        }
        let thrusters = &resting[body].vehicle.thrusters;
        for (number, &thrust_n) in holding.thrusts_n.iter().enumerate() {
            let failed = thrusters.get(number).is_some_and(|thruster| thruster.failed);
            match limits_n {
                _ if failed && thrust_n.abs() > SHARE => {
                    let message =
                        format!("{name}: thruster {} is out of order and pushes {thrust_n:.3} N", number + 1);
                    wrong.push((Condition::Thrusters, message));
                }
                Some([least_n, greatest_n])
                    if thrust_n < least_n - SHARE || thrust_n > greatest_n + SHARE =>
                {
                    let message = format!(
                        "{name}: thruster {} pushes {thrust_n:.3} N, from {least_n:.3} to {greatest_n:.3} N can",
                        number + 1
                    );
                    wrong.push((Condition::Thrusters, message));
                }
                _ => {}
            }
        }
    }
    if limits_n.is_none() {
        let volts = judge.problem.rules.battery_v;
        wrong.push((Condition::Thrusters, format!("{volts} V is outside the table of the thrusters")));
    }
    let current = judge.problem.rules.current_m_s;
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    cluster.iter().enumerate().for_each(|(body, &cluster)| members.entry(cluster).or_default().push(body));
    for members in members.into_values() {
        let own = members.iter().map(|&body| (&resting[body], thrusts[body].unwrap_or_default()));
        if let Some(message) =
            unbalanced(&own.collect::<Vec<_>>(), current, judge.problem.rules.tilt_limit_rad)
        {
            wrong.push((Condition::V6, message));
        }
    }
    for (condition, message) in wrong {
        judge.add(index, start_s, condition, message);
    }
}

/// What is left of force and moment on a cluster, if that is too much.
fn unbalanced(cluster: &[(&Body<'_>, &[f64])], current: Vector, tilt_limit_rad: f64) -> Option<String> {
    let count = cluster.len() as f64;
    let origin = cluster.iter().fold([0.0; 3], |sum, (body, _)| plus(sum, body.pose.position_m));
    let origin = origin.map(|x| x / count);
    let (mut restoring, mut pushed) = ([[0.0; 3]; 2], [[0.0; 3]; 2]);
    let mut effort = [0.0; 2];
    // Σ z·W − z·B: tilted by θ, the cluster turns itself back by sin θ of it.
    let mut stiffness_nm = 0.0;
    for (body, thrusts) in cluster {
        let (sin, cos) = body.pose.yaw_rad.sin_cos();
        let turned = |v: Vector| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
        let place = |arm: Vector| plus(plus(body.pose.position_m, origin.map(|x| -x)), turned(arm));
        let own = &body.vehicle.body;
        let forces = [(own.r_g_m, own.mass_kg * GRAVITY_M_S2), (own.r_b_m, -own.buoyancy_n)];
        for (arm, force_n) in forces {
            let force = [0.0, 0.0, force_n];
            stiffness_nm += place(arm)[2] * force_n;
            restoring = [plus(restoring[0], force), plus(restoring[1], cross(place(arm), force))];
        }
        // The water that passes it.
        let flow = [cos * current[0] + sin * current[1], cos * current[1] - sin * current[0], current[2]];
        let drag =
            [0, 1, 2].map(|k| (own.linear_damping[k] + own.quadratic_damping[k] * flow[k].abs()) * flow[k]);
        let carried = [0, 1, 2].map(|k| own.added_mass[k] * flow[k]);
        let (drag, munk) = (turned(drag), turned(cross(carried, flow)));
        restoring = [plus(restoring[0], drag), plus(restoring[1], plus(cross(place([0.0; 3]), drag), munk))];
        for (thruster, &thrust_n) in body.vehicle.thrusters.iter().zip(*thrusts) {
            let force = turned(thruster.direction).map(|e| e * thrust_n);
            let moment = cross(place(thruster.position_m), force);
            pushed = [plus(pushed[0], force), plus(pushed[1], moment)];
            effort = [effort[0] + size(force), effort[1] + size(moment)];
        }
    }
    let units = ["N", "N·m"];
    for k in 0..2 {
        let mut left = plus(restoring[k], pushed[k]);
        // A stable cluster holds roll and pitch itself, at a tilt within the limit.
        if k == 1 && f64::hypot(left[0], left[1]) <= stiffness_nm * tilt_limit_rad.sin() * (1.0 + SHARE) {
            (left[0], left[1]) = (0.0, 0.0);
        }
        // Opposite weights and buoyancies cancel to rounding, so there is an absolute floor too.
        if size(left) > SHARE * size(restoring[k]).max(effort[k]) + 1e-9 {
            let names: Vec<&str> = cluster.iter().map(|(body, _)| body.name.as_str()).collect();
            return Some(format!(
                "{} not balanced: {:.6?} {} of {:.6?} {} are left",
                names.join(", "),
                left,
                units[k],
                restoring[k],
                units[k]
            ));
        }
    }
    None
}

/// Least and greatest thrust at a voltage, N; `None` outside the table.
fn limits_n(volts: f64) -> Option<[f64; 2]> {
    let mut ends: Vec<(f64, [f64; 2])> = Vec::new();
    for line in T200.lines().skip(1) {
        let mut numbers = line.split(',').map(|number| number.trim().parse::<f64>());
        let (Some(Ok(row_v)), Some(Ok(kgf))) = (numbers.next(), numbers.nth(4)) else { continue };
        let thrust_n = kgf * GRAVITY_M_S2;
        match ends.last_mut() {
            Some((last_v, [least, greatest])) if (*last_v - row_v).abs() < 1e-9 => {
                (*least, *greatest) = (least.min(thrust_n), greatest.max(thrust_n));
            }
            _ => ends.push((row_v, [thrust_n; 2])),
        }
    }
    let (low, high) =
        (ends.iter().rfind(|(row_v, _)| *row_v <= volts)?, ends.iter().find(|(row_v, _)| *row_v >= volts)?);
    let share = if high.0 > low.0 { (volts - low.0) / (high.0 - low.0) } else { 0.0 };
    Some([0, 1].map(|k| low.1[k] + share * (high.1[k] - low.1[k])))
}

#[cfg(test)]
mod tests {
    use reconfiguration::pose::Pose;
    use reconfiguration::vehicle::Vehicle;

    use super::*;

    /// Trim of 5 mm against a centre of gravity 20 mm down: sin θ = 1/4, 0.2527 rad.
    #[test]
    fn a_stable_cluster_holds_what_is_left_of_pitch_within_the_limit() {
        let mut vehicle = Vehicle::built_in("bluerov2").expect("it comes with the program");
        let pose = Pose::from([3.0, -2.0, 5.0, 0.7]);
        // Buoyant by 2 N: one newton down by each of the upright two.
        let thrusts = [0.0, 0.0, 0.0, 0.0, -1.0, -1.0];
        let left = |vehicle: &Vehicle, tilt_limit_rad: f64| {
            unbalanced(
                &[(&Body { name: "robot 1".to_owned(), pose, vehicle }, &thrusts)],
                [0.0; 3],
                tilt_limit_rad,
            )
        };
        assert_eq!(left(&vehicle, 0.0), None);
        vehicle.body.r_g_m[0] = 0.005;
        assert_eq!(left(&vehicle, 0.253), None);
        assert!(left(&vehicle, 0.252).is_some_and(|said| said.contains("N·m of")));
        // Upside down nothing is held.
        vehicle.body.r_g_m[2] = -0.02;
        assert!(left(&vehicle, 0.253).is_some());
    }

    #[test]
    fn limits_are_the_ends_of_the_table() {
        // Rows 16,1100 and 16,1900: −4.06948 and 5.24504 kgf.
        let [least, greatest] = limits_n(16.0).expect("inside");
        assert!(
            (greatest - 51.4362).abs() < 1e-3 && (least + 39.9079).abs() < 1e-3,
            "{least} to {greatest} N"
        );
        let [a, b, c] = [14.0, 15.0, 16.0].map(|v| limits_n(v).expect("inside")[1]);
        assert!((b - (a + c) / 2.0).abs() < 1e-12);
        assert!(limits_n(9.9).is_none() && limits_n(20.1).is_none() && limits_n(f64::NAN).is_none());
    }
}
