//! The dispatcher, and the firmware's links of 25 modules, over radios that lose.

use firmware::link::session::{Identity, Link, SURE_WITHIN};
use link::dispatcher::Dispatcher;
use link::faults::{FaultParameters, Faulty};
use link::identity::HostIdentity;
use link::lead::Lead;
use link::loopback::{Ether, LoopbackRadio, Node};
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::Radians;
use protocol::{
    Acknowledge, Cycle, Delivery, Hello, MAX_DATAGRAM, Message, ModboatCycle, ModuleId, ModuleKind, Motion,
    Radio, TimeRequest, Verdict,
};

use super::calculation::TICK_US;

const HOST: Node = Node(0);

/// One module: its link, and which cycles it has.
struct Module {
    link: Link,
    radio: Faulty<LoopbackRadio>,
    prepared: Option<u32>,
    taken: Option<u32>,
}

impl Module {
    fn ask(&mut self, now: FleetInstant) {
        let mut buffer = [0; MAX_DATAGRAM];
        let request = Message::TimeRequest(TimeRequest { sent: LocalInstant(now.0) });
        if let Some(datagram) = self.link.seal(&request, &mut buffer) {
            let Ok(()) = self.radio.send(now, HOST, datagram);
        }
    }

    fn follow(&mut self, now: FleetInstant) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Ok(Some((length, _))) = self.radio.receive(now, &mut buffer) {
            let Ok(heard) = self.link.open(LocalInstant(now.0), &buffer[..length], false) else { continue };
            let answer = match heard.opened.message {
                Message::Cycle(Cycle { number, .. }) if self.taken == Some(number) => {
                    Some((number, Verdict::Duplicate))
                }
                Message::Cycle(Cycle { number, delivery: Delivery::Prepare, .. }) => {
                    self.prepared = Some(number);
                    Some((number, Verdict::Prepared))
                }
                Message::Cycle(Cycle { number, .. }) => {
                    self.taken = Some(number);
                    Some((number, Verdict::Accepted))
                }
                Message::Commit(number) if self.prepared == Some(number) => {
                    self.taken = Some(number);
                    Some((number, Verdict::Accepted))
                }
                // The first word in the session: the host sees that it is there.
                Message::Called => Some((0, Verdict::Duplicate)),
                _ => None,
            };
            let Some((cycle, verdict)) = answer else { continue };
            let message = Message::Acknowledge(Acknowledge { cycle, verdict });
            let datagram = self.link.seal(&message, &mut buffer).expect("a session");
            let Ok(()) = self.radio.send(now, HOST, datagram);
        }
    }
}

/// What became of one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reached {
    /// Modules that could run it at its start.
    pub modules: usize,
    /// No module was to run it.
    pub dropped: bool,
    /// No commit of it was to be sent for the first time closer to its start.
    pub commit_lead: Duration,
}

/// Pause between two questions of a module for the time: what is measured of the link is measured all the time.
const ASK_EVERY_US: u64 = 20_000;

/// See the module's documentation.
pub struct Rig {
    host: Dispatcher<Node>,
    radio: Faulty<LoopbackRadio>,
    modules: Vec<Module>,
    now: FleetInstant,
    number: u32,
}

impl Rig {
    /// With every module in a session; `seed` decides every loss.
    pub fn new(modules: u16, seed: u64) -> Self {
        let HostIdentity { key, boot } = HostIdentity::simulated(seed, 0);
        let ids: Vec<ModuleId> = (1..=modules).map(ModuleId).collect();
        let ether = Ether::default();
        let radio = |node: Node| {
            let seed = seed.wrapping_mul(1_000_003).wrapping_add(u64::from(node.0));
            Faulty::new(ether.radio(node), FaultParameters::default(), seed)
        };
        let module = |id: &ModuleId| {
            let link = Link::new(Identity {
                module: *id,
                fleet: key.fleet(),
                key: key.module(*id),
                boot: [id.0 as u8; 12],
                report_every: Duration(10_000),
                sure_within: SURE_WITHIN,
            });
            Module { link, radio: radio(Node(id.0)), prepared: None, taken: None }
        };
        let modules = ids.iter().map(module).collect();
        let host = Dispatcher::new(&ids, &key, boot);
        let mut rig = Self { host, radio: radio(HOST), modules, now: FleetInstant(0), number: 0 };
        let hello = Hello { kind: ModuleKind::Modboat, firmware: (0, 1, 0), session: 0 };
        for module in &mut rig.modules {
            let mut buffer = [0; MAX_DATAGRAM];
            let datagram = module.link.seal_announcement(&hello, &mut buffer).expect("room");
            let Ok(()) = module.radio.send(rig.now, HOST, datagram);
        }
        (0..3).for_each(|_| rig.tick());
        assert!(rig.host.modules().iter().all(|link| link.is_known()));
        rig
    }

    fn tick(&mut self) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Ok(Some((length, from))) = self.radio.receive(self.now, &mut buffer) {
            let _ = self.host.handle_datagram(self.now, from, &buffer[..length]);
        }
        self.host.handle_timer(self.now);
        while let Some((to, datagram)) = self.host.poll_transmit(self.now, &mut buffer) {
            let Ok(()) = self.radio.send(self.now, to, datagram);
        }
        for (index, module) in self.modules.iter_mut().enumerate() {
            module.follow(self.now);
            if (self.now.0 + index as u64 * TICK_US).is_multiple_of(ASK_EVERY_US) {
                module.ask(self.now);
            }
        }
        self.now = FleetInstant(self.now.0 + TICK_US);
    }

    /// How long before its start a cycle for all or none is to be sent, by what the host has measured.
    pub fn lead(&self) -> Lead {
        self.host.lead()
    }

    /// One cycle in this weather, sent `lead` ahead, until its start.
    pub fn cycle(&mut self, weather: FaultParameters, lead: Duration, delivery: Delivery) -> Reached {
        self.radio.set_parameters(weather);
        self.modules.iter_mut().for_each(|module| module.radio.set_parameters(weather));
        self.number += 1;
        let start = self.now.after(lead);
        let motion = Motion::Modboat(ModboatCycle {
            rotation: Radians(0.0),
            centerline: Radians(1.5),
            amplitude: Radians(1.0),
            transition: Duration(0),
            period: Duration(1_500_000),
            law: protocol::TransitionLaw::ConstantSpeed,
        });
        let motions = vec![Some(motion); self.modules.len()];
        let commit_lead = self.host.lead().commit;
        self.host.dispatch(self.now, self.number, start, &motions, delivery);
        while self.now < start {
            self.tick();
        }
        let modules = self.modules.iter().filter(|module| module.taken == Some(self.number)).count();
        // What is under way belongs to no later cycle.
        self.radio.heal(true);
        self.modules.iter_mut().for_each(|module| module.radio.heal(true));
        self.tick();
        let dropped = self.host.is_dropped(self.number);
        self.tick();
        Reached { modules, dropped, commit_lead }
    }
}
