//! Reconfigurations at any heading before the judge, by both manners and both criteria. `FLOTILLA_TURNED` sets how many problems.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

use judge::verify;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;
use rov::conditions::Conditions;
use rov::order::{InTurn, Known, Progress};
use rov::planner::{OrderRule, PATIENCE, PlanError, Planned, Request, plan, plan_with};
use rov::power::PowerLaw;
use tests::seeds::{number, on_all_cores};
use tests::turned::problem;

const SEEDS: u64 = 5;
/// Where the paper's rule leads nowhere by the paper's manner, all orders of so many robots are searched.
const SEARCHED: usize = 4;
const WAYS: [(Manner, Criterion); 4] = [
    (Manner::Best, Criterion::Energy),
    (Manner::Best, Criterion::Euclidean),
    (Manner::Paper, Criterion::Energy),
    (Manner::Paper, Criterion::Euclidean),
];

fn request(problem: &Problem, (manner, criterion): (Manner, Criterion), order: OrderRule) -> Request {
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("in the table");
    Request { criterion, manner, order, law }
}

fn planned(problem: &Problem, way: (Manner, Criterion), order: OrderRule) -> Result<Planned, PlanError> {
    plan(problem, &request(problem, way, order))
}

/// Moves that a search prices before it is given up without an order. Of 200 problems one takes more than [`PATIENCE`] to prove that there is
/// none.
const PRICED_MOST: usize = 50 * PATIENCE;

/// Ends a search with the first order that it knows.
struct First;

