//! Stops, releases, and modules that must not move at all.

use proptest::prelude::*;

use super::*;

#[test]
fn an_emergency_stop_latches_until_released_and_then_it_rests_where_it_is_found() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Accepted);
    bench.run(2_700 * MS);
    bench.say(&Message::EmergencyStop);
    assert_eq!(bench.state(), ModuleState::Stopped);
    let frozen = bench.reference();
    assert!(frozen.angle_rad < -0.1 && frozen.rate_rad_s == 0.0, "in mid swing: {frozen:?}");
    assert_eq!(bench.ask(&direct(2, 4_000 * MS)), refused(Refusal::Stopped));
    assert_eq!(bench.ask(&Message::Commit(1)), refused(Refusal::Stopped));
    let said = bench.run(9_000 * MS);
    assert_eq!((bench.reference(), bench.state()), (frozen, ModuleState::Stopped));
    let told = |message: &&Message| matches!(message, Message::Telemetry(_));
    let Some(Message::Telemetry(report)) = said.iter().rfind(told) else { panic!("no report") };
    assert_eq!((report.state, report.faults), (ModuleState::Stopped, Faults::EMERGENCY));
    // The tail was turned by hand.
    bench.tail.tail = Some(Radians(0.7));
    bench.run(9_010 * MS);
    assert_eq!(bench.reference(), frozen, "not yet");
    bench.say(&Message::Release);
    assert_eq!((bench.state(), bench.endpoint.failsafe().may_drive()), (ModuleState::Boot, false));
    bench.run(9_011 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert!(bench.is_frozen_at(0.7) && bench.endpoint.failsafe().may_drive());
    assert_eq!(bench.ask(&direct(3, 9_500 * MS)), refused(Refusal::PoseMismatch), "it sets out from 0");
    let mut from_there = cycle(4, 9_500 * MS, 1.0);
    if let Motion::Modboat(motion) = &mut from_there.motion {
        motion.centerline = Radians(-0.3);
    }
    assert_eq!(bench.ask(&Message::Cycle(from_there)), Verdict::Accepted);
    bench.run(9_501 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
}

#[test]
fn after_a_release_it_waits_until_it_sees_its_tail() {
    let mut bench = Bench::ready();
    bench.say(&Message::EmergencyStop);
    bench.tail.tail = None;
    bench.run(1_100 * MS);
    bench.say(&Message::Release);
    bench.run(1_200 * MS);
    assert_eq!((bench.state(), bench.endpoint.failsafe().may_drive()), (ModuleState::Boot, false));
    // Stopped once more before it has looked: the stop holds.
    bench.say(&Message::EmergencyStop);
    bench.tail.tail = Some(Radians(0.2));
    bench.run(1_300 * MS);
    assert_eq!(bench.state(), ModuleState::Stopped);
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), refused(Refusal::Stopped));
    bench.say(&Message::Release);
    bench.run(1_301 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert!(bench.is_frozen_at(0.2));
}

/// Stops and releases in the order in which they were said, whatever the order in which they come.
#[test]
fn the_last_word_counts_in_any_order() {
    let orders: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let (stop, release) = (Message::EmergencyStop, Message::Release);
    for words in [[&stop, &release, &stop], [&release, &stop, &release], [&stop, &stop, &release]] {
        for order in orders {
            let mut bench = Bench::ready();
            let said = words.map(|word| bench.host.seal(word));
            for k in order {
                assert_eq!(bench.bring(&said[k]), Ok(()));
            }
            bench.run(1_010 * MS);
            let expected = if *words[2] == stop { ModuleState::Stopped } else { ModuleState::Ready };
            assert_eq!(bench.state(), expected, "{words:?} in the order {order:?}");
        }
    }
}

#[test]
fn a_stop_drops_the_cycles_that_were_sent_before_it() {
    let mut bench = Bench::ready();
    let said =
        [&direct(1, 2_000 * MS), &Message::EmergencyStop, &Message::Release].map(|m| bench.host.seal(m));
    for k in [1, 2, 0] {
        assert_eq!(bench.bring(&said[k]), Ok(()));
        bench.run(bench.now.0 + MS);
    }
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
    assert_eq!(bench.host.session().outgoing().late, 1);
}

#[test]
fn a_low_battery_lets_the_cycle_end_and_refuses_the_next() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Accepted);
    bench.run(2_500 * MS);
    bench.endpoint.set_low_battery(true);
    bench.run(3_000 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
    assert_eq!(bench.ask(&direct(2, 4_000 * MS)), refused(Refusal::LowBattery));
    assert_eq!(bench.ask(&prepare(2, 4_000 * MS)), refused(Refusal::LowBattery));
    bench.run(4_001 * MS);
    assert_eq!(bench.state(), ModuleState::Holding);
    bench.endpoint.set_low_battery(false);
    bench.run(4_002 * MS);
    assert_eq!(bench.ask(&direct(2, 4_500 * MS)), refused(Refusal::LowBattery), "that was final");
    assert_eq!(bench.ask(&direct(3, 4_500 * MS)), Verdict::Accepted);
}

/// What was answered stays true: the host goes by it.
#[test]
fn what_is_held_is_not_refused_when_the_battery_gets_low() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Accepted);
    bench.endpoint.set_low_battery(true);
    bench.run(1_500 * MS);
    assert_eq!(bench.ask(&direct(1, 2_000 * MS)), Verdict::Duplicate);
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Executing);
}

/// The host gives up what it releases from.
#[test]
fn what_a_release_has_overtaken_does_not_run() {
    let mut bench = Bench::ready();
    bench.say(&Message::EmergencyStop);
    let (cycle, release) = (bench.host.seal(&direct(1, 2_000 * MS)), bench.host.seal(&Message::Release));
    for datagram in [&release, &cycle] {
        assert_eq!(bench.bring(datagram), Ok(()));
        bench.run(bench.now.0 + MS);
    }
    bench.run(2_001 * MS);
    assert_eq!(bench.state(), ModuleState::Ready);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever comes to it: noise, and whatever a host of its fleet would say to it.
    #[test]
    fn unprovisioned_it_says_nothing_and_moves_nothing(
        noise in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..100), 1..20),
        tail in any::<u32>(),
    ) {
        let mut host = Bench::ready();
        let genuine = [&direct(1, 2_000 * MS), &Message::Release, &Message::EmergencyStop, &Message::Release]
            .map(|message| host.host.seal(message));
        let recorded = host.host.recorded.clone();
        let mut endpoint = Endpoint::new(None, ModboatRobot::new(TailLimits::default()));
        let measurement = Measurement { tail: Some(Radians(f32::from_bits(tail))), ..AT_ZERO };
        for (now, datagram) in (0..).step_by(700).zip(noise.iter().chain(&genuine).chain(&recorded)) {
            endpoint.handle_timer(LocalInstant(now), &measurement);
            prop_assert!(endpoint.handle_datagram(LocalInstant(now), datagram).is_err());
            prop_assert_eq!(endpoint.state(LocalInstant(now)), ModuleState::Unprovisioned);
            prop_assert!(!endpoint.failsafe().may_drive());
            prop_assert!(endpoint.poll_transmit(&mut [0; protocol::MAX_DATAGRAM]).is_none());
        }
    }
}
