//! A bridge between a run of Flotilla and ROS 2, in a process of its own: slow and dead peers never reach the loop.
//!
//! ```text
//!                    Foxglove's stream                      DDS
//! flotilla run ────── log's messages ─────▶ bridge ── topics ───────▶ ROS 2
//!   --serve    ◀───── page's commands ─────        ◀─ cmd_vel, goal_pose, services
//!
//! flotilla run ◀───── VRPN ──────────────── poses  ◀─ poses of any driver
//!   --pose ros2:/…
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`cli`] | the command line |
//! | [`attach`] | the run's console: its stream, and its commands |
//! | [`bridge`] | from the one to the other |
//! | [`shown`] | which topic goes where, and what is changed on the way |
//! | [`drive`] | `cmd_vel`, with its deadman |
//! | [`poses`] | poses of a driver, served to a run |
//! | [`node`] | the node: names, qualities of service |
//! | [`wire`] | messages of ROS 2 as they come and go |
//!
//! The crate `ros2-client` speaks DDS by itself: no ROS is needed to build or run this.

pub mod attach;
pub mod bridge;
pub mod cli;
pub mod drive;
pub mod node;
pub mod poses;
pub mod shown;
pub mod wire;
