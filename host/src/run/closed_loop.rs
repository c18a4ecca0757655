//! The closed loop of a fleet, the same for Modboats and ROVs: one step a tick.
//!
//! ```text
//! Fleet ──── actuation ────→ World ──── truth ────→ PoseSource
//!  │ ↑                         ↑                        │ poses
//!  │ └─────── datagrams ───────┼─────────────────────┐  ↓
//!  └───────── datagrams ───────┼───────────────────→ Host: Dispatcher, Controller
//!                              └────── couplings ─────────────────────────┘
//! ```
//!
//! | | Modboats | ROVs |
//! |---|---|---|
//! | [`Controller`] | [`Pilot`](super::pilot::Pilot) | [`Execution`](super::reconfigure::controller::Execution) |
//! | [`Fleet`] | [`InProcess`](super::fleet::InProcess), [`OverUdp`](super::fleet::OverUdp) | the same |
//! | [`World`] | [`Tank`](sim::tank::Tank) | [`Water`](super::reconfigure::water::Water) |
//! | [`PoseSource`] | [`Cameras`](super::boats::Cameras), [`LabPoses`](super::lab::LabPoses) | [`ExactPoses`](super::reconfigure::water::ExactPoses), [`LabBodies`](super::reconfigure::poses::LabBodies) |
//! | [`Observer`] | [`BoatLog`](super::log::boats::BoatLog) | [`RovLog`](super::log::rovs::RovLog) |

use link::strangers::Silence;
use protocol::time::{Duration, FleetInstant};
use protocol::{MAX_DATAGRAM, ModuleState, Radio};

use super::RunError;
use super::clock::{Clock, Pace, Tick, WallClock};
use super::fleet::{Address, Fleet};
use super::host::{Controller, Host, Step};
use super::orders::{ModuleStatus, Operator, Order, Ordered, RunStatus};
use super::pose_source::PoseSource;
use super::progress::Progress;
use super::reporter::{Reporter, stopped};

pub use super::clock::Gap;

/// The water, where it is simulated.
pub trait World {
    /// What it feels of one module.
    type Actuation;
    /// What connectors can do in it.
    type Coupling;

    /// The tick that ends at `now`. `begun`: the run's time zero has passed; before that robots may be held in place.
    fn step(&mut self, now: FleetInstant, begun: bool, actuation: &[Self::Actuation]);

    /// Nothing is known of the time until `now`: it goes on from where it was.
    fn skip(&mut self, _now: FleetInstant) {}

    /// Lets connectors act; what they did, if they could.
    ///
    /// # Errors
    /// [`RunError`] for bodies that cannot be so.
    fn couple(&mut self, coupling: Self::Coupling) -> Result<Option<Self::Coupling>, RunError>;
}

/// What looks at a run after each of its steps: a recorder, a log, a console.
pub trait Observer<R> {
    /// After the step at `now`.
    ///
    /// # Errors
    /// [`RunError`], which ends the run.
    fn observe(&mut self, now: FleetInstant, run: &R) -> Result<(), RunError>;
}

/// A fault that is planned into a run, for tests: called before each step with its time, the controller and the fleet.
pub type FaultHook<'a, C, F> = &'a mut dyn FnMut(FleetInstant, &C, &mut F);

/// How a run is driven.
pub struct Drive<'a, C, F> {
    /// Whose time it follows.
    pub pace: Pace,
    /// Who may stop, hold, release and end it.
    pub operator: &'a mut dyn Operator,
    /// Faults.
    pub hook: FaultHook<'a, C, F>,
}

/// Modules that have not been heard for this time after a gap do not keep the others from being looked at. *Assumed.*
const BLIND_MAX: Duration = Duration(1_000_000);

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ending {
    /// Why, if before its time.
    pub why: Option<String>,
    /// At which tick.
    pub at: FleetInstant,
    /// How long it took by the wall clock, s.
    pub wall_s: f64,
}

