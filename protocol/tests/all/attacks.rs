//! An attacker that receives every datagram and can send any: nothing is followed that was not meant, and nothing
//! twice; every datagram is counted for what it is.

use std::collections::HashSet;

use crate::common::{BOOT, HOST, MODULE, end, fleet_key, messages, nonce, open, pair, remade, seal};
use proptest::prelude::*;
use proptest::sample::Index;
use protocol::ledger::{Class, Incoming, Outgoing};
use protocol::session::open_announcement;
use protocol::window::{Arrival, WINDOW, Window};
use protocol::*;

/// Both ends, and what each of them said with everything there is to say; all of it has come.
fn conversation() -> (Session, Session, Vec<(Side, Vec<u8>)>) {
    let (mut host, mut module) = pair();
    let call = host.seal_call(&mut [0; MAX_DATAGRAM]).expect("fits").to_vec();
    open(&mut module, &call).expect("accepted");
    let mut said = vec![(Side::Host, call)];
    for (_, side, message) in messages().into_iter().chain(messages()) {
        let (from, to) = match side {
            Side::Host => (&mut host, &mut module),
            Side::Module => (&mut module, &mut host),
        };
        said.push((side, seal(from, &message)));
        open(to, &said[said.len() - 1].1).expect("accepted");
    }
    (host, module, said)
}

/// The datagram with another number of session, under a right checksum.
fn in_session(datagram: &[u8], session: u32) -> Vec<u8> {
    let mut other = datagram.to_vec();
    other[8..12].copy_from_slice(&session.to_le_bytes());
    remade(&other)
}

#[test]
fn a_replay_is_a_duplicate_and_changes_nothing() {
    let (mut host, mut module, said) = conversation();
    let before = format!("{host:?} {module:?}");
    for (side, datagram) in said.iter().chain(said.iter().rev()) {
        let to = if *side == Side::Host { &mut module } else { &mut host };
        assert_eq!(open(to, datagram), Err(Class::Duplicate));
    }
    assert_eq!(format!("{host:?} {module:?}"), before);
}

#[test]
fn a_reflection_is_foreign_and_forged_under_another_kind() {
    let (mut host, mut module, said) = conversation();
    for (side, datagram) in &said {
        let (back, kinds) = match side {
            Side::Host => (&mut host, [Kind::ToHost, Kind::Announce]),
            Side::Module => (&mut module, [Kind::ToModule, Kind::Call]),
        };
        assert_eq!(open(back, datagram), Err(Class::Foreign));
        for kind in kinds {
            let mut turned = datagram.clone();
            turned[1] = kind as u8;
            let class = open(back, &remade(&turned)).expect_err("sealed with the key of the other direction");
            // Too short for a nonce, or a kind without session.
            assert!(matches!(class, Class::Forged | Class::Corrupt | Class::Stale), "{class:?}");
        }
    }
}

#[test]
fn old_sessions_are_stale_and_forged_under_the_new_number() {
    let (_, _, said) = conversation();
    // The module booted again, the host did, or the host called once more.
    for (boot, host_nonce) in [(nonce(0xB0), HOST), (BOOT, nonce(0xD0)), (nonce(0xB0), nonce(0xD0))] {
        let (mut host, mut module) =
            (end(Side::Host, &boot, host_nonce), end(Side::Module, &boot, host_nonce));
        for (side, datagram) in &said {
            let to = if *side == Side::Host { &mut module } else { &mut host };
            assert_eq!(open(to, datagram), Err(Class::Stale));
            let claimed = in_session(datagram, to.id());
            assert_eq!(open(to, &claimed), Err(Class::Forged));
        }
        assert!(!host.is_confirmed() && !module.is_confirmed());
        assert_eq!(host.outgoing(), Outgoing::default());
    }
}

