//! Where frames come from: one trait over all protocols.

use thiserror::Error;

use crate::frame::{Arrival, Label};
use crate::time::{HostInstant, ServerInstant};

/// A stream of frames. It never blocks, and mends its connection by itself.
pub trait Source {
    /// Does what is due at `now` and takes the next frame that has come; `None` where there is none yet. To be called until it
    /// gives `None`, at least every few milliseconds: the time of arrival of a frame is that of the call.
    ///
    /// # Errors
    /// What waiting does not mend: a server of a version that is not read here. A server that is away is no error but a
    /// [`Status`].
    fn poll(&mut self, now: HostInstant) -> Result<Option<Arrival>, SourceError>;

    /// How the connection stands.
    fn status(&self) -> &Status;

    /// The bodies that the server has announced, in its order; empty as long as it has not.
    fn bodies(&self) -> &[Label];

    /// The newest exchange of time stamps with the server that was not asked for yet; protocols without one never have any.
    fn exchange(&mut self) -> Option<Exchange> {
        None
    }
}

/// A question and its answer that say how the clocks lie: the server read its own between the two instants of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// When the host asked.
    pub sent: HostInstant,
    /// What the server's clock said.
    pub server: ServerInstant,
    /// When the host had the answer.
    pub received: HostInstant,
}

/// How a connection stands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// How far it has come.
    pub link: Link,
    /// What the server says of itself.
    pub server: Option<ServerDescription>,
    /// Connections that were made so far: above one, it has been lost and made again.
    pub connects: u32,
    /// Messages that did not follow the protocol.
    pub undecodable: u64,
    /// Datagrams from machines other than the server.
    pub foreign: u64,
    /// What went wrong last, in words for the operator.
    pub trouble: Option<String>,
}

impl Status {
    /// Remembers what went wrong.
    pub fn note(&mut self, trouble: impl ToString) {
        self.trouble = Some(trouble.to_string());
    }
}

/// How far a connection has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Link {
    /// The server has not answered, or not for a while.
    #[default]
    Connecting,
    /// The server answers, but there are no frames.
    Connected,
    /// Frames come.
    Streaming,
}

/// What a server says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerDescription {
    /// Its name and version, such as `Motive 3.1.2`.
    pub application: String,
    /// The protocol and version in force, such as `NatNet 4.1`.
    pub protocol: String,
    /// How frames come, such as `multicast 239.255.42.99:1511 on 192.168.1.7`.
    pub transport: String,
}

/// What waiting does not mend.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SourceError {
    /// The server speaks a version that is not read here.
    #[error("{server} speaks {spoken}; this program reads {read}{advice}")]
    Version {
        /// Who.
        server: String,
        /// What it speaks.
        spoken: String,
        /// What would do.
        read: &'static str,
        /// What the operator can do, with its own punctuation; may be empty.
        advice: &'static str,
    },
    /// The program that brings the poses has ended; it says why itself.
    #[error("{program}, which brings the poses, has ended: {status}")]
    Ended {
        /// Which.
        program: &'static str,
        /// How, as the operating system says.
        status: String,
    },
    /// A socket could not be opened.
    #[error("cannot open a socket for {purpose}: {reason}")]
    Socket {
        /// What for.
        purpose: String,
        /// What the operating system said.
        reason: String,
    },
}
