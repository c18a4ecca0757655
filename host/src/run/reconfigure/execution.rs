//! One execution of a plan: its controller, fleet and water in the [closed loop](super::super::closed_loop).
//!
//! Energy and time count from plan time 0, when the water lets go.

use link::faults::FaultParameters;
use reconfiguration::plan::Plan;
use reconfiguration::problem::Problem;
use record::reconfigure::Record;
use rov::power::PowerLaw;
use sim::rov::RovActuation;
use sim::rov::basin::BasinError;

use super::super::RunError;
use super::super::clock::{Clock, Pace, WallClock};
use super::super::closed_loop::{Drive, Run};
use super::super::fleet::{Fleet, InProcess};
use super::super::host::Controller;
use super::super::orders::Unattended;
use super::super::progress::Progress;
use super::super::shortfall;
use super::super::summary::{AbsenceFigures, GapFigures, LinkFigures, all_of, reboots};
use super::super::watch::Watch;
use super::ExecutionError;
use super::accounts::Accounts;
use super::controller::Execution;
use super::recorder::{Recorder, RovRun};
use super::summary::{Energy, MoveFigures, Summary};
use super::water::{ExactPoses, Water};

/// A robot that takes no part, or is waited for, for less than this in all is no shortfall, s: what a move waits for a robot that is not
/// quite there. *Assumed.*
const FLOOR_S: f64 = 4.0;

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
    let pace = Pace::Simulated;
    run(
        problem,
        plan,
        options,
        &mut fleet,
        Drive { pace, operator: &mut Unattended, hook: &mut |_, _, _| {} },
        progress,
    )
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
    run_by(Clock::new(drive.pace), problem, plan, options, fleet, drive, progress)
}

/// [`run`] by any clock.
fn run_by<'p, F: Fleet<Actuation = RovActuation>, T: WallClock>(
    clock: Clock<T>,
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
    let mut watch = Watch::new(vec![f64::INFINITY]);
    let water = Water::new(bodies).map_err(ExecutionError::from)?;
    let mut run: RovRun<'_, '_, F> = Run::new(controller, fleet, Some(water), ExactPoses);
    let ending = run.drive(clock, drive, progress, &mut [&mut recorder, &mut watch])?;

    let (samples, moves) = recorder.finish(ending.at, &run);
    let sum = |of: fn(&MoveFigures) -> Energy| moves.iter().map(of).sum::<Energy>();
    let (planned, executed) = (sum(|m| m.planned), sum(|m| m.executed));
    let links = run.host.dispatcher();
    let id = |robot: usize| run.host.controller.id(robot, links);
    let seen = &watch.legs()[0];
    let shortfalls = shortfall::of_watch(None, seen, FLOOR_S, Execution::MODULE, id);
    let gaps = run.host.controller.gaps().iter();
    let summary = Summary {
        problem: problem.name.clone(),
        criterion: plan.criterion,
        manner: plan.manner,
        seed: options.seed,
        failure: ending.why.or_else(|| all_of(&shortfalls)),
        shortfalls,
        gaps: gaps.map(|&(start_s, length_s)| GapFigures { start_s, length_s }).collect(),
        absences: AbsenceFigures::of_all(watch.legs(), id),
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

#[cfg(test)]
mod tests;
