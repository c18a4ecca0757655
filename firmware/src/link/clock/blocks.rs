//! The exchanges that are kept: the best of each direction, block of time by block of time.
//!
//! A block is the time between two multiples of 2ˢ µs of the own clock. Of its exchanges it keeps the least
//! f = t2 − t1, the greatest b = t3 − t4 and how many there were; which is best is told after taking out the drift as
//! known so far. s begins at 18 (0.26 s). When the room is full, the oldest two neighbours that lie within one block of
//! twice the length become one; once there are none, s grows by one. At s = 23 (8.4 s) the oldest block goes
//! instead. The window so grows with the time the clock has run, up to 16·8.4 s = 134 s, and is always nearly full.
//!
//! Assumptions and limits: 16 blocks of 40 bytes. Blocks older than the window are dropped, however few are left.

use heapless::Deque;

use super::exact::{along, drifted_us};

/// Blocks kept.
pub(super) const BLOCKS: usize = 16;

/// log₂ of the length of a block in µs, at first and at last.
const SHIFT_MIN: u32 = 18;
const SHIFT_MAX: u32 = 23;

/// How one direction saw the fleet clock less the own clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Own clock, µs.
    pub at_us: u64,
    /// t2 − t1 or t3 − t4, µs.
    pub offset_us: i64,
}

impl Sight {
    /// How much more offset this saw than `other` did, at the same time.
    fn above_us(&self, other: &Self, drift_ppb: i32) -> i64 {
        let drifted_us = drifted_us(along(other.at_us, self.at_us), drift_ppb);
        self.offset_us.saturating_sub(other.offset_us).saturating_sub(drifted_us)
    }
}

/// The best of the exchanges that ended within one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// The least t2 − t1, at t1.
    pub forward: Sight,
    /// The greatest t3 − t4, at t4.
    pub backward: Sight,
    /// How many exchanges.
    pub count: u32,
}

impl Block {
    const fn number(&self, shift: u32) -> u64 {
        self.backward.at_us.wrapping_shr(shift)
    }

    fn join(&mut self, later: &Self, drift_ppb: i32) {
        if later.forward.above_us(&self.forward, drift_ppb) <= 0 {
            self.forward = later.forward;
        }
        if later.backward.above_us(&self.backward, drift_ppb) >= 0 {
            self.backward = later.backward;
        }
        self.count = self.count.saturating_add(later.count);
    }
}

/// The best exchanges of each direction, by block of time.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    kept: Deque<Block, BLOCKS>,
    shift: u32,
}

impl Blocks {
    pub(super) const fn new() -> Self {
        Self { kept: Deque::new(), shift: SHIFT_MIN }
    }

    pub(super) fn clear(&mut self) {
        *self = Self::new();
    }

    pub(super) fn len(&self) -> usize {
        self.kept.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Block> {
        self.kept.iter()
    }

    /// Takes in an exchange, a block by itself; none ended later so far.
    pub(super) fn add(&mut self, new: Block, drift_ppb: i32) {
        while self.kept.front().is_some_and(|oldest| {
            new.number(SHIFT_MAX).saturating_sub(oldest.number(SHIFT_MAX)) >= BLOCKS as u64
        }) {
            self.kept.pop_front();
        }
        if !self.fits(&new) {
            self.make_room(drift_ppb);
        }
        let shift = self.shift;
        match self.kept.back_mut().filter(|last| last.number(shift) == new.number(shift)) {
            Some(last) => last.join(&new, drift_ppb),
            // Room was just made.
            None => drop(self.kept.push_back(new)),
        }
    }

    fn fits(&self, new: &Block) -> bool {
        !self.kept.is_full()
            || self.kept.back().is_some_and(|last| last.number(self.shift) == new.number(self.shift))
    }

    fn make_room(&mut self, drift_ppb: i32) {
        while self.kept.is_full() && self.shift < SHIFT_MAX {
            self.join_oldest(drift_ppb);
            if self.kept.is_full() {
                self.shift = self.shift.saturating_add(1);
            }
        }
        if self.kept.is_full() {
            self.kept.pop_front();
        }
    }

    /// Makes one of the oldest two neighbours that lie within one block of twice the length, if there are any.
    fn join_oldest(&mut self, drift_ppb: i32) {
        let twice = self.shift.saturating_add(1);
        let mut joined = false;
        // Round once: every block comes out at the front and goes in at the back.
        for place in 0..self.kept.len() {
            let Some(block) = self.kept.pop_front() else { break };
            let into = |last: &&mut Block| !joined && place > 0 && last.number(twice) == block.number(twice);
            match self.kept.back_mut().filter(into) {
                Some(last) => {
                    last.join(&block, drift_ppb);
                    joined = true;
                }
                None => drop(self.kept.push_back(block)),
            }
        }
    }
}
