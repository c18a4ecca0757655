//! Constants of a thruster-driven ROV from logs of its own swims.
//!
//! | file | what |
//! |---|---|
//! | [`data`] | poses and thrusts of robots that swim alone |
//! | `constants` | θ |
//! | `model` | motion, (i16)–(i19) |
//! | `prediction` | motion foretold over held-back data |
//! | `search`, [`outcome`] | all of it |
//!
//! Filter, search and intervals are those of a Modboat: (i7)–(i11), (i13), (i14).

mod constants;
pub mod data;
mod model;
pub mod outcome;
mod prediction;
mod search;

pub use search::identify;
