use std::vec::Vec;

use protocol::units::{Amperes, Radians, RadiansPerSecond, Volts};
use protocol::{
    Connectors, Delivery, Faults, FleetKey, ModboatCycle, ModuleId, ModuleKind, Motion, RovCycle,
};

use super::*;
use crate::bench_host::{AHEAD, BenchHost, Counterpart, assert_exact, identity, in_session};
use crate::link::failsafe::Permission;
use crate::link::session::{CALLS, HOST_SILENCE};
use crate::modboat::reference::Reference;
use crate::modboat::robot::{Measurement, ModboatRobot};
use protocol::configuration::TailLimits;

mod hosts;
mod stops;
mod two_phase;

const MS: u64 = 1_000;
const AT_ZERO: Measurement = Measurement {
    tail: Some(Radians(0.0)),
    lost: false,
    rate: RadiansPerSecond(0.0),
    current: Amperes(0.0),
    battery: Volts(7.4),
};

/// A module that ticks every millisecond, and its host.
struct Bench {
    endpoint: Endpoint<ModboatRobot>,
    host: BenchHost,
    now: LocalInstant,
    tail: Measurement,
}

impl Bench {
    /// Booted, and nothing has been said.
    fn boot() -> Self {
        let endpoint = Endpoint::new(Some(identity(1)), ModboatRobot::new(TailLimits::default()));
        Self { endpoint, host: BenchHost::new(1), now: LocalInstant(0), tail: AT_ZERO }
    }

    /// In a session, and it knows the fleet time: at 1 s of its own clock.
    fn ready() -> Self {
        let mut bench = Self::boot();
        bench.run(1_000 * MS);
        assert_eq!(bench.state(), ModuleState::Ready);
        bench
    }

    /// Ticks until `end`, own clock. What it said comes back.
    fn run(&mut self, end: u64) -> Vec<Message> {
        let mut said = Vec::new();
        while self.now.0 < end {
            self.endpoint.handle_timer(self.now, &self.tail);
            said.extend(self.host.listen(self.now, &mut self.endpoint));
            self.now.0 += MS;
        }
        said
    }

    fn state(&self) -> ModuleState {
        self.endpoint.state(self.now)
    }

    fn ask(&mut self, message: &Message) -> Verdict {
        self.host.ask(self.now, &mut self.endpoint, message)
    }

    fn say(&mut self, message: &Message) -> Vec<Message> {
        self.host.say(self.now, &mut self.endpoint, message)
    }

    /// Delivers a datagram of any sender.
    fn bring(&mut self, datagram: &[u8]) -> Result<(), Class> {
        let heard = self.endpoint.handle_datagram(self.now, datagram);
        assert_exact(&self.endpoint);
        heard
    }

    fn reference(&self) -> Reference {
        self.endpoint.reference(self.now).expect("it has seen its tail")
    }

    fn incoming(&self) -> protocol::ledger::Incoming {
        Counterpart::incoming(&self.endpoint)
    }

    fn is_frozen_at(&self, angle_rad: f32) -> bool {
        (self.reference().angle_rad - angle_rad).abs() < 1e-6
    }
}

/// Starts at `start` on the module's own clock, at the pose 0, and ends there 2 s later.
fn cycle(number: u32, start: u64, amplitude: f32) -> Cycle {
    let motion = ModboatCycle {
        rotation: Radians(0.0),
        centerline: Radians(-amplitude),
        amplitude: Radians(amplitude),
        transition: Duration(500_000),
        period: Duration(1_500_000),
        law: protocol::TransitionLaw::ConstantSpeed,
    };
    let motion = Motion::Modboat(motion);
    Cycle { number, start: FleetInstant(start + AHEAD), motion, delivery: Delivery::Direct }
}

fn direct(number: u32, start: u64) -> Message {
    Message::Cycle(cycle(number, start, 1.0))
}

fn prepare(number: u32, start: u64) -> Message {
    Message::Cycle(Cycle { delivery: Delivery::Prepare, ..cycle(number, start, 1.0) })
}

fn refused(refusal: Refusal) -> Verdict {
    Verdict::Refused(refusal)
}