impl Progress for First {
    fn report(&mut self, known: &Known) -> ControlFlow<()> {
        if known.best.is_some() || known.priced >= PRICED_MOST {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

fn judged(problem: &Problem, planned: &Planned, what: &str) {
    let found = verify(problem, &planned.plan);
    assert!(found.is_empty(), "{what}: {}", found.iter().map(|v| format!("\n  {v}")).collect::<String>());
}

/// What became of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    /// The least g + h next.
    ByRule,
    /// That leads nowhere, another order does.
    ByOtherOrder,
    /// The rule leads nowhere: every robot that waits was looked at with every slot.
    DeadEnd,
    /// No order leads there: every configuration was looked at.
    NoOrder,
    /// The search was given up.
    Open,
}

fn end(problem: &Problem, way: (Manner, Criterion), what: &str) -> Fate {
    let found = match planned(problem, way, OrderRule::Paper) {
        Ok(planned) => Ok((planned, Fate::ByRule)),
        Err(PlanError::DeadEnd { why, moves }) => {
            assert!(moves < problem.robots.len() && why.contains("robot"), "{what}: {why}");
            // A robot that chooses where it turns is told from the paper's by no more than that: what is closed by the grid is a fault.
            if why.contains("though there is one") {
                println!("{what}: {why}");
            }
            if way.0 == Manner::Paper && problem.robots.len() > SEARCHED {
                return Fate::DeadEnd;
            }
            let searched = request(problem, way, OrderRule::Exact);
            plan_with(problem, &searched, &InTurn, &mut First).map(|planned| (planned, Fate::ByOtherOrder))
        }
        Err(error) => Err(error),
    };
    match found {
        Ok((planned, end)) => {
            judged(problem, &planned, what);
            end
        }
        Err(PlanError::Unreachable { .. } | PlanError::Blocked { .. }) => Fate::NoOrder,
        Err(PlanError::OutOfPatience { .. }) => Fate::Open,
        Err(error) => panic!("{what}: {error}"),
    }
}

#[test]
fn plans_at_any_heading_pass_the_judge() {
    let seeds = number("FLOTILLA_TURNED").unwrap_or(SEEDS);
    let results = on_all_cores(0..seeds, |seed| {
        let problem = problem(&mut ChaCha8Rng::seed_from_u64(seed));
        WAYS.map(|way| end(&problem, way, &format!("seed {seed}, {}, {way:?}", problem.description)))
    });
    for (index, way) in WAYS.into_iter().enumerate() {
        let mut ends: BTreeMap<Fate, usize> = BTreeMap::new();
        results.iter().for_each(|result| *ends.entry(result[index]).or_default() += 1);
        let count = |end: Fate| ends.get(&end).copied().unwrap_or_default();
        println!("{way:?}: {ends:?} of {seeds}; every plan passes the judge");
        let plans = (count(Fate::ByRule) + count(Fate::ByOtherOrder)) as f64;
        assert_eq!(count(Fate::Open), 0, "{way:?}: {ends:?}");
        let least = if way.0 == Manner::Best { 0.9 } else { 0.7 };
        assert!(plans >= least * seeds as f64, "{way:?}: {ends:?}");
    }
}

/// Two robots in line go to two slots side by side, a quarter turn away.
#[test]
fn two_robots_that_turn_pass_the_judge() {
    let robot = Vehicle::built_in("bluerov1").expect("it comes with the program");
    let start = |id: u16| [f64::from(id - 1) * 0.483, 0.0, 5.0, 0.0].into();
    let slot = |y: f64| Slot { pose: [3.0, y, 5.0, FRAC_PI_2].into(), requires: Vec::new() };
    let problem = Problem {
        name: "min2".to_owned(),
        description: String::new(),
        vehicles: vec![robot],
        robots: [1, 2]
            .map(|id| Robot { id, vehicle: 0, start: start(id), capabilities: Vec::new() })
            .to_vec(),
        tools: Vec::new(),
        slots: vec![slot(0.0), slot(0.483)],
        rules: Rules::default(),
        bounds: None,
    };
    problem.check().expect("a sound problem");
    for way in WAYS {
        for order in [OrderRule::Paper, OrderRule::Exact] {
            let planned = planned(&problem, way, order).expect("a plan");
            judged(&problem, &planned, &format!("{way:?}, {order:?}"));
            assert_eq!(planned.plan.moves.len(), 2);
        }
    }
}

/// The middle one of three side by side is to face about, where it has no room. By the paper's rules it swims its height up or down, which
/// is the nearest place where it has, and back; turned nearer, it would run into the others.
#[test]
fn a_robot_between_others_faces_about_by_the_papers_rules() {
    let [_, width_m, height_m] = Vehicle::built_in("bluerov1").expect("it comes with the program").box_m;
    let at = |row: f64, yaw: f64| [0.0, row * width_m, 5.0, yaw];
    let brings = |row: f64| if row == 0.0 { vec!["faces about".to_owned()] } else { Vec::new() };
    let rows = [-1.0, 0.0, 1.0];
    let robot = |(id, row): (u16, f64)| Robot {
        id,
        vehicle: 0,
        start: at(row, 0.0).into(),
        capabilities: brings(row),
    };
    let slot = |row: f64| Slot {
        pose: at(row, if row == 0.0 { 2.0 * FRAC_PI_2 } else { 0.0 }).into(),
        requires: brings(row),
    };
    let problem = Problem {
        name: "about".to_owned(),
        description: String::new(),
        vehicles: vec![Vehicle::built_in("bluerov1").expect("it comes with the program")],
        robots: (1..).zip(rows).map(robot).collect(),
        tools: Vec::new(),
        slots: rows.map(slot).to_vec(),
        rules: Rules::default(),
        bounds: None,
    };
    problem.check().expect("a sound problem");
    for way in &WAYS[2..] {
        let planned = planned(&problem, *way, OrderRule::Paper).expect("a plan");
        judged(&problem, &planned, &format!("{way:?}"));
        let [own] = &planned.plan.moves[..] else { panic!("{way:?}: {:?}", planned.plan.moves) };
        let out_m: [f64; 3] = std::array::from_fn(|k| own.path[1][k] - own.path[0][k]);
        assert_eq!((own.robot, own.path.len()), (2, 3), "{way:?}");
        assert!(
            out_m[0].abs() < 1e-9 && out_m[1].abs() < 1e-9 && (out_m[2].abs() - height_m).abs() < 1e-9,
            "{out_m:?}"
        );
        let mut nearer = planned.clone();
        for action in &mut nearer.plan.moves[0].actions {
            for end in [&mut action.from, &mut action.to] {
                end.position_m[2] = 5.0 + 0.8 * (end.position_m[2] - 5.0);
            }
        }
        let found = verify(&problem, &nearer.plan);
        assert!(found.iter().any(|v| v.message.contains("no room to turn beside robot 1")), "{found:?}");
    }
}
