//! The controller of ROVs that carry out a plan: which of them answer, when the plan begins, and thrusts for each, twenty times a
//! second.
//!
//! ```text
//! 0 …              every robot announces itself, learns the fleet time, arms its controllers
//! then             the first thrusts, while robots and tools are held in their places: the propellers come up to speed
//! plan time 0 …    the water lets go; moves, one after the other, until the last robot holds in its slot
//! ```
//!
//! [`Conductor`] says what each robot is to do. Where states are not known exactly the [`Estimator`] tells them from fixes. Without a fix for
//! `hold_after_s` robots are told nothing more: they go to neutral when their leases end, and the plan waits until fixes come again.

use link::dispatcher::{Dispatcher, DispatcherEvent, ModuleLink};
use protocol::message::MAX_THRUSTERS;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Newtons;
use protocol::{Connectors, Delivery, ModuleKind, ModuleState, Motion, RovCycle};
use reconfiguration::plan::Plan;
use reconfiguration::problem::Problem;
use rov::dynamics::State;
use rov::power::PowerLaw;
use sim::rov::basin::Misfit;

use super::super::RunError;
use super::super::clock::Gap;
use super::super::hold::Hold;
use super::super::host::{Controller, Dispatch, Patience, Step};
use super::super::orders::Order;
use super::ExecutionError;
use super::conductor::{AHEAD_S, Conductor, Coupling, HAND_OVER_S, PERIOD, apart};
use super::estimator::{Estimator, Seen, Sighting, Verdict};
use super::water::{STEP, STEP_S, is_step};

/// Time that thrusts hold without another packet: five periods, so that four lost ones in a row do no harm.
const LEASE: Duration = Duration(250_000);
/// A robot that has been silent for this long does not answer. *Assumed*.
const SILENCE: Duration = Duration(300_000);
/// How long robots are waited for at the beginning. *Assumed*.
const PATIENCE: Patience = Patience { missing_after_s: 3.0, join_s: 30.0 };

/// The share of the docking tolerance that is kept to with estimated states. *Assumed*: what is left is four times their error.
const WITHIN: f64 = 0.75;
/// A run that sees nothing for this time ends, s. *Assumed*.
const BLIND_MOST_S: f64 = 60.0;

/// What a run does with fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixes {
    /// Without one for this time the run holds, s.
    pub hold_after_s: f64,
}