/// See the module's documentation.
pub struct Run<'a, C, F: Fleet, W, P> {
    /// The host: controller and dispatcher.
    pub host: Host<C, Address<F>>,
    /// The modules.
    pub fleet: &'a mut F,
    /// The water; `None` where it is real.
    pub world: Option<W>,
    /// Where poses come from.
    pub poses: P,
    /// What the water felt of each module in the last step.
    pub actuation: Vec<F::Actuation>,
    /// Spans in which the host did not run, or did not know yet what the modules had done meanwhile. No figure uses them.
    pub gaps: Vec<Gap>,
    /// What was ordered in this tick, and what came of it.
    pub ordered: Vec<Ordered>,
    /// The last gap is not over for figures: since when the host runs again.
    blind: Option<FleetInstant>,
    /// Since when the fleet has not been under way, though it might be.
    idle_since: FleetInstant,
    /// The stop or hold in force.
    halted: Option<Order>,
    /// Until when an ended run waits for its fleet to come to rest.
    ends_by: Option<FleetInstant>,
}

/// How long an ended run waits at most for its modules to finish their cycle, or to have stopped. *Assumed*: a cycle with its
/// transition takes two seconds.
const REST_WITHIN: Duration = Duration(3_000_000);

impl<C, F: Fleet, W, P> Run<'_, C, F, W, P> {
    /// Whether it is not known what the modules do: the last gap is not over for figures.
    pub fn is_blind(&self) -> bool {
        self.blind.is_some()
    }

    /// `stop` or `hold`, while one is in force.
    pub fn order(&self) -> Option<&'static str> {
        match self.halted {
            Some(Order::Stop) => Some("stop"),
            Some(Order::Hold) => Some("hold"),
            _ => None,
        }
    }
}

