//! The controller of Modboats: observes the structure, decides once a cycle.
//!
//! Sans-IO: fixes, the state of the links and the time go in, cycles come out.
//!
//! ```text
//! fixes → Observer, Controller → wrench → Planner → cycles
//!                                    ↑ where every tail will be ← acknowledgements, telemetry
//! ```
//!
//! A decision falls `lead_s` before the running cycle ends. A plan that not every module may miss goes to all or none, and that takes as long
//! as fleet, losses and round trips want ([`link::lead`]): it starts no sooner, and while such plans follow each other decisions fall by so much
//! earlier, at most one period. A decision needs to know where every tail will be then: at the
//! end pose of the running cycle if the module reports that it runs it, where it reports to rest if not. A module that has lost its
//! power since its last report stands somewhere in the running decision: in its swing, or in its turn, if no report is from after that
//! (`Remaining`). For a report that is missing it waits until [`DECIDE_BY`]. While one pose is unknown nothing is sent, the modules finish their cycle and hold, and the
//! loop starts again as soon as all are ready. Where fewer are required, one that is silent for long is missing: its tail may be
//! anywhere, no other module comes within its reach, and the others swim. When it is back, and rests where it says, the next decision
//! counts on it again.
//!
//! Decisions follow each other as the plans say: one interval is the plan's own transition, none where no tail moves,
//! and one period. The controller has to know the interval before there is a plan: it takes that of the decision
//! before, and half a turn's for the first.
//!
//! A transition in two steps goes out as two cycles ([`Via`]): the first turns to the poses between and
//! rests there, the second, sent when every module certainly has the first, does the rest. If one has not, the second
//! is never sent: the fleet holds, at the poses between or where it was.
//!
//! How far a decision has come is the pilot's [`Phase`]; [`phase`] has the table of what leads from one to another.

use firmware::link::session::SURE_WITHIN;
use protocol::configuration::TailLimits;
use protocol::time::{Duration, FleetInstant};
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::Arc;

use link::delivery::Knowledge;
use link::dispatcher::{Dispatcher, ModuleLink};
use modboat::bounds::{Governor, Place};
use modboat::control::{Controller as Control, Goal, Moment, Observation, Tails, Target};
use modboat::distance::DistanceToCollision;
use modboat::distance_table::DistanceTable;
use modboat::motion::{Turn, Wrench};
use modboat::observer::{Fix, Observer};
use modboat::plan::{Outcome, Plan};
use modboat::planner::Planner;
use modboat::planner_config::LawOfTime;
use modboat::setting::Participation;
use quantity::ParameterError;

use super::host::Dispatch;
use super::scenario::{Demand, Scenario, Timing};

pub use decision::{Decision, SentCycle, Via};
use decision::{
    Remaining, all_have, cycles, dispatch, first_cycles, give_up, give_up_second, pose_of, steps,
};
use phase::{Phase, PhaseEvent};
use planners::{planner_for, planner_of};
use settling::Settling;
pub use targets::{Asked, Targets, speed_max_m_s};
pub use weak::Weak;
use weak::WeakModules;

mod controller;
mod decision;
pub mod phase;
mod planners;
mod seen;
mod settling;
mod targets;
mod weak;

/// Time before the end of the running cycle from which a decision no longer waits for reports: what it sends must get through. *Assumed.*
pub const DECIDE_BY: Duration = Duration(200_000);

/// A fleet at rest begins when every module is that sure of the fleet time: with something in hand for the time until the start.
const SURE_TO_BEGIN: Duration = Duration(SURE_WITHIN.0 / 4 * 3);

