//! Reports with numbers that no module can have.

use protocol::units::{Amperes, PulseMicros, Radians, RadiansPerSecond, Volts};
use protocol::{Faults, Health, RovTelemetry, Telemetry};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::super::*;
use super::played::*;

/// When all of it happens, µs.
const NOW: u64 = 100_000_000;

/// A module that was sent cycle 7 and has reported, as good as can be.
fn reporting() -> Bench {
    let mut bench = Bench::joined(1);
    bench.now = FleetInstant(NOW);
    bench.dispatch(7, NOW + 300_000, &SWIM, Delivery::Direct);
    bench.heard();
    assert_eq!(bench.say(0, &Message::Telemetry(boat())), Some(DispatcherEvent::Reported(0)));
    bench
}

fn boat() -> Telemetry {
    let Message::Telemetry(report) = report(NOW, 6, ModuleState::Ready) else { unreachable!() };
    report
}

fn rov() -> RovTelemetry {
    let Message::RovTelemetry(report) = rov_report(NOW, 6) else { unreachable!() };
    report
}

/// Hears `message`: whether it was followed. What was known stays as it was if not.
fn followed(bench: &mut Bench, message: &Message) -> bool {
    let before = (bench.link(0).telemetry().copied(), *bench.link(0).incoming());
    let datagram = bench.modules[0].say(message);
    let told = bench.deliver(0, &datagram);
    let (link, incoming) = (bench.link(0), *bench.link(0).incoming());
    assert!(incoming.is_exact() && incoming.received == before.1.received + 1);
    match told {
        Ok(_) => assert_eq!(incoming.accepted, before.1.accepted + 1, "{message:?}"),
        Err(class) => {
            assert_eq!((class, incoming.corrupt), (Class::Corrupt, before.1.corrupt + 1), "{message:?}");
            assert_eq!(link.telemetry().copied(), before.0, "{message:?}");
        }
    }
    told.is_ok()
}

#[test]
fn one_number_that_no_module_has_makes_a_report_corrupt() {
    const BAD: [f32; 5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30];
    let with = |change: &dyn Fn(&mut Telemetry)| {
        let mut report = boat();
        change(&mut report);
        Message::Telemetry(report)
    };
    let rov_with = |change: &dyn Fn(&mut RovTelemetry)| {
        let mut report = rov();
        change(&mut report);
        Message::RovTelemetry(report)
    };
    let mut bad = vec![
        with(&|r| r.battery = Volts(-0.1)),
        with(&|r| r.at = FleetInstant(u64::MAX)),
        with(&|r| r.at = FleetInstant(NOW + 1_000_001)),
        with(&|r| r.at = FleetInstant(1)),
        with(&|r| r.cycle = 8),
        with(&|r| r.cycle = u32::MAX),
        rov_with(&|r| r.battery = Volts(-0.1)),
        rov_with(&|r| r.at = FleetInstant(NOW / 3)),
        rov_with(&|r| r.cycle = 8),
        rov_with(&|r| r.pulses.push(PulseMicros(0.0)).expect("room")),
        rov_with(&|r| r.pulses.push(PulseMicros(20_000.0)).expect("room")),
        Message::Health(Health { drift_ppb: i32::MIN, ..Health::default() }),
        Message::Health(Health { drift_ppb: i32::MAX, ..Health::default() }),
        Message::Health(Health {
            incoming: Incoming { received: 3, accepted: 2, ..Incoming::default() },
            ..Health::default()
        }),
    ];
    for value in BAD {
        bad.push(with(&|r| r.tail = Radians(value)));
        bad.push(with(&|r| r.rate = RadiansPerSecond(value)));
        bad.push(rov_with(&|r| r.pulses.push(PulseMicros(value)).expect("room")));
        if !value.is_nan() {
            bad.push(with(&|r| r.current = Amperes(value)));
            bad.push(with(&|r| r.battery = Volts(value)));
            bad.push(rov_with(&|r| r.current = Amperes(value)));
            bad.push(rov_with(&|r| r.battery = Volts(value)));
        }
    }
    let mut bench = reporting();
    for message in &bad {
        assert!(!followed(&mut bench, message), "{message:?}");
    }
    // The module learns that they were of no use.
    bench.dispatcher.hold();
    bench.heard();
    let outgoing = bench.modules[0].session.as_ref().expect("a session").outgoing();
    assert_eq!(outgoing.late, bad.len() as u64);
    // What a module can have is followed, at the limits too.
    for good in [
        with(&|r| r.at = FleetInstant(0)),
        with(&|r| r.at = FleetInstant(NOW + 1_000_000)),
        with(&|r| r.at = FleetInstant(NOW - 60_000_000)),
        with(&|r| (r.cycle, r.tail, r.rate) = (7, Radians(-9e4), RadiansPerSecond(-15.0))),
        with(&|r| (r.battery, r.faults) = (Volts(0.0), Faults(0xFF))),
        Message::Health(Health { uncertainty: Duration(u32::MAX), drift_ppb: -300_000, ..Health::default() }),
        Message::RovTelemetry(rov()),
    ] {
        assert!(followed(&mut bench, &good), "{good:?}");
    }
}

