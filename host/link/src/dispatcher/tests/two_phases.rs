//! One cycle to all modules or none.

use super::super::super::delivery::{COMMIT_LEAD, Knowledge};
use super::super::*;
use super::played::*;

const START: u64 = 500_000;
/// The last instant at which a commit is sent for the first time.
const LAST: u64 = START - COMMIT_LEAD.0 as u64;

/// Three modules that have received cycle 1, which none may miss.
fn prepared() -> Bench {
    let mut bench = Bench::joined(3);
    bench.dispatch(1, START, &SWIM, Delivery::Prepare);
    assert_eq!(who(&bench.heard()), [0, 1, 2]);
    bench
}

fn knowledge(bench: &Bench) -> [Knowledge; 3] {
    [0, 1, 2].map(|index| bench.link(index).knowledge(1))
}

/// No module ever gets a commit.
#[track_caller]
fn assert_dropped(bench: &mut Bench) {
    assert!(bench.dispatcher.is_dropped(1));
    assert_eq!(knowledge(bench), [Knowledge::CertainlyNot; 3]);
    for us in (bench.now.0..START + 100_000).step_by(1_000) {
        let heard = bench.at(us);
        assert!(heard.is_empty(), "{us} µs: {heard:?}");
    }
    for index in 0..3 {
        // An answer that was under way changes nothing.
        bench.say(index, &answer(1, Verdict::Prepared));
        assert!(bench.at(START + 200_000).is_empty());
        let ledger = *bench.link(index).ledger();
        assert_eq!((ledger.cycles, ledger.acknowledged, ledger.open()), (1, 0, 0), "{ledger:?}");
        assert_eq!(ledger.refused + ledger.late + ledger.unanswered, 1, "{ledger:?}");
    }
}

#[test]
fn a_commit_goes_out_when_every_module_has_prepared_and_again_until_acknowledged() {
    let mut bench = prepared();
    for index in [0, 1] {
        assert_eq!(bench.say(index, &answer(1, Verdict::Prepared)), None);
    }
    let heard = bench.at(10_000);
    assert!(
        who(&heard) == [2] && matches!(heard[0].1, Message::Cycle(_)),
        "only the cycle, again: {heard:?}"
    );
    assert!(bench.at(11_000).is_empty());
    bench.say(2, &answer(1, Verdict::Prepared));
    assert_eq!(bench.at(12_000), [0, 1, 2].map(|index| (index, Message::Commit(1))));
    assert_eq!(knowledge(&bench), [Knowledge::Possibly; 3]);
    assert_eq!(
        bench.say(0, &answer(1, Verdict::Accepted)),
        Some(DispatcherEvent::Accepted { module: 0, cycle: 1 })
    );
    assert!(bench.at(21_999).is_empty());
    assert_eq!(bench.at(22_000), [1, 2].map(|index| (index, Message::Commit(1))));
    // The first answer was lost; this is the one to the second.
    assert_eq!(
        bench.say(1, &answer(1, Verdict::Duplicate)),
        Some(DispatcherEvent::Accepted { module: 1, cycle: 1 })
    );
    let commits: usize = (32..500).map(|ms| bench.at(ms * 1_000).len()).sum();
    assert_eq!(commits, 47, "every 10 ms until the start");
    assert!(bench.at(START).is_empty());
    assert_eq!(knowledge(&bench), [Knowledge::Possibly; 3], "taken is not run");
    assert!(!bench.dispatcher.is_dropped(1), "two run it");
    let ledgers = [0, 1, 2].map(|index| *bench.link(index).ledger());
    assert_eq!(ledgers.map(|l| (l.acknowledged, l.unanswered, l.open())), [(1, 0, 0), (1, 0, 0), (0, 1, 0)]);
    bench.say(2, &report(START + 10_000, 0, ModuleState::Holding));
    assert_eq!(bench.link(2).knowledge(1), Knowledge::CertainlyNot);
}

#[test]
fn a_commit_is_sent_for_the_first_time_only_while_it_can_be_repeated() {
    for (answered, committed) in [(LAST, true), (LAST + 1, false)] {
        let mut bench = prepared();
        bench.say(0, &answer(1, Verdict::Prepared));
        bench.say(1, &answer(1, Verdict::Prepared));
        bench.at(LAST - 1);
        bench.now = FleetInstant(answered);
        bench.say(2, &answer(1, Verdict::Prepared));
        let heard = bench.at(answered);
        assert_eq!(who(&heard), if committed { vec![0, 1, 2] } else { vec![] }, "{answered} µs");
        if !committed {
            assert_dropped(&mut bench);
        }
    }
}

