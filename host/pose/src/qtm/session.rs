//! The client's end of QTM RT, sans-IO: packets and time in, frames and packets out.
//!
//! ```text
//! greeting ──▶ version, down from 1.25 ──▶ parameters ──▶ frames
//! ```
//!
//! The parameters are asked for again when QTM says that something began or changed, and while frames have another number of bodies.

use std::collections::VecDeque;
use std::time::Duration;

use super::data::{self, Data};
use super::packet::{Packet, event};
use super::parameters;
use crate::frame::{Body, Frame, Label};
use crate::source::{Link, ServerDescription, SourceError, Status};
use crate::time::{HostInstant, ServerInstant};

/// Versions that are asked for, in this order. From 1.8 on bodies are laid out as in [`data`]; 1.25 is the newest of the vendor's
/// Python client.
const VERSIONS: [&str; 5] = ["1.25", "1.23", "1.19", "1.13", "1.8"];
/// Pause between two questions while the answer is not what is needed. *Assumed.*
const AGAIN: Duration = Duration::from_secs(1);
/// Without a frame for this time there is no stream. *Assumed.*
const QUIET_AFTER: Duration = Duration::from_secs(1);
/// Pause between two signs of life that are asked for while no frames come. *Assumed.*
const PING: Duration = Duration::from_secs(1);
/// Without any packet for this time the server is away. *Assumed.*
pub const LOST_AFTER: Duration = Duration::from_secs(4);

/// How far a session has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Greeting,
    /// The version at this place of [`VERSIONS`] was asked for.
    Version(usize),
    /// The parameters were asked for before any frame.
    Parameters,
    Frames,
}

/// A client's session; a new connection needs a new one.
#[derive(Debug)]
pub struct Session {
    phase: Phase,
    /// Where UDP frames are to be sent, if not over the connection.
    udp_port: Option<u16>,
    version: &'static str,
    application: String,
    bodies: Vec<Label>,
    /// The same with those that are switched off.
    all: Vec<Label>,
    outbox: VecDeque<Packet>,
    heard: HostInstant,
    framed: Option<HostInstant>,
    pinged: HostInstant,
    asked: HostInstant,
    ask_again: bool,
}

impl Session {
    /// A session on a connection made at `now`; with a port, frames come to it as UDP datagrams.
    pub fn new(now: HostInstant, udp_port: Option<u16>) -> Self {
        Self {
            phase: Phase::Greeting,
            udp_port,
            version: "",
            application: "QTM".into(),
            bodies: Vec::new(),
            all: Vec::new(),
            outbox: VecDeque::new(),
            heard: now,
            framed: None,
            pinged: now,
            asked: now,
            ask_again: false,
        }
    }

    /// The bodies of the newest parameters.
    pub fn bodies(&self) -> &[Label] {
        &self.bodies
    }

    /// The next packet for the server.
    pub fn take_outgoing(&mut self) -> Option<Packet> {
        self.outbox.pop_front()
    }

    /// Whether the server is away.
    pub fn is_lost(&self, now: HostInstant) -> bool {
        now.since(self.heard) >= LOST_AFTER
    }

    /// Does what is due.
    pub fn handle_timer(&mut self, now: HostInstant, status: &mut Status) {
        let quiet = self.framed.is_none_or(|framed| now.since(framed) >= QUIET_AFTER);
        if quiet && status.link == Link::Streaming {
            status.link = Link::Connected;
        }
        if quiet && self.phase == Phase::Frames && now.since(self.pinged) >= PING {
            self.pinged = now;
            self.send("ByteOrder");
        }
        if self.ask_again && now.since(self.asked) >= AGAIN {
            self.ask(now);
        }
    }

    fn send(&mut self, command: &str) {
        self.outbox.push_back(Packet::Command(command.into()));
    }

    fn ask(&mut self, now: HostInstant) {
        (self.asked, self.ask_again) = (now, false);
        self.send("GetParameters 6D");
    }

    /// Takes a packet of the server.
    ///
    /// # Errors
    /// A server of a version that is not read.
    pub fn handle_packet(
        &mut self,
        now: HostInstant,
        packet: Packet,
        status: &mut Status,
    ) -> Result<Option<Frame>, SourceError> {
        self.heard = now;
        match packet {
            Packet::Command(text) => self.answered(now, &text, status)?,
            Packet::Error(text) => self.failed(now, &text, status)?,
            Packet::Xml(text) => self.learn(now, &text, status),
            Packet::Data(content) => match data::decode(&content) {
                Ok(data) => return Ok(self.framed(now, data, status)),
                Err(malformed) => {
                    status.undecodable += 1;
                    status.note(format!("a frame of QTM does not follow its protocol: {malformed}"));
                }
            },
            Packet::NoMoreData => status.note("QTM is not measuring: start a measurement or a preview"),
            Packet::Event(
                event::CONNECTED
                | event::CAPTURE_STARTED
                | event::RT_FROM_FILE_STARTED
                | event::CAMERA_SETTINGS_CHANGED,
            ) => self.ask_again = self.phase == Phase::Frames,
            Packet::Event(event::CONNECTION_CLOSED) => status.note("QTM has disconnected from its cameras"),
            Packet::Event(event::QTM_SHUTTING_DOWN) => status.note("QTM is shutting down"),
            Packet::Event(_) | Packet::Other(_) => {}
        }
        Ok(None)
    }

