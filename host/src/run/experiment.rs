//! One run of Modboats: pilot, fleet, tank and motion capture in the [closed loop](super::closed_loop).

use std::cell::RefCell;
use std::sync::OnceLock;
use std::time::Instant;

use modboat::observer::Fix;
use protocol::time::FleetInstant;
use quantity::ParameterError;
use record::RunRecord;
use sim::TailState;
use sim::mocap::Mocap;
use sim::tank::Tank;

use super::RunError;
use super::boats::{BoatRun, Cameras};
use super::clock::{Clock, WallClock};
use super::closed_loop::{Drive, Run};
use super::distances;
use super::fleet::{Fleet, InProcess};
use super::log::boats::{self, BoatLog};
use super::log::{Log, counts};
use super::orders::Unattended;
use super::pilot::{Decision, Pilot};
use super::pose_source::PoseSource;
use super::progress::{Noted, Progress, Quiet};
use super::scenario::Scenario;
use super::summary::Summary;

pub use super::clock::Pace;
pub use super::closed_loop::FaultHook;

/// What a run leaves behind.
#[derive(Debug)]
pub struct RunResult {
    /// The figures.
    pub summary: Summary,
    /// Everything over time.
    pub record: RunRecord,
    /// Every decision, as it was dispatched.
    pub decisions: Vec<Decision>,
    /// What became of the log, if that was not good.
    pub log_failure: Option<String>,
}

/// Where a run takes place.
pub struct Site<P> {
    /// The water; `None` where it is real.
    pub water: Option<Tank>,
    /// What tells the poses.
    pub poses: P,
}

impl Site<Cameras> {
    /// Water and cameras of `scenario`, in this process, from `seed`.
    ///
    /// # Errors
    /// [`RunError::Parameter`].
    pub fn simulated(scenario: &Scenario, seed: u64) -> Result<Self, RunError> {
        let poses = Cameras::new(Mocap::new(&scenario.mocap, seed ^ 0x3C0D)?);
        Ok(Self { water: Some(water(scenario, seed)?), poses })
    }
}

/// The water of `scenario`, with its structure at the start; gusts from `seed`.
///
/// # Errors
/// [`ParameterError`] for numbers that cannot be.
pub fn water(scenario: &Scenario, seed: u64) -> Result<Tank, ParameterError> {
    let Scenario { structure, modboat, tank, .. } = scenario;
    Tank::new(structure, modboat, tank, &scenario.start_pose(), seed ^ 0x7A4B)
}

/// Runs `scenario` with modules in this process, from `seed`, as fast as the machine can.
///
/// # Errors
/// [`RunError`].
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<RunResult, RunError> {
    let mut fleet = InProcess::boats(scenario, seed)?;
    let pace = Pace::Simulated;
    run(
        scenario,
        seed,
        &mut fleet,
        Drive { pace, operator: &mut Unattended, hook: &mut |_, _, _| {} },
        &mut Quiet,
    )
}

/// Runs `scenario` with any fleet.
///
/// # Errors
/// [`RunError`].
pub fn run<F: Fleet<Actuation = TailState>>(
    scenario: &Scenario,
    seed: u64,
    fleet: &mut F,
    drive: Drive<'_, Pilot, F>,
    progress: &mut dyn Progress,
) -> Result<RunResult, RunError> {
    run_into(Log::default(), scenario, seed, fleet, drive, progress)
}

/// [`run`], with a log.
///
/// # Errors
/// As for [`run`].
pub fn run_into<F: Fleet<Actuation = TailState>>(
    log: Log,
    scenario: &Scenario,
    seed: u64,
    fleet: &mut F,
    drive: Drive<'_, Pilot, F>,
    progress: &mut dyn Progress,
) -> Result<RunResult, RunError> {
    run_with(log, scenario, seed, fleet, drive, Site::simulated(scenario, seed)?, progress)
}

/// [`run_into`], with poses from anywhere.
///
/// # Errors
/// As for [`run`].
pub fn run_with<F: Fleet<Actuation = TailState>, P: PoseSource<Tank, Pose = Fix>>(
    log: Log,
    scenario: &Scenario,
    seed: u64,
    fleet: &mut F,
    drive: Drive<'_, Pilot, F>,
    site: Site<P>,
    progress: &mut dyn Progress,
) -> Result<RunResult, RunError> {
    run_by(Clock::new(drive.pace), log, scenario, seed, fleet, drive, site, progress)
}

/// [`run_with`] by any clock.
#[expect(clippy::too_many_arguments, reason = "what a run is made of")]
fn run_by<F: Fleet<Actuation = TailState>, T: WallClock, P: PoseSource<Tank, Pose = Fix>>(
    clock: Clock<T>,
    log: Log,
    scenario: &Scenario,
    seed: u64,
    fleet: &mut F,
    drive: Drive<'_, Pilot, F>,
    site: Site<P>,
    progress: &mut dyn Progress,
) -> Result<RunResult, RunError> {
    let table = distances::table(&scenario.modboat, &scenario.planner, progress);
    let pilot = Pilot::new(scenario, table, stopwatch)?;
    let notes = RefCell::new(Vec::new());
    let mut run: BoatRun<'_, F, P> = Run::new(pilot, fleet, site.water, site.poses);
    let ids = counts::ids(&run.host.controller, run.host.dispatcher());
    let mut log = BoatLog::new(log, scenario, &boats::head(scenario, seed, ids), &notes);
    let ending = run.drive(clock, drive, &mut Noted { progress, notes: &notes }, &mut [&mut log])?;

    let (outcome, log_failure) = log.finish(&ending, &run).map_err(RunError::Log)?;
    let decisions = run.host.controller.decisions().to_vec();
    Ok(RunResult { summary: outcome.summary, record: outcome.record, decisions, log_failure })
}

/// Any clock that only goes forward.
fn stopwatch() -> FleetInstant {
    static BEGAN: OnceLock<Instant> = OnceLock::new();
    FleetInstant(BEGAN.get_or_init(Instant::now).elapsed().as_micros() as u64)
}

#[cfg(test)]
mod tests;
