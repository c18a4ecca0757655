//! Who is taken in, who is not, and what is heard of whom.

use std::collections::VecDeque;

use protocol::time::LocalInstant;
use protocol::{Announcer, FleetKey, Hello, Kind, MAX_DATAGRAM, ModuleKind};

use super::super::super::delivery::Knowledge;
use super::super::super::offers::{OFFERS, PROVES_WITHIN, SILENT};
use super::super::*;
use super::played::*;

#[test]
fn a_module_is_taken_in_when_it_has_answered_the_call() {
    let mut bench = Bench::new(1);
    let announcement = bench.modules[0].announce();
    assert_eq!(bench.deliver(0, &announcement), Ok(None));
    assert!(!bench.link(0).is_known(), "it may be a recording");
    assert_eq!(bench.heard(), [(0, Message::Called)]);
    assert!(!bench.link(0).is_known(), "no module has answered");
    assert_eq!(bench.say(0, &health()), Some(DispatcherEvent::Joined(0)));
    assert_eq!((bench.link(0).boots(), bench.link(0).sessions()), (1, 1));
    // From then on it announces what its next session would be: nothing new.
    bench.now = FleetInstant(1_000_000);
    let announcement = bench.modules[0].announce();
    assert_eq!(bench.deliver(0, &announcement), Ok(None));
    assert_eq!(bench.deliver(0, &announcement), Err(Class::Duplicate));
    assert!(bench.sent().is_empty());
    assert_eq!(bench.say(0, &health()), None);
}

/// Recordings of boots that this start of the host knows nothing of.
fn recordings(bench: &mut Bench, count: usize) -> Vec<Vec<u8>> {
    let record = |_| {
        let recording = bench.modules[0].announce();
        bench.modules[0].reboot();
        recording
    };
    (0..count).map(record).collect()
}

#[test]
fn a_replayed_announcement_changes_nothing() {
    let mut bench = Bench::new(1);
    let recordings = recordings(&mut bench, 3);
    let own = bench.modules[0].announce();
    assert_eq!(bench.join(0), Some(DispatcherEvent::Joined(0)));
    bench.dispatch(1, 5_000_000, &SWIM, Delivery::Direct);
    bench.heard();
    bench.say(0, &answer(1, Verdict::Accepted));
    bench.say(0, &report(10, 0, ModuleState::Ready));
    let before = bench.link(0).telemetry().copied();
    for round in 1..=20 {
        bench.now = FleetInstant(round * 100_000);
        for (recording, first) in recordings.iter().zip([true; 3]) {
            let heard = bench.dispatcher.handle_datagram(bench.now, 'x', recording);
            assert_eq!(heard, if first && round == 1 { Ok(None) } else { Err(Class::Duplicate) });
        }
        // The one that led to the session, and another of that boot, are used up.
        assert_eq!(bench.dispatcher.handle_datagram(bench.now, 'x', &own), Err(Class::Stale));
        // What goes to the stranger is one call for each, which opens nothing at the module.
        let calls = bench.sent();
        assert_eq!(calls.len(), if round == 1 { 3 } else { 0 });
        for (to, call) in calls {
            assert_eq!((to, bench.modules[0].handle_datagram(&call)), ('x', Err(Class::Stale)));
        }
    }
    let link = bench.link(0);
    assert_eq!((link.boots(), link.sessions(), link.is_elsewhere()), (1, 1, false));
    assert_eq!((link.knowledge(1), link.ledger().acknowledged), (Knowledge::Possibly, 1));
    assert!(link.telemetry().copied() == before && link.incoming().is_exact());
    // The session in force goes on, at the module's address.
    assert_eq!(bench.say(0, &report(20, 0, ModuleState::Ready)), Some(DispatcherEvent::Reported(0)));
    bench.dispatcher.hold();
    assert_eq!(bench.heard(), [(0, Message::Hold)]);
}

