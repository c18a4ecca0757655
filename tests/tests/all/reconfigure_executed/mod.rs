//! Plans of reconfigurations, executed: planner, link, firmware and water together, with faults in them.

use host::run::RunError;
use host::run::closed_loop::Drive;
use host::run::experiment::Pace;
use host::run::fleet::InProcess;
use host::run::host::Controller;
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::reconfigure::ExecutionError;
use host::run::reconfigure::controller::Execution;
use host::run::reconfigure::execution::{Executed, Options, execute, run};
use host::run::reconfigure::scenario::ReconfigureScenario;
use link::faults::FaultParameters;
use protocol::time::{Duration, FleetInstant};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::plan::{Action, ActionKind, Criterion, Manner, Move, Placed, Plan, destination};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;
use rov::planner::{OrderRule, PlanError, Request, plan};
use rov::power::PowerLaw;
use rov::propulsion::{Propulsion, Steady};
use sim::rov::Thrusters;
use std::f64::consts::FRAC_PI_2;
use tests::reconfigure::{self as random, Kind};

mod udp;

fn law() -> PowerLaw {
    PowerLaw::fitted(16.0).expect("in the table")
}

fn options(seed: u64) -> Options {
    Options { seed, radio: FaultParameters::default(), law: law() }
}

fn problem(name: &str) -> Problem {
    ReconfigureScenario::open(name).expect("built in").problem
}

fn planned(problem: &Problem, manner: Manner) -> Plan {
    let request = Request { criterion: Criterion::Energy, manner, order: OrderRule::Paper, law: law() };
    plan(problem, &request).unwrap_or_else(|error| panic!("{}: {error}", problem.name)).plan
}

type Rovs = InProcess<Thrusters>;

/// Runs in this process; `hook` is called with the time since the beginning of the plan, s.
fn with_faults(
    problem: &Problem,
    plan: &Plan,
    options: &Options,
    hook: &mut dyn FnMut(FleetInstant, f64, &mut Rovs),
) -> Executed {
    let mut fleet = InProcess::rovs(problem, options.radio, options.seed).expect("a fleet");
    let mut at = |now: FleetInstant, controller: &Execution<'_>, fleet: &mut Rovs| {
        let origin = controller.origin();
        hook(now, origin.map_or(-1.0, |origin| now.as_secs_f64() - origin.as_secs_f64()), fleet);
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut at };
    run(problem, plan, options, &mut fleet, drive, &mut Quiet)
        .unwrap_or_else(|error| panic!("seed {}: {error}", options.seed))
}

fn show(what: &str, executed: &Executed) {
    let summary = &executed.summary;
    println!(
        "{what}: executed/planned {:.4}, run in {:.2} s",
        summary.ratio.unwrap_or(f64::NAN),
        summary.wall_s
    );
    for (name, energy) in [
        ("planned", summary.planned),
        ("expected", summary.expected),
        ("executed", summary.executed),
        ("by table", summary.by_table),
    ] {
        let (navigate_j, balance_j) = (energy.navigate_j, energy.balance_j);
        println!(
            "  {name:9} {navigate_j:7.2} + {balance_j:6.2} = {:7.2} J in {:6.2} s",
            energy.total_j, energy.time_s
        );
    }
    for of in &summary.moves {
        println!(
            "  robot {} into {}: {:.2} J of {:.2} in {:.2} s of {:.2}; beside {:.1} mm, gap {:.1} mm, drawn in from {:.1} mm, {:.2}°",
            of.robot,
            destination(of.slot),
            of.executed.total_j,
            of.planned.total_j,
            of.executed.time_s,
            of.planned.time_s,
            of.cross_track_m * 1e3,
            of.least_gap_m.unwrap_or(f64::NAN) * 1e3,
            of.end_m.unwrap_or(f64::NAN) * 1e3,
            of.end_rad.unwrap_or(f64::NAN).to_degrees()
        );
    }
    if let Some(failure) = &summary.failure {
        println!("  {failure}");
    }
}

/// The greatest roll or pitch of a robot that moves and of one that waits, rad.
fn tilts(executed: &Executed) -> (f64, f64) {
    let Executed { record, .. } = executed;
    let (mut moving_rad, mut waiting_rad) = (0.0_f64, 0.0_f64);
    for sample in &record.samples {
        let mover = sample.moving.map(|number| record.plan.moves[number].robot);
        for (robot, of) in record.problem.robots.iter().zip(&sample.robots) {
            let most_rad = if mover == Some(robot.id) { &mut moving_rad } else { &mut waiting_rad };
            *most_rad = most_rad.max(of.eta[3].abs()).max(of.eta[4].abs());
        }
    }
    (moving_rad, waiting_rad)
}