/// See the module's documentation.
pub struct Pilot {
    scenario: Scenario,
    observer: Observer,
    control: Control,
    governor: Option<Governor>,
    targets: Targets,
    /// An operator has ordered a stop or a hold.
    halted: bool,
    /// The newest pose.
    fix: Option<Fix>,
    /// Whether the last decision was not made for want of a pose.
    lacks_pose: bool,
    planner: Planner,
    distance: Arc<DistanceToCollision>,
    table: Option<Arc<DistanceTable>>,
    /// What a person is to know, and was not told yet.
    news: VecDeque<String>,
    /// The planner without the missing modules.
    partial: Option<(Vec<Participation>, Planner)>,
    stopwatch: fn() -> FleetInstant,
    lead: Duration,
    /// The same of a plan that goes to all modules or none, as of the last decision.
    lead_for_all: Duration,
    /// All decisions so far; the last one may still run.
    decisions: Vec<Decision>,
    phase: Phase,
    settling: Settling,
    weak: Option<WeakModules>,
    /// The wrench of a decision, by number, where modules are known by now to give another than was planned.
    corrected: Option<(u32, Wrench)>,
    /// When a pause is over.
    resumes: FleetInstant,
    origin: Option<FleetInstant>,
    refusals: u32,
    dropped: u32,
    /// For the decision that is being made: where each tail will rest, if that is known.
    known: Vec<Option<f64>>,
    /// The same with any angle where it is not: nothing is sent to that module.
    poses: Vec<f64>,
    participation: Vec<Participation>,
    /// The same: in which turns they can still have stopped.
    remaining: Remaining,
    /// The planner writes into it what it can use again.
    plan: Plan,
}

impl Pilot {
    /// For one scenario. The planner searches by `table`, if there is one, whatever the scenario says. `stopwatch` is any clock that
    /// says how long the planner took.
    ///
    /// # Errors
    /// [`ParameterError`] for numbers the observer or planner cannot work with.
    pub fn new(
        scenario: &Scenario,
        table: Option<Arc<DistanceTable>>,
        stopwatch: fn() -> FleetInstant,
    ) -> Result<Self, ParameterError> {
        let Scenario { structure, modboat, .. } = scenario;
        let distance = Arc::new(DistanceToCollision::new(modboat));
        let planner = planner_of(structure, modboat, &scenario.planner, &distance, table.clone());
        Ok(Self {
            scenario: scenario.clone(),
            observer: Observer::new(structure, modboat, &scenario.observer)?,
            control: Control::new(structure, modboat, &scenario.control, &scenario.observer),
            governor: scenario
                .bounds
                .as_ref()
                .map(|bounds| Governor::new(bounds, structure, modboat, &scenario.control)),
            targets: Targets::new(scenario),
            halted: false,
            fix: None,
            lacks_pose: false,
            planner,
            distance,
            table,
            news: VecDeque::new(),
            partial: None,
            stopwatch,
            lead: span(scenario.timing.lead_s),
            lead_for_all: span(scenario.timing.lead_s),
            decisions: Vec::new(),
            phase: Phase::Waiting,
            settling: Settling::default(),
            weak: WeakModules::new(scenario),
            corrected: None,
            resumes: FleetInstant(0),
            origin: None,
            refusals: 0,
            dropped: 0,
            known: Vec::new(),
            poses: Vec::new(),
            participation: Vec::new(),
            remaining: Remaining::default(),
            plan: Plan::default(),
        })
    }

    /// Whether the newest pose is too old at `now` for a decision: at the start of its cycle it would be older than `hold_after_s`, where
    /// the lead leaves room for that.
    fn lacks_pose_at(&self, now: FleetInstant) -> bool {
        let hold_after_s = self.scenario.pose.hold_after_s;
        let most_s = hold_after_s - self.scenario.timing.lead_s.min(0.5 * hold_after_s);
        self.fix.is_some_and(|fix| now.as_secs_f64() - fix.t_s > most_s)
    }

    /// The second step of a transition is not sent any more.
    fn give_up_if_turning(&mut self) {
        if self.phase == Phase::Turning
            && let Some(decision) = self.decisions.last_mut()
        {
            give_up_second(decision);
        }
    }

    fn handle_phase(&mut self, event: PhaseEvent) {
        self.phase = self.phase.after(event);
    }

    /// Mean wrench that the fleet is meant to give at `now`, over the whole cycle with its transition: the observer
    /// averages over that anyway, and a step between the two would only pass for a motion.
    fn wrench_at(&self, now: FleetInstant) -> Wrench {
        // While the last decision waits for its start, the one before it runs.
        let running = self.decisions.iter().rev().take(2).find(|decision| decision.start <= now);
        running.filter(|decision| now < decision.end()).map_or(Wrench::default(), |decision| {
            let period_s = f64::from(decision.period.as_secs_f32());
            let share = period_s / (period_s + f64::from(decision.transition.as_secs_f32()));
            let corrected = self.corrected.filter(|(number, _)| *number == decision.number);
            corrected.map_or(decision.plan.wrench, |(_, wrench)| wrench) * share
        })
    }

