//! Stop and release.

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
        bench.say(index, &report(0, 1, ModuleState::Executing));
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

#[test]
fn a_release_is_repeated_until_every_module_goes_on() {
    let mut bench = stopping();
    for index in [0, 1] {
        bench.say(index, &report(1, 1, ModuleState::Stopped));
    }
    bench.now = FleetInstant(1_000_000);
    bench.dispatcher.release(bench.now);
    assert_eq!(bench.heard(), [0, 1].map(|index| (index, Message::Release)));
    assert_eq!(told(&mut bench, 1_000_000 + EVERY, &Message::Release), [0, 1]);
    // A report of so soon may be from before a stop that is still under way.
    bench.say(0, &report(2, 1, ModuleState::Ready));
    assert_eq!(told(&mut bench, 1_000_000 + 2 * EVERY, &Message::Release), [0, 1]);
    let settled = 1_000_000 + SETTLES;
    bench.at(settled - 1);
    bench.now = FleetInstant(settled);
    bench.say(0, &report(3, 1, ModuleState::Ready));
    bench.say(1, &report(3, 1, ModuleState::Stopped));
    assert_eq!(told(&mut bench, settled + EVERY, &Message::Release), [1]);
    bench.say(1, &report(4, 1, ModuleState::Ready));
    assert!(bench.at(settled + 2 * EVERY).is_empty());
    // What stops a module that has followed is another stop: it is not ended unasked.
    bench.say(1, &report(5, 1, ModuleState::Stopped));
    assert!(bench.at(settled + 3 * EVERY).is_empty());
    // Who was not there is released when it comes.
    bench.join(2);
    bench.say(2, &report(6, 0, ModuleState::Stopped));
    assert_eq!(told(&mut bench, settled + 4 * EVERY, &Message::Release), [2]);
    bench.say(2, &report(7, 0, ModuleState::Ready));
    assert!(bench.at(settled + 5 * EVERY).is_empty());
    bench.say(2, &report(8, 0, ModuleState::Stopped));
    assert!(bench.at(settled + 6 * EVERY).is_empty(), "it is over");
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
fn hold_reaches_every_module_and_ends_what_is_under_way() {
    let mut bench = Bench::joined(2);
    bench.dispatch(1, 500_000, &SWIM, Delivery::Direct);
    bench.heard();
    bench.say(0, &answer(1, Verdict::Accepted));
    bench.dispatcher.hold();
    assert_eq!(bench.heard(), [0, 1].map(|index| (index, Message::Hold)));
    assert!(bench.at(300_000).is_empty());
    let counts = [0, 1].map(|index| *bench.link(index).ledger()).map(|l| (l.acknowledged, l.unanswered));
    assert_eq!(counts, [(1, 0), (0, 1)]);
}
