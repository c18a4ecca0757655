//! What is asked of the program and what it answers: one path for the command line and for the Python package.
//!
//! | file | what |
//! |---|---|
//! | [`plan`] | a stream of demands, and the plan for each |

pub mod plan;
