//! The bytes of wire version 1, one file a message. A test that fails here means that modules in the field and a
//! host built from this tree no longer understand each other: bump the wire version instead.

use std::path::PathBuf;

use protocol::units::{Amperes, Micros, MicrosSpan, Newtons, PulseMicros, Radians, RadiansPerSecond, Volts};
use protocol::*;

fn messages() -> Vec<(&'static str, Message)> {
    let start = Micros(12_345_678);
    let thrusts = [1.5, -2.25, 0.0, 40.0, -39.9, 0.125, 7.0, -0.5];
    let pulses = [1545.5, 1440.25, 1500.0, 1830.0, 1100.0, 1528.125, 1612.75, 1471.5];
    vec![
        ("hello", Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: (0, 1, 0) })),
        ("time-request", Message::TimeRequest(TimeRequest { sent: Micros(1_000_001) })),
        (
            "time-reply",
            Message::TimeReply(TimeReply {
                request_sent: Micros(1_000_001),
                received: Micros(77_000_000_123),
                sent: Micros(77_000_000_456),
            }),
        ),
        (
            "cycle-modboat",
            Message::Cycle(Cycle {
                number: 42,
                start,
                motion: Motion::Modboat(ModboatCycle {
                    rotation: Radians(-1.25),
                    centerline: Radians(0.5),
                    amplitude: Radians(-2.6),
                    transition: MicrosSpan(500_000),
                    period: MicrosSpan(1_500_000),
                }),
            }),
        ),
        (
            "cycle-rov",
            Message::Cycle(Cycle {
                number: 43,
                start,
                motion: Motion::Rov(RovCycle {
                    thrusts: thrusts.into_iter().map(Newtons).collect(),
                    lease: MicrosSpan(200_000),
                }),
            }),
        ),
        ("acknowledge-accepted", Message::Acknowledge(Acknowledge { cycle: 42, verdict: Verdict::Accepted })),
        (
            "acknowledge-refused",
            Message::Acknowledge(Acknowledge { cycle: 42, verdict: Verdict::Refused(Refusal::PoseMismatch) }),
        ),
        (
            "telemetry",
            Message::Telemetry(Telemetry {
                at: start,
                state: ModuleState::Executing,
                cycle: 42,
                tail: Radians(-3.5),
                rate: RadiansPerSecond(10.75),
                current: Amperes(0.25),
                battery: Volts(7.4),
            }),
        ),
        ("hold", Message::Hold),
        ("emergency-stop", Message::EmergencyStop),
        (
            "rov-telemetry",
            Message::RovTelemetry(RovTelemetry {
                at: start,
                state: ModuleState::Executing,
                cycle: 43,
                pulses: pulses.into_iter().map(PulseMicros).collect(),
                battery: Volts(15.75),
                current: Amperes(24.5),
            }),
        ),
    ]
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text.trim().bytes().collect();
    digits
        .chunks(2)
        .map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).expect("two hex digits"))
        .collect()
}

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/wire/v1").join(format!("{name}.hex"))
}

#[test]
fn every_message_has_its_bytes() {
    let header = Header { module: ModuleId(3), session: 0xC0FF_EE00, sequence: 300 };
    for (name, message) in messages() {
        let mut buffer = [0; MAX_DATAGRAM];
        let bytes = encode(&header, &message, &mut buffer).expect("fits").to_vec();
        let path = golden(name);
        if std::env::var_os("FLOTILLA_WRITE_GOLDEN").is_some() {
            std::fs::write(&path, hex(&bytes) + "\n").expect("writable");
        }
        let stored =
            std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert_eq!(hex(&bytes), stored.trim(), "{name} changed on the wire");
        assert_eq!(decode(&unhex(&stored)), Ok((header, message)), "{name} is read back");
        assert!(bytes.len() + 16 <= MAX_DATAGRAM, "{name} leaves room for an authentication tag");
    }
}

#[test]
fn every_damaged_bit_is_noticed() {
    for (name, _) in messages() {
        let good = unhex(&std::fs::read_to_string(golden(name)).expect("golden file"));
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(decode(&bad).is_err(), "{name} with bit {bit} flipped was accepted");
        }
        for length in 0..good.len() {
            assert!(decode(&good[..length]).is_err(), "{name} cut to {length} bytes was accepted");
        }
        let mut longer = good.clone();
        longer.push(0);
        assert!(decode(&longer).is_err(), "{name} with a byte too many was accepted");
    }
}

#[test]
fn each_fault_has_its_name() {
    let good = unhex(&std::fs::read_to_string(golden("hold")).expect("golden file"));
    let with = |index: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[index] = value;
        decode(&bytes)
    };
    assert_eq!(with(0, 2), Err(DecodeError::Version(2)));
    assert_eq!(with(1, Seal::Authenticated as u8), Err(DecodeError::Seal(1)));
    assert_eq!(with(2, good[2] ^ 1), Err(DecodeError::Checksum));
    assert_eq!(decode(&[0; MAX_DATAGRAM + 1]), Err(DecodeError::Length(MAX_DATAGRAM + 1)));
    assert_eq!(decode(&[]), Err(DecodeError::Length(0)));
    let mut tiny = [0; 5];
    assert_eq!(
        encode(&Header { module: ModuleId(1), session: 0, sequence: 0 }, &Message::Hold, &mut tiny),
        Err(EncodeError::BufferTooSmall { have: 5 })
    );
}