    /// What the tails do at `now`, as planned; none before the first decision begins.
    fn tails_at(&self, now: FleetInstant) -> Option<Tails> {
        let decision = self.decisions.iter().rev().take(2).find(|decision| decision.start <= now)?;
        let sum = |of: fn(&Turn) -> f64| decision.turns.iter().map(of).sum::<f64>();
        let rest_rad = sum(|turn| turn.to_rad);
        let swings = now < decision.end();
        let net_rad: f64 = decision.plan.cycle.iter().map(|swing| swing.amplitude_rad).sum();
        let net_rad = if swings { net_rad } else { 0.0 };
        Some(Tails {
            about_rad: rest_rad - net_rad,
            net_rad,
            from_rad: sum(|turn| turn.from_rad),
            turn_s: decision.start.as_secs_f64(),
            swim_s: decision.swim_start().as_secs_f64(),
        })
    }

    /// Whether a report that would tell which modules run the cycle that ends at `end` may still come in time.
    fn waits_for_reports<A: Copy>(
        &self,
        now: FleetInstant,
        end: FleetInstant,
        links: &Dispatcher<A>,
    ) -> bool {
        let Some(decision) = self.decisions.last() else { return false };
        let number = decision.last_number();
        let unknown = |(link, &missing): (&ModuleLink<A>, &bool)| {
            !missing && link.knowledge(number) == Knowledge::Possibly
        };
        now.after(DECIDE_BY) < end && links.modules().iter().zip(&decision.missing).any(unknown)
    }

    /// What is due at `now` but for the wrench of the observer.
    fn next<A: Copy>(&mut self, now: FleetInstant, links: &Dispatcher<A>) -> Option<Dispatch> {
        if self.phase == Phase::Turning
            && let Some(second) = self.send_second(now, links)
        {
            return Some(second);
        }
        self.forget_if_dropped(now, links);
        if self.phase == Phase::Pausing && now >= self.resumes {
            self.handle_phase(PhaseEvent::PauseOver);
        }
        match (self.phase, self.decisions.last().map(Decision::end)) {
            (Phase::Swimming, Some(end))
                if now.after(self.lead_now()) >= end && !self.waits_for_reports(now, end, links) =>
            {
                self.decide(now, end, links)
            }
            (Phase::Waiting, _) if self.targets.lacks_target().is_none() => {
                self.decide(now, now.after(self.lead), links)
            }
            _ => None,
        }
    }

    /// How long before the end of the running cycle the next is decided on: after a plan for all or none another may follow.
    fn lead_now(&self) -> Duration {
        let for_all = self.decisions.last().is_some_and(|last| !last.plan.loss_tolerant);
        if for_all { self.lead_for_all } else { self.lead }
    }

