//! Stop, release and hold.

use protocol::{Faults, Telemetry};

use super::super::orders::{HOLD_MAX, ORDER_EVERY, RELEASE_SETTLES};
use super::super::*;
use super::played::*;

const EVERY: u64 = ORDER_EVERY.0 as u64;
const SETTLES: u64 = RELEASE_SETTLES.0 as u64;

/// Who is told what at `us`; all the same.
fn told(bench: &mut Bench, us: u64, message: &Message) -> Vec<usize> {
    let heard = bench.at(us);
    assert!(heard.iter().all(|(_, said)| said == message), "{us} µs: {heard:?}");
    who(&heard)
}

/// Two modules that swim and one that has not joined, told to stop.
fn stopping() -> Bench {
    let mut bench = Bench::new(3);
    for index in [0, 1] {
        bench.join(index);
        bench.say(index, &report(0, 0, ModuleState::Executing));
    }
    bench.dispatch(2, 900_000, &SWIM, Delivery::Direct);
    assert_eq!(bench.heard().len(), 2);
    bench.dispatcher.emergency_stop(bench.now);
    assert_eq!(bench.heard(), [0, 1].map(|index| (index, Message::EmergencyStop)));
    bench
}

#[test]
fn a_stop_is_repeated_until_every_module_has_stopped() {
    let mut bench = stopping();
    assert!((0..3).all(|index| bench.link(index).ledger().open() == 0), "no cycle is sent any more");
    assert!(bench.at(EVERY - 1).is_empty());
    assert_eq!(told(&mut bench, EVERY, &Message::EmergencyStop), [0, 1]);
    bench.say(0, &report(1, 1, ModuleState::Stopped));
    assert_eq!(told(&mut bench, 2 * EVERY, &Message::EmergencyStop), [1]);
    bench.say(1, &report(1, 1, ModuleState::Stopped));
    assert!(bench.at(3 * EVERY).is_empty());
    // It stays in force: for who joins later, and for who has lost it.
    bench.join(2);
    assert_eq!(told(&mut bench, 4 * EVERY, &Message::EmergencyStop), [2]);
    bench.say(2, &report(1, 0, ModuleState::Stopped));
    assert!(bench.at(5 * EVERY).is_empty());
    bench.modules[0].reboot();
    assert_eq!(bench.join(0), Some(DispatcherEvent::Rebooted(0)));
    bench.say(0, &report(0, 0, ModuleState::Unsynchronised));
    assert_eq!(told(&mut bench, 6 * EVERY, &Message::EmergencyStop), [0]);
}

/// Module `index` says that it is stopped by `faults`.
fn stops(bench: &mut Bench, index: usize, faults: Faults) {
    let Message::Telemetry(report) = report(bench.now.0, 0, ModuleState::Stopped) else { unreachable!() };
    bench.say(index, &Message::Telemetry(Telemetry { faults, ..report }));
}

/// Module `index` says that it goes on.
fn goes_on(bench: &mut Bench, index: usize) {
    bench.say(index, &report(bench.now.0, 0, ModuleState::Ready));
}

/// The same two, both stopped, and released a second later.
fn released() -> Bench {
    let mut bench = stopping();
    (0..2).for_each(|index| stops(&mut bench, index, Faults::EMERGENCY));
    bench.now = FleetInstant(1_000_000);
    bench.dispatcher.release(bench.now);
    assert_eq!(bench.heard(), [0, 1].map(|index| (index, Message::Release)));
    bench
}

