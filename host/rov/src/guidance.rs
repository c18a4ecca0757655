//! Guidance and control: where a robot is to be at every instant of an action, and the thrusts that bring it there.
//!
//! | file | what |
//! |---|---|
//! | [`profile`] | from rest to rest: way, speed and acceleration over time |
//! | [`course`] | the reference along one action of a plan |
//! | [`sight`] | line-of-sight steering: the velocity that leads back to a course |
//! | [`helm`] | from reference and state to thrusts: feedforward, feedback, allocation |
//!
//! A robot that moves and a cluster that waits are steered alike: the one follows a course, the other has a course of
//! length zero.

pub mod course;
pub mod helm;
pub mod profile;
pub mod sight;
