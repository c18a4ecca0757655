//! One simulated second of a robot, alone and docked.

use std::hint::black_box;

use criterion::Criterion;
use nalgebra::Vector6;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::cluster::Cluster;
use rov::dynamics::{Dynamics, STEP_S, State};

/// The lines.
pub fn second(criterion: &mut Criterion) {
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    let mut group = criterion.benchmark_group("one simulated second");
    for robots in [1, 4] {
        let members: Vec<_> =
            (0..robots).map(|k| (Pose::from([0.483 * f64::from(k), 0.0, 0.0, 0.0]), &robot)).collect();
        let cluster = Cluster::new(&Pose::default(), &members).expect("members");
        let dynamics = Dynamics::new(&cluster).expect("massive");
        let tau = Vector6::new(5.0, -2.0, 1.0, 0.1, 0.2, -0.3);
        group.bench_function(format!("BlueROV1, {robots} docked"), |b| {
            b.iter(|| {
                let mut state = State::from_eta(&[0.0; 6], &[0.1; 6]);
                dynamics.advance(&mut state, black_box(&tau), 1.0, STEP_S);
                black_box(state)
            });
        });
    }
    group.finish();
}