#[test]
fn a_replay_on_its_heels_does_not_take_a_call_away() {
    let mut bench = Bench::new(1);
    let recordings = recordings(&mut bench, 2);
    let announcement = bench.modules[0].announce();
    bench.dispatcher.handle_datagram(bench.now, 'x', &recordings[0]).expect("genuine, though old");
    bench.deliver(0, &announcement).expect("genuine");
    bench.dispatcher.handle_datagram(bench.now, 'x', &recordings[1]).expect("genuine, though old");
    let sent = bench.sent();
    assert_eq!(sent.iter().map(|(to, _)| *to).collect::<String>(), "xax");
    assert_eq!(
        bench.modules[0].handle_datagram(&sent[1].1).map(|opened| opened.message),
        Ok(Message::Called)
    );
    assert_eq!(bench.say(0, &health()), Some(DispatcherEvent::Joined(0)));
}

#[test]
fn a_reboot_is_told_from_another_session_of_the_same_boot() {
    let mut bench = Bench::joined(1);
    bench.say(0, &report(1, 0, ModuleState::Ready));
    let (announcement, said) = (bench.modules[0].announce(), bench.modules[0].say(&health()));
    bench.modules[0].reboot();
    let other_life = bench.modules[0].announce();
    assert_eq!(bench.join(0), Some(DispatcherEvent::Rebooted(0)));
    assert_eq!((bench.link(0).boots(), bench.link(0).sessions()), (2, 2));
    assert_eq!(bench.link(0).telemetry(), None, "of its former boot");
    // What it said before its reboot comes late, and is no news of a reboot.
    assert_eq!(bench.deliver(0, &said), Err(Class::Stale));
    assert_eq!(bench.deliver(0, &other_life), Err(Class::Stale), "its nonce is used up");
    assert_eq!(bench.deliver(0, &announcement), Ok(None), "called, to no effect");
    for (_, call) in bench.sent() {
        assert_eq!(bench.modules[0].handle_datagram(&call), Err(Class::Stale));
    }
    assert_eq!((bench.link(0).boots(), bench.link(0).incoming().stale), (2, 2));
    // It leaves the session without a reboot.
    bench.modules[0].session = None;
    bench.now = FleetInstant(1_000_000);
    assert_eq!(bench.join(0), Some(DispatcherEvent::Rejoined(0)));
    assert_eq!((bench.link(0).boots(), bench.link(0).sessions()), (2, 3));
}

#[test]
fn calls_are_few_however_many_announcements_come() {
    let mut bench = Bench::new(1);
    let recordings = recordings(&mut bench, 100);
    let mut calls = 0;
    for ms in 0..1_000 {
        bench.now = FleetInstant(ms * 1_000);
        let announcement = bench.modules[0].announce();
        bench.deliver(0, &announcement).expect("genuine");
        assert_eq!(bench.deliver(0, &announcement), Err(Class::Duplicate));
        calls += bench.sent().len();
    }
    assert_eq!(calls, 20, "one in 50 ms");
    // However many boots are recorded: never more calls than announcements, to where those came from.
    for round in 0..3 {
        for recording in &recordings {
            bench.now = bench.now.after(Duration(1_000));
            let _ = bench.dispatcher.handle_datagram(bench.now, 'x', recording);
            let calls = bench.sent();
            assert!(calls.len() <= 1 && calls.iter().all(|(to, _)| *to == 'x'), "round {round}: {calls:?}");
        }
    }
    let outgoing = bench.link(0).outgoing();
    assert_eq!(outgoing.lost, outgoing.sent - outgoing.under_way(), "{outgoing:?}");
    assert!(outgoing.under_way() <= OFFERS as u64 * 20, "offers that are still open: {outgoing:?}");
    // The module was called 20 times without an answer, so its place was given up to others that want it; its turn comes again.
    bench.now = bench.now.after(Duration(1_000_000));
    assert_eq!(bench.join(0), Some(DispatcherEvent::Joined(0)));
    let outgoing = bench.link(0).outgoing();
    assert_eq!((outgoing.sent, outgoing.acknowledged, outgoing.under_way()), (outgoing.lost + 1, 1, 0));
}