/// Every robot is in its slot, level; no waiting robot has been tilted; the ledger is exact.
fn all_arrived(executed: &Executed) {
    let Executed { record, summary, .. } = executed;
    let seed = summary.seed;
    assert_eq!(summary.failure, None, "seed {seed}");
    let last = record.samples.last().expect("samples");
    for of in &record.plan.moves {
        let index = record.problem.robots.iter().position(|robot| robot.id == of.robot).expect("known");
        let Some(slot) = of.slot.map(|slot| record.plan.slots[slot]) else { continue };
        let eta = last.robots[index].eta;
        let off_m = (0..3).map(|k| (eta[k] - slot.position_m[k]).powi(2)).sum::<f64>().sqrt();
        let turned_rad = quantity::wrap_rad(eta[5] - slot.yaw_rad).abs();
        println!("  robot {} rests {:.2} mm and {turned_rad:.4} rad off its slot", of.robot, 1e3 * off_m);
        assert!(
            last.robots[index].arrived && off_m < 0.006 && turned_rad < 0.004,
            "robot {}: {eta:?}",
            of.robot
        );
    }
    let (moving_rad, waiting_rad) = tilts(executed);
    println!(
        "  seed {seed}: tilted by at most {moving_rad:.4} rad in a move, {waiting_rad:.4} while waiting"
    );
    // Twice what was seen.
    assert!(moving_rad < 0.03 && waiting_rad < 0.012, "seed {seed}");
    for link in &summary.link {
        let ledger = link.ledger;
        assert!(ledger.cycles > 0 && ledger.open() <= 1, "seed {seed}, robot {}: {ledger:?}", link.module);
        let (out, incoming) = (link.to_module, link.from_module);
        assert_eq!(out.sent, out.acknowledged + out.late + out.lost + out.under_way(), "{out:?}");
        assert!(incoming.is_exact() && incoming.forged + incoming.foreign == 0, "seed {seed}: {incoming:?}");
        // One that has just come back refuses until it knows the fleet time again.
        assert!(ledger.refused <= 10 * summary.reboots, "seed {seed}, robot {}: {ledger:?}", link.module);
    }
}

/// Within twice the 1.2 % that are seen, by the table's law 2.8 %.
fn near(executed_j: f64, wanted_j: f64, most: f64, what: &str) {
    assert!((executed_j / wanted_j - 1.0).abs() < most, "{what}: {executed_j} J against {wanted_j} J");
}
const SMOOTH: f64 = 0.025;
/// Balancing alone, of which handing over is the rest: 1.4 % were seen.
const BALANCE: f64 = 0.03;
const BY_TABLE: f64 = 0.055;
/// Random problems: 3 % at most were seen.
const RANDOM: f64 = 0.06;
/// Plans by the paper's rules, of which ramps and corners are reckoned, not planned.
const PAPER: f64 = 0.06;

#[test]
fn executed_energy_is_the_planned_one() {
    for name in ["t-to-i-far", "t-to-i-below"] {
        let problem = problem(name);
        let executed =
            execute(&problem, &planned(&problem, Manner::Best), &options(1), &mut Quiet).expect("begun");
        show(name, &executed);
        all_arrived(&executed);
        let summary = &executed.summary;
        near(summary.executed.total_j, summary.planned.total_j, SMOOTH, name);
        near(summary.executed.navigate_j, summary.planned.navigate_j, SMOOTH, name);
        near(summary.executed.balance_j, summary.planned.balance_j, BALANCE, name);
        // 0.3 s a move to hand over, and the rest of a packet.
        let late_s = summary.executed.time_s - summary.planned.time_s;
        assert!(late_s < 0.5 * summary.moves.len() as f64, "{name}: {late_s} s late");
        for of in &summary.moves {
            assert!(of.cross_track_m < 0.004, "{name}: {of:?}");
            // Hulls part and meet along their faces.
            assert!(of.least_gap_m.is_some_and(|gap_m| gap_m > -0.0046), "{name}: {of:?}");
        }
    }
}

