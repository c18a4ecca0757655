//! The client's sockets: the connection, and in UDP one socket for frames.

use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use super::packet::{self, Packet};
use super::session::Session;
use crate::frame::{Arrival, Frame, Label};
use crate::source::{Link, Source, SourceError, Status};
use crate::stream::{Connection, Turn};
use crate::time::HostInstant;

/// Datagrams that are looked at in one poll before it returns. *Assumed.*
const MOST_A_POLL: usize = 256;
/// The largest UDP datagram, bytes.
const LARGEST: usize = 65_535;

/// A client of QTM RT.
#[derive(Debug)]
pub struct QtmClient {
    server: SocketAddr,
    connection: Connection,
    /// The socket for UDP frames, if they are wanted, and its port.
    udp: Option<(UdpSocket, u16)>,
    session: Option<Session>,
    status: Status,
    received: Vec<u8>,
    buffer: Vec<u8>,
}

impl QtmClient {
    /// A client of the server at `server`. Frames come over the connection, or over UDP: then a frame that is lost does not hold
    /// up those after it.
    ///
    /// # Errors
    /// No socket for UDP frames.
    pub fn new(server: SocketAddr, over_udp: bool) -> Result<Self, SourceError> {
        let udp = over_udp.then(|| open_udp(server)).transpose().map_err(|error| SourceError::Socket {
            purpose: format!("frames of QTM {server}"),
            reason: error.to_string(),
        })?;
        let (connection, status) = (Connection::new(server), Status::default());
        Ok(Self {
            server,
            connection,
            udp,
            session: None,
            status,
            received: Vec::new(),
            buffer: vec![0; LARGEST],
        })
    }

    /// Looks after the connection and takes what has come over it.
    fn exchange(&mut self, now: HostInstant) {
        let peer = match self.connection.poll(now) {
            Turn::Down => return,
            Turn::Lost(error) => return self.lose(format!("no connection to QTM {}: {error}", self.server)),
            Turn::Made(peer) => {
                self.session = Some(Session::new(now, self.udp.as_ref().map(|(_, port)| *port)));
                self.received.clear();
                peer
            }
            Turn::Up(peer) => peer,
        };
        let Some(session) = &mut self.session else { return };
        session.handle_timer(now, &mut self.status);
        let mut done = peer.receive(&mut self.received);
        while let (Ok(()), Some(packet)) = (&done, session.take_outgoing()) {
            done = peer.send(&packet.encode());
        }
        if session.is_lost(now) {
            done = done.and(Err(ErrorKind::TimedOut.into()));
        }
        if let Err(error) = done {
            self.connection.close(now);
            self.lose(format!("the connection to QTM {} is lost: {error}", self.server));
        }
    }

    fn lose(&mut self, trouble: String) {
        self.session = None;
        self.status.link = Link::Connecting;
        self.status.note(trouble);
    }

    /// Takes packets until one is a frame.
    fn frame(&mut self, now: HostInstant) -> Result<Option<Frame>, SourceError> {
        while let Some(session) = &mut self.session {
            let packet = match packet::take(&mut self.received) {
                Ok(Some(packet)) => packet,
                Ok(None) => break,
                Err(malformed) => {
                    self.status.undecodable += 1;
                    self.connection.close(now);
                    self.lose(format!("{} does not speak QTM RT: {malformed}", self.server));
                    break;
                }
            };
            let frame = session.handle_packet(now, packet, &mut self.status);
            if self.status.link != Link::Connecting {
                self.connection.proven();
            }
            match frame {
                Ok(None) => {}
                Ok(Some(frame)) => return Ok(Some(frame)),
                Err(error) => {
                    self.connection.close(now);
                    self.lose(error.to_string());
                    return Err(error);
                }
            }
        }
        Ok(None)
    }

    /// The next packet that came as a datagram.
    fn datagram(&mut self) -> Option<Packet> {
        let (socket, _) = self.udp.as_ref()?;
        for _ in 0..MOST_A_POLL {
            let (length, from) = socket.recv_from(&mut self.buffer).ok()?;
            if from.ip() != self.server.ip() {
                self.status.foreign += 1;
                continue;
            }
            let mut datagram = self.buffer.get(..length).unwrap_or_default().to_vec();
            match packet::take(&mut datagram) {
                Ok(Some(packet)) => return Some(packet),
                Ok(None) | Err(_) => self.status.undecodable += 1,
            }
        }
        None
    }
}

impl Source for QtmClient {
    fn poll(&mut self, now: HostInstant) -> Result<Option<Arrival>, SourceError> {
        let arrival = |frame| Arrival { frame, arrived: now };
        // Frames that came together are handed out one by one before the sockets are looked at again.
        if let Some(frame) = self.frame(now)? {
            return Ok(Some(arrival(frame)));
        }
        self.exchange(now);
        if let Some(frame) = self.frame(now)? {
            return Ok(Some(arrival(frame)));
        }
        while let Some(packet) = self.datagram() {
            let Some(session) = &mut self.session else { break };
            if let Some(frame) = session.handle_packet(now, packet, &mut self.status)? {
                return Ok(Some(arrival(frame)));
            }
        }
        Ok(None)
    }

    fn status(&self) -> &Status {
        &self.status
    }

    fn bodies(&self) -> &[Label] {
        self.session.as_ref().map_or(&[], |session| session.bodies())
    }
}

fn open_udp(server: SocketAddr) -> std::io::Result<(UdpSocket, u16)> {
    let any: IpAddr = match server {
        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    };
    let socket = UdpSocket::bind((any, 0))?;
    socket.set_nonblocking(true)?;
    let port = socket.local_addr()?.port();
    Ok((socket, port))
}
