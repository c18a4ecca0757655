use nalgebra::UnitQuaternion;

use super::*;
use crate::dynamics::{Dynamics, STEP_S, State};

fn vehicle(name: &str) -> Vehicle {
    Vehicle::built_in(name).expect(name)
}

fn near(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{what}: {a}, by hand {b}");
}

/// Two robots 0.33 m apart side by side, about the point between them, by the parallel-axis theorem.
#[test]
fn two_side_by_side_by_hand() {
    let robot = vehicle("bluerov1");
    let d = 0.165;
    let members = [(Pose::from([2.0, d, 1.0, 0.0]), &robot), (Pose::from([2.0, -d, 1.0, 0.0]), &robot)];
    let cluster = Cluster::new(&[2.0, 0.0, 1.0, 0.0].into(), &members).expect("two");
    let (rigid, added) = (cluster.rigid_body_mass(), cluster.added_mass());
    near(rigid[(0, 0)], 7.46, "mass");
    near(rigid[(3, 3)], 2.0 * (0.056 + 3.73 * d * d), "I_xx");
    near(rigid[(4, 4)], 2.0 * 0.095, "I_yy");
    near(rigid[(5, 5)], 2.0 * (0.106 + 3.73 * d * d), "I_zz");
    near(added[(0, 0)], 10.8, "X_u̇");
    near(added[(3, 3)], 2.0 * (0.053 + 12.7 * d * d), "K_ṗ");
    near(added[(5, 5)], 2.0 * (0.117 + 5.4 * d * d), "N_ṙ");
    near(added[(0, 5)], 0.0, "by symmetry surge and yaw do not mix");
}

