//! The host's end of a fleet: a controller, and the dispatcher that sends what it decides. Sans-IO: datagrams, poses and the time go
//! in, datagrams come out.
//!
//! ```text
//! poses ─────→ Controller ──── cycles ───→ Dispatcher ──→ datagrams
//!                  ↑ ──── events, links ───── ↑ ──────── datagrams
//! ```

use link::dispatcher::{Dispatcher, DispatcherEvent};
use link::identity::HostIdentity;
use protocol::ledger::Class;
use protocol::time::FleetInstant;
use protocol::{Delivery, ModuleId, ModuleKind, Motion, Refusal};

use super::RunError;
use super::clock::Gap;
use super::hold::Hold;
use super::orders::Order;
use super::steering::Steering;

/// What steers a fleet: the pilot of Modboats, the execution of a plan of ROVs.
pub trait Controller {
    /// One of its modules, in a word.
    const MODULE: &'static str;
    /// The kind of module that it steers.
    const KIND: ModuleKind;
    /// What a pose source tells it.
    type Pose: ?Sized;
    /// What connectors are to do.
    type Coupling;

    /// Takes in what a datagram changed.
    fn handle_event<A: Copy>(&mut self, event: DispatcherEvent, links: &Dispatcher<A>);

    /// Takes in a pose; its time is fleet time.
    fn handle_pose(&mut self, pose: &Self::Pose);

    /// Connectors have done what was asked.
    ///
    /// # Errors
    /// [`RunError`] where it does not go on.
    fn handle_coupled(&mut self, coupling: Self::Coupling) -> Result<(), RunError>;

    /// Decides what is due at `now`. After [`Step::Couple`] it is asked again within the same tick, and says so once.
    ///
    /// # Errors
    /// [`RunError`] where it does not go on.
    fn step<A: Copy>(
        &mut self,
        now: FleetInstant,
        links: &Dispatcher<A>,
    ) -> Result<Step<Self::Coupling>, RunError>;

    /// The host did not run in `gap`: begins again from what the modules report next.
    fn handle_gap(&mut self, gap: &Gap);

    /// The run is over: it decides nothing more.
    fn finish(&mut self);

    /// An operator has ordered a stop or a hold: until [`resume`](Self::resume) nothing is decided that moves the fleet.
    fn halt(&mut self, order: Order);

    /// The stop or hold is over: it goes on from where the fleet is.
    fn resume(&mut self);

    /// An operator gives another target, or none, at `now`. What comes of it, in words.
    ///
    /// # Errors
    /// Why it is not followed.
    fn steer(&mut self, _now: FleetInstant, _steering: &Steering) -> Result<String, String> {
        Err("this fleet follows its plan".to_owned())
    }

    /// Why the fleet holds for want of a target, if it does: empty before the first.
    fn lacks_target(&self) -> Option<&'static str> {
        None
    }

    /// Time zero of the run, fleet time; `None` before it is known.
    fn origin(&self) -> Option<FleetInstant>;

    /// How long the run takes from there, s.
    fn duration_s(&self) -> f64;

    /// Whether the fleet does what it was told. While it does not, it is waited for.
    fn is_under_way(&self) -> bool;

    /// Whether it gets on with what is asked for: it does not hold, and waits for no module.
    fn gets_on(&self) -> bool {
        self.is_under_way()
    }

    /// Why it does not get on, where it does not.
    fn hold(&self) -> Hold {
        Hold::Module
    }

    /// Whether it holds because no pose is new enough.
    fn lacks_pose(&self) -> bool {
        false
    }

    /// What a person is to know, once.
    fn take_news(&mut self) -> Option<String> {
        None
    }

    /// What the fleet does, for a person.
    fn status<A: Copy>(&self, links: &Dispatcher<A>) -> String;

    /// Modules (by index) that it waits for.
    fn missing<A: Copy>(&self, links: &Dispatcher<A>) -> Vec<usize>;

    /// The number that a person knows a module (by index) by.
    fn id<A: Copy>(&self, index: usize, links: &Dispatcher<A>) -> u16;

    /// How long a fleet may keep it waiting.
    fn patience(&self) -> Patience;
}

/// How long a fleet that is not under way is waited for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patience {
    /// Until missing modules are named, s.
    pub missing_after_s: f64,
    /// Until the run ends, s.
    pub join_s: f64,
}

