//! One run: the pilot, a fleet and the tank, tick by tick.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use link::dispatcher::{Dispatcher, ModuleLink};
use protocol::ledger::Outgoing;
use protocol::time::FleetInstant;
use protocol::{Faults, MAX_DATAGRAM, ModuleState, Radio};
use record::{PoseSample, RunRecord};
use sim::TailState;
use sim::mocap::Mocap;
use sim::module::TICK;
use sim::tank::Tank;

use super::RunError;
use super::distances;
use super::fleet::{Fleet, InProcess};
use super::pilot::{Decision, Pilot};
use super::progress::{Progress, Quiet};
use super::recorder::Recorder;
use super::scenario::Scenario;
use super::summary::Summary;

/// Whose time a run follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Simulated time, as fast as the machine can.
    Simulated,
    /// Simulated time, no faster than the wall clock: to watch.
    Watched,
    /// The wall clock's: with modules that have clocks of their own.
    Real,
}

/// What a run leaves behind.
#[derive(Debug)]
pub struct RunResult {
    /// The figures.
    pub summary: Summary,
    /// Everything over time.
    pub record: RunRecord,
    /// Every decision, as it was dispatched.
    pub decisions: Vec<Decision>,
}

/// A fault that is planned into a run, for tests and drills.
pub type Drill<'a, F> = &'a mut dyn FnMut(FleetInstant, Option<FleetInstant>, &mut F);

/// The same, and what watches a run: it sees the pilot too.
pub type Watch<'a, F> =
    &'a mut dyn FnMut(FleetInstant, &Pilot<<<F as Fleet>::Radio as Radio>::Address>, &mut F);

/// Runs `scenario` with modules in this process, from `seed`, as fast as the machine can.
///
/// # Errors
/// [`RunError`].
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<RunResult, RunError> {
    let mut fleet = InProcess::new(scenario, seed)?;
    let stop = AtomicBool::new(false);
    run(scenario, seed, &mut fleet, Pace::Simulated, &mut Quiet, &stop, &mut |_, _, _| {})
}

/// Runs `scenario` with any fleet. `stop` ends it early: the fleet is told to hold, and what was measured is kept.
/// `drill` is called at every tick with the time and the start of the first cycle.
///
/// # Errors
/// [`RunError`].
pub fn run<F: Fleet>(
    scenario: &Scenario,
    seed: u64,
    fleet: &mut F,
    pace: Pace,
    progress: &mut dyn Progress,
    stop: &AtomicBool,
    drill: Drill<'_, F>,
) -> Result<RunResult, RunError> {
    let mut watch = |tick: FleetInstant, pilot: &Pilot<_>, fleet: &mut F| drill(tick, pilot.origin(), fleet);
    run_watched(scenario, seed, fleet, pace, progress, stop, &mut watch)
}