#[test]
fn announces_itself_is_called_asks_the_time_and_reports() {
    let mut bench = Bench::boot();
    bench.tail.tail = None;
    assert_eq!(bench.run(2 * MS), [], "it does not know where its tail is");
    assert_eq!((bench.state(), bench.endpoint.reference(bench.now)), (ModuleState::Boot, None));
    bench.tail = AT_ZERO;
    let said = bench.run(3 * MS);
    assert!(matches!(said[..], [Message::Hello(Hello { kind: ModuleKind::Modboat, session: 0, .. })]));
    assert!(bench.endpoint.link().is_some_and(|link| link.is_open()), "called at once");
    assert_eq!((bench.state(), bench.reference()), (ModuleState::Unsynchronised, Reference::at_rest(0.0)));
    let said = bench.run(4 * MS);
    let [Message::Telemetry(report), Message::Health(health)] = said[..] else { panic!("{said:?}") };
    assert_eq!((report.state, report.cycle, report.faults), (ModuleState::Unsynchronised, 0, Faults(0)));
    assert_eq!(health.incoming.accepted, 1, "the call");
    let said = bench.run(3_004 * MS);
    let count = |what: fn(&Message) -> bool| said.iter().filter(|message| what(message)).count();
    assert_eq!(count(|message| matches!(message, Message::Telemetry(_))), 150, "every 20 ms");
    let healths =
        |said: &[Message]| said.iter().filter(|message| matches!(message, Message::Health(_))).count();
    assert_eq!(
        healths(&said),
        11,
        "sure after 0.2 s; from a second later on five a second, as no cycle has come"
    );
    let session = bench.host.session().id();
    let hellos: Vec<_> = said.iter().filter(|message| matches!(message, Message::Hello(_))).collect();
    assert!((3..=4).contains(&hellos.len()), "{hellos:?}");
    assert!(hellos.iter().all(|hello| matches!(hello, Message::Hello(hello) if hello.session == session)));
    assert_eq!(bench.state(), ModuleState::Ready);
    // A cycle that has begun says that the host knows.
    assert_eq!(bench.ask(&direct(1, 4_000 * MS)), Verdict::Accepted);
    bench.run(4_100 * MS);
    assert!((2..=3).contains(&healths(&bench.run(7_000 * MS))), "every second");
}

#[test]
fn announces_itself_five_times_a_second_while_no_host_is_heard() {
    let mut endpoint = Bench::boot().endpoint;
    let mut buffer = [0; protocol::MAX_DATAGRAM];
    let mut said = 0;
    for now in (0..1_000 * MS).step_by(1_000).map(LocalInstant) {
        endpoint.handle_timer(now, &AT_ZERO);
        while let Some(datagram) = endpoint.poll_transmit(&mut buffer) {
            let header = protocol::Frame::parse(datagram).unwrap().header;
            assert_eq!((header.kind, header.sequence), (protocol::Kind::Announce, said));
            said += 1;
        }
    }
    assert_eq!((said, endpoint.link().unwrap().announced()), (5, 5), "nothing else without a session");
}

#[test]
fn takes_a_cycle_once_and_runs_it_on_fleet_time() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Accepted);
    bench.run(1_100 * MS);
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Duplicate);
    assert_eq!(bench.ask(&Message::Cycle(cycle(1, 2_000 * MS, 1.1))), refused(Refusal::Conflict));
    bench.run(1_999 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
    // 0.5 s of transition, half a period: φ₀ − A.
    bench.run(3_250 * MS);
    assert!((bench.reference().angle_rad + 2.0).abs() < 1e-4, "{:?}", bench.reference());
    let said = bench.run(4_001 * MS);
    assert_eq!(bench.state(), ModuleState::Holding);
    let runs = |message: &Message| {
        matches!(message, Message::Telemetry(report)
            if (report.state, report.cycle) == (ModuleState::Executing, 1))
    };
    assert!(said.iter().any(runs), "{said:?}");
    assert!(bench.is_frozen_at(0.0));
}

#[test]
fn refuses_what_it_must_not_run() {
    let mut bench = Bench::boot();
    bench.run(MS);
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), refused(Refusal::NotSynchronised));
    assert_eq!(bench.ask(&Message::Commit(1)), refused(Refusal::NotPrepared));
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 999 * MS)), refused(Refusal::Late));
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), refused(Refusal::Late), "a refusal is final");
    for (number, amplitude) in (2..).zip([3.0, 0.5, f32::NAN, f32::INFINITY]) {
        let asked = Message::Cycle(cycle(number, 2_000 * MS, amplitude));
        assert_eq!(bench.ask(&asked), refused(Refusal::BeyondLimits), "{amplitude}");
    }
    let mut elsewhere = cycle(6, 2_000 * MS, 1.0);
    if let Motion::Modboat(motion) = &mut elsewhere.motion {
        motion.rotation = Radians(0.5);
    }
    assert_eq!(bench.ask(&Message::Cycle(elsewhere)), refused(Refusal::PoseMismatch));
    let motion = Motion::Rov(RovCycle {
        thrusts: heapless::Vec::new(),
        lease: Duration(1),
        connectors: Connectors::Closed,
    });
    let rov = Message::Cycle(Cycle { motion, ..cycle(7, 2_000 * MS, 1.0) });
    assert_eq!(bench.ask(&rov), refused(Refusal::WrongKind));
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Ready, "nothing of that runs");
    let late = bench.host.session().outgoing().late;
    assert_eq!(late, 2, "the host learns from the receipts what came too late");
    // By now it is sure of the time for that long.
    bench.run(30_000 * MS);
    assert_eq!(bench.ask(&direct(8, 40_100 * MS)), refused(Refusal::TooFarAhead));
}

