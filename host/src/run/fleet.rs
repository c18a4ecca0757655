//! The modules of a run: inside this process on the loopback radio, or processes of their own, or robots, on UDP.

use std::convert::Infallible;

use link::dispatcher::{Dispatcher, ModuleLink};
use link::faults::{FaultCount, FaultParameters, Faulty};
use link::identity::HostIdentity;
use link::loopback::{Ether, LoopbackRadio, Node};
use link::udp::UdpRadio;
use protocol::time::{Duration, FleetInstant};
use protocol::{ModuleId, Radio};
use reconfiguration::problem::Problem;
use sim::TailState;
use sim::clock::ClockParameters;
use sim::module::{Boat, SimModule};
use sim::node::{Hardware, Setup, Simulated};
use sim::remote::RemoteTail;
use sim::rov::remote::RemoteRov;
use sim::rov::{RovActuation, SimRov, Thrusters};

use super::RunError;
use super::scenario::Scenario;

/// The host's address on the loopback.
const HOST: Node = Node(0);

/// Pause between two reports of a module in this process.
const REPORT_EVERY: Duration = Duration(20_000);

/// The radio of a module in this process.
pub type Medium = Faulty<LoopbackRadio>;

/// What a fleet's radio is addressed by.
pub type Address<F> = <<F as Fleet>::Radio as Radio>::Address;

/// The modules of one run, and the host's radio to them.
pub trait Fleet {
    /// What carries the datagrams.
    type Radio: Radio<Address: 'static, Error: Into<RunError>>;
    /// What the water feels of one module.
    type Actuation;

    /// The host's end of it.
    fn radio(&mut self) -> &mut Self::Radio;

    /// The host's identity on the link.
    fn host(&self) -> &HostIdentity;

    /// Their ids, in the order of the structure's places or of the problem's robots.
    fn roster(&self) -> &[ModuleId];

    /// Lets the modules run up to `now`, one tick after the last call.
    ///
    /// # Errors
    /// The radio's.
    fn advance(&mut self, now: FleetInstant) -> Result<(), RunError>;

    /// Writes what the water feels of each module at `now`.
    fn actuate(
        &mut self,
        now: FleetInstant,
        links: &Dispatcher<Address<Self>>,
        actuation: &mut Vec<Self::Actuation>,
    );

    /// By how much what the water feels at `now` is older than that.
    fn delay(&self) -> Duration {
        Duration(0)
    }

    /// Nothing was seen of the modules until `now`: what they are seen to do from then on is not joined to what they did before.
    fn forget(&mut self, _now: FleetInstant) {}

    /// Whether every module has told what it does since then.
    fn is_heard_since(&self, _since: FleetInstant, _links: &Dispatcher<Address<Self>>) -> bool {
        true
    }

    /// What the medium did to the datagrams, both ways, where that is known.
    fn faults(&self) -> Option<FaultCount>;

    /// Greatest error of a module's fleet time at `now`, µs, where that is known.
    fn clock_error_us(&self, now: FleetInstant) -> Option<u64>;
}

/// Modules in this process: Modboats, or ROVs.
pub struct InProcess<H: Hardware = Boat> {
    radio: Medium,
    host: HostIdentity,
    roster: Vec<ModuleId>,
    modules: Vec<Simulated<H, Medium>>,
}

impl InProcess {
    /// The modules of `scenario`, its faults on every radio, all from `seed`.
    ///
    /// # Errors
    /// [`RunError::Module`].
    pub fn boats(scenario: &Scenario, seed: u64) -> Result<Self, RunError> {
        let Scenario { structure, radio, clock, modboat, motor, start, .. } = scenario;
        Self::build(structure.len(), clock, *radio, seed, |setup, radio| {
            let boat = Boat::new(modboat, motor, start.tail_rad, setup.seed);
            boat.and_then(|boat| SimModule::new(setup, boat, radio, HOST))
                .map_err(|source| RunError::Module { id: setup.id.0, source })
        })
    }
}

