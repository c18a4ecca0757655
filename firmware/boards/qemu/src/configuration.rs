//! The configuration block in memory: the image of `flotilla provision`, where the linker says it is.

unsafe extern "C" {
    static __configuration: u8;
    static __configuration_length: u8;
}

/// The block of memory that holds the image.
#[must_use]
pub fn block() -> &'static [u8] {
    // SAFETY: `memory.x` gives an address and a length inside the memory of the board that nothing else is linked to and no code writes
    // to; the symbols themselves are no bytes, only their addresses mean something.
    unsafe {
        core::slice::from_raw_parts(&raw const __configuration, (&raw const __configuration_length).addr())
    }
}
