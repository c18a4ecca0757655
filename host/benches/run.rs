//! Criterion benches of a run: a whole simulated experiment, and the steps that it makes a thousand times a second.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use host::run::experiment::simulate;
use host::run::scenario::Scenario;
use modboat::observer::{Fix, Observer};
use modboat::structure::Structure;
use record::PoseSample;
use sim::TailState;
use sim::tank::Tank;

/// 90 s of three modules: planned, sent, executed by the firmware, swum and observed.
fn experiment(criterion: &mut Criterion) {
    let scenario = Scenario::open("holonomic-1").expect("it comes with the program");
    let mut group = criterion.benchmark_group("run");
    group.sample_size(10);
    group.bench_function("holonomic-1, 90 s, 3 modules", |b| {
        let mut seed = 0;
        b.iter(|| {
            seed += 1;
            black_box(simulate(&scenario, seed).map(|result| result.summary))
        });
    });
    group.finish();
}

/// One millisecond of the tank, and one fix of the observer.
fn steps(criterion: &mut Criterion) {
    let scenario = Scenario::open("holonomic-1").expect("it comes with the program");
    let mut group = criterion.benchmark_group("step");
    for shape in ["3x1", "5x5"] {
        let structure = Structure::from_word(shape).expect(shape);
        let mut tank = Tank::new(&structure, &scenario.modboat, &scenario.tank, &PoseSample::default(), 1)
            .expect("valid defaults");
        let mut t_s = 0.0;
        let mut tails = vec![TailState::default(); structure.len()];
        group.bench_function(format!("tank, {} modules", structure.len()), |b| {
            b.iter(|| {
                t_s += 1e-3;
                // Waveform (1) about sway with |A| = 0.7 rad, everybody the same way: nobody meets anybody.
                let (sin, cos) = (std::f64::consts::TAU * t_s / 1.5).sin_cos();
                let rate = std::f64::consts::TAU / 1.5;
                tails.fill(TailState {
                    angle_rad: 1.57 + 0.7 * cos,
                    rate_rad_s: -0.7 * rate * sin,
                    acceleration_rad_s2: -0.7 * rate * rate * cos,
                    inertia_kg_m2: 1e-4,
                });
                tank.step(1e-3, &tails);
            });
        });
        let mut observer =
            Observer::new(&structure, &scenario.modboat, &scenario.observer).expect("valid defaults");
        let mut t_s = 0.0;
        group.bench_function(format!("observer, {} modules", structure.len()), |b| {
            b.iter(|| {
                t_s += 1.0 / 120.0;
                observer.update(&Fix { t_s, position_m: [0.04 * t_s, 0.0], heading_rad: 1.57 });
                black_box(observer.estimate())
            });
        });
    }
    group.finish();
}

criterion_group!(benches, experiment, steps);
criterion_main!(benches);
