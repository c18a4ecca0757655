//! How deep the stack has been: `cortex-m-rt` paints it before `main`, and what is not that colour any more was used.

/// What it is painted with (feature `paint-stack`).
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes of stack used at the deepest since boot.
#[must_use]
pub fn high_water() -> usize {
    let (top, mut at) = ((&raw const _stack_start).addr(), &raw const _stack_end);
    // SAFETY: every word between the two is memory of the stack. It may change while it is read, below what is
    // in use now never.
    while at.addr() < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    top - at.addr()
}