/// Whether a module that announces itself five times a second joins while `boots` recorded boots of it are played at one a millisecond, with
/// 20 ms of way each way, and when.
fn joins_beside_recordings(boots: usize) -> Option<u64> {
    let mut bench = Bench::new(1);
    let recordings = recordings(&mut bench, boots);
    let mut under_way: VecDeque<(u64, Vec<u8>, bool)> = VecDeque::new();
    for ms in 0..120_000_u64 {
        bench.now = FleetInstant(ms * 1_000);
        if ms % 200 == 0 {
            let announcement = bench.modules[0].announce();
            under_way.push_back((ms + 20, announcement, false));
        }
        let recording = &recordings[ms as usize % boots];
        let _ = bench.dispatcher.handle_datagram(bench.now, 'x', recording);
        for (to, call) in bench.sent() {
            // What answers a recording goes to where that came from, and opens nothing.
            if to != 'x' {
                under_way.push_back((ms + 20, call, true));
            }
        }
        while under_way.front().is_some_and(|(at, ..)| *at <= ms) {
            let (_, datagram, is_call) = under_way.pop_front().expect("there is one");
            if !is_call {
                let _ = bench.deliver(0, &datagram);
            } else if bench.modules[0].handle_datagram(&datagram).is_ok() {
                assert_eq!(bench.say(0, &health()), Some(DispatcherEvent::Joined(0)));
                assert!(!bench.link(0).is_elsewhere());
                return Some(ms);
            }
        }
    }
    None
}

#[test]
fn recorded_announcements_keep_no_module_out() {
    for (boots, most_ms) in [(6, 100), (OFFERS - 1, 100)] {
        let joined_ms = joins_beside_recordings(boots);
        assert!(joined_ms.is_some_and(|ms| ms <= most_ms), "{boots} boots: {joined_ms:?} ms");
    }
    // More than are offered at once: each has its time first.
    for boots in [20, 100, 200] {
        assert!(boots < SILENT);
        let joined_ms = joins_beside_recordings(boots);
        let most_ms = (boots / OFFERS + 3) as u64 * u64::from(PROVES_WITHIN.0 / 1_000);
        println!("{boots} recorded boots: joined after {joined_ms:?} ms");
        assert!(joined_ms.is_some_and(|ms| ms <= most_ms), "{boots} boots: {joined_ms:?} of {most_ms} ms");
    }
}

/// Module 0 takes up the call of another host.
fn serve_another(bench: &mut Bench) {
    let mut other: Dispatcher<char> = Dispatcher::new(&[ModuleId(1)], &KEY, [5; 12]);
    let mut buffer = [0; MAX_DATAGRAM];
    let announcement = bench.modules[0].announce();
    other.handle_datagram(FleetInstant(0), 'a', &announcement).expect("genuine");
    let (_, call) = other.poll_transmit(FleetInstant(0), &mut buffer).expect("a call");
    bench.modules[0].handle_datagram(call).expect("it opens");
}

/// Ten different announcements of an old boot, which served another host then.
#[test]
fn a_module_in_our_session_is_not_said_to_be_elsewhere() {
    let mut bench = Bench::new(1);
    serve_another(&mut bench);
    let recordings: Vec<Vec<u8>> = (0..30).map(|_| bench.modules[0].announce()).collect();
    bench.modules[0].reboot();
    assert_eq!(bench.join(0), Some(DispatcherEvent::Joined(0)));
    for (round, recording) in (1..).zip(&recordings) {
        bench.now = FleetInstant(round * 60_000);
        bench.say(0, &health());
        let told = bench.dispatcher.handle_datagram(bench.now, 'x', recording);
        assert_eq!((told, bench.link(0).is_elsewhere()), (Ok(None), false), "round {round}");
    }
}

