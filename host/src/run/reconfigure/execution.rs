//! One execution of a plan: its controller, fleet and water in the [closed loop](super::super::closed_loop).
//!
//! Energy and time count from plan time 0, when the water lets go.

use std::cell::RefCell;

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
use super::super::log::Log;
use super::super::log::rovs::{Document, RovLog, RovRun, Title};
use super::super::orders::Unattended;
use super::super::pose_source::PoseSource;
use super::super::progress::{Noted, Progress};
use super::ExecutionError;
use super::accounts::Accounts;
use super::conductor::Conductor;
use super::controller::{Execution, Fixes};
use super::estimator::Seen;
use super::summary::Summary;
use super::water::{ExactPoses, Water};

/// Where a plan is executed.
pub struct Site<P> {
    /// The water; `None` where it is real.
    pub water: Option<Water>,
    /// What tells the poses.
    pub poses: P,
    /// What is done with them, where they are fixes and no exact states.
    pub fixes: Option<Fixes>,
}

impl Site<ExactPoses> {
    /// Water in this process, with all of `problem` docked in it, and exact poses.
    ///
    /// # Errors
    /// [`ExecutionError`] for bodies that cannot be in water.
    pub fn simulated(problem: &Problem, plan: &Plan, law: &PowerLaw) -> Result<Self, ExecutionError> {
        let water = Water::new(Conductor::new(problem, plan, law.clone())?.bodies())?;
        Ok(Self { water: Some(water), poses: ExactPoses::default(), fixes: None })
    }
}

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
    /// What became of the log, if that was not good.
    pub log_failure: Option<String>,
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
    run_into((Log::default(), Title::default()), problem, plan, options, fleet, drive, progress)
}

/// [`run`], with a log, and what it is called.
///
/// # Errors
/// As for [`execute`].
pub fn run_into<'p, F: Fleet<Actuation = RovActuation>>(
    log: (Log, Title),
    problem: &'p Problem,
    plan: &'p Plan,
    options: &Options,
    fleet: &mut F,
    drive: Drive<'_, Execution<'p>, F>,
    progress: &mut dyn Progress,
) -> Result<Executed, RunError> {
    let site = Site::simulated(problem, plan, &options.law)?;
    run_by(Clock::new(drive.pace), log, problem, plan, options, fleet, drive, site, progress)
}

/// [`run_into`], with poses from anywhere.
///
/// # Errors
/// As for [`execute`].
#[expect(clippy::too_many_arguments, reason = "what an execution is made of")]
pub fn run_with<'p, F: Fleet<Actuation = RovActuation>, P: PoseSource<Water, Pose = Seen>>(
    log: (Log, Title),
    problem: &'p Problem,
    plan: &'p Plan,
    options: &Options,
    fleet: &mut F,
    drive: Drive<'_, Execution<'p>, F>,
    site: Site<P>,
    progress: &mut dyn Progress,
) -> Result<Executed, RunError> {
    run_by(Clock::new(drive.pace), log, problem, plan, options, fleet, drive, site, progress)
}

/// [`run_with`] by any clock.
#[expect(clippy::too_many_arguments, reason = "the same, and a clock")]
fn run_by<'p, F: Fleet<Actuation = RovActuation>, T: WallClock, P: PoseSource<Water, Pose = Seen>>(
    clock: Clock<T>,
    (log, title): (Log, Title),
    problem: &'p Problem,
    plan: &'p Plan,
    options: &Options,
    fleet: &mut F,
    drive: Drive<'_, Execution<'p>, F>,
    site: Site<P>,
    progress: &mut dyn Progress,
) -> Result<Executed, RunError> {
    let mut controller = Execution::new(problem, plan, options.law.clone())?;
    if let Some(fixes) = site.fixes {
        controller = controller.by_fixes(fixes)?;
    }
    let bodies = controller.conductor().bodies();
    let accounts = Accounts::new(problem, plan, &options.law).map_err(ExecutionError::from)?;
    let document = Document { title, problem: problem.clone(), plan: plan.clone() };
    let notes = RefCell::new(Vec::new());
    let log = RovLog::new(log, document, options.seed, accounts, bodies, &notes).map_err(BasinError::from);
    let mut log = log.map_err(ExecutionError::from)?;
    let mut run: RovRun<'_, '_, F, P> = Run::new(controller, fleet, site.water, site.poses);
    let ending = run.drive(clock, drive, &mut Noted { progress, notes: &notes }, &mut [&mut log])?;
    let (outcome, log_failure) = log.finish(&ending, &run).map_err(RunError::Log)?;
    Ok(Executed { record: outcome.record, summary: outcome.summary, log_failure })
}

#[cfg(test)]
mod tests;
