//! The client's socket.

use std::io::ErrorKind;
use std::net::SocketAddr;
use std::sync::Arc;

use super::session::Session;
use crate::frame::{Arrival, Label};
use crate::source::{Link, Source, SourceError, Status};
use crate::stream::{Connection, Turn};
use crate::time::HostInstant;

/// A client of VRPN.
#[derive(Debug)]
pub struct VrpnClient {
    server: SocketAddr,
    wanted: Vec<Arc<str>>,
    connection: Connection,
    session: Option<Session>,
    status: Status,
    received: Vec<u8>,
}

impl VrpnClient {
    /// A client of the server at `server` that takes the poses of `wanted`, or of every tracker if there are none.
    pub fn new(server: SocketAddr, wanted: &[&str]) -> Self {
        Self {
            server,
            wanted: wanted.iter().map(|&name| name.into()).collect(),
            connection: Connection::new(server),
            session: None,
            status: Status::default(),
            received: Vec::new(),
        }
    }

    fn lose(&mut self, trouble: String) {
        self.session = None;
        self.status.link = Link::Connecting;
        self.status.note(trouble);
    }

    /// Looks after the connection and takes what has come over it.
    fn exchange(&mut self, now: HostInstant) -> Result<(), SourceError> {
        let peer = match self.connection.poll(now) {
            Turn::Down => return Ok(()),
            Turn::Lost(error) => {
                self.lose(format!("no connection to VRPN {}: {error}", self.server));
                return Ok(());
            }
            Turn::Made(peer) => {
                self.session = Some(Session::new(now, &self.wanted));
                self.received.clear();
                peer
            }
            Turn::Up(peer) => peer,
        };
        let Some(session) = &mut self.session else { return Ok(()) };
        session.handle_timer(now, &mut self.status);
        let mut done = peer.receive(&mut self.received);
        // What came before the end of the connection is taken too.
        let followed = session.handle_bytes(now, &mut self.received, &mut self.status);
        done = done.and_then(|()| peer.send(&session.take_outgoing()));
        if session.is_lost(now) {
            done = done.and(Err(ErrorKind::TimedOut.into()));
        }
        match (followed, done) {
            (Ok(Ok(())), Ok(())) => {
                if self.status.link != Link::Connecting {
                    self.connection.proven();
                }
                Ok(())
            }
            (Err(error), _) => {
                self.connection.close(now);
                self.lose(error.to_string());
                Err(error)
            }
            (Ok(Err(malformed)), _) => {
                self.status.undecodable += 1;
                self.connection.close(now);
                self.lose(format!("{} does not speak VRPN: {malformed}", self.server));
                Ok(())
            }
            (Ok(Ok(())), Err(error)) => {
                self.connection.close(now);
                self.lose(format!("the connection to VRPN {} is lost: {error}", self.server));
                Ok(())
            }
        }
    }

    fn frame(&mut self, now: HostInstant) -> Option<Arrival> {
        let frame = self.session.as_mut()?.take_frame()?;
        Some(Arrival { frame, arrived: now })
    }
}

impl Source for VrpnClient {
    fn poll(&mut self, now: HostInstant) -> Result<Option<Arrival>, SourceError> {
        // Frames that came together are handed out one by one before the socket is looked at again.
        if let Some(arrival) = self.frame(now) {
            return Ok(Some(arrival));
        }
        self.exchange(now)?;
        Ok(self.frame(now))
    }

    fn status(&self) -> &Status {
        &self.status
    }

    fn bodies(&self) -> &[Label] {
        self.session.as_ref().map_or(&[], |session| session.bodies())
    }
}
