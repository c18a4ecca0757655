//! Stack depth: `cortex-m-rt` paints the stack before `main`, and what is not that colour any more was used.

/// What it is painted with (feature `paint-stack`).
const PAINT: u32 = 0xcccc_cccc;

/// Words that one look takes: all of the stack at once would keep the main loop from its network for a millisecond.
const LOOK: usize = 256;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Looks for the end of the paint, a piece at a time.
#[derive(Debug)]
pub struct Stack {
    at: *const u32,
    high_water: usize,
}

impl Stack {
    /// Nothing is known yet.
    #[must_use]
    pub fn new() -> Self {
        Self { at: &raw const _stack_end, high_water: 0 }
    }

    /// Looks at the next piece.
    pub fn look(&mut self) {
        let top = (&raw const _stack_start).addr();
        for _ in 0..LOOK {
            // SAFETY: every word between the two is memory of the stack. It may change while it is read, below what is
            // in use now never.
            if self.at.addr() >= top || unsafe { self.at.read_volatile() } != PAINT {
                self.high_water = top.saturating_sub(self.at.addr());
                self.at = &raw const _stack_end;
                return;
            }
            self.at = self.at.wrapping_add(1);
        }
    }

    /// Bytes used at the deepest when the looks were last through; 0 before.
    #[must_use]
    pub fn high_water(&self) -> usize {
        self.high_water
    }
}

impl Default for Stack {
    fn default() -> Self {
        Self::new()
    }
}
