//! The bytes of wire version 2, one file a datagram. A test that fails here means that modules in the field and a
//! host built from this tree no longer understand each other: bump the wire version instead.

use std::path::PathBuf;

use crate::common::{BOOT, HOST, MODULE, end, fleet_key, messages, open, pair, remade, seal};
use protocol::ledger::Class;
use protocol::session::{open_announcement, seal_stop};
use protocol::*;

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

/// The stored bytes; with `FLOTILLA_WRITE_GOLDEN` in the environment these are stored.
fn golden(name: &str, bytes: &[u8]) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/wire/v2").join(format!("{name}.hex"));
    if std::env::var_os("FLOTILLA_WRITE_GOLDEN").is_some() {
        std::fs::write(&path, hex(bytes) + "\n").expect("writable");
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert_eq!(hex(bytes), stored.trim(), "{name} changed on the wire");
    unhex(&stored)
}

/// Both ends after 300 datagrams each, of which every second came, some too late: two-byte numbers, full receipts.
fn talked() -> (Session, Session) {
    let (mut host, mut module) = pair();
    for k in 0..300 {
        let there = seal(&mut host, &Message::Hold);
        let back = seal(&mut module, &Message::TimeRequest(TimeRequest { sent: time::LocalInstant(k) }));
        if k % 2 == 0 {
            open(&mut module, &there).expect("accepted");
            open(&mut host, &back).expect("accepted");
        }
        if k % 50 == 0 {
            module.came_late();
        }
    }
    (host, module)
}

fn hello(session: u32) -> Message {
    Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: (0, 2, 0), session })
}

fn announcer() -> Announcer {
    let key = fleet_key();
    Announcer::new(key.fleet(), MODULE, &key.module(MODULE), BOOT)
}

/// Every datagram of a session, with its name, who reads it and what it says.
fn datagrams() -> Vec<(&'static str, Vec<u8>, Session, Message)> {
    let mut all = Vec::new();
    for (name, sender, message) in messages() {
        let (mut host, mut module) = talked();
        let (bytes, reader) = match sender {
            Side::Host => (seal(&mut host, &message), module),
            Side::Module => (seal(&mut module, &message), host),
        };
        all.push((name, bytes, reader, message));
    }
    let (mut host, module) = pair();
    let call = host.seal_call(&mut [0; MAX_DATAGRAM]).expect("fits").to_vec();
    all.push(("call", call, module, Message::Called));
    all
}

#[test]
fn every_message_has_its_bytes() {
    for (name, bytes, mut reader, message) in datagrams() {
        let stored = golden(name, &bytes);
        assert_eq!(
            open(&mut reader, &stored).map(|opened| opened.message),
            Ok(message),
            "{name} is read back"
        );
    }
}

#[test]
fn announcements_have_their_bytes() {
    let (mut announcer, mut buffer) = (announcer(), [0; MAX_DATAGRAM]);
    for (name, session) in [("announce", 0), ("announce-in-session", 0xC0FF_EE00)] {
        let stored = golden(name, announcer.seal(&hello(session), &mut buffer).expect("fits"));
        let frame = Frame::parse(&stored).expect("a datagram");
        assert_eq!(open_announcement(&fleet_key().module(MODULE), &frame), Ok(hello(session)), "{name}");
    }
    assert_eq!(announcer.sent(), 2);
}

/// A host's stop of a module that it is in no session with.
#[test]
fn a_stop_has_its_bytes() {
    let key = fleet_key();
    let module = key.module(MODULE);
    let mut buffer = [0; MAX_DATAGRAM];
    let stored = golden("stop", seal_stop(key.fleet(), MODULE, &module, BOOT, &mut buffer).expect("fits"));
    let (announcer, frame) = (announcer(), Frame::parse(&stored).expect("a datagram"));
    assert_eq!(announcer.open_stop(&frame), Ok(()));
    assert_eq!(open_announcement(&module, &frame), Err(Class::Foreign));
    let (mut host, mut module) = pair();
    assert_eq!(module.open(&frame), Err(Class::Stale), "of no session");
    assert_eq!(host.open(&frame), Err(Class::Foreign));
    // No bit of it may differ.
    for bit in 0..(stored.len() - frame::CHECKSUM) * 8 {
        let mut bad = stored.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        let bad = remade(&bad);
        let class =
            Frame::parse(&bad).map_err(|_| Class::Corrupt).and_then(|frame| announcer.open_stop(&frame));
        let expected = match bit / 8 {
            0 | 1 => class == Err(Class::Corrupt) || class == Err(Class::Foreign),
            2..8 => class == Err(Class::Foreign),
            16..32 => class == Err(Class::Stale),
            _ => class == Err(Class::Forged),
        };
        assert!(expected, "bit {bit} flipped is {class:?}");
    }
    // What an announcement says is no stop, nor is what a host says in a session.
    let hello = self::announcer().seal(&hello(0), &mut buffer).expect("fits").to_vec();
    assert_eq!(announcer.open_stop(&Frame::parse(&hello).expect("a datagram")), Err(Class::Foreign));
    let said = seal(&mut host, &Message::EmergencyStop);
    assert_eq!(announcer.open_stop(&Frame::parse(&said).expect("a datagram")), Err(Class::Foreign));
}