impl InProcess<Thrusters> {
    /// The robots of `problem`, `faults` on every radio, all from `seed`.
    ///
    /// # Errors
    /// [`RunError::Rov`].
    pub fn rovs(problem: &Problem, faults: FaultParameters, seed: u64) -> Result<Self, RunError> {
        Self::build(problem.robots.len(), &ClockParameters::default(), faults, seed, |setup, radio| {
            let robot = usize::from(setup.id.0) - 1;
            let thrusters = Thrusters::new(&reversed(problem, robot), problem.rules.battery_v);
            thrusters
                .and_then(|thrusters| SimRov::new(setup, thrusters, radio, HOST))
                .map_err(|source| RunError::Rov { id: problem.robots[robot].id, source })
        })
    }
}

fn reversed(problem: &Problem, robot: usize) -> Vec<bool> {
    let vehicle = problem.robots.get(robot).and_then(|robot| problem.vehicles.get(robot.vehicle));
    vehicle.map_or_else(Vec::new, |vehicle| vehicle.thrusters.iter().map(|t| t.reversed).collect())
}

/// On the link modules are numbered by their place, from 1.
fn numbered(modules: usize) -> Vec<ModuleId> {
    (1..=modules as u16).map(ModuleId).collect()
}

impl<H: Hardware> InProcess<H> {
    fn build(
        modules: usize,
        clock: &ClockParameters,
        faults: FaultParameters,
        seed: u64,
        module: impl Fn(&Setup<'_>, Medium) -> Result<Simulated<H, Medium>, RunError>,
    ) -> Result<Self, RunError> {
        let ether = Ether::default();
        // Far apart, so that no two generators of one run start alike.
        let seeds = |stream: u64, index: usize| {
            seed.wrapping_mul(1_000_003).wrapping_add(stream * 10_007 + index as u64)
        };
        let host = HostIdentity::simulated(seed, 0);
        let roster = numbered(modules);
        let modules = roster.iter().enumerate().map(|(index, &id)| {
            let (fleet, key) = (host.key.fleet(), host.key.module(id));
            let seed = seeds(2, index);
            let setup = Setup { id, fleet, key, report_every: REPORT_EVERY, clock, seed };
            module(&setup, Faulty::new(ether.radio(Node(id.0)), faults, seeds(3, index)))
        });
        let modules = modules.collect::<Result<_, _>>()?;
        Ok(Self { radio: Faulty::new(ether.radio(HOST), faults, seeds(1, 0)), host, roster, modules })
    }

    /// The modules.
    pub fn modules(&self) -> &[Simulated<H, Medium>] {
        &self.modules
    }

    /// The modules, for faults in them.
    pub fn modules_mut(&mut self) -> &mut [Simulated<H, Medium>] {
        &mut self.modules
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
}

impl<H: Hardware> Fleet for InProcess<H> {
    type Radio = Medium;
    type Actuation = H::Actuation;

    fn host(&self) -> &HostIdentity {
        &self.host
    }

    fn roster(&self) -> &[ModuleId] {
        &self.roster
    }

    fn radio(&mut self) -> &mut Medium {
        &mut self.radio
    }

    fn advance(&mut self, now: FleetInstant) -> Result<(), RunError> {
        for module in &mut self.modules {
            module.tick(now)?;
        }
        Ok(())
    }

    fn actuate(&mut self, _now: FleetInstant, _links: &Dispatcher<Node>, actuation: &mut Vec<H::Actuation>) {
        actuation.resize_with(self.modules.len(), Default::default);
        self.modules.iter().zip(actuation).for_each(|(module, actuation)| module.actuate(actuation));
    }

    fn faults(&self) -> Option<FaultCount> {
        let counts = self.modules.iter().map(|module| module.radio().count());
        Some(counts.fold(self.radio.count(), |sum, count| sum + count))
    }

    fn clock_error_us(&self, now: FleetInstant) -> Option<u64> {
        self.modules.iter().filter_map(|module| module.clock_error_us(now)).map(i64::unsigned_abs).max()
    }
}

/// What a module that is not in this process does, by its reports.
pub trait Remote {
    /// What the water feels of it.
    type Actuation: Default;

    /// See [`Fleet::delay`].
    const DELAY: Duration = Duration(0);

    /// See [`Fleet::forget`].
    fn forget(&mut self, now: FleetInstant);

    /// When its last report is from, fleet time.
    fn reported<A: Copy>(link: &ModuleLink<A>) -> Option<FleetInstant>;

    /// Writes that at `now`.
    fn actuate<A: Copy>(&mut self, now: FleetInstant, link: &ModuleLink<A>, actuation: &mut Self::Actuation);
}

impl Remote for RemoteTail {
    type Actuation = TailState;
    const DELAY: Duration = sim::remote::DELAY;

    fn forget(&mut self, now: FleetInstant) {
        RemoteTail::forget(self, now);
    }

    fn reported<A: Copy>(link: &ModuleLink<A>) -> Option<FleetInstant> {
        link.telemetry().map(|report| report.at)
    }

    fn actuate<A: Copy>(&mut self, now: FleetInstant, link: &ModuleLink<A>, tail: &mut TailState) {
        if let Some(report) = link.telemetry() {
            self.report(report, link.heard());
        }
        *tail = self.state(now);
    }
}

impl Remote for RemoteRov {
    type Actuation = RovActuation;

    /// Thrusts are those of the last report, and none after a silence: nothing is joined.
    fn forget(&mut self, _now: FleetInstant) {}

    fn reported<A: Copy>(link: &ModuleLink<A>) -> Option<FleetInstant> {
        link.rov_telemetry().map(|report| report.at)
    }

    fn actuate<A: Copy>(&mut self, now: FleetInstant, link: &ModuleLink<A>, actuation: &mut RovActuation) {
        if let Some(report) = link.rov_telemetry() {
            self.report(report, link.heard());
        }
        self.step(now);
        RemoteRov::actuate(self, actuation);
    }
}

/// Modules that are processes of their own, or robots. What the water feels of them follows from what they report.
pub struct OverUdp<M = RemoteTail> {
    radio: Faulty<UdpRadio>,
    host: HostIdentity,
    roster: Vec<ModuleId>,
    modules: Vec<M>,
}

impl OverUdp {
    /// For the modules of `roster`, in the order of the structure's places, which will announce themselves to `radio`;
    /// `scenario`'s faults on what the host sends.
    pub fn boats(
        scenario: &Scenario,
        radio: UdpRadio,
        host: HostIdentity,
        roster: Vec<ModuleId>,
        seed: u64,
    ) -> Self {
        let inertia_kg_m2 = scenario.motor.rotor_inertia_kg_m2;
        let modules = roster.iter().map(|_| RemoteTail::new(inertia_kg_m2)).collect();
        Self { radio: Faulty::new(radio, scenario.radio, seed), host, roster, modules }
    }
}

impl OverUdp<RemoteRov> {
    /// For the robots of `problem`, which will announce themselves to `radio` with the numbers of `roster`; `faults` on what the host
    /// sends.
    #[must_use]
    pub fn rovs(
        problem: &Problem,
        radio: UdpRadio,
        host: HostIdentity,
        roster: Vec<ModuleId>,
        faults: FaultParameters,
        seed: u64,
    ) -> Self {
        let modules = (0..roster.len()).map(|robot| RemoteRov::new(&reversed(problem, robot))).collect();
        Self { radio: Faulty::new(radio, faults, seed), host, roster, modules }
    }
}

impl<M: Remote> Fleet for OverUdp<M> {
    type Radio = Faulty<UdpRadio>;
    type Actuation = M::Actuation;

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

    fn actuate(
        &mut self,
        now: FleetInstant,
        links: &Dispatcher<Address<Self>>,
        actuation: &mut Vec<M::Actuation>,
    ) {
        actuation.resize_with(self.modules.len(), Default::default);
        for ((module, link), actuation) in self.modules.iter_mut().zip(links.modules()).zip(actuation) {
            module.actuate(now, link, actuation);
        }
    }

    fn delay(&self) -> Duration {
        M::DELAY
    }

    fn forget(&mut self, now: FleetInstant) {
        self.modules.iter_mut().for_each(|module| module.forget(now));
    }

    fn is_heard_since(&self, since: FleetInstant, links: &Dispatcher<Address<Self>>) -> bool {
        links.modules().iter().all(|link| M::reported(link).is_some_and(|at| at >= since))
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