#[test]
fn strangers_are_counted_and_otherwise_ignored() {
    let mut bench = Bench::joined(1);
    let other = FleetKey::new([8; 32]);
    let hello = Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: (0, 2, 0), session: 0 });
    let mut buffer = [0; MAX_DATAGRAM];
    let stranger =
        |bench: &mut Bench, datagram: &[u8]| bench.dispatcher.handle_datagram(bench.now, 'x', datagram);
    assert_eq!(stranger(&mut bench, b"noise"), Err(Class::Corrupt));
    assert_eq!(stranger(&mut bench, &[]), Err(Class::Corrupt));
    let mut damaged = bench.modules[0].say(&health());
    damaged[20] ^= 4;
    assert_eq!(stranger(&mut bench, &damaged), Err(Class::Corrupt));
    let elsewhere = Played::new(&other, ModuleId(1)).announce();
    assert_eq!(stranger(&mut bench, &elsewhere), Err(Class::Foreign));
    let unknown = Played::new(&KEY, ModuleId(2)).announce();
    assert_eq!(stranger(&mut bench, &unknown), Err(Class::Foreign));
    bench.dispatcher.hold();
    let reflected = bench.sent().remove(0).1;
    assert_eq!(stranger(&mut bench, &reflected), Err(Class::Foreign));
    let strays = *bench.dispatcher.strays();
    assert_eq!((strays.received, strays.corrupt, strays.foreign), (6, 3, 3));
    // Who claims to be the module without its key is charged to the module.
    let (id, key) = (ModuleId(1), other.module(ModuleId(1)));
    let mut announcer = Announcer::new(KEY.fleet(), id, &key, Nonce([3; 16]));
    let forged = announcer.seal(&hello, &mut buffer).expect("room").to_vec();
    assert_eq!(stranger(&mut bench, &forged), Err(Class::Forged));
    let incoming = *bench.link(0).incoming();
    assert_eq!((incoming.received, incoming.accepted, incoming.forged), (3, 2, 1));
    assert_eq!((strays.is_exact(), incoming.is_exact(), bench.link(0).sessions()), (true, true, 1));
    assert!(bench.sent().is_empty());
}

#[test]
fn a_module_that_serves_another_host_is_told_from_one_that_is_to_be_called() {
    let mut bench = Bench::new(1);
    serve_another(&mut bench);
    // It names the other's session, and answers none of our calls.
    let mut told = Vec::new();
    for round in 0..15 {
        bench.now = FleetInstant(round * 200_000);
        let announcement = bench.modules[0].announce();
        told.push(bench.deliver(0, &announcement).expect("genuine"));
        assert_eq!(bench.sent().len(), 1, "it is called all the same");
    }
    let first = told.iter().position(Option::is_some);
    assert_eq!((first, told.last()), (Some(10), Some(&Some(DispatcherEvent::Elsewhere(0)))));
    assert!(bench.link(0).is_elsewhere() && !bench.link(0).is_known());
    // The other falls silent: it comes.
    bench.now = FleetInstant(4_000_000);
    let announcement = bench.modules[0].announce();
    bench.deliver(0, &announcement).expect("genuine");
    bench.heard();
    assert_eq!(bench.say(0, &health()), Some(DispatcherEvent::Joined(0)));
    assert!(!bench.link(0).is_elsewhere());
}

#[test]
fn a_module_is_wherever_its_newest_datagram_came_from() {
    let mut bench = Bench::joined(1);
    let (older, newer) = (bench.modules[0].say(&health()), bench.modules[0].say(&health()));
    bench.dispatcher.handle_datagram(bench.now, 'z', &newer).expect("genuine");
    bench.deliver(0, &older).expect("genuine, though overtaken");
    bench.dispatcher.hold();
    assert_eq!(bench.sent().first().map(|(to, _)| *to), Some('z'));
}

#[test]
fn clocks_are_answered() {
    let mut bench = Bench::joined(1);
    bench.now = FleetInstant(1_000);
    bench.say(0, &Message::TimeRequest(protocol::TimeRequest { sent: LocalInstant(77) }));
    // What lies between is no time under way.
    bench.now = FleetInstant(1_400);
    let reply = TimeReply {
        request_sent: LocalInstant(77),
        received: FleetInstant(1_000),
        sent: FleetInstant(1_400),
    };
    assert_eq!(bench.heard(), [(0, Message::TimeReply(reply))]);
}

