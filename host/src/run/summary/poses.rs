//! The figures of a motion capture.

use pose::ledger::{Bodies, Frames};
use runlog::flotilla;
use serde::Serialize;

/// What came of a motion capture: frames and bodies by what became of them, and its time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseFigures {
    /// Where poses come from.
    pub source: String,
    /// Frames received, and of those accepted, doubled, off the server's clock, out of order, frozen and without a body.
    pub frames: Frames,
    /// Bodies of frames that got as far as their bodies, and of those accepted, untracked, not finite and teleported.
    pub bodies: Bodies,
    /// Connections that were made.
    pub connects: u32,
    /// Jumps of the server's clock.
    pub clock_jumps: u64,
    /// Least time from exposure to arrival, s; null where the protocol does not show it.
    pub least_delay_s: Option<f64>,
    /// How far off that may be, s.
    pub least_delay_error_s: Option<f64>,
    /// Time beyond the least that half of the frames did not exceed, s.
    pub late_p50_s: f64,
    /// And 99 of 100.
    pub late_p99_s: f64,
    /// Why the fleet held for want of poses, and for how long.
    pub troubles: Vec<TroubleFigures>,
}

/// Why the fleet held for want of poses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TroubleFigures {
    /// In words.
    pub reason: String,
    /// For how long, s.
    pub time_s: f64,
}

impl From<flotilla::Poses> for PoseFigures {
    fn from(poses: flotilla::Poses) -> Self {
        let troubles = poses.troubles.into_iter();
        Self {
            source: poses.source,
            frames: Frames {
                received: poses.frames,
                accepted: poses.frames_accepted,
                doubled: poses.frames_doubled,
                off_the_clock: poses.frames_off_the_clock,
                out_of_order: poses.frames_out_of_order,
                frozen: poses.frames_frozen,
                without_body: poses.frames_without_body,
            },
            bodies: Bodies {
                received: poses.bodies,
                accepted: poses.bodies_accepted,
                untracked: poses.bodies_untracked,
                not_finite: poses.bodies_not_finite,
                teleported: poses.bodies_teleported,
            },
            connects: poses.connects,
            clock_jumps: poses.clock_jumps,
            least_delay_s: poses.least_delay_s,
            least_delay_error_s: poses.least_delay_error_s,
            late_p50_s: poses.late_p50_s,
            late_p99_s: poses.late_p99_s,
            troubles: troubles
                .map(|trouble| TroubleFigures { reason: trouble.text, time_s: trouble.time_s })
                .collect(),
        }
    }
}
