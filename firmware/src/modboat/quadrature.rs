//! From the count of a quadrature encoder and an index switch to the reading of an absolute one.
//!
//! n = ((c − c₀) mod N)·M/N = ⌊((c − c₀) mod N)·r/2⁴⁸⌋,   r = ⌊2⁶⁴/N⌋ + 1
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | c | the counter of the hardware: each edge of both lines, wrapping at 2³² | count |
//! | c₀ | its value at the index | count |
//! | N | counts in one turn of the tail, gears included | count |
//! | n, M | reading, and readings in one turn: [`READINGS`] | reading |
//! | r | its reciprocal, for a division of 64 bits takes a Cortex-M hundreds of instructions; exact for N ≤ 2²⁴ | |
//!
//! The index is a hall switch and a magnet on the axis. It is on over some degrees, so only one of its two edges is meant: the
//! one that is passed into the magnet while the count rises, and out of it while the count falls. That is the same place
//! from either side.
//!
//! Assumptions and limits: an edge counts only while the tail turns slowly, at most [`SLOW_PER_TURN`] of a turn between two
//! updates, or the place would be uncertain by what it moves meanwhile. The first such edge decides. Every later one, at any speed, is
//! held against the count: where it comes further than [`TOLERANCE_PER_TURN`] from the index, beyond what the tail has moved since the
//! update before, counts were lost, and the zero is not known any more ([`Quadrature::take_fault`]). Counts that are lost and found again
//! between two passes are not noticed, nor are any while the tail does not pass its index.

/// Readings in one turn, M.
pub const READINGS: u32 = 1 << 16;

/// Counts in one turn that are told apart at most.
pub const COUNTS_MAX: u32 = 1 << 24;

/// An edge of the index counts where the tail has moved less than a turn by this since the update before: 3 rad/s at 1 kHz.
pub const SLOW_PER_TURN: u32 = 2_000;

/// The index may come a turn by this from where it was found: 0.009 rad, backlash and the switch's hysteresis. *Assumed.*
pub const TOLERANCE_PER_TURN: u32 = 720;

/// Where a tail stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Counts from the index, below those of one turn.
    pub position: u32,
    /// Whether the index is on.
    pub index: bool,
}

/// Absolute readings from a quadrature count and an index switch.
#[derive(Clone, Debug)]
pub struct Quadrature {
    counts_per_turn: u32,
    /// r
    reciprocal: u64,
    /// The counter and the index at the last update.
    last: Option<(i32, bool)>,
    /// The count rose when it changed last.
    rising: Option<bool>,
    /// Counts from the index, 0..N, once that has been seen.
    position: Option<u32>,
    /// What the index must be at the first update for `position` to be believed.
    resumed: Option<bool>,
    fault: bool,
}

impl Quadrature {
    /// Of an encoder with so many counts in one turn of the tail; taken into 1..=[`COUNTS_MAX`].
    #[must_use]
    pub fn new(counts_per_turn: u32) -> Self {
        let counts_per_turn = counts_per_turn.clamp(1, COUNTS_MAX);
        Self {
            counts_per_turn,
            // Of a power of two exactly 2⁶⁴/N.
            reciprocal: u64::MAX.checked_div(u64::from(counts_per_turn)).unwrap_or(0).saturating_add(1),
            last: None,
            rising: None,
            position: None,
            resumed: None,
            fault: false,
        }
    }

    /// The same, whose tail stands at `place` until the first update, as far as is known: it is believed if the index is as it was then.
    #[must_use]
    pub fn resumed_at(self, place: Place) -> Self {
        Self { position: Some(place.position), resumed: Some(place.index), ..self }
    }

    /// Counts in one turn, N.
    #[must_use]
    pub const fn counts_per_turn(&self) -> u32 {
        self.counts_per_turn
    }

