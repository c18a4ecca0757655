//! Guidance and control of a robot: its reference at every instant of an action, and the thrusts that follow it.
//!
//! | file | what |
//! |---|---|
//! | [`profile`] | from rest to rest: way, speed and acceleration over time |
//! | [`reference`](mod@reference) | the reference trajectory of one action of a plan |
//! | [`los`] | line-of-sight (LOS) guidance: the velocity that leads back to a path |
//! | [`observer`] | state, and what no model knows, from late and noisy fixes |
//! | [`residual`] | a thruster that gives nothing, by what no model knows |
//! | [`tracking`] | tracking controller, from reference and state to thrusts: feedforward, feedback, allocation |
//!
//! A robot that moves and a cluster that waits are controlled alike: the reference of the one moves, that of the other rests.

pub mod los;
pub mod observer;
pub mod profile;
pub mod reference;
pub mod residual;
pub mod tracking;