/// The same; `watch` is called at every tick, before the fleet advances to it.
///
/// # Errors
/// [`RunError`].
pub fn run_watched<F: Fleet>(
    scenario: &Scenario,
    seed: u64,
    fleet: &mut F,
    pace: Pace,
    progress: &mut dyn Progress,
    stop: &AtomicBool,
    watch: Watch<'_, F>,
) -> Result<RunResult, RunError> {
    let table = distances::table(&scenario.modboat, &scenario.planner, progress);
    let mut pilot = Pilot::new(scenario, fleet.host(), fleet.roster(), table, stopwatch)?;
    let start = PoseSample {
        position_m: scenario.start.position_m,
        heading_rad: scenario.start_heading_rad(),
        ..PoseSample::default()
    };
    let mut tank = Tank::new(&scenario.structure, &scenario.modboat, &scenario.tank, &start, seed ^ 0x7A4B)?;
    let mut mocap = Mocap::new(&scenario.mocap, seed ^ 0x3C0D)?;
    let mut recorder = Recorder::default();
    let mut tails: Vec<TailState> = Vec::new();
    let mut clock_error_us = None;
    let mut idle_since = FleetInstant(0);
    let mut clock = Clock::new(pace);
    let mut buffer = [0; MAX_DATAGRAM];
    let (mut heard, mut waiting, mut missed) = (0, true, false);
    let mut cut_short = None;

    loop {
        let tick = clock.next_tick();
        watch(tick, &pilot, fleet);
        fleet.advance(tick)?;

        let mut now = clock.now(tick);
        while let Some((length, from)) = fleet.radio().receive(now, &mut buffer).map_err(Into::into)? {
            // What does not decode is counted by the pilot; there is nothing else to do about it.
            let _ = pilot.handle_datagram(now, from, &buffer[..length]);
            now = clock.now(tick);
        }

        fleet.tails(tick, pilot.dispatcher(), &mut tails);
        tank.step(f64::from(TICK.as_secs_f32()), &tails);
        let pose = tank.pose();
        if let Some(fix) = mocap.sample(pose.t_s, &pose) {
            pilot.handle_fix(&fix);
        }
        pilot.handle_timer(tick);
        transmit(&mut pilot, fleet, || clock.now(tick))?;

        let sample = (&pose, tails.as_slice(), tank.last_wrench());
        recorder.step(tick, pilot.origin(), f64::from(TICK.as_secs_f32()), sample, pilot.decisions());
        if pilot.is_finished() {
            break;
        }
        if stop.load(Ordering::Relaxed) {
            progress.note("interrupted: the fleet finishes its cycle and holds");
            cut_short = Some("interrupted".to_owned());
            pilot.finish();
            transmit(&mut pilot, fleet, || clock.now(tick))?;
            break;
        }

        let known = pilot.dispatcher().modules().iter().filter(|link| link.is_known()).count();
        if known != heard {
            heard = known;
            progress.note(&format!("{known} of {} modules have joined", scenario.structure.len()));
        }
        if pilot.is_swimming() {
            idle_since = tick;
            clock_error_us = clock_error_us.max(fleet.clock_error_us(tick));
            if waiting {
                progress.note(&swimming(&pilot));
            }
        } else if !waiting {
            progress.note("the fleet holds: a module's tail is not known");
        }
        waiting = !pilot.is_swimming();
        let idle_s = tick.as_secs_f64() - idle_since.as_secs_f64();
        if idle_s <= scenario.timing.missing_after_s {
            missed = false;
        } else if !std::mem::replace(&mut missed, true) {
            progress.note(&format!("still missing: {}", missing(&pilot)));
        }
        if idle_s > scenario.timing.join_s {
            let links = pilot.dispatcher().modules();
            let modules = pilot.missing().into_iter().map(|index| links[index].id().0).collect();
            let silent = RunError::Silent { modules, waited_s: scenario.timing.join_s, hint: String::new() };
            // What was measured before a module fell silent is kept.
            if pilot.origin().is_none() {
                return Err(silent);
            }
            cut_short = Some(stopped(links).unwrap_or_else(|| silent.to_string()));
            break;
        }
        if clock.ticks.is_multiple_of(100) {
            let t_s = pilot.origin().map_or(0.0, |origin| tick.as_secs_f64() - origin.as_secs_f64());
            progress.at(t_s.max(0.0), scenario.duration_s());
            progress.link(&link_line(pilot.dispatcher()));
        }
    }

    let wall_s = clock.elapsed_s();
    let record = recorder.finish(scenario, pilot.origin(), pilot.decisions());
    let mut summary = Summary::new(scenario, seed, &record, &pilot, &tank);
    summary.faults = fleet.faults();
    summary.clock_error_us = clock_error_us;
    summary.wall_s = wall_s;
    summary.judge(cut_short);
    Ok(RunResult { summary, record, decisions: pilot.decisions().to_vec() })
}

