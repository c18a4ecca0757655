//! The controller of ROVs that carry out a plan: which of them answer, when the plan begins, and thrusts for each, twenty times a
//! second.
//!
//! ```text
//! 0 …              every robot announces itself, learns the fleet time, arms its controllers
//! then             the first thrusts, while robots and tools are held in their places: the propellers come up to speed
//! plan time 0 …    the water lets go; moves, one after the other, until the last robot holds in its slot
//! ```
//!
//! [`Conductor`] says what each robot is to do.

use link::dispatcher::{Dispatcher, DispatcherEvent, ModuleLink};
use protocol::message::MAX_THRUSTERS;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Newtons;
use protocol::{Delivery, ModuleKind, ModuleState, Motion, RovCycle};
use reconfiguration::plan::Plan;
use reconfiguration::problem::Problem;
use rov::dynamics::State;
use rov::power::PowerLaw;

use super::super::RunError;
use super::super::clock::Gap;
use super::super::host::{Controller, Dispatch, Patience, Step};
use super::super::orders::Order;
use super::ExecutionError;
use super::conductor::{AHEAD_S, Conductor, Coupling, HAND_OVER_S, PERIOD};
use super::water::{STEP, STEP_S, is_step};

/// Time that thrusts hold without another packet: five periods, so that four lost ones in a row do no harm.
const LEASE: Duration = Duration(250_000);
/// A robot that has been silent for this long does not answer. *Assumed*.
const SILENCE: Duration = Duration(300_000);
/// How long robots are waited for at the beginning. *Assumed*.
const PATIENCE: Patience = Patience { missing_after_s: 3.0, join_s: 30.0 };

/// See the module's documentation.
pub struct Execution<'a> {
    problem: &'a Problem,
    plan: &'a Plan,
    conductor: Conductor<'a>,
    /// Of all bodies, as they were seen last.
    states: Vec<State>,
    answering: Vec<bool>,
    /// When all robots were ready.
    joined: Option<FleetInstant>,
    origin: Option<FleetInstant>,
    /// Until when the conductor has been told that time passes.
    advanced: FleetInstant,
    number: u32,
    /// A stop, a hold or the end that an operator has ordered.
    halted: Option<Order>,
    /// Spans in which the host did not run: start, s of the plan's time, which stands still in them, and length, s.
    gaps: Vec<(f64, f64)>,
}

impl<'a> Execution<'a> {
    /// At the beginning of `plan`, allocating by `law`.
    ///
    /// # Errors
    /// As for [`Conductor::new`].
    pub fn new(problem: &'a Problem, plan: &'a Plan, law: PowerLaw) -> Result<Self, ExecutionError> {
        Ok(Self {
            problem,
            plan,
            conductor: Conductor::new(problem, plan, law)?,
            states: Vec::new(),
            answering: vec![false; problem.robots.len()],
            joined: None,
            origin: None,
            advanced: FleetInstant(0),
            number: 0,
            halted: None,
            gaps: Vec::new(),
        })
    }

    /// What each robot is to do.
    #[must_use]
    pub fn conductor(&self) -> &Conductor<'a> {
        &self.conductor
    }

    /// Spans in which the host did not run: start, s of the plan's time, which stands still in them, and length, s.
    #[must_use]
    pub fn gaps(&self) -> &[(f64, f64)] {
        &self.gaps
    }

    /// Which robots would obey at `now`; all have joined when all do.
    fn look<A: Copy>(&mut self, now: FleetInstant, links: &Dispatcher<A>) {
        let obeys =
            |state| matches!(state, ModuleState::Ready | ModuleState::Executing | ModuleState::Holding);
        let answers = |link: &ModuleLink<A>| {
            now.since(link.heard()) <= SILENCE
                && link.rov_telemetry().is_some_and(|report| obeys(report.state))
        };
        self.answering.clear();
        self.answering.extend(links.modules().iter().map(answers));
        if self.joined.is_none() && self.answering.iter().all(|answers| *answers) {
            self.joined = Some(now);
        }
        // Held in place until, by the end of the next step, the propellers give what balances.
        let up_to_speed =
            |joined: FleetInstant| now.after(STEP).as_secs_f64() - joined.as_secs_f64() >= 2.0 * HAND_OVER_S;
        if self.origin.is_none() && self.joined.is_some_and(up_to_speed) {
            self.origin = Some(now);
        }
    }

    fn dispatch(&mut self, now: FleetInstant) -> Result<Dispatch, ExecutionError> {
        self.number += 1;
        let motion = |thrusts_n: &Vec<f64>| {
            let thrusts = thrusts_n.iter().take(MAX_THRUSTERS);
            let thrusts = thrusts.map(|&thrust_n| Newtons(thrust_n as f32)).collect();
            Some(Motion::Rov(RovCycle { thrusts, lease: LEASE }))
        };
        let motions = self.conductor.commands_n(&self.states)?.iter().map(motion).collect();
        let start = now.after(Duration((AHEAD_S * 1e6) as u32));
        Ok(Dispatch { number: self.number, start, motions, delivery: Delivery::Direct })
    }
}