#[test]
fn what_others_seal_is_not_followed() {
    let key = fleet_key();
    let other_fleet = FleetKey::new([7; 32]);
    // (who it claims to be, with whose key): a module that was taken apart, or the owner of another fleet.
    let strangers = [
        (key.fleet(), ModuleId(4), key.module(ModuleId(4)), Class::Foreign),
        (key.fleet(), MODULE, key.module(ModuleId(4)), Class::Stale),
        (other_fleet.fleet(), MODULE, other_fleet.module(MODULE), Class::Foreign),
        (key.fleet(), MODULE, other_fleet.module(MODULE), Class::Stale),
    ];
    for (fleet, module, key, class) in strangers {
        for (side, reader) in [(Side::Host, Side::Module), (Side::Module, Side::Host)] {
            let mut stranger = Session::new(side, fleet, module, &key, &BOOT, HOST);
            let mut reader = end(reader, &BOOT, HOST);
            for (_, _, message) in messages() {
                let datagram = seal(&mut stranger, &message);
                assert_eq!(open(&mut reader, &datagram), Err(class));
                let claimed = in_session(&datagram, reader.id());
                let known = open(&mut reader, &claimed);
                let expected = if class == Class::Stale { Class::Forged } else { Class::Foreign };
                assert_eq!(known, Err(expected));
            }
        }
    }
}

#[test]
fn announcements_are_of_one_module_and_one_boot() {
    let key = fleet_key();
    let mut buffer = [0; MAX_DATAGRAM];
    let hello = Message::Hello(Hello { kind: ModuleKind::Rov, firmware: (0, 2, 0), session: 0 });
    let mut announcer = Announcer::new(key.fleet(), MODULE, &key.module(MODULE), BOOT);
    let datagram = announcer.seal(&hello, &mut buffer).expect("fits").to_vec();
    let frame = Frame::parse(&datagram).expect("a datagram");
    assert_eq!(open_announcement(&key.module(MODULE), &frame), Ok(hello));
    assert_eq!(open_announcement(&key.module(ModuleId(4)), &frame), Err(Class::Forged));
    let mut other_boot = datagram.clone();
    other_boot[16] ^= 1;
    let other_boot = remade(&other_boot);
    let frame = Frame::parse(&other_boot).expect("a datagram");
    assert_eq!(open_announcement(&key.module(MODULE), &frame), Err(Class::Forged));
    // It is no way into a session, and no session's datagram is an announcement.
    let (mut host, mut module) = pair();
    assert_eq!(open(&mut module, &datagram), Err(Class::Foreign));
    assert_eq!(open(&mut host, &datagram), Err(Class::Stale));
    let claimed = in_session(&datagram, host.id());
    assert_eq!(open(&mut host, &claimed), Err(Class::Stale));
    for datagram in [seal(&mut module, &Message::Hold), seal(&mut host, &Message::Hold)] {
        let frame = Frame::parse(&datagram).expect("a datagram");
        assert_eq!(open_announcement(&key.module(MODULE), &frame), Err(Class::Foreign));
    }
}

/// ChaCha20-Poly1305 is broken by one nonce used twice under one key.
#[test]
fn no_nonce_is_used_twice_under_a_key() {
    let key = fleet_key();
    let mut seen = HashSet::new();
    let mut note = |epoch: u32, datagram: &[u8]| {
        let header = Frame::parse(datagram).expect("a datagram").header;
        // Which key: announcements of a boot, or one direction of a session.
        let key = (epoch, header.kind == Kind::Announce, header.kind.is_for_host());
        assert!(seen.insert((key, header.session, header.kind as u8, header.sequence)), "{header:?}");
    };
    let mut small = [0; 60];
    for (epoch, first) in (0_u32..).zip([0x10, 0x20, 0x30]) {
        let boot = nonce(first);
        let mut announcer = Announcer::new(key.fleet(), MODULE, &key.module(MODULE), boot);
        let (mut host, mut module) = (end(Side::Host, &boot, HOST), end(Side::Module, &boot, HOST));
        let mut buffer = [0; MAX_DATAGRAM];
        let hello = Message::Hello(Hello { kind: ModuleKind::Rov, firmware: (0, 2, 0), session: 0 });
        for round in 0..200 {
            note(epoch, announcer.seal(&hello, &mut buffer).expect("fits"));
            // A call repeated in the middle of a session counts with it.
            if round % 50 == 0 {
                note(epoch, host.seal_call(&mut buffer).expect("fits"));
            }
            for (_, side, message) in messages() {
                let session = if side == Side::Host { &mut host } else { &mut module };
                // What does not fit uses no number up.
                if let Ok(datagram) = session.seal(&message, &mut small) {
                    note(epoch, datagram);
                }
                note(epoch, &seal(session, &message));
            }
        }
    }
    assert!(seen.len() > 9_000, "{}", seen.len());
}