#[test]
fn an_older_report_does_not_replace_a_newer_one() {
    let mut bench = Bench::joined(1);
    bench.dispatch(2, 400_000, &SWIM, Delivery::Direct);
    bench.heard();
    let reports = [1, 2].map(|cycle| bench.modules[0].say(&report(0, cycle, ModuleState::Executing)));
    assert_eq!(bench.deliver(0, &reports[1]), Ok(Some(DispatcherEvent::Reported(0))));
    assert_eq!(bench.deliver(0, &reports[0]), Ok(None));
    assert_eq!(bench.link(0).telemetry().map(|report| report.cycle), Some(2));
    assert_eq!(bench.deliver(0, &reports[1]), Err(Class::Duplicate));
    // The module learns with the next word of the host that the other was of no use.
    bench.dispatcher.hold();
    bench.heard();
    let outgoing = bench.modules[0].session.as_ref().expect("a session").outgoing();
    assert_eq!((outgoing.sent, outgoing.acknowledged, outgoing.late, outgoing.lost), (3, 2, 1, 0));
    // What is no report may be overtaken, and is of use all the same.
    bench.dispatch(3, 500_000, &SWIM, Delivery::Direct);
    bench.heard();
    let answered = bench.modules[0].say(&answer(3, Verdict::Accepted));
    bench.say(0, &report(0, 2, ModuleState::Executing));
    assert_eq!(bench.deliver(0, &answered), Ok(Some(DispatcherEvent::Accepted { module: 0, cycle: 3 })));
}

/// The operator's host stops what another one swims.
#[test]
fn a_module_of_another_host_is_stopped_when_it_announces_itself() {
    let mut bench = Bench::new(1);
    serve_another(&mut bench);
    bench.dispatcher.emergency_stop(bench.now);
    assert!(bench.sent().is_empty(), "it is not known where it is");
    let announcement = bench.modules[0].announce();
    assert_eq!(bench.deliver(0, &announcement), Ok(None));
    let kinds: Vec<Kind> = bench
        .sent()
        .iter()
        .map(|(to, datagram)| {
            assert_eq!(*to, 'a');
            let frame = Frame::parse(datagram).expect("a datagram");
            if frame.header.kind == Kind::Stop {
                assert_eq!(bench.modules[0].announcer.open_stop(&frame), Ok(()));
            }
            frame.header.kind
        })
        .collect();
    assert_eq!(kinds, [Kind::Call, Kind::Stop]);
    // Once released it is called alone.
    bench.dispatcher.release(bench.now);
    bench.now = FleetInstant(1_000_000);
    let announcement = bench.modules[0].announce();
    assert_eq!(bench.deliver(0, &announcement), Ok(None));
    assert_eq!(bench.sent().len(), 1);
}

#[test]
fn a_module_that_does_not_know_its_tail_says_what_is_wrong_with_it() {
    let mut bench = Bench::joined(1);
    bench.say(0, &report(1, 0, ModuleState::Ready));
    let unknown = protocol::TailUnknown {
        at: FleetInstant(2),
        state: ModuleState::Stopped,
        cycle: 0,
        battery: protocol::units::Volts(7.4),
        faults: protocol::Faults::INDEX,
    };
    let heard = bench.say(0, &Message::TailUnknown(unknown));
    assert_eq!(heard, Some(DispatcherEvent::Reported(0)));
    let link = bench.link(0);
    assert_eq!((link.state(), link.faults()), (Some(ModuleState::Stopped), protocol::Faults::INDEX));
    assert_eq!(link.telemetry(), None, "where it was seen before means nothing any more");
    bench.say(0, &report(3, 0, ModuleState::Ready));
    let link = bench.link(0);
    assert_eq!((link.state(), link.faults()), (Some(ModuleState::Ready), protocol::Faults(0)));
    assert!(link.telemetry().is_some());
}
