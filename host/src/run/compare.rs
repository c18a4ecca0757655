//! Several planners or controllers on one scenario, each with the same seeds: the same water, noise and losses.
//!
//! Every run is a closed loop of its own; two at a time, as the machine has cores. What comes back is each contender's
//! figures over its runs, mean and worst, the margins of its loop, and the records for the pictures.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use modboat::control::ControllerKind;
use modboat::control::margins::{Axis, Loop, Margins};
use modboat::planner_kind::PlannerKind;
use record::RunRecord;
use serde::Serialize;

use super::RunError;
use super::closed_loop::Drive;
use super::distances;
use super::experiment::{Pace, RunResult, run};
use super::fleet::InProcess;
use super::orders::EndWhen;
use super::progress::Progress;
use super::scenario::Scenario;
use super::summary::Summary;

/// How often progress is reported.
const REPORT: Duration = Duration::from_millis(50);

/// A figure by which planners are compared.
pub struct Figure {
    /// Its key in JSON; ends with its unit.
    pub key: &'static str,
    /// Its name for a person, with the unit it is printed in.
    pub title: &'static str,
    /// Printed unit over the one in JSON.
    pub scale: f64,
    /// Decimals printed.
    pub decimals: usize,
    /// Whether more of it is better.
    pub more_is_better: bool,
    of: fn(&Summary) -> Option<f64>,
}

/// All figures, in the order of the table.
pub const FIGURES: [Figure; 13] = [
    figure("velocity_error", "velocity error, %", (100.0, 2), velocity_error),
    figure("heading_rms_rad", "heading error RMS, mrad", (1e3, 2), heading_rms_rad),
    figure("position_rms_m", "position error RMS, mm", (1e3, 1), |s| station(s, |leg| leg.0)),
    figure("position_max_m", "position error at most, mm", (1e3, 1), |s| station(s, |leg| leg.1)),
    figure("wrench_error", "wrench error, %", (100.0, 4), |s| Some(s.cycles.mean_error)),
    Figure {
        more_is_better: true,
        ..figure("without_transition_share", "cycles without transition, %", (100.0, 1), |s| {
            Some(s.cycles.without_transition_share)
        })
    },
    figure("travel_rad", "tail travel a cycle and module, rad", (1.0, 3), |s| Some(s.cycles.mean_travel_rad)),
    figure("interval_s", "time between decisions, s", (1.0, 3), |s| Some(s.cycles.mean_interval_s)),
    Figure {
        more_is_better: true,
        ..figure("loss_tolerant_share", "loss tolerant cycles, %", (100.0, 1), |s| {
            Some(s.cycles.loss_tolerant_share)
        })
    },
    figure("solve_median_s", "planning, median, ms", (1e3, 3), |s| {
        Some(1e-6 * s.cycles.solve_us_median as f64)
    }),
    figure("solve_max_s", "planning at most, ms", (1e3, 2), |s| Some(1e-6 * s.cycles.solve_us_max as f64)),
    figure("contacts", "tail contacts", (1.0, 1), |s| Some(s.contacts.len() as f64)),
    figure("not_planned", "cycles repeated or held", (1.0, 1), |s| {
        Some((s.cycles.repeated + s.cycles.held) as f64)
    }),
];

const fn figure(
    key: &'static str,
    title: &'static str,
    (scale, decimals): (f64, usize),
    of: fn(&Summary) -> Option<f64>,
) -> Figure {
    Figure { key, title, scale, decimals, more_is_better: false, of }
}

/// Mean over the legs that ask for a velocity, relative to it.
fn velocity_error(summary: &Summary) -> Option<f64> {
    let moving = summary.legs.iter().filter(|leg| leg.demand_m_s[0].hypot(leg.demand_m_s[1]) > 0.0);
    mean(moving.map(|leg| leg.velocity_error))
}

/// RMS over all legs alike.
fn heading_rms_rad(summary: &Summary) -> Option<f64> {
    mean(summary.legs.iter().map(|leg| leg.heading_rms_rad * leg.heading_rms_rad)).map(f64::sqrt)
}

/// The greatest of (RMS, most) over the legs that keep a station.
fn station(summary: &Summary, which: fn((f64, f64)) -> f64) -> Option<f64> {
    let stations = summary.legs.iter().filter_map(|leg| leg.station.as_ref());
    stations.map(|station| which((station.rms_m, station.max_m))).reduce(f64::max)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    (count > 0.0).then(|| sum / count)
}

/// One figure over all runs of a planner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// The worst.
    pub worst: f64,
}