#[test]
fn a_release_is_repeated_until_every_module_goes_on() {
    let mut bench = released();
    assert_eq!(told(&mut bench, 1_000_000 + EVERY, &Message::Release), [0, 1]);
    goes_on(&mut bench, 0);
    stops(&mut bench, 1, Faults::EMERGENCY);
    assert_eq!(told(&mut bench, 1_000_000 + 2 * EVERY, &Message::Release), [1]);
    goes_on(&mut bench, 1);
    assert!(bench.at(1_000_000 + 3 * EVERY).is_empty());
    // Who was not there is released when it comes.
    let settled = 1_000_000 + SETTLES;
    bench.now = FleetInstant(settled);
    bench.join(2);
    stops(&mut bench, 2, Faults::EMERGENCY);
    assert_eq!(told(&mut bench, settled + EVERY, &Message::Release), [2]);
    goes_on(&mut bench, 2);
    assert!(bench.at(settled + 2 * EVERY).is_empty());
    stops(&mut bench, 2, Faults::EMERGENCY);
    assert!(bench.at(settled + 3 * EVERY).is_empty(), "it is over");
}

/// Each is stopped again while copies of the release might still be sent.
#[test]
fn what_was_stopped_after_a_release_is_not_released_by_it() {
    // It went on, and was stopped by another host.
    let mut bench = released();
    bench.at(1_000_000 + EVERY);
    goes_on(&mut bench, 0);
    stops(&mut bench, 0, Faults::EMERGENCY);
    assert_eq!(told(&mut bench, 1_000_000 + 2 * EVERY, &Message::Release), [1]);
    // No report tells that it went on, but it has a fault that it did not have; a battery that runs low is none.
    stops(&mut bench, 1, Faults::EMERGENCY.with(Faults::LOW_BATTERY));
    assert_eq!(told(&mut bench, 1_000_000 + 3 * EVERY, &Message::Release), [1]);
    stops(&mut bench, 1, Faults::STALLED);
    assert!(bench.at(1_000_000 + 4 * EVERY).is_empty());
    // One that was going: what was under way may still stop it, and is released; later it is another stop.
    for (after, faults, again) in [
        (SETTLES - 1, Faults::EMERGENCY, true),
        (SETTLES, Faults::EMERGENCY, false),
        (SETTLES - 1, Faults::BLIND, false),
    ] {
        let mut bench = stopping();
        bench.now = FleetInstant(100_000);
        bench.dispatcher.release(bench.now);
        bench.heard();
        bench.now = FleetInstant(100_000 + after);
        stops(&mut bench, 0, faults);
        let told = told(&mut bench, 100_000 + after + EVERY, &Message::Release);
        assert_eq!(told, if again { &[0, 1][..] } else { &[1] }, "{after} µs, {faults:?}");
    }
}

#[test]
fn a_release_of_a_module_that_goes_on_is_over_once_no_stop_is_under_way() {
    let mut bench = Bench::joined(1);
    goes_on(&mut bench, 0);
    bench.dispatcher.release(bench.now);
    assert_eq!(bench.heard(), [(0, Message::Release)]);
    bench.now = FleetInstant(SETTLES - 1);
    goes_on(&mut bench, 0);
    assert_eq!(told(&mut bench, SETTLES, &Message::Release), [0]);
    goes_on(&mut bench, 0);
    assert!(bench.at(SETTLES + EVERY).is_empty());
}

#[test]
fn a_release_of_one_leaves_the_others_stopped() {
    let mut bench = Bench::joined(3);
    bench.dispatcher.emergency_stop(bench.now);
    bench.heard();
    (0..2).for_each(|index| stops(&mut bench, index, Faults::EMERGENCY));
    bench.now = FleetInstant(100_000);
    assert!(bench.dispatcher.release_one(bench.now, ModuleId(2)));
    assert!(!bench.dispatcher.release_one(bench.now, ModuleId(4)), "it is not in the roster");
    assert_eq!(bench.heard(), [(1, Message::Release), (2, Message::EmergencyStop)]);
    goes_on(&mut bench, 1);
    // The first is still stopped: once it is not, it is told again. The third never said that it is.
    assert_eq!(told(&mut bench, 100_000 + EVERY, &Message::EmergencyStop), [2]);
    goes_on(&mut bench, 0);
    goes_on(&mut bench, 1);
    assert_eq!(told(&mut bench, 100_000 + 2 * EVERY, &Message::EmergencyStop), [0, 2]);
    // A stop of all is one of that module too.
    bench.dispatcher.emergency_stop(bench.now);
    assert_eq!(who(&bench.heard()), [0, 1, 2]);
}

