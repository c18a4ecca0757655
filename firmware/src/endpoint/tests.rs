use protocol::units::{Amperes, Radians, RadiansPerSecond, Volts};
use protocol::{ModboatCycle, Motion};

use super::*;
use crate::limits::Limits;
use crate::reference::Reference;
use crate::swimmer::{Measurement, Swimmer};

const HOST: u32 = 77;
const IDENTITY: Identity = Identity { module: ModuleId(2), session: 5, report_every: MicrosSpan(20_000) };
const AT_ZERO: Measurement = Measurement {
    tail: Some(Radians(0.0)),
    rate: RadiansPerSecond(0.0),
    current: Amperes(0.0),
    battery: Volts(7.4),
};

fn from_host(session: u32, message: &Message) -> std::vec::Vec<u8> {
    let mut buffer = [0; protocol::MAX_DATAGRAM];
    let header = Header { module: IDENTITY.module, session, sequence: 0 };
    encode(&header, message, &mut buffer).unwrap().to_vec()
}

fn sent(endpoint: &mut Endpoint<Swimmer>) -> std::vec::Vec<Message> {
    let mut buffer = [0; protocol::MAX_DATAGRAM];
    let mut messages = std::vec::Vec::new();
    while let Some(datagram) = endpoint.poll_transmit(&mut buffer) {
        messages.push(decode(datagram).unwrap().1);
    }
    messages
}

/// Booted, its clock 1 s behind the fleet's, exchanges done by `now` = 0.2 s.
fn synchronised() -> Endpoint<Swimmer> {
    let mut endpoint = Endpoint::new(IDENTITY, Swimmer::new(Limits::default()));
    for exchange in 0..4 {
        let now = Micros(exchange * 50_000);
        endpoint.handle_timer(now, &AT_ZERO);
        let fleet = now.after(MicrosSpan(1_000_000));
        let reply = TimeReply { request_sent: now, received: fleet, sent: fleet };
        endpoint.handle_datagram(now, &from_host(HOST, &Message::TimeReply(reply))).unwrap();
    }
    sent(&mut endpoint);
    endpoint
}

fn cycle(number: u32, start: u64, amplitude: f32) -> Message {
    let motion = ModboatCycle {
        rotation: Radians(0.0),
        centerline: Radians(-amplitude),
        amplitude: Radians(amplitude),
        transition: MicrosSpan(500_000),
        period: MicrosSpan(1_500_000),
    };
    Message::Cycle(Cycle { number, start: Micros(start), motion: Motion::Modboat(motion) })
}

fn answer(endpoint: &mut Endpoint<Swimmer>, now: u64, message: &Message) -> Verdict {
    endpoint.handle_datagram(Micros(now), &from_host(HOST, message)).unwrap();
    match sent(endpoint).as_slice() {
        [Message::Acknowledge(acknowledge)] => acknowledge.verdict,
        other => panic!("{other:?}"),
    }
}

#[test]
fn announces_itself_asks_the_time_and_reports() {
    let mut endpoint = Endpoint::new(IDENTITY, Swimmer::new(Limits::default()));
    endpoint.handle_timer(Micros(0), &Measurement::default());
    assert!(matches!(sent(&mut endpoint)[..], [Message::Hello(_), Message::TimeRequest(_)]));
    assert_eq!(endpoint.reference(Micros(0)), None, "nobody knows where the tail is");
    endpoint.handle_timer(Micros(1_000), &AT_ZERO);
    let [Message::Telemetry(report)] = sent(&mut endpoint)[..] else { panic!("a report is due") };
    assert_eq!((report.state, report.cycle), (ModuleState::Unsynchronised, 0));
    assert_eq!(endpoint.reference(Micros(1_000)), Some(Reference::at_rest(0.0)));
    endpoint.handle_timer(Micros(199_000), &AT_ZERO);
    assert!(!sent(&mut endpoint).iter().any(|message| matches!(message, Message::Hello(_))));
    endpoint.handle_timer(Micros(200_000), &AT_ZERO);
    assert!(sent(&mut endpoint).iter().any(|message| matches!(message, Message::Hello(_))));
}

#[test]
fn takes_a_cycle_once_and_runs_it_on_fleet_time() {
    let mut endpoint = synchronised();
    assert_eq!(endpoint.state(Micros(200_000)), ModuleState::Ready);
    let message = cycle(1, 2_000_000, 1.0);
    assert_eq!(answer(&mut endpoint, 200_000, &message), Verdict::Accepted);
    assert_eq!(answer(&mut endpoint, 300_000, &message), Verdict::Duplicate);
    assert_eq!(
        answer(&mut endpoint, 300_000, &cycle(1, 2_000_000, 1.1)),
        Verdict::Refused(Refusal::Conflict)
    );
    // Fleet time 2 s is 1 s on its own clock.
    assert_eq!(endpoint.state(Micros(999_999)), ModuleState::Ready);
    assert_eq!(endpoint.state(Micros(1_000_000)), ModuleState::Executing);
    // 0.5 s of transition, half a period: φ₀ − A.
    let reference = endpoint.reference(Micros(2_250_000)).unwrap();
    assert!((reference.angle_rad + 2.0).abs() < 1e-5, "{reference:?}");
    assert_eq!(endpoint.state(Micros(3_000_000)), ModuleState::Holding);
    endpoint.handle_timer(Micros(3_000_000), &AT_ZERO);
    assert!(sent(&mut endpoint).iter().any(|m| matches!(m, Message::Telemetry(report) if report.cycle == 1)));
}

