//! Decoding and encoding under arbitrary input. The fuzz target in `protocol/fuzz` does the same with coverage
//! guidance; its corpus is replayed here, so that a finding stays found.

use proptest::prelude::*;
use protocol::units::{Amperes, Micros, MicrosSpan, Newtons, PulseMicros, Radians, Volts};
use protocol::*;

/// Whatever decodes must encode again to something that decodes to the same.
fn round_trip(datagram: &[u8]) {
    if let Ok((header, message)) = decode(datagram) {
        let mut buffer = [0; MAX_DATAGRAM];
        let again = encode(&header, &message, &mut buffer).expect("what was read fits");
        // NaN is not equal to itself: compare the text.
        assert_eq!(format!("{:?}", decode(again)), format!("{:?}", Ok::<_, DecodeError>((header, message))));
    }
}

/// Puts a right version, seal and checksum around any body, so that the postcard decoder is reached.
fn dressed(body: &[u8]) -> Vec<u8> {
    let mut datagram = vec![WIRE_VERSION, Seal::Checksum as u8];
    datagram.extend_from_slice(body);
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&datagram);
    datagram.extend_from_slice(&checksum.to_le_bytes());
    datagram
}

#[test]
fn the_corpus_is_replayed() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus/decode");
    let mut replayed = 0;
    for entry in std::fs::read_dir(corpus).expect("the corpus is checked in") {
        let bytes = std::fs::read(entry.expect("readable").path()).expect("readable");
        round_trip(&bytes);
        round_trip(&dressed(&bytes));
        replayed += 1;
    }
    assert!(replayed >= 10, "only {replayed} files in {corpus}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        round_trip(&bytes);
        round_trip(&dressed(&bytes));
    }

    #[test]
    fn modboat_cycles_survive(
        module: u16, session: u32, sequence: u32, number: u32, start: u64,
        rotation: f32, centerline: f32, amplitude: f32, transition: u32, period: u32,
    ) {
        let header = Header { module: ModuleId(module), session, sequence };
        let motion = Motion::Modboat(ModboatCycle {
            rotation: Radians(rotation),
            centerline: Radians(centerline),
            amplitude: Radians(amplitude),
            transition: MicrosSpan(transition),
            period: MicrosSpan(period),
        });
        let message = Message::Cycle(Cycle { number, start: Micros(start), motion });
        let mut buffer = [0; MAX_DATAGRAM];
        let datagram = encode(&header, &message, &mut buffer).expect("fits");
        prop_assert!(datagram.len() + 16 <= MAX_DATAGRAM);
        prop_assert_eq!(format!("{:?}", decode(datagram)), format!("{:?}", Ok::<_, DecodeError>((header, message))));
    }

    #[test]
    fn rov_cycles_survive(number: u32, start: u64, lease: u32, thrusts in prop::collection::vec(-60f32..60.0, 0..=8)) {
        let header = Header { module: ModuleId(9), session: 1, sequence: 2 };
        let motion = Motion::Rov(RovCycle {
            thrusts: thrusts.into_iter().map(Newtons).collect(),
            lease: MicrosSpan(lease),
        });
        let message = Message::Cycle(Cycle { number, start: Micros(start), motion });
        let mut buffer = [0; MAX_DATAGRAM];
        let datagram = encode(&header, &message, &mut buffer).expect("fits");
        prop_assert_eq!(decode(datagram), Ok((header, message)));
    }

    #[test]
    fn rov_reports_survive(
        sequence: u32, at: u64, cycle: u32, battery: f32, current: f32,
        pulses in prop::collection::vec(any::<f32>(), 0..=8),
    ) {
        let header = Header { module: ModuleId(9), session: 1, sequence };
        let message = Message::RovTelemetry(RovTelemetry {
            at: Micros(at),
            state: ModuleState::Executing,
            cycle,
            pulses: pulses.into_iter().map(PulseMicros).collect(),
            battery: Volts(battery),
            current: Amperes(current),
        });
        let mut buffer = [0; MAX_DATAGRAM];
        let datagram = encode(&header, &message, &mut buffer).expect("fits");
        prop_assert!(datagram.len() + 16 <= MAX_DATAGRAM);
        prop_assert_eq!(format!("{:?}", decode(datagram)), format!("{:?}", Ok::<_, DecodeError>((header, message))));
    }
}
