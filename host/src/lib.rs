//! The `flotilla` program: the closed loop of a fleet, and the command line.
//!
//! | module | what |
//! |---|---|
//! | [`run`] | the closed loop: plan, dispatch, execute, observe |
//! | [`answer`] | what is asked of the program and what it answers, for the command line and for Python |
//! | [`provision`] | from a module's TOML file and its key to the image in its flash, and back |
//! | [`cli`] | the `flotilla` program |
//!
//! What these are built from are crates of their own, beside this one:
//!
//! | crate | what |
//! |---|---|
//! | [`modboat`] | planner, controller and observer of docked Modboats: pure functions |
//! | [`rov`] | planner and guidance of thruster-driven ROVs: pure functions |
//! | [`reconfiguration`] | vehicles, the problem and the plan of a reconfiguration: data that `rov` and `judge` share |
//! | [`judge`] | whether a reconfiguration plan keeps every condition, by code of its own |
//! | [`grid`] | Theta* and A* on grids, and maps read from text |
//! | [`link`] | radios, their faults, keys, and the dispatcher |
//! | [`sim`] | water, motors, motion capture, and modules made of the firmware crate |
//! | [`record`] | what a run leaves in memory |
//! | [`plot`] | pictures of it |
//! | [`quantity`], [`reader`] | numbers from outside, and files that a person writes |

pub mod answer;
pub mod cli;
pub mod provision;
pub mod run;
