//! Data of a reconfiguration of ROVs: what is given and what is planned.
//!
//! | module | what |
//! |---|---|
//! | [`vehicle`] | kinds of robots and tools, read from TOML |
//! | [`body`] | what the motion of one of them depends on |
//! | [`strip`] | added mass and damping of a box, for a vehicle whose file gives none |
//! | [`pose`] | where one of them is |
//! | [`problem`] | start, goal and rules |
//! | [`task`] | what a goal is to be good for, where none is given |
//! | [`plan`] | moves, their times and energies |
//!
//! The planner (`rov`), the judge of plans (`judge`), the simulator and the pictures share these types. No algorithm is
//! here, so that the judge shares none with the planner.

pub mod body;
pub mod plan;
pub mod pose;
pub mod problem;
pub mod strip;
pub mod task;
pub mod vehicle;
