//! Where a run's poses come from: the seam, and the account of what came.

use pose::ledger::Ledger;
use protocol::time::FleetInstant;
use runlog::flotilla::Body;

use super::RunError;

/// Where poses come from. `W` is the world that a simulated one looks at.
pub trait PoseSource<W> {
    /// What it tells.
    type Pose: ?Sized;

    /// The newest pose, if one has come by `now` that was not told before; the time in it is fleet time.
    ///
    /// # Errors
    /// What waiting does not mend.
    fn poll<'a>(
        &'a mut self,
        now: FleetInstant,
        world: Option<&'a W>,
    ) -> Result<Option<&'a Self::Pose>, RunError>;

    /// Why there are no poses, if there are none.
    fn trouble(&self) -> Option<&str> {
        None
    }

    /// Bodies as a motion capture sees them, where there is one, in the world.
    fn bodies(&self) -> Option<Vec<Body>> {
        None
    }

    /// What became of what a motion capture sent, where there is one.
    fn account(&self) -> Option<PoseAccount> {
        None
    }
}

/// What came of a motion capture, so far.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseAccount {
    /// Where poses come from.
    pub source: String,
    /// What became of frames and bodies.
    pub ledger: Ledger,
    /// Connections that were made.
    pub connects: u32,
    /// Jumps of the server's clock.
    pub clock_jumps: u64,
    /// Least time from exposure to arrival, and how far off that may be, s; `None` where the protocol does not show it.
    pub least_delay_s: Option<(f64, f64)>,
    /// Time beyond the least that half of the frames did not exceed, s.
    pub late_p50_s: f64,
    /// And 99 of 100.
    pub late_p99_s: f64,
}