/// What was reported before a release is no reason to keep a stop back after it.
#[test]
fn a_stop_right_after_a_release_is_sent_at_once() {
    let mut bench = stopping();
    for index in [0, 1] {
        bench.say(index, &report(1, 1, ModuleState::Stopped));
    }
    bench.now = FleetInstant(100_000);
    bench.dispatcher.release(bench.now);
    bench.heard();
    bench.now = FleetInstant(101_000);
    bench.dispatcher.emergency_stop(bench.now);
    assert_eq!(bench.heard(), [0, 1].map(|index| (index, Message::EmergencyStop)));
}

#[test]
fn a_hold_is_repeated_until_nothing_that_was_sent_can_begin() {
    let mut bench = Bench::joined(2);
    bench.dispatch(1, 500_000, &SWIM, Delivery::Direct);
    bench.heard();
    bench.say(0, &answer(1, Verdict::Accepted));
    bench.dispatcher.hold();
    assert_eq!(bench.heard(), [0, 1].map(|index| (index, Message::Hold)));
    let counts = [0, 1].map(|index| *bench.link(index).ledger()).map(|l| (l.acknowledged, l.unanswered));
    assert_eq!(counts, [(1, 0), (0, 1)], "it ends what is under way");
    let mut sends = Vec::new();
    for ms in 1..2_000 {
        let heard = bench.at(ms * 1_000);
        assert!(heard.is_empty() || heard == [0, 1].map(|index| (index, Message::Hold)), "{heard:?}");
        sends.extend((!heard.is_empty()).then_some(ms * 1_000));
    }
    // Fast at first; the last before the cycle could begin by a clock that is off.
    let pauses: Vec<u64> = sends.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(pauses.is_sorted() && pauses[0] <= EVERY * 3 / 2, "{pauses:?}");
    assert!(pauses.iter().all(|&pause| pause <= u64::from(HOLD_MAX.0) + 1_000), "{pauses:?}");
    let last = sends.last().copied().expect("it is repeated");
    assert!((400_000..510_000).contains(&last) && sends.len() >= 7, "{sends:?}");
}

#[test]
fn a_hold_ends_with_the_next_cycle() {
    let mut bench = Bench::joined(2);
    bench.dispatch(1, 500_000, &SWIM, Delivery::Direct);
    bench.heard();
    bench.dispatcher.hold();
    bench.heard();
    // The second module gets none.
    let start = FleetInstant(900_000);
    bench.dispatcher.dispatch(bench.now, 2, start, &[Some(SWIM), None], Delivery::Direct);
    let heard: Vec<_> = (0..400).flat_map(|ms| bench.at(ms * 1_000)).collect();
    let holds: Vec<usize> = who(&heard)
        .into_iter()
        .zip(&heard)
        .filter(|(_, (_, message))| *message == Message::Hold)
        .map(|(index, _)| index)
        .collect();
    assert!(holds.len() >= 5 && holds.iter().all(|&index| index == 1), "{holds:?}");
}

#[test]
fn a_hold_leaves_a_stop_in_force_and_is_not_repeated_where_nothing_was_sent() {
    let mut bench = Bench::joined(1);
    bench.dispatcher.hold();
    assert_eq!(bench.heard(), [(0, Message::Hold)]);
    assert!(bench.at(EVERY).is_empty() && bench.at(2 * EVERY).is_empty());
    bench.dispatch(1, 500_000, &SWIM, Delivery::Direct);
    bench.heard();
    bench.dispatcher.emergency_stop(bench.now);
    bench.heard();
    bench.dispatcher.hold();
    assert_eq!(bench.heard(), [(0, Message::Hold)]);
    for k in 3..10 {
        assert_eq!(told(&mut bench, k * EVERY, &Message::EmergencyStop), [0]);
    }
}
