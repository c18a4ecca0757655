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
//!
//! Decisions follow each other as the plans say: one interval is the plan's own transition, none where nobody moves,
//! and one period. The controller has to know the interval before there is a plan: it takes that of the decision
//! before, and that of a full transition for the first.
//!
//! A transition in two steps goes out as two cycles ([`Via`]): the first turns to the poses between and
//! rests there, the second, sent when everybody certainly has the first, does the rest. If somebody has not, the second
//! is never sent: the fleet holds, at the poses between or where it was.

use protocol::DecodeError;
use protocol::ModuleState;
use protocol::units::{Micros, MicrosSpan};
use std::sync::Arc;

use super::scenario::{Demand, Leg, Scenario};
use crate::link::dispatcher::{Dispatcher, Event};
use crate::modboat::control::{Controller, Observation, Target};
use crate::modboat::distance::DistanceToCollision;
use crate::modboat::motion::{Turn, Wrench};
use crate::modboat::observer::{Fix, Observer};
use crate::modboat::plan::{Outcome, Plan};
use crate::modboat::planner::Planner;
use crate::modboat::table::Table;
use crate::quantity::ParameterError;

pub use decision::{Decision, Via};
use decision::{cycles, first_cycles, give_up_second, steps};

mod decision;

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
    /// Whether its second step is still to be sent.
    second: bool,
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
            second: false,
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
        if self.second {
            self.send_second(now);
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
            Some(Decision { number, via: Some(via), .. }) if self.second && link.has(*number) => {
                Some(via.rad[index])
            }
            Some(decision) if link.has(decision.last_number()) => Some(decision.turns[index].to_rad),
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
        // Of the plan that is to be made only the last one's interval is known.
        let transition_s = self
            .decisions
            .last()
            .map_or(parameters.transition_s, |last| f64::from(last.transition.as_secs_f32()));
        let interval_s = transition_s + parameters.period_s;
        let horizon_s = start.as_secs_f64() - now.as_secs_f64() + interval_s;
        // A cycle that straddles two legs belongs to the one that has more of it.
        let start_s = self.origin.map_or(0.0, |origin| start.as_secs_f64() - origin.as_secs_f64());
        let leg_time_s = start_s + 0.5 * interval_s;
        let &Leg { demand, heading_rad, .. } = self.scenario.leg_at(leg_time_s);
        let observed = Observation {
            velocity_m_s: estimate.velocity_m_s,
            heading_rad: estimate.heading_rad,
            yaw_rate_rad_s: estimate.yaw_rate_rad_s,
        };
        let velocity_m_s = match demand {
            Demand::Velocity(velocity_m_s) => velocity_m_s,
            Demand::Station(station_m) => {
                self.controller.towards(station_m, estimate.position_m, &observed, horizon_s)
            }
        };
        let target = Target { velocity_m_s, heading_rad };
        let demand = self.controller.demand(&target, &observed, interval_s, horizon_s);

        let began = (self.stopwatch)();
        let previous = self.decisions.last().map(|decision| decision.plan.cycle.as_slice());
        let plan = self.planner.plan(demand, Some(&poses), previous);
        let solve_us = u64::from((self.stopwatch)().since(began).0);
        self.carry_out(now, start, demand, &poses, plan, solve_us);
    }

    /// Sends what was planned for `start`, with the tails at `poses`.
    fn carry_out(
        &mut self,
        now: Micros,
        start: Micros,
        demand: Wrench,
        poses: &[f64],
        plan: Plan,
        solve_us: u64,
    ) {
        let period = span(self.scenario.modboat.period_s);
        let turns = plan
            .transition
            .clone()
            .unwrap_or_else(|| poses.iter().map(|&pose| Turn { from_rad: pose, to_rad: pose }).collect());
        let speed_max_rad_s = self.scenario.modboat.tail_speed_max_rad_s;
        let (via, transition) = steps(&plan, &turns, speed_max_rad_s);
        let number = self.decisions.last().map_or(1, |decision| decision.last_number() + 1);
        let decision = Decision { number, start, transition, via, period, demand, turns, plan, solve_us };
        self.swimming = decision.plan.outcome != Outcome::Held;
        self.second = self.swimming && decision.via.is_some();
        if self.swimming {
            self.origin.get_or_insert(start);
            self.dispatcher.dispatch(now, number, start, &first_cycles(&decision));
        } else {
            self.retry = decision.end();
        }
        self.decisions.push(decision);
    }

    /// Sends the second step of the last decision when it is due, or gives it up.
    fn send_second(&mut self, now: Micros) {
        let Some(decision) = self.decisions.last_mut() else { return };
        let start = decision.last_start();
        // A module keeps one cycle beside the one it runs: the first must have begun.
        if now < decision.start || now.after(self.lead) < start {
            return;
        }
        self.second = false;
        if self.dispatcher.modules().iter().all(|link| link.has(decision.number)) {
            self.dispatcher.dispatch(now, decision.last_number(), start, &cycles(decision));
        } else {
            self.swimming = false;
            give_up_second(decision);
        }
    }

    /// A module that lost the running cycle (it rebooted, or never had it) leaves the rhythm of the others.
    fn swimming_over_if_unknown(&mut self) {
        let Some(decision) = self.decisions.last().filter(|_| self.swimming) else { return };
        let number = decision.last_number();
        if !self.dispatcher.modules().iter().all(|link| link.has(number)) {
            self.swimming = false;
        }
    }
}

fn span(seconds: f64) -> MicrosSpan {
    MicrosSpan((seconds * 1e6).round() as u32)
}

#[cfg(test)]
mod tests;
