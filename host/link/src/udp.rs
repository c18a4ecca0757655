//! A radio over a UDP socket that never blocks.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};

use protocol::Radio;
use protocol::time::FleetInstant;
use thiserror::Error;

/// Why there is no socket.
#[derive(Debug, Error)]
#[error("cannot listen on UDP {address}: {source}")]
pub struct BindError {
    /// The address asked for.
    pub address: String,
    /// What the operating system said.
    pub source: io::Error,
}

/// One UDP socket as a [`Radio`].
#[derive(Debug)]
pub struct UdpRadio {
    socket: UdpSocket,
}

impl UdpRadio {
    /// Listens on `address`, such as `127.0.0.1:4870`; port 0 takes any free one.
    ///
    /// # Errors
    /// [`BindError`] when the address is not one of this machine or the port is taken.
    pub fn bind(address: impl ToSocketAddrs + std::fmt::Display) -> Result<Self, BindError> {
        let name = address.to_string();
        let bound = UdpSocket::bind(address).and_then(|socket| {
            socket.set_nonblocking(true)?;
            Ok(Self { socket })
        });
        bound.map_err(|source| BindError { address: name, source })
    }

    /// Where it listens.
    ///
    /// # Errors
    /// The operating system's.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }
}

impl Radio for UdpRadio {
    type Address = SocketAddr;
    type Error = io::Error;

    fn send(&mut self, _now: FleetInstant, to: SocketAddr, datagram: &[u8]) -> io::Result<()> {
        match self.socket.send_to(datagram, to) {
            Ok(_) => Ok(()),
            // A full queue or a peer that is not there (yet) is a lost datagram, not a broken radio.
            Err(error) if is_passing(&error) => Ok(()),
            Err(error) => Err(error),
        }
    }

    fn receive(&mut self, _now: FleetInstant, buffer: &mut [u8]) -> io::Result<Option<(usize, SocketAddr)>> {
        loop {
            return match self.socket.recv_from(buffer) {
                Ok(received) => Ok(Some(received)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(None),
                // The echo of an earlier send to a closed port; something real may stand behind it in the queue.
                Err(error) if is_passing(&error) => continue,
                Err(error) => Err(error),
            };
        }
    }
}

fn is_passing(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock
            | ErrorKind::Interrupted
            | ErrorKind::ConnectionRefused
            | ErrorKind::ConnectionReset
            | ErrorKind::HostUnreachable
            | ErrorKind::NetworkUnreachable
            | ErrorKind::NetworkDown
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn datagrams_cross_a_real_socket() {
        let mut here = UdpRadio::bind("127.0.0.1:0").unwrap();
        let mut there = UdpRadio::bind("127.0.0.1:0").unwrap();
        let mut buffer = [0; 512];
        assert_eq!(there.receive(FleetInstant(0), &mut buffer).unwrap(), None);
        here.send(FleetInstant(0), there.local_address().unwrap(), b"swim").unwrap();
        let received = std::iter::repeat_with(|| {
            std::thread::sleep(std::time::Duration::from_millis(1));
            there.receive(FleetInstant(0), &mut buffer).unwrap()
        })
        .take(2_000)
        .find_map(|received| received);
        assert_eq!(received, Some((4, here.local_address().unwrap())));
        assert_eq!(&buffer[..4], b"swim");
    }

    #[test]
    fn a_busy_port_is_named() {
        let first = UdpRadio::bind("127.0.0.1:0").unwrap();
        let address = first.local_address().unwrap().to_string();
        let error = UdpRadio::bind(address.as_str()).unwrap_err();
        assert!(error.to_string().contains(&address), "{error}");
    }

    #[test]
    fn a_peer_that_is_not_there_is_no_error() {
        let mut here = UdpRadio::bind("127.0.0.1:0").unwrap();
        let gone = UdpRadio::bind("127.0.0.1:0").unwrap().local_address().unwrap();
        let mut buffer = [0; 512];
        for _ in 0..3 {
            here.send(FleetInstant(0), gone, b"hello?").unwrap();
            assert_eq!(here.receive(FleetInstant(0), &mut buffer).unwrap(), None);
        }
    }
}