/// The modules whose tail angles are unknown, and why if that is known.
fn missing<A: Copy>(pilot: &Pilot<A>) -> String {
    let modules = pilot.dispatcher().modules();
    let one = |index: usize| {
        let link = &modules[index];
        let why = match (link.is_elsewhere(), link.state(), link.health()) {
            (true, ..) => " (serves another host)".to_owned(),
            (false, Some(ModuleState::Ready | ModuleState::Holding), Some(health)) => {
                format!(" (knows the fleet time to {:.1} ms)", f64::from(health.uncertainty.0) * 1e-3)
            }
            (false, Some(state), _) => format!(" ({state:?})"),
            (false, None, _) => String::new(),
        };
        format!("{}{why}", link.id())
    };
    pilot.missing().into_iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Which modules swim.
fn swimming<A: Copy>(pilot: &Pilot<A>) -> String {
    let missing = pilot.decisions().last().map_or(&[][..], |decision| &decision.missing);
    let missing: Vec<String> = pilot
        .dispatcher()
        .modules()
        .iter()
        .zip(missing)
        .filter(|(_, missing)| **missing)
        .map(|(link, _)| link.id().to_string())
        .collect();
    match missing.as_slice() {
        [] => "all modules are ready: swimming".to_owned(),
        missing => format!("swimming without {}: their tails may be anywhere", missing.join(", ")),
    }
}

/// The ledger in a line, as it is now.
fn link_line<A: Copy>(dispatcher: &Dispatcher<A>) -> String {
    let modules = dispatcher.modules();
    let there = modules.iter().filter(|link| link.is_known()).count();
    let sent = modules.iter().fold(Outgoing::default(), |sum, link| sum.plus(&link.outgoing()));
    let incoming = || modules.iter().map(|link| link.incoming()).chain([dispatcher.strays()]);
    let bad: u64 = incoming().map(|i| u64::from(i.duplicate + i.stale + i.corrupt + i.foreign)).sum();
    let forged: u64 = incoming().map(|i| u64::from(i.forged)).sum();
    let unsure = modules.iter().filter_map(|link| link.health()).map(|health| health.uncertainty.0).max();
    let clock = unsure.map_or(String::new(), |us| format!(", clocks ±{:.1} ms", f64::from(us) * 1e-3));
    let faults = modules.iter().filter(|link| link.faults().0 != 0).count();
    let faults = if faults == 0 { String::new() } else { format!(", {faults} with faults") };
    format!(
        "{there}/{} modules, {} sent, {} lost, {} late, {bad} not followed, {forged} forged{clock}{faults}",
        modules.len(),
        sent.sent,
        sent.lost,
        sent.late
    )
}

/// Who has stopped and why, by its own word.
fn stopped<A: Copy>(links: &[ModuleLink<A>]) -> Option<String> {
    let link = links.iter().find(|link| link.state() == Some(ModuleState::Stopped))?;
    let faults = Faults::NAMES.iter().filter(|(fault, _)| link.faults().has(*fault));
    let names: Vec<&str> = faults.map(|(_, name)| *name).collect();
    Some(format!("module {} has stopped: {}", link.id(), names.join(", ")))
}

/// Sends what the pilot has to say.
fn transmit<F: Fleet>(
    pilot: &mut Pilot<<F::Radio as Radio>::Address>,
    fleet: &mut F,
    now: impl Fn() -> FleetInstant,
) -> Result<(), RunError> {
    let mut buffer = [0; MAX_DATAGRAM];
    while let Some((to, datagram)) = pilot.poll_transmit(now(), &mut buffer) {
        fleet.radio().send(now(), to, datagram).map_err(Into::into)?;
    }
    Ok(())
}

/// Ticks of a thousandth of a second, simulated or awaited.
pub(super) struct Clock {
    pace: Pace,
    began: Instant,
    ticks: u64,
}

impl Clock {
    /// At tick zero, now.
    pub(super) fn new(pace: Pace) -> Self {
        Self { pace, began: Instant::now(), ticks: 0 }
    }

    /// Ticks so far.
    pub(super) fn ticks(&self) -> u64 {
        self.ticks
    }

    /// How long it has run by the wall clock, s.
    pub(super) fn elapsed_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// The next tick; in real time it waits for it.
    pub(super) fn next_tick(&mut self) -> FleetInstant {
        self.ticks += 1;
        let tick = self.ticks * u64::from(TICK.0);
        if self.pace != Pace::Simulated {
            let due = self.began + Duration::from_micros(tick);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        FleetInstant(tick)
    }

    /// The time now: of the tick in a simulation, of the wall clock otherwise.
    pub(super) fn now(&self, tick: FleetInstant) -> FleetInstant {
        match self.pace {
            Pace::Simulated | Pace::Watched => tick,
            Pace::Real => FleetInstant(self.began.elapsed().as_micros() as u64),
        }
    }
}

/// Any clock that only goes forward.
fn stopwatch() -> FleetInstant {
    static BEGAN: OnceLock<Instant> = OnceLock::new();
    FleetInstant(BEGAN.get_or_init(Instant::now).elapsed().as_micros() as u64)
}
