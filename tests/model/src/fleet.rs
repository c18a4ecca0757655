//! The fleet: two modules, a host, what is under way between them, and everything that can happen next.

use link::delivery::Knowledge;
use protocol::Delivery;
use stateright::{Model, Property};

use crate::host::{Host, Outgoing};
use crate::module::{Module, Past};
use crate::properties::{Breaches, properties};
use crate::said::{Ack, Held, MODULES, Order, Pose, Report, Say, SessionId, Up};

/// A way to break the protocol, or to undo what the checker had found missing in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Broken {
    /// A prepared cycle runs without a commit.
    NoCommit,
    /// The host commits as soon as one module has prepared.
    HastyCommit,
    /// A module draws the same nonce at every boot, and for every session.
    SameNonce,
    /// A cycle is given up though it was committed to others, when one has lost it.
    DropAfterCommit,
    /// A number that was given up is used again.
    ReusedNumber,
    /// A cycle counts though a hold, a stop or a release was sent after it and came before it.
    NoFence,
    /// What was refused may be accepted when it comes again, and the other way round.
    ForgetfulRefusals,
    /// A module that took a cycle is believed to run it, whatever it reports.
    AcceptanceIsProof,
    /// A release counts whatever its sender knew of the stop, and whichever was sent first.
    BlindRelease,
    /// A stop lets the running cycle end.
    LateStop,
    /// A reboot of the host ends a stop.
    StopOfOneHost,
}

/// Most events of each kind that may happen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Budget {
    /// Cycles dispatched.
    pub cycles: u8,
    /// Boots of modules.
    pub module_boots: u8,
    /// Boots of the host.
    pub host_boots: u8,
    /// Times a module doubts its clock: when a cycle comes or when one starts.
    pub doubts: u8,
    /// Holds.
    pub holds: u8,
    /// Stops and releases by the host.
    pub orders: u8,
    /// Stops that the host does not know of: by a fault of the module, or by another host.
    pub stalls: u8,
}

/// Configuration of an exploration.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The last slot.
    pub slots: u8,
    /// How much may happen.
    pub budget: Budget,
    /// What cycles may be.
    pub deliveries: &'static [Delivery],
    /// Reports may come when they are old.
    pub late_reports: bool,
    /// Every order is sent once and the replay window is in force. Otherwise an order stands for any number of copies, each
    /// with its own number: whatever order they come in, and with any replay.
    pub once: bool,
    /// From every state the network is healed for so many slots; 0: it is not tried.
    pub recovery: u8,
    /// What is broken.
    pub broken: Option<Broken>,
}

/// State of the whole model: modules, host, and messages under way.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Fleet {
    /// Slot n begins at start n; slot 1 is the first.
    pub now: u8,
    /// The PC.
    pub host: Host,
    /// The modules; which is which does not matter.
    pub modules: [Module; MODULES],
    /// Calls that may still come and still be followed.
    pub calls: [Vec<SessionId>; MODULES],
    /// What may still happen.
    pub left: Budget,
    /// What must never happen, and has.
    pub breaches: Breaches,
}

/// One event that can happen next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The next slot begins; a module doubts its clock just before, and drops what waits.
    SlotBegins {
        /// Which.
        doubts: Option<usize>,
    },
    /// Too late for a first commit.
    LeadPasses,
    /// The host plans.
    Decide(Delivery),
    /// The host says hold.
    Hold,
    /// The host says stop, or release.
    Order {
        /// Which of the two.
        stop: bool,
    },
    /// An announcement comes to the host, which answers it.
    Announced(usize),
    /// A call comes to a module.
    Called(usize, SessionId),
    /// The first datagram of a new session comes to the host.
    Joins(usize),
    /// A module learns the fleet time.
    TimeKnown(usize),
    /// An order comes to a module; it doubts its clock then.
    Hears {
        /// Which module.
        module: usize,
        /// What comes.
        order: Order,
        /// Whether it doubts.
        doubt: bool,
    },
    /// An acknowledgement comes to the host.
    Answered(usize, Ack),
    /// A report comes to the host: an old one, by place, or the present one.
    Reported(usize, Option<usize>),
    /// A module boots.
    ModuleBoots(usize),
    /// A module's motor stalls.
    Stalls(usize),
    /// The host boots.
    HostBoots,
}

