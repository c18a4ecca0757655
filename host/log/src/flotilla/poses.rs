//! Messages about a motion capture.

use super::super::message::messages;
use super::super::ros::Time;

messages! {
    /// Why there were no poses, and for how long the fleet held for it.
    Trouble = "flotilla_msgs" {
        /// In words.
        text: String,
        /// For how long, s.
        time_s: f64,
    }

    /// What became of what a motion capture sent, so far.
    Poses = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Where poses come from.
        source: String,
        /// Frames.
        frames: u64,
        /// Of those: used.
        frames_accepted: u64,
        /// Of those: the same as the one before.
        frames_doubled: u64,
        /// Of those: with a stamp that does not fit the server's clock.
        frames_off_the_clock: u64,
        /// Of those: older than the newest.
        frames_out_of_order: u64,
        /// Of those: of a stream that is frozen.
        frames_frozen: u64,
        /// Of those: without a body that could be used.
        frames_without_body: u64,
        /// Bodies of frames that got as far as their bodies.
        bodies: u64,
        /// Of those: used.
        bodies_accepted: u64,
        /// Of those: not seen by the server.
        bodies_untracked: u64,
        /// Of those: with a number that is none.
        bodies_not_finite: u64,
        /// Of those: further from their last place than anything moves.
        bodies_teleported: u64,
        /// Connections that were made.
        connects: u32,
        /// Jumps of the server's clock.
        clock_jumps: u64,
        /// Least time from exposure to arrival, where the protocol shows it, s.
        least_delay_s: Option<f64>,
        /// How far off that may be, s.
        least_delay_error_s: Option<f64>,
        /// Time beyond the least that half of the frames did not exceed, s.
        late_p50_s: f64,
        /// And 99 of 100.
        late_p99_s: f64,
        /// Why there were no poses.
        troubles: Vec<Trouble>,
    }
}
