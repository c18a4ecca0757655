//! A plan executed by ROVs with sockets of their own.

use host::run::experiment::Pace;
use host::run::progress::Quiet;
use host::run::reconfigure::ExecutionError;
use host::run::reconfigure::execution::run;
use host::run::reconfigure::fleet::{Fleet, OverUdp};
use link::dispatcher::Dispatcher;
use link::faults::{FaultCount, FaultParameters};
use link::identity::HostIdentity;
use link::udp::UdpRadio;
use protocol::ModuleId;
use protocol::time::{Duration, FleetInstant};
use reconfiguration::plan::ActionKind;
use sim::clock::ClockParameters;
use sim::rov::{RovSetup, SimRov};
use std::net::SocketAddr;
use std::sync::atomic::AtomicBool;

use super::{all_arrived, options, pair, show};

/// ROVs with sockets of their own in lock step with their host: they take their turn at each of its ticks.
struct OnSockets {
    host: OverUdp,
    rovs: Vec<SimRov<UdpRadio>>,
}

impl Fleet for OnSockets {
    type Radio = <OverUdp as Fleet>::Radio;

    fn radio(&mut self) -> &mut Self::Radio {
        self.host.radio()
    }

    fn host(&self) -> &HostIdentity {
        self.host.host()
    }

    fn advance(
        &mut self,
        now: FleetInstant,
        dispatcher: &Dispatcher<SocketAddr>,
    ) -> Result<(), ExecutionError> {
        for rov in &mut self.rovs {
            rov.tick(now)?;
        }
        self.host.advance(now, dispatcher)
    }

    fn thrusts_n(&self) -> Vec<&[f64]> {
        self.host.thrusts_n()
    }

    fn pulses_us(&self, robot: usize, dispatcher: &Dispatcher<SocketAddr>) -> Vec<f64> {
        self.host.pulses_us(robot, dispatcher)
    }

    fn faults(&self) -> Option<FaultCount> {
        self.host.faults()
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
        let setup = RovSetup {
            id: ModuleId(id),
            fleet: identity.key.fleet(),
            key: identity.key.module(ModuleId(id)),
            reversed: &[false; 6],
            battery_v: 16.0,
            report_every: Duration(20_000),
            clock: &clock,
            seed: u64::from(id),
        };
        let radio = UdpRadio::bind("127.0.0.1:0").expect("a socket");
        SimRov::new(&setup, radio, address).expect("an ROV")
    });
    let rovs = rovs.collect();
    let host = OverUdp::new(&problem, radio, identity.clone(), FaultParameters::default(), 1);
    let mut fleet = OnSockets { host, rovs };
    let stop = AtomicBool::new(false);
    let executed = run(
        &problem,
        &plan,
        &options(1),
        &mut fleet,
        Pace::Simulated,
        &mut Quiet,
        &stop,
        &mut |_, _, _: &mut OnSockets| {},
    )
    .expect("begun");
    show("over UDP", &executed);
    all_arrived(&executed);
}
