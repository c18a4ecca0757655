//! The [`Module`] trait: what a board, the emulator, the simulator or a process runs.
//!
//! ```text
//! every interval:      supply → tick      ┐
//! for every datagram:  handle_datagram    ┴→ poll_transmit until there is nothing → network
//! ```
//!
//! The runner owns clock, pins and network; the module owns every decision. Times are instants of the module's own clock.
//!
//! Assumptions and limits: ticks come at the interval that the module was built for, and a datagram may come at any time
//! between two of them. Both results are for tests and measurements: the module watches its outputs and counts its datagrams
//! itself, so a runner need not look at them.

use protocol::ledger::Class;
use protocol::time::LocalInstant;
use protocol::units::{Amperes, Volts};
use protocol::{Faults, ModuleState};

use crate::link::endpoint::{Endpoint, Robot};

/// What the board measures of its supply.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Supply {
    /// Battery voltage; not a number where nothing is wired.
    pub battery: Volts,
    /// Battery current, for an ROV's reports. A Modboat reads its motor's from its
    /// [`CurrentSense`](crate::modboat::servo::CurrentSense).
    pub current: Amperes,
}

/// What a module is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// Its state, as told to the host.
    pub state: ModuleState,
    /// What is wrong with it.
    pub faults: Faults,
    /// Number of the cycle that it runs, if any.
    pub running: Option<u32>,
}

/// A module of either kind: [`Modboat`](crate::modboat::Modboat) or [`Rov`](crate::rov::Rov).
pub trait Module {
    /// What depends on the kind of robot.
    type Robot: Robot;
    /// Why an output failed.
    type Error;

    /// One turn of the control loop at `now`: measures, decides, drives. It posts nothing, so that no report makes a tick long.
    ///
    /// # Errors
    /// The output that failed; everything else goes on all the same.
    fn tick(&mut self, now: LocalInstant, supply: &Supply) -> Result<(), Self::Error>;

    /// Follows one datagram that arrived at `now`.
    ///
    /// # Errors
    /// What it is, if it is not to be followed; it is counted and nothing else happens.
    fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class>;

    /// Posts what was due at the last tick, and writes the next datagram to the start of `buffer` (of [`protocol::MAX_DATAGRAM`] bytes).
    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]>;

    /// Its side of the link: ledger, fleet clock and failsafe.
    fn endpoint(&self) -> &Endpoint<Self::Robot>;

    /// What it is doing at `now`.
    fn status(&self, now: LocalInstant) -> Status {
        let endpoint = self.endpoint();
        Status {
            state: endpoint.state(now),
            faults: endpoint.failsafe().faults(),
            running: endpoint.running(now),
        }
    }
}