/// One robot across, off to the north: its sway is the cluster's surge, and yaw moves it sideways.
#[test]
fn a_turned_member_trades_surge_for_sway() {
    let robot = vehicle("bluerov1");
    let (d, east) = (0.4, std::f64::consts::FRAC_PI_2);
    let cluster = Cluster::new(&Pose::default(), &[(Pose::from([d, 0.0, 0.0, east]), &robot)]).expect("one");
    let added = cluster.added_mass();
    near(added[(0, 0)], 13.2, "X_u̇");
    near(added[(1, 1)], 5.4, "Y_v̇");
    near(added[(5, 5)], 0.117 + 5.4 * d * d, "N_ṙ");
    near(added[(1, 5)], 5.4 * d, "Y_ṙ");
    let drag = cluster.drag(&[0.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
    near(drag[0], 6.22 * 0.5 + 21.66 * 0.25, "drag ahead is its drag sideways");
    // Turning at r, it swims along its own length at r d: x of its body points east.
    let r = 0.8;
    let drag = cluster.drag(&[0.0, 0.0, 0.0, 0.0, 0.0, -r]);
    let side = 4.03 * r * d + 18.18 * (r * d).powi(2);
    near(drag[1], -side, "Y");
    near(drag[5], -(side * d + 0.07 * r + 0.227 * r * r), "N");
}

/// Kinetic energy and dissipated power are the members' own, with velocities from the motion of their origins.
#[test]
fn energy_and_power_are_the_members_sum() {
    let kinds = [vehicle("bluerov1"), vehicle("bluerov2-heavy"), vehicle("tool-20n")];
    let poses = [[0.3, -0.2, 0.1, 0.4], [-0.5, 0.1, 0.3, 2.2], [0.1, 0.6, -0.4, -1.3]];
    let members: Vec<_> = poses.iter().zip(&kinds).map(|(pose, kind)| (Pose::from(*pose), kind)).collect();
    let cluster = Cluster::new(&Pose::default(), &members).expect("three");
    let nu = [0.4, -0.3, 0.2, 0.5, -0.6, 0.9];
    let (mut energy_j, mut power_w) = (0.0, 0.0);
    for (pose, kind) in poses.iter().zip(&kinds) {
        let [x, y, z, psi] = *pose;
        let [u, v, w, p, q, r] = nu;
        // v + ω × p, then turned by −ψ.
        let (vx, vy, vz) = (u + q * z - r * y, v + r * x - p * z, w + p * y - q * x);
        let own = |a: f64, b: f64| (psi.cos() * a + psi.sin() * b, psi.cos() * b - psi.sin() * a);
        let ((u, v), (p, q)) = (own(vx, vy), own(p, q));
        let nu = [u, v, vz, p, q, r];
        let body = &kind.body;
        // ½ m |v + ω × r_G|² + ½ ωᵀ I ω + ½ νᵀ M_A ν
        let [gx, gy, gz] = body.r_g_m;
        let at_g = [u + q * gz - r * gy, v + r * gx - p * gz, vz + p * gy - q * gx];
        energy_j += 0.5 * body.mass_kg * at_g.iter().map(|v| v * v).sum::<f64>();
        for (axis, nu) in nu.into_iter().enumerate() {
            let inertia = if axis < 3 { 0.0 } else { body.inertia_kg_m2[axis - 3] };
            energy_j += 0.5 * (inertia + body.added_mass[axis]) * nu * nu;
            let force = (body.linear_damping[axis] + body.quadratic_damping[axis] * nu.abs()) * nu;
            power_w += force * nu;
        }
    }
    let nu_vector = Vector6::from(nu);
    let mass = cluster.rigid_body_mass() + cluster.added_mass();
    near(0.5 * nu_vector.dot(&(mass * nu_vector)), energy_j, "kinetic energy");
    near(nu_vector.dot(&Vector6::from(cluster.drag(&nu))), power_w, "dissipated power");
}

/// The same cluster described about another origin moves the same way.
#[test]
fn the_origin_is_a_matter_of_taste() {
    let (robot, tool) = (vehicle("bluerov2"), vehicle("tool-20n"));
    let members = [
        (Pose::from([0.0, 0.0, 0.0, 0.3]), &robot),
        (Pose::from([0.5, 0.1, 0.0, 0.3]), &robot),
        (Pose::from([-0.4, 0.0, 0.2, -1.0]), &tool),
    ];
    let elsewhere = [0.6, -0.3, 0.25, 1.1];
    let [x, y, z, psi] = elsewhere;
    let dynamics = [Pose::default(), Pose::from(elsewhere)]
        .map(|origin| Dynamics::new(&Cluster::new(&origin, &members).expect("three")).expect("massive"));
    let nu = [0.5, -0.2, 0.3, 0.4, -0.3, 0.6];
    let (v, omega) = (Vector3::new(nu[0], nu[1], nu[2]), Vector3::new(nu[3], nu[4], nu[5]));
    let offset = Vector3::new(x, y, z);
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, psi);
    let (v_there, omega_there) =
        (turn.inverse_transform_vector(&(v + omega.cross(&offset))), turn.inverse_transform_vector(&omega));
    let nu_there = [v_there.x, v_there.y, v_there.z, omega_there.x, omega_there.y, omega_there.z];
    let mut here = State::from_eta(&[0.0; 6], &nu);
    let mut there = State::from_eta(&[x, y, z, 0.0, 0.0, psi], &nu_there);
    dynamics[0].advance(&mut here, &Vector6::zeros(), 10.0, STEP_S);
    dynamics[1].advance(&mut there, &Vector6::zeros(), 10.0, STEP_S);
    let expected = here.position_m + here.attitude * offset;
    assert!((there.position_m - expected).norm() < 1e-9, "{} against {expected}", there.position_m);
    assert!(there.attitude.angle_to(&(here.attitude * turn)) < 1e-7);
    assert!(here.position_m.norm() > 0.1, "it moved");
}

/// Two robots side by side, and one vehicle with what they have together.
#[test]
fn a_cluster_moves_as_one_vehicle_with_the_composed_coefficients() {
    let d = 0.165;
    let still = [0.0; 6];
    let mut robot = vehicle("bluerov1");
    (robot.body.linear_damping, robot.body.quadratic_damping) = (still, still);
    let members = [(Pose::from([0.0, d, 0.0, 0.0]), &robot), (Pose::from([0.0, -d, 0.0, 0.0]), &robot)];
    let pair = Cluster::new(&Pose::default(), &members).expect("two");
    let alone = robot.body.clone();
    let (m, [i_x, i_y, i_z], [x, y, z, k, p, n]) = (alone.mass_kg, alone.inertia_kg_m2, alone.added_mass);
    let one = Cluster::of(&Body {
        mass_kg: 2.0 * m,
        weight_n: 2.0 * alone.weight_n,
        buoyancy_n: 2.0 * alone.buoyancy_n,
        inertia_kg_m2: [2.0 * (i_x + m * d * d), 2.0 * i_y, 2.0 * (i_z + m * d * d)],
        added_mass: [2.0 * x, 2.0 * y, 2.0 * z, 2.0 * (k + z * d * d), 2.0 * p, 2.0 * (n + x * d * d)],
        ..alone
    });
    let tau = Vector6::new(2.0, -1.0, 0.5, 0.02, -0.03, 0.05);
    let [pair, one] = [pair, one].map(|cluster| {
        let mut state = State::from_eta(&[0.0; 6], &[0.1, 0.2, -0.1, 0.3, 0.1, -0.2]);
        Dynamics::new(&cluster).expect("massive").advance(&mut state, &tau, 5.0, STEP_S);
        state
    });
    assert!((pair.position_m - one.position_m).norm() < 1e-9 && (pair.nu - one.nu).norm() < 1e-9);
    // And still water is not free: what is needed to hold level and still is nothing for neutral robots.
    assert!(Cluster::of(&robot.body).force_needed(&still).iter().all(|part| part.abs() < 1e-15));
}

#[test]
fn no_members_and_poses_that_are_not_finite_are_refused() {
    let robot = vehicle("bluerov1");
    assert_eq!(
        Cluster::new(&Pose::default(), &[]).expect_err("empty").to_string(),
        "a cluster of no members"
    );
    let members = [(Pose::default(), &robot), (Pose::from([0.0, f64::NAN, 0.0, 0.0]), &robot)];
    let refused = Cluster::new(&Pose::default(), &members).expect_err("nowhere").to_string();
    assert!(refused.starts_with("member 1: pose [0.0, NaN, 0.0, 0.0] (m, m, m, rad)"), "{refused}");
}
