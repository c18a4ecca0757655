//! Parallel plans, executed: no hull comes nearer to another than planned, whatever is late.

use std::collections::BTreeMap;

use host::run::closed_loop::Drive;
use host::run::experiment::Pace;
use host::run::fleet::InProcess;
use host::run::host::Controller;
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::reconfigure::controller::Execution;
use host::run::reconfigure::execution::{Executed, Options, run};
use link::faults::FaultParameters;
use protocol::time::FleetInstant;
use reconfiguration::plan::Plan;
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use rov::configuration::LevelBox;
use rov::parallel::overlapped;
use rov::power::PowerLaw;
use sim::rov::Thrusters;
use tests::seeds::{number, on_all_cores};
use tests::shifted::places;

use super::{TIME_W, one_by_one};

/// A hull may come so much nearer to another one than planned, m.
const NEARER_M: f64 = 0.02;

type Rovs = InProcess<Thrusters>;

/// Executes a plan; `hook` is called with the time since its beginning, s.
fn executed(
    problem: &Problem,
    plan: &Plan,
    law: &PowerLaw,
    seed: u64,
    hook: &mut dyn FnMut(f64, &mut Rovs),
) -> Executed {
    let options = Options { seed, radio: FaultParameters::default(), law: law.clone() };
    let mut fleet = InProcess::rovs(problem, options.radio, options.seed).expect("a fleet");
    let mut at = |now: FleetInstant, controller: &Execution<'_>, fleet: &mut Rovs| {
        let origin = controller.origin();
        hook(origin.map_or(-1.0, |origin| now.as_secs_f64() - origin.as_secs_f64()), fleet);
    };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut at };
    run(problem, plan, &options, &mut fleet, drive, &mut Quiet).expect("begun")
}

/// The least gap between the hulls of two robots of which one is under way, m.
type Gaps = BTreeMap<(usize, usize), f64>;

fn note(gaps: &mut Gaps, problem: &Problem, poses: &[(Pose, bool)]) {
    let around =
        |robot: usize| LevelBox::around(poses[robot].0, &problem.vehicles[problem.robots[robot].vehicle]);
    for first in 0..poses.len() {
        for second in (first + 1..poses.len()).filter(|&second| poses[first].1 || poses[second].1) {
            let least_m = gaps.entry((first, second)).or_insert(f64::INFINITY);
            *least_m = least_m.min(around(first).gap_m(&around(second)));
        }
    }
}

fn planned_gaps(problem: &Problem, plan: &Plan) -> Gaps {
    let mut gaps = Gaps::new();
    let mut now_s = 0.0;
    while now_s < plan.time_s {
        let places = places(problem, plan, now_s);
        let poses: Vec<(Pose, bool)> =
            places.iter().map(|(pose, under_way)| (*pose, under_way.is_some())).collect();
        note(&mut gaps, problem, &poses);
        now_s += 0.005;
    }
    gaps
}

fn executed_gaps(problem: &Problem, executed: &Executed) -> Gaps {
    let mut gaps = Gaps::new();
    for sample in &executed.record.samples {
        let pose = |eta: [f64; 6]| Pose::from([eta[0], eta[1], eta[2], eta[5]]);
        let poses: Vec<(Pose, bool)> =
            sample.robots.iter().map(|of| (pose(of.eta), of.reference.is_some())).collect();
        note(&mut gaps, problem, &poses);
    }
    gaps
}

/// All robots are in their slots, and no two came nearer to each other than planned. How much nearer they came, m.
fn kept_clear(problem: &Problem, plan: &Plan, executed: &Executed, what: &str) -> f64 {
    assert_eq!(executed.summary.failure, None, "{what}");
    assert!(executed.summary.moves.iter().all(|of| of.end_m.is_some()), "{what}");
    assert_eq!(executed.summary.moves.len(), plan.moves.len(), "{what}");
    let planned = planned_gaps(problem, plan);
    let mut nearer_m = f64::NEG_INFINITY;
    for (pair, gap_m) in executed_gaps(problem, executed) {
        let planned_m = planned.get(&pair).copied().unwrap_or(f64::INFINITY);
        assert!(
            gap_m >= planned_m - NEARER_M,
            "{what}, robots {pair:?}: {gap_m:.4} m, planned {planned_m:.4} m"
        );
        nearer_m = nearer_m.max(planned_m - gap_m);
    }
    nearer_m
}

