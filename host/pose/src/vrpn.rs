//! VRPN, the protocol of the Virtual-Reality Peripheral Network: trackers.
//!
//! | file | what |
//! |---|---|
//! | [`message`] | the cookie, messages, poses of trackers |
//! | [`session`] | the client's end, sans-IO |
//! | [`client`] | its sockets |
//! | [`server`] | the server's end |
//!
//! Numbers are high byte first. Over a TCP connection to port 3883 both ends send a cookie of 24 bytes, then messages: a header of
//! 24 bytes (`u32` length with the header, `u32` s and `u32` µs of the time, `i32` sender, `i32` kind, `u32` sequence) and a
//! payload, filled up to a multiple of 8 bytes. Each end describes its senders and kinds by name, in messages of kinds −1 and −2;
//! the numbers are its own. A client can also ask by a UDP datagram with its address and port in words to be called back.
//!
//! Sources: `Format_Of_Protocol.txt`, `vrpn_Connection.C`, `vrpn_Tracker.C` and `vrpn_BaseClass.C` of VRPN 07.38.

pub mod client;
pub mod message;
pub mod server;
pub mod session;