/// A board without a divider, or without a sensor, says that it has no number.
#[test]
fn what_is_not_measured_becomes_zero() {
    let mut bench = reporting();
    let unmeasured = (Volts(f32::NAN), Amperes(f32::NAN));
    let report = Telemetry { battery: unmeasured.0, current: unmeasured.1, ..boat() };
    assert!(followed(&mut bench, &Message::Telemetry(report)));
    let noted = bench.link(0).telemetry().map(|report| (report.battery, report.current));
    assert_eq!(noted, Some((Volts(0.0), Amperes(0.0))));
    let report = RovTelemetry { battery: unmeasured.0, current: unmeasured.1, ..rov() };
    assert!(followed(&mut bench, &Message::RovTelemetry(report)));
    let noted = bench.link(0).rov_telemetry().map(|report| (report.battery, report.current));
    assert_eq!(noted, Some((Volts(0.0), Amperes(0.0))));
}

#[test]
fn a_first_word_that_is_corrupt_still_proves_that_the_module_is_there() {
    let mut bench = Bench::new(1);
    let announcement = bench.modules[0].announce();
    assert_eq!(bench.deliver(0, &announcement), Ok(None));
    bench.heard();
    let corrupt = Message::Telemetry(Telemetry { tail: Radians(f32::NAN), ..boat() });
    assert_eq!(bench.say(0, &corrupt), Some(DispatcherEvent::Joined(0)));
    assert_eq!((bench.link(0).telemetry(), bench.link(0).incoming().corrupt), (None, 1));
}

/// What it said before is of no use either then: it may have moved since.
#[test]
fn a_module_that_reports_nothing_but_such_numbers_is_named_and_unknown() {
    let mut bench = reporting();
    let corrupt = Telemetry { tail: Radians(f32::NAN), ..boat() };
    let lies_until = |bench: &mut Bench, us: u64| {
        while bench.now.0 < us {
            bench.now = FleetInstant(bench.now.0 + 20_000);
            let lie = Message::Telemetry(Telemetry { at: bench.now, ..corrupt });
            assert!(!followed(bench, &lie));
            bench.dispatcher.handle_timer(bench.now);
        }
    };
    let known = |bench: &Bench| {
        let named = bench.dispatcher.silence(bench.now, ModuleId(1)) == Some(Silence::Implausible);
        (named, bench.link(0).telemetry().is_some(), bench.link(0).state().is_some())
    };
    lies_until(&mut bench, NOW + 900_000);
    assert_eq!(known(&bench), (false, true, true));
    // One that is true makes up for them, whatever its health says.
    let truth = |bench: &Bench| Message::Telemetry(Telemetry { at: bench.now, ..boat() });
    let message = truth(&bench);
    assert!(followed(&mut bench, &message));
    lies_until(&mut bench, NOW + 1_900_000);
    assert_eq!(known(&bench), (false, true, true));
    lies_until(&mut bench, NOW + 2_100_000);
    assert_eq!(known(&bench), (true, false, false));
    let unsound = Health { drift_ppb: i32::MAX, ..Health::default() };
    assert!(!followed(&mut bench, &Message::Health(unsound)));
    let message = truth(&bench);
    assert!(followed(&mut bench, &message));
    assert_eq!(known(&bench), (false, true, true));
}

/// Any bits, most of them of a single number that is amiss.
#[test]
fn whatever_bits_come_no_number_gets_in_that_is_none() {
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut bench = reporting();
        let (mut followed_count, mut bits) = (0, [0_u32; 4]);
        for _ in 0..2_000 {
            let mut float = |good: f32| match rng.random_range(0..4) {
                0 => f32::from_bits(rng.random()),
                // About the limits of every kind.
                1 => good + rng.random_range(-1.0_f32..1.0) * 10.0_f32.powi(rng.random_range(-3..9)),
                _ => good,
            };
            let values = [float(0.3), float(2.0), float(0.5), float(7.4), float(1_580.0)];
            bits = [0, 1, 2, 3].map(|k: usize| values[k].to_bits());
            let [tail, rate, current, battery, pulse] = values;
            let at = if rng.random_bool(0.8) { FleetInstant(NOW) } else { FleetInstant(rng.random()) };
            let cycle = if rng.random_bool(0.8) { 6 } else { rng.random_range(0..20) };
            let (battery, current) = (Volts(battery), Amperes(current));
            let message = if rng.random_bool(0.5) {
                let (tail, rate) = (Radians(tail), RadiansPerSecond(rate));
                Message::Telemetry(Telemetry { at, cycle, tail, rate, current, battery, ..boat() })
            } else {
                let pulses = [PulseMicros(pulse)].into_iter().collect();
                Message::RovTelemetry(RovTelemetry { at, cycle, pulses, current, battery, ..rov() })
            };
            followed_count += u32::from(followed(&mut bench, &message));
            let link = bench.link(0);
            let boat =
                link.telemetry().map(|r| (r.at, r.cycle, vec![r.tail.0, r.rate.0], r.battery.0, r.current.0));
            let rov = link.rov_telemetry().map(|r| {
                let pulses = r.pulses.iter().map(|pulse| pulse.0).collect();
                (r.at, r.cycle, pulses, r.battery.0, r.current.0)
            });
            let (at, cycle, moves, battery, current) = boat.or(rov).expect("the last good one stays");
            assert!(moves.iter().all(|value| value.abs() < 2e5), "seed {seed}: {moves:?}, {bits:x?}");
            assert!((0.0..=100.0).contains(&battery) && current.abs() <= 1e3, "seed {seed}: {bits:x?}");
            assert!(
                cycle <= 7 && (at.0 == 0 || at.0.abs_diff(NOW) <= 60_000_000),
                "seed {seed}: {at:?}, {cycle}"
            );
        }
        assert!(
            (100..1_900).contains(&followed_count),
            "seed {seed}: {followed_count} of 2000 were followed"
        );
        assert!(bits != [0; 4]);
    }
}