/// The table's steps are allocated along by a linear program, from corner to corner: the thrusts follow all the same.
#[test]
fn the_measured_table_can_be_planned_and_executed_by() {
    let problem = problem("t-to-i-far");
    let law = PowerLaw::table(16.0).expect("in the table");
    let (criterion, manner, order) = (Criterion::Energy, Manner::Best, OrderRule::Paper);
    let request = Request { criterion, manner, order, law: law.clone() };
    let plan = plan(&problem, &request).expect("planned").plan;
    let executed = execute(&problem, &plan, &Options { law, ..options(1) }, &mut Quiet).expect("begun");
    show("by the table", &executed);
    all_arrived(&executed);
    near(executed.summary.executed.total_j, plan.energy_total_j, BY_TABLE, "by the table");
}

/// Whatever can be planned can be executed, planar and in space, with and without a tool.
#[test]
fn random_reconfigurations_are_executed() {
    const SEEDS: u64 = 16;
    let (mut ratios, mut dead_ends) = (Vec::new(), 0);
    for seed in 0..SEEDS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kind = Kind { robots: rng.random_range(3..=5), ..Kind::random(&mut rng) };
        let problem = random::problem(kind, &mut rng);
        let (criterion, manner, order) = (Criterion::Energy, Manner::Best, OrderRule::Paper);
        let planned = match plan(&problem, &Request { criterion, manner, order, law: law() }) {
            Ok(planned) => planned,
            // The paper's order may lead to where no robot can move.
            Err(PlanError::DeadEnd { .. }) => {
                dead_ends += 1;
                continue;
            }
            Err(error) => panic!("seed {seed}, {kind:?}: {error}"),
        };
        let executed = execute(&problem, &planned.plan, &options(seed), &mut Quiet).expect("begun");
        let ratio = executed.summary.ratio.expect("a robot moved");
        println!("seed {seed}, {kind:?}: {:.2} J, executed/planned {ratio:.4}", planned.plan.energy_total_j);
        all_arrived(&executed);
        assert!((ratio - 1.0).abs() < RANDOM, "seed {seed}: {ratio}");
        ratios.push(ratio);
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let most = ratios.iter().fold(0.0, |most: f64, ratio| most.max((ratio - 1.0).abs()));
    println!(
        "{} executed, executed/planned {mean:.4} on average, off by {most:.4} at most; {dead_ends} dead ends",
        ratios.len()
    );
    // One was seen to be.
    assert!(dead_ends <= 2, "{dead_ends} of {SEEDS} problems came to a dead end");
}

/// The paper's plans know no acceleration. Executed with it they take longer and draw more; how much is expected.
#[test]
fn plans_by_the_papers_rules_take_what_acceleration_adds() {
    for name in ["t-to-i-far", "t-to-i-below"] {
        let problem = problem(name);
        let executed =
            execute(&problem, &planned(&problem, Manner::Paper), &options(1), &mut Quiet).expect("begun");
        show(&format!("{name}, the paper's rules"), &executed);
        all_arrived(&executed);
        let summary = &executed.summary;
        near(summary.executed.total_j, summary.expected.total_j, PAPER, name);
        assert!(summary.executed.total_j > summary.planned.total_j, "{name}");
    }
}

#[test]
fn a_fifth_of_the_datagrams_lost_changes_little() {
    let problem = problem("t-to-i-far");
    let plan = planned(&problem, Manner::Best);
    let radio = FaultParameters { loss: 0.2, duplication: 0.05, jitter_s: 0.02, ..Default::default() };
    for seed in [1, 2] {
        let executed =
            execute(&problem, &plan, &Options { radio, ..options(seed) }, &mut Quiet).expect("begun");
        show(&format!("a fifth lost, seed {seed}"), &executed);
        all_arrived(&executed);
        near(executed.summary.executed.total_j, executed.summary.planned.total_j, SMOOTH, "a fifth lost");
        let faults = executed.summary.faults.expect("in process");
        assert!(faults.lost * 6 > faults.sent, "{faults:?}");
    }
}

/// Round to the other robot's back, turning on the way.
const ROUND: [(ActionKind, [f64; 4], f64); 6] = [
    (ActionKind::Leg, [0.0, 1.1, -0.2, 0.0], 0.25),
    (ActionKind::Turn, [0.0, 1.1, -0.2, -FRAC_PI_2], 0.8),
    (ActionKind::Leg, [-1.4, 0.0, -0.2, -FRAC_PI_2], 0.25),
    (ActionKind::Turn, [-1.4, 0.0, -0.2, 0.0], 0.8),
    (ActionKind::Leg, [-1.4, 0.0, 0.0, 0.0], 0.2),
    (ActionKind::Leg, [-0.483, 0.0, 0.0, 0.0], 0.4),
];

