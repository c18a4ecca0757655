//! What several tests of this crate share: one fleet, one module, one session, and every message.

use protocol::ledger::Incoming;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::{Amperes, Newtons, PulseMicros, Radians, RadiansPerSecond, Volts};
use protocol::*;

/// Key of the fleet: 00 01 … 1f.
pub fn fleet_key() -> FleetKey {
    let mut bytes = [0; 32];
    bytes.iter_mut().zip(0..).for_each(|(byte, k)| *byte = k);
    FleetKey::new(bytes)
}

/// The module.
pub const MODULE: ModuleId = ModuleId(3);

/// Nonce of its boot: a0 a1 … af.
pub const BOOT: Nonce = nonce(0xA0);
/// Nonce of the host: c0 c1 … cf.
pub const HOST: Nonce = nonce(0xC0);

/// Sixteen bytes that count from `first`.
pub const fn nonce(first: u8) -> Nonce {
    let mut bytes = [first; 16];
    let mut k = 0;
    while k < 16 {
        bytes[k] += k as u8;
        k += 1;
    }
    Nonce(bytes)
}

/// One end of the session that two nonces make.
pub fn end(side: Side, boot: &Nonce, host: Nonce) -> Session {
    let key = fleet_key();
    Session::new(side, key.fleet(), MODULE, &key.module(MODULE), boot, host)
}

/// Both ends of the session: the host's and the module's.
pub fn pair() -> (Session, Session) {
    (end(Side::Host, &BOOT, HOST), end(Side::Module, &BOOT, HOST))
}

/// The next datagram of `session` with that message.
pub fn seal(session: &mut Session, message: &Message) -> Vec<u8> {
    session.seal(message, &mut [0; MAX_DATAGRAM]).expect("fits").to_vec()
}

/// What `session` makes of a datagram.
pub fn open(session: &mut Session, datagram: &[u8]) -> Result<session::Opened, ledger::Class> {
    session.open(&Frame::parse(datagram).map_err(|_| ledger::Class::Corrupt)?)
}

/// The datagram with a right checksum.
pub fn remade(datagram: &[u8]) -> Vec<u8> {
    let guarded = &datagram[..datagram.len() - frame::CHECKSUM];
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(guarded);
    [guarded, &checksum.to_le_bytes()].concat()
}

/// Every message that is said within a session, with its name and who says it.
pub fn messages() -> Vec<(&'static str, Side, Message)> {
    let at = FleetInstant(12_345_678);
    let to_module = [
        ("time-reply", time_reply()),
        ("cycle-modboat", cycle(42, Motion::Modboat(modboat()), Delivery::Direct)),
        ("cycle-modboat-prepare", cycle(42, Motion::Modboat(modboat()), Delivery::Prepare)),
        ("cycle-modboat-rest-to-rest", cycle(42, Motion::Modboat(rest_to_rest()), Delivery::Direct)),
        ("cycle-rov", cycle(43, Motion::Rov(rov()), Delivery::Direct)),
        ("cycle-rov-connectors-open", cycle(43, Motion::Rov(undocking()), Delivery::Direct)),
        ("commit", Message::Commit(42)),
        ("hold", Message::Hold),
        ("emergency-stop", Message::EmergencyStop),
        ("release", Message::Release),
    ];
    let to_host = [
        ("time-request", Message::TimeRequest(TimeRequest { sent: LocalInstant(1_000_001) })),
        ("acknowledge-accepted", acknowledge(Verdict::Accepted)),
        ("acknowledge-duplicate", acknowledge(Verdict::Duplicate)),
        ("acknowledge-refused", acknowledge(Verdict::Refused(Refusal::PoseMismatch))),
        ("acknowledge-prepared", acknowledge(Verdict::Prepared)),
        ("telemetry", telemetry(at)),
        ("telemetry-stopped", stopped(at)),
        ("rov-telemetry", rov_telemetry(at)),
        ("tail-unknown", tail_unknown(at)),
        ("health", health()),
    ];
    let to_module = to_module.into_iter().map(|(name, message)| (name, Side::Host, message));
    to_module.chain(to_host.into_iter().map(|(name, message)| (name, Side::Module, message))).collect()
}

fn cycle(number: u32, motion: Motion, delivery: Delivery) -> Message {
    Message::Cycle(Cycle { number, start: FleetInstant(12_345_678), motion, delivery })
}

fn modboat() -> ModboatCycle {
    ModboatCycle {
        rotation: Radians(-1.25),
        centerline: Radians(0.5),
        amplitude: Radians(-2.6),
        transition: Duration(500_000),
        period: Duration(1_500_000),
        law: TransitionLaw::ConstantSpeed,
    }
}

fn rest_to_rest() -> ModboatCycle {
    ModboatCycle { law: TransitionLaw::RestToRest { ramp: Duration(52_000) }, ..modboat() }
}

fn rov() -> RovCycle {
    let thrusts = [1.5, -2.25, 0.0, 40.0, -39.9, 0.125, 7.0, -0.5];
    RovCycle {
        thrusts: thrusts.into_iter().map(Newtons).collect(),
        lease: Duration(200_000),
        connectors: Connectors::Closed,
    }
}

fn undocking() -> RovCycle {
    RovCycle { connectors: Connectors::Open, ..rov() }
}

fn acknowledge(verdict: Verdict) -> Message {
    Message::Acknowledge(Acknowledge { cycle: 42, verdict })
}

fn time_reply() -> Message {
    Message::TimeReply(TimeReply {
        request_sent: LocalInstant(1_000_001),
        received: FleetInstant(77_000_000_123),
        sent: FleetInstant(77_000_000_456),
    })
}

fn telemetry(at: FleetInstant) -> Message {
    Message::Telemetry(Telemetry {
        at,
        state: ModuleState::Executing,
        cycle: 42,
        tail: Radians(-3.5),
        rate: RadiansPerSecond(10.75),
        current: Amperes(0.25),
        battery: Volts(7.4),
        faults: Faults::LOW_BATTERY,
    })
}

fn tail_unknown(at: FleetInstant) -> Message {
    Message::TailUnknown(TailUnknown {
        at,
        state: ModuleState::Stopped,
        cycle: 42,
        battery: Volts(7.25),
        faults: Faults::BLIND,
    })
}

/// With the faults that came after the first five.
fn stopped(at: FleetInstant) -> Message {
    Message::Telemetry(Telemetry {
        at,
        state: ModuleState::Stopped,
        cycle: 42,
        tail: Radians(0.75),
        rate: RadiansPerSecond(0.0),
        current: Amperes(0.0),
        battery: Volts(7.25),
        faults: Faults::FOLLOWING.with(Faults::WRONG_WAY).with(Faults::INDEX),
    })
}

fn rov_telemetry(at: FleetInstant) -> Message {
    let pulses = [1545.5, 1440.25, 1500.0, 1830.0, 1100.0, 1528.125, 1612.75, 1471.5];
    Message::RovTelemetry(RovTelemetry {
        at,
        state: ModuleState::Stopped,
        cycle: 43,
        pulses: pulses.into_iter().map(PulseMicros).collect(),
        battery: Volts(15.75),
        current: Amperes(24.5),
        faults: Faults(0b1_1111),
    })
}

fn health() -> Message {
    let incoming = Incoming {
        received: 1006,
        accepted: 1000,
        duplicate: 3,
        stale: 1,
        corrupt: 1,
        forged: 0,
        foreign: 1,
    };
    Message::Health(Health { incoming, uncertainty: Duration(340), drift_ppb: -31_250 })
}
