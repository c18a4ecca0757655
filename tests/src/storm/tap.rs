//! A fleet whose radios are tapped: every datagram that a sender hands to its faulty radio, and every one that comes out at a
//! receiver, in order, before any code of the link counts it.

use std::cell::RefCell;
use std::net::SocketAddr;
use std::rc::Rc;

use host::run::scenario::Scenario;
use link::faults::{FaultParameters, Faulty};
use link::identity::HostIdentity;
use link::loopback::{Ether, Node};
use link::udp::{BrokenRadio, UdpRadio};
use protocol::time::{Duration, FleetInstant};
use protocol::{ModuleId, Radio};
use sim::module::{Boat, SimModule};
use sim::node::Setup;

use super::liar::Liar;
use super::wire::{Trouble, Wire, address};

/// The host's address on the loopback; modules have their ids.
pub const HOST: Node = Node(0);
/// Pause between two reports of a module, as of modules in the program's own process.
const REPORT_EVERY: Duration = Duration(20_000);

/// A datagram at a tap.
#[derive(Clone, Debug)]
pub enum Tapped {
    /// Handed to the radio by this node.
    Sent(Node, Vec<u8>),
    /// The same, with numbers that no module can have.
    Lied(Node, Vec<u8>),
    /// Taken from the radio by this node.
    Came(Node, Vec<u8>),
}

type Tape = Rc<RefCell<Vec<Tapped>>>;

/// The medium of a storm: faults over the radio of runs on UDP.
pub type Medium = Faulty<UdpRadio<Wire>>;

/// A faulty radio with a tap above it.
pub struct Tap {
    node: Node,
    radio: Medium,
    tape: Tape,
    /// Says something else than its module, if there is one.
    pub liar: Option<Liar>,
}

impl Tap {
    /// The radio below.
    #[must_use]
    pub const fn radio(&self) -> &Medium {
        &self.radio
    }
}

impl Radio for Tap {
    type Address = SocketAddr;
    type Error = BrokenRadio;

    fn send(&mut self, now: FleetInstant, to: SocketAddr, datagram: &[u8]) -> Result<(), BrokenRadio> {
        if let Some(lie) = self.liar.as_mut().and_then(|liar| liar.say(datagram)) {
            self.tape.borrow_mut().push(Tapped::Lied(self.node, lie.clone()));
            return self.radio.send(now, to, &lie);
        }
        self.tape.borrow_mut().push(Tapped::Sent(self.node, datagram.to_vec()));
        self.radio.send(now, to, datagram)
    }

    fn receive(
        &mut self,
        now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, SocketAddr)>, BrokenRadio> {
        let received = self.radio.receive(now, buffer)?;
        if let Some((length, _)) = received {
            if let Some(liar) = &mut self.liar {
                liar.hear(&buffer[..length]);
            }
            self.tape.borrow_mut().push(Tapped::Came(self.node, buffer[..length].to_vec()));
        }
        Ok(received)
    }
}

/// Modules in this process and the host's radio to them, all tapped.
pub struct TappedFleet {
    /// The host's end.
    pub radio: Tap,
    /// The modules, in the order of the structure's places; behind them those that have the number of one of them.
    pub modules: Vec<SimModule<Tap>>,
    /// The ids of the structure's.
    pub roster: Vec<ModuleId>,
    /// The machine of each node.
    pub troubles: Vec<Rc<Trouble>>,
    /// What all radios are at.
    pub ether: Ether,
    tape: Tape,
}

impl TappedFleet {
    /// The modules of `scenario`, and others with the numbers `doubles`; its faults on every radio, all from `seed`.
    ///
    /// # Panics
    /// If a module of the scenario cannot be.
    #[must_use]
    pub fn new(scenario: &Scenario, doubles: &[u16], seed: u64) -> Self {
        let (ether, tape) = (Ether::default(), Tape::default());
        // Far apart, so that no two generators of one run start alike.
        let seeds = |stream: u64, index: u64| seed.wrapping_mul(1_000_003) + stream * 10_007 + index;
        let nodes = 1 + scenario.structure.len() + doubles.len();
        let troubles: Vec<Rc<Trouble>> = (0..nodes).map(|_| Rc::default()).collect();
        let tap = |node: Node, seed: u64| {
            let wire = Wire::new(&ether, node, Rc::clone(&troubles[usize::from(node.0)]), seed);
            let radio = UdpRadio::over(wire);
            // A module waits for its network.
            let radio = if node == HOST { radio } else { radio.patient() };
            Tap { node, radio: Faulty::new(radio, scenario.radio, seed), tape: Rc::clone(&tape), liar: None }
        };
        let host = HostIdentity::simulated(seed, 0);
        let roster: Vec<ModuleId> = (1..=scenario.structure.len() as u16).map(ModuleId).collect();
        let ids = roster.iter().copied().chain(doubles.iter().copied().map(ModuleId));
        let modules = ids.zip(0..).map(|(id, index)| {
            let (fleet, key, seed) = (host.key.fleet(), host.key.module(id), seeds(2, index));
            let setup = Setup { id, fleet, key, report_every: REPORT_EVERY, clock: &scenario.clock, seed };
            let Scenario { modboat, motor, start, .. } = scenario;
            let boat = Boat::new(modboat, motor, start.tail_rad, seed).expect("a module");
            let tap = tap(Node(index as u16 + 1), seeds(3, index));
            SimModule::new(&setup, boat, tap, address(HOST)).expect("a module")
        });
        let modules = modules.collect();
        Self { radio: tap(HOST, seeds(1, 0)), modules, roster, troubles, ether, tape }
    }

    /// Lets every module run for one tick.
    pub fn advance(&mut self, now: FleetInstant) {
        for module in &mut self.modules {
            module.tick(now).expect("a module's radio is patient");
        }
    }

    /// What passed the taps since the last call.
    pub fn take_tape(&mut self) -> Vec<Tapped> {
        std::mem::take(&mut self.tape.borrow_mut())
    }

    /// Changes what the medium does on every radio.
    pub fn set_weather(&mut self, faults: FaultParameters) {
        self.each_radio(&mut |radio| radio.set_parameters(faults));
    }

    /// Makes the medium perfect; with `drop_under_way`, what is under way never arrives.
    pub fn heal(&mut self, drop_under_way: bool) {
        self.each_radio(&mut |radio| radio.heal(drop_under_way));
    }

    fn each_radio(&mut self, change: &mut dyn FnMut(&mut Medium)) {
        change(&mut self.radio.radio);
        self.modules.iter_mut().for_each(|module| change(&mut module.radio_mut().radio));
    }
}
