//! The zero of a counting encoder over a reset by the watchdog: a record in memory that such a reset leaves alone.
//!
//! ```text
//! every tick   the tail rests, and is held there → record        anything else → no record, before the drive
//! boot         the watchdog's reset, and a record → the count goes on from it, to be held against the index at the next pass
//!              anything else                      → the zero is to be found, as after a power-on
//! ```
//!
//! | word | content |
//! |---|---|
//! | 0 | [`MAGIC`], which names this layout |
//! | 1 | counts from the index; bit 31: the index is on |
//! | 2 | counts in one turn |
//! | 3 | CRC-32 (ISO-HDLC) of the three before, little endian |
//!
//! **When a record is believed.** Nothing counts edges between the last tick and the boot. So there is a record only while the tail does not turn by
//! itself: it has stood still for [`REST_FOR`], the reference stands still, and the drive is no more than holding takes ([`RestWatch`]). It is taken away
//! before the first drive that is more, so that a loop that hangs in that very tick leaves none. What is put out when the loop hangs stays on until the
//! watchdog resets the board, ten ticks later:
//!
//! |Δφ| ≤ ω₀·d_rest·10·Δt = 18 · 0.08 · 0.01 = 0.0144 rad, without any friction
//!
//! which is less than the following error that no module is stopped for, 0.020 rad. In reset the motor is shorted, and while booting shorted or free: a
//! tail at rest stays. What turns it all the same, a hand or a wave, shows in the switch of the index if that has changed, and at the next pass of the
//! index otherwise: the count is off there, which is the fault that every misplaced index is ([`Quadrature::take_fault`]). A stopped module keeps
//! nothing, for it would come back without its stop. A record serves one boot.
//!
//! Assumptions and limits: the board says which reset it was ([`RetainedMemory::recall`]). Turns are counted from zero again: a pose is a point
//! on the circle. Until the index is passed the zero is as good as the rest was.

use protocol::frame::checksum;
use protocol::time::Duration;
use protocol::units::Radians;

use crate::modboat::homing::STILL_FOR;
use crate::modboat::quadrature::{Place, Quadrature};
use crate::modboat::reference::{Reference, wrap};

/// Words of a record.
pub const WORDS: usize = 4;

/// The first word: "zer" and the number of the layout.
pub const MAGIC: u32 = u32::from_le_bytes(*b"zer\x01");

/// No record.
const NOTHING: [u32; WORDS] = [0; WORDS];

/// In word 1: the index is on.
const INDEX_ON: u32 = 1 << 31;

/// A tail that stays within so much of where it stood is at rest, rad: two counts of 4800 in a turn, a third of what the index may be off by.
/// *Assumed.*
pub const REST_RAD: f32 = 0.0026;

/// d_rest, the greatest drive that holds a tail at rest. *Assumed*: a servo that rests between two counts of 4800 in a turn drives by 0.056.
pub const REST_DRIVE: f32 = 0.08;

/// How long it must have been at rest: as long as a tail that a hand has let go of.
pub const REST_FOR: Duration = STILL_FOR;

/// Memory that a reset by the watchdog leaves as it is.
pub trait RetainedMemory {
    /// What stands there, if the watchdog caused the last reset; nothing after a power-on or any other reset.
    fn recall(&mut self) -> Option<[u32; WORDS]>;

    /// Puts a record there.
    fn keep(&mut self, words: [u32; WORDS]);
}

/// The record of a tail that stands there, for an encoder with so many counts in one turn.
#[must_use]
pub fn record(Place { position, index }: Place, counts_per_turn: u32) -> [u32; WORDS] {
    let place = position | if index { INDEX_ON } else { 0 };
    [MAGIC, place, counts_per_turn, check_of([MAGIC, place, counts_per_turn])]
}

/// What a record of the same encoder says; nothing if it is damaged or of another one.
#[must_use]
pub fn read([magic, place, counts, check]: [u32; WORDS], counts_per_turn: u32) -> Option<Place> {
    let position = place & !INDEX_ON;
    let sound = magic == MAGIC
        && check == check_of([magic, place, counts])
        && counts == counts_per_turn
        && position < counts_per_turn;
    sound.then_some(Place { position, index: place & INDEX_ON != 0 })
}

fn check_of([magic, place, counts]: [u32; WORDS - 1]) -> u32 {
    let [m0, m1, m2, m3] = magic.to_le_bytes();
    let [p0, p1, p2, p3] = place.to_le_bytes();
    let [c0, c1, c2, c3] = counts.to_le_bytes();
    checksum(&[m0, m1, m2, m3, p0, p1, p2, p3, c0, c1, c2, c3])
}

/// A [`Quadrature`] with the record of its zero.
#[derive(Debug)]
pub struct KeptQuadrature<M> {
    quadrature: Quadrature,
    memory: M,
    /// What stands in the memory.
    kept: Option<Place>,
}

impl<M: RetainedMemory> KeptQuadrature<M> {
    /// At boot: goes on from the record, if there is one to be believed.
    #[must_use]
    pub fn boot(quadrature: Quadrature, mut memory: M) -> Self {
        let counts_per_turn = quadrature.counts_per_turn();
        let place = memory.recall().and_then(|words| read(words, counts_per_turn));
        memory.keep(NOTHING);
        let quadrature = match place {
            Some(place) => quadrature.resumed_at(place),
            None => quadrature,
        };
        Self { quadrature, memory, kept: None }
    }

    /// Takes in the counter and whether the index is on: the reading, once the zero is known.
    pub fn update(&mut self, counter: i32, index: bool) -> Option<u32> {
        self.quadrature.update(counter, index);
        self.quadrature.reading()
    }

    /// Whether the zero is known.
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.quadrature.place().is_some()
    }

    /// See [`Quadrature::take_fault`].
    pub fn take_fault(&mut self) -> bool {
        self.quadrature.take_fault()
    }

    /// See [`Encoder::keep_zero`](crate::modboat::encoder::Encoder::keep_zero).
    pub fn keep_zero(&mut self, resting: bool) {
        let place = if resting { self.quadrature.place() } else { None };
        if place == self.kept {
            return;
        }
        self.kept = place;
        let words = place.map_or(NOTHING, |place| record(place, self.quadrature.counts_per_turn()));
        self.memory.keep(words);
    }
}

/// Whether a tail stands still where it is held, and is driven no more than that takes.
#[derive(Clone, Debug)]
pub struct RestWatch {
    ticks_needed: u32,
    /// Where it was when it came to rest, rad.
    at_rad: f32,
    /// Ticks since then.
    ticks: u32,
}

impl RestWatch {
    /// Of a tail that is looked at every `interval`.
    #[must_use]
    pub fn new(interval: Duration) -> Self {
        let ticks_needed = REST_FOR.0.checked_div(interval.0).unwrap_or(u32::MAX);
        Self { ticks_needed, at_rad: f32::NAN, ticks: 0 }
    }

    /// Takes in one tick: where the tail is, where it should be, and the drive that is about to go out. Whether it rests.
    pub fn update(&mut self, pose: Radians, reference: &Reference, drive: f32) -> bool {
        let held = reference.is_at_rest() && libm::fabsf(drive) <= REST_DRIVE;
        let near = libm::fabsf(wrap(pose.0 - self.at_rad)) <= REST_RAD;
        if held && near {
            self.ticks = self.ticks.saturating_add(1);
        } else {
            (self.at_rad, self.ticks) = (pose.0, 0);
        }
        self.ticks >= self.ticks_needed
    }

    /// The tail is not held any more.
    pub const fn forget(&mut self) {
        self.ticks = 0;
    }
}

#[cfg(test)]
mod tests;
