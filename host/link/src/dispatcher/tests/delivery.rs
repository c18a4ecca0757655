//! One cycle to each module, and what is known of it then.

use super::super::super::delivery::Knowledge;
use super::super::*;
use super::played::*;

fn numbers(heard: &[(usize, Message)]) -> Vec<(usize, u32)> {
    let number = |(index, message): &(usize, Message)| match message {
        Message::Cycle(cycle) => (*index, cycle.number),
        other => panic!("{other:?}"),
    };
    heard.iter().map(number).collect()
}

#[test]
fn a_cycle_goes_out_again_until_it_is_answered() {
    let mut bench = Bench::new(2);
    bench.join(0);
    bench.dispatch(1, 100_000, &SWIM, Delivery::Direct);
    assert_eq!(numbers(&bench.heard()), [(0, 1)], "module 2 is in no session yet");
    assert_eq!(bench.link(1).knowledge(1), Knowledge::CertainlyNot);
    assert!(bench.at(9_999).is_empty());
    bench.join(1);
    assert_eq!(numbers(&bench.at(10_000)), [(0, 1), (1, 1)]);
    assert_eq!(bench.link(1).knowledge(1), Knowledge::Possibly);
    bench.now = FleetInstant(15_000);
    assert_eq!(
        bench.say(0, &answer(1, Verdict::Accepted)),
        Some(DispatcherEvent::Accepted { module: 0, cycle: 1 })
    );
    assert_eq!(bench.say(0, &answer(1, Verdict::Duplicate)), None, "its answer to the second");
    assert_eq!(numbers(&bench.at(22_000)), [(1, 1)]);
    assert!(bench.at(100_000).is_empty(), "the cycle has started");
    let [one, two] = [0, 1].map(|index| *bench.link(index).ledger());
    assert_eq!((one.cycles, one.acknowledged, one.unanswered, one.resent, one.open()), (1, 1, 0, 1, 0));
    assert_eq!((two.cycles, two.acknowledged, two.unanswered, two.resent, two.open()), (1, 0, 1, 1, 0));
    assert_eq!(bench.link(0).knowledge(1), Knowledge::Possibly, "what it took it may still drop");
    bench.say(0, &report(110_001, 1, ModuleState::Executing));
    assert!(bench.link(0).has(1) && !bench.link(1).has(1), "a report is proof");
    // From a cycle's first datagram to its answer.
    let answers = bench.link(0).answers().quantiles();
    assert_eq!((answers.count, (answers.max_ms * 1e3).round() as u64), (1, 15_000));
}

#[test]
fn within_three_tenths_of_a_second_it_goes_out_seventeen_times() {
    let mut bench = Bench::joined(1);
    bench.dispatch(1, 1_000_000, &SWIM, Delivery::Direct);
    let sends = bench.heard().len() + (1..300).map(|ms| bench.at(ms * 1_000).len()).sum::<usize>();
    assert_eq!(sends, 17);
    assert_eq!(bench.link(0).ledger().resent, 16);
}

#[test]
fn a_module_without_a_motion_gets_none() {
    let mut bench = Bench::joined(2);
    bench.dispatcher.dispatch(bench.now, 1, FleetInstant(100_000), &[None, Some(SWIM)], Delivery::Direct);
    assert_eq!(numbers(&bench.heard()), [(1, 1)]);
    assert_eq!((bench.link(0).ledger().cycles, bench.link(1).ledger().cycles), (0, 1));
}

#[test]
fn thrusts_twenty_times_a_second_are_each_accounted_for() {
    let mut bench = Bench::joined(1);
    let motion = thrust(Duration(200_000));
    // 1 is answered; 2 is still open when 3 takes its place, and its late answer is not 3's.
    for (k, start) in [(1, 30_000), (2, 80_000), (3, 130_000)] {
        bench.now = FleetInstant(start - 30_000);
        bench.dispatch(k, start, &motion, Delivery::Direct);
        assert_eq!(numbers(&bench.heard()), [(0, k)]);
        assert_eq!(numbers(&bench.at(start - 10_000)), [(0, k)], "again");
        if k == 1 {
            bench.now = FleetInstant(25_000);
            let event = bench.say(0, &answer(1, Verdict::Accepted));
            assert_eq!(event, Some(DispatcherEvent::Accepted { module: 0, cycle: 1 }));
        }
    }
    bench.now = FleetInstant(120_000);
    assert_eq!(bench.say(0, &answer(2, Verdict::Accepted)), None);
    // It goes on past its start, until its lease is over; until then it may still be taken.
    bench.say(0, &rov_report(200_000, 1));
    assert_eq!(bench.link(0).knowledge(3), Knowledge::Possibly);
    assert_eq!(numbers(&bench.at(329_999)), [(0, 3)]);
    assert!(bench.at(330_000).is_empty());
    let ledger = *bench.link(0).ledger();
    assert_eq!((ledger.cycles, ledger.acknowledged, ledger.unanswered, ledger.open()), (3, 1, 2, 0));
    assert_eq!(ledger.resent, 4);
    // What it reports counts as an answer as far as having it goes.
    assert!(!bench.link(0).has(3));
    assert_eq!(bench.say(0, &rov_report(210_000, 3)), Some(DispatcherEvent::Reported(0)));
    let link = bench.link(0);
    assert!(link.has(3) && link.telemetry().is_none());
    assert_eq!(link.rov_telemetry().map(|report| report.pulses.len()), Some(1));
    bench.say(0, &rov_report(340_000, 2));
    assert_eq!(bench.link(0).knowledge(3), Knowledge::CertainlyNot);
}

