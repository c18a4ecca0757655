//! Arbitrary input on every way in. The fuzz target in `protocol/fuzz` asks the same with coverage guidance; its corpus
//! is replayed here, so that a finding stays found.

#[path = "../../fuzz/src/lib.rs"]
mod fuzz;

use crate::common::{messages, open, pair, remade, seal};
use proptest::prelude::*;
use protocol::time::{Duration, FleetInstant};
use protocol::units::{Amperes, Newtons, PulseMicros, Radians, Volts};
use protocol::*;

#[test]
fn the_corpus_is_replayed() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus/decode");
    if std::env::var_os("FLOTILLA_WRITE_CORPUS").is_some() {
        for (name, _, message) in messages() {
            let plain = [vec![0; 3], postcard::to_slice(&message, &mut [0; MAX_DATAGRAM]).unwrap().to_vec()];
            std::fs::write(format!("{corpus}/{name}"), plain.concat()).expect("writable");
        }
    }
    let mut replayed = 0;
    for entry in std::fs::read_dir(corpus).expect("the corpus is checked in") {
        let bytes = std::fs::read(entry.expect("readable").path()).expect("readable");
        fuzz::decode(&bytes);
        replayed += 1;
    }
    assert!(replayed >= 24, "only {replayed} files in {corpus}");
}

/// What comes back of a message that was sent, by the text: NaN is not equal to itself.
fn told(message: &Message, side: Side) -> (String, usize) {
    let (mut host, mut module) = pair();
    let (from, to) = if side == Side::Host { (&mut host, &mut module) } else { (&mut module, &mut host) };
    let datagram = seal(from, message);
    let again = open(to, &remade(&datagram)).expect("accepted").message;
    (format!("{again:?}"), datagram.len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        fuzz::decode(&bytes);
    }

    /// Few bytes that are nearly a message: the variants, then anything.
    #[test]
    fn no_plain_text_panics(
        receipt in prop::collection::vec(0_u8..200, 3), variant in 0_u8..15, rest in prop::collection::vec(any::<u8>(), 0..90),
    ) {
        fuzz::decode(&[receipt.as_slice(), &[variant], &rest].concat());
    }

    #[test]
    fn modboat_cycles_survive(
        number: u32, start: u64, rotation: f32, centerline: f32, amplitude: f32, transition: u32, period: u32,
        prepare: bool, ramp in proptest::option::of(any::<u32>()),
    ) {
        let motion = Motion::Modboat(ModboatCycle {
            rotation: Radians(rotation),
            centerline: Radians(centerline),
            amplitude: Radians(amplitude),
            transition: Duration(transition),
            period: Duration(period),
            law: ramp.map_or(TransitionLaw::ConstantSpeed, |ramp| TransitionLaw::RestToRest { ramp: Duration(ramp) }),
        });
        let delivery = if prepare { Delivery::Prepare } else { Delivery::Direct };
        let message = Message::Cycle(Cycle { number, start: FleetInstant(start), motion, delivery });
        let (again, length) = told(&message, Side::Host);
        prop_assert_eq!(again, format!("{message:?}"));
        prop_assert!(length <= 100, "{} bytes", length);
    }

    #[test]
    fn rov_cycles_survive(number: u32, start: u64, lease: u32, open: bool, thrusts in prop::collection::vec(-60f32..60.0, 0..=8)) {
        let motion = Motion::Rov(RovCycle {
            thrusts: thrusts.into_iter().map(Newtons).collect(),
            lease: Duration(lease),
            connectors: if open { Connectors::Open } else { Connectors::Closed },
        });
        let message = Message::Cycle(Cycle { number, start: FleetInstant(start), motion, delivery: Delivery::Direct });
        let (again, length) = told(&message, Side::Host);
        prop_assert_eq!(again, format!("{message:?}"));
        prop_assert!(length <= MAX_DATAGRAM);
    }

    #[test]
    fn rov_reports_survive(
        at: u64, cycle: u32, battery in -1e3_f32..1e3, current in -1e3_f32..1e3, faults: u8,
        pulses in prop::collection::vec(0_f32..20_000.0, 0..=8),
    ) {
        let message = Message::RovTelemetry(RovTelemetry {
            at: FleetInstant(at),
            state: ModuleState::Executing,
            cycle,
            pulses: pulses.into_iter().map(PulseMicros).collect(),
            battery: Volts(battery),
            current: Amperes(current),
            faults: Faults(faults),
        });
        let (again, length) = told(&message, Side::Module);
        prop_assert_eq!(again, format!("{message:?}"));
        prop_assert!(length <= MAX_DATAGRAM);
    }
}
