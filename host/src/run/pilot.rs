//! The host's closed loop: observes the structure, decides once a cycle, dispatches the decision.
//!
//! Sans-IO like everything that talks: fixes, datagrams and the time go in, datagrams come out.
//!
//! ```text
//! fixes → Observer → Controller (13)–(19) → wrench → Planner → cycles → Dispatcher → datagrams
//!                                                      ↑ where every tail will be ← acknowledgements, telemetry
//! ```
//!
//! A decision falls `lead` before the running cycle ends. It needs to know where every tail will be then: at the
//! end pose of the running cycle if the module certainly has it, where it reports to rest if not. While that is
//! unknown of one module nothing is sent, everybody finishes and holds, and the loop starts again as soon as all
//! are ready.

use protocol::ModuleState;
use protocol::units::{Micros, MicrosSpan, Radians};
use protocol::{DecodeError, ModboatCycle, Motion};
use std::sync::Arc;

use super::scenario::{Leg, Scenario};
use crate::link::dispatcher::{Dispatcher, Event};
use crate::modboat::control::{Controller, Observation, Target};
use crate::modboat::distance::DistanceToCollision;
use crate::modboat::motion::{Swing, Turn, Wrench};
use crate::modboat::observer::{Fix, Observer};
use crate::modboat::plan::{Outcome, Plan};
use crate::modboat::planner::Planner;
use crate::modboat::table::Table;
use crate::quantity::ParameterError;

/// One decision, as dispatched (or, where the fleet is held, as not dispatched).
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Cycle number k, from 1.
    pub number: u32,
    /// Start of the transition, fleet time.
    pub start: Micros,
    /// Length of the transition; zero where none is needed.
    pub transition: MicrosSpan,
    /// Length of the swim cycle.
    pub period: MicrosSpan,
    /// The wrench asked for.
    pub demand: Wrench,
    /// Each module's transition; from = to where it does not move.
    pub turns: Vec<Turn>,
    /// The plan.
    pub plan: Plan,
    /// Time the planner took, µs.
    pub solve_us: u64,
}

impl Decision {
    /// Start of the swim cycle.
    #[must_use]
    pub fn swim_start(&self) -> Micros {
        self.start.after(self.transition)
    }

    /// End of the swim cycle.
    #[must_use]
    pub fn end(&self) -> Micros {
        self.swim_start().after(self.period)
    }
}

/// See the module's documentation. `A` is the radio's address.
pub struct Pilot<A> {
    scenario: Scenario,
    dispatcher: Dispatcher<A>,
    observer: Observer,
    controller: Controller,
    planner: Planner,
    stopwatch: fn() -> Micros,
    lead: MicrosSpan,
    /// What the observer takes to act now.
    wrench: Wrench,
    /// All decisions so far; the last one may still run.
    decisions: Vec<Decision>,
    /// Whether the last decision is on its way or being executed.
    swimming: bool,
    /// After an attempt that found no plan, when to try again.
    retry: Micros,
    origin: Option<Micros>,
    finished: bool,
    reboots: u32,
    refusals: u32,
}

impl<A: Copy> Pilot<A> {
    /// For one scenario; `session` tells this life of the host from its earlier ones. The planner searches by `table`, if
    /// there is one, whatever the scenario says. `stopwatch` is any clock that says how long the planner took.
    ///
    /// # Errors
    /// [`ParameterError`] for numbers the observer or planner cannot work with.
    pub fn new(
        scenario: &Scenario,
        session: u32,
        table: Option<Arc<Table>>,
        stopwatch: fn() -> Micros,
    ) -> Result<Self, ParameterError> {
        let Scenario { structure, modboat, .. } = scenario;
        let distance = Arc::new(DistanceToCollision::new(modboat));
        let mut planner = Planner::with_distance(structure, modboat, &scenario.planner, distance);
        if let Some(table) = table {
            planner = planner.with_table(table);
        }
        let modules = structure.len() as u16;
        Ok(Self {
            scenario: scenario.clone(),
            dispatcher: Dispatcher::new(modules, session),
            observer: Observer::new(structure, modboat, &scenario.observer)?,
            controller: Controller::new(structure, modboat, &scenario.control),
            planner,
            stopwatch,
            lead: span(scenario.timing.lead_s),
            wrench: Wrench::default(),
            decisions: Vec::new(),
            swimming: false,
            retry: Micros(0),
            origin: None,
            finished: false,
            reboots: 0,
            refusals: 0,
        })
    }

