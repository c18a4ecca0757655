//! Goals for tasks: against counts by hand, and against plans to every goal there is.

use std::ops::ControlFlow;

use quantity::bounds::Bounds;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Robot, Rules, Tool};
use reconfiguration::task::{Passage, Service};
use reconfiguration::vehicle::Vehicle;

use super::super::planner::{OrderRule, plan};
use super::super::power::PowerLaw;
use super::*;

const L: f64 = 0.483;
const W: f64 = 0.33;

/// Robots at places around a tool, or around nothing; the first brings a sonar.
fn problem(starts: &[[f64; 4]], tool: bool) -> Problem {
    let vehicles = ["bluerov1", "tool-20n"].map(|name| Vehicle::built_in(name).expect("built in")).to_vec();
    let robots = starts.iter().enumerate().map(|(index, start)| Robot {
        id: index as u16 + 1,
        vehicle: 0,
        start: Pose::from(*start),
        capabilities: if index == 0 { vec!["sonar".to_owned()] } else { Vec::new() },
    });
    Problem {
        name: "task".to_owned(),
        description: String::new(),
        vehicles,
        robots: robots.collect(),
        tools: if tool { vec![Tool { vehicle: 1, pose: Pose::default() }] } else { Vec::new() },
        slots: Vec::new(),
        rules: Rules { grid_divisions: [1, 1, 1], ..Rules::default() },
        bounds: None,
    }
}

fn request() -> Request {
    let law = PowerLaw::fitted(16.0).expect("in the table");
    Request { criterion: Criterion::Energy, manner: Manner::Best, order: OrderRule::Exact, law }
}

/// A passage as wide as a robot: what fits through is a row along it.
fn row() -> Option<Passage> {
    Some(Passage { heading_rad: 0.0, width_m: W + 0.01, height_m: 0.28 })
}

#[test]
fn what_does_the_task_already_stays_as_it_is() {
    let problem = problem(&[[L, 0.0, 0.0, 0.0], [-L, 0.0, 0.0, 0.0]], true);
    let found = goal(&problem, &Task { services: Vec::new(), passage: row() }, &request()).expect("a goal");
    assert!(found.planned.plan.moves.is_empty() && found.proved, "{:?}", found.planned.plan.moves);
    // Both behind, one each side, both ahead; each robot at two headings.
    assert_eq!(found.configurations, 12);
}

/// Five robots, a T around a tool and one more, are to become a row with the sonar ahead.
#[test]
fn five_robots_find_a_row_with_the_sonar_ahead() {
    let starts = [[0.0, -W, 0.0, 0.0], [0.0, W, 0.0, 0.0], [-L, 0.0, 0.0, 0.0], [-2.0 * L, 0.0, 0.0, 0.0]];
    let problem = problem(&[&starts[..], &[[-3.0 * L, 0.0, 0.0, 0.0]]].concat(), true);
    let sonar = Service { capability: "sonar".to_owned(), place_m: [L, 0.0, 0.0], within_m: 0.1 };
    let task = Task { services: vec![sonar], passage: row() };
    let found = goal_with(&problem, &task, &request(), &InTurn, &mut Tries(8)).expect("a goal");
    println!(
        "{} configurations, {} tried, {:.2} J, proved {}",
        found.configurations, found.tried, found.planned.plan.energy_total_j, found.proved
    );
    assert!(judge::verify(&found.problem, &found.planned.plan).is_empty());
    let [first, ..] = &found.planned.plan.moves[..] else { panic!("nothing moves") };
    assert!(first.robot > 0 && found.planned.plan.moves.iter().any(|own| own.robot == 1));
}

