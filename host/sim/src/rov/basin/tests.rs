use super::*;

fn vehicle(name: &str, drags: bool) -> Vehicle {
    let mut vehicle = Vehicle::built_in(name).expect("built in");
    if !drags {
        (vehicle.linear_damping, vehicle.quadratic_damping) = ([0.0; 6], [0.0; 6]);
        vehicle.r_g_m = vehicle.r_b_m;
    }
    vehicle
}

/// Linear momentum, and angular about the world's origin.
fn momentum(basin: &Basin) -> (Vector3<f64>, Vector3<f64>) {
    let each = (0..basin.bodies.len()).map(|body| {
        let (p, l) = basin.momentum(body);
        (p, l + basin.state(body).position_m.cross(&p))
    });
    each.fold((Vector3::zeros(), Vector3::zeros()), |a, b| (a.0 + b.0, a.1 + b.1))
}

fn unmoved(before: (Vector3<f64>, Vector3<f64>), after: (Vector3<f64>, Vector3<f64>), what: &str) {
    let scale = 1.0 + before.0.norm() + before.1.norm();
    let off = (before.0 - after.0).norm() + (before.1 - after.1).norm();
    assert!(off < 1e-9 * scale, "{what}: {before:?} {after:?}");
}

/// Nothing pushes and nothing drags: momentum stays when robots let go, drift, and take hold again.
#[test]
fn momentum_stays_through_parting_drifting_and_meeting() {
    let robot = vehicle("bluerov1", false);
    let poses = [[0.0, 0.0, 0.0, 0.3], [0.483 * 0.3_f64.cos(), 0.483 * 0.3_f64.sin(), 0.0, 0.3]];
    let mut basin = Basin::new(&poses.map(|pose| (pose.into(), &robot))).expect("a pair");
    assert_eq!(basin.rafts.len(), 1);
    basin.rafts[0].state.nu = Vector6::new(0.2, -0.1, 0.05, 0.1, 0.2, -0.3);
    let before = momentum(&basin);
    let drift = |basin: &mut Basin, steps: usize| {
        for _ in 0..steps {
            basin.step(0.005, &[&[], &[]]);
        }
    };
    drift(&mut basin, 100);
    unmoved(before, momentum(&basin), "one cluster");
    let (was, other) = (basin.state(1), basin.state(0));
    basin.undock(1).expect("two bodies");
    assert_eq!(basin.rafts.len(), 2);
    for (body, was) in [(1, was), (0, other)] {
        let now = basin.state(body);
        assert!((now.position_m - was.position_m).norm() < 1e-12 && (now.nu - was.nu).norm() < 1e-9);
    }
    unmoved(before, momentum(&basin), "parted");
    drift(&mut basin, 4);
    unmoved(before, momentum(&basin), "drifted");
    // What the connectors pull straight is small, but it is a turn and a shift at given momentum: that alone
    // must not change the linear part, nor the angular part about the origin.
    let misfit = basin.misfit(1, poses[1].into());
    assert!(misfit.position_m < 0.02 && misfit.position_m > 1e-5, "{misfit:?}");
    basin.dock(1, poses[1].into()).expect("docked");
    assert_eq!(basin.rafts.len(), 1);
    let (p, l) = {
        let raft = &basin.rafts[0];
        let own = raft.dynamics.mass_matrix() * raft.state.nu;
        let p = raft.state.attitude * own.fixed_rows::<3>(0);
        (p, raft.state.attitude * own.fixed_rows::<3>(3) + raft.state.position_m.cross(&p))
    };
    unmoved(before, (p, l), "met");
}

/// A robot that is docked to the side of where the cluster has gone fits the slot that the cluster carries.
#[test]
fn a_slot_goes_where_its_cluster_goes() {
    let robot = vehicle("bluerov1", true);
    let tool = vehicle("tool-20n", true);
    let slot = Pose::from([0.483, 0.0, 0.0, 0.0]);
    let mut basin = Basin::new(&[
        (Pose::from([-2.0, 0.0, 0.0, 0.0]), &robot),
        (Pose::from([-0.483, 0.0, 0.0, 0.0]), &robot),
        (Pose::default(), &tool),
    ])
    .expect("three bodies");
    assert_eq!(basin.rafts.len(), 2);
    basin.undock(0).expect("it was alone");
    for raft in &mut basin.rafts {
        if raft.members.contains(&2) {
            raft.state.position_m.y += 0.5;
            raft.state.attitude = UnitQuaternion::from_euler_angles(0.0, 0.0, 1.0);
        } else {
            // Where the slot is now: half a metre east, then one box along the turned x from the tool.
            let from_lead = 2.0 * 0.483;
            raft.state.position_m =
                Vector3::new(-0.483 + from_lead * 1.0_f64.cos(), 0.5 + from_lead * 1.0_f64.sin(), 0.0);
            raft.state.attitude = UnitQuaternion::from_euler_angles(0.0, 0.0, 1.0);
        }
    }
    let misfit = basin.misfit(0, slot);
    assert!(misfit.position_m < 1e-9 && misfit.angle_rad < 1e-7, "{misfit:?}");
    basin.dock(0, slot).expect("docked");
    assert_eq!(basin.rafts.len(), 1);
}

/// The 20 N tool asks for 0.6 N·m; balanced by hand with two vertical thrusters it stays where it is.
#[test]
fn the_tool_pitches_unless_it_is_balanced() {
    let (robot, tool) = (vehicle("bluerov1", true), vehicle("tool-20n", true));
    let bodies = [(Pose::from([-0.483, 0.0, 0.0, 0.0]), &robot), (Pose::default(), &tool)];
    let mut basin = Basin::new(&bodies).expect("two bodies");
    let [k, m] = basin.restoring_nm(1);
    assert!(k.abs() < 1e-12 && (m - 0.6).abs() < 1e-5, "{k} {m}");
    // Thrusters 3 and 4 at x = 0.165 m, 5 at −0.185 m, all along z: M = −Σ x Z.
    let pair_n = 0.6 / 0.35;
    let thrusts_n = [0.0, 0.0, -pair_n / 2.0, -pair_n / 2.0, pair_n, 0.0];
    let mut balanced = basin.clone();
    for _ in 0..200 {
        basin.step(0.01, &[&[], &[]]);
        balanced.step(0.01, &[&thrusts_n[..], &[]]);
    }
    assert!(basin.state(1).eta()[4] < -0.1, "nose down: {:?}", basin.state(1).eta());
    assert!(balanced.state(1).eta()[4].abs() < 1e-4, "{:?}", balanced.state(1).eta());
}
