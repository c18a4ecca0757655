//! One execution of a plan: its controller, fleet and water in the [closed loop](super::super::closed_loop).
//!
//! Energy and time count from plan time 0, when the water lets go.

use std::sync::atomic::AtomicBool;

use link::faults::FaultParameters;
use reconfiguration::plan::Plan;
use reconfiguration::problem::Problem;
use record::reconfigure::Record;
use rov::power::PowerLaw;
use sim::rov::RovActuation;
use sim::rov::basin::BasinError;

use super::super::RunError;
use super::super::clock::Pace;
use super::super::closed_loop::{Drive, Run};
use super::super::fleet::{Fleet, InProcess};
use super::super::progress::Progress;
use super::super::summary::{LinkFigures, reboots};
use super::ExecutionError;
use super::accounts::Accounts;
use super::controller::Execution;
use super::recorder::{Recorder, RovRun};
use super::summary::{Energy, MoveFigures, Summary};
use super::water::{ExactPoses, Water};

/// How a plan is executed.
#[derive(Clone, Debug)]
pub struct Options {
    /// Seed of everything random.
    pub seed: u64,
    /// What the medium does to datagrams.
    pub radio: FaultParameters,
    /// What thrust costs: allocated by and counted in.
    pub law: PowerLaw,
}

/// What an execution leaves behind.
#[derive(Clone, Debug)]
pub struct Executed {
    /// Everything over time.
    pub record: Record,
    /// The figures.
    pub summary: Summary,
}

/// Executes `plan` with ROVs in this process, as fast as the machine can.
///
/// # Errors
/// [`RunError`], for what cannot begin. What fails on the way is told in [`Summary::failure`].
pub fn execute(
    problem: &Problem,
    plan: &Plan,
    options: &Options,
    progress: &mut dyn Progress,
) -> Result<Executed, RunError> {
    let mut fleet = InProcess::rovs(problem, options.radio, options.seed)?;
    let (pace, stop) = (Pace::Simulated, &AtomicBool::new(false));
    run(problem, plan, options, &mut fleet, Drive { pace, stop, hook: &mut |_, _, _| {} }, progress)
}

/// Executes `plan` with any fleet.
///
/// # Errors
/// As for [`execute`].
pub fn run<'p, F: Fleet<Actuation = RovActuation>>(
    problem: &'p Problem,
    plan: &'p Plan,
    options: &Options,
    fleet: &mut F,
    drive: Drive<'_, Execution<'p>, F>,
    progress: &mut dyn Progress,
) -> Result<Executed, RunError> {
    let controller = Execution::new(problem, plan, options.law.clone())?;
    let bodies = controller.conductor().bodies();
    let accounts = Accounts::new(problem, plan, &options.law).map_err(ExecutionError::from)?;
    let recorder = Recorder::new(accounts, bodies, problem.robots.len()).map_err(BasinError::from);
    let mut recorder = recorder.map_err(ExecutionError::from)?;
    let water = Water::new(bodies).map_err(ExecutionError::from)?;
    let mut run: RovRun<'_, '_, F> = Run::new(controller, fleet, Some(water), ExactPoses);
    let ending = run.drive(drive, progress, &mut [&mut recorder])?;

    let (samples, moves) = recorder.finish(ending.at, &run);
    let sum = |of: fn(&MoveFigures) -> Energy| moves.iter().map(of).sum::<Energy>();
    let (planned, executed) = (sum(|m| m.planned), sum(|m| m.executed));
    let links = run.host.dispatcher();
    let summary = Summary {
        problem: problem.name.clone(),
        criterion: plan.criterion,
        manner: plan.manner,
        seed: options.seed,
        failure: ending.why,
        planned,
        expected: sum(|m| m.expected),
        executed,
        by_table: sum(|m| m.by_table),
        ratio: (planned.total_j > 0.0).then(|| executed.total_j / planned.total_j),
        reboots: reboots(links).into(),
        link: LinkFigures::of_all(&run.host.controller, links),
        strays: *links.strays(),
        faults: run.fleet.faults(),
        wall_s: ending.wall_s,
        moves,
    };
    Ok(Executed { record: Record { problem: problem.clone(), plan: plan.clone(), samples }, summary })
}