#[test]
fn it_is_dropped_when_a_module_does_not_answer_in_time() {
    let mut bench = prepared();
    bench.say(0, &answer(1, Verdict::Prepared));
    bench.say(2, &answer(1, Verdict::Prepared));
    bench.at(LAST);
    assert!(!bench.dispatcher.is_dropped(1));
    bench.now = FleetInstant(LAST + 1);
    bench.dispatcher.handle_timer(bench.now);
    bench.heard();
    assert_dropped(&mut bench);
}

#[test]
fn it_is_dropped_when_a_module_refuses() {
    for reason in [Refusal::PoseMismatch, Refusal::Late, Refusal::Unsure] {
        let mut bench = prepared();
        bench.say(0, &answer(1, Verdict::Prepared));
        let event = bench.say(1, &answer(1, Verdict::Refused(reason)));
        assert_eq!(event, Some(DispatcherEvent::Refused { module: 1, cycle: 1, reason }));
        bench.say(2, &answer(1, Verdict::Prepared));
        bench.at(5_000);
        assert_dropped(&mut bench);
    }
}

#[test]
fn it_is_dropped_when_a_module_reboots_before_the_commit() {
    let mut bench = prepared();
    (0..3).for_each(|index| assert_eq!(bench.say(index, &answer(1, Verdict::Prepared)), None));
    bench.modules[1].reboot();
    assert_eq!(bench.join(1), Some(DispatcherEvent::Rebooted(1)));
    bench.at(5_000);
    assert!(bench.dispatcher.is_dropped(1));
    assert_eq!(knowledge(&bench), [Knowledge::CertainlyNot; 3]);
    assert_dropped(&mut bench);
}

#[test]
fn a_reboot_after_the_commit_is_known_of_that_module_alone() {
    let mut bench = prepared();
    (0..3).for_each(|index| assert_eq!(bench.say(index, &answer(1, Verdict::Prepared)), None));
    assert_eq!(bench.at(5_000).len(), 3);
    bench.say(0, &answer(1, Verdict::Accepted));
    bench.modules[1].reboot();
    assert_eq!(bench.join(1), Some(DispatcherEvent::Rebooted(1)));
    assert_eq!(bench.at(15_000), [(2, Message::Commit(1))]);
    assert_eq!(knowledge(&bench), [Knowledge::Possibly, Knowledge::CertainlyNot, Knowledge::Possibly]);
    assert!(!bench.dispatcher.is_dropped(1));
}

/// It prepared in a session that is over and has lost the cycle: it says so.
#[test]
fn a_commit_that_is_refused_leaves_the_others_to_go_on() {
    let mut bench = prepared();
    (0..3).for_each(|index| assert_eq!(bench.say(index, &answer(1, Verdict::Prepared)), None));
    bench.at(5_000);
    bench.say(0, &answer(1, Verdict::Accepted));
    let reason = Refusal::NotPrepared;
    let event = bench.say(1, &answer(1, Verdict::Refused(reason)));
    assert_eq!(event, Some(DispatcherEvent::Refused { module: 1, cycle: 1, reason }));
    assert_eq!(bench.at(15_000), [(2, Message::Commit(1))]);
    assert_eq!(bench.link(1).knowledge(1), Knowledge::CertainlyNot);
    assert!(!bench.dispatcher.is_dropped(1));
}

#[test]
fn it_is_dropped_at_once_when_a_module_is_in_no_session() {
    let mut bench = Bench::new(3);
    bench.join(0);
    bench.join(1);
    bench.dispatch(1, START, &SWIM, Delivery::Prepare);
    assert_eq!(who(&bench.heard()), [0, 1]);
    assert!(bench.at(1_000).is_empty());
    assert!(bench.dispatcher.is_dropped(1));
    bench.join(2);
    assert_dropped(&mut bench);
}

#[test]
fn what_takes_its_place_ends_it() {
    for stop in [false, true] {
        let mut bench = prepared();
        (0..3).for_each(|index| assert_eq!(bench.say(index, &answer(1, Verdict::Prepared)), None));
        if stop {
            bench.dispatcher.emergency_stop(bench.now);
        } else {
            bench.dispatcher.hold();
        }
        let heard: Vec<_> = (1..400).flat_map(|ms| bench.at(ms * 1_000)).collect();
        assert!(heard.iter().all(|(_, message)| !matches!(message, Message::Commit(_))), "{heard:?}");
        assert!((0..3).all(|index| bench.link(index).ledger().unanswered == 1));
    }
}