    /// Where the tail stood at the last update; nothing before the index was seen.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        let ((_, index), position) = self.last.zip(self.position)?;
        Some(Place { position, index })
    }

    /// Takes in the counter and whether the index is on.
    pub fn update(&mut self, counter: i32, index: bool) {
        let Some((last, index_before)) = self.last.replace((counter, index)) else {
            self.position = self.position.filter(|_| self.resumed == Some(index));
            return;
        };
        let moved = counter.wrapping_sub(last);
        if moved != 0 {
            self.rising = Some(moved > 0);
        }
        self.position = self.position.map(|position| self.beyond(position, moved));
        let slow =
            moved.unsigned_abs() <= self.counts_per_turn.checked_div(SLOW_PER_TURN).unwrap_or(0).max(1);
        let at_edge = index != index_before && self.rising == Some(index);
        match self.position {
            None if slow && at_edge => self.position = Some(0),
            Some(position) if at_edge && self.is_off(position, moved) => {
                self.position = None;
                self.fault = true;
            }
            _ => {}
        }
    }

    /// Whether an index that was passed on the way of `moved` counts to `position` is further off than it may be.
    fn is_off(&self, position: u32, moved: i32) -> bool {
        let allowed = self.counts_per_turn.checked_div(TOLERANCE_PER_TURN).unwrap_or(0).max(2);
        let ahead = if moved < 0 { self.counts_per_turn.saturating_sub(position) } else { position };
        // 0 at `position`, |moved| where it came from: the index lies between the two.
        let behind = self.counts_per_turn.saturating_sub(ahead);
        ahead > moved.unsigned_abs().saturating_add(allowed) && behind > allowed
    }

    /// Whether the index came elsewhere than expected since this was asked last.
    pub fn take_fault(&mut self) -> bool {
        core::mem::take(&mut self.fault)
    }

    /// The reading, 0..[`READINGS`]; nothing before the index was seen.
    #[must_use]
    pub fn reading(&self) -> Option<u32> {
        // n = ⌊p·r/2⁴⁸⌋: p < N, so the product is below 2⁶⁴, and what r is too great by makes less than 1/N of it.
        u32::try_from(u64::from(self.position?).wrapping_mul(self.reciprocal) >> 48).ok()
    }

    /// `position` moved on by `by`, within the turn.
    fn beyond(&self, position: u32, by: i32) -> u32 {
        let per_turn = i64::from(self.counts_per_turn);
        let moved = i64::from(position).saturating_add(i64::from(by));
        // Between two ticks a tail moves by less than a turn; a remainder of 64 bits takes hundreds of instructions.
        let within = if moved < 0 {
            moved.saturating_add(per_turn)
        } else if moved >= per_turn {
            moved.saturating_sub(per_turn)
        } else {
            moved
        };
        let within = if (0..per_turn).contains(&within) {
            within
        } else {
            moved.checked_rem_euclid(per_turn).unwrap_or(0)
        };
        u32::try_from(within).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A magnet over a tenth of a turn, from count 0 up.
    fn index(count: i64, per_turn: u32) -> bool {
        count.rem_euclid(i64::from(per_turn)) * 10 < i64::from(per_turn)
    }

    fn turn(encoder: &mut Quadrature, per_turn: u32, from: i64, to: i64, step: i64) {
        let mut count = from;
        while (to - count) * step.signum() >= 0 {
            encoder.update(count as i32, index(count, per_turn));
            count += step;
        }
    }

    #[test]
    fn the_index_is_one_place_from_either_side() {
        for (per_turn, step) in [(4_800, 1), (4_800, 2), (600, 1), (20_000, 7)] {
            for (from, to) in [(-1_000, 1_000), (1_500, -1_000)] {
                let step = if to > from { step } else { -step };
                let mut encoder = Quadrature::new(per_turn);
                turn(&mut encoder, per_turn, from, to, step);
                let reading = encoder.reading().unwrap_or_else(|| panic!("{per_turn}, {from} to {to}"));
                let last = from + (to - from) / step * step;
                let meant = last.rem_euclid(i64::from(per_turn)) * 65_536 / i64::from(per_turn);
                let off = (i64::from(reading) - meant + 32_768).rem_euclid(65_536) - 32_768;
                assert!(
                    off.abs() <= step.abs() * 65_536 / i64::from(per_turn) + 1,
                    "{per_turn} {step}: {off}"
                );
            }
        }
    }

    #[test]
    fn what_is_not_at_the_index_is_no_zero() {
        let mut encoder = Quadrature::new(4_800);
        turn(&mut encoder, 4_800, 100, 4_000, 1);
        assert_eq!(encoder.reading(), None, "it began on the magnet and left it the wrong way");
        turn(&mut encoder, 4_800, 4_000, 5_000, 100);
        assert_eq!(encoder.reading(), None, "it came too fast");
        let mut still = Quadrature::new(4_800);
        [false, true, false, true].into_iter().for_each(|on| still.update(77, on));
        assert_eq!(still.reading(), None, "a switch that flickers over a tail at rest");
    }

    proptest! {
        /// However it is turned after the zero was found, over any number of turns and of wraps.
        #[test]
        fn the_reading_follows(per_turn in 1_u32..=COUNTS_MAX, start in any::<i32>(), moves in prop::collection::vec(-1_000_000_i32..1_000_000, 1..50)) {
            let mut encoder = Quadrature::new(per_turn);
            encoder.update(start.wrapping_sub(1), false);
            encoder.update(start, true);
            prop_assert_eq!(encoder.reading(), Some(0));
            let (mut counter, mut whole) = (start, 0_i64);
            for by in moves {
                counter = counter.wrapping_add(by);
                whole += i64::from(by);
                encoder.update(counter, true);
                let meant = whole.rem_euclid(i64::from(per_turn)) * 65_536 / i64::from(per_turn);
                prop_assert_eq!(encoder.reading(), u32::try_from(meant).ok());
            }
        }

        #[test]
        fn takes_anything(per_turn in any::<u32>(), inputs in prop::collection::vec(any::<(i32, bool)>(), 0..50)) {
            let mut encoder = Quadrature::new(per_turn);
            for (counter, index) in inputs {
                encoder.update(counter, index);
                prop_assert!(encoder.reading().is_none_or(|reading| reading < READINGS));
            }
        }
    }
}