impl Config {
    /// Cycles of both deliveries, late reports, copies of everything; nothing is broken.
    #[must_use]
    pub const fn new(slots: u8, budget: Budget) -> Self {
        let deliveries = &[Delivery::Direct, Delivery::Prepare];
        Self { slots, budget, deliveries, late_reports: true, once: false, recovery: 0, broken: None }
    }

    /// Both modules in a session, at rest, and ready.
    #[must_use]
    pub fn first(&self) -> Fleet {
        let mut host = Host::new(1);
        let session = SessionId { boot: 0, count: 0, life: 1 };
        let module = || {
            let mut module = Module::booted(0, (0, 0), Pose(0), Past::default());
            module.called(self, 1, session);
            module.take_time(1);
            module
        };
        let modules = [module(), module()];
        for index in 0..MODULES {
            host.offer(index, session);
            host.join(self, 1, index, session, Up::default());
        }
        let recorded = || if self.broken == Some(Broken::SameNonce) { vec![session] } else { Vec::new() };
        let calls = [recorded(), recorded()];
        Fleet { now: 1, host, modules, calls, left: self.budget, breaches: Breaches::default() }
    }

    /// What `action` makes of `fleet`.
    #[must_use]
    pub fn after(&self, fleet: &Fleet, action: Action) -> Fleet {
        let mut next = fleet.clone();
        next.act(self, action);
        next.note(self, fleet);
        next.tidy(self);
        next.sort();
        next
    }
}

impl Fleet {
    /// Does one thing, without a look at the properties.
    pub(crate) fn step(&mut self, config: &Config, action: Action) {
        self.act(config, action);
        self.tidy(config);
    }

    /// Sends again what the host repeats.
    pub(crate) fn repeat(&mut self, config: &Config) {
        let outgoing = self.host.repeats();
        self.send(config, outgoing);
        for (index, module) in self.modules.iter().enumerate() {
            let offers = self.host.links[index].calling.iter();
            let wanted = offers.filter(|offer| (offer.boot, offer.count) == module.nonce);
            let missing = wanted.filter(|offer| !self.calls[index].contains(offer)).copied();
            let missing: Vec<SessionId> = missing.collect();
            self.calls[index].extend(missing);
        }
    }

