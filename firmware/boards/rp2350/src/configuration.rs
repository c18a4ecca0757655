//! The configuration in flash: one sector at the address of `memory.x`, written by `flotilla provision` and by nothing else.
//!
//! The chip shows its flash in memory, so the sector is read like a constant. No program of a module writes flash, and one that did
//! would have to keep away from it.

use protocol::{Configuration, ConfigurationError};

/// Bytes of the sector.
const SECTOR: usize = 4096;

unsafe extern "C" {
    /// Where the linker puts the sector: `memory.x`.
    static __configuration: [u8; SECTOR];
}

/// Reads it.
///
/// # Errors
/// There is none, or none that this build reads.
pub fn read() -> Result<Configuration, ConfigurationError> {
    // SAFETY: `memory.x` places the symbol at a whole sector of flash, in which the linker puts nothing. Bytes of any value
    // are valid, they stay mapped, and no code writes them while a program runs.
    let sector = unsafe { &__configuration };
    Configuration::read(sector)
}
