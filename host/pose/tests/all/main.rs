//! Clients and servers of this crate against each other over real sockets, and codecs against hostile bytes.

mod clock;
mod feed;
mod gate;
mod hostile;
mod natnet;
mod qtm;
mod rig;
mod structure;
mod vehicles;
mod velocity;
mod vrpn;
