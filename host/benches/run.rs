//! Criterion benches of a run: a whole simulated experiment, and the steps that it makes a thousand times a second.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, run_into, simulate};
use host::run::fleet::InProcess;
use host::run::log::Log;
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use modboat::observer::{Fix, Observer};
use modboat::structure::Structure;
use record::PoseSample;
use sim::TailState;
use sim::tank::Tank;

/// How often a run is made without and with a log.
const RUNS: usize = 30;

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

/// The same without and with a log in a file, turn about so that a busy machine is busy for both; their ratio is printed: it has to stay
/// below 1.1.
fn logged(criterion: &mut Criterion) {
    let scenario = Scenario::open("holonomic-1").expect("it comes with the program");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.mcap");
    let once = |kept: bool, seed: u64| {
        let log = if kept { Log::create(&path).expect("a file") } else { Log::default() };
        let mut fleet = InProcess::boats(&scenario, seed).expect("valid");
        let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut |_, _, _| {} };
        let began = Instant::now();
        black_box(run_into(log, &scenario, seed, &mut fleet, drive, &mut Quiet)).expect("runs");
        began.elapsed().as_secs_f64()
    };
    // The least of several is what the machine takes when nothing else wants it.
    let mut least_s = [f64::INFINITY; 2];
    for _ in 0..RUNS {
        for kept in [false, true] {
            least_s[usize::from(kept)] = least_s[usize::from(kept)].min(once(kept, 1));
        }
    }
    println!(
        "log: {:.1} ms without, {:.1} ms with, {:.3} times",
        1e3 * least_s[0],
        1e3 * least_s[1],
        least_s[1] / least_s[0]
    );
    let mut group = criterion.benchmark_group("log");
    group.sample_size(10);
    for (name, kept) in [("none", false), ("file", true)] {
        group.bench_function(name, |b| b.iter(|| once(kept, 1)));
    }
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
                // Waveform (1) about sway with |A| = 0.7 rad, all tails the same way: no two touch.
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

criterion_group!(benches, experiment, logged, steps);
criterion_main!(benches);
