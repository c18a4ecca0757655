//! Orders of moves before the judge and in the water: places exchanged by way of a parking place, more slots than robots,
//! a cube of eight to a line.

use std::path::Path;

use host::run::progress::Quiet;
use host::run::reconfigure::execution::{Options, execute};
use host::run::reconfigure::scenario::ReconfigureScenario;
use judge::{Condition, verify};
use link::faults::FaultParameters;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use reconfiguration::plan::{Criterion, Manner, Plan};
use reconfiguration::problem::Problem;
use rov::order::{InTurn, Patience};
use rov::planner::{OrderRule, PlanError, Planned, Request, plan_with};
use rov::power::PowerLaw;
use tests::reconfigure::{Kind, problem as random};
use tests::seeds::on_all_cores;

/// Robots and slots in lines of a file: pose, and what is brought or required.
fn problem(robots: &[([f64; 4], &str)], slots: &[([f64; 4], &str)]) -> Problem {
    let list = |what: &str| if what.is_empty() { String::new() } else { format!("{what:?}") };
    let mut text = "name = \"orders\"\n".to_owned();
    for (index, (start, brings)) in robots.iter().enumerate() {
        let (id, brings) = (index + 1, list(brings));
        text += &format!(
            "[[robot]]\nid = {id}\nvehicle = \"bluerov1\"\nstart = {start:?}\ncapabilities = [{brings}]\n"
        );
    }
    for (pose, requires) in slots {
        text += &format!("[[slot]]\npose = {pose:?}\nrequires = [{}]\n", list(requires));
    }
    ReconfigureScenario::parse("orders.toml", &text, Path::new(".")).expect("a sound problem").problem
}

/// Three in a row whose ends change places.
fn exchange() -> Problem {
    let at = |n: f64| [0.483 * n, 0.0, 5.0, 0.0];
    problem(
        &[(at(0.0), "a"), (at(1.0), "b"), (at(2.0), "c")],
        &[(at(0.0), "c"), (at(1.0), "b"), (at(2.0), "a")],
    )
}

fn law() -> PowerLaw {
    PowerLaw::fitted(16.0).expect("in the table")
}

fn planned(problem: &Problem, patience: usize) -> Result<Planned, PlanError> {
    let order = OrderRule::Exact;
    let request = Request { criterion: Criterion::Energy, manner: Manner::Best, order, law: law() };
    plan_with(problem, &request, &InTurn, &mut Patience(patience))
}

fn judged(problem: &Problem, plan: &Plan) {
    let found = verify(problem, plan);
    assert!(found.is_empty(), "{}", found.iter().map(|v| format!("\n  {v}")).collect::<String>());
}

#[test]
fn robots_that_exchange_places_park_and_the_plan_is_executed() {
    let problem = exchange();
    let Planned { plan, proved, .. } = planned(&problem, 20_000).expect("a plan");
    judged(&problem, &plan);
    assert!(proved && plan.proved == Some(true) && plan.gap == Some(0.0));
    let parked = plan.moves.iter().position(|own| own.slot.is_none()).expect("one parks");
    let place = plan.moves[parked].to.expect("somewhere");

    // As JSON and back; a move to a slot says nothing of another place.
    let text = serde_json::to_string(&plan).expect("JSON");
    assert_eq!(serde_json::from_str::<Plan>(&text).expect("a plan"), plan);
    assert_eq!(text.matches("\"slot\":null,\"to\":[").count(), 1, "{text}");
    assert_eq!(
        text.matches(",\"to\":[").count() - 1,
        plan.moves.iter().map(|own| own.actions.len()).sum::<usize>()
    );

    // The rules may allow one move only; where it parks is where it is to end; and it goes on from there.
    let mut strict = problem.clone();
    strict.rules.moves_per_robot = 1;
    let breaks = |problem: &Problem, plan: &Plan, condition| {
        let found = verify(problem, plan);
        assert!(found.iter().any(|v| v.condition == condition), "{condition}: {found:?}");
    };
    breaks(&strict, &plan, Condition::V5);
    assert!(matches!(planned(&strict, 20_000), Err(PlanError::Unreachable { .. })));
    let spoilt = |change: &dyn Fn(&mut Plan)| {
        let mut spoilt = plan.clone();
        change(&mut spoilt);
        spoilt
    };
    let beside = spoilt(&|plan| plan.moves[parked].to.as_mut().expect("it parks").position_m[2] += 0.1);
    breaks(&problem, &beside, Condition::V1);
    breaks(&problem, &spoilt(&|plan| plan.moves[parked].to = None), Condition::Identity);
    breaks(&problem, &spoilt(&|plan| plan.moves[parked].slot = Some(1)), Condition::Identity);
    breaks(&problem, &spoilt(&|plan| plan.moves.truncate(parked + 1)), Condition::V1);

    let options = Options { seed: 1, radio: FaultParameters::default(), law: law() };
    let executed = execute(&problem, &plan, &options, &mut Quiet).expect("executed");
    assert_eq!(executed.summary.failure, None);
    assert_eq!(executed.summary.moves.len(), plan.moves.len());
    let rests = &executed.record.samples.last().expect("samples").robots;
    for own in plan.moves.iter().filter_map(|own| Some((own.robot, own.slot?))) {
        let (eta, slot) = (rests[usize::from(own.0) - 1].eta, problem.slots[own.1].pose);
        let off_m = (0..3).map(|k| (eta[k] - slot.position_m[k]).powi(2)).sum::<f64>().sqrt();
        assert!(off_m < 0.05, "robot {} rests {off_m} m off", own.0);
    }
    println!("parked at {place:?}, executed/planned {:?}", executed.summary.ratio);
}

