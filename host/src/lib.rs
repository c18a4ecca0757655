//! The host of a fleet: plans for everybody, sends each module its cycle, simulates the tank, shows what happened.
//!
//! ```text
//! protocol ← firmware ← sim ← run ← cli          protocol ← link ← run          modboat, rov ← sim, run, plot
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`modboat`] | the planner of docked Modboats: pure functions from a wrench to everybody's cycle |
//! | [`rov`] | the planner of thruster-driven ROVs: hydrostatics, dynamics, energy, reconfiguration |
//! | [`grid`] | Theta* and A* on grids, and the maps read from files: pure functions |
//! | [`verify`] | whether a reconfiguration plan keeps every condition, by code of its own |
//! | [`link`] | radios, their faults, and the dispatcher |
//! | [`provision`] | from a module's TOML file and its key to the image in its flash, and back |
//! | [`sim`] | the tank, the motors, and modules made of the firmware crate |
//! | [`run`] | the closed loop: plan, dispatch, execute, observe |
//! | [`plot`] | the pictures of a run |
//! | [`cli`] | the `flotilla` program |

pub mod cli;
pub mod grid;
pub mod link;
pub mod modboat;
pub mod plot;
pub mod provision;
pub mod quantity;
pub mod rov;
pub mod run;
pub mod sim;
mod toml_lines;
pub mod verify;
