//! Poses from motion capture: what the program uses in a laboratory, and the servers that stand in for one.
//!
//! ```text
//! natnet, qtm, vrpn ──▶ Source ──▶ clock ──▶ gate ──▶ axes ──▶ structure, vehicle
//!                       frames     host time  ledger   world    poses
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`source`] | the trait over all protocols, and how a connection stands |
//! | [`server`] | the trait over all servers |
//! | [`frame`], [`time`] | frames of bodies; instants on the server's clock and the host's |
//! | [`address`] | sources in words, and opening them |
//! | [`clock`] | the server's clock on the host's |
//! | [`gate`], [`ledger`] | which frames are fixes; what became of every one |
//! | [`feed`], [`figures`] | a source and its gate; rates, latencies and shares |
//! | [`axes`] | from the laboratory's axes to the world's |
//! | [`proposal`] | what the axes probably are, for the operator |
//! | [`roster`], [`structure`] | which body is which module; where a structure of boats is |
//! | [`velocity`], [`vehicles`] | velocities of a body from its fixes; underwater vehicles, each by its body |
//! | [`natnet`], [`qtm`], [`vrpn`] | NatNet of OptiTrack Motive; QTM RT of Qualisys; trackers of VRPN |
//! | [`ros2`] | topics of ROS 2, by way of a program of its own |
//! | [`bytes`], [`stream`] | wire bytes with bounds checked; TCP that never blocks |

pub mod address;
pub mod axes;
pub mod bytes;
pub mod clock;
pub mod feed;
pub mod figures;
pub mod frame;
pub mod gate;
pub mod ledger;
pub mod natnet;
pub mod proposal;
pub mod qtm;
pub mod ros2;
pub mod roster;
pub mod server;
pub mod source;
pub mod stream;
pub mod structure;
pub mod time;
pub mod vehicles;
pub mod velocity;
pub mod vrpn;