#[test]
fn what_is_not_for_it_changes_nothing() {
    let mut bench = Bench::ready();
    let before = std::format!("{:?} {:?}", bench.endpoint.robot, bench.endpoint.failsafe);
    let key = FleetKey::new([0x43; 32]);
    let strangers = [(crate::bench_host::fleet_key(), ModuleId(3)), (key, crate::bench_host::MODULE)];
    assert_eq!(bench.bring(b"noise"), Err(Class::Corrupt));
    for (key, module) in strangers {
        let boot = protocol::Nonce([1; 16]);
        let side = protocol::Side::Host;
        let mut other = protocol::Session::new(
            side,
            key.fleet(),
            module,
            &key.module(module),
            &boot,
            protocol::Nonce([9; 16]),
        );
        let mut buffer = [0; protocol::MAX_DATAGRAM];
        let stop = other.seal(&Message::EmergencyStop, &mut buffer).unwrap().to_vec();
        assert_eq!(bench.bring(&stop), Err(Class::Foreign));
    }
    // What modules say is not for modules.
    let mut buffer = [0; protocol::MAX_DATAGRAM];
    bench.endpoint.handle_timer(bench.now.after(KEEP_EVERY), &AT_ZERO);
    let mut own = Vec::new();
    while let Some(datagram) = bench.endpoint.poll_transmit(&mut buffer) {
        own.push(datagram.to_vec());
    }
    assert!(!own.is_empty());
    for datagram in &own {
        assert_eq!(bench.bring(datagram), Err(Class::Foreign), "its own words come back");
    }
    let incoming = bench.incoming();
    assert_eq!((incoming.corrupt, incoming.foreign, incoming.forged), (1, 2 + own.len() as u32, 0));
    assert_eq!(std::format!("{:?} {:?}", bench.endpoint.robot, bench.endpoint.failsafe), before);
}

#[test]
fn a_cycle_is_refused_while_the_time_at_its_start_is_unsure() {
    let mut bench = Bench::boot();
    let strict = Identity { sure_within: Duration(0), ..identity(1) };
    bench.endpoint = Endpoint::new(Some(strict), ModboatRobot::new(TailLimits::default()));
    bench.run(1_000 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), refused(Refusal::Unsure));
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
}

#[test]
fn a_cycle_is_dropped_at_the_gate_when_the_time_has_become_unsure() {
    for unsure in [false, true] {
        let mut bench = Bench::ready();
        assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Accepted);
        bench.run(1_900 * MS);
        bench.host.tells_time = false;
        if unsure {
            // The same time, from exchanges that took 100 ms: good to 50 ms.
            bench.endpoint.clock.reset();
            for k in 0..crate::link::clock::NEEDED as u64 {
                let sent = LocalInstant(1_000 * MS + k * 100 * MS);
                let host = FleetInstant(sent.0 + 50 * MS + AHEAD);
                let reply_received = LocalInstant(sent.0 + 100 * MS);
                let exchange =
                    Exchange { request_sent: sent, request_received: host, reply_sent: host, reply_received };
                assert!(bench.endpoint.clock.add(&exchange, false));
            }
            assert!(bench.endpoint.clock.is_synchronised());
        }
        bench.run(1_994 * MS);
        assert!(bench.endpoint.robot.waiting(bench.endpoint.fleet(bench.now)).is_some(), "until the gate");
        bench.run(2_010 * MS);
        let expected = if unsure { ModuleState::Ready } else { ModuleState::Executing };
        assert_eq!(bench.state(), expected);
        assert_eq!(bench.is_frozen_at(0.0), unsure || bench.reference().rate_rad_s == 0.0);
        bench.run(2_600 * MS);
        assert_eq!(bench.is_frozen_at(0.0), unsure);
    }
}
