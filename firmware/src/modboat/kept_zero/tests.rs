use std::cell::RefCell;
use std::rc::Rc;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

const COUNTS: u32 = 4_800;

/// Registers, and whether the watchdog caused the last reset.
#[derive(Clone, Default)]
struct Registers(Rc<RefCell<([u32; WORDS], bool)>>);

impl RetainedMemory for Registers {
    fn recall(&mut self) -> Option<[u32; WORDS]> {
        let (words, by_watchdog) = *self.0.borrow();
        by_watchdog.then_some(words)
    }

    fn keep(&mut self, words: [u32; WORDS]) {
        self.0.borrow_mut().0 = words;
    }
}

/// Boots with these words in its registers.
fn boot(words: [u32; WORDS], by_watchdog: bool) -> KeptQuadrature<Registers> {
    KeptQuadrature::boot(Quadrature::new(COUNTS), Registers(Rc::new(RefCell::new((words, by_watchdog)))))
}

fn place() -> Place {
    Place { position: 1_234, index: false }
}

#[test]
fn the_layout_is_fixed() {
    // The checksum by zlib's crc32 of Python 3.11 over b"zer\x01" and 0x800004d2 and 4800, little endian.
    let on = Place { index: true, ..place() };
    assert_eq!(record(on, COUNTS), [0x0172_657a, 0x8000_04d2, 4_800, 0x1992_a89e]);
}

#[test]
fn goes_on_from_its_record_once() {
    let mut encoder = boot(record(place(), COUNTS), true);
    assert_eq!(encoder.memory.0.borrow().0, [0; WORDS], "it serves one boot");
    // The counter of the hardware begins anywhere.
    assert_eq!(encoder.update(-7, false), Some(1_234 * 65_536 / COUNTS));
    assert_eq!(encoder.update(-7 + 66, false), Some(1_300 * 65_536 / COUNTS));
    assert!(encoder.is_homed() && !encoder.take_fault());
    encoder.keep_zero(true);
    assert_eq!(encoder.memory.0.borrow().0, record(Place { position: 1_300, index: false }, COUNTS));
    encoder.keep_zero(false);
    assert_eq!(encoder.memory.0.borrow().0, [0; WORDS]);
}

#[test]
fn every_damaged_bit_is_refused() {
    let whole = record(place(), COUNTS);
    for bit in 0..WORDS * 32 {
        let mut words = whole;
        words[bit / 32] ^= 1 << (bit % 32);
        assert_eq!(read(words, COUNTS), None, "bit {bit}");
        let mut encoder = boot(words, true);
        assert_eq!((encoder.update(0, false), encoder.is_homed()), (None, false), "bit {bit}");
    }
    assert_eq!(read([0; WORDS], COUNTS), None);
    assert_eq!(read([u32::MAX; WORDS], COUNTS), None);
}

#[test]
fn what_is_not_the_watchdogs_or_of_this_encoder_is_refused() {
    let whole = record(place(), COUNTS);
    assert_eq!(boot(whole, false).update(0, false), None, "a power-on");
    assert_eq!(boot(whole, true).update(0, true), None, "the index is on, and was not");
    assert_eq!(boot(record(place(), 4_804), true).update(0, false), None, "another encoder");
    assert_eq!(read(record(Place { position: COUNTS, index: false }, COUNTS), COUNTS), None, "beyond a turn");
}

#[test]
fn without_a_zero_nothing_is_kept() {
    let mut encoder = boot([0; WORDS], true);
    encoder.update(5, false);
    encoder.keep_zero(true);
    assert_eq!(encoder.memory.0.borrow().0, [0; WORDS]);
}

/// Each pose, reference and drive of a row, a tick each.
fn rests(rows: &[(f32, Reference, f32)]) -> Vec<bool> {
    // Three ticks are as long as it must rest.
    let mut watch = RestWatch::new(Duration(REST_FOR.0 / 3));
    rows.iter().map(|(pose, reference, drive)| watch.update(Radians(*pose), reference, *drive)).collect()
}

#[test]
fn a_tail_rests_that_is_held_where_it_stands() {
    let at = Reference::at_rest(1.0);
    let still = (1.0, at, 0.01);
    assert_eq!(rests(&[still; 5]), [false, false, false, true, true]);
    let turned = Reference { rate_rad_s: 1e-3, ..at };
    let begins = Reference { acceleration_rad_s2: -1.0, ..at };
    let unknown = Reference { rate_rad_s: f32::NAN, ..at };
    for broken in [
        (1.0 + 2.0 * REST_RAD, at, 0.01),
        (1.0, turned, 0.01),
        (1.0, begins, 0.01),
        (1.0, unknown, 0.01),
        (1.0, at, -0.09),
        (1.0, at, f32::NAN),
        (f32::NAN, at, 0.01),
    ] {
        let seen = rests(&[still, still, still, still, broken, still, still, still]);
        assert_eq!(seen[..7], [false, false, false, true, false, false, false], "{broken:?}");
    }
    // A count more and less is no turn, and the other side of π is near.
    let beside =
        [6e-4, -6e-4, 1e-4, -1e-4, 6e-4].map(|beside: f32| beside - core::f32::consts::PI.copysign(beside));
    let flickers = beside.map(|pose| (pose, at, 0.01));
    assert_eq!(rests(&flickers), [false, false, false, true, true]);
    // Slowly away.
    let creeps: Vec<_> = (0_u8..9).map(|tick| (1.0 + f32::from(tick) * 0.9 * REST_RAD, at, 0.01)).collect();
    assert!(!rests(&creeps).contains(&true));
}

proptest! {
    #[test]
    fn a_record_is_read_as_it_was_written(counts in 1_u32..=crate::modboat::quadrature::COUNTS_MAX, at in any::<u32>(), index in any::<bool>()) {
        let place = Place { position: at % counts, index };
        prop_assert_eq!(read(record(place, counts), counts), Some(place));
    }

    #[test]
    fn any_words_are_taken(words in any::<[u32; WORDS]>(), counts in any::<u32>()) {
        let mut encoder = KeptQuadrature::boot(Quadrature::new(counts), Registers(Rc::new(RefCell::new((words, true)))));
        prop_assert!(encoder.update(0, false).is_none(), "a record by chance");
    }
}
