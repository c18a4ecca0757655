//! Judges that are not ours, protocol by protocol.

mod natnet;
mod qtm;
mod vrpn;