    fn act(&mut self, config: &Config, action: Action) {
        let now = self.now;
        match action {
            Action::SlotBegins { doubts } => self.slot_begins(doubts),
            Action::LeadPasses => {
                let outgoing = self.host.settle(config, now, false);
                self.send(config, outgoing);
            }
            Action::Decide(delivery) => {
                let outgoing = self.host.decide(config, now, delivery);
                self.left.cycles -= u8::from(!outgoing.is_empty());
                self.send(config, outgoing);
            }
            Action::Hold => {
                self.left.holds -= 1;
                let outgoing = self.host.hold();
                self.send(config, outgoing);
            }
            Action::Order { stop } => {
                self.left.orders -= 1;
                let outgoing = self.host.order(stop);
                self.send(config, outgoing);
            }
            Action::Announced(index) => {
                let Module { nonce, session, .. } = self.modules[index];
                if let Some(offer) = self.host.offers(index, nonce, session) {
                    self.host.offer(index, offer);
                    self.calls[index].push(offer);
                }
            }
            Action::Called(index, session) => {
                self.modules[index].called(config, now, session);
                if config.broken != Some(Broken::SameNonce) {
                    self.calls[index].clear();
                }
            }
            Action::Joins(index) => {
                if let Some(session) = self.modules[index].session {
                    let up = std::mem::take(&mut self.modules[index].up);
                    let outgoing = self.host.join(config, now, index, session, up);
                    self.send(config, outgoing);
                }
            }
            Action::TimeKnown(index) => self.changes(config, index, |module| module.take_time(now)),
            Action::Hears { module, order, doubt } => {
                self.left.doubts -= u8::from(doubt);
                self.changes(config, module, |module| module.hear(config, now, order, doubt));
            }
            Action::Answered(index, ack) => {
                let outgoing = self.host.acknowledged(config, now, index, ack);
                self.send(config, outgoing);
            }
            Action::Reported(index, place) => {
                let reports = &mut self.host.links[index].up.reports;
                let report = match place {
                    Some(place) => reports.drain(..=place).next_back(),
                    None => {
                        reports.clear();
                        Some(self.modules[index].report(now))
                    }
                };
                report.into_iter().for_each(|report| self.host.reported(index, report));
            }
            Action::ModuleBoots(index) => {
                self.left.module_boots -= 1;
                self.changes(config, index, |module| module.reboot(config, now));
                if config.broken != Some(Broken::SameNonce) {
                    self.calls[index].clear();
                }
            }
            Action::Stalls(index) => {
                self.left.stalls -= 1;
                self.changes(config, index, |module| module.stall(config, now));
            }
            Action::HostBoots => {
                self.left.host_boots -= 1;
                self.host = Host::new(self.host.life + 1);
                self.modules.iter_mut().for_each(|module| module.up = Up::default());
            }
        }
    }

    /// Changes a module. What it would have reported until then may still come.
    fn changes(&mut self, config: &Config, index: usize, change: impl FnOnce(&mut Module)) {
        let module = &mut self.modules[index];
        let (session, before) = (module.session, module.report(self.now));
        change(module);
        let changed = module.session != session || module.report(self.now) != before;
        if changed && config.late_reports {
            self.posted(index, session, before);
        }
        // Acknowledgements of the session in force with the host are under way to it.
        let module = &mut self.modules[index];
        let link = &mut self.host.links[index];
        if module.session.is_some() && module.session == link.live {
            std::mem::take(&mut module.up.acks).into_iter().for_each(|ack| link.up.acknowledge(ack));
        }
    }

    fn posted(&mut self, index: usize, session: Option<SessionId>, report: Report) {
        let link = &mut self.host.links[index];
        if session.is_some() && link.live == session && link.report != Some(report) {
            link.up.reports.push(report);
        }
    }

    fn slot_begins(&mut self, doubts: Option<usize>) {
        self.left.doubts -= u8::from(doubts.is_some());
        for index in 0..MODULES {
            let (session, report) = (self.modules[index].session, self.modules[index].report(self.now));
            self.posted(index, session, report);
        }
        self.now += 1;
        self.host.slot_begins(self.now);
        for (index, module) in self.modules.iter_mut().enumerate() {
            module.slot_begins(self.now, doubts == Some(index));
        }
    }

    /// Whatever is said in a session that the module is not in, it cannot open.
    fn send(&mut self, config: &Config, outgoing: Outgoing) {
        for (index, say) in outgoing {
            let (link, module) = (&mut self.host.links[index], &mut self.modules[index]);
            let sequence = link.next_sequence();
            let boot = module.boots;
            let say = match say {
                Say::Cycle(held) => Say::Cycle(Held { boot, ..held }),
                Say::Release { seen, .. } => Say::Release { seen, sent_at: module.past.stops },
                other => other,
            };
            if link.live == module.session || config.broken == Some(Broken::SameNonce) {
                module.down.push(Order { sequence, say });
            }
        }
    }