    /// Takes in one datagram.
    ///
    /// # Errors
    /// [`DecodeError`] if it is none; it is counted and nothing happens.
    pub fn handle_datagram(&mut self, now: Micros, from: A, datagram: &[u8]) -> Result<(), DecodeError> {
        match self.dispatcher.handle_datagram(now, from, datagram)? {
            Some(Event::Rebooted(_)) => self.reboots += 1,
            Some(Event::Refused { .. }) => self.refusals += 1,
            _ => {}
        }
        Ok(())
    }

    /// Takes in one fix; its time is fleet time.
    pub fn handle_fix(&mut self, fix: &Fix) {
        self.observer.update(fix);
    }

    /// Does what is due at `now`.
    pub fn handle_timer(&mut self, now: Micros) {
        let wrench = self.wrench_at(now);
        if wrench != self.wrench {
            self.observer.predict(now.as_secs_f64());
            self.observer.set_wrench(wrench);
            self.wrench = wrench;
        }
        self.dispatcher.handle_timer(now);
        if self.finished {
            return;
        }
        if self
            .origin
            .is_some_and(|origin| now.as_secs_f64() - origin.as_secs_f64() >= self.scenario.duration_s())
        {
            self.finish();
            return;
        }
        match self.decisions.last().filter(|_| self.swimming).map(Decision::end) {
            Some(end) if now.after(self.lead) >= end => self.decide(now, end),
            None if now >= self.retry => self.decide(now, now.after(self.lead)),
            _ => {}
        }
    }

    /// Ends the run: everybody finishes the running cycle and holds.
    pub fn finish(&mut self) {
        if !self.finished {
            self.finished = true;
            self.dispatcher.hold();
        }
    }

    /// The next datagram to send, if any, and where to.
    pub fn poll_transmit(&mut self) -> Option<(A, Vec<u8>)> {
        self.dispatcher.poll_transmit()
    }

    /// Start of the first cycle, fleet time: time zero of the run.
    pub fn origin(&self) -> Option<Micros> {
        self.origin
    }

    /// Whether the run is over.
    pub fn is_finished(&self) -> bool {
        self.finished
    }

    /// Whether a cycle runs or is on its way.
    pub fn is_swimming(&self) -> bool {
        self.swimming
    }

    /// All decisions so far.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// The link.
    pub fn dispatcher(&self) -> &Dispatcher<A> {
        &self.dispatcher
    }

    /// How often a module was seen to reboot.
    pub fn reboots(&self) -> u32 {
        self.reboots
    }

    /// How often a module refused a cycle.
    pub fn refusals(&self) -> u32 {
        self.refusals
    }

    /// Modules (by index) whose tails nobody knows for the next cycle.
    pub fn missing(&self) -> Vec<usize> {
        (0..self.dispatcher.modules().len()).filter(|&index| self.pose_of(index).is_none()).collect()
    }

    /// Mean wrench that the fleet is meant to give at `now`, over the whole cycle with its transition: the observer
    /// averages over that anyway, and a step between the two would only pass for a motion.
    fn wrench_at(&self, now: Micros) -> Wrench {
        // While the last decision waits for its start, the one before it runs.
        let running = self.decisions.iter().rev().take(2).find(|decision| decision.start <= now);
        running.filter(|decision| now < decision.end()).map_or(Wrench::default(), |decision| {
            let period_s = f64::from(decision.period.as_secs_f32());
            let share = period_s / (period_s + f64::from(decision.transition.as_secs_f32()));
            Wrench::from_array(decision.plan.wrench.to_array().map(|component| component * share))
        })
    }

