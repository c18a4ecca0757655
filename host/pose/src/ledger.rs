//! What became of every frame and of every body in it, to the last one.
//!
//! ```text
//! frames:  received = accepted + doubled + off the clock + out of order + frozen + without a body
//! bodies:  received = accepted + untracked + not finite + teleported        (of frames that got as far as their bodies)
//! ```

use std::fmt;

use serde::Serialize;

/// Why a frame was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameFault {
    /// It has come before.
    Doubled,
    /// Its stamp does not fit the server's clock.
    OffTheClock,
    /// It is older than the newest.
    OutOfOrder,
    /// No body has moved in the last digit for the time that is allowed: the stream is frozen.
    Frozen,
    /// No body of it was accepted.
    WithoutBody,
}

/// Why a body of a frame was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyFault {
    /// The server did not see it.
    Untracked,
    /// Its position or attitude is no number, or its attitude no turn.
    NotFinite,
    /// It is further from where it was than anything moves.
    Teleported,
}

/// Frames by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[expect(missing_docs, reason = "the classes are those of `FrameFault`")]
pub struct Frames {
    pub received: u64,
    pub accepted: u64,
    pub doubled: u64,
    pub off_the_clock: u64,
    pub out_of_order: u64,
    pub frozen: u64,
    pub without_body: u64,
}

/// Bodies by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[expect(missing_docs, reason = "the classes are those of `BodyFault`")]
pub struct Bodies {
    pub received: u64,
    pub accepted: u64,
    pub untracked: u64,
    pub not_finite: u64,
    pub teleported: u64,
}

/// The whole account.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ledger {
    /// Frames.
    pub frames: Frames,
    /// Bodies of the frames that got as far as their bodies.
    pub bodies: Bodies,
}

impl Ledger {
    /// Enters a frame.
    pub fn enter_frame(&mut self, became: Result<(), FrameFault>) {
        let frames = &mut self.frames;
        frames.received += 1;
        *match became {
            Ok(()) => &mut frames.accepted,
            Err(FrameFault::Doubled) => &mut frames.doubled,
            Err(FrameFault::OffTheClock) => &mut frames.off_the_clock,
            Err(FrameFault::OutOfOrder) => &mut frames.out_of_order,
            Err(FrameFault::Frozen) => &mut frames.frozen,
            Err(FrameFault::WithoutBody) => &mut frames.without_body,
        } += 1;
    }

    /// Enters a body.
    pub fn enter_body(&mut self, became: Result<(), BodyFault>) {
        let bodies = &mut self.bodies;
        bodies.received += 1;
        *match became {
            Ok(()) => &mut bodies.accepted,
            Err(BodyFault::Untracked) => &mut bodies.untracked,
            Err(BodyFault::NotFinite) => &mut bodies.not_finite,
            Err(BodyFault::Teleported) => &mut bodies.teleported,
        } += 1;
    }

    /// Whether both accounts balance.
    pub fn balances(&self) -> bool {
        let (f, b) = (&self.frames, &self.bodies);
        let frames = f.accepted + f.doubled + f.off_the_clock + f.out_of_order + f.frozen + f.without_body;
        let bodies = b.accepted + b.untracked + b.not_finite + b.teleported;
        f.received == frames && b.received == bodies
    }
}

impl fmt::Display for Ledger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (frames, bodies) = (&self.frames, &self.bodies);
        write!(f, "{} frames = {} accepted", frames.received, frames.accepted)?;
        for (count, class) in [
            (frames.doubled, "doubled"),
            (frames.off_the_clock, "off the clock"),
            (frames.out_of_order, "out of order"),
            (frames.frozen, "frozen"),
            (frames.without_body, "without a body"),
        ] {
            write!(f, " + {count} {class}")?;
        }
        write!(f, "; {} bodies = {} accepted", bodies.received, bodies.accepted)?;
        for (count, class) in [
            (bodies.untracked, "untracked"),
            (bodies.not_finite, "not finite"),
            (bodies.teleported, "teleported"),
        ] {
            write!(f, " + {count} {class}")?;
        }
        Ok(())
    }
}
