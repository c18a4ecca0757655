//! The server's end of VRPN: one tracker for each body.
//!
//! Clients connect over TCP, or ask by UDP to be called back; poses go over the connection in both cases.

use std::collections::BTreeMap;
use std::io;
use std::net::{SocketAddr, TcpListener, UdpSocket};

use super::message::{self, Message, Pose};
use crate::bytes::text_of;
use crate::frame::{Frame, Label};
use crate::server::{ServeError, Server};
use crate::stream::{Connection, Peer, Turn};
use crate::time::{HostInstant, ServerInstant};

/// Clients at once: `vrpn_MAX_ENDPOINTS`.
const MOST_CLIENTS: usize = 256;
/// Attempts to find a port that is free for TCP and UDP.
const ATTEMPTS: usize = 20;
/// Names that a client may describe.
const MOST_NAMES: usize = 2000;
/// Numbers of this end's kinds.
const POSE: i32 = 0;
const PING: i32 = 1;
const PONG: i32 = 2;

/// How a client is reached.
#[derive(Debug)]
enum Way {
    /// It has connected.
    Accepted(Peer),
    /// It has asked for a call to this address.
    Called(SocketAddr, Connection),
}

#[derive(Debug)]
struct Client {
    way: Way,
    /// Whether this end's cookie was sent.
    greeted: bool,
    /// Whether the other end's has come.
    met: bool,
    received: Vec<u8>,
    /// The client's senders and kinds by its own numbers.
    senders: BTreeMap<i32, String>,
    kinds: BTreeMap<i32, String>,
}

/// A server of VRPN.
#[derive(Debug)]
pub struct VrpnServer {
    listener: TcpListener,
    requests: UdpSocket,
    address: SocketAddr,
    /// The bodies, each with the number of its sender.
    senders: Vec<(Label, i32)>,
    clients: Vec<Client>,
}

impl Client {
    fn new(way: Way) -> Self {
        let (senders, kinds) = (BTreeMap::new(), BTreeMap::new());
        Self { way, greeted: false, met: false, received: Vec::new(), senders, kinds }
    }

    /// Takes what the client has sent and answers it; `Err` ends the client.
    fn attend(&mut self, now: HostInstant, senders: &[(Label, i32)]) -> io::Result<()> {
        let peer = match &mut self.way {
            Way::Accepted(peer) => peer,
            Way::Called(_, connection) => match connection.poll(now) {
                Turn::Down => return Ok(()),
                Turn::Lost(error) => return Err(error),
                Turn::Made(peer) | Turn::Up(peer) => peer,
            },
        };
        if !std::mem::replace(&mut self.greeted, true) {
            peer.send(&message::cookie())?;
        }
        peer.flush()?;
        peer.receive(&mut self.received)?;
        if !self.met && self.received.len() >= message::COOKIE_LENGTH {
            let cookie: Vec<u8> = self.received.drain(..message::COOKIE_LENGTH).collect();
            if !message::is_read(&cookie) {
                return Err(io::Error::other("another version"));
            }
            self.met = true;
            peer.send(&descriptions(senders))?;
        }
        while self.met {
            let Some(message) = message::take(&mut self.received).map_err(io::Error::other)? else { break };
            let names = match message.kind {
                message::SENDER_DESCRIPTION => &mut self.senders,
                message::KIND_DESCRIPTION => &mut self.kinds,
                kind => {
                    let asks = self.kinds.get(&kind).is_some_and(|name| name == message::PING);
                    let asked = self.senders.get(&message.sender).filter(|_| asks);
                    if let Some(sender) = asked.and_then(|name| number_of(senders, name)) {
                        let pong = Message { time: message.time, sender, kind: PONG, payload: Vec::new() };
                        peer.send(&pong.encode())?;
                    }
                    continue;
                }
            };
            if names.len() < MOST_NAMES
                && let Ok(name) = message.described()
            {
                names.insert(message.sender, name);
            }
        }
        Ok(())
    }

    /// Sends poses to a client that has come so far; `Err` ends the client.
    fn send(&mut self, now: HostInstant, bytes: &[u8]) -> io::Result<()> {
        match &mut self.way {
            _ if !self.met => Ok(()),
            Way::Accepted(peer) => peer.send(bytes),
            Way::Called(_, connection) => match connection.poll(now) {
                Turn::Down => Ok(()),
                Turn::Lost(error) => Err(error),
                Turn::Made(peer) | Turn::Up(peer) => peer.send(bytes),
            },
        }
    }
}

fn number_of(senders: &[(Label, i32)], name: &str) -> Option<i32> {
    senders.iter().find(|(label, _)| label.name.as_deref() == Some(name)).map(|(_, number)| *number)
}

