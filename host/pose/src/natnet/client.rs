//! The client's sockets: one for commands, and in multicast one that joins the group.
//!
//! The group is joined on the interface that leads to the server: joined on another, a machine with two networks hears nothing.

use std::io::{self, ErrorKind};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, SocketAddrV4, UdpSocket};

use socket2::{Domain, Protocol, Socket, Type};

use super::message::LARGEST;
use super::session::Session;
use crate::frame::{Arrival, Label};
use crate::source::{Exchange, Source, SourceError, Status};
use crate::time::HostInstant;

/// Datagrams that are looked at in one poll before it returns, so that a flood does not hold the caller. *Assumed.*
const MOST_A_POLL: usize = 256;
/// Bytes that the operating system keeps of frames not taken yet: the SDK's sample asks for 1 MB too.
const KEPT: usize = 1 << 20;

/// A client of NatNet.
#[derive(Debug)]
pub struct NatNetClient {
    server: SocketAddr,
    interface: Option<Ipv4Addr>,
    command: UdpSocket,
    /// The socket that has joined the group, and the group.
    data: Option<(UdpSocket, SocketAddrV4)>,
    session: Session,
    buffer: Vec<u8>,
}

impl NatNetClient {
    /// A client of the server whose command port is `server`. `interface` is the address of this machine in the server's network,
    /// where the one that the operating system would choose is not right.
    ///
    /// # Errors
    /// No socket for commands.
    pub fn new(server: SocketAddr, interface: Option<Ipv4Addr>) -> Result<Self, SourceError> {
        let any: IpAddr = match server {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let command = open_command(any).map_err(|error| SourceError::Socket {
            purpose: format!("commands to NatNet {server}"),
            reason: error.to_string(),
        })?;
        let session = Session::default();
        Ok(Self { server, interface, command, data: None, session, buffer: vec![0; LARGEST + 4] })
    }

    /// Joins the group that the server has named, if it is another than before.
    fn follow_group(&mut self) -> Result<(), SourceError> {
        let Some(info) = self.session.info() else { return Ok(()) };
        let wanted = info.group.map(|group| SocketAddrV4::new(group, info.data_port));
        if wanted == self.data.as_ref().map(|(_, group)| *group) {
            return Ok(());
        }
        self.data = None;
        let Some(group) = wanted else { return Ok(()) };
        let joined = interface_towards(self.server, self.interface)
            .and_then(|interface| Ok((join(group, interface)?, interface)));
        let (socket, interface) = joined.map_err(|error| SourceError::Socket {
            purpose: format!("the multicast group {group} of {}", self.server.ip()),
            reason: error.to_string(),
        })?;
        self.data = Some((socket, group));
        self.session.joined_on(interface);
        Ok(())
    }

    fn flush(&mut self) {
        for datagram in self.session.take_outbox() {
            if let Err(error) = self.command.send_to(&datagram, self.server) {
                self.session.status_mut().note(format!("cannot send to {}: {error}", self.server));
            }
        }
    }

    /// The next datagram of either socket: its length and where it came from.
    fn receive(&mut self) -> Option<(usize, SocketAddr)> {
        let sockets = [self.data.as_ref().map(|(socket, _)| socket), Some(&self.command)];
        for socket in sockets.into_iter().flatten() {
            match socket.recv_from(&mut self.buffer) {
                Ok(received) => return Some(received),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => self.session.status_mut().note(format!("cannot receive: {error}")),
            }
        }
        None
    }
}

impl Source for NatNetClient {
    fn poll(&mut self, now: HostInstant) -> Result<Option<Arrival>, SourceError> {
        self.session.handle_timer(now);
        self.flush();
        for _ in 0..MOST_A_POLL {
            let Some((length, from)) = self.receive() else { break };
            if from.ip() != self.server.ip() {
                let status = self.session.status_mut();
                status.foreign += 1;
                status.note(format!("datagrams come from {}, which is not the server", from.ip()));
                continue;
            }
            let datagram = self.buffer.get(..length).unwrap_or_default();
            let frame = self.session.handle_datagram(now, datagram)?;
            self.follow_group()?;
            self.flush();
            if let Some(frame) = frame {
                return Ok(Some(Arrival { frame, arrived: now }));
            }
        }
        Ok(None)
    }

    fn status(&self) -> &Status {
        self.session.status()
    }

    fn bodies(&self) -> &[Label] {
        self.session.bodies()
    }

    fn exchange(&mut self) -> Option<Exchange> {
        self.session.take_exchange()
    }
}

fn open_command(any: IpAddr) -> io::Result<UdpSocket> {
    let socket = UdpSocket::bind((any, 0))?;
    socket.set_nonblocking(true)?;
    // Unicast frames come here too.
    socket2::SockRef::from(&socket).set_recv_buffer_size(KEPT)?;
    Ok(socket)
}

/// This machine's address in the network of `server`: the operating system's own choice for a datagram to it.
fn interface_towards(server: SocketAddr, given: Option<Ipv4Addr>) -> io::Result<Ipv4Addr> {
    if let Some(given) = given {
        return Ok(given);
    }
    let probe = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    probe.connect(server)?;
    match probe.local_addr()?.ip() {
        IpAddr::V4(address) => Ok(address),
        IpAddr::V6(_) => Err(ErrorKind::Unsupported.into()),
    }
}

/// A socket that has joined `group` on `interface`; others on this machine may listen to the same group.
fn join(group: SocketAddrV4, interface: Ipv4Addr) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_reuse_address(true)?;
    // Bound to the group itself, other datagrams to the port stay out; Windows does not bind to a group.
    let bound = if cfg!(unix) { *group.ip() } else { Ipv4Addr::UNSPECIFIED };
    socket.bind(&SocketAddr::from((bound, group.port())).into())?;
    socket.join_multicast_v4(group.ip(), &interface)?;
    socket.set_recv_buffer_size(KEPT)?;
    socket.set_nonblocking(true)?;
    Ok(socket.into())
}