/// Two robots side by side, 3 and 7; the second one goes that way to the first one's back.
fn pair(way: &[(ActionKind, [f64; 4], f64)]) -> (Problem, Plan) {
    let robot = Vehicle::built_in("bluerov1").expect("built in");
    let rules = Rules::default();
    let start = [Pose::from([0.0; 4]), Pose::from([0.0, 0.33, 0.0, 0.0])];
    let slots = [start[0], Pose::from([-0.483, 0.0, 0.0, 0.0])];
    let propulsion = Propulsion::new(&robot, law(), &rules, Steady::Whole).expect("six degrees of freedom");
    let mut actions: Vec<Action> = Vec::new();
    let mut at = start[1];
    let mut act = |kind: ActionKind, to: [f64; 4], speed: f64| {
        let to = Pose::from(to);
        let way: [f64; 3] = std::array::from_fn(|k| to.position_m[k] - at.position_m[k]);
        let length_m = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (sin, cos) = at.yaw_rad.sin_cos();
        let [x, y, z] = way.map(|x| x / length_m);
        let (expense, acceleration) = match kind {
            ActionKind::Leg => {
                let body = [cos * x + sin * y, cos * y - sin * x, z];
                let a = rules.acceleration_m_s2;
                (propulsion.leg(body, length_m, speed, Some(a)).expect("within limits"), Some(a))
            }
            ActionKind::Turn => {
                let a = rules.yaw_acceleration_rad_s2;
                (propulsion.turn(to.yaw_rad - at.yaw_rad, speed, Some(a)).expect("within limits"), Some(a))
            }
            _ => (rov::propulsion::Expense::default(), None),
        };
        let start_s = actions.last().map_or(0.0, |last| last.start_s + last.duration_s);
        let (duration_s, energy_j) = (expense.duration_s, expense.energy_j);
        actions.push(Action { kind, start_s, duration_s, from: at, to, speed, acceleration, energy_j });
        at = to;
    };
    act(ActionKind::Undock, start[1].into(), 0.0);
    for &(kind, to, speed) in way {
        act(kind, to, speed);
    }
    act(ActionKind::Dock, slots[1].into(), 0.0);
    let duration_s: f64 = actions.iter().map(|action| action.duration_s).sum();
    let energy_j: f64 = actions.iter().map(|action| action.energy_j).sum();
    let moved = Move {
        robot: 7,
        slot: Some(1),
        to: None,
        path: actions.iter().map(|action| action.to.position_m).collect(),
        start_s: 0.0,
        duration_s,
        energy_navigate_j: energy_j,
        energy_balance_j: 0.0,
        balance_w: 0.0,
        balance: Vec::new(),
        actions,
    };
    let ids = [3, 7];
    let problem = Problem {
        name: "pair".to_owned(),
        description: String::new(),
        vehicles: vec![robot],
        robots: (ids.iter().zip(start))
            .map(|(&id, start)| Robot { id, vehicle: 0, start, capabilities: Vec::new() })
            .collect(),
        tools: Vec::new(),
        slots: slots.map(|pose| Slot { pose, requires: Vec::new() }).to_vec(),
        rules,
        bounds: None,
    };
    let plan = Plan {
        problem: problem.name.clone(),
        criterion: Criterion::Energy,
        manner: Manner::Best,
        robots: ids.iter().zip(start).map(|(&id, start)| Placed { id, start }).collect(),
        slots: slots.to_vec(),
        moves: vec![moved],
        intervals: Vec::new(),
        energy_navigate_j: energy_j,
        energy_balance_j: 0.0,
        energy_total_j: energy_j,
        time_s: duration_s,
        lower_bound_j: None,
        gap: None,
        proved: None,
    };
    (problem, plan)
}

#[test]
fn a_plan_made_by_hand_is_followed_and_a_seed_reproduces_it() {
    let (problem, plan) = pair(&ROUND);
    let executed = execute(&problem, &plan, &options(3), &mut Quiet).expect("begun");
    show("by hand", &executed);
    all_arrived(&executed);
    near(executed.summary.executed.total_j, plan.energy_total_j, SMOOTH, "by hand");
    let samples = &executed.record.samples;
    let mut behind_m = 0.0_f64;
    for (k, sample) in samples[..samples.len() - 1].iter().enumerate() {
        assert!((sample.t_s - k as f64 * 0.05).abs() < 1e-9, "evenly spaced");
        if let Some(reference) = sample.robots[1].reference {
            let eta = sample.robots[1].eta;
            let off_m = (0..3).map(|k| (eta[k] - reference.position_m[k]).powi(2)).sum::<f64>().sqrt();
            behind_m = behind_m.max(off_m);
        }
    }
    println!("  at most {:.1} mm behind its reference", 1e3 * behind_m);
    assert!(behind_m < 0.01, "{behind_m} m behind");
    let again = execute(&problem, &plan, &options(3), &mut Quiet).expect("begun");
    assert!((again.summary.executed.total_j - executed.summary.executed.total_j).abs() < 1e-12);
}