    /// Plans the cycle that starts at `start`, to be sent; holds the fleet if that cannot be done.
    fn decide<A: Copy>(
        &mut self,
        now: FleetInstant,
        start: FleetInstant,
        links: &Dispatcher<A>,
    ) -> Option<Dispatch> {
        // A module that lost the running cycle (it rebooted, or never had it) leaves the rhythm of the others.
        if self.decisions.last().is_some_and(|last| !all_have(links, last, last.last_number())) {
            self.handle_phase(PhaseEvent::Lost);
        }
        self.plan_with_weak_modules(now, links);
        let (phase, last) = (self.phase, self.decisions.last());
        let poses = links.modules().iter().enumerate();
        self.known.clear();
        self.known.extend(poses.map(|(index, link)| pose_of(phase, last, index, link)));
        self.lacks_pose = self.fix.is_none() || self.lacks_pose_at(now);
        if self.lacks_pose {
            self.handle_phase(PhaseEvent::Blind);
            return None;
        }
        let (true, Some(estimate)) = (self.is_enough(now, links), self.observer.estimate()) else {
            self.handle_phase(PhaseEvent::Lost);
            return None;
        };
        let parameters = &self.scenario.modboat;
        // Of the plan that is to be made only the last one's interval is known. Before the first swim, half a turn is taken for it.
        let transition_s = match last {
            Some(last) if self.origin.is_some() => f64::from(last.transition.as_secs_f32()),
            _ if self.scenario.planner.law() == LawOfTime::RestToRest => parameters.transition_times_s(PI).0,
            _ => parameters.transition_s,
        };
        let interval_s = transition_s + parameters.period_s;
        let moment = Moment { now_s: now.as_secs_f64(), start_s: start.as_secs_f64(), interval_s };
        // A cycle that straddles two legs belongs to the one that has more of it.
        let start_s = self.origin.map_or(0.0, |origin| start.as_secs_f64() - origin.as_secs_f64());
        let leg_time_s = start_s + 0.5 * interval_s;
        self.targets.arrive(estimate.position_m, &self.scenario.modboat);
        let Asked { target: asked, demand, heading_rad } = self.targets.asked(&self.scenario, leg_time_s)?;
        let observed = Observation {
            velocity_m_s: estimate.velocity_m_s,
            heading_rad: estimate.heading_rad,
            yaw_rate_rad_s: estimate.yaw_rate_rad_s,
            unknown_m_s2: estimate.unknown_m_s2,
            unknown_rad_s2: estimate.unknown_rad_s2,
        };
        let (velocity_m_s, station_m) = match demand {
            Demand::Velocity(velocity_m_s) => (velocity_m_s, None),
            Demand::Station(station_m) => {
                let horizon_s = moment.horizon_s();
                let control = &self.scenario.control;
                (control.towards(station_m, estimate.position_m, &observed, horizon_s), Some(station_m))
            }
        };
        let (mut target, mut bounded) = (Target { velocity_m_s, heading_rad }, false);
        if let Some(governor) = &mut self.governor {
            let ahead_s = start.as_secs_f64() - now.as_secs_f64();
            let position_m = [0, 1].map(|k| estimate.position_m[k] + estimate.velocity_m_s[k] * ahead_s);
            let place = Place { position_m, heading_rad: estimate.heading_rad };
            let governed = governor.govern(&target, place, estimate.velocity_m_s, 2.0 * interval_s);
            (target, bounded) = (governed.target, governed.is_limited);
        }
        let goal = Goal { target, station_m: station_m.filter(|_| !bounded), is_bounded: bounded };
        let began = (self.stopwatch)();
        let Self { scenario, distance, known, poses, participation, remaining, .. } = self;
        Planner::participation(&scenario.structure, distance, known, participation);
        poses.clear();
        poses.extend(known.iter().map(|pose| pose.unwrap_or(0.0)));
        let Some(planner) =
            planner_for(&mut self.planner, &mut self.partial, scenario, distance, participation)
        else {
            self.handle_phase(PhaseEvent::Lost);
            return None;
        };
        // At rest, tails leave their neighbours' reach before anything swims. What the swim will be asked for is not asked of the
        // controller yet.
        let likely = || self.control.clone().demand(&goal, &observed, &moment);
        let leaves = !phase.is_under_way() && planner.leave_into(likely(), poses, &mut self.plan);
        let demand = if leaves {
            Wrench::default()
        } else {
            let demand = self.control.demand(&goal, &observed, &moment);
            planner.settle(self.settling.is_settled(asked, demand, &scenario.planner.weights));
            let previous = last.map(|decision| remaining.of(decision, links, !phase.is_under_way()));
            planner.plan_into(demand, Some(poses), previous, &mut self.plan);
            self.control.planned(self.plan.wrench);
            demand
        };
        let solve_us = u64::from((self.stopwatch)().since(began).0);
        self.lead_for_all = links.lead().total().min(span(self.scenario.modboat.period_s)).max(self.lead);
        let for_all = !self.plan.loss_tolerant;
        let start = if for_all { start.max(now.after(self.lead_for_all)) } else { start };
        self.carry_out(start, demand, bounded, self.plan.clone(), solve_us, leaves)
    }

    /// Whether a module knows the fleet time well enough to be begun with. Once the fleet swims,
    /// a module itself refuses a cycle that its clock is not sure enough for.
    fn is_sure<A: Copy>(&self, link: &ModuleLink<A>) -> bool {
        self.phase.is_under_way() || link.health().is_some_and(|health| health.uncertainty <= SURE_TO_BEGIN)
    }

