use std::vec::Vec;

use super::*;
use crate::message::{Acknowledge, Verdict};
use crate::time::LocalInstant;
use crate::{FleetKey, TimeRequest};

const BOOT: Nonce = Nonce([1; 16]);
const HOST: Nonce = Nonce([2; 16]);
const MODULE: ModuleId = ModuleId(7);

fn pair() -> (Session, Session) {
    let key = FleetKey::new([9; 32]);
    let end = |side| Session::new(side, key.fleet(), MODULE, &key.module(MODULE), &BOOT, HOST);
    (end(Side::Host), end(Side::Module))
}

fn passed(from: &mut Session, to: &mut Session, message: &Message) -> Result<Opened, Class> {
    let mut buffer = [0; MAX_DATAGRAM];
    let datagram = from.seal(message, &mut buffer).expect("fits");
    to.open(&Frame::parse(datagram).expect("a datagram"))
}

#[test]
fn ends_before_its_numbers_do() {
    let (mut host, mut module) = pair();
    (host.sequence, module.sequence) = (u32::MAX - 2, u32::MAX - 2);
    for last in [u32::MAX - 2, u32::MAX - 1] {
        let opened = passed(&mut host, &mut module, &Message::Hold).expect("accepted");
        assert_eq!(opened.sequence, last);
        passed(&mut module, &mut host, &Message::Hold).expect("accepted");
    }
    let mut buffer = [0; MAX_DATAGRAM];
    for end in [&mut host, &mut module] {
        assert_eq!(end.seal(&Message::Hold, &mut buffer), Err(EncodeError::Exhausted));
        assert_eq!(end.seal_call(&mut buffer), Err(EncodeError::Exhausted), "nor a call");
        assert_eq!(buffer, [0; MAX_DATAGRAM], "nothing is sealed");
        assert_eq!(end.sequence, u32::MAX, "for good");
    }
    assert_eq!(host.came.seen, u32::MAX, "the greatest number is never used, so this still counts it");
}

#[test]
fn announcements_end_too() {
    let key = FleetKey::new([9; 32]);
    let mut announcer = Announcer::new(key.fleet(), MODULE, &key.module(MODULE), BOOT);
    announcer.sequence = u32::MAX - 1;
    let mut buffer = [0; MAX_DATAGRAM];
    assert!(announcer.seal(&Message::Hold, &mut buffer).is_ok());
    assert_eq!(announcer.seal(&Message::Hold, &mut buffer), Err(EncodeError::Exhausted));
    assert_eq!(announcer.sent(), u32::MAX);
}

#[test]
fn what_does_not_fit_leaves_nothing_sealed_behind() {
    let message = Message::Acknowledge(Acknowledge { cycle: 7_000_000, verdict: Verdict::Prepared });
    let (mut host, _) = pair();
    let mut buffer = [0; MAX_DATAGRAM];
    let whole = host.clone().seal(&message, &mut buffer).expect("fits").to_vec();
    let sealed = &whole[16..whole.len() - 20];
    for have in 0..whole.len() {
        let mut small = std::vec![0; have];
        assert_eq!(host.seal(&message, &mut small), Err(EncodeError::BufferTooSmall { have }));
        // Under the same number something else is sealed next: with both one would have their difference.
        assert!(!small.windows(sealed.len()).any(|bytes| bytes == sealed), "{have} bytes");
    }
    assert_eq!(host.sequence, 0);
}

/// A module that was taken over may claim what it likes.
#[test]
fn receipts_that_cannot_be_do_not_spoil_the_sums() {
    let claims = [0, 1, 3, 5, 9, u32::MAX];
    let receipts = claims.into_iter().flat_map(|seen| {
        claims.into_iter().flat_map(move |accepted| claims.map(|late| Receipt { seen, accepted, late }))
    });
    for receipt in receipts {
        let (mut host, mut module) = pair();
        for _ in 0..5 {
            host.seal(&Message::Hold, &mut [0; MAX_DATAGRAM]).expect("fits");
        }
        module.came = receipt;
        passed(&mut module, &mut host, &Message::Hold).expect("accepted");
        let Outgoing { sent, acknowledged, late, lost } = host.outgoing();
        let under_way = host.outgoing().under_way();
        assert_eq!((sent, acknowledged + late + lost + under_way), (5, 5), "{receipt:?}");
    }
}

#[test]
fn is_short_with_the_longest_receipt() {
    let (_, mut module) = pair();
    module.came = Receipt { seen: u32::MAX, accepted: u32::MAX, late: u32::MAX };
    let message = Message::TimeRequest(TimeRequest { sent: LocalInstant(u64::MAX) });
    let mut buffer = [0; MAX_DATAGRAM];
    let plain: Vec<u8> = postcard::to_slice(&message, &mut buffer).expect("fits").to_vec();
    assert!(module.seal(&message, &mut buffer).expect("fits").len() <= plain.len() + 64);
    assert!(module.seal_call(&mut buffer).is_ok_and(|call| call.len() <= 1 + 15 + 64));
}

#[test]
fn late_is_no_more_than_what_came() {
    let (mut host, mut module) = pair();
    module.came_late();
    assert_eq!(module.came.late, 0);
    passed(&mut host, &mut module, &Message::Hold).expect("accepted");
    module.came_late();
    module.came_late();
    passed(&mut module, &mut host, &Message::Hold).expect("accepted");
    assert_eq!(host.outgoing(), Outgoing { sent: 1, acknowledged: 0, late: 1, lost: 0 });
}