/// States of bodies from fixes.
struct Estimated {
    estimator: Estimator,
    hold_after_s: f64,
    /// Since when it has seen nothing for too long.
    blind: Option<FleetInstant>,
    /// Thrusters that were found to give nothing: robot, thruster, s of the plan's time.
    failed: Vec<(usize, usize, f64)>,
}

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
    estimated: Option<Estimated>,
    /// Which robots' connectors are to be open.
    open: Vec<bool>,
    /// Whether a robot has drifted towards the edge of the water.
    near_edge: bool,
    news: Vec<String>,
    drawn_in: Option<Misfit>,
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
            estimated: None,
            open: vec![false; problem.robots.len()],
            near_edge: false,
            news: Vec::new(),
            drawn_in: None,
        })
    }

    /// With states that fixes tell.
    ///
    /// # Errors
    /// [`ExecutionError::Basin`] for bodies that cannot be in water.
    pub fn by_fixes(mut self, fixes: Fixes) -> Result<Self, ExecutionError> {
        let estimator = Estimator::new(self.conductor.bodies(), f64::from(LEASE.0) * 1e-6)?;
        self.conductor.keep_within(WITHIN);
        let hold_after_s = fixes.hold_after_s;
        self.estimated = Some(Estimated { estimator, hold_after_s, blind: None, failed: Vec::new() });
        Ok(self)
    }

    /// States of all bodies, as they are held true.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// The fix that was taken last, where states are estimated.
    #[must_use]
    pub fn sighting(&self) -> Option<&Sighting> {
        self.estimated.as_ref().map(|estimated| estimated.estimator.sighting())
    }

    /// How far from its slot, and turned, the robot was held to be that took hold last.
    #[must_use]
    pub fn drawn_in(&self) -> Option<&Misfit> {
        self.drawn_in.as_ref()
    }

    /// Thrusters that were found to give nothing: robot and thruster, from 0, and when, s of the plan's time.
    #[must_use]
    pub fn failed_thrusters(&self) -> &[(usize, usize, f64)] {
        self.estimated.as_ref().map_or(&[], |estimated| &estimated.failed)
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

    /// Whether poses have been missing for too long.
    fn is_blind(&self) -> bool {
        self.estimated.as_ref().is_some_and(|own| own.blind.is_some())
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
        let placed = self.estimated.as_ref().is_none_or(|own| own.estimator.missing().is_none());
        if self.joined.is_none() && placed && self.answering.iter().all(|answers| *answers) {
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
        let motion = |(thrusts_n, &open): (&Vec<f64>, &bool)| {
            let thrusts = thrusts_n.iter().take(MAX_THRUSTERS);
            let thrusts = thrusts.map(|&thrust_n| Newtons(thrust_n as f32)).collect();
            let connectors = if open { Connectors::Open } else { Connectors::Closed };
            Some(Motion::Rov(RovCycle { thrusts, lease: LEASE, connectors }))
        };
        if let Some(Estimated { estimator, .. }) = &self.estimated {
            self.conductor.oppose(estimator.unknown());
        }
        let commands_n = self.conductor.commands_n(&self.states)?;
        let motions = commands_n.iter().zip(&self.open).map(motion).collect();
        let start = now.after(Duration((AHEAD_S * 1e6) as u32));
        if let Some(Estimated { estimator, .. }) = &mut self.estimated {
            estimator.command(start, &commands_n);
        }
        Ok(Dispatch { number: self.number, start, motions, delivery: Delivery::Direct })
    }

    /// States at `now` by what was seen until then. Why the run ends, if it is blind for good.
    fn estimate(&mut self, now: FleetInstant, begun: bool) -> Result<Option<String>, ExecutionError> {
        let t_s = self.origin.map_or(0.0, |origin| now.as_secs_f64() - origin.as_secs_f64());
        let Some(Estimated { estimator, hold_after_s, blind, failed }) = &mut self.estimated else {
            return Ok(None);
        };
        let found = estimator.advance(now, STEP_S, begun);
        self.states.clear();
        self.states.extend_from_slice(estimator.states());
        let named = |robot: usize, thruster: usize| {
            format!("thruster {} of robot {}", thruster + 1, self.problem.robots[robot].id)
        };
        match found {
            Some(Verdict::Suspected(robot, thruster)) => {
                self.conductor.set_working(robot, thruster, false)?;
            }
            Some(Verdict::Acquitted(robot, thruster)) => self.conductor.set_working(robot, thruster, true)?,
            Some(Verdict::Dead(robot, thruster)) => {
                failed.push((robot, thruster, t_s));
                let of = named(robot, thruster);
                self.news.push(format!("{of} gives nothing, at {t_s:.1} s: it is allocated around"));
            }
            None => {}
        }
        // A robot that does not get where it should and would if the thruster worked.
        if let Some((robot, thruster)) = estimator.suspect()
            && self.conductor.waits()
            && !failed.iter().any(|known| (known.0, known.1) == (robot, thruster))
        {
            failed.push((robot, thruster, t_s));
            let of = named(robot, thruster);
            self.news.push(format!("{of} seems to give nothing, at {t_s:.1} s: alone it cannot do without"));
        }
        let lost = estimator.lost(now, *hold_after_s);
        let sees = estimator.age_s(now) <= *hold_after_s && lost.is_none() && estimator.strayed().is_none();
        match *blind {
            None if begun && !sees => {
                *blind = Some(now);
                self.news.push(match (lost, estimator.strayed()) {
                    (None, Some(body)) => format!(
                        "{} is not in its place: it has broken away, or its body was moved on it: all thrusters go to neutral",
                        called(self.problem, body)
                    ),
                    (unseen, _) => {
                        let of = called(self.problem, unseen.unwrap_or_default());
                        format!("no fix of {of} for {hold_after_s} s: all thrusters go to neutral")
                    }
                });
                self.conductor.hold(true);
            }
            Some(_) if sees => {
                *blind = None;
                self.news.push("fixes come again: the plan goes on".to_owned());
                self.conductor.hold(self.halted.is_some());
            }
            Some(since) if now.since(since).as_secs_f32() > BLIND_MOST_S as f32 => {
                return Ok(Some(format!("no fix for {BLIND_MOST_S} s")));
            }
            _ => {}
        }
        Ok(None)
    }

    /// Says that a robot has drifted towards the edge of the water, and that none has any more.
    fn note_drift(&mut self) {
        let drifted = self.conductor.drifted();
        if drifted.is_some() == self.near_edge {
            return;
        }
        self.near_edge = drifted.is_some();
        self.news.push(match drifted {
            Some((body, room_m)) => {
                let of = called(self.problem, body);
                format!("{of} has drifted to {room_m:.2} m from the edge of the water: the plan waits until it is back")
            }
            None => "no robot is too near to the edge of the water any more: the plan goes on".to_owned(),
        });
    }
}

/// How a person calls a body, robots first.
fn called(problem: &Problem, body: usize) -> String {
    problem.robots.get(body).map_or_else(|| "a tool".to_owned(), |robot| format!("robot {}", robot.id))
}

impl Controller for Execution<'_> {
    const MODULE: &'static str = "robot";
    const KIND: ModuleKind = ModuleKind::Rov;
    type Pose = Seen;
    type Coupling = Coupling;

    fn handle_event<A: Copy>(&mut self, _event: DispatcherEvent, _links: &Dispatcher<A>) {}

    fn handle_pose(&mut self, seen: &Seen) {
        match (seen, &mut self.estimated) {
            (Seen::Exact(states), _) => self.states.clone_from(states),
            (Seen::Fix(sighting), Some(Estimated { estimator, .. })) => {
                estimator.take(sighting, self.origin.is_some());
            }
            (Seen::Fix(_), None) => {}
        }
    }

    fn handle_coupled(&mut self, coupling: Coupling) -> Result<(), RunError> {
        match coupling {
            Coupling::Undock(robot) => {
                self.open[robot] = true;
                if let Some(Estimated { estimator, .. }) = &mut self.estimated {
                    estimator.undock(robot).map_err(ExecutionError::from)?;
                }
                Ok(())
            }
            Coupling::Dock(robot, slot) => {
                self.open[robot] = false;
                if let Some(state) = self.states.get(robot) {
                    let (position_m, angle_rad) = apart(state, &slot);
                    self.drawn_in = Some(Misfit { position_m, angle_rad });
                }
                if let Some(Estimated { estimator, .. }) = &mut self.estimated {
                    estimator.dock(robot, slot).map_err(ExecutionError::from)?;
                }
                Ok(self.conductor.docked(robot)?)
            }
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
            if let Some(why) = self.estimate(now, begun)? {
                return Ok(Step::End(Some(why)));
            }
            if begun {
                let advanced = self.conductor.advance(STEP_S, &self.states, &self.answering);
                self.note_drift();
                match advanced {
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
        let told = matches!(self.halted, None | Some(Order::Hold)) && !self.is_blind();
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
        self.conductor.hold(self.is_blind());
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

    fn hold(&self) -> Hold {
        let silent = |(_, robot): (usize, usize)| self.answering.get(robot) != Some(&true);
        let mut movers = self.conductor.under_way();
        match self.conductor.moving() {
            _ if self.halted.is_some() => Hold::Operator,
            _ if self.is_blind() => Hold::PosesLost,
            _ if self.conductor.drifted().is_some() => Hold::Bounds,
            Some(_) if !movers.any(silent) => Hold::Astray,
            _ => Hold::Module,
        }
    }

    /// Before the plan begins: bodies are not seen, or are not where the plan has them.
    fn lacks_pose(&self) -> bool {
        self.estimated.as_ref().is_some_and(|own| {
            own.blind.is_some() || (self.joined.is_none() && own.estimator.missing().is_some())
        })
    }

    fn take_news(&mut self) -> Option<String> {
        (!self.news.is_empty()).then(|| self.news.remove(0))
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