/// How far a controller is from its limit of stability: thrust and phase, by the response of its sampled loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopMargins {
    /// Of the heading: greatest factor on the thrust.
    pub heading_gain: f64,
    /// Least factor on it; 0 where any will do.
    pub heading_least_gain: f64,
    /// Phase, rad.
    pub heading_phase_rad: f64,
    /// The same of a station.
    pub position_gain: f64,
    /// Least factor.
    pub position_least_gain: f64,
    /// Phase, rad.
    pub position_phase_rad: f64,
}

impl LoopMargins {
    /// Of the controller that `scenario` has; `None` where its observer cannot be.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Option<Self> {
        let sampled = Loop {
            structure: &scenario.structure,
            parameters: &scenario.modboat,
            control: &scenario.control,
            observer: &scenario.observer,
            lead_s: scenario.timing.lead_s,
        };
        let [heading, position]: [Margins; 2] =
            [sampled.margins(Axis::Heading)?, sampled.margins(Axis::Surge)?];
        Some(Self {
            heading_gain: heading.gain,
            heading_least_gain: heading.least_gain,
            heading_phase_rad: heading.phase_rad,
            position_gain: position.gain,
            position_least_gain: position.least_gain,
            position_phase_rad: position.phase_rad,
        })
    }
}

/// What one planner did with one controller.
#[derive(Debug, Serialize)]
pub struct Contender {
    /// The planner's name.
    pub planner: &'static str,
    /// The controller's name.
    pub controller: &'static str,
    /// The margins of its loop.
    pub margins: Option<LoopMargins>,
    /// [`FIGURES`] by key, those that there are.
    pub figures: BTreeMap<&'static str, Spread>,
    /// Every run, by seed.
    pub runs: Vec<Summary>,
    /// The record of every run.
    #[serde(skip)]
    pub records: Vec<RunRecord>,
}

/// Planners and controllers beside each other.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Scenario.
    pub scenario: String,
    /// Modules.
    pub modules: usize,
    /// Seeds of the runs.
    pub seeds: Vec<u64>,
    /// In the order asked for.
    pub planners: Vec<Contender>,
}

impl Comparison {
    /// What went wrong first, if anything did.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        self.planners.iter().find_map(|contender| {
            let run = contender.runs.iter().find(|run| !run.passed())?;
            let why = run.failure.as_deref().unwrap_or_default();
            Some(format!("{}, seed {}: {why}", self.name(contender), run.seed))
        })
    }

    /// What tells a contender from the others.
    #[must_use]
    pub fn name(&self, &Contender { planner, controller, .. }: &Contender) -> String {
        let one_planner = self.planners.iter().all(|other| other.planner == planner);
        let one_controller = self.planners.iter().all(|other| other.controller == controller);
        match (one_planner, one_controller) {
            (_, true) => planner.to_owned(),
            (true, false) => controller.to_owned(),
            (false, false) => format!("{planner}, {controller}"),
        }
    }
}

/// Runs `scenario` with every contestant and seed. `stop` ends it early; what was measured is kept.
///
/// # Errors
/// The first [`RunError`] of any run.
pub fn compare(
    scenario: &Scenario,
    contestants: &[(PlannerKind, ControllerKind)],
    seeds: &[u64],
    progress: &mut dyn Progress,
    stop: &AtomicBool,
) -> Result<Comparison, RunError> {
    let scenarios: Vec<Scenario> = contestants
        .iter()
        .map(|&(planner, controller)| {
            let mut scenario = scenario.clone();
            (scenario.planner.kind, scenario.control.kind) = (planner, controller);
            scenario
        })
        .collect();
    // A table that a planner searches by is made once; the runs read it.
    scenarios
        .iter()
        .for_each(|scenario| drop(distances::table(&scenario.modboat, &scenario.planner, progress)));
    let jobs: Vec<(usize, u64)> =
        (0..contestants.len()).flat_map(|planner| seeds.iter().map(move |&seed| (planner, seed))).collect();
    let (next, done_ms) = (AtomicUsize::new(0), AtomicU64::new(0));
    let results = Mutex::new(Vec::with_capacity(jobs.len()));
    let work = || {
        while let Some(&(planner, seed)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let result = one(&scenarios[planner], seed, &done_ms, stop);
            // Nothing panics while it holds the lock.
            results.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((planner, seed, result));
        }
    };
    let total_s = scenario.duration_s() * jobs.len() as f64;
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            thread::sleep(REPORT);
            progress.at(1e-3 * done_ms.load(Ordering::Relaxed) as f64, total_s);
        }
    });
    let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    results.sort_by_key(|&(planner, seed, _)| (planner, seed));
    let mut contenders: Vec<Contender> = contestants
        .iter()
        .zip(&scenarios)
        .map(|((planner, controller), scenario)| Contender {
            planner: planner.name(),
            controller: controller.name(),
            margins: LoopMargins::of(scenario),
            figures: BTreeMap::new(),
            runs: Vec::new(),
            records: Vec::new(),
        })
        .collect();
    for (planner, _, result) in results {
        let RunResult { summary, record, .. } = result?;
        contenders[planner].runs.push(summary);
        contenders[planner].records.push(record);
    }
    for contender in &mut contenders {
        contender.figures = FIGURES.iter().filter_map(|figure| spread(figure, &contender.runs)).collect();
    }
    Ok(Comparison {
        scenario: scenario.name.clone(),
        modules: scenario.structure.len(),
        seeds: seeds.to_vec(),
        planners: contenders,
    })
}