impl<'a, C, F, W, P> Run<'a, C, F, W, P>
where
    C: Controller,
    F: Fleet,
    W: World<Actuation = F::Actuation, Coupling = C::Coupling>,
    P: PoseSource<W, Pose = C::Pose>,
{
    /// Before its first step.
    pub fn new(controller: C, fleet: &'a mut F, world: Option<W>, poses: P) -> Self {
        let host = Host::new(controller, fleet.host(), fleet.roster());
        Self {
            host,
            fleet,
            world,
            poses,
            actuation: Vec::new(),
            gaps: Vec::new(),
            ordered: Vec::new(),
            blind: None,
            idle_since: FleetInstant(0),
            halted: None,
            ends_by: None,
        }
    }

    /// The host did not run in `gap`: the modules have finished what they had, and hold. The controller begins again from what they
    /// report next.
    pub fn skip(&mut self, gap: Gap) {
        self.gaps.push(gap);
        self.blind = Some(gap.end);
        self.fleet.forget(gap.end);
        self.host.controller.handle_gap(&gap);
        // It is not the modules that kept the host waiting.
        self.idle_since = FleetInstant(self.idle_since.0 + (gap.end.0 - gap.start.0));
    }

    /// Whether what is seen of the modules at `now` is from after the last gap.
    fn sees(&mut self, now: FleetInstant) -> bool {
        let (Some(since), Some(gap)) = (self.blind, self.gaps.last_mut()) else { return true };
        gap.end = now;
        if now.since(since) < BLIND_MAX && !self.fleet.is_heard_since(since, self.host.dispatcher()) {
            return false;
        }
        self.blind = None;
        if let Some(world) = &mut self.world {
            world.skip(now);
        }
        true
    }

    /// The tick at `now`; `clock` is read again for each datagram. What the controller decided in it.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn step(
        &mut self,
        now: FleetInstant,
        clock: impl Fn() -> FleetInstant,
    ) -> Result<Step<C::Coupling>, RunError> {
        self.host.forget_events();
        self.fleet.advance(now)?;
        let mut buffer = [0; MAX_DATAGRAM];
        let mut received = clock();
        while let Some((length, from)) =
            self.fleet.radio().receive(received, &mut buffer).map_err(Into::into)?
        {
            // What does not decode is counted; there is nothing else to do about it.
            let _ = self.host.handle_datagram(received, from, &buffer[..length]);
            received = clock();
        }
        if self.sees(now) {
            self.fleet.actuate(now, self.host.dispatcher(), &mut self.actuation);
            if let Some(world) = &mut self.world {
                let begun = self.host.controller.origin().is_some_and(|origin| origin < now);
                world.step(now, begun, &self.actuation);
            }
            // A tick that comes late would tell too early a time of arrival.
            self.look(clock())?;
        }
        let step = self.act(now)?;
        self.transmit(clock)?;
        let rests = self.halted.is_some() || self.host.controller.lacks_target().is_some();
        if self.host.controller.is_under_way() || rests {
            self.idle_since = now;
        }
        Ok(step)
    }

    /// How long the fleet has not been under way at `now`, s.
    pub fn idle_s(&self, now: FleetInstant) -> f64 {
        now.as_secs_f64() - self.idle_since.as_secs_f64()
    }

    fn look(&mut self, now: FleetInstant) -> Result<(), RunError> {
        if let Some(pose) = self.poses.poll(now, self.world.as_ref())? {
            self.host.handle_pose(pose);
        }
        Ok(())
    }

    /// Does what the controller decides, connectors first.
    fn act(&mut self, now: FleetInstant) -> Result<Step<C::Coupling>, RunError> {
        loop {
            let coupling = match self.host.handle_timer(now)? {
                Step::Couple(coupling) => coupling,
                step => return Ok(step),
            };
            // Real connectors do what they are told.
            let coupled = match &mut self.world {
                Some(world) => world.couple(coupling)?,
                None => Some(coupling),
            };
            if let Some(coupled) = coupled {
                self.look(now)?;
                self.host.controller.handle_coupled(coupled)?;
            }
        }
    }

    /// Sends what the host has to say.
    fn transmit(&mut self, clock: impl Fn() -> FleetInstant) -> Result<(), RunError> {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((to, datagram)) = self.host.poll_transmit(clock(), &mut buffer) {
            self.fleet.radio().send(clock(), to, datagram).map_err(Into::into)?;
        }
        Ok(())
    }

    /// Step after step, as `clock` has them, until the run is over. `observers` look at each, in this order.
    ///
    /// # Errors
    /// [`RunError`], for what cannot begin or go on. What cuts a run short is told in [`Ending::why`].
    pub(super) fn drive<T: WallClock>(
        &mut self,
        mut clock: Clock<T>,
        drive: Drive<'_, C, F>,
        progress: &mut dyn Progress,
        observers: &mut [&mut dyn Observer<Self>],
    ) -> Result<Ending, RunError> {
        let Drive { operator, hook, .. } = drive;
        let (mut reporter, mut seen_trouble) = (Reporter::default(), None::<String>);
        let (at, why) = loop {
            let Tick { now, gap } = clock.next_tick();
            if let Some(gap) = gap {
                progress.note(&format!(
                    "the host did not run for {:.1} s: the fleet holds, and begins again",
                    gap.length_s()
                ));
                self.skip(gap);
            }
            hook(now, &self.host.controller, self.fleet);
            self.ordered.clear();
            while let Some(order) = operator.poll(&|| self.status(now)) {
                let (what, steers) = (order.words(), matches!(order, Order::Steer(_)));
                let outcome = self.obey(now, order);
                operator.answer(&outcome);
                // Targets come ten times a second.
                if !steers {
                    progress.note(match &outcome {
                        Ok(text) | Err(text) => text,
                    });
                }
                self.ordered.push(Ordered { at: now, by: operator.by(), what, steers, outcome });
            }
            let step = match self.step(now, || clock.now()) {
                // What was measured until then is kept.
                Err(RunError::Radio(error)) if self.host.controller.origin().is_some() => {
                    self.host.controller.finish();
                    break (now, Some(error.to_string()));
                }
                step => step?,
            };
            if self.poses.trouble() != seen_trouble.as_deref() {
                seen_trouble = self.poses.trouble().map(str::to_owned);
                match &seen_trouble {
                    Some(trouble) => progress.note(&format!("no pose: {trouble}")),
                    None => progress.note("poses come again"),
                }
            }
            while let Some(news) = self.host.controller.take_news() {
                progress.note(&news);
            }
            for observer in observers.iter_mut() {
                observer.observe(now, self)?;
            }
            if let Step::End(why) = step {
                break (now, why);
            }
            if self.ends_by.is_some_and(|by| now >= by || self.is_at_rest()) {
                let stopped = self.halted == Some(Order::Stop);
                let why = if stopped { "ended by an emergency stop" } else { "interrupted" };
                break (now, Some(why.to_owned()));
            }
            let idle_s = self.idle_s(now);
            reporter.report(now, idle_s, &self.host, progress);
            // Poses are waited for until the run's time is over, but not before it has begun.
            let waits = self.host.controller.lacks_pose() && self.host.controller.origin().is_some();
            if idle_s > self.host.controller.patience().join_s && !waits {
                break (now, Some(self.silence(now)?));
            }
        };
        Ok(Ending { why, at, wall_s: clock.elapsed_s() })
    }

    /// Does what an operator orders at `now`.
    fn obey(&mut self, now: FleetInstant, order: Order) -> Result<String, String> {
        if order == Order::Hold && self.halted == Some(Order::Stop) {
            return Err("the fleet is stopped: a hold changes nothing".to_owned());
        }
        let text = match &order {
            Order::Stop | Order::Hold => {
                self.host.controller.halt(order.clone());
                self.halted = Some(order.clone());
                let dispatcher = self.host.dispatcher_mut();
                if order == Order::Stop {
                    dispatcher.emergency_stop(now);
                    "emergency stop: every drive is off until a release"
                } else {
                    dispatcher.hold();
                    "hold: the fleet finishes its cycle and holds until a release"
                }
            }
            Order::Release(None) => {
                self.host.controller.resume();
                self.halted = None;
                self.host.dispatcher_mut().release(now);
                "released: the run goes on"
            }
            Order::Release(Some(id)) => {
                if !self.host.dispatcher_mut().release_one(now, *id) {
                    return Err(format!("there is no module {id} to release"));
                }
                "one module is released"
            }
            Order::End => {
                self.host.finish();
                "interrupted: the fleet finishes its cycle and holds"
            }
            Order::Steer(steering) => {
                let said = self.host.controller.steer(now, steering)?;
                if self.host.controller.lacks_target().is_some() {
                    self.host.dispatcher_mut().hold();
                }
                return Ok(said);
            }
        };
        // A stop while the run ends has its own time.
        if order == Order::End || order == Order::Stop && self.ends_by.is_some() {
            self.ends_by = Some(now.after(REST_WITHIN));
        }
        Ok(text.to_owned())
    }

    /// Whether every module that has joined has finished its cycle, or has stopped where a stop is in force.
    fn is_at_rest(&self) -> bool {
        let rests = |state| match self.halted {
            Some(Order::Stop) => state == ModuleState::Stopped,
            _ => state != ModuleState::Executing,
        };
        self.host.dispatcher().modules().iter().filter_map(|link| link.state()).all(rests)
    }

    /// The run at `now`, for an operator.
    fn status(&self, now: FleetInstant) -> RunStatus {
        let (controller, links) = (&self.host.controller, self.host.dispatcher());
        let modules = links.modules().iter().enumerate();
        RunStatus {
            t_s: controller.origin().map_or(-1.0, |origin| now.as_secs_f64() - origin.as_secs_f64()),
            duration_s: controller.duration_s(),
            fleet: controller.status(links),
            order: self.order().map(str::to_owned),
            modules: modules
                .map(|(index, link)| ModuleStatus::of(now, controller.id(index, links), link))
                .collect(),
        }
    }

    /// Why the run ends for modules that do not answer. What was measured before a module fell silent is kept.
    fn silence(&self, now: FleetInstant) -> Result<String, RunError> {
        let (controller, links) = (&self.host.controller, self.host.dispatcher());
        if controller.lacks_pose() {
            let waited = || format!("none came within {} s", controller.patience().join_s);
            return Err(RunError::Pose(self.poses.trouble().map_or_else(waited, str::to_owned)));
        }
        let (mut modules, mut known) = (Vec::new(), Vec::new());
        for index in controller.missing(links) {
            let id = controller.id(index, links);
            let link = &links.modules()[index];
            match links.silence(now, link.id()) {
                Some(Silence::Doubled) => {
                    let places = link.doubled().into_iter().flatten().map(|address| format!("{address:?}"));
                    let places = places.collect::<Vec<_>>().join(" and ");
                    known.push((
                        id,
                        Silence::Doubled,
                        format!("is there twice, at {places}: neither is used"),
                    ));
                }
                Some(Silence::Stopped) => {
                    let faults = link.faults().names().collect::<Vec<_>>().join(", ");
                    let hint = format!("is stopped ({faults}); flotilla release --module {id} ends that");
                    known.push((id, Silence::Stopped, hint));
                }
                None | Some(Silence::NeverHeard | Silence::Unanswered | Silence::Known) => modules.push(id),
                Some(reason) => known.push((id, reason, reason.to_string())),
            }
        }
        let (waited_s, hint) = (controller.patience().join_s, String::new());
        let silent = RunError::Silent { kind: C::MODULE, modules, known, waited_s, hint };
        if controller.origin().is_none() {
            return Err(silent);
        }
        Ok(stopped(&self.host).unwrap_or_else(|| silent.to_string()))
    }
}
