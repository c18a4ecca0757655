use super::emulator::StateMachine;
use super::*;

/// The lines BA at each count of a turn of the code, in the order of a rising count.
const LINES: [u32; 4] = [0b00, 0b01, 0b11, 0b10];

/// What the encoder shows at `count`; the other pins show something else.
fn pins(count: i64, others: u64) -> u32 {
    LINES[count.rem_euclid(4) as usize] | (others as u32) << 2
}

/// Marsaglia's xorshift: the same walks every time.
struct Walk(u64);

impl Walk {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
}

/// A state machine that has looked at the lines of `count` for a while.
fn started(count: i64, x: u32) -> StateMachine {
    let mut machine = StateMachine::new(&program());
    machine.x = x;
    (0..3 * CYCLES_MAX).for_each(|_| machine.step(pins(count, 0)));
    machine
}

#[test]
fn fits_and_stands_where_its_table_must() {
    let program = program();
    assert_eq!(program.origin, Some(0));
    assert_eq!(program.version, pio::PioVersion::V1);
    assert!(program.code.len() <= RP2040_MAX_PROGRAM_SIZE, "{} instructions", program.code.len());
    assert_eq!(ENTRY, 0);
}

#[test]
fn begins_within_one_of_where_it_stood() {
    for count in 0..4 {
        for x in [0, 1, 5, u32::MAX] {
            let off = started(count, x).entries[ENTRY].wrapping_sub(x) as i32;
            assert!(off.abs() <= 1, "count {count}, from {x}: off by {off}");
        }
    }
}

#[test]
fn follows_any_walk() {
    for (seed, x) in [(1, 0_u32), (2, 3), (3, u32::MAX - 2), (4, 1 << 31)] {
        let mut walk = Walk(0x9e37_79b9_7f4a_7c15 ^ seed);
        let mut count = seed as i64;
        let mut machine = started(count, x);
        let (zero, first) = (machine.entries[ENTRY], count);
        for turn in 0..200_000 {
            // Runs of one direction, so that it goes far, and steps to and fro.
            let up = match turn / 1_000 % 3 {
                0 => walk.next() & 1 == 0,
                1 => true,
                _ => false,
            };
            count += if up { 1 } else { -1 };
            // From as fast as it can follow to slow.
            let cycles = u64::from(CYCLES_MAX) + walk.next() % 40;
            (0..cycles).for_each(|_| machine.step(pins(count, walk.next())));
            let behind = (count - first) - i64::from(machine.entries[ENTRY].wrapping_sub(zero) as i32);
            assert!(behind.abs() <= 2, "seed {seed}, edge {turn}: {behind} behind");
        }
        (0..3 * CYCLES_MAX).for_each(|_| machine.step(pins(count, 0)));
        let counted = i64::from(machine.entries[ENTRY].wrapping_sub(zero) as i32);
        assert_eq!(counted, count - first, "seed {seed}");
    }
}

#[test]
fn goes_through_zero_and_the_wrap_either_way() {
    for (from, by) in [(2, -5), (-2, 5)] {
        let mut machine = started(0, from as u32);
        let zero = machine.entries[ENTRY] as i32;
        let step = i64::from(by) / 5;
        for count in 1..=5 {
            (0..2 * CYCLES_MAX).for_each(|_| machine.step(pins(step * count, 0)));
        }
        assert_eq!(machine.entries[ENTRY] as i32, zero + by);
    }
}

#[test]
fn a_spike_leaves_no_trace_and_both_lines_at_once_mean_nothing() {
    let mut machine = started(0, 100);
    let before = machine.entries[ENTRY];
    for lines in [0b01, 0b00, 0b10, 0b00, 0b11, 0b00, 0b11, 0b01, 0b10, 0b00] {
        (0..2 * CYCLES_MAX).for_each(|_| machine.step(lines));
    }
    // Up, down; down, up; nothing, nothing, nothing; down (B fell), nothing, up (B fell).
    assert_eq!(machine.entries[ENTRY], before);
}

#[test]
fn is_as_fast_as_it_says() {
    let mut machine = started(0, 0);
    let (mut looks, mut since, mut slowest, mut count) = (0, 0, 0, 0_i64);
    let look = program().code.iter().position(|code| *code == 0b0100_0000_0000_0010).unwrap() as u8;
    while looks < 1_000 {
        if machine.pc == look {
            slowest = slowest.max(since);
            (looks, since) = (looks + 1, 0);
            count += if looks % 7 < 4 { 1 } else { -1 };
        }
        machine.step(pins(count, 0));
        since += 1;
    }
    assert_eq!(slowest, CYCLES_MAX);
}