    fn answered(&mut self, now: HostInstant, text: &str, status: &mut Status) -> Result<(), SourceError> {
        match self.phase {
            Phase::Greeting if text.starts_with("QTM RT Interface connected") => self.ask_version(0)?,
            Phase::Version(at) if text.starts_with("Version set to") => {
                self.version = VERSIONS.get(at).copied().unwrap_or_default();
                self.send("QTMVersion");
                self.ask(now);
                self.phase = Phase::Parameters;
                self.describe(status);
            }
            Phase::Version(at) => self.ask_version(at + 1)?,
            _ => {
                if let Some(version) = text.strip_prefix("QTM Version is ") {
                    self.application = format!("QTM {version}");
                    self.describe(status);
                }
            }
        }
        Ok(())
    }

    fn ask_version(&mut self, at: usize) -> Result<(), SourceError> {
        let version = VERSIONS.get(at).ok_or_else(|| SourceError::Version {
            server: self.application.clone(),
            spoken: "none of the versions of QTM RT that it was asked for".into(),
            read: "QTM RT 1.8 to 1.25",
            advice: "; update QTM",
        })?;
        self.send(&format!("Version {version}"));
        self.phase = Phase::Version(at);
        Ok(())
    }

    fn describe(&self, status: &mut Status) {
        let transport = self.udp_port.map_or("TCP".into(), |port| format!("UDP to port {port}"));
        status.server = Some(ServerDescription {
            application: self.application.clone(),
            protocol: format!("QTM RT {}", self.version),
            transport,
        });
    }

    fn failed(&mut self, now: HostInstant, text: &str, status: &mut Status) -> Result<(), SourceError> {
        match self.phase {
            Phase::Version(at) => self.ask_version(at + 1)?,
            Phase::Greeting => status.note(format!("QTM refuses the connection: {text}")),
            Phase::Parameters | Phase::Frames => {
                status.note(format!("QTM says: {text}"));
                (self.asked, self.ask_again) = (now, true);
            }
        }
        Ok(())
    }

    fn learn(&mut self, now: HostInstant, xml: &str, status: &mut Status) {
        let settings = parameters::bodies(xml);
        let enabled = settings.iter().filter(|body| body.enabled);
        self.bodies = enabled.map(|body| Label::named(&body.name)).collect();
        self.all = settings.iter().map(|body| Label::named(&body.name)).collect();
        if self.bodies.is_empty() {
            status.note(
                "QTM has no 6DOF bodies: add them in its project options, and switch on \"Calculate 6DOF\"",
            );
            (self.asked, self.ask_again) = (now, true);
        }
        if self.phase == Phase::Parameters {
            let udp = self.udp_port.map_or_else(String::new, |port| format!("UDP:{port} "));
            self.send(&format!("StreamFrames AllFrames {udp}6DRes"));
            self.phase = Phase::Frames;
            status.link = Link::Connected;
            status.connects += 1;
        }
    }

    fn framed(&mut self, now: HostInstant, data: Data, status: &mut Status) -> Option<Frame> {
        let Some(bodies) = data.bodies else {
            status.note("frames of QTM have no 6DOF bodies: switch on \"Calculate 6DOF\" for real time");
            return None;
        };
        self.framed = Some(now);
        status.link = Link::Streaming;
        // Names go by their place, so with another number of bodies none is known. The documentation leaves open whether bodies
        // that are switched off have a place.
        let known = [&self.bodies, &self.all].into_iter().find(|known| known.len() == bodies.len());
        self.ask_again |= known.is_none();
        let label = |at: usize| known.and_then(|known| known.get(at)).cloned().unwrap_or_default();
        let bodies = bodies.into_iter().enumerate().map(|(at, body)| Body {
            label: label(at),
            position: body.position,
            attitude: body.attitude,
            tracked: body.tracked,
            error: body.residual,
        });
        let micros = i64::try_from(data.timestamp_us).unwrap_or(i64::MAX);
        let captured = ServerInstant(micros.saturating_mul(1000));
        Some(Frame { number: Some(data.number), captured, bodies: bodies.collect() })
    }
}