#[test]
fn no_key_is_shown() {
    let key = FleetKey::new(std::array::from_fn(|k| 0x91 ^ (k as u8).wrapping_mul(73)));
    let module = key.module(MODULE);
    let mut session = Session::new(Side::Host, key.fleet(), MODULE, &module, &BOOT, HOST);
    let announcer = Announcer::new(key.fleet(), MODULE, &module, BOOT);
    let datagram = seal(&mut session, &Message::Hold);
    let frame = Frame::parse(&datagram).expect("a datagram");
    let derived = |length: usize, info: &[&[u8]]| {
        let mut bytes = vec![0; length];
        let hkdf = hkdf::Hkdf::<sha2::Sha256>::from_prk(module.bytes()).expect("32 bytes");
        hkdf.expand_multi_info(info, &mut bytes).expect("short enough");
        bytes
    };
    // The last four bytes of the session's are its public number.
    let secrets = [
        key.bytes().to_vec(),
        module.bytes().to_vec(),
        derived(32, &[b"announce", &BOOT.0]),
        derived(64, &[b"session", &BOOT.0, &HOST.0]),
    ];
    let shown = [
        format!("{key:?} {module:?} {session:?} {announcer:?} {frame:?}"),
        format!("{key:#?} {module:#?} {session:#?} {announcer:#?} {frame:#?}"),
        format!("{key:x?} {module:x?} {session:x?} {announcer:x?} {frame:x?}"),
        format!("{key:#X?} {module:#X?} {session:#X?} {announcer:#X?} {frame:#X?}"),
    ];
    for text in shown {
        let numbers = |radix| -> Vec<u32> {
            let words =
                text.split(|c: char| !c.is_ascii_hexdigit()).map(|word| word.trim_start_matches("0x"));
            words.filter_map(|word| u32::from_str_radix(word, radix).ok()).collect()
        };
        let (decimal, hexadecimal) = (numbers(10), numbers(16));
        let lower = text.to_lowercase();
        for part in secrets.iter().flat_map(|secret| secret.windows(3)) {
            let wanted: Vec<u32> = part.iter().copied().map(u32::from).collect();
            for listed in [&decimal, &hexadecimal] {
                assert!(!listed.windows(3).any(|numbers| numbers == wanted), "{part:02x?} in {text}");
            }
            let joined: String = part.iter().map(|byte| format!("{byte:02x}")).collect();
            assert!(!lower.contains(&joined), "{joined} in {text}");
        }
    }
}

