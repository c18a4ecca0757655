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
//! end pose of the running cycle if the module reports that it runs it, where it reports to rest if not. For a report that
//! is missing it waits until [`DECIDE_BY`]. While one pose is unknown nothing is sent, the modules finish their cycle and hold, and the
//! loop starts again as soon as all are ready. Where fewer are required, one that is silent for long is missing: its tail may be
//! anywhere, no other module comes within its reach, and the others swim. When it is back, and rests where it says, the next decision
//! counts on it again.
//!
//! Decisions follow each other as the plans say: one interval is the plan's own transition, none where no tail moves,
//! and one period. The controller has to know the interval before there is a plan: it takes that of the decision
//! before, and that of a full transition for the first.
//!
//! A transition in two steps goes out as two cycles ([`Via`]): the first turns to the poses between and
//! rests there, the second, sent when every module certainly has the first, does the rest. If one has not, the second
//! is never sent: the fleet holds, at the poses between or where it was.

use firmware::link::session::SURE_WITHIN;
use protocol::ledger::Class;
use protocol::time::{Duration, FleetInstant};
use protocol::{Delivery, ModuleId, ModuleState, Motion};
use std::sync::Arc;

use link::delivery::Knowledge;
use link::dispatcher::{Dispatcher, DispatcherEvent, ModuleLink};
use link::identity::HostIdentity;
use modboat::control::{Controller, Observation, Target};
use modboat::distance::DistanceToCollision;
use modboat::distance_table::DistanceTable;
use modboat::motion::{Turn, Wrench};
use modboat::observer::{Fix, Observer};
use modboat::plan::{Outcome, Plan};
use modboat::planner::Planner;
use modboat::setting::Participation;
use quantity::ParameterError;

use super::scenario::{Demand, Leg, Scenario, Timing};

pub use decision::{Decision, Order, Via};
use decision::{cycles, first_cycles, give_up, give_up_second, steps};

mod decision;

/// Time before the end of the running cycle from which a decision no longer waits for reports: what it sends must get through. *Assumed.*
pub const DECIDE_BY: Duration = Duration(200_000);

/// A fleet at rest begins when every module is that sure of the fleet time: with something in hand for the time until the start.
const SURE_TO_BEGIN: Duration = Duration(SURE_WITHIN.0 / 4 * 3);

/// See the module's documentation. `A` is the radio's address.
pub struct Pilot<A> {
    scenario: Scenario,
    dispatcher: Dispatcher<A>,
    observer: Observer,
    controller: Controller,
    planner: Planner,
    distance: Arc<DistanceToCollision>,
    /// The planner without the missing modules.
    partial: Option<(Vec<Participation>, Planner)>,
    stopwatch: fn() -> FleetInstant,
    lead: Duration,
    /// What the observer takes to act now.
    wrench: Wrench,
    /// All decisions so far; the last one may still run.
    decisions: Vec<Decision>,
    /// Whether the last decision is on its way or being executed.
    swimming: bool,
    /// Whether its second step is still to be sent.
    second: bool,
    /// After an attempt that found no plan, when to try again.
    retry: FleetInstant,
    origin: Option<FleetInstant>,
    finished: bool,
    reboots: u32,
    refusals: u32,
    dropped: u32,
}

