//! UF2 files: their bytes, and every way in which one can be wrong.

use images::uf2::{BLOCK, Family, PAYLOAD, Uf2Error, is_uf2, read, write};
use proptest::prelude::*;

/// One page whose bytes count up, for 0x101ff000.
fn one() -> Vec<u8> {
    let page: Vec<u8> = (0..=255).collect();
    write(Family::ABSOLUTE, [(0x101f_f000, &page[..])]).expect("a file")
}

/// Worked out by hand from Microsoft's description.
#[test]
fn the_bytes_of_a_block_are_golden() {
    let file = one();
    let head = [
        0x55, 0x46, 0x32, 0x0a, 0x57, 0x51, 0x5d, 0x9e, 0x00, 0x20, 0x00, 0x00, 0x00, 0xf0, 0x1f,
        0x10, // "UF2\n", …
        0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x57, 0xff, 0x8b, 0xe4,
    ];
    assert_eq!(file.len(), 512);
    assert_eq!(file[..32], head);
    assert!((0..=255).eq(file[32..288].iter().copied()));
    assert!(file[288..508].iter().all(|byte| *byte == 0));
    assert_eq!(file[508..], [0x30, 0x6f, 0xb1, 0x0a]);
}

#[test]
fn families_have_picotools_names() {
    assert_eq!(Family::RP2350_ARM_S.to_string(), "rp2350-arm-s");
    assert_eq!(Family::ABSOLUTE.to_string(), "absolute");
    assert_eq!(Family(0xE48B_FF56).to_string(), "0xe48bff56");
}

#[test]
fn what_cannot_be_written_is_refused() {
    let long = [0; PAYLOAD + 1];
    for (page, expected) in [
        ((0x1000_0001, &long[..1]), Uf2Error::Alignment(0x1000_0001)),
        ((0x1000_0000, &long[..]), Uf2Error::Page(257)),
    ] {
        assert_eq!(write(Family::ABSOLUTE, [page]), Err(expected));
    }
    assert_eq!(write(Family::ABSOLUTE, [(0, &long[..0]); 0]), Err(Uf2Error::Empty));
}

#[test]
fn every_fault_of_a_file_is_named() {
    let two = write(Family::ABSOLUTE, [(0x1000_0000, &[1][..]), (0x1000_0100, &[2])]).expect("a file");
    let with = |at: usize, byte: u8| {
        let mut file = two.clone();
        file[at] = byte;
        read(&file).map(|_| ()).expect_err("it is wrong")
    };
    let second = BLOCK;
    assert_eq!(with(0, 0), Uf2Error::Magic(1));
    assert_eq!(with(second + 4, 0), Uf2Error::Magic(2));
    assert_eq!(with(second + 511, 0), Uf2Error::Magic(2));
    assert_eq!(with(8, 1), Uf2Error::Flags { block: 1, flags: 0x2001 });
    assert_eq!(with(second + 12, 1), Uf2Error::Alignment(0x1000_0101));
    assert_eq!(with(17, 0), Uf2Error::Payload { block: 1, bytes: 0 });
    assert_eq!(with(second + 20, 0), Uf2Error::Number { block: 2, number: 0, count: 2 });
    assert_eq!(with(24, 3), Uf2Error::Number { block: 1, number: 0, count: 3 });
    assert_eq!(with(second + 28, 0x59), Uf2Error::Family { block: 2, family: Family::RP2350_ARM_S });
    let error = |file| read(file).map(|_| ()).expect_err("it is wrong");
    assert_eq!(error(&two[..1000]), Uf2Error::Length(1000));
    assert_eq!(error(&two[..512]), Uf2Error::Number { block: 1, number: 0, count: 2 });
    assert_eq!(error(&[]), Uf2Error::Empty);
    assert!(is_uf2(&two) && !is_uf2(b"FLOT") && !is_uf2(&[]));
}

proptest! {
    #[test]
    fn what_was_written_is_read(
        family in any::<u32>(),
        pages in prop::collection::vec((any::<u32>(), prop::collection::vec(any::<u8>(), 0..=PAYLOAD)), 1..20),
    ) {
        let pages: Vec<(u32, &[u8])> = pages.iter().map(|(at, bytes)| (at & !0xFF, &bytes[..])).collect();
        let file = write(Family(family), pages.iter().copied()).unwrap();
        let (found, blocks) = read(&file).unwrap();
        prop_assert_eq!((found, blocks.len()), (Family(family), pages.len()));
        for (block, (address, bytes)) in blocks.iter().zip(&pages) {
            prop_assert_eq!(block.address, *address);
            prop_assert_eq!(&block.payload[..bytes.len()], *bytes);
            prop_assert!(block.payload[bytes.len()..].iter().all(|byte| *byte == 0xFF));
        }
    }

    #[test]
    fn takes_anything(file in prop::collection::vec(any::<u8>(), 0..1200), change in any::<(u16, u8)>()) {
        let _ = read(&file);
        let mut file = one();
        file[usize::from(change.0) % BLOCK] = change.1;
        let _ = read(&file);
    }
}
