//! Registers of the bus, the only way in which this board touches it.

/// A block of 32-bit registers at a fixed address.
#[derive(Debug)]
pub struct Registers(usize);

impl Registers {
    /// The block at `address`.
    ///
    /// # Safety
    /// A block of registers must be there, and the bytes at the offsets used must be registers of it that may be read and written in
    /// this way. No other block may exist that this one interferes with.
    pub const unsafe fn at(address: usize) -> Self {
        Self(address)
    }

    /// Reads the register at `offset`, bytes.
    pub fn read(&self, offset: usize) -> u32 {
        // SAFETY: a register is there, as `at` was promised; aligned, as offsets here are multiples of four.
        unsafe { ((self.0 + offset) as *const u32).read_volatile() }
    }

    /// Writes the register at `offset`, bytes.
    pub fn write(&self, offset: usize, value: u32) {
        // SAFETY: as in `read`.
        unsafe { ((self.0 + offset) as *mut u32).write_volatile(value) }
    }
}
