//! One execution: conductor, fleet and water, tick by tick.
//!
//! ```text
//! 0 …              every robot announces itself, learns the fleet time, arms its controllers
//! then             the first thrusts, while robots and tools are held in their places: the propellers come up to speed
//! plan time 0 …    the water lets go; moves, one after the other, until the last robot holds in its slot
//! ```
//!
//! Energy and time count from plan time 0.

use std::sync::atomic::{AtomicBool, Ordering};

use link::dispatcher::{self, Dispatcher};
use link::faults::FaultParameters;
use link::identity::HostIdentity;
use protocol::message::MAX_THRUSTERS;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Newtons;
use protocol::{Delivery, MAX_DATAGRAM, ModuleId, ModuleState, Motion, Radio, RovCycle};
use reconfiguration::plan::Plan;
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;
use record::reconfigure::{Record, RobotSample, Sample};
use rov::configuration_matrix::ConfigurationMatrix;
use rov::dynamics::State;
use rov::power::PowerLaw;
use sim::rov::basin::{Basin, BasinError};

use super::super::experiment::{Clock, Pace};
use super::super::progress::Progress;
use super::super::summary::LinkFigures;
use super::ExecutionError;
use super::accounts::Accounts;
use super::conductor::{AHEAD_S, Conductor, DOCK_M, DOCK_RAD, Event, HAND_OVER_S};
use super::fleet::{Fleet, InProcess};
use super::summary::{Energy, Summary};

/// Ticks of the fleet to one step of water and conductor.
const TICKS: u64 = 5;
/// That step, s: 200 Hz.
const STEP_S: f64 = TICKS as f64 * 1e-3;
/// Steps from one thrust packet, and one sample of the record, to the next.
const STEPS: u64 = 10;
/// Time that thrusts hold without another packet: five periods, so that four lost ones in a row do no harm.
const LEASE: Duration = Duration(250_000);
/// A robot that has been silent for this long does not answer. *Assumed*.
const SILENCE: Duration = Duration(300_000);
/// How long robots are waited for at the beginning, s. *Assumed*.
const JOIN_S: f64 = 30.0;

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

/// A fault that is planned into a run, for tests and drills: at every tick, with the time and plan time 0.
pub type Drill<'a, F> = &'a mut dyn FnMut(FleetInstant, Option<FleetInstant>, &mut F);

/// Executes `plan` with ROVs in this process, as fast as the machine can.
///
/// # Errors
/// [`ExecutionError`], for what cannot begin. What fails on the way is told in [`Summary::failure`].
pub fn execute(
    problem: &Problem,
    plan: &Plan,
    options: &Options,
    progress: &mut dyn Progress,
) -> Result<Executed, ExecutionError> {
    let mut fleet = InProcess::new(problem, options.radio, options.seed)?;
    let stop = AtomicBool::new(false);
    run(problem, plan, options, &mut fleet, Pace::Simulated, progress, &stop, &mut |_, _, _| {})
}