/// Postcard writes the place of a variant in its list: they are in this order for good.
#[test]
fn every_variant_has_its_number() {
    fn numbered<T: serde::Serialize + std::fmt::Debug>(variants: impl IntoIterator<Item = T>) {
        for (number, variant) in (0_u8..).zip(variants) {
            let mut buffer = [0; 8];
            let bytes = postcard::to_slice(&variant, &mut buffer).expect("fits");
            assert_eq!(bytes.first(), Some(&number), "{variant:?}");
        }
    }
    numbered([ModuleKind::Modboat, ModuleKind::Rov]);
    numbered([Delivery::Direct, Delivery::Prepare]);
    numbered([Verdict::Accepted, Verdict::Duplicate, Verdict::Refused(Refusal::Late), Verdict::Prepared]);
    numbered([
        Refusal::Late,
        Refusal::TooFarAhead,
        Refusal::AlreadyRun,
        Refusal::Conflict,
        Refusal::PoseMismatch,
        Refusal::BeyondLimits,
        Refusal::NotSynchronised,
        Refusal::WrongKind,
        Refusal::Stopped,
        Refusal::Unsure,
        Refusal::LowBattery,
        Refusal::NotPrepared,
    ]);
    numbered([
        ModuleState::Unsynchronised,
        ModuleState::Ready,
        ModuleState::Executing,
        ModuleState::Holding,
        ModuleState::Stopped,
        ModuleState::Arming,
        ModuleState::Boot,
        ModuleState::Unprovisioned,
    ]);
    let bits = Faults::NAMES.map(|(fault, _)| fault.0);
    assert_eq!(
        bits,
        [1, 2, 4, 8, 16, 32, 64, 128],
        "emergency, low battery, stalled, blind, output, following, wrong way, index"
    );
}

#[test]
fn damage_on_the_way_is_corrupt() {
    for (name, good, mut reader, message) in datagrams() {
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(open(&mut reader, &bad), Err(Class::Corrupt), "{name} with bit {bit} flipped");
        }
        for length in 0..good.len() {
            assert_eq!(
                open(&mut reader, &good[..length]),
                Err(Class::Corrupt),
                "{name} cut to {length} bytes"
            );
        }
        let longer = [good.as_slice(), &[0]].concat();
        assert_eq!(open(&mut reader, &longer), Err(Class::Corrupt), "{name} with a byte too many");
        assert_eq!(open(&mut reader, &good).map(|opened| opened.message), Ok(message), "nothing has changed");
    }
}

/// From a sender that can make a checksum, but has no key.
#[test]
fn a_changed_bit_under_a_right_checksum_is_seen_for_what_it_is() {
    for (name, good, mut reader, message) in datagrams() {
        for bit in 0..(good.len() - frame::CHECKSUM) * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            let class = open(&mut reader, &remade(&bad)).expect_err(name);
            let expected: &[Class] = match bit / 8 {
                0 => &[Class::Corrupt],
                // Another kind: unknown, too short for it, for the other side, or with another nonce.
                1 => &[Class::Corrupt, Class::Foreign, Class::Forged],
                2..8 => &[Class::Foreign],
                8..12 => &[Class::Stale],
                _ => &[Class::Forged],
            };
            assert!(expected.contains(&class), "{name} with bit {bit} flipped is {class:?}");
        }
        for length in 0..good.len() - frame::CHECKSUM {
            let class = open(&mut reader, &remade(&[&good[..length], &[0; 4]].concat())).expect_err(name);
            assert!(matches!(class, Class::Corrupt | Class::Forged), "{name} cut to {length}: {class:?}");
        }
        assert_eq!(open(&mut reader, &good).map(|opened| opened.message), Ok(message), "nothing has changed");
    }
}

#[test]
fn a_changed_announcement_is_rejected() {
    let key = fleet_key().module(MODULE);
    let good = announcer().seal(&hello(0), &mut [0; MAX_DATAGRAM]).expect("fits").to_vec();
    for bit in 0..(good.len() - frame::CHECKSUM) * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Frame::parse(&bad), Err(FrameError::Checksum));
        let bad = remade(&bad);
        let class = Frame::parse(&bad).map_err(|_| Class::Corrupt).and_then(|f| open_announcement(&key, &f));
        let class = class.expect_err("another announcement");
        let expected = match bit / 8 {
            0 | 1 => matches!(class, Class::Corrupt | Class::Foreign),
            _ => class == Class::Forged,
        };
        assert!(expected, "bit {bit} flipped is {class:?}");
    }
}

#[test]
fn a_datagram_is_little_longer_than_what_it_says() {
    for (name, bytes, _, message) in datagrams() {
        let mut buffer = [0; MAX_DATAGRAM];
        let plain = postcard::to_slice(&message, &mut buffer).expect("fits").len();
        assert!(bytes.len() <= plain + 64, "{name}: {} bytes for {plain}", bytes.len());
        println!("{name}: {} bytes, {plain} of them the message", bytes.len());
    }
}

#[test]
fn each_fault_has_its_name() {
    let (mut host, _) = pair();
    let good = seal(&mut host, &Message::Hold);
    let with = |index: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[index] = value;
        remade(&bytes)
    };
    assert_eq!(Frame::parse(&with(0, 1)), Err(FrameError::Version(1)));
    assert_eq!(Frame::parse(&with(1, 0)), Err(FrameError::Kind(0)));
    assert_eq!(Frame::parse(&[0; MAX_DATAGRAM + 1]), Err(FrameError::Length(MAX_DATAGRAM + 1)));
    assert_eq!(Frame::parse(&[]), Err(FrameError::Length(0)));
    let (mut host, mut module) = (end(Side::Host, &BOOT, HOST), end(Side::Module, &BOOT, HOST));
    for have in 0..good.len() {
        let mut tiny = vec![0; have];
        assert_eq!(host.seal(&Message::Hold, &mut tiny), Err(EncodeError::BufferTooSmall { have }));
    }
    assert_eq!(host.outgoing().sent, 0, "no number is used up");
    assert_eq!(seal(&mut host, &Message::Hold), good);
    assert!(open(&mut module, &good).is_ok());
}
