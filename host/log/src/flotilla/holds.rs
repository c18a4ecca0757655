//! Message about why a fleet held.

use super::super::message::messages;
use super::super::ros::Time;

messages! {
    /// Why the fleet held, so far: a reason a leg and a row.
    Holds = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Which leg, from 0.
        leg: Vec<u32>,
        /// Why, as a number.
        reason: Vec<u8>,
        /// For how long, s.
        time_s: Vec<f64>,
    }
}