/// Executes `plan` with any fleet. `stop` ends it early: all robots go to neutral, and what was measured is kept.
///
/// # Errors
/// As for [`execute`].
#[expect(clippy::too_many_arguments, reason = "what is run, by which fleet, how fast, and what observes it")]
pub fn run<F: Fleet>(
    problem: &Problem,
    plan: &Plan,
    options: &Options,
    fleet: &mut F,
    pace: Pace,
    progress: &mut dyn Progress,
    stop: &AtomicBool,
    drill: Drill<'_, F>,
) -> Result<Executed, ExecutionError> {
    let mut stage = Stage::new(problem, plan, options)?;
    let roster: Vec<ModuleId> = (1..=problem.robots.len() as u16).map(ModuleId).collect();
    let HostIdentity { key, boot } = fleet.host();
    let mut dispatcher = Dispatcher::new(&roster, key, *boot);
    let mut clock = Clock::new(pace);
    let mut buffer = [0; MAX_DATAGRAM];
    let (mut joined, mut origin, mut failure) = (None::<FleetInstant>, None::<FleetInstant>, None::<String>);
    let (mut number, mut steps, mut reboots, mut known) = (0, 0_u64, 0, 0);

    loop {
        let tick = clock.next_tick();
        drill(tick, origin, fleet);
        fleet.advance(tick, &dispatcher)?;
        let mut now = clock.now(tick);
        while let Some((length, from)) = fleet.radio().receive(now, &mut buffer).map_err(Into::into)? {
            // What does not decode is counted; there is nothing else to do about it.
            if let Ok(Some(dispatcher::DispatcherEvent::Rebooted(robot))) =
                dispatcher.handle_datagram(now, from, &buffer[..length])
            {
                reboots += 1;
                progress.note(&format!("robot {} has lost its power and is back", problem.robots[robot].id));
            }
            now = clock.now(tick);
        }

        if clock.ticks().is_multiple_of(TICKS) {
            let answering = answering(&dispatcher, tick);
            let heard = answering.iter().filter(|answers| **answers).count();
            if joined.is_none() && heard != known {
                known = heard;
                progress.note(&format!("{known} of {} robots are ready", answering.len()));
            }
            if joined.is_none() && heard == answering.len() {
                joined = Some(tick);
            }
            if joined.is_none() && tick.as_secs_f64() > JOIN_S {
                let silent = problem.robots.iter().zip(&answering).filter(|(_, answers)| !**answers);
                let robots = silent.map(|(robot, _)| robot.id).collect();
                return Err(ExecutionError::Silent { robots, waited_s: JOIN_S });
            }
            // Held in place until the propellers give what balances.
            let up_to_speed =
                joined.is_some_and(|at| tick.as_secs_f64() - at.as_secs_f64() >= 2.0 * HAND_OVER_S);
            if origin.is_none() && up_to_speed {
                origin = Some(tick);
                progress.note("all robots balance: the plan begins");
            }
            if origin.is_some() {
                if steps.is_multiple_of(STEPS) {
                    stage.sample(steps as f64 * STEP_S, fleet, &dispatcher)?;
                    progress.at(steps as f64 * STEP_S, plan.time_s);
                }
                match stage.step(&fleet.thrusts_n(), &answering) {
                    Ok(()) => {}
                    Err(ExecutionError::Failed(reason)) => failure = Some(reason.to_string()),
                    Err(error) => return Err(error),
                }
                steps += 1;
            }
            if stop.load(Ordering::Relaxed) {
                failure = Some("interrupted".to_owned());
            }
            if failure.is_some() || (origin.is_some() && stage.conductor.is_finished()) {
                break;
            }
            if joined.is_some() && clock.ticks().is_multiple_of(TICKS * STEPS) {
                number += 1;
                let start = tick.after(Duration((AHEAD_S * 1e6) as u32));
                dispatcher.dispatch(tick, number, start, &motions(&stage.commands_n()?), Delivery::Direct);
            }
        }
        dispatcher.handle_timer(tick);
        transmit(&mut dispatcher, fleet, clock.now(tick))?;
    }
    stage.sample(steps as f64 * STEP_S, fleet, &dispatcher)?;
    dispatcher.hold();
    transmit(&mut dispatcher, fleet, clock.now(FleetInstant(clock.ticks() * 1_000)))?;

    let Stage { accounts, samples, .. } = stage;
    let moves = accounts.finish();
    let sum = |of: fn(&super::summary::MoveFigures) -> Energy| moves.iter().map(of).sum::<Energy>();
    let (planned, executed) = (sum(|m| m.planned), sum(|m| m.executed));
    let link = problem.robots.iter().zip(dispatcher.modules());
    let summary = Summary {
        problem: problem.name.clone(),
        criterion: plan.criterion,
        manner: plan.manner,
        seed: options.seed,
        failure,
        planned,
        expected: sum(|m| m.expected),
        executed,
        by_table: sum(|m| m.by_table),
        ratio: (planned.total_j > 0.0).then(|| executed.total_j / planned.total_j),
        reboots,
        link: link.map(|(robot, link)| LinkFigures::new(robot.id, link)).collect(),
        strays: *dispatcher.strays(),
        faults: fleet.faults(),
        wall_s: clock.elapsed_s(),
        moves,
    };
    Ok(Executed { record: Record { problem: problem.clone(), plan: plan.clone(), samples }, summary })
}

fn transmit<F: Fleet>(
    dispatcher: &mut Dispatcher<<F::Radio as Radio>::Address>,
    fleet: &mut F,
    now: FleetInstant,
) -> Result<(), ExecutionError> {
    let mut buffer = [0; MAX_DATAGRAM];
    while let Some((to, datagram)) = dispatcher.poll_transmit(now, &mut buffer) {
        fleet.radio().send(now, to, datagram).map_err(Into::into)?;
    }
    Ok(())
}

/// Which robots would obey at `now`.
fn answering<A: Copy>(dispatcher: &Dispatcher<A>, now: FleetInstant) -> Vec<bool> {
    let obeys = |state| matches!(state, ModuleState::Ready | ModuleState::Executing | ModuleState::Holding);
    let links = dispatcher.modules().iter();
    links
        .map(|link| {
            now.since(link.heard()) <= SILENCE
                && link.rov_telemetry().is_some_and(|report| obeys(report.state))
        })
        .collect()
}

