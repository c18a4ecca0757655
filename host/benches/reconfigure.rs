//! Criterion benches of whole reconfigurations (`cargo bench -p host --bench reconfigure`): plans of T → I with the tool, by both criteria, and one way of it.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion as Bench, criterion_group, criterion_main};
use host::run::reconfigure::scenario::ReconfigureScenario;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::problem::Problem;
use rov::clearance::{Clearance, Resting};
use rov::conditions::Conditions;
use rov::planner::{OrderRule, Request, plan as planned};
use rov::power::PowerLaw;
use rov::propulsion::{Propulsion, Steady};
use rov::route::{Mover, RouteQuery, Scratch};
use rov::search_graph::Lattice;

/// The last robot of the stem around all others to the far end of the line, no robot having moved.
fn route(bench: &mut Bench, problem: &Problem) {
    let (rules, robot) = (&problem.rules, &problem.robots[3]);
    let vehicle = &problem.vehicles[robot.vehicle];
    let law = PowerLaw::fitted(rules.battery_v).expect("in the table");
    let propulsion = Propulsion::new(vehicle, law, rules.battery_v, Steady::Whole).expect("six thrusters");
    let mover = Mover::new(propulsion, rules);
    let half_m = vehicle.box_m.map(|side| side / 2.0);
    let others = problem.robots.iter().filter(|other| other.id != robot.id).map(|other| other.start);
    let resting = others.chain(problem.tools.iter().map(|tool| tool.pose));
    let clearance = Clearance {
        resting: resting.map(|pose| Resting { pose, half_m }).collect(),
        half_m,
        start: robot.start,
        slot: problem.slots[3].pose,
        distance_m: problem.clearance_m(vehicle),
        bounds_m: problem.bounds_m(),
    };
    let cell_m = std::array::from_fn(|k| vehicle.box_m[k] / f64::from(rules.grid_divisions[k]));
    let lattice = Lattice::new(problem.robots[0].start.position_m, cell_m, problem.bounds_m());
    let query = RouteQuery { mover: &mover, clearance: &clearance, lattice: &lattice, rules, lambda_w: 0.5 };
    let mut scratch = Scratch::default();
    for criterion in [Criterion::Energy, Criterion::Euclidean] {
        bench.bench_function(&format!("plan/one way of T to I/{criterion:?}"), |b| {
            b.iter(|| query.route(black_box(criterion), Manner::Best, &mut scratch));
        });
    }
}

/// The bench lines `plan/…`.
fn plan(bench: &mut Bench) {
    let problem = ReconfigureScenario::open("t-to-i-far").expect("it comes with the program").problem;
    route(bench, &problem);
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
    let mut group = bench.benchmark_group("plan/T to I, best, exact");
    group.sample_size(10).measurement_time(Duration::from_secs(10));
    for criterion in [Criterion::Energy, Criterion::Euclidean] {
        let request = Request { criterion, manner: Manner::Best, order: OrderRule::Exact, law: law.clone() };
        group.bench_function(format!("{criterion:?}"), |b| {
            b.iter(|| planned(black_box(&problem), &request).expect("a plan"));
        });
    }
    group.finish();
}

criterion_group!(benches, plan);
criterion_main!(benches);
