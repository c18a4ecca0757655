//! The host is stopped while a robot moves, by a clock of the test's own: leases end, the plan's time stands still, the move is ended.

mod noisy;

use std::cell::Cell;
use std::time::Duration;

use rov::planner::{OrderRule, Request};

use super::super::super::clock::Fake;
use super::super::super::host::Controller;
use super::super::super::progress::Quiet;
use super::super::scenario::ReconfigureScenario;
use super::*;
use protocol::time::FleetInstant;
use reconfiguration::plan::{Criterion, Manner};
use sim::module::TICK;
use sim::rov::Thrusters;

/// A built-in problem, its plan, and the power law of both.
fn planned(name: &str) -> (Problem, Plan, PowerLaw) {
    planned_in(name, |_| {})
}

/// The same with another water.
fn planned_in(name: &str, change: impl FnOnce(&mut Problem)) -> (Problem, Plan, PowerLaw) {
    let mut problem = ReconfigureScenario::open(name).expect("built in").problem;
    change(&mut problem);
    let law = PowerLaw::fitted(problem.rules.battery_v).expect("valid");
    let request = Request {
        criterion: Criterion::Energy,
        manner: Manner::Best,
        order: OrderRule::Exact,
        law: law.clone(),
    };
    let mut plan = rov::planner::plan(&problem, &request).expect("a plan").plan;
    rov::pricing::price(&problem, &mut plan, &law).expect("a price");
    let broken = judge::verify(&problem, &plan);
    assert!(broken.is_empty(), "{name}: {broken:?}");
    (problem, plan, law)
}

/// Executes the built-in scenario; the host is stopped for `length_s` at each of the times of `stops_s`, s of the plan.
fn paused(stops_s: &[f64], length_s: f64) -> Summary {
    let (problem, plan, law) = planned("i-to-l");
    let options = Options { seed: 1, radio: FaultParameters::default(), law };
    let mut fleet = InProcess::rovs(&problem, options.radio, options.seed).expect("valid");
    let time = Cell::new(Duration::ZERO);
    let (mut last, mut stops_s) = (FleetInstant(0), stops_s.iter());
    let mut next_s = stops_s.next();
    let mut hook = |now: FleetInstant, execution: &Execution<'_>, fleet: &mut InProcess<Thrusters>| {
        while last.after(TICK) < now {
            last = last.after(TICK);
            fleet.advance(last).expect("a loopback");
        }
        last = now;
        let t_s = execution.origin().map(|origin| now.as_secs_f64() - origin.as_secs_f64());
        if next_s.is_some_and(|&next_s| t_s.is_some_and(|t_s| t_s >= next_s)) {
            next_s = stops_s.next();
            time.set(time.get() + Duration::from_secs_f64(length_s));
        }
    };
    let drive = Drive { pace: Pace::Real, operator: &mut Unattended, hook: &mut hook };
    let clock = Clock::over(Pace::Real, Fake(&time));
    run_by(
        clock,
        (Log::default(), Title::default()),
        &problem,
        &plan,
        &options,
        &mut fleet,
        drive,
        Site::simulated(&problem, &plan, &options.law).expect("bodies"),
        &mut Quiet,
    )
    .expect("begun")
    .summary
}

#[test]
fn a_plan_is_executed_to_its_end_though_the_host_was_stopped() {
    let undisturbed = paused(&[], 0.0);
    assert_eq!((undisturbed.failure, undisturbed.gaps.len()), (None, 0));
    for (stops_s, length_s) in [(&[0.1, 4.0][..], 7.0), (&[9.0], 0.7), (&[3.0], 120.0)] {
        let of = format!("stopped at {stops_s:?} s for {length_s} s");
        let summary = paused(stops_s, length_s);
        assert_eq!(summary.failure, None, "{of}");
        assert_eq!(summary.gaps.len(), stops_s.len(), "{of}: {:?}", summary.gaps);
        for (gap, at_s) in summary.gaps.iter().zip(stops_s) {
            assert!(
                (gap.start_s - at_s).abs() < 0.06 && (gap.length_s - length_s).abs() < 0.1,
                "{of}: {gap:?}"
            );
        }
        assert_eq!(summary.moves.len(), undisturbed.moves.len(), "{of}");
        assert!(summary.moves.iter().all(|figures| figures.end_m.is_some()), "{of}");
        // The time of the plan stood still: no figure counts the gap.
        let (with_s, without_s) = (summary.executed.time_s, undisturbed.executed.time_s);
        assert!((with_s - without_s).abs() < 15.0, "{of}: {with_s} s, {without_s} s without");
    }
}

/// A robot that falls silent in mid-plan is named, whether the others get on without it or not.
#[test]
fn a_robot_that_dies_is_named() {
    let (problem, plan, law) = planned("i-to-l");
    for robot in 0..problem.robots.len() {
        let options = Options { seed: 2, radio: FaultParameters::default(), law: law.clone() };
        let mut fleet = InProcess::rovs(&problem, options.radio, options.seed).expect("valid");
        let mut hook = |now: FleetInstant, execution: &Execution<'_>, fleet: &mut InProcess<Thrusters>| {
            if execution.origin().is_some_and(|origin| now.since(origin).as_secs_f32() >= 2.0) {
                let dead = FaultParameters { loss: 1.0, ..FaultParameters::default() };
                fleet.modules_mut()[robot].radio_mut().set_parameters(dead);
            }
        };
        let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut hook };
        let executed = run(&problem, &plan, &options, &mut fleet, drive, &mut Quiet).expect("begun");
        let (id, complaints) = (problem.robots[robot].id, executed.summary.complaints());
        let named = format!("robot {id} took no part for ");
        let is_named =
            complaints.iter().any(|line| line.starts_with(&named) && line.ends_with(": it does not answer"));
        assert!(executed.summary.failure.is_some() && is_named, "robot {id}: {complaints:?}");
    }
}
