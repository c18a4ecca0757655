//! What executes a reconfiguration: ROVs inside this process on the loopback radio, or processes of their own on UDP.
//!
//! The water is simulated by the run either way; a fleet says what its propellers give. On the link robots are numbered
//! by their place in the problem, from 1.

use std::convert::Infallible;
use std::net::SocketAddr;

use link::dispatcher::Dispatcher;
use link::faults::{FaultCount, FaultParameters, Faulty};
use link::identity::HostIdentity;
use link::loopback::{Ether, LoopbackRadio, Node};
use link::udp::UdpRadio;
use protocol::time::{Duration, FleetInstant};
use protocol::{ModuleId, Radio};
use reconfiguration::problem::Problem;
use sim::clock::ClockParameters;
use sim::rov::remote::RemoteRov;
use sim::rov::{RovSetup, SimRov};

use super::ExecutionError;

/// The host's address on the loopback.
const HOST: Node = Node(0);

/// Pause between two reports of an ROV in this process.
const REPORT_EVERY: Duration = Duration(20_000);

/// The ROVs of one run, and the host's radio to them.
pub trait Fleet {
    /// What carries the datagrams.
    type Radio: Radio<Address: 'static, Error: Into<ExecutionError>>;

    /// The host's end of it.
    fn radio(&mut self) -> &mut Self::Radio;

    /// The host's identity on the link.
    fn host(&self) -> &HostIdentity;

    /// Lets the ROVs run up to `now`.
    ///
    /// # Errors
    /// The radio's.
    fn advance(
        &mut self,
        now: FleetInstant,
        dispatcher: &Dispatcher<<Self::Radio as Radio>::Address>,
    ) -> Result<(), ExecutionError>;

    /// Thrusts of every robot as the water feels them, N.
    fn thrusts_n(&self) -> Vec<&[f64]>;

    /// Pulses of a robot's controllers, µs.
    fn pulses_us(&self, robot: usize, dispatcher: &Dispatcher<<Self::Radio as Radio>::Address>) -> Vec<f64>;

    /// What the medium did to the datagrams, both ways, where that is known.
    fn faults(&self) -> Option<FaultCount>;
}

fn reversed(problem: &Problem, robot: usize) -> Vec<bool> {
    let vehicle = problem.robots.get(robot).and_then(|robot| problem.vehicles.get(robot.vehicle));
    vehicle.map_or_else(Vec::new, |vehicle| vehicle.thrusters.iter().map(|t| t.reversed).collect())
}

/// ROVs in this process.
pub struct InProcess {
    radio: Faulty<LoopbackRadio>,
    host: HostIdentity,
    rovs: Vec<SimRov<Faulty<LoopbackRadio>>>,
}

impl InProcess {
    /// The robots of `problem`, `faults` on every radio, all from `seed`.
    ///
    /// # Errors
    /// [`ExecutionError::Rov`].
    pub fn new(problem: &Problem, faults: FaultParameters, seed: u64) -> Result<Self, ExecutionError> {
        let ether = Ether::default();
        // Far apart, so that no two generators of one run start alike.
        let seeds = |stream: u64, index: usize| {
            seed.wrapping_mul(1_000_003).wrapping_add(stream * 10_007 + index as u64)
        };
        let radio = Faulty::new(ether.radio(HOST), faults, seeds(1, 0));
        let clock = ClockParameters::default();
        let host = HostIdentity::simulated(seed, 0);
        let mut rovs = Vec::with_capacity(problem.robots.len());
        for (index, robot) in problem.robots.iter().enumerate() {
            let number = index as u16 + 1;
            let setup = RovSetup {
                id: ModuleId(number),
                fleet: host.key.fleet(),
                key: host.key.module(ModuleId(number)),
                reversed: &reversed(problem, index),
                battery_v: problem.rules.battery_v,
                report_every: REPORT_EVERY,
                clock: &clock,
                seed: seeds(2, index),
            };
            let rov_radio = Faulty::new(ether.radio(Node(number)), faults, seeds(3, index));
            let rov = SimRov::new(&setup, rov_radio, HOST)
                .map_err(|source| ExecutionError::Rov { id: robot.id, source })?;
            rovs.push(rov);
        }
        Ok(Self { radio, host, rovs })
    }

    /// The ROVs in the order of the problem, for faults in them.
    pub fn rovs_mut(&mut self) -> &mut [SimRov<Faulty<LoopbackRadio>>] {
        &mut self.rovs
    }
}

impl Fleet for InProcess {
    type Radio = Faulty<LoopbackRadio>;

    fn host(&self) -> &HostIdentity {
        &self.host
    }

    fn radio(&mut self) -> &mut Self::Radio {
        &mut self.radio
    }

    fn advance(&mut self, now: FleetInstant, _dispatcher: &Dispatcher<Node>) -> Result<(), ExecutionError> {
        for rov in &mut self.rovs {
            rov.tick(now)?;
        }
        Ok(())
    }

    fn thrusts_n(&self) -> Vec<&[f64]> {
        self.rovs.iter().map(SimRov::thrusts_n).collect()
    }

    fn pulses_us(&self, robot: usize, _dispatcher: &Dispatcher<Node>) -> Vec<f64> {
        self.rovs.get(robot).map_or_else(Vec::new, SimRov::pulses_us)
    }

    fn faults(&self) -> Option<FaultCount> {
        let counts = self.rovs.iter().map(|rov| rov.radio().count());
        Some(counts.fold(self.radio.count(), |sum, count| sum + count))
    }
}

/// ROVs that are processes of their own. What their propellers give follows from the pulses that they report.
pub struct OverUdp {
    radio: Faulty<UdpRadio>,
    host: HostIdentity,
    rovs: Vec<RemoteRov>,
}

impl OverUdp {
    /// For the robots of `problem`, which will announce themselves to `radio`; `faults` on what the host sends.
    #[must_use]
    pub fn new(
        problem: &Problem,
        radio: UdpRadio,
        host: HostIdentity,
        faults: FaultParameters,
        seed: u64,
    ) -> Self {
        let rovs = (0..problem.robots.len()).map(|robot| RemoteRov::new(&reversed(problem, robot)));
        Self { radio: Faulty::new(radio, faults, seed), host, rovs: rovs.collect() }
    }
}

impl Fleet for OverUdp {
    type Radio = Faulty<UdpRadio>;

    fn host(&self) -> &HostIdentity {
        &self.host
    }

    fn radio(&mut self) -> &mut Self::Radio {
        &mut self.radio
    }

    fn advance(
        &mut self,
        now: FleetInstant,
        dispatcher: &Dispatcher<SocketAddr>,
    ) -> Result<(), ExecutionError> {
        for (rov, link) in self.rovs.iter_mut().zip(dispatcher.modules()) {
            if let Some(report) = link.rov_telemetry() {
                rov.report(report, link.heard());
            }
            rov.step(now);
        }
        Ok(())
    }

    fn thrusts_n(&self) -> Vec<&[f64]> {
        self.rovs.iter().map(RemoteRov::thrusts_n).collect()
    }

    fn pulses_us(&self, robot: usize, dispatcher: &Dispatcher<SocketAddr>) -> Vec<f64> {
        let report = dispatcher.modules().get(robot).and_then(|link| link.rov_telemetry());
        report.map_or_else(Vec::new, |report| report.pulses.iter().map(|pulse| f64::from(pulse.0)).collect())
    }

    fn faults(&self) -> Option<FaultCount> {
        None
    }
}

impl From<Infallible> for ExecutionError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}