impl<A: Copy> Pilot<A> {
    /// For one scenario, as the host `host`, with the modules of `roster` in the structure's places. The planner searches by `table`, if
    /// there is one, whatever the scenario says. `stopwatch` is any clock that says how long the planner took.
    ///
    /// # Errors
    /// [`ParameterError`] for numbers the observer or planner cannot work with.
    pub fn new(
        scenario: &Scenario,
        host: &HostIdentity,
        roster: &[ModuleId],
        table: Option<Arc<DistanceTable>>,
        stopwatch: fn() -> FleetInstant,
    ) -> Result<Self, ParameterError> {
        let Scenario { structure, modboat, .. } = scenario;
        let distance = Arc::new(DistanceToCollision::new(modboat));
        let mut planner =
            Planner::with_distance(structure, modboat, &scenario.planner, Arc::clone(&distance));
        if let Some(table) = table {
            planner = planner.with_table(table);
        }
        Ok(Self {
            scenario: scenario.clone(),
            dispatcher: Dispatcher::new(roster, &host.key, host.boot),
            observer: Observer::new(structure, modboat, &scenario.observer)?,
            controller: Controller::new(structure, modboat, &scenario.control),
            planner,
            distance,
            partial: None,
            stopwatch,
            lead: span(scenario.timing.lead_s),
            wrench: Wrench::default(),
            decisions: Vec::new(),
            swimming: false,
            second: false,
            retry: FleetInstant(0),
            origin: None,
            finished: false,
            reboots: 0,
            refusals: 0,
            dropped: 0,
        })
    }

    /// Takes in one datagram.
    ///
    /// # Errors
    /// What it is, if it is not to be followed; it is counted and nothing happens.
    pub fn handle_datagram(&mut self, now: FleetInstant, from: A, datagram: &[u8]) -> Result<(), Class> {
        match self.dispatcher.handle_datagram(now, from, datagram)? {
            Some(DispatcherEvent::Rebooted(_)) => self.reboots += 1,
            Some(DispatcherEvent::Refused { .. }) => self.refusals += 1,
            Some(DispatcherEvent::Reported(index))
                if self.dispatcher.modules()[index].state() == Some(ModuleState::Stopped) =>
            {
                self.let_go();
            }
            _ => {}
        }
        Ok(())
    }

    /// Takes in one fix; its time is fleet time.
    pub fn handle_fix(&mut self, fix: &Fix) {
        self.observer.update(fix);
    }

    /// Does what is due at `now`.
    pub fn handle_timer(&mut self, now: FleetInstant) {
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
        self.forget_if_dropped(now);
        match self.decisions.last().filter(|_| self.swimming).map(Decision::end) {
            Some(end) if now.after(self.lead) >= end && !self.waits_for_reports(now, end) => {
                self.decide(now, end);
            }
            None if now >= self.retry => self.decide(now, now.after(self.lead)),
            _ => {}
        }
    }

    /// Ends the run: the modules finish the running cycle and hold.
    pub fn finish(&mut self) {
        if !self.finished {
            self.finished = true;
            self.dispatcher.hold();
        }
    }

