//! Linked programs: what is loaded where, sections, functions.

use crate::made::{Part, program, usual};
use images::elf::{ElfError, Program};
use images::size_table::{Row, rendered};
use images::uf2;

/// The flash that a program fills, by address.
fn flash(elf: &[u8]) -> Result<Vec<(u32, Vec<u8>)>, ElfError> {
    let file = Program::read(elf)?.uf2()?;
    let (family, blocks) = uf2::read(&file)?;
    assert_eq!(family, uf2::Family::RP2350_ARM_S);
    Ok(blocks.iter().map(|block| (block.address, block.payload.to_vec())).collect())
}

fn part(load: u32, bytes: &[u8]) -> Part<'_> {
    Part { name: ".text", address: load, load: Some(load), bytes }
}

#[test]
fn pieces_are_put_together_page_by_page() {
    let pages = flash(&usual(&[])).expect("a program");
    let addresses: Vec<u32> = pages.iter().map(|(address, _)| *address).collect();
    // 792 bytes of vector table, block and code, then constants and the rest from 0x400 on.
    assert_eq!(addresses, [0x1000_0000, 0x1000_0100, 0x1000_0200, 0x1000_0300, 0x1000_0400]);
    let whole: Vec<u8> = pages.into_iter().flat_map(|(_, bytes)| bytes).collect();
    let ranges = [(0x11, 0, 72), (0x22, 72, 92), (0x33, 92, 792), (0xFF, 792, 1024), (0x44, 1024, 1124)];
    let copied = [(0x55, 1124, 1164), (0x66, 1164, 1172), (0xFF, 1172, 1280)];
    for (byte, from, to) in ranges.into_iter().chain(copied) {
        assert!(whole[from..to].iter().all(|found| *found == byte), "{byte:#x} from {from} to {to}");
    }
}

#[test]
fn pieces_need_no_order_and_no_alignment() {
    let parts = [part(0x1000_1ffd, &[7; 5]), part(0x1000_0010, &[8; 3])];
    let pages = flash(&program(&parts, &[])).expect("a program");
    let [first, second, third] = &pages[..] else { panic!("{pages:?}") };
    assert_eq!((first.0, second.0, third.0), (0x1000_0000, 0x1000_1f00, 0x1000_2000));
    assert_eq!((&first.1[15..20], &second.1[252..]), (&[255, 8, 8, 8, 255][..], &[255, 7, 7, 7][..]));
    assert_eq!(third.1[..3], [7, 7, 255]);
}

#[test]
fn what_overlaps_must_agree() {
    let same = [part(0x1000_0000, &[1, 2, 3]), part(0x1000_0002, &[3, 4])];
    assert_eq!(flash(&program(&same, &[])).expect("a program")[0].1[..5], [1, 2, 3, 4, 255]);
    let other = [part(0x1000_0000, &[1, 2, 3]), part(0x1000_0002, &[9])];
    assert!(matches!(flash(&program(&other, &[])), Err(ElfError::Overlap(0x1000_0002))));
}

#[test]
fn what_is_no_program_for_the_board_is_refused() {
    for (at, expected) in [(0, 0), (0x2000_0000, 0x2000_0000), (0x11ff_ffff, 0x1200_0000)] {
        let found = flash(&program(&[part(at, &[1, 2])], &[]));
        assert!(matches!(found, Err(ElfError::NotFlash(address)) if address == expected), "{found:?}");
    }
    assert!(matches!(flash(b"#!/bin/sh"), Err(ElfError::Read(_))));
    let nothing = Part { name: ".bss", address: 0x2000_0000, load: None, bytes: &[0; 4] };
    assert!(matches!(flash(&program(&[nothing], &[])), Err(ElfError::Uf2(uf2::Uf2Error::Empty))));
    let good = usual(&["main"]);
    for length in 0..good.len() {
        // Whatever is cut off: an error, and no panic.
        let cut = Program::read(&good[..length])
            .map(|program| (program.uf2().is_ok(), program.sections().is_ok(), program.functions().is_ok()));
        assert!(!matches!(cut, Ok((true, true, true))), "{length} of {} bytes", good.len());
    }
}

#[test]
fn flash_and_ram_are_told_apart() {
    let elf = usual(&[]);
    let row = Row::measure("pico2w", &Program::read(&elf).expect("a program")).expect("sections");
    assert_eq!((row.flash(), row.ram()), (72 + 20 + 700 + 100 + 40 + 8, 40 + 3000 + 1024));
    let table = rendered(&[row]);
    assert!(
        table.ends_with("\n| `pico2w` | 72 | 20 | 700 | 100 | 40 | 3000 | 1024 | 8 | 940 | 4064 |\n"),
        "{table}"
    );
}

#[test]
fn functions_have_rusts_names() {
    let elf = usual(&["main", "_ZN4core9panicking5panic17h0123456789abcdefE", "main"]);
    let program = Program::read(&elf).expect("a program");
    assert_eq!(program.functions().expect("symbols"), ["core::panicking::panic", "main"]);
    let stripped = usual(&[]);
    let found = Program::read(&stripped).expect("a program").functions();
    assert!(matches!(found, Err(ElfError::NoSymbols)));
}