#[test]
fn refuses_what_it_must_not_run() {
    let mut endpoint = Endpoint::new(IDENTITY, Swimmer::new(Limits::default()));
    endpoint.handle_timer(Micros(0), &AT_ZERO);
    sent(&mut endpoint);
    let refusal = |verdict| Verdict::Refused(verdict);
    assert_eq!(answer(&mut endpoint, 0, &cycle(1, 1, 1.0)), refusal(Refusal::NotSynchronised));
    let mut endpoint = synchronised();
    assert_eq!(answer(&mut endpoint, 200_000, &cycle(1, 1_199_999, 1.0)), refusal(Refusal::Late));
    assert_eq!(answer(&mut endpoint, 200_000, &cycle(1, 3_601_000_000, 1.0)), refusal(Refusal::TooFarAhead));
    assert_eq!(answer(&mut endpoint, 200_000, &cycle(1, 2_000_000, 3.0)), refusal(Refusal::BeyondLimits));
    assert_eq!(
        answer(&mut endpoint, 200_000, &cycle(1, 2_000_000, f32::NAN)),
        refusal(Refusal::BeyondLimits)
    );
    let mut elsewhere = cycle(1, 2_000_000, 1.0);
    if let Message::Cycle(Cycle { motion: Motion::Modboat(motion), .. }) = &mut elsewhere {
        motion.rotation = Radians(0.5);
    }
    assert_eq!(answer(&mut endpoint, 200_000, &elsewhere), refusal(Refusal::PoseMismatch));
    let rov = Motion::Rov(protocol::RovCycle { thrusts: heapless::Vec::new(), lease: MicrosSpan(1) });
    let rov = Message::Cycle(Cycle { number: 1, start: Micros(2_000_000), motion: rov });
    assert_eq!(answer(&mut endpoint, 200_000, &rov), refusal(Refusal::WrongKind));
    assert_eq!(endpoint.state(Micros(2_000_000)), ModuleState::Ready, "nothing of that runs");
}

#[test]
fn an_emergency_stop_latches() {
    let mut endpoint = synchronised();
    assert_eq!(answer(&mut endpoint, 200_000, &cycle(1, 2_000_000, 1.0)), Verdict::Accepted);
    endpoint.handle_datagram(Micros(1_700_000), &from_host(HOST, &Message::EmergencyStop)).unwrap();
    let frozen = endpoint.reference(Micros(1_700_000)).unwrap();
    assert_eq!(endpoint.reference(Micros(9_000_000)).unwrap(), frozen);
    assert_eq!(endpoint.state(Micros(9_000_000)), ModuleState::Stopped);
    let verdict = answer(&mut endpoint, 2_000_000, &cycle(2, 4_000_000, 1.0));
    assert_eq!(verdict, Verdict::Refused(Refusal::Stopped));
}

#[test]
fn a_new_host_is_heard_after_the_running_cycle() {
    let mut endpoint = synchronised();
    assert_eq!(answer(&mut endpoint, 200_000, &cycle(9, 2_000_000, 1.0)), Verdict::Accepted);
    let new_host = from_host(HOST + 1, &Message::EmergencyStop);
    endpoint.handle_datagram(Micros(1_500_000), &new_host).unwrap();
    assert_eq!(endpoint.ignored().early, 1);
    assert_eq!(endpoint.state(Micros(1_500_000)), ModuleState::Executing);
    endpoint.handle_datagram(Micros(3_000_000), &from_host(HOST + 1, &Message::Hold)).unwrap();
    assert_eq!(endpoint.state(Micros(3_000_000)), ModuleState::Unsynchronised, "its time begins anew");
    assert!(endpoint.reference(Micros(3_000_000)).unwrap().angle_rad.abs() < 1e-6, "the pose is held");
}

#[test]
fn what_comes_late_changes_nothing() {
    let mut endpoint = synchronised();
    let numbered = |session, sequence, message: &Message| {
        let mut buffer = [0; protocol::MAX_DATAGRAM];
        let header = Header { module: IDENTITY.module, session, sequence };
        encode(&header, message, &mut buffer).unwrap().to_vec()
    };
    let now = Micros(200_000);
    endpoint.handle_datagram(now, &numbered(HOST, 11, &cycle(1, 2_000_000, 1.0))).unwrap();
    endpoint.handle_datagram(now, &numbered(HOST, 10, &Message::Hold)).unwrap();
    assert_eq!(endpoint.ignored().stale, 1);
    assert_eq!(endpoint.state(Micros(1_000_000)), ModuleState::Executing, "the hold was older");
    // Another host, and a datagram of the one before that took its time.
    let later = Micros(4_000_000);
    endpoint.handle_datagram(later, &numbered(HOST + 1, 0, &Message::Hold)).unwrap();
    endpoint.handle_datagram(later, &numbered(HOST, 12, &Message::EmergencyStop)).unwrap();
    assert_eq!(endpoint.ignored().stale, 2);
    assert_ne!(endpoint.state(later), ModuleState::Stopped);
}

#[test]
fn what_is_not_for_it_changes_nothing() {
    let mut endpoint = synchronised();
    assert!(endpoint.handle_datagram(Micros(1), b"noise").is_err());
    let mut buffer = [0; protocol::MAX_DATAGRAM];
    let header = Header { module: ModuleId(3), session: HOST, sequence: 0 };
    let foreign = encode(&header, &Message::EmergencyStop, &mut buffer).unwrap();
    endpoint.handle_datagram(Micros(1), foreign).unwrap();
    assert_eq!(endpoint.ignored(), Ignored { damaged: 1, foreign: 1, early: 0, stale: 0 });
    assert_eq!(endpoint.state(Micros(1)), ModuleState::Ready);
}