/// A cycle that was dispatched, for 1 s, and heard.
fn under_way() -> Bench {
    let mut bench = Bench::joined(1);
    bench.dispatch(5, 1_000_000, &SWIM, Delivery::Direct);
    bench.heard();
    bench
}

#[test]
fn a_cycle_without_an_answer_is_known_from_reports_of_after_its_start() {
    for (at, cycle, expected) in [
        (0, 4, Knowledge::Possibly),
        (999_000, 4, Knowledge::Possibly),
        // So much its clock may be off.
        (1_009_999, 4, Knowledge::Possibly),
        (1_010_000, 4, Knowledge::CertainlyNot),
        (1_000_500, 5, Knowledge::Certainly),
    ] {
        let mut bench = under_way();
        assert_eq!(bench.link(0).knowledge(5), Knowledge::Possibly);
        bench.at(1_000_000);
        assert_eq!((bench.link(0).ledger().unanswered, bench.link(0).ledger().open()), (1, 0));
        bench.say(0, &report(at, cycle, ModuleState::Executing));
        assert_eq!(bench.link(0).knowledge(5), expected, "{at} µs, cycle {cycle}");
        assert_eq!(bench.link(0).is_up_to_date(), at >= 1_010_000);
        assert_eq!(
            bench.link(0).knowledge(4),
            if cycle == 4 { Knowledge::Certainly } else { Knowledge::Possibly }
        );
    }
}

#[test]
fn a_late_answer_still_tells_what_the_module_has() {
    for (verdict, expected) in [
        (Verdict::Accepted, Knowledge::Possibly),
        (Verdict::Duplicate, Knowledge::Possibly),
        (Verdict::Refused(Refusal::Late), Knowledge::CertainlyNot),
        (Verdict::Refused(Refusal::Unsure), Knowledge::CertainlyNot),
    ] {
        let mut bench = under_way();
        bench.at(1_000_000);
        bench.now = FleetInstant(1_200_000);
        assert!(bench.say(0, &answer(5, verdict)).is_some(), "{verdict:?}");
        assert_eq!(bench.link(0).knowledge(5), expected, "{verdict:?}");
        // It was counted before.
        let ledger = *bench.link(0).ledger();
        assert_eq!((ledger.cycles, ledger.unanswered), (1, 1), "{verdict:?}: {ledger:?}");
        assert_eq!((ledger.acknowledged, ledger.refused, ledger.late), (0, 0, 0), "{verdict:?}");
    }
}

#[test]
fn refusals_are_counted_and_those_for_lateness_apart() {
    for (reason, late) in [(Refusal::Late, true), (Refusal::PoseMismatch, false), (Refusal::Stopped, false)] {
        let mut bench = under_way();
        let event = bench.say(0, &answer(5, Verdict::Refused(reason)));
        assert_eq!(event, Some(DispatcherEvent::Refused { module: 0, cycle: 5, reason }));
        let ledger = *bench.link(0).ledger();
        assert_eq!((ledger.late, ledger.refused), (u64::from(late), u64::from(!late)));
        assert_eq!((ledger.open(), bench.link(0).knowledge(5)), (0, Knowledge::CertainlyNot));
        assert!(bench.at(500_000).is_empty(), "not asked again");
        assert_eq!(bench.say(0, &answer(5, Verdict::Refused(reason))), None);
        assert_eq!(*bench.link(0).ledger(), ledger);
    }
}

#[test]
fn a_reboot_forgets_what_was_accepted() {
    let mut bench = under_way();
    bench.say(0, &answer(5, Verdict::Accepted));
    assert_eq!(bench.link(0).knowledge(5), Knowledge::Possibly);
    bench.modules[0].reboot();
    assert_eq!(bench.join(0), Some(DispatcherEvent::Rebooted(0)));
    assert_eq!(bench.link(0).knowledge(5), Knowledge::CertainlyNot);
    assert!(bench.link(0).is_up_to_date());
    let ledger = *bench.link(0).ledger();
    assert_eq!((ledger.acknowledged, ledger.unanswered, ledger.open()), (1, 0, 0), "counted once");
    // What was queued before its reboot does not reach it.
    bench.modules[0].reboot();
    bench.now = FleetInstant(100_000);
    let announcement = bench.modules[0].announce();
    bench.deliver(0, &announcement).expect("genuine");
    bench.heard();
    bench.dispatch(6, 2_000_000, &SWIM, Delivery::Direct);
    assert_eq!(bench.say(0, &health()), Some(DispatcherEvent::Rebooted(0)));
    assert!(bench.heard().is_empty() && bench.at(500_000).is_empty());
    assert_eq!(bench.link(0).knowledge(6), Knowledge::CertainlyNot);
    assert_eq!((bench.link(0).ledger().unanswered, bench.link(0).ledger().open()), (1, 0));
}

/// It may have served another host meanwhile, and forgotten.
#[test]
fn another_session_of_the_same_boot_leaves_it_open_what_the_module_has() {
    let mut bench = under_way();
    bench.say(0, &answer(5, Verdict::Accepted));
    bench.modules[0].session = None;
    bench.now = FleetInstant(100_000);
    assert_eq!(bench.join(0), Some(DispatcherEvent::Rejoined(0)));
    assert_eq!(bench.link(0).knowledge(5), Knowledge::Possibly);
    bench.say(0, &report(1_100_000, 0, ModuleState::Ready));
    assert_eq!(bench.link(0).knowledge(5), Knowledge::CertainlyNot);
}
