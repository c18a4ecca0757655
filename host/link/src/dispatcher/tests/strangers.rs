//! Who is named as what, and what the flood of others does to it.

use protocol::{FleetKey, ModuleKind};

use super::super::*;
use super::played::*;

const AT: FleetInstant = FleetInstant(5_000_000);

fn silence(bench: &Bench, number: u16) -> Option<Silence> {
    bench.dispatcher.silence(bench.now, ModuleId(number))
}

/// The datagram with another first byte, and a checksum that is right again.
fn of_version(datagram: &[u8], version: u8) -> Vec<u8> {
    let mut datagram = datagram.to_vec();
    datagram[0] = version;
    let end = datagram.len() - 4;
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&datagram[..end]);
    datagram[end..].copy_from_slice(&checksum.to_le_bytes());
    datagram
}

#[test]
fn a_module_is_named_as_what_it_is() {
    let mut bench = Bench::new(6);
    bench.dispatcher = bench.dispatcher.of_kind(ModuleKind::Modboat);
    bench.now = AT;
    assert!((1..=6).all(|number| silence(&bench, number) == Some(Silence::NeverHeard)));
    assert_eq!(silence(&bench, 7), None, "it is not in the roster");
    // 1 has an older key.
    let older = FleetKey::new([8; 32]);
    let announcement = Played::new(&older, ModuleId(1)).announce();
    assert_eq!(bench.deliver(0, &announcement), Err(Class::Foreign));
    assert_eq!(silence(&bench, 1), Some(Silence::OtherFleet));
    // 2 has other firmware.
    let announcement = of_version(&bench.modules[1].announce(), 3);
    assert_eq!(bench.deliver(1, &announcement), Err(Class::Corrupt));
    assert_eq!(silence(&bench, 2), Some(Silence::OtherVersion(3)));
    // 3 is an ROV.
    bench.join(2);
    assert_eq!((silence(&bench, 3), bench.link(2).kind()), (Some(Silence::Known), None));
    bench.say(2, &rov_report(0, 0));
    assert_eq!(bench.link(2).kind(), Some(ModuleKind::Rov));
    assert_eq!(silence(&bench, 3), Some(Silence::WrongKind));
    // 4 is stopped, 5 only announces itself.
    bench.join(3);
    bench.say(3, &report(0, 0, ModuleState::Stopped));
    assert_eq!(silence(&bench, 4), Some(Silence::Stopped));
    let announcement = bench.modules[4].announce();
    bench.deliver(4, &announcement).expect("genuine");
    assert_eq!(silence(&bench, 5), Some(Silence::Unanswered));
    assert_eq!(silence(&bench, 6), Some(Silence::NeverHeard));
    let mut strangers: Vec<_> = bench.dispatcher.strangers();
    strangers.sort_unstable_by_key(|stranger| stranger.module);
    let named: Vec<_> = strangers.iter().map(|s| (s.what, s.module, s.address, s.heard)).collect();
    let one = |what, number, address| (what, Some(ModuleId(number)), address, AT);
    assert_eq!(
        named,
        [
            one(Strangeness::OtherFleet(older.fleet()), 1, 'a'),
            one(Strangeness::OtherVersion(3), 2, 'b'),
            one(Strangeness::WrongKind(ModuleKind::Rov), 3, 'c'),
        ]
    );
    // What was heard long ago is no reason any more.
    bench.now = FleetInstant(AT.0 + 10_000_000);
    assert_eq!(
        (silence(&bench, 1), silence(&bench, 2)),
        (Some(Silence::NeverHeard), Some(Silence::NeverHeard))
    );
    // A word of one that is known counts more than any hint.
    let announcement = of_version(&bench.modules[3].announce(), 1);
    let _ = bench.deliver(3, &announcement);
    assert_eq!(silence(&bench, 4), Some(Silence::Stopped));
}

/// It announces itself every second: the host need not wait for a report.
#[test]
fn a_kind_is_known_from_an_announcement_of_the_session() {
    let mut bench = Bench::joined(1);
    let announcement = bench.modules[0].announce();
    bench.deliver(0, &announcement).expect("genuine");
    assert_eq!(bench.link(0).kind(), Some(ModuleKind::Modboat));
    bench.modules[0].reboot();
    bench.now = AT;
    bench.join(0);
    assert_eq!(bench.link(0).kind(), None, "of its former boot");
}

#[test]
fn what_has_no_number_may_be_any_module() {
    let mut bench = Bench::new(2);
    bench.now = AT;
    let other = Played::new(&FleetKey::new([8; 32]), ModuleId(1)).announce();
    let announcement = of_version(&other, 1);
    assert_eq!(bench.deliver(0, &announcement), Err(Class::Corrupt));
    assert!((1..=2).all(|number| silence(&bench, number) == Some(Silence::OtherVersion(1))));
    assert_eq!(bench.dispatcher.strangers()[0].module, None);
    // Damage is no other version, nor is a number that is in no roster a stranger.
    let mut damaged = of_version(&other, 4);
    damaged[20] ^= 1;
    assert_eq!(bench.deliver(0, &damaged), Err(Class::Corrupt));
    let unknown = Played::new(&FleetKey::new([8; 32]), ModuleId(9)).announce();
    assert_eq!(bench.deliver(0, &unknown), Err(Class::Foreign));
    assert_eq!(bench.dispatcher.strangers().len(), 1);
}

#[test]
fn a_flood_of_strangers_is_bounded_and_drives_none_out() {
    let mut bench = Bench::new(1);
    bench.now = AT;
    let mut real = Played::new(&FleetKey::new([8; 32]), ModuleId(1));
    let announcement = real.announce();
    let _ = bench.deliver(0, &announcement);
    for k in 0..20_000_u64 {
        bench.now = FleetInstant(AT.0 + k * 1_000);
        let mut key = [9; 32];
        key[..8].copy_from_slice(&k.to_le_bytes());
        // Keys are costly to derive: the header is all that counts.
        let mut forged = announcement.clone();
        forged[2..6].copy_from_slice(&key[..4]);
        let version = forged[0];
        let _ = bench.dispatcher.handle_datagram(bench.now, 'x', &of_version(&forged, version));
        if k % 1_000 == 0 {
            let announcement = real.announce();
            let _ = bench.deliver(0, &announcement);
        }
        assert!(bench.dispatcher.strangers().len() <= 75);
    }
    let fleet = FleetKey::new([8; 32]).fleet();
    let kept = bench.dispatcher.strangers().into_iter().find(|s| s.what == Strangeness::OtherFleet(fleet));
    assert_eq!(kept.map(|stranger| (stranger.address, stranger.count)), Some(('a', 21)));
    assert_eq!(silence(&bench, 1), Some(Silence::OtherFleet));
    assert!(bench.dispatcher.strays().is_exact());
}

#[test]
fn reasons_read_as_sentences() {
    let texts = [
        (Silence::OtherFleet, "seems to have another fleet's key"),
        (Silence::OtherVersion(1), "seems to speak wire version 1, not 2"),
        (Silence::Doubled, "is there twice"),
    ];
    for (silence, text) in texts {
        assert_eq!(silence.to_string(), text);
    }
}
