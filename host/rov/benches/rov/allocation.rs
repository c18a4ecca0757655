//! Thrusts for a wrench: one robot (no solver), a cluster of four around a tool by each law, a demand out of reach.

use std::hint::black_box;

use criterion::Criterion;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::allocation::Allocator;
use rov::configuration_matrix::ConfigurationMatrix;
use rov::power::{PowerLaw, limits_n};

const BATTERY_V: f64 = 16.0;
const T_SHAPE: [[f64; 4]; 4] =
    [[0.0, -0.33, 0.0, 0.0], [0.0, 0.33, 0.0, 0.0], [-0.483, 0.0, 0.0, 0.0], [-0.966, 0.0, 0.0, 0.0]];

fn allocator(poses: &[[f64; 4]], law: PowerLaw) -> Allocator {
    let robot = Vehicle::built_in("bluerov1").expect("comes with the program");
    let members: Vec<_> = poses.iter().map(|pose| (&robot, Pose::from(*pose))).collect();
    let matrix =
        ConfigurationMatrix::of_cluster(&members, &Pose::default()).expect("its thrusters are sound");
    let limits = vec![limits_n(BATTERY_V).expect("in the table"); matrix.thrusters()];
    Allocator::new(matrix, &limits, law).expect("one limit a thruster")
}

/// The bench lines `allocation/…`.
pub fn allocation(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("allocation");
    let fitted = || PowerLaw::fitted(BATTERY_V).expect("in the table");
    let one = allocator(&T_SHAPE[..1], fitted());
    let mut thrusts = [0.0; 6];
    let demand = [6.0, 0.5, -1.0, 0.1, 0.3, 0.2];
    group.bench_function("one robot", |bench| {
        bench.iter(|| one.allocate_into(black_box(&demand), &mut thrusts).map(|_| one.power_w(&thrusts)));
    });
    let laws = [
        ("quadratic", PowerLaw::quadratic(0.14).expect("positive")),
        ("fitted", fitted()),
        ("table", PowerLaw::table(BATTERY_V).expect("in the table")),
    ];
    for (name, law) in laws {
        let four = allocator(&T_SHAPE, law);
        for (what, demand) in [
            ("balancing", [0.0, 0.0, 0.0, 0.0, 0.6, 0.0]),
            ("24 thrusters", [60.0, 5.0, -20.0, 3.0, 6.0, 4.0]),
            ("out of reach", [2000.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ] {
            let name = format!("{name}, {what}");
            group.bench_function(name, |bench| bench.iter(|| four.allocate(black_box(&demand))));
        }
    }
    group.finish();
}