/// Two wings of a tool are to pass a door: a row, with the sonar ahead; of all rows the cheapest.
#[test]
fn a_row_with_the_sonar_ahead_is_the_cheapest_of_all_rows() {
    let problem = problem(&[[0.0, W, 0.0, 0.0], [0.0, -W, 0.0, 0.0]], true);
    let sonar = |place_m: [f64; 3]| Service { capability: "sonar".to_owned(), place_m, within_m: 0.1 };
    let task = Task { services: vec![sonar([L, 0.0, 0.0])], passage: row() };
    let found = goal(&problem, &task, &request()).expect("a goal");
    let ahead = found.planned.plan.moves.iter().find(|own| own.robot == 1).expect("the sonar moves");
    let end = ahead.actions.last().expect("docks").to;
    assert!((end.position_m[0] - L).abs() < 1e-9 && end.position_m[1].abs() < 1e-9, "{end:?}");
    // By hand: the other one is behind the tool, or ahead of the sonar, at two headings each, as the sonar itself.
    assert_eq!(found.configurations, 8);
    let places = [-L, 2.0 * L];
    let mut least_j = f64::INFINITY;
    for x in places {
        for (first, second) in [(0.0, 0.0), (0.0, std::f64::consts::PI)] {
            let slot = |x: f64, yaw: f64, requires: &[&str]| Slot {
                pose: Pose::from([x, 0.0, 0.0, yaw]),
                requires: requires.iter().map(|name| (*name).to_owned()).collect(),
            };
            let by_hand =
                Problem { slots: vec![slot(L, first, &["sonar"]), slot(x, second, &[])], ..problem.clone() };
            if let Ok(planned) = plan(&by_hand, &request()) {
                least_j = least_j.min(planned.plan.energy_total_j);
            }
        }
    }
    let energy_j = found.planned.plan.energy_total_j;
    println!(
        "{} configurations, {} tried, {energy_j:.2} J, by hand {least_j:.2} J",
        found.configurations, found.tried
    );
    assert!(energy_j <= least_j * (1.0 + 1e-6), "{energy_j} J, by hand {least_j} J");
}