#[test]
fn a_robot_that_faces_about_goes_out_and_back() {
    let at = |n: f64, yaw: f64| [0.483 * n, 0.0, 5.0, yaw];
    let about = std::f64::consts::PI;
    let flip =
        problem(&[(at(0.0, 0.0), ""), (at(1.0, 0.0), "")], &[(at(0.0, about), ""), (at(1.0, about), "")]);
    judged(&flip, &planned(&flip, 20_000).expect("a plan").plan);
}

#[test]
fn a_choice_of_slots_is_one_cluster() {
    let row = |y: f64, count: usize| -> Vec<([f64; 4], &str)> {
        (0..count).map(|n| ([0.483 * n as f64, y, 5.0, 0.0], "")).collect()
    };
    for slots in [3, 5] {
        let surplus = problem(&row(0.0, 2), &row(1.0, slots));
        let planned = planned(&surplus, 20_000).expect("a plan");
        assert!(planned.proved);
        judged(&surplus, &planned.plan);
    }
}

#[test]
fn sixteen_random_robots_have_an_order_within_few_prices() {
    let kinds = [(false, false), (false, true), (true, true)];
    on_all_cores(1..4, |seed| {
        let (tool, spatial) = kinds[seed as usize - 1];
        let kind = Kind { robots: 16, tool, spatial };
        let sixteen = random(kind, &mut ChaCha8Rng::seed_from_u64(seed));
        let planned = planned(&sixteen, 1000).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        println!(
            "{kind:?}: {:.1} J, at least {:.1} J, {} priced",
            planned.cost, planned.bound, planned.priced
        );
        judged(&sixteen, &planned.plan);
        assert!(planned.gap().is_some_and(|gap| gap < 1.0), "seed {seed}: {:?}", planned.gap());
    });
}

#[test]
fn a_cube_of_eight_becomes_a_line_by_the_best_order_known() {
    let cube: Vec<([f64; 4], &str)> = (0..8)
        .map(|n| {
            let side = |bit: usize| f64::from(u8::from(n >> bit & 1 == 1));
            ([0.483 * side(2), 0.33 * side(1), 5.0 + 0.267 * side(0), 0.0], "")
        })
        .collect();
    let line: Vec<([f64; 4], &str)> =
        (0..8).map(|n| ([3.0 + 0.483 * f64::from(n), 0.0, 5.0, 0.0], "")).collect();
    let eight = problem(&cube, &line);
    let planned = planned(&eight, 600).expect("a plan");
    println!("{:.1} J, at least {:.1} J, {} priced", planned.cost, planned.bound, planned.priced);
    judged(&eight, &planned.plan);
    assert!(planned.gap().is_some_and(|gap| gap < 0.2), "{:?}", planned.gap());
}