    /// Forgets what can make no difference.
    fn tidy(&mut self, config: &Config) {
        let asked = self.host.asks();
        for (index, module) in self.modules.iter_mut().enumerate() {
            let link = &mut self.host.links[index];
            let heard = link.live.is_some() && link.live == module.session;
            if config.broken != Some(Broken::SameNonce) {
                module.tidy(config, self.now, asked.filter(|_| heard));
            }
            link.up.acks.retain(|ack| asked == Some(ack.number));
            if !config.late_reports {
                link.up.reports.clear();
            }
            if !heard && !link.calling.iter().any(|offer| Some(*offer) == module.session) {
                module.up = Up::default();
            }
        }
    }

    /// Which module is which does not matter.
    fn sort(&mut self) {
        let key =
            |index: usize| fingerprint(&(&self.modules[index], &self.host.links[index], &self.calls[index]));
        if key(1) < key(0) {
            self.modules.reverse();
            self.calls.reverse();
            self.host.swap();
        }
    }

    /// Whether what the host knows of its cycle is known.
    #[must_use]
    pub fn knowledge(&self, config: &Config, index: usize) -> Knowledge {
        self.host.knowledge(config, index)
    }
}

fn fingerprint(value: &impl std::hash::Hash) -> u64 {
    use std::hash::{DefaultHasher, Hasher};
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

impl Model for Config {
    type State = Fleet;
    type Action = Action;

    fn init_states(&self) -> Vec<Fleet> {
        vec![self.first()]
    }

    fn actions(&self, fleet: &Fleet, actions: &mut Vec<Action>) {
        // One breach is enough.
        if fleet.breaches != Breaches::default() {
            return;
        }
        let Fleet { now, host, modules, calls, left, .. } = fleet;
        if host.is_undecided() {
            actions.push(Action::LeadPasses);
        } else if *now < self.slots {
            actions.push(Action::SlotBegins { doubts: None });
            let doubting =
                (0..MODULES).filter(|&index| left.doubts > 0 && modules[index].slots.next.is_some());
            actions.extend(doubting.map(|index| Action::SlotBegins { doubts: Some(index) }));
        }
        if left.cycles > 0 && *now < self.slots && host.may_decide(*now) {
            actions.extend(self.deliveries.iter().map(|&delivery| Action::Decide(delivery)));
        }
        if left.holds > 0 && host.cycle.is_some() {
            actions.push(Action::Hold);
        }
        if left.orders > 0 {
            actions.push(Action::Order { stop: host.ordered() != Some(true) });
        }
        if left.host_boots > 0 {
            actions.push(Action::HostBoots);
        }
        for (index, module) in modules.iter().enumerate() {
            let link = &host.links[index];
            if host.offers(index, module.nonce, module.session).is_some() {
                actions.push(Action::Announced(index));
            }
            let calls = calls[index].iter().filter(|&&session| module.may_be_called(*now, session));
            actions.extend(calls.map(|&session| Action::Called(index, session)));
            let in_force = module.session.is_some() && module.session == link.live;
            if module.session.is_some_and(|session| link.calling.contains(&session)) {
                actions.push(Action::Joins(index));
            }
            if module.wants_time() && in_force {
                actions.push(Action::TimeKnown(index));
            }
            for &order in module.down.iter().filter(|_| module.session.is_some()) {
                actions.push(Action::Hears { module: index, order, doubt: false });
                if left.doubts > 0 && matches!(order.say, Say::Cycle(_)) {
                    actions.push(Action::Hears { module: index, order, doubt: true });
                }
            }
            actions.extend(link.up.acks.iter().map(|&ack| Action::Answered(index, ack)));
            actions.extend((0..link.up.reports.len()).map(|place| Action::Reported(index, Some(place))));
            if in_force && link.report != Some(module.report(*now)) {
                actions.push(Action::Reported(index, None));
            }
            if left.module_boots > 0 {
                actions.push(Action::ModuleBoots(index));
            }
            if left.stalls > 0 {
                actions.push(Action::Stalls(index));
            }
        }
    }

    fn next_state(&self, fleet: &Fleet, action: Action) -> Option<Fleet> {
        let next = self.after(fleet, action);
        (next != *fleet).then_some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        properties(self.recovery > 0)
    }
}
