//! Peers in ROS 2 that are not ours; one program, so that it is linked once.

mod bridge;
mod environment;
mod errors;
mod poses;
