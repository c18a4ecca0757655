//! The [`Robot`] trait: what an endpoint leaves to the kind of robot that it speaks for.

use protocol::time::FleetInstant;
use protocol::{Cycle, Faults, Message, ModuleKind, ModuleState, Verdict};

/// State common to all reports of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Present {
    /// Fleet time (0 while unsynchronised).
    pub at: FleetInstant,
    /// What the module is doing.
    pub state: ModuleState,
    /// The cycle that runs, or ran last; 0 before the first.
    pub cycle: u32,
    /// What is wrong with it.
    pub faults: Faults,
}

/// What depends on the kind of robot: what a cycle means, and what is reported. Times are fleet time; before that is
/// known nothing is offered, and every time is zero.
pub trait Robot {
    /// Said in the hello.
    const KIND: ModuleKind;

    /// What the robot measures for its reports.
    type Measurement;

    /// Takes in what was measured, before anything else that happens at that time.
    fn observe(&mut self, measurement: &Self::Measurement);

    /// False until it knows where it is.
    fn is_located(&self) -> bool {
        true
    }

    /// False while it cannot do yet what a cycle asks.
    fn is_ready(&self) -> bool {
        true
    }

    /// Whether the cycle with this number waits, runs or ran last.
    fn knows(&self, cycle: u32) -> bool;

    /// Takes a cycle, or says why not. Idempotent.
    fn offer(&mut self, now: FleetInstant, cycle: &Cycle) -> Verdict;

    /// Lets a cycle run that was prepared. Idempotent.
    fn commit(&mut self, now: FleetInstant, cycle: u32) -> Verdict;

    /// Start of the cycle that waits for it, if one does.
    fn waiting(&self, now: FleetInstant) -> Option<FleetInstant>;

    /// Drops what has not begun and goes over to holding.
    fn hold(&mut self, now: FleetInstant);

    /// Stops at once, until released.
    fn emergency_stop(&mut self, now: FleetInstant);

    /// Ends a stop: rests where the next measurement finds it.
    fn release(&mut self);

    /// Number of the cycle that is being run at `now`, if any.
    fn running(&self, now: FleetInstant) -> Option<u32>;

    /// Number of the cycle that began last by `now`, whether it still runs or not.
    fn latest(&self, now: FleetInstant) -> Option<u32>;

    /// Forgets every cycle, for another epoch of fleet time. A stop in force stays in force.
    fn start_new_epoch(&mut self, now: FleetInstant);

    /// The report that is due, of what was observed last; nothing while there is nothing to report.
    fn report(&self, present: &Present) -> Option<Message>;
}
