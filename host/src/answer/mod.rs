//! What is asked of the program and what it answers: one path for the command line and for the Python package.
//!
//! | file | what |
//! |---|---|
//! | [`plan`] | a stream of demands, and the plan for each |
//! | [`batch`] | many demands at once, each planned for by itself |
//! | [`envelope`] | where a demand lies in what modules could give |
//! | [`transition`] | which way round each tail turns into a given cycle |
//! | [`response`] | motion of an ROV under a wrench, thrusts or pulses |
//! | [`route`] | shortest paths on a map |
//! | [`reconfigure`] | plans of ROVs, judged before they are handed out |
//! | [`threads`] | as many threads as the computer has cores |

pub mod batch;
pub mod envelope;
pub mod plan;
pub mod reconfigure;
pub mod response;
pub mod route;
pub mod threads;
pub mod transition;