#[test]
fn random_parallel_plans_are_executed_as_clear_as_planned() {
    let seeds = number("FLOTILLA_PARALLEL").unwrap_or(6);
    let results = on_all_cores(0..seeds, |seed| {
        let (problem, one_by_one, law) = one_by_one(seed)?;
        let plan = overlapped(&problem, &one_by_one, &law, TIME_W).expect("robots");
        if !plan.is_parallel() {
            return None;
        }
        let what = format!("seed {seed}, {} robots, {} tools", problem.robots.len(), problem.tools.len());
        let executed = executed(&problem, &plan, &law, seed, &mut |_, _| {});
        let nearer_m = kept_clear(&problem, &plan, &executed, &what);
        let summary = &executed.summary;
        let (ratio, late_s) = (summary.ratio.unwrap_or(1.0), summary.executed.time_s - plan.time_s);
        println!(
            "{what}: {:.1} J in {:.1} s, executed/planned {ratio:.4}, {late_s:.2} s late, at most {:.1} mm nearer",
            plan.energy_total_j,
            plan.time_s,
            1e3 * nearer_m
        );
        // Time passes as planned but for docking.
        assert!((-0.1..0.5 + 0.02 * plan.time_s).contains(&late_s), "{what}: {late_s} s late");
        assert!((ratio - 1.0).abs() < 0.08, "{what}: {ratio}");
        Some(ratio)
    });
    let ratios: Vec<f64> = results.into_iter().flatten().collect();
    println!("{} executed of {seeds}", ratios.len());
    assert!(2 * ratios.len() as u64 >= seeds, "{} of {seeds}", ratios.len());
}

/// A robot falls silent for two seconds under way: its thrusts end, it stops somewhere, and time stands still for all
/// until it is back. Others are then where they would have been with it.
#[test]
fn a_robot_that_is_late_delays_the_others_and_no_hull_comes_nearer() {
    let (mut delayed, mut cases) = (0, 0);
    for seed in 0..3 {
        let Some((problem, one_by_one, law)) = one_by_one(seed) else { continue };
        let plan = overlapped(&problem, &one_by_one, &law, TIME_W).expect("robots");
        let Some(own) = plan.moves.iter().max_by(|a, b| a.duration_s.total_cmp(&b.duration_s)) else {
            continue;
        };
        let robot = problem.robots.iter().position(|robot| robot.id == own.robot).expect("known");
        let from_s = own.start_s + 0.4 * own.duration_s;
        let silence =
            |lost: bool| FaultParameters { loss: f64::from(u8::from(lost)), ..FaultParameters::default() };
        let mut hook = |t_s: f64, fleet: &mut Rovs| {
            let lost = (from_s..from_s + 2.0).contains(&t_s);
            fleet.modules_mut()[robot].radio_mut().set_parameters(silence(lost));
        };
        let what = format!("seed {seed}, robot {} silent from {from_s:.1} s", own.robot);
        let late = executed(&problem, &plan, &law, seed, &mut hook);
        let undisturbed = executed(&problem, &plan, &law, seed, &mut |_, _| {});
        let nearer_m = kept_clear(&problem, &plan, &late, &what);
        let late_s = late.summary.executed.time_s - undisturbed.summary.executed.time_s;
        println!("{what}: {late_s:.2} s later, {:.1} mm nearer", 1e3 * nearer_m);
        cases += 1;
        delayed += usize::from(late_s > 1.5);
    }
    assert!(cases >= 2 && delayed == cases, "{delayed} of {cases} delayed");
}
