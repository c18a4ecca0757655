//! Why an execution ends before its plan does.

use thiserror::Error;

/// Why the rest of a plan is not executed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Failure {
    /// The mover does not get there.
    #[error(
        "robot {robot}, move {number}, {doing}: {off_m:.3} m and {off_deg:.1}° from where it should be for {waited_s} s{hint}"
    )]
    Late {
        /// Its id.
        robot: u16,
        /// Which move, from 1.
        number: usize,
        /// The action.
        doing: &'static str,
        /// Distance, m.
        off_m: f64,
        /// Angle, °.
        off_deg: f64,
        /// Patience, s.
        waited_s: f64,
        /// What may be the reason.
        hint: &'static str,
    },
    /// A cluster that waits does not stay.
    #[error(
        "the waiting cluster of {robots}, during move {number}: {off_m:.3} m and {off_deg:.1}° from its place{hint}"
    )]
    Adrift {
        /// Its robots.
        robots: String,
        /// Which move, from 1.
        number: usize,
        /// Distance, m.
        off_m: f64,
        /// Angle, °.
        off_deg: f64,
        /// What may be the reason.
        hint: &'static str,
    },
}
