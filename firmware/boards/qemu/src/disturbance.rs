//! What goes wrong around the firmware, for tests: by words on the emulator's command line, each with a time of the board's own clock in
//! milliseconds (`-semihosting-config …,arg=block,arg=9000`).
//!
//! | word | from then on |
//! |---|---|
//! | `swap` | the leads of the motor are swapped |
//! | `block` | something holds the tail |
//! | `lose` | the counter misses an edge every millisecond, [`LOST`] in all |
//! | `hang` | the control loop hangs for [`HANGS_S`], its outputs as they are, and the board is reset: its time begins again |
//! | `sag` | the battery shows [`SAGGED`], for [`SAGS_FOR`] |
//!
//! `turned` has an angle in its place, in thousandths of a radian: so far a hand turns the tail while the board restarts.

use cortex_m::peripheral::SCB;
use protocol::time::{Duration, LocalInstant};
use protocol::units::Volts;

use crate::{motor, semihosting};

/// Edges that are missed: 0.08 rad of 4800 in a turn.
pub const LOST: u32 = 60;

/// Ten ticks, which the watchdog of another board waits for. This one's is not used: the emulator lets it expire while a debugger holds the
/// processor.
pub const HANGS_S: f64 = 0.01;

/// Below what a Modboat takes for low, 6.4 V.
pub const SAGGED: Volts = Volts(6.0);

/// Longer than the hold-off of the battery watch, 2 s.
pub const SAGS_FOR: Duration = Duration(4_000_000);

/// What is to go wrong, and when.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disturbances {
    swap: Option<LocalInstant>,
    block: Option<LocalInstant>,
    lose: Option<LocalInstant>,
    hang: Option<LocalInstant>,
    sag: Option<LocalInstant>,
}

impl Disturbances {
    /// Those of the command line.
    #[must_use]
    pub fn asked_for() -> Self {
        let at = |word| Some(LocalInstant(u64::from(semihosting::number_after(word)?) * 1_000));
        Self { swap: at("swap"), block: at("block"), lose: at("lose"), hang: at("hang"), sag: at("sag") }
    }

    /// Lets it be `now` at the motor. Does not return where the board is reset.
    pub fn act(&self, now: LocalInstant) {
        let is = |from: Option<LocalInstant>| from.is_some_and(|from| from <= now);
        let lost = self.lose.map_or(0, |from| (now.since(from).0 / 1_000).min(LOST));
        motor::disturb(is(self.swap), is(self.block), lost);
        if is(self.hang) {
            motor::step(HANGS_S);
            SCB::sys_reset();
        }
    }

    /// What the battery shows, whose voltage is `full` otherwise.
    #[must_use]
    pub fn battery(&self, now: LocalInstant, full: Volts) -> Volts {
        let sags = self.sag.is_some_and(|from| from <= now && now < from.after(SAGS_FOR));
        if sags { SAGGED } else { full }
    }
}