    /// Writes the next datagram to send, if any, to the start of `buffer`, and says where to.
    pub fn poll_transmit<'a>(&mut self, now: FleetInstant, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        self.dispatcher.poll_transmit(now, buffer)
    }

    /// Start of the first cycle, fleet time: time zero of the run.
    pub fn origin(&self) -> Option<FleetInstant> {
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

    /// How often a cycle that no module may miss was given up because a module might have missed it.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Modules (by index) that the next cycle waits for: their tail angles are unknown, or they do not know the time.
    pub fn missing(&self) -> Vec<usize> {
        let waited_for = |&index: &usize| self.pose_of(index).is_none() || !self.is_sure(index);
        (0..self.dispatcher.modules().len()).filter(waited_for).collect()
    }

    /// Mean wrench that the fleet is meant to give at `now`, over the whole cycle with its transition: the observer
    /// averages over that anyway, and a step between the two would only pass for a motion.
    fn wrench_at(&self, now: FleetInstant) -> Wrench {
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
            // It rests where it says, if it says so after the start of all that it may have taken.
            _ => (matches!(report.state, ModuleState::Ready | ModuleState::Holding) && link.is_up_to_date())
                .then(|| f64::from(report.tail.0)),
        }
    }

    /// Whether a report that would tell which modules run the cycle that ends at `end` may still come in time.
    fn waits_for_reports(&self, now: FleetInstant, end: FleetInstant) -> bool {
        let Some(decision) = self.decisions.last() else { return false };
        let number = decision.last_number();
        let unknown = |(link, &missing): (&ModuleLink<A>, &bool)| {
            !missing && link.knowledge(number) == Knowledge::Possibly
        };
        now.after(DECIDE_BY) < end && self.dispatcher.modules().iter().zip(&decision.missing).any(unknown)
    }

    /// Plans the cycle that starts at `start` and sends it; holds the fleet if that cannot be done.
    fn decide(&mut self, now: FleetInstant, start: FleetInstant) {
        self.swimming_over_if_unknown();
        let known: Vec<Option<f64>> =
            (0..self.dispatcher.modules().len()).map(|index| self.pose_of(index)).collect();
        let (true, Some(estimate)) = (self.is_enough(now, &known), self.observer.estimate()) else {
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
            unknown_m_s2: estimate.unknown_m_s2,
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
        let participation = Planner::participation(&self.scenario.structure, &self.distance, &known);
        // Where the pose is unknown any angle will do: nothing is sent to that module.
        let poses: Vec<f64> = known.iter().map(|pose| pose.unwrap_or(0.0)).collect();
        let Some(planner) =
            planner_for(&mut self.planner, &mut self.partial, &self.scenario, &self.distance, &participation)
        else {
            self.swimming = false;
            return;
        };
        let plan = planner.plan(demand, Some(&poses), previous);
        let solve_us = u64::from((self.stopwatch)().since(began).0);
        let missing = known.iter().map(Option::is_none).collect();
        self.carry_out(now, start, demand, (&poses, missing), plan, solve_us);
    }

    /// Whether a module knows the fleet time well enough to be begun with. Once the fleet swims,
    /// a module itself refuses a cycle that its clock is not sure enough for.
    fn is_sure(&self, index: usize) -> bool {
        let health = self.dispatcher.modules()[index].health();
        self.swimming || health.is_some_and(|health| health.uncertainty <= SURE_TO_BEGIN)
    }

    /// Whether the tails of enough modules are known: of all, or of those that are required while the others are missing.
    fn is_enough(&self, now: FleetInstant, known: &[Option<f64>]) -> bool {
        let Timing { require, missing_after_s, .. } = self.scenario.timing;
        let count = known.iter().flatten().count();
        let silent = |index: usize| {
            let heard = self.dispatcher.modules()[index].heard();
            f64::from(now.since(heard).as_secs_f32()) >= missing_after_s
        };
        let unknown = || (0..known.len()).filter(|&index| known[index].is_none());
        let sure = (0..known.len()).filter(|&index| known[index].is_some()).all(|index| self.is_sure(index));
        sure && (count == known.len() || require > 0 && count >= require as usize && unknown().all(silent))
    }

    /// Sends what was planned for `start`, with the tails at `poses`.
    fn carry_out(
        &mut self,
        now: FleetInstant,
        start: FleetInstant,
        demand: Wrench,
        (poses, missing): (&[f64], Vec<bool>),
        plan: Plan,
        solve_us: u64,
    ) {
        let period = span(self.scenario.modboat.period_s);
        let turns = plan
            .transition
            .clone()
            .unwrap_or_else(|| poses.iter().map(|&pose| Turn { from_rad: pose, to_rad: pose }).collect());
        let (via, transition) = steps(&plan, &turns);
        let number = self.decisions.last().map_or(1, |decision| decision.last_number() + 1);
        let decision =
            Decision { number, start, transition, via, period, demand, missing, turns, plan, solve_us };
        self.swimming = decision.plan.outcome != Outcome::Held;
        self.second = self.swimming && decision.via.is_some();
        if self.swimming {
            self.origin.get_or_insert(start);
            let motions = of_those_present(first_cycles(&decision), &decision);
            self.dispatcher.dispatch(now, number, start, &motions, delivery(&decision));
        } else {
            self.retry = decision.end();
        }
        self.decisions.push(decision);
    }

    /// Sends the second step of the last decision when it is due, or gives it up.
    fn send_second(&mut self, now: FleetInstant) {
        let Some(decision) = self.decisions.last_mut() else { return };
        let start = decision.last_start();
        // A module keeps one cycle beside the one it runs: the first must have begun.
        if now < decision.start || now.after(self.lead) < start {
            return;
        }
        self.second = false;
        if all_have(&self.dispatcher, decision, decision.number) {
            let (number, delivery) = (decision.last_number(), delivery(decision));
            let motions = of_those_present(cycles(decision), decision);
            self.dispatcher.dispatch(now, number, start, &motions, delivery);
        } else {
            self.swimming = false;
            give_up_second(decision);
        }
    }

    /// A cycle that might not reach every module in time is run by no module: another is planned when its start has
    /// passed.
    fn forget_if_dropped(&mut self, now: FleetInstant) {
        let Some(decision) = self.decisions.last_mut().filter(|_| self.swimming) else { return };
        let (number, start) = if self.second {
            (decision.number, decision.start)
        } else {
            (decision.last_number(), decision.last_start())
        };
        if now >= start || !self.dispatcher.is_dropped(number) {
            return;
        }
        if decision.via.is_some() && !self.second {
            give_up_second(decision);
        } else {
            give_up(decision, self.lead);
        }
        self.dropped += 1;
        (self.swimming, self.second, self.retry) = (false, false, start);
    }

    /// A module has stopped in the middle of its cycle: from where to go on is seen when all modules rest.
    fn let_go(&mut self) {
        self.swimming = false;
        if std::mem::take(&mut self.second)
            && let Some(decision) = self.decisions.last_mut()
        {
            give_up_second(decision);
        }
    }

    /// A module that lost the running cycle (it rebooted, or never had it) leaves the rhythm of the others.
    fn swimming_over_if_unknown(&mut self) {
        let Some(decision) = self.decisions.last().filter(|_| self.swimming) else { return };
        if !all_have(&self.dispatcher, decision, decision.last_number()) {
            self.swimming = false;
        }
    }
}

