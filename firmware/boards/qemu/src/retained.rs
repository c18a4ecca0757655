//! What outlives a reset of this board: words behind the memory that its program has, which the emulator clears at its start alone.
//!
//! | words | what |
//! |---|---|
//! | 0 to 3 | the record of the tail's zero, as in the scratch registers of another board's watchdog |
//! | 4 to 7 | where the tail stands: the water does not restart with the processor |

use firmware::modboat::kept_zero::{RetainedMemory, WORDS};

use crate::registers::Registers;

/// The words, as registers. The board's memory of 4 MiB begins 128 KiB before (`memory.x`).
// SAFETY: memory that no section of the program is in, used here alone.
const MEMORY: Registers = unsafe { Registers::at(0x2002_0000) };

/// Bytes of a word.
const WORD: usize = 4;

/// The record of the tail's zero. Nothing but a loop that hangs resets this board, and its memory is clear at a power-on.
#[derive(Debug)]
pub struct Retained;

impl RetainedMemory for Retained {
    fn recall(&mut self) -> Option<[u32; WORDS]> {
        Some([0, 1, 2, 3].map(|word| MEMORY.read(word * WORD)))
    }

    fn keep(&mut self, words: [u32; WORDS]) {
        words.into_iter().enumerate().for_each(|(word, value)| MEMORY.write(word * WORD, value));
    }
}

/// The tail stands there now, rad.
pub fn put_tail(angle_rad: f64) {
    let bits = angle_rad.to_bits();
    for (word, value) in [bits, !bits].into_iter().enumerate() {
        #[expect(clippy::cast_possible_truncation, reason = "its lower half")]
        let halves = [value as u32, (value >> 32) as u32];
        halves.into_iter().enumerate().for_each(|(half, value)| {
            MEMORY.write((4 + 2 * word + half) * WORD, value);
        });
    }
}

/// Where the tail stood at the reset, rad; nothing after a power-on.
#[must_use]
pub fn tail() -> Option<f64> {
    let [bits, check] = [4, 6]
        .map(|word| u64::from(MEMORY.read(word * WORD)) | u64::from(MEMORY.read((word + 1) * WORD)) << 32);
    (bits == !check).then(|| f64::from_bits(bits))
}