/// Its thrusters stop, it drifts, arms, comes back to where its reference waits, and goes on.
#[test]
fn a_mover_that_loses_its_power_comes_back_and_finishes() {
    let (problem, plan) = pair(&ROUND);
    let mut cut = false;
    let executed = with_faults(&problem, &plan, &options(4), &mut |now, t_s, fleet| {
        if t_s > 7.0 && !std::mem::replace(&mut cut, true) {
            fleet.modules_mut()[1].reboot(now, Duration(500_000));
        }
    });
    show("power lost for half a second", &executed);
    all_arrived(&executed);
    assert_eq!(executed.summary.reboots, 1);
    let dead = executed.record.samples.iter().filter(|sample| (7.1..10.3).contains(&sample.t_s));
    for sample in dead {
        let pulses_us = &sample.robots[1].pulses_us;
        assert!(pulses_us.iter().all(|us| (us - 1500.0).abs() < 1e-3), "{} s: {pulses_us:?}", sample.t_s);
    }
    let late_s = executed.summary.executed.time_s - plan.time_s;
    assert!((3.0..12.0).contains(&late_s), "{late_s} s late, where 6 were seen");
}

#[test]
fn a_mover_that_stays_away_ends_the_run_by_name() {
    let (problem, plan) = pair(&ROUND);
    let mut cut = false;
    let executed = with_faults(&problem, &plan, &options(5), &mut |now, t_s, fleet| {
        if t_s > 3.0 && !std::mem::replace(&mut cut, true) {
            fleet.modules_mut()[1].reboot(now, Duration(600_000_000));
        }
    });
    show("power lost for good", &executed);
    let failure = executed.summary.failure.expect("no robot moves");
    assert!(failure.starts_with("robot 7, move 1, on a leg:"), "{failure}");
    assert!(failure.ends_with("for 20 s (it does not answer)"), "{failure}");
    assert!(executed.record.samples.len() > 20 * 20 && executed.summary.moves[0].end_m.is_none());
}

/// A robot that waits loses its power for a while: the others of its cluster hold the tool level without it.
#[test]
fn the_others_balance_for_one_that_is_silent() {
    let problem = problem("t-to-i-far");
    let plan = planned(&problem, Manner::Best);
    let waits = (problem.robots.iter()).position(|robot| robot.id == plan.moves[3].robot).expect("known");
    let mut cut = false;
    let executed = with_faults(&problem, &plan, &options(6), &mut |now, t_s, fleet| {
        if t_s > 4.0 && !std::mem::replace(&mut cut, true) {
            fleet.modules_mut()[waits].reboot(now, Duration(2_000_000));
        }
    });
    show("one silent", &executed);
    all_arrived(&executed);
    assert_eq!(executed.summary.reboots, 1);
}

#[test]
fn plans_of_something_else_are_refused() {
    let (problem, plan) = pair(&ROUND);
    let refused = |change: &dyn Fn(&mut Plan)| {
        let mut other = plan.clone();
        change(&mut other);
        match execute(&problem, &other, &options(1), &mut Quiet) {
            Err(RunError::Execution(ExecutionError::Misfit(what))) => what,
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    assert_eq!(refused(&|plan| plan.moves[0].robot = 8), "move 1: there is no robot 8");
    assert_eq!(refused(&|plan| plan.moves[0].slot = Some(2)), "move 1: there is no slot 3");
    assert_eq!(refused(&|plan| plan.moves.push(plan.moves[0].clone())), "move 2: robot 7 has moved before");
    let ends = refused(&|plan| plan.moves[0].slot = Some(0));
    assert!(ends.ends_with("and not in slot 1"), "{ends}");
    let gap = refused(&|plan| {
        plan.moves[0].actions.remove(2);
    });
    assert!(gap.starts_with("move 1: action 3 begins elsewhere"), "{gap}");
    let docked = refused(&|plan| {
        plan.moves[0].actions.remove(0);
    });
    assert!(docked.contains("begin with undocking"), "{docked}");
}
