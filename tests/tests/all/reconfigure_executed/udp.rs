//! A plan executed by ROVs with sockets of their own.

use host::run::RunError;
use host::run::closed_loop::Drive;
use host::run::experiment::Pace;
use host::run::fleet::{Fleet, OverUdp};
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::reconfigure::execution::run;
use link::dispatcher::Dispatcher;
use link::faults::{FaultCount, FaultParameters};
use link::identity::HostIdentity;
use link::udp::UdpRadio;
use protocol::ModuleId;
use protocol::time::{Duration, FleetInstant};
use reconfiguration::plan::ActionKind;
use sim::clock::ClockParameters;
use sim::node::Setup;
use sim::rov::remote::RemoteRov;
use sim::rov::{RovActuation, SimRov, Thrusters};
use std::net::SocketAddr;

use super::{all_arrived, options, pair, show};

/// ROVs with sockets of their own in lock step with their host: they take their turn at each of its ticks.
struct OnSockets {
    host: OverUdp<RemoteRov>,
    rovs: Vec<SimRov<UdpRadio>>,
}

impl Fleet for OnSockets {
    type Radio = <OverUdp<RemoteRov> as Fleet>::Radio;
    type Actuation = RovActuation;

    fn radio(&mut self) -> &mut Self::Radio {
        self.host.radio()
    }

    fn host(&self) -> &HostIdentity {
        self.host.host()
    }

    fn roster(&self) -> &[ModuleId] {
        self.host.roster()
    }

    fn advance(&mut self, now: FleetInstant) -> Result<(), RunError> {
        for rov in &mut self.rovs {
            rov.tick(now)?;
        }
        self.host.advance(now)
    }

    fn actuate(
        &mut self,
        now: FleetInstant,
        links: &Dispatcher<SocketAddr>,
        actuation: &mut Vec<RovActuation>,
    ) {
        self.host.actuate(now, links, actuation);
    }

    fn faults(&self) -> Option<FaultCount> {
        self.host.faults()
    }

    fn clock_error_us(&self, now: FleetInstant) -> Option<u64> {
        self.host.clock_error_us(now)
    }
}

/// The same over UDP: every ROV with a socket of its own.
#[test]
fn robots_on_udp_follow_the_plan() {
    let (problem, plan) = pair(&[
        (ActionKind::Leg, [-0.483, 0.6, 0.0, 0.0], 0.25),
        (ActionKind::Leg, [-0.483, 0.0, 0.0, 0.0], 0.25),
    ]);
    let radio = UdpRadio::bind("127.0.0.1:0").expect("a socket");
    let address = radio.local_address().expect("an address");
    let identity = HostIdentity::simulated(1, 0);
    let clock = ClockParameters { offset_s: 0.0, drift_ppm: 0.0 };
    let rovs = (1..=problem.robots.len() as u16).map(|id| {
        let setup = Setup {
            id: ModuleId(id),
            fleet: identity.key.fleet(),
            key: identity.key.module(ModuleId(id)),
            report_every: Duration(20_000),
            clock: &clock,
            seed: u64::from(id),
        };
        let radio = UdpRadio::bind("127.0.0.1:0").expect("a socket");
        SimRov::new(&setup, Thrusters::new(&[false; 6], 16.0).expect("in the table"), radio, address)
            .expect("an ROV")
    });
    let rovs = rovs.collect();
    let roster = (1..=problem.robots.len() as u16).map(ModuleId).collect();
    let host = OverUdp::rovs(&problem, radio, identity.clone(), roster, FaultParameters::default(), 1);
    let mut fleet = OnSockets { host, rovs };
    let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut |_, _, _| {} };
    let executed = run(&problem, &plan, &options(1), &mut fleet, drive, &mut Quiet).expect("begun");
    show("over UDP", &executed);
    all_arrived(&executed);
}