fn spread(figure: &Figure, runs: &[Summary]) -> Option<(&'static str, Spread)> {
    let values = || runs.iter().filter_map(figure.of);
    let worse = if figure.more_is_better { f64::min } else { f64::max };
    Some((figure.key, Spread { mean: mean(values())?, worst: values().reduce(worse)? }))
}

/// One run; adds the milliseconds that it has swum to `done_ms`.
fn one(
    scenario: &Scenario,
    seed: u64,
    done_ms: &AtomicU64,
    stop: &AtomicBool,
) -> Result<RunResult, RunError> {
    let mut fleet = InProcess::boats(scenario, seed)?;
    let mut tally = Tally { done_ms, seen_ms: 0 };
    let drive = Drive { pace: Pace::Simulated, operator: &mut EndWhen::new(stop), hook: &mut |_, _, _| {} };
    let result = run(scenario, seed, &mut fleet, drive, &mut tally);
    tally.at(scenario.duration_s(), scenario.duration_s());
    result
}

/// Counts time into a sum that several runs share.
struct Tally<'a> {
    done_ms: &'a AtomicU64,
    seen_ms: u64,
}

impl Progress for Tally<'_> {
    fn at(&mut self, t_s: f64, _duration_s: f64) {
        let now_ms = (1e3 * t_s) as u64;
        self.done_ms.fetch_add(now_ms.saturating_sub(self.seen_ms), Ordering::Relaxed);
        self.seen_ms = self.seen_ms.max(now_ms);
    }

    fn note(&mut self, _text: &str) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::experiment::simulate;
    use crate::run::progress::Quiet;

    #[test]
    fn a_comparison_is_the_runs_it_stands_for_and_its_spread_their_mean_and_worst() {
        let text = "name = \"t\"\n[structure]\nsize = \"2x1\"\n[[leg]]\nduration_s = 25.0\n\
                    velocity_m_s = [0.02, 0.0]\nheading_rad = 1.5\n";
        let mut scenario = Scenario::parse("t.toml", text).expect("valid");
        scenario.planner.kind = PlannerKind::PotentialField;
        scenario.control.kind = ControllerKind::Paper;
        let stop = AtomicBool::new(false);
        let seeds = [3, 4, 5];
        let contestants = [(PlannerKind::PotentialField, ControllerKind::Paper)];
        let compared = compare(&scenario, &contestants, &seeds, &mut Quiet, &stop);
        let compared = compared.expect("runs");
        let contender = &compared.planners[0];
        let alone: Vec<Summary> =
            seeds.iter().map(|&seed| simulate(&scenario, seed).expect("runs").summary).collect();
        for (run, alone) in contender.runs.iter().zip(&alone) {
            assert_eq!((run.seed, &run.legs, &run.contacts), (alone.seed, &alone.legs, &alone.contacts));
        }
        let heading = |s: &Summary| s.legs[0].heading_rms_rad;
        let Spread { mean, worst } = contender.figures["heading_rms_rad"];
        assert!((mean - alone.iter().map(heading).sum::<f64>() / 3.0).abs() < 1e-12);
        assert!((worst - alone.iter().map(heading).fold(0.0, f64::max)).abs() < 1e-15);
        // Of a share the least is the worst; what no leg asks for is no figure.
        let Spread { mean, worst } = contender.figures["without_transition_share"];
        assert!(worst <= mean);
        assert!(!contender.figures.contains_key("position_rms_m"));
        assert_eq!(compared.failure(), None);
    }
}