/// A plan that is not loss tolerant goes to all modules or to none.
fn delivery(decision: &Decision) -> Delivery {
    if decision.plan.loss_tolerant { Delivery::Direct } else { Delivery::Prepare }
}

/// The motions, with none for missing modules.
fn of_those_present(motions: Vec<Motion>, decision: &Decision) -> Vec<Option<Motion>> {
    motions.into_iter().zip(&decision.missing).map(|(motion, missing)| (!missing).then_some(motion)).collect()
}

/// Whether every module that is not missing certainly has cycle `number` of this decision.
fn all_have<A: Copy>(dispatcher: &Dispatcher<A>, decision: &Decision, number: u32) -> bool {
    dispatcher.modules().iter().zip(&decision.missing).all(|(link, &missing)| missing || link.has(number))
}

/// The planner for the modules that take part; made again when they change. Nothing where none takes part.
fn planner_for<'a>(
    whole: &'a mut Planner,
    partial: &'a mut Option<(Vec<Participation>, Planner)>,
    scenario: &Scenario,
    distance: &Arc<DistanceToCollision>,
    participation: &[Participation],
) -> Option<&'a mut Planner> {
    if participation.iter().all(|module| *module == Participation::Active) {
        return Some(whole);
    }
    if partial.as_ref().is_none_or(|(known, _)| known != participation) {
        let Scenario { structure, modboat, planner, .. } = scenario;
        let among =
            Planner::among(structure, modboat, planner, Arc::clone(distance), participation.to_vec())?;
        *partial = Some((participation.to_vec(), among));
    }
    partial.as_mut().map(|(_, planner)| planner)
}

fn span(seconds: f64) -> Duration {
    Duration((seconds * 1e6).round() as u32)
}

#[cfg(test)]
mod tests;