/// What the window must say of `sequence`, by all that came before.
fn oracle(came: &HashSet<u32>, sequence: u32) -> Arrival {
    let newest = came.iter().copied().max();
    match newest {
        Some(newest) if newest.saturating_sub(sequence) >= WINDOW => Arrival::Stale,
        _ if came.contains(&sequence) => Arrival::Duplicate,
        _ => Arrival::Fresh { overtaken: newest > Some(sequence) },
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn the_window_says_what_a_list_of_all_says(
        base in prop_oneof![Just(0), Just(u32::MAX - 400), any::<u32>()],
        steps in prop::collection::vec((0_u32..400, 0_u32..40), 1..300),
    ) {
        let (mut window, mut came, mut reached) = (Window::new(), HashSet::new(), 0);
        for (jump, back) in steps {
            // Mostly near what came last; now and then anywhere.
            let sequence = if back < 35 { reached } else { jump };
            let sequence = base.saturating_add(sequence.saturating_sub(jump % (back * 5 + 1)));
            let expected = oracle(&came, sequence);
            prop_assert_eq!(window.note(sequence), expected);
            if matches!(expected, Arrival::Fresh { .. }) {
                came.insert(sequence);
            }
            reached += back % 3;
            prop_assert_eq!(window.newest(), came.iter().copied().max());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// As many as the window holds, in any order, each any number of times.
    #[test]
    fn within_the_window_every_order_is_accepted_once(
        order in Just((0..WINDOW as usize).collect::<Vec<_>>()).prop_shuffle(),
        again in prop::collection::vec(any::<Index>(), 0..60),
    ) {
        let (mut host, mut module) = pair();
        let datagrams: Vec<_> = (0..WINDOW).map(|k| seal(&mut host, &Message::Commit(k))).collect();
        let (mut accepted, mut newest) = (0, None);
        for (place, &k) in order.iter().enumerate() {
            let opened = open(&mut module, &datagrams[k]);
            let wanted = (Message::Commit(k as u32), newest > Some(k), k as u32);
            prop_assert_eq!(opened.map(|o| (o.message, o.overtaken, o.sequence)), Ok(wanted));
            newest = newest.max(Some(k));
            accepted += 1;
            if let Some(index) = again.get(place) {
                let earlier = order[index.index(place + 1)];
                prop_assert_eq!(open(&mut module, &datagrams[earlier]), Err(Class::Duplicate));
            }
        }
        prop_assert_eq!(accepted, WINDOW);
    }

    /// Loss, doubling and reordering in both directions, counted a second time by hand.
    #[test]
    fn ledgers_are_exact_whatever_the_way_does(
        fates in prop::collection::vec((any::<bool>(), 0_u8..100, 0_usize..300, 0_u8..10), 1..400),
        reports in 0_u64..50,
    ) {
        let mut ends = pair();
        // Under way, each way: number and bytes.
        let mut way: [Vec<(u32, Vec<u8>)>; 2] = [Vec::new(), Vec::new()];
        let mut came = [HashSet::new(), HashSet::new()];
        let (mut late, mut sent) = ([0_u64; 2], [0_u64; 2]);
        let mut incoming = [Incoming::default(); 2];
        let mut last = [Outgoing::default(); 2];
        for (from_host, fate, place, behaviour) in fates {
            let d = usize::from(from_host);
            let sender = if from_host { &mut ends.0 } else { &mut ends.1 };
            let datagram = seal(sender, &Message::Commit(sent[d] as u32));
            let number = sent[d] as u32;
            sent[d] += 1;
            match fate {
                0..15 => {}
                15..30 => way[d].extend([(number, datagram.clone()), (number, datagram)]),
                _ => way[d].push((number, datagram)),
            }
            // Some of what is under way comes, from anywhere in the queue.
            for _ in 0..behaviour % 4 {
                if way[d].is_empty() {
                    break;
                }
                let (number, datagram) = way[d].remove(place % way[d].len());
                let receiver = if from_host { &mut ends.1 } else { &mut ends.0 };
                let expected = oracle(&came[d], number);
                let opened = open(receiver, &datagram);
                incoming[d].count(opened.as_ref().err().copied().unwrap_or(Class::Accepted));
                match expected {
                    Arrival::Fresh { overtaken } => {
                        prop_assert_eq!(opened.map(|o| (o.sequence, o.overtaken)), Ok((number, overtaken)));
                        came[d].insert(number);
                        if behaviour == 9 {
                            receiver.came_late();
                            late[d] += 1;
                        }
                    }
                    Arrival::Duplicate => prop_assert_eq!(opened, Err(Class::Duplicate)),
                    Arrival::Stale => prop_assert_eq!(opened, Err(Class::Stale)),
                }
                prop_assert!(incoming[d].is_exact());
            }
            for (d, end) in [(1, &ends.0), (0, &ends.1)] {
                let now = end.outgoing();
                prop_assert_eq!(now.sent, now.acknowledged + now.late + now.lost + now.under_way());
                prop_assert_eq!(now.sent, sent[d]);
                prop_assert!(now.acknowledged + now.late >= last[d].acknowledged + last[d].late);
                prop_assert!(now.late >= last[d].late);
                prop_assert!(now.acknowledged + now.late <= came[d].len() as u64);
                last[d] = now;
            }
        }
        // The last word of each side is heard: its receipt is all that came to it until then.
        for _ in 0..=reports {
            let datagram = seal(&mut ends.1, &Message::Hold);
            sent[0] += 1;
            prop_assert!(open(&mut ends.0, &datagram).is_ok());
        }
        let of_host = ends.0.outgoing();
        let newest = came[1].iter().max().map_or(0, |newest| u64::from(*newest) + 1);
        prop_assert_eq!(of_host.late, late[1]);
        prop_assert_eq!(of_host.acknowledged, came[1].len() as u64 - late[1]);
        prop_assert_eq!(of_host.lost, newest - came[1].len() as u64);
        prop_assert_eq!(of_host.under_way(), sent[1] - newest);
        let closed = of_host.closed();
        prop_assert_eq!(closed.under_way(), 0);
        prop_assert_eq!(closed.sent, closed.acknowledged + closed.late + closed.lost);
        prop_assert_eq!(u64::from(incoming[1].accepted), came[1].len() as u64);
    }
}
