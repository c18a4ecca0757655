//! NatNet, the protocol of OptiTrack Motive: 3.0 to 4.2, unicast and multicast.
//!
//! | file | what |
//! |---|---|
//! | [`message`] | headers, versions, the server's information, requests |
//! | [`frames`] | frames of data |
//! | [`models`] | model definitions: which number has which name |
//! | [`session`] | the client's end, sans-IO |
//! | [`client`] | its sockets |
//! | [`server`] | the server's end |
//!
//! Every message is one datagram, numbers low byte first: `u16` kind, `u16` length, payload. Clients ask on the command port
//! (1510); frames come on the data port (1511) of a multicast group, or in unicast to the port that the client asked from, as long
//! as it keeps asking.
//!
//! Sources: OptiTrack, *NatNet SDK 4.2*, `PacketClient.cpp` (layouts of frames and definitions by version, connection options,
//! requests) and `NatNetTypes.h` (kinds of messages, server information, default ports and group). Checked against bytes of Motive
//! 2.1 that the Python package `python_natnet` publishes.

pub mod client;
pub mod frames;
pub mod message;
pub mod models;
pub mod server;
pub mod session;
