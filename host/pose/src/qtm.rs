//! QTM RT, the real-time protocol of Qualisys Track Manager: bodies with six degrees of freedom.
//!
//! | file | what |
//! |---|---|
//! | [`packet`] | packets, and how a stream is cut into them |
//! | [`data`] | data packets: bodies, in millimetres |
//! | [`parameters`] | the settings in XML: names of bodies |
//! | [`session`] | the client's end, sans-IO |
//! | [`client`] | its sockets |
//! | [`server`] | the server's end |
//! | `streaming` | what one client of the server has asked for |
//!
//! A TCP connection to port 22223 carries packets, numbers low byte first: `u32` size with the header, `u32` type, content. The
//! server greets, the client names the protocol's version, asks for the parameters and then for frames, over the same connection
//! or as UDP datagrams.
//!
//! Source: Qualisys, *QTM Real-time Server Protocol Documentation*. It leaves the order of the rotation matrix open: column by
//! column, as clients that are in use read it (the Eigen maps of `RTProtocol` users, and libmotioncapture's own).

pub mod client;
pub mod data;
pub mod packet;
pub mod parameters;
pub mod server;
pub mod session;
mod streaming;
