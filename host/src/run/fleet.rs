//! Who executes: modules inside this process on the loopback radio, or processes of their own on UDP.

use std::convert::Infallible;
use std::net::SocketAddr;

use link::dispatcher::Dispatcher;
use link::faults::{FaultCount, FaultParameters, Faulty};
use link::identity::HostIdentity;
use link::loopback::{Ether, LoopbackRadio, Node};
use link::udp::UdpRadio;
use protocol::time::{Duration, FleetInstant};
use protocol::{ModuleId, Radio};
use sim::TailState;
use sim::module::{Setup, SimModule};
use sim::remote::RemoteTail;

use super::RunError;
use super::scenario::Scenario;

/// The host's address on the loopback.
const HOST: Node = Node(0);

/// Pause between two reports of a module in this process.
const REPORT_EVERY: Duration = Duration(20_000);

/// The modules of one run, and the host's radio to them.
pub trait Fleet {
    /// What carries the datagrams.
    type Radio: Radio<Address: 'static, Error: Into<RunError>>;

    /// The host's end of it.
    fn radio(&mut self) -> &mut Self::Radio;

    /// Who the host is to them.
    fn host(&self) -> &HostIdentity;

    /// Their ids, in the order of the structure's places.
    fn roster(&self) -> &[ModuleId];

    /// Lets the modules run up to `now`, one servo tick after the last call.
    ///
    /// # Errors
    /// The radio's.
    fn advance(&mut self, now: FleetInstant) -> Result<(), RunError>;

    /// The tails as the water feels them at `now`.
    fn tails(
        &mut self,
        now: FleetInstant,
        dispatcher: &Dispatcher<<Self::Radio as Radio>::Address>,
        tails: &mut Vec<TailState>,
    );

    /// What the medium did to the datagrams, both ways, where that is known.
    fn faults(&self) -> Option<FaultCount>;

    /// Greatest error of a module's fleet time at `now`, µs, where that is known.
    fn clock_error_us(&self, now: FleetInstant) -> Option<u64>;
}

/// Modules in this process.
pub struct InProcess {
    radio: Faulty<LoopbackRadio>,
    host: HostIdentity,
    roster: Vec<ModuleId>,
    modules: Vec<SimModule<Faulty<LoopbackRadio>>>,
}

impl InProcess {
    /// The modules of `scenario`, its faults on every radio, all from `seed`.
    ///
    /// # Errors
    /// [`RunError::Module`].
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, RunError> {
        let ether = Ether::default();
        // Far apart, so that no two generators of one run start alike.
        let seeds = |stream: u64, index: usize| {
            seed.wrapping_mul(1_000_003).wrapping_add(stream * 10_007 + index as u64)
        };
        let radio = Faulty::new(ether.radio(HOST), scenario.radio, seeds(1, 0));
        let host = HostIdentity::simulated(seed, 0);
        let mut modules = Vec::with_capacity(scenario.structure.len());
        for index in 0..scenario.structure.len() {
            let id = index as u16 + 1;
            let setup = Setup {
                id: ModuleId(id),
                fleet: host.key.fleet(),
                key: host.key.module(ModuleId(id)),
                modboat: &scenario.modboat,
                motor: &scenario.motor,
                clock: &scenario.clock,
                tail_rad: scenario.start.tail_rad,
                report_every: REPORT_EVERY,
                seed: seeds(2, index),
            };
            let module_radio = Faulty::new(ether.radio(Node(id)), scenario.radio, seeds(3, index));
            let module = SimModule::new(&setup, module_radio, HOST)
                .map_err(|source| RunError::Module { id, source })?;
            modules.push(module);
        }
        let roster = (1..=scenario.structure.len() as u16).map(ModuleId).collect();
        Ok(Self { radio, host, roster, modules })
    }

    /// The modules.
    pub fn modules(&self) -> &[SimModule<Faulty<LoopbackRadio>>] {
        &self.modules
    }

