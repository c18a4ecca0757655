//! What is planned does not depend on the world's origin and north, nor on the order of a file.

use host::run::reconfigure::scenario::ReconfigureScenario;
use judge::verify;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use rov::conditions::Conditions;
use rov::planner::{OrderRule, Planned, Request, plan};
use rov::power::PowerLaw;
use tests::reconfigure::{Kind, problem};
use tests::seeds::on_all_cores;

/// Greatest difference of two plans of one problem, as a share of their joules.
const SPREAD: f64 = 0.005;

/// Heading of the whole problem, and where its origin goes.
type Placing = (f64, [f64; 3]);

/// The problem turned about its origin, moved, and listed in another order.
fn placed(problem: &Problem, (yaw_rad, to_m): Placing, seed: u64) -> Problem {
    let (sin, cos) = yaw_rad.sin_cos();
    let place = |pose: Pose| {
        let [x, y, z] = pose.position_m;
        let position_m = [to_m[0] + cos * x - sin * y, to_m[1] + sin * x + cos * y, to_m[2] + z];
        Pose { position_m, yaw_rad: pose.yaw_rad + yaw_rad }
    };
    let mut problem = problem.clone();
    problem.robots.iter_mut().for_each(|robot| robot.start = place(robot.start));
    problem.tools.iter_mut().for_each(|tool| tool.pose = place(tool.pose));
    problem.slots.iter_mut().for_each(|slot| slot.pose = place(slot.pose));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    problem.robots.shuffle(&mut rng);
    problem.slots.shuffle(&mut rng);
    problem
}

fn planned(problem: &Problem, law: &PowerLaw, criterion: Criterion, manner: Manner) -> Option<Planned> {
    let order = if manner == Manner::Paper { OrderRule::Paper } else { OrderRule::Exact };
    plan(problem, &Request { criterion, manner, order, law: law.clone() }).ok()
}

const MANNERS: [(Criterion, Manner); 4] = [
    (Criterion::Energy, Manner::Paper),
    (Criterion::Euclidean, Manner::Paper),
    (Criterion::Energy, Manner::Best),
    (Criterion::Euclidean, Manner::Best),
];

/// J of every criterion and manner; the judge passes each plan.
fn joules(
    problem: &Problem,
    law: &PowerLaw,
    manners: &[(Criterion, Manner)],
    what: &str,
) -> Vec<Option<f64>> {
    problem.check().unwrap_or_else(|error| panic!("{what}: {error}"));
    let of = |&(criterion, manner): &(Criterion, Manner)| {
        let planned = planned(problem, law, criterion, manner)?;
        let found = verify(problem, &planned.plan);
        assert!(found.is_empty(), "{what}, {criterion:?}, {manner:?}: {found:?}");
        Some(planned.plan.energy_total_j)
    };
    manners.iter().map(of).collect()
}

/// The same to [`SPREAD`], a dead end for a dead end.
fn same(expected: &[Option<f64>], found: &[Option<f64>], what: &str) -> f64 {
    let mut worst: f64 = 0.0;
    for (expected, found) in expected.iter().zip(found) {
        match (expected, found) {
            (Some(a), Some(b)) => worst = worst.max((a / b - 1.0).abs()),
            (None, None) => {}
            _ => panic!("{what}: {found:?} where it was {expected:?}"),
        }
    }
    assert!(worst <= SPREAD, "{what}: {found:?} where it was {expected:?}");
    worst
}

const HEADINGS: usize = 12;
const ORIGINS: [[f64; 3]; 5] =
    [[0.0; 3], [3.7, -1.2, 5.0], [-999.3, 123.4, 20.0], [5e5, -5e5, 8.0], [999_990.0, 999_990.0, 999.0]];