    /// Where module `index` will rest when what it has is over, if that is known.
    fn pose_of(&self, index: usize) -> Option<f64> {
        let link = &self.dispatcher.modules()[index];
        let report = link.telemetry()?;
        match self.decisions.last().filter(|_| self.swimming) {
            Some(decision) if link.has(decision.number) => Some(decision.turns[index].to_rad),
            _ => matches!(report.state, ModuleState::Ready | ModuleState::Holding)
                .then(|| f64::from(report.tail.0)),
        }
    }

    /// Plans the cycle that starts at `start` and sends it; holds the fleet if that cannot be done.
    fn decide(&mut self, now: Micros, start: Micros) {
        self.swimming_over_if_unknown();
        let poses: Option<Vec<f64>> =
            (0..self.dispatcher.modules().len()).map(|index| self.pose_of(index)).collect();
        let (Some(poses), Some(estimate)) = (poses, self.observer.estimate()) else {
            self.swimming = false;
            return;
        };
        let parameters = &self.scenario.modboat;
        let (transition, period) = (span(parameters.transition_s), span(parameters.period_s));
        let interval_s = parameters.transition_s + parameters.period_s;
        let horizon_s = start.as_secs_f64() - now.as_secs_f64() + interval_s;
        // A cycle that straddles two legs belongs to the one that has more of it.
        let start_s = self.origin.map_or(0.0, |origin| start.as_secs_f64() - origin.as_secs_f64());
        let leg_time_s = start_s + 0.5 * interval_s;
        let &Leg { velocity_m_s, heading_rad, .. } = self.scenario.leg_at(leg_time_s);
        let observed = Observation {
            velocity_m_s: estimate.velocity_m_s,
            heading_rad: estimate.heading_rad,
            yaw_rate_rad_s: estimate.yaw_rate_rad_s,
        };
        let target = Target { velocity_m_s, heading_rad };
        let demand = self.controller.demand(&target, &observed, interval_s, horizon_s);

        let began = (self.stopwatch)();
        let previous = self.decisions.last().map(|decision| decision.plan.cycle.as_slice());
        let plan = self.planner.plan(demand, Some(&poses), previous);
        let solve_us = u64::from((self.stopwatch)().since(began).0);

        let turns = plan
            .transition
            .clone()
            .unwrap_or_else(|| poses.iter().map(|&pose| Turn { from_rad: pose, to_rad: pose }).collect());
        let transition = if plan.transition.is_some() { transition } else { MicrosSpan(0) };
        let number = self.decisions.last().map_or(1, |decision| decision.number + 1);
        let decision = Decision { number, start, transition, period, demand, turns, plan, solve_us };
        self.swimming = decision.plan.outcome != Outcome::Held;
        if self.swimming {
            self.origin.get_or_insert(start);
            self.dispatcher.dispatch(now, number, start, &cycles(&decision));
        } else {
            self.retry = decision.end();
        }
        self.decisions.push(decision);
    }

    /// A module that lost the running cycle (it rebooted, or never had it) leaves the rhythm of the others.
    fn swimming_over_if_unknown(&mut self) {
        let Some(decision) = self.decisions.last().filter(|_| self.swimming) else { return };
        let number = decision.number;
        if !self.dispatcher.modules().iter().all(|link| link.has(number)) {
            self.swimming = false;
        }
    }
}

/// What goes over the wire for one decision.
fn cycles(decision: &Decision) -> Vec<Motion> {
    let one = |(swing, turn): (&Swing, &Turn)| {
        Motion::Modboat(ModboatCycle {
            rotation: Radians(turn.rotation_rad() as f32),
            centerline: Radians(swing.centerline_rad as f32),
            amplitude: Radians(swing.amplitude_rad as f32),
            transition: decision.transition,
            period: decision.period,
        })
    };
    decision.plan.cycle.iter().zip(&decision.turns).map(one).collect()
}

fn span(seconds: f64) -> MicrosSpan {
    MicrosSpan((seconds * 1e6).round() as u32)
}
