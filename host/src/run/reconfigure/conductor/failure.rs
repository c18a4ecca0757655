//! Why an execution ends before its plan does.

use reconfiguration::plan::ActionKind;
use thiserror::Error;

use super::PATIENCE_S;

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

impl Failure {
    /// The robot `robot` is so far, m and rad, from where its action `kind` of the move `number` (from 0) should have it.
    pub(super) fn late(
        robot: u16,
        number: usize,
        kind: ActionKind,
        (off_m, off_rad): (f64, f64),
        hint: &'static str,
    ) -> Self {
        let doing = match kind {
            ActionKind::Undock => "undocking",
            ActionKind::Turn => "turning",
            ActionKind::Leg => "on a leg",
            ActionKind::Dock => "docking",
        };
        let off_deg = off_rad.to_degrees();
        Self::Late { robot, number: number + 1, doing, off_m, off_deg, waited_s: PATIENCE_S, hint }
    }

    /// The cluster of `robots` is so far, m and rad, from its place; `silent`: not all of them answer.
    pub(super) fn adrift(
        robots: impl Iterator<Item = u16>,
        silent: bool,
        number: usize,
        (off_m, off_rad): (f64, f64),
    ) -> Self {
        let robots: Vec<String> = robots.map(|id| id.to_string()).collect();
        let robots = if robots.is_empty() { "tools".to_owned() } else { robots.join(", ") };
        let hint = if silent { " (not all of them answer)" } else { "" };
        Self::Adrift { robots, number: number + 1, off_m, off_deg: off_rad.to_degrees(), hint }
    }
}