fn motions(thrusts_n: &[Vec<f64>]) -> Vec<Option<Motion>> {
    let motion = |thrusts_n: &Vec<f64>| {
        let thrusts =
            thrusts_n.iter().take(MAX_THRUSTERS).map(|&thrust_n| Newtons(thrust_n as f32)).collect();
        Some(Motion::Rov(RovCycle { thrusts, lease: LEASE }))
    };
    thrusts_n.iter().map(motion).collect()
}

/// The water with all bodies in it, and the conductor.
struct Stage<'a> {
    conductor: Conductor<'a>,
    basin: Basin,
    accounts: Accounts,
    /// Of robots, then tools.
    vehicles: Vec<&'a Vehicle>,
    /// Of robots, about their own origins.
    matrices: Vec<ConfigurationMatrix>,
    states: Vec<State>,
    samples: Vec<Sample>,
}

impl<'a> Stage<'a> {
    fn new(problem: &'a Problem, plan: &'a Plan, options: &Options) -> Result<Self, ExecutionError> {
        let conductor = Conductor::new(problem, plan, options.law.clone())?;
        let robots = problem.robots.iter().map(|robot| (robot.start, robot.vehicle));
        let tools = problem.tools.iter().map(|tool| (tool.pose, tool.vehicle));
        let kinds = robots.chain(tools).filter_map(|(pose, kind)| Some((pose, problem.vehicles.get(kind)?)));
        let bodies: Vec<(Pose, &Vehicle)> = kinds.collect();
        let basin = Basin::new(&bodies)?;
        let matrix = |&(_, vehicle): &(Pose, &Vehicle)| ConfigurationMatrix::of_vehicle(vehicle);
        let matrices = bodies.iter().take(problem.robots.len()).map(matrix).collect::<Result<_, _>>();
        Ok(Self {
            conductor,
            accounts: Accounts::new(problem, plan, &options.law)?,
            states: (0..bodies.len()).map(|body| basin.state(body)).collect(),
            basin,
            vehicles: bodies.iter().map(|(_, vehicle)| *vehicle).collect(),
            matrices: matrices.map_err(BasinError::from)?,
            samples: Vec::new(),
        })
    }

    fn commands_n(&mut self) -> Result<Vec<Vec<f64>>, ExecutionError> {
        self.conductor.commands_n(&self.states)
    }

    /// The next 5 ms of all bodies.
    fn step(&mut self, thrusts_n: &[&[f64]], answering: &[bool]) -> Result<(), ExecutionError> {
        self.basin.step(STEP_S, thrusts_n);
        self.accounts.spend(STEP_S, &self.conductor, thrusts_n);
        self.observe();
        match self.conductor.advance(STEP_S, &self.states, answering)? {
            Some(Event::Undock(robot)) => self.basin.undock(robot)?,
            Some(Event::Dock(robot, slot)) => {
                let misfit = self.basin.misfit(robot, slot);
                if let Some(number) = self.conductor.moving()
                    && misfit.position_m <= DOCK_M
                    && misfit.angle_rad <= DOCK_RAD
                {
                    self.basin.dock(robot, slot)?;
                    self.accounts.end(number, &misfit);
                    self.conductor.docked()?;
                    self.observe();
                }
            }
            None => {}
        }
        Ok(())
    }

    fn observe(&mut self) {
        for (body, state) in self.states.iter_mut().enumerate() {
            *state = self.basin.state(body);
        }
    }

    fn sample<F: Fleet>(
        &mut self,
        t_s: f64,
        fleet: &F,
        dispatcher: &Dispatcher<<F::Radio as Radio>::Address>,
    ) -> Result<(), ExecutionError> {
        self.accounts.look(&self.conductor, &self.states, &self.vehicles);
        let reference = self.conductor.reference();
        let robots =
            self.matrices.iter().zip(fleet.thrusts_n()).enumerate().map(|(robot, (matrix, thrusts_n))| {
                let reference = reference.filter(|(mover, _)| *mover == robot);
                RobotSample {
                    eta: self.states[robot].eta(),
                    nu: self.states[robot].nu.into(),
                    tau: matrix.wrench(thrusts_n),
                    thrusts_n: thrusts_n.to_vec(),
                    pulses_us: fleet.pulses_us(robot, dispatcher),
                    power_w: self.accounts.power_w(thrusts_n),
                    reference: reference.map(|(_, reference)| reference.pose),
                    arrived: self.conductor.arrived()[robot],
                }
            });
        let robots: Vec<RobotSample> = robots.collect();
        let tool = (robots.len() < self.states.len()).then_some(robots.len());
        let restoring_nm = tool.map_or([0.0; 2], |tool| self.basin.restoring_nm(tool));
        self.samples.push(Sample { t_s, moving: self.conductor.moving(), restoring_nm, robots });
        Ok(())
    }
}