    /// Whether the tails of enough modules are known: of all, or of those that are required while the others are missing.
    fn is_enough<A: Copy>(&self, now: FleetInstant, links: &Dispatcher<A>) -> bool {
        let Timing { require, missing_after_s, .. } = self.scenario.timing;
        let count = self.known.iter().flatten().count();
        let modules = || links.modules().iter().zip(&self.known);
        let silent =
            |link: &ModuleLink<A>| f64::from(now.since(link.heard()).as_secs_f32()) >= missing_after_s;
        let all_silent = || modules().filter(|(_, pose)| pose.is_none()).all(|(link, _)| silent(link));
        let sure = modules().filter(|(_, pose)| pose.is_some()).all(|(link, _)| self.is_sure(link));
        sure && (count == self.known.len() || require > 0 && count >= require as usize && all_silent())
    }

    /// Takes down what was planned for `start`; what is to be sent for it, if it moves anything.
    fn carry_out(
        &mut self,
        start: FleetInstant,
        demand: Wrench,
        bounded: bool,
        plan: Plan,
        solve_us: u64,
        leaves: bool,
    ) -> Option<Dispatch> {
        // A cycle that only turns still has a period: the least that a module takes.
        let period =
            if leaves { TailLimits::default().period_min } else { span(self.scenario.modboat.period_s) };
        let stay = || self.poses.iter().map(|&pose| Turn { from_rad: pose, to_rad: pose }).collect();
        let turns = plan.transition.clone().unwrap_or_else(stay);
        let missing = self.known.iter().map(Option::is_none).collect();
        let (via, transition) = steps(&plan, &turns);
        let number = self.decisions.last().map_or(1, |decision| decision.last_number() + 1);
        let decision = Decision {
            number,
            start,
            transition,
            via,
            period,
            demand,
            bounded,
            missing,
            turns,
            plan,
            solve_us,
        };
        let sent = if decision.plan.outcome == Outcome::Held {
            self.resumes = decision.end();
            self.handle_phase(PhaseEvent::Held);
            None
        } else {
            // The first leg begins with the first swim.
            if !leaves {
                self.origin.get_or_insert(start);
            }
            let first = decision.via.is_some();
            self.handle_phase(if first { PhaseEvent::FirstSent } else { PhaseEvent::Sent });
            Some(dispatch(&decision, number, start, first_cycles(&decision)))
        };
        self.decisions.push(decision);
        sent
    }

    /// The second step of the last decision when it is due; gives it up if a module has not the first.
    fn send_second<A: Copy>(&mut self, now: FleetInstant, links: &Dispatcher<A>) -> Option<Dispatch> {
        let decision = self.decisions.last()?;
        let start = decision.last_start();
        // A module keeps one cycle beside the one it runs: the first must have begun.
        let for_all = !decision.plan.loss_tolerant;
        let lead = if for_all { self.lead_for_all } else { self.lead };
        if now < decision.start || now.after(lead) < start {
            return None;
        }
        let blind = self.lacks_pose_at(now);
        let decision = self.decisions.last_mut()?;
        if !blind && all_have(links, decision, decision.number) {
            let second = dispatch(decision, decision.last_number(), start, cycles(decision));
            self.handle_phase(PhaseEvent::SecondSent);
            return Some(second);
        }
        // A report of it may still come.
        if blind || now.after(self.lead) >= start {
            give_up_second(decision);
            self.lacks_pose = blind;
            self.handle_phase(if blind { PhaseEvent::Blind } else { PhaseEvent::FirstMissed });
        }
        None
    }

    /// A cycle that might not reach every module in time is run by no module: another is planned when its start has
    /// passed.
    fn forget_if_dropped<A: Copy>(&mut self, now: FleetInstant, links: &Dispatcher<A>) {
        let Some(decision) = self.decisions.last_mut().filter(|_| self.phase.is_under_way()) else { return };
        let turning = self.phase == Phase::Turning;
        let (number, start) = if turning {
            (decision.number, decision.start)
        } else {
            (decision.last_number(), decision.last_start())
        };
        if now >= start || !links.is_dropped(number) {
            return;
        }
        if decision.via.is_some() && !turning {
            give_up_second(decision);
        } else {
            give_up(decision, self.lead);
        }
        self.dropped += 1;
        self.resumes = start;
        self.handle_phase(PhaseEvent::Dropped);
    }
}

fn span(seconds: f64) -> Duration {
    Duration((seconds * 1e6).round() as u32)
}

#[cfg(test)]
mod tests;
