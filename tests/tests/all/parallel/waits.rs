//! What a parallel plan waits for, by a plan made by hand: who has arrived, why it holds, and the edge of the water.

use host::run::closed_loop::Drive;
use host::run::experiment::Pace;
use host::run::fleet::InProcess;
use host::run::hold::Hold;
use host::run::host::Controller;
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::reconfigure::controller::Execution;
use host::run::reconfigure::execution::{Executed, Options, run};
use link::faults::FaultParameters;
use protocol::time::FleetInstant;
use quantity::bounds::Bounds;
use reconfiguration::plan::{Action, ActionKind, Criterion, Interval, Manner, Move, Placed, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;
use rov::configuration::LevelBox;
use rov::docking::HAND_OVER_S;
use rov::power::PowerLaw;
use rov::propulsion::{Expense, Propulsion, Steady};
use sim::rov::Thrusters;

const SPEED_M_S: f64 = 0.2;
/// Where both robots start, where the first one parks, and both slots: the second robot's comes first.
const STARTS: [[f64; 4]; 2] = [[0.0, 0.0, 5.0, 0.0], [0.0, 2.0, 5.0, 0.0]];
const PARKED: [f64; 4] = [1.0, 0.0, 5.0, 0.0];
const SLOTS: [[f64; 4]; 2] = [[3.0, 2.0, 5.0, 0.0], [2.0, 0.0, 5.0, 0.0]];

fn law() -> PowerLaw {
    PowerLaw::fitted(16.0).expect("in the table")
}

/// Straight ahead, from the first place to the second one.
fn moved(robot: u16, slot: Option<usize>, start_s: f64, [from, to]: [[f64; 4]; 2]) -> Move {
    let rules = Rules::default();
    let vehicle = Vehicle::built_in("bluerov1").expect("built in");
    let propulsion = Propulsion::new(&vehicle, law(), &rules, Steady::Whole).expect("six degrees of freedom");
    let a = rules.acceleration_m_s2;
    let way = propulsion.leg([1.0, 0.0, 0.0], to[0] - from[0], SPEED_M_S, Some(a)).expect("within limits");
    let (from, to) = (Pose::from(from), Pose::from(to));
    let steps = [
        (ActionKind::Undock, from, from, Expense { duration_s: HAND_OVER_S, ..Expense::default() }),
        (ActionKind::Leg, from, to, way),
        (ActionKind::Dock, to, to, Expense::default()),
    ];
    let mut now_s = start_s;
    let actions: Vec<Action> = steps
        .into_iter()
        .map(|(kind, from, to, Expense { duration_s, energy_j, .. })| {
            let is_leg = kind == ActionKind::Leg;
            let (speed, acceleration) = if is_leg { (SPEED_M_S, Some(a)) } else { (0.0, None) };
            now_s += duration_s;
            let start_s = now_s - duration_s;
            Action { kind, start_s, duration_s, from, to, speed, acceleration, energy_j }
        })
        .collect();
    Move {
        robot,
        slot,
        to: slot.is_none().then_some(to),
        path: vec![from.position_m, to.position_m],
        start_s,
        duration_s: now_s - start_s,
        energy_navigate_j: way.energy_j,
        energy_balance_j: 0.0,
        balance_w: 0.0,
        balance: Vec::new(),
        actions,
    }
}

/// Robot 1 parks and goes on from there while robot 2 goes to its slot. Robots that feel nothing need no balance.
fn parking() -> (Problem, Plan) {
    let first = moved(1, None, 0.0, [STARTS[0], PARKED]);
    let second = moved(2, Some(0), 0.0, [STARTS[1], SLOTS[0]]);
    let on = moved(1, Some(1), first.duration_s + 2.0, [PARKED, SLOTS[1]]);
    let moves = vec![first, second, on];
    let mut cuts: Vec<f64> =
        moves.iter().flat_map(|own| [own.start_s, own.start_s + own.duration_s]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|b, a| *b - *a < 1e-9);
    let interval = |cut: &[f64]| Interval {
        start_s: cut[0],
        duration_s: cut[1] - cut[0],
        balance_w: 0.0,
        balance: Vec::new(),
    };
    let energy_navigate_j = moves.iter().map(|own| own.energy_navigate_j).sum();
    let plan = Plan {
        problem: "parking".to_owned(),
        criterion: Criterion::Energy,
        manner: Manner::Best,
        robots: (1..).zip(STARTS).map(|(id, start)| Placed { id, start: start.into() }).collect(),
        slots: SLOTS.map(Pose::from).to_vec(),
        intervals: cuts.windows(2).map(interval).collect(),
        energy_navigate_j,
        energy_balance_j: 0.0,
        energy_total_j: energy_navigate_j,
        time_s: cuts.last().copied().unwrap_or_default(),
        moves,
        lower_bound_j: None,
        gap: None,
        proved: None,
    };
    let robot = |(id, start): (u16, [f64; 4])| Robot {
        id,
        vehicle: 0,
        start: start.into(),
        capabilities: Vec::new(),
    };
    let problem = Problem {
        name: plan.problem.clone(),
        description: String::new(),
        vehicles: vec![Vehicle::built_in("bluerov1").expect("built in")],
        robots: (1..).zip(STARTS).map(robot).collect(),
        tools: Vec::new(),
        slots: SLOTS.map(|pose| Slot { pose: pose.into(), requires: Vec::new() }).to_vec(),
        rules: Rules::default(),
        bounds: None,
    };
    (problem, plan)
}

/// Executes the plan; robot 2 hears nothing from one time of the plan to another, s. Reasons to hold, in the order in which they come.
fn executed(problem: &Problem, plan: &Plan, silent_s: [f64; 2]) -> (Executed, Vec<Hold>) {
    disturbed(problem, plan, silent_s, None)
}

/// The same; from a time of the plan on, s, both thrusters that push robot 2 ahead are out of order.
fn disturbed(
    problem: &Problem,
    plan: &Plan,
    silent_s: [f64; 2],
    fails_s: Option<f64>,
) -> (Executed, Vec<Hold>) {
    let options = Options { seed: 1, radio: FaultParameters::default(), law: law() };
    let mut fleet = InProcess::<Thrusters>::rovs(problem, options.radio, options.seed).expect("a fleet");
    let mut holds = Vec::new();
    let mut hook = |now: FleetInstant, execution: &Execution<'_>, fleet: &mut InProcess<Thrusters>| {
        let Some(origin) = execution.origin() else { return };
        let t_s = now.as_secs_f64() - origin.as_secs_f64();
        let loss = f64::from(u8::from((silent_s[0]..silent_s[1]).contains(&t_s)));
        fleet.modules_mut()[1]
            .radio_mut()
            .set_parameters(FaultParameters { loss, ..FaultParameters::default() });
        if fails_s.is_some_and(|fails_s| t_s >= fails_s) {
            [0, 1].into_iter().for_each(|thruster| fleet.modules_mut()[1].set_failed(thruster));
        }
        if !execution.gets_on() && holds.last() != Some(&execution.hold()) {
            holds.push(execution.hold());
        }
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
    let executed = run(problem, plan, &options, &mut fleet, drive, &mut Quiet).expect("begun");
    (executed, holds)
}

/// A robot that only parks has not arrived: it is to move again.
#[test]
fn a_robot_that_parks_has_not_arrived() {
    let (problem, plan) = parking();
    let (Executed { record, summary, .. }, holds) = executed(&problem, &plan, [0.0; 2]);
    assert_eq!((summary.failure, holds), (None, Vec::new()));
    let (parks_s, goes_on_s) = (plan.moves[0].duration_s + 0.5, plan.moves[2].start_s);
    let parked: Vec<bool> = record
        .samples
        .iter()
        .filter(|sample| (parks_s..goes_on_s).contains(&sample.t_s))
        .map(|sample| sample.robots[0].arrived)
        .collect();
    assert!(parked.len() > 10 && parked.iter().all(|arrived| !arrived), "{parked:?}");
    let last = record.samples.last().expect("samples");
    assert!(last.robots.iter().all(|robot| robot.arrived));
}

/// A mover that does not answer is why the plan waits.
#[test]
fn a_robot_under_way_that_is_silent_is_the_reason_to_hold() {
    let (problem, plan) = parking();
    let from_s = plan.moves[1].start_s + 0.5 * plan.moves[1].duration_s;
    let (Executed { summary, .. }, holds) = executed(&problem, &plan, [from_s, from_s + 3.0]);
    assert_eq!(summary.failure, None);
    assert_eq!(holds.first(), Some(&Hold::Module), "{holds:?}");
    println!("{holds:?}");
}

/// A mover that answers and is no longer on its path is another reason: all others wait for it, and the run ends by its name.
#[test]
fn a_robot_under_way_that_is_off_its_path_is_the_reason_to_hold() {
    let (problem, plan) = parking();
    let from_s = plan.moves[1].start_s + 0.5 * plan.moves[1].duration_s;
    let (Executed { record, summary, .. }, holds) = disturbed(&problem, &plan, [0.0; 2], Some(from_s));
    assert_eq!(holds, [Hold::Astray]);
    let failure = summary.failure.expect("it never arrives");
    assert!(failure.contains("robot 2") && !failure.contains("robot 1"), "{failure}");
    println!("{failure}");
    // Robot 1, under way again by then, waits for it on its own way.
    let waits = &record.samples.last().expect("samples").robots[0];
    assert!(!waits.arrived && waits.eta[0] < SLOTS[1][0] - 0.1, "{:?}", waits.eta);
}

/// A plan that leads robot 2 out of the water: it waits before, and ends by name.
#[test]
fn a_plan_does_not_go_on_towards_the_edge_of_the_water() {
    let (mut problem, plan) = parking();
    // Its bow would be 0.2415 m further than its slot, at 3.0 m.
    let edge_m = vec![[-2.0, -2.0], [3.0, -2.0], [3.0, 4.0], [-2.0, 4.0]];
    let bounds = Bounds { edge_m, margin_m: 0.4 };
    problem.bounds = Some(bounds.clone());
    let (Executed { record, summary, .. }, holds) = executed(&problem, &plan, [0.0; 2]);
    let failure = summary.failure.expect("it cannot be done");
    assert!(
        failure.contains("robot 2") && failure.contains("too near to the edge of the water"),
        "{failure}"
    );
    assert_eq!(holds, [Hold::Bounds]);
    let vehicle = &problem.vehicles[0];
    let hulls = record.samples.iter().flat_map(|sample| &sample.robots);
    let room_m = hulls.map(|robot| {
        let pose = Pose::from([robot.eta[0], robot.eta[1], robot.eta[2], robot.eta[5]]);
        bounds.room_m(&LevelBox::around(pose, vehicle).outline_m())
    });
    let least_m = room_m.fold(f64::INFINITY, f64::min);
    println!("least room of a hull: {least_m:.3} m");
    // At half of the margin the time of the plan begins to stand still, which takes 0.1 m at 0.2 m/s.
    assert!((0.05..0.2).contains(&least_m), "{least_m} m");
}