/// Both T to I at some placings; returns the ratios of energy to Euclidean by the paper's rules that were seen.
fn t_to_i(placings: &[Placing], laws: &[(&str, PowerLaw)], manners: &[(Criterion, Manner)]) {
    for name in ["t-to-i-far", "t-to-i-below"] {
        let file = ReconfigureScenario::open(name).expect("built in").problem;
        for (law_name, law) in laws {
            let expected = joules(&file, law, manners, name);
            let found = on_all_cores(0..placings.len() as u64, |k| {
                let placing = placings[k as usize];
                let what = format!("{name} by the {law_name} law at {placing:?}");
                joules(&placed(&file, placing, k), law, manners, &what)
            });
            let mut worst: f64 = 0.0;
            for (placing, found) in placings.iter().zip(found) {
                let what = format!("{name} by the {law_name} law at {placing:?}");
                worst = worst.max(same(&expected, &found, &what));
            }
            let joules: Vec<f64> = expected.iter().map(|joules| joules.expect("a plan")).collect();
            println!(
                "{name} by the {law_name} law at {} placings: {joules:.2?} J, energy over Euclidean by the paper's rules \
                 {:.3} (the paper: 0.814), spread {:.2e}",
                placings.len(),
                joules[0] / joules[1],
                worst
            );
        }
    }
}

fn laws() -> [(&'static str, PowerLaw); 2] {
    let table = PowerLaw::table(16.0).expect("in the table");
    [("table", table), ("fitted", PowerLaw::fitted(16.0).expect("in the table"))]
}

/// Heading and origin for a number, every heading with every origin.
fn placing(number: usize) -> Placing {
    let heading = [0, 1, 3, 4, 5, 7, 10, 13, 14, 17, 19, 22][number % HEADINGS];
    (f64::from(heading) * std::f64::consts::PI / 12.0, ORIGINS[number / HEADINGS])
}

/// Whether all of it is asked for: tests/night does.
fn full() -> bool {
    std::env::var_os("FLOTILLA_FULL").is_some()
}

#[test]
fn t_to_i_takes_the_same_joules_wherever_it_is() {
    if full() {
        let placings: Vec<Placing> = (0..HEADINGS * ORIGINS.len()).map(placing).collect();
        return t_to_i(&placings, &laws(), &MANNERS);
    }
    // Turned by 90° as a file of the tank had it, by 75°, and by 210° far away.
    let placings = [(std::f64::consts::FRAC_PI_2, [0.0; 3]), placing(16), placing(57)];
    t_to_i(&placings, &laws()[..1], &MANNERS[..3]);
    t_to_i(&placings[..1], &laws()[1..], &MANNERS[..2]);
}

/// Random problems with their goal turned against their start, turned and moved as a whole.
fn random(seeds: std::ops::Range<u64>) -> (usize, usize, f64) {
    let law = PowerLaw::fitted(16.0).expect("in the table");
    let results = on_all_cores(seeds, |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut kind = Kind::random(&mut rng);
        kind.robots = rng.random_range(3..=5);
        let mut problem = problem(kind, &mut rng);
        problem.rules.grid_divisions = [1, 1, 1];
        let placing = (rng.random_range(-3.1..3.1), ORIGINS[rng.random_range(0..ORIGINS.len())]);
        let manners = &MANNERS[..if seed % 4 == 0 { 4 } else { 2 }];
        let what = format!("seed {seed}, {kind:?}, at {placing:?}");
        let expected = joules(&problem, &law, manners, &what);
        let found = joules(&placed(&problem, placing, seed), &law, manners, &what);
        let worst = same(&expected, &found, &what);
        (expected.iter().flatten().count(), expected.len(), worst)
    });
    results
        .into_iter()
        .fold((0, 0, 0.0), |(a, b, c): (usize, usize, f64), (x, y, z)| (a + x, b + y, c.max(z)))
}

#[test]
fn random_problems_take_the_same_joules_wherever_they_are() {
    let (plans, asked, worst) = random(if full() { 1000..1200 } else { 500..520 });
    println!("{plans} plans of {asked}, spread {worst:.2e}");
    assert!(plans * 10 >= asked * 8, "{plans} plans of {asked}");
}
