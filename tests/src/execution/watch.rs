//! A run in this process with the judge beside it, and modules that lose their power on the way.

use std::sync::atomic::AtomicBool;

use host::run::RunError;
use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, RunResult, run};
use host::run::fleet::InProcess;
use host::run::host::Controller;
use host::run::pilot::{Decision, Pilot};
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use modboat::parameters::Parameters;
use protocol::time::{Duration, FleetInstant};

use super::{Judge, Limits, Report, Seen};
use crate::convert::{of_decision, of_parameters};

/// A module that loses its power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reboot {
    /// Which, from 0.
    pub module: usize,
    /// When, s after the start of the first cycle.
    pub at_s: f64,
    /// For how long.
    pub off: Duration,
}

/// What modules with these parameters are taken to keep.
#[must_use]
pub fn limits_of(parameters: &Parameters) -> Limits {
    Limits { tracking_error_rad: parameters.tracking_error_rad, clock_error_s: parameters.clock_error_s }
}

/// What tells a decision from what the host made of it later: one that is given up keeps its number.
type Mark = (u32, bool, u32, u32);

fn mark(decision: &Decision) -> Mark {
    (decision.number, decision.via.is_some(), decision.transition.0, decision.period.0)
}

/// Runs `scenario` from `seed` with these reboots, and judges it at every tick.
///
/// # Errors
/// That of the run.
pub fn judged(scenario: &Scenario, seed: u64, reboots: &[Reboot]) -> Result<(RunResult, Report), RunError> {
    let mut fleet = InProcess::boats(scenario, seed)?;
    let mut judge = Judge::new(&of_parameters(&scenario.modboat), scenario.structure.cells());
    let mut marks: Vec<Mark> = Vec::new();
    let mut seen: Vec<Seen> = Vec::new();
    let mut reboots = reboots.to_vec();
    let stop = AtomicBool::new(false);
    let mut watch = |now: FleetInstant, pilot: &Pilot, fleet: &mut InProcess| {
        let decisions = pilot.decisions();
        // The last one may have been given up in the same tick in which another one was made.
        for (index, decision) in decisions.iter().enumerate().skip(marks.len().saturating_sub(1)) {
            if marks.get(index) != Some(&mark(decision)) {
                marks.truncate(index);
                marks.push(mark(decision));
                judge.decided(index, of_decision(decision));
            }
        }
        seen.clear();
        seen.extend(fleet.modules().iter().map(|module| Seen {
            angle_rad: module.tail().angle_rad,
            powered: module.has_power(),
            runs: module.running(now),
            clock_error_s: module.clock_error_us(now).unwrap_or(0) as f64 * 1e-6,
        }));
        judge.observe(now.as_secs_f64(), &seen);
        let due = |reboot: &Reboot| {
            let at_us = (reboot.at_s * 1e6) as u64;
            pilot.origin().is_some_and(|origin| now >= FleetInstant(origin.0 + at_us))
        };
        for reboot in reboots.extract_if(.., |reboot| due(reboot)) {
            fleet.modules_mut()[reboot.module].reboot(now, reboot.off);
        }
    };
    let drive = Drive { pace: Pace::Simulated, stop: &stop, hook: &mut watch };
    let run = run(scenario, seed, &mut fleet, drive, &mut Quiet)?;
    Ok((run, judge.report()))
}
