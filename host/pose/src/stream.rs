//! TCP connections that never block: one that is made again by itself, for clients, and one that was accepted, for servers.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use socket2::{Domain, Protocol, SockAddr, Socket, Type};

use crate::time::HostInstant;

/// The first pause between two attempts, doubled up to [`LONGEST_PAUSE`]. *Assumed.*
const SHORTEST_PAUSE: Duration = Duration::from_millis(250);
/// The longest pause between two attempts. *Assumed.*
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// An attempt that is not answered for this time is given up. *Assumed.*
const PATIENCE: Duration = Duration::from_secs(3);
/// Bytes that wait for a peer before it counts as one that does not keep up. *Assumed*: seconds of a fleet's frames.
const MOST_WAITING: usize = 1 << 20;
/// Bytes taken in one poll, so that a flood does not hold the caller. *Assumed.*
const MOST_A_POLL: usize = 1 << 20;

/// An open connection: bytes out wait here until the socket takes them.
#[derive(Debug)]
pub struct Peer {
    stream: TcpStream,
    waiting: Vec<u8>,
}

impl Peer {
    /// Around a connected socket.
    ///
    /// # Errors
    /// A socket that cannot be set not to block.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        // Frames are small, and each is wanted at once.
        stream.set_nodelay(true)?;
        Ok(Self { stream, waiting: Vec::new() })
    }

    /// The other end.
    ///
    /// # Errors
    /// A connection that is gone.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.stream.peer_addr()
    }

    /// This end.
    ///
    /// # Errors
    /// A connection that is gone.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.stream.local_addr()
    }

    /// Sends bytes, or keeps them until the socket takes them.
    ///
    /// # Errors
    /// A connection that is broken, or a peer that does not keep up.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.waiting.extend(bytes);
        self.flush()
    }

    /// Sends what waits.
    ///
    /// # Errors
    /// A connection that is broken, or a peer that does not keep up.
    pub fn flush(&mut self) -> io::Result<()> {
        while !self.waiting.is_empty() {
            match self.stream.write(&self.waiting) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(taken) => drop(self.waiting.drain(..taken)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        match self.waiting.len() {
            0..=MOST_WAITING => Ok(()),
            _ => Err(io::Error::new(ErrorKind::TimedOut, "the other end does not keep up")),
        }
    }

    /// Adds what has come to `bytes`.
    ///
    /// # Errors
    /// A connection that is broken or closed by the other end.
    pub fn receive(&mut self, bytes: &mut Vec<u8>) -> io::Result<()> {
        let mut chunk = [0; 16_384];
        let mut taken = 0;
        while taken < MOST_A_POLL {
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(io::Error::new(ErrorKind::UnexpectedEof, "closed by the other end")),
                Ok(count) => {
                    bytes.extend(chunk.get(..count).unwrap_or_default());
                    taken += count;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// A client's connection.
#[derive(Debug)]
pub struct Connection {
    server: SocketAddr,
    state: State,
    /// Attempts since it stood last.
    attempts: u32,
}

#[derive(Debug)]
enum State {
    Down { again: HostInstant },
    Trying { socket: Socket, since: HostInstant },
    Up(Peer),
}

/// What has become of a connection in one poll.
#[derive(Debug)]
pub enum Turn<'a> {
    /// It does not stand.
    Down,
    /// It has just been lost or refused, and why.
    Lost(io::Error),
    /// It has just been made.
    Made(&'a mut Peer),
    /// It stands.
    Up(&'a mut Peer),
}

impl Connection {
    /// A connection to `server`, to be made at the first poll.
    pub fn new(server: SocketAddr) -> Self {
        Self { server, state: State::Down { again: HostInstant::default() }, attempts: 0 }
    }

    /// Gives the connection up; another is made after a pause.
    pub fn close(&mut self, now: HostInstant) {
        let doubled = SHORTEST_PAUSE.saturating_mul(1 << self.attempts.min(8));
        self.attempts = self.attempts.saturating_add(1);
        self.state = State::Down { again: now.after(doubled.min(LONGEST_PAUSE)) };
    }

    /// The other end has shown that it speaks the protocol: the next attempt after a loss is made soon.
    pub fn proven(&mut self) {
        self.attempts = 0;
    }

    /// Makes the connection, or sends what waits on it.
    pub fn poll(&mut self, now: HostInstant) -> Turn<'_> {
        match self.step(now) {
            Ok(false) => match &mut self.state {
                State::Up(peer) => Turn::Up(peer),
                _ => Turn::Down,
            },
            Ok(true) => match &mut self.state {
                State::Up(peer) => Turn::Made(peer),
                _ => Turn::Down,
            },
            Err(error) => {
                self.close(now);
                Turn::Lost(error)
            }
        }
    }

    /// One step; whether the connection was made in it.
    fn step(&mut self, now: HostInstant) -> io::Result<bool> {
        match &mut self.state {
            State::Down { again } if now >= *again => {
                let socket = begin(self.server)?;
                self.state = State::Trying { socket, since: now };
                Ok(false)
            }
            State::Down { .. } => Ok(false),
            State::Trying { socket, since } => {
                if let Some(error) = socket.take_error()? {
                    return Err(error);
                }
                if socket.peer_addr().is_err() {
                    let late = now.since(*since) >= PATIENCE;
                    return if late { Err(ErrorKind::TimedOut.into()) } else { Ok(false) };
                }
                let stream = socket.try_clone()?.into();
                self.state = State::Up(Peer::new(stream)?);
                Ok(true)
            }
            State::Up(peer) => peer.flush().map(|()| false),
        }
    }
}

/// Begins to connect.
fn begin(server: SocketAddr) -> io::Result<Socket> {
    let socket = Socket::new(Domain::for_address(server), Type::STREAM, Some(Protocol::TCP))?;
    socket.set_nonblocking(true)?;
    match socket.connect(&SockAddr::from(server)) {
        Ok(()) => Ok(socket),
        Err(error) if in_progress(&error) => Ok(socket),
        Err(error) => Err(error),
    }
}

fn in_progress(error: &io::Error) -> bool {
    // EINPROGRESS has a kind of its own that is not stable yet; 115 on Linux, 36 on the BSDs.
    error.kind() == ErrorKind::WouldBlock || matches!(error.raw_os_error(), Some(115 | 36))
}
