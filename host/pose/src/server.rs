//! A motion-capture server: the same trait over all protocols.

use std::net::SocketAddr;

use thiserror::Error;

use crate::frame::Frame;
use crate::time::HostInstant;

/// Serves frames to any number of clients. It never blocks; a client that does not keep up is dropped.
pub trait Server {
    /// Answers clients; to be called every few milliseconds.
    fn poll(&mut self, now: HostInstant);

    /// Sends a frame to all clients that asked for frames.
    fn send(&mut self, now: HostInstant, frame: &Frame);

    /// Sets what the server's clock shows more than the host's, ns, where the protocol lets clients ask for it.
    fn set_clock_ahead_ns(&mut self, _clock_ahead_ns: i64) {}

    /// Clients at present. Listeners of a multicast are not known and do not count.
    fn clients(&self) -> usize;

    /// Where clients connect.
    fn address(&self) -> SocketAddr;
}

/// Why there is no server.
#[derive(Debug, Error)]
#[error("cannot serve {protocol} on {address}: {source}")]
pub struct ServeError {
    /// What was to be served.
    pub protocol: &'static str,
    /// Where.
    pub address: SocketAddr,
    /// What the operating system said.
    pub source: std::io::Error,
}