    /// Changes what the medium does on every radio.
    pub fn set_weather(&mut self, faults: FaultParameters) {
        self.radio.set_parameters(faults);
        self.modules.iter_mut().for_each(|module| module.radio_mut().set_parameters(faults));
    }

    /// Makes the medium perfect; with `drop_under_way`, what is under way never arrives.
    pub fn heal(&mut self, drop_under_way: bool) {
        self.radio.heal(drop_under_way);
        self.modules.iter_mut().for_each(|module| module.radio_mut().heal(drop_under_way));
    }

    /// The modules, for faults in them.
    pub fn modules_mut(&mut self) -> &mut [SimModule<Faulty<LoopbackRadio>>] {
        &mut self.modules
    }
}

impl Fleet for InProcess {
    type Radio = Faulty<LoopbackRadio>;

    fn host(&self) -> &HostIdentity {
        &self.host
    }

    fn roster(&self) -> &[ModuleId] {
        &self.roster
    }

    fn radio(&mut self) -> &mut Self::Radio {
        &mut self.radio
    }

    fn advance(&mut self, now: FleetInstant) -> Result<(), RunError> {
        for module in &mut self.modules {
            module.tick(now)?;
        }
        Ok(())
    }

    fn tails(&mut self, _now: FleetInstant, _dispatcher: &Dispatcher<Node>, tails: &mut Vec<TailState>) {
        tails.clear();
        tails.extend(self.modules.iter().map(SimModule::tail));
    }

    fn faults(&self) -> Option<FaultCount> {
        let counts = self.modules.iter().map(|module| module.radio().count());
        Some(counts.fold(self.radio.count(), |sum, count| sum + count))
    }

    fn clock_error_us(&self, now: FleetInstant) -> Option<u64> {
        self.modules.iter().filter_map(|module| module.clock_error_us(now)).map(i64::unsigned_abs).max()
    }
}

/// Modules that are processes of their own, or robots. The water is simulated here, from the tails they report.
pub struct OverUdp {
    radio: Faulty<UdpRadio>,
    host: HostIdentity,
    roster: Vec<ModuleId>,
    tails: Vec<RemoteTail>,
}

impl OverUdp {
    /// For the modules of `roster`, in the order of the structure's places, which will announce themselves to `radio`;
    /// `scenario`'s faults on what the host sends.
    pub fn new(
        scenario: &Scenario,
        radio: UdpRadio,
        host: HostIdentity,
        roster: Vec<ModuleId>,
        seed: u64,
    ) -> Self {
        let inertia_kg_m2 = scenario.motor.rotor_inertia_kg_m2;
        let tails = scenario.structure.cells().iter().map(|_| RemoteTail::new(inertia_kg_m2)).collect();
        Self { radio: Faulty::new(radio, scenario.radio, seed), host, roster, tails }
    }
}

impl Fleet for OverUdp {
    type Radio = Faulty<UdpRadio>;

    fn host(&self) -> &HostIdentity {
        &self.host
    }

    fn roster(&self) -> &[ModuleId] {
        &self.roster
    }

    fn radio(&mut self) -> &mut Self::Radio {
        &mut self.radio
    }

    fn advance(&mut self, _now: FleetInstant) -> Result<(), RunError> {
        Ok(())
    }

    fn tails(&mut self, now: FleetInstant, dispatcher: &Dispatcher<SocketAddr>, tails: &mut Vec<TailState>) {
        tails.clear();
        for (tail, link) in self.tails.iter_mut().zip(dispatcher.modules()) {
            if let Some(report) = link.telemetry() {
                tail.report(report, link.heard());
            }
            tails.push(tail.state(now));
        }
    }

    fn faults(&self) -> Option<FaultCount> {
        None
    }

    fn clock_error_us(&self, _now: FleetInstant) -> Option<u64> {
        None
    }
}

impl From<Infallible> for RunError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}
