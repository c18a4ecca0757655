//! The program of a PIO state machine that counts the edges of a quadrature encoder, each edge of both lines.
//!
//! ```text
//! A  __/▔▔▔▔\____/▔▔▔▔\____          count up: A rises before B does
//! B  ____/▔▔▔▔\____/▔▔▔▔\__
//!    0 1 2  3 4 …
//! ```
//!
//! The lines before and the lines now make the four bits of an address; what stands there is a jump to what that means: one
//! more, one less, or nothing. Both lines at once mean nothing: one edge was missed, and its direction is unknown.
//!
//! The count is put into [`ENTRY`] of the state machine's receive queue over and over: the queue is four registers then
//! (`FJOIN_RX_PUT`), and a reader of one gets the newest count, without a wait and without a stale one before it.
//!
//! | register | what it holds |
//! |---|---|
//! | X | the count, wrapping at 2³² |
//! | Y | in its lowest two bits the lines before: A is bit 0, B is bit 1 |
//! | ISR | what goes out, then the address |
//!
//! It takes [`CYCLES_MAX`] cycles from one look at the lines to the next, at 150 MHz 73 ns: 13 million counts a second. Encoders
//! of tails make some ten thousand.
//!
//! Assumptions and limits: A and B are two pins in a row, A the lower; the address is the program's, so it must stand at the
//! start of the instruction memory, and the input shifts to the left. What Y says of the lines at the start may be wrong: the count
//! begins within one of where X stood. A spike shorter than a look is not seen, and a longer one counts up and down again.
//!
//! Source: RP2350 datasheet, section 11.4; the receive queue as registers is 11.4.8.

use pio::{Program, RP2040_MAX_PROGRAM_SIZE};

/// Which register of the queue has the count.
pub const ENTRY: usize = 0;

/// Cycles from one look at the lines to the next, at most.
pub const CYCLES_MAX: u32 = 11;

/// The program.
#[must_use]
pub fn program() -> Program<RP2040_MAX_PROGRAM_SIZE> {
    pio::pio_asm!(
        ".origin 0",
        // 16 jumps: the address is BA before, BA now.
        "    jmp publish", // 00 00
        "    jmp more",    // 00 01: A rose while B was low
        "    jmp less",    // 00 10: B rose while A was low
        "    jmp publish", // 00 11
        "    jmp less",    // 01 00: A fell while B was low
        "    jmp publish", // 01 01
        "    jmp publish", // 01 10
        "    jmp more",    // 01 11: B rose while A was high
        "    jmp more",    // 10 00: B fell while A was low
        "    jmp publish", // 10 01
        "    jmp publish", // 10 10
        "    jmp less",    // 10 11: A rose while B was high
        "    jmp publish", // 11 00
        "    jmp less",    // 11 01: B fell while A was high
        "    jmp more",    // 11 10: A fell while B was high
        "    jmp publish", // 11 11
        "less:",
        // One less, and on in the next line whether there was a jump or, at zero, none.
        "    jmp x-- publish",
        ".wrap_target",
        "publish:",
        // The count to where the processor reads it.
        "    mov isr, x",
        "    mov rxfifo[0], isr",
        // The address: nothing, the lines before, the lines now.
        "    mov isr, null",
        "    in y, 2",
        "    in pins, 2",
        // What is now is before, next time; the older lines above it do not matter.
        "    mov y, isr",
        "    mov pc, isr",
        "more:",
        // There is no addition: x + 1 = ¬(¬x − 1).
        "    mov x, ~x",
        "    jmp x-- added",
        "added:",
        "    mov x, ~x",
        ".wrap",
    )
    .program
}

#[cfg(test)]
mod emulator;
#[cfg(test)]
mod tests;
