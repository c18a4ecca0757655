//! Goals for tasks: against counts by hand, and against plans to every goal there is.

use quantity::bounds::Bounds;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Robot, Rules, Tool};
use reconfiguration::task::{Passage, Service};
use reconfiguration::vehicle::Vehicle;

use super::super::planner::OrderRule;
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
    let found = goal(&problem, &task, &request()).expect("a goal");
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
    let (grown, cut) = growth::grown(&problem, &Task::default(), |_| 0.0);
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
    let (grown, cut) = growth::grown(&problem, &Task::default(), |_| 0.0);
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
    let (grown, cut) = growth::grown(&problem, &task, |places| judge.bound_j(places));
    let mut refused = fitness::Refused::default();
    let fit = grown.iter().filter(|places| judge.slots(places, &mut refused).is_some()).count();
    println!("{fit} of {} do the task; {refused}", grown.len());
    assert!(cut && fit > 0, "{refused}");
}