#[test]
fn what_no_configuration_can_do_is_said() {
    let problem = problem(&[[L, 0.0, 0.0, 0.0], [-L, 0.0, 0.0, 0.0]], true);
    let service = |capability: &str, place_m: [f64; 3]| Service {
        capability: capability.to_owned(),
        place_m,
        within_m: 0.1,
    };
    let asked = |services: Vec<Service>| goal(&problem, &Task { services, passage: row() }, &request());
    match asked(vec![service("drill", [L, 0.0, 0.0])]) {
        Err(MorphologyError::Incapable { capability }) => assert_eq!(capability, "drill"),
        other => panic!("{other:?}"),
    }
    match asked(vec![service("sonar", [0.0, 2.0, 0.0])]) {
        Err(error @ MorphologyError::Unfit { grown: 12, .. }) => {
            assert!(error.to_string().contains("12 lack a service"), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

/// Without a tool the first robot's place is kept; all pairs of two robots, counted by hand.
#[test]
fn pairs_are_counted() {
    let problem = problem(&[[0.0; 4], [0.0, W, 0.0, 0.0]], false);
    let (grown, cut) = growth::grown(&problem, &Task::default(), &|_| 0.0, &InTurn, &mut Endless);
    // At four sides with four headings each, above and below with four each.
    assert!(!cut && grown.len() == 24, "{}", grown.len());
}

/// The same with the edge of the water, and its margin, right ahead of the first robot: nothing is docked there, which is one side of six.
#[test]
fn nothing_grows_beyond_the_edge_of_the_water() {
    let mut problem = problem(&[[0.0; 4], [0.0, W, 0.0, 0.0]], false);
    let ahead_m = 0.5 * L + 0.15;
    let edge_m = vec![[-2.0, -2.0], [ahead_m, -2.0], [ahead_m, 2.0], [-2.0, 2.0]];
    problem.bounds = Some(Bounds { edge_m, margin_m: 0.1 });
    let (grown, cut) = growth::grown(&problem, &Task::default(), &|_| 0.0, &InTurn, &mut Endless);
    assert!(!cut && grown.len() == 20, "{}", grown.len());
    assert!(grown.iter().flatten().all(|place| place.pose.position_m[0] < 1e-9), "{grown:?}");
}

/// Five robots behind a tool, and a sonar three lengths ahead of it, where only a chain of three gets: there are far more configurations
/// of three and four than are grown on, and those that reach it are among them.
#[test]
fn a_service_far_ahead_is_reached_by_five_robots() {
    let starts: Vec<[f64; 4]> = (1..=5).map(|n| [-L * f64::from(n), 0.0, 0.0, 0.0]).collect();
    let problem = problem(&starts, true);
    let ahead = Service { capability: "sonar".to_owned(), place_m: [3.0 * L, 0.0, 0.0], within_m: 0.1 };
    let task = Task { services: vec![ahead], passage: None };
    let limits_n = limits_n(16.0).expect("in the table");
    let request = request();
    let judge = fitness::Fitness::new(&problem, &task, &request.law, limits_n).expect("robots");
    let (grown, cut) = growth::grown(
        &problem,
        &task,
        &|places: &[growth::Place]| judge.bound_j(places),
        &InTurn,
        &mut Endless,
    );
    let fit = grown.iter().filter(|places| judge.slots(places).is_ok()).count();
    println!("{fit} of {} do the task", grown.len());
    assert!(cut && fit > 0);
}

/// Runs jobs backwards: the result must not depend on which is done first.
struct Backwards;

impl Workers for Backwards {
    fn run(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).rev().for_each(job);
    }
}

/// Breaks off after so many plans were asked for.
struct Tries(usize);

impl GoalProgress for Tries {
    fn report(&mut self, search: &Search) -> ControlFlow<()> {
        if search.tried > self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Breaks off after so many reports, and keeps what it was told.
struct After(usize, Vec<Search>);

impl GoalProgress for After {
    fn report(&mut self, search: &Search) -> ControlFlow<()> {
        self.1.push(*search);
        if self.1.len() > self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Two wings of a tool that are to become two rows of a passage, with the sonar ahead.
fn two_rows() -> (Problem, Task) {
    let starts = [[0.0, -W, 0.0, 0.0], [0.0, W, 0.0, 0.0]];
    let passage = Passage { heading_rad: 0.0, width_m: 2.0 * W + 0.01, height_m: 0.28 };
    let sonar = Service { capability: "sonar".to_owned(), place_m: [L, 0.0, 0.0], within_m: 0.1 };
    (problem(&starts, true), Task { services: vec![sonar], passage: Some(passage) })
}

#[test]
fn the_order_of_jobs_does_not_matter_and_reports_close_in() {
    let (problem, task) = two_rows();
    let mut heard = After(usize::MAX, Vec::new());
    let [one, other] = [
        goal(&problem, &task, &request()).expect("a goal"),
        goal_with(&problem, &task, &request(), &Backwards, &mut heard).expect("a goal"),
    ];
    assert_eq!(one.planned.plan, other.planned.plan);
    assert_eq!((one.tried, one.proved, one.bound_j), (other.tried, other.proved, other.bound_j));
    let energy_j = one.planned.plan.energy_total_j;
    assert!(one.bound_j.is_none_or(|bound_j| bound_j <= energy_j), "{:?}, {energy_j}", one.bound_j);
    assert!(heard.1.iter().any(|search| !search.plans()) && heard.1.iter().any(Search::plans));
    let best = heard.1.iter().filter_map(|search| search.best_j);
    assert!(best.clone().zip(best.skip(1)).all(|(before, after)| after <= before), "{:?}", heard.1);
}

/// However early a search is ended: a goal that does the task, whose plan the judge passes, or a refusal for want of a plan; and nothing is
/// called proved that a longer search betters.
#[test]
fn a_search_that_is_ended_early_gives_what_it_has() {
    let (problem, task) = two_rows();
    let whole = goal(&problem, &task, &request()).expect("a goal");
    let mut found = 0;
    for patience in [0, 1, 3, 10, 30, 100, 300] {
        let mut early = After(patience, Vec::new());
        match goal_with(&problem, &task, &request(), &InTurn, &mut early) {
            Ok(goal) => {
                found += 1;
                assert!(judge::verify(&goal.problem, &goal.planned.plan).is_empty(), "{patience}");
                let [energy_j, least_j] = [&goal, &whole].map(|found| found.planned.plan.energy_total_j);
                assert!(
                    energy_j >= least_j * (1.0 - 1e-9) || !whole.proved,
                    "{patience}: {energy_j} {least_j}"
                );
                assert!(
                    !goal.proved || energy_j <= least_j * (1.0 + 1e-9),
                    "{patience}: {energy_j} {least_j}"
                );
                assert!(goal.bound_j.is_none_or(|bound_j| bound_j <= least_j * (1.0 + 1e-9)), "{patience}");
            }
            Err(MorphologyError::Unreachable { last: PlanError::OutOfPatience { .. }, .. }) => {}
            Err(other) => panic!("{patience}: {other}"),
        }
    }
    assert!(found >= 2, "{found} goals");
}

/// A configuration that does the task as it is costs nothing, which is least whatever was left out.
#[test]
fn robots_that_may_stay_are_proved_least() {
    let starts: Vec<[f64; 4]> =
        (0..8).map(|n| [L * f64::from(n % 4), W * f64::from(n / 4), 0.0, 0.0]).collect();
    let passage = Passage { heading_rad: 0.0, width_m: 2.0 * W + 0.01, height_m: 0.28 };
    let task = Task { services: Vec::new(), passage: Some(passage) };
    let found = goal(&problem(&starts, false), &task, &request()).expect("a goal");
    assert!(
        found.planned.plan.moves.is_empty() && found.proved,
        "{:.2} J",
        found.planned.plan.energy_total_j
    );
}