/// What a controller decided.
#[derive(Clone, Debug, PartialEq)]
pub enum Step<C> {
    /// Nothing is due.
    Wait,
    /// Connectors are to do this at once.
    Couple(C),
    /// Modules are sent this.
    Dispatch(Dispatch),
    /// The run is over; why, if it is before its time.
    End(Option<String>),
}

/// One cycle of every module.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispatch {
    /// Its number.
    pub number: u32,
    /// When it starts, fleet time.
    pub start: FleetInstant,
    /// What each module does, in the order of the roster; `None` for one that gets nothing.
    pub motions: Vec<Option<Motion>>,
    /// To each module, or to all or none.
    pub delivery: Delivery,
}

/// See the module's documentation. `A` is the radio's address.
pub struct Host<C, A> {
    /// What decides.
    pub controller: C,
    dispatcher: Dispatcher<A>,
    /// Why each module refused the last cycle that it answered, if it did.
    refusals: Vec<Option<Refusal>>,
    /// What datagrams changed since the last tick.
    events: Vec<(FleetInstant, DispatcherEvent)>,
}

impl<C: Controller, A: Copy> Host<C, A> {
    /// For the modules of `roster`, by this identity.
    pub fn new(controller: C, identity: &HostIdentity, roster: &[ModuleId]) -> Self {
        let dispatcher = Dispatcher::new(roster, &identity.key, identity.boot).of_kind(C::KIND);
        Self { controller, dispatcher, refusals: vec![None; roster.len()], events: Vec::new() }
    }

    /// Why each module refused the last cycle that it answered, if it did.
    pub fn refusals(&self) -> &[Option<Refusal>] {
        &self.refusals
    }

    /// What datagrams changed in this tick, and when they came; not that modules reported.
    pub fn events(&self) -> &[(FleetInstant, DispatcherEvent)] {
        &self.events
    }

    /// Another tick begins.
    pub fn forget_events(&mut self) {
        self.events.clear();
    }

    /// The link.
    pub fn dispatcher(&self) -> &Dispatcher<A> {
        &self.dispatcher
    }

    /// The link, for orders that no controller decides.
    pub fn dispatcher_mut(&mut self) -> &mut Dispatcher<A> {
        &mut self.dispatcher
    }

    /// Takes in one datagram.
    ///
    /// # Errors
    /// What it is, if it is not to be followed; it is counted and nothing happens.
    pub fn handle_datagram(&mut self, now: FleetInstant, from: A, datagram: &[u8]) -> Result<(), Class> {
        if let Some(event) = self.dispatcher.handle_datagram(now, from, datagram)? {
            let verdict = match event {
                DispatcherEvent::Refused { module, reason, .. } => Some((module, Some(reason))),
                DispatcherEvent::Accepted { module, .. } | DispatcherEvent::Rebooted(module) => {
                    Some((module, None))
                }
                _ => None,
            };
            if let Some((module, refusal)) = verdict {
                self.refusals[module] = refusal;
            }
            if !matches!(event, DispatcherEvent::Reported(_)) {
                self.events.push((now, event));
            }
            self.controller.handle_event(event, &self.dispatcher);
        }
        Ok(())
    }

    /// Takes in a pose; its time is fleet time.
    pub fn handle_pose(&mut self, pose: &C::Pose) {
        self.controller.handle_pose(pose);
    }

    /// Does what is due at `now`: what is to be sent waits for [`poll_transmit`](Self::poll_transmit). After [`Step::Couple`] to be
    /// called again.
    ///
    /// # Errors
    /// The controller's.
    pub fn handle_timer(&mut self, now: FleetInstant) -> Result<Step<C::Coupling>, RunError> {
        self.dispatcher.handle_timer(now);
        let step = self.controller.step(now, &self.dispatcher)?;
        match &step {
            Step::Dispatch(Dispatch { number, start, motions, delivery }) => {
                self.dispatcher.dispatch(now, *number, *start, motions, *delivery);
            }
            Step::End(_) => self.dispatcher.hold(),
            Step::Wait | Step::Couple(_) => {}
        }
        Ok(step)
    }

    /// Ends the run: the modules finish what runs and hold.
    pub fn finish(&mut self) {
        self.controller.finish();
        self.dispatcher.hold();
    }

    /// Writes the next datagram to send, if any, to the start of `buffer`, and says where to.
    pub fn poll_transmit<'a>(&mut self, now: FleetInstant, buffer: &'a mut [u8]) -> Option<(A, &'a [u8])> {
        self.dispatcher.poll_transmit(now, buffer)
    }
}