impl Controller for Execution<'_> {
    const MODULE: &'static str = "robot";
    const KIND: ModuleKind = ModuleKind::Rov;
    type Pose = [State];
    type Coupling = Coupling;

    fn handle_event<A: Copy>(&mut self, _event: DispatcherEvent, _links: &Dispatcher<A>) {}

    fn handle_pose(&mut self, states: &[State]) {
        self.states.clear();
        self.states.extend_from_slice(states);
    }

    fn handle_coupled(&mut self, coupling: Coupling) -> Result<(), RunError> {
        match coupling {
            Coupling::Undock(_) => Ok(()),
            Coupling::Dock(..) => Ok(self.conductor.docked()?),
        }
    }

    fn step<A: Copy>(
        &mut self,
        now: FleetInstant,
        links: &Dispatcher<A>,
    ) -> Result<Step<Coupling>, RunError> {
        if !is_step(now) {
            return Ok(Step::Wait);
        }
        // A step of the plan begins at its time zero, and ends now.
        let begun = self.origin.is_some_and(|origin| origin < now);
        if self.advanced < now {
            self.advanced = now;
            self.look(now, links);
            if begun {
                match self.conductor.advance(STEP_S, &self.states, &self.answering) {
                    Ok(None) => {}
                    Ok(Some(coupling)) => return Ok(Step::Couple(coupling)),
                    Err(ExecutionError::Failed(reason)) => return Ok(Step::End(Some(reason.to_string()))),
                    Err(error) => return Err(error.into()),
                }
            }
        }
        if begun && self.conductor.is_finished() {
            return Ok(Step::End(None));
        }
        // Held, robots are told to keep their place; stopped, nothing.
        let told = matches!(self.halted, None | Some(Order::Hold));
        if told && self.joined.is_some() && now.0.is_multiple_of(u64::from(PERIOD.0)) {
            return Ok(Step::Dispatch(self.dispatch(now)?));
        }
        Ok(Step::Wait)
    }

    /// The leases of the robots have ended. The time of the plan stands still, and goes on when its mover is where it should be.
    fn handle_gap(&mut self, gap: &Gap) {
        let Some(origin) = &mut self.origin else {
            // What balances has to come up to speed again.
            self.joined = None;
            return;
        };
        self.gaps.push((gap.start.as_secs_f64() - origin.as_secs_f64(), gap.length_s()));
        let period_us = u64::from(PERIOD.0);
        origin.0 += (gap.end.0 - gap.start.0) / period_us * period_us;
        self.conductor.pause();
    }

    fn finish(&mut self) {
        self.halted = Some(Order::End);
    }

    fn halt(&mut self, order: Order) {
        self.halted = Some(order);
        self.conductor.hold(true);
    }

    fn resume(&mut self) {
        self.halted = None;
        self.conductor.hold(false);
    }

    /// When the water lets go.
    fn origin(&self) -> Option<FleetInstant> {
        self.origin
    }

    fn duration_s(&self) -> f64 {
        self.plan.time_s
    }

    fn is_under_way(&self) -> bool {
        self.joined.is_some()
    }

    fn gets_on(&self) -> bool {
        !self.conductor.waits()
    }

    fn status<A: Copy>(&self, _links: &Dispatcher<A>) -> String {
        "all robots are ready: they balance, then the plan begins".to_owned()
    }

    /// Robots that would not obey.
    fn missing<A: Copy>(&self, _links: &Dispatcher<A>) -> Vec<usize> {
        (0..self.answering.len()).filter(|&robot| !self.answering[robot]).collect()
    }

    fn id<A: Copy>(&self, index: usize, _links: &Dispatcher<A>) -> u16 {
        self.problem.robots[index].id
    }

    fn patience(&self) -> Patience {
        PATIENCE
    }
}