/// All that a client has to know of this end.
fn descriptions(senders: &[(Label, i32)]) -> Vec<u8> {
    let sender = |name, number| Message::description(message::SENDER_DESCRIPTION, number, name).encode();
    let named =
        senders.iter().map(|(label, number)| sender(label.name.as_deref().unwrap_or_default(), *number));
    let kinds = [(POSE, message::POSE), (PING, message::PING), (PONG, message::PONG)];
    let kinds =
        kinds.map(|(number, name)| Message::description(message::KIND_DESCRIPTION, number, name).encode());
    // The first sender of every VRPN is the connection itself.
    [sender(message::CONTROL, 0)].into_iter().chain(named).chain(kinds).flatten().collect()
}

impl VrpnServer {
    /// A server on `address`, TCP and UDP, where port 0 takes a free one, with a tracker for each of `bodies`.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn new(address: SocketAddr, bodies: &[Label]) -> Result<Self, ServeError> {
        let failed = |source| ServeError { protocol: "VRPN", address, source };
        let (listener, requests) = bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        requests.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let senders = bodies.iter().cloned().zip(1..).collect();
        Ok(Self { listener, requests, address, senders, clients: Vec::new() })
    }

    /// Adds a tracker, unless there is one of this label; clients that are there are told.
    pub fn add(&mut self, now: HostInstant, body: &Label) {
        if self.senders.iter().any(|(label, _)| label == body) || self.senders.len() >= MOST_NAMES {
            return;
        }
        // The first sender is the connection itself, number 0.
        let number = self.senders.len() as i32 + 1;
        let name = body.name.as_deref().unwrap_or_default();
        let bytes = Message::description(message::SENDER_DESCRIPTION, number, name).encode();
        self.senders.push((body.clone(), number));
        self.clients.retain_mut(|client| client.send(now, &bytes).is_ok());
    }

    fn accept(&mut self) {
        while let Ok((stream, _)) = self.listener.accept() {
            if self.clients.len() < MOST_CLIENTS
                && let Ok(peer) = Peer::new(stream)
            {
                self.clients.push(Client::new(Way::Accepted(peer)));
            }
        }
    }

    /// Calls clients that ask for it; they ask again until they are called.
    fn call(&mut self) {
        let mut buffer = [0; 200];
        while let Ok((length, from)) = self.requests.recv_from(&mut buffer) {
            let text = text_of(buffer.get(..length).unwrap_or_default());
            // The address is that of the request: a client with several networks may name another.
            let port = text.split_once(' ').and_then(|(_, port)| port.trim().parse().ok());
            let Some(port) = port.filter(|&port: &u16| port >= 1024) else { continue };
            let place = SocketAddr::new(from.ip(), port);
            let known = |client: &Client| matches!(client.way, Way::Called(called, _) if called == place);
            if self.clients.len() < MOST_CLIENTS && !self.clients.iter().any(known) {
                self.clients.push(Client::new(Way::Called(place, Connection::new(place))));
            }
        }
    }
}

impl Server for VrpnServer {
    fn poll(&mut self, now: HostInstant) {
        self.accept();
        self.call();
        let senders = &self.senders;
        self.clients.retain_mut(|client| client.attend(now, senders).is_ok());
    }

    fn send(&mut self, now: HostInstant, frame: &Frame) {
        let time: ServerInstant = frame.captured;
        // A tracker that sees nothing sends nothing.
        let seen = frame.bodies.iter().filter(|body| body.tracked);
        let messages = seen.filter_map(|body| {
            let (_, sender) = self.senders.iter().find(|(label, _)| *label == body.label)?;
            let pose = Pose { sensor: 0, position: body.position, attitude: body.attitude };
            Some(Message { time, sender: *sender, kind: POSE, payload: pose.encode() }.encode())
        });
        let bytes: Vec<u8> = messages.flatten().collect();
        self.clients.retain_mut(|client| client.send(now, &bytes).is_ok());
    }

    fn clients(&self) -> usize {
        self.clients.len()
    }

    fn address(&self) -> SocketAddr {
        self.address
    }
}

/// TCP and UDP on one port; with port 0, one that is free for both.
fn bind(address: SocketAddr) -> io::Result<(TcpListener, UdpSocket)> {
    let attempts = if address.port() == 0 { ATTEMPTS } else { 1 };
    let mut bound = Err(io::ErrorKind::AddrInUse.into());
    for _ in 0..attempts {
        bound = TcpListener::bind(address)
            .and_then(|listener| Ok((UdpSocket::bind(listener.local_addr()?)?, listener)))
            .map(|(requests, listener)| (listener, requests));
        if bound.is_ok() {
            break;
        }
    }
    bound
}
