//! The client's end of NatNet, sans-IO: datagrams and time in, frames and datagrams out.
//!
//! ```text
//!              hello, again with back-off                 nothing heard for LOST_AFTER
//! connecting ─────────────────────────────▶ connected ◀─▶ streaming ─────────────────▶ connecting
//! ```
//!
//! A server newer than 4.2 is asked for the bitstream 4.1, which it grants in unicast only. While no frames come the hello is sent
//! again, because a server that was started again has forgotten its unicast clients.

use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;

use super::frames::{self, FrameOfData};
use super::message::{self, ServerInfo, Version, kind};
use super::models;
use crate::bytes::{Malformed, Reader};
use crate::frame::{Body, Frame, Label};
use crate::source::{Exchange, Link, ServerDescription, SourceError, Status};
use crate::time::{HostInstant, ServerInstant};

/// The first pause between two hellos, doubled up to [`LONGEST_PAUSE`]. *Assumed.*
const SHORTEST_PAUSE: Duration = Duration::from_millis(250);
/// The longest pause between two hellos. *Assumed.*
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// Without a frame for this time the hello is sent again. *Assumed.*
const QUIET_AFTER: Duration = Duration::from_secs(1);
/// Without any message for this time the server is away. *Assumed*: several times the pause between two echoes.
const LOST_AFTER: Duration = Duration::from_secs(4);
/// Pause between two signs of life; the SDK's sample sends one every 2 s at least.
const KEEP_ALIVE: Duration = Duration::from_secs(1);
/// Pause between two questions for the server's clock. *Assumed.*
const ECHO: Duration = Duration::from_millis(500);
/// Pause between two questions for the model definitions while a name is missing. *Assumed.*
const ASK_MODELS: Duration = Duration::from_secs(1);

/// When something was done last; due at once while it was never done.
#[derive(Clone, Copy, Debug, Default)]
struct Due(Option<HostInstant>);

impl Due {
    /// Whether `pause` has passed; if so, it counts as done.
    fn take(&mut self, now: HostInstant, pause: Duration) -> bool {
        let due = self.0.is_none_or(|last| now.since(last) >= pause);
        if due {
            self.0 = Some(now);
        }
        due
    }
}

/// A client's session.
#[derive(Debug, Default)]
pub struct Session {
    status: Status,
    info: Option<ServerInfo>,
    /// Where the group was joined.
    interface: Option<Ipv4Addr>,
    /// What frames follow; `None` until it is agreed.
    version: Option<Version>,
    names: BTreeMap<i32, Arc<str>>,
    bodies: Vec<Label>,
    outbox: Vec<Vec<u8>>,
    hellos: u32,
    hello: Due,
    keep_alive: Due,
    echo: Due,
    models: Due,
    models_wanted: bool,
    heard: Option<HostInstant>,
    framed: Option<HostInstant>,
    asked: Option<(u64, HostInstant)>,
    exchange: Option<Exchange>,
}

impl Session {
    /// How it stands.
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// How it stands, to add to it.
    pub fn status_mut(&mut self) -> &mut Status {
        &mut self.status
    }

    /// What the server said of itself.
    pub fn info(&self) -> Option<&ServerInfo> {
        self.info.as_ref()
    }

    /// The bodies of the newest model definitions.
    pub fn bodies(&self) -> &[Label] {
        &self.bodies
    }

    /// The newest exchange of stamps that was not taken yet.
    pub fn take_exchange(&mut self) -> Option<Exchange> {
        self.exchange.take()
    }

    /// Datagrams for the server's command port.
    pub fn take_outbox(&mut self) -> Vec<Vec<u8>> {
        std::mem::take(&mut self.outbox)
    }

    /// Does what is due.
    pub fn handle_timer(&mut self, now: HostInstant) {
        if self.heard.is_some_and(|heard| now.since(heard) >= LOST_AFTER) {
            self.status.note(format!("the server has been silent for {} s", LOST_AFTER.as_secs()));
            self.status.link = Link::Connecting;
            (self.heard, self.framed, self.info, self.version, self.hellos) = (None, None, None, None, 0);
        }
        let quiet = self.framed.is_none_or(|framed| now.since(framed) >= QUIET_AFTER);
        if quiet && self.status.link == Link::Streaming {
            self.status.link = Link::Connected;
        }
        let doubled = SHORTEST_PAUSE.saturating_mul(1 << self.hellos.saturating_sub(1).min(8));
        if quiet && self.hello.take(now, doubled.min(LONGEST_PAUSE)) {
            self.hellos = self.hellos.saturating_add(1);
            self.outbox.push(message::connect());
            // The first hello after an answer comes before frames can have come.
            if self.version.is_some() && self.hellos > 2 {
                self.status.note(self.no_frames());
            }
        }
        let Some(info) = &self.info else { return };
        if info.group.is_none() && self.keep_alive.take(now, KEEP_ALIVE) {
            self.outbox.push(message::message(kind::KEEP_ALIVE, |_| ()));
        }
        if self.echo.take(now, ECHO) {
            let stamp = u64::try_from(now.0.as_nanos()).unwrap_or_default();
            self.asked = Some((stamp, now));
            self.outbox.push(message::echo_request(stamp));
        }
        if self.models_wanted && self.version.is_some() && self.models.take(now, ASK_MODELS) {
            self.outbox.push(message::message(kind::REQUEST_MODEL_DEF, |_| ()));
        }
    }

    /// What is likely wrong with a server that answers and sends no frames.
    fn no_frames(&self) -> String {
        let transport = self.status.server.as_ref().map_or("", |server| server.transport.as_str());
        let likely = match self.info.as_ref().and_then(|info| info.group) {
            Some(_) => {
                "is that the interface of its network, and does a switch or firewall hold multicast back?"
            }
            None => "does a firewall hold UDP back?",
        };
        format!(
            "the server answers, but sends no frames ({transport}): is streaming switched on in Motive, is it live or playing; {likely}"
        )
    }

    /// Takes a datagram of the server.
    ///
    /// # Errors
    /// A server of a version that is not read.
    pub fn handle_datagram(
        &mut self,
        now: HostInstant,
        datagram: &[u8],
    ) -> Result<Option<Frame>, SourceError> {
        match self.take(now, datagram) {
            Ok(Ok(frame)) => {
                self.heard = Some(now);
                Ok(frame)
            }
            Ok(Err(refused)) => {
                self.status.note(&refused);
                Err(refused)
            }
            Err(malformed) => {
                self.status.undecodable += 1;
                self.status.note(format!("a message of the server does not follow NatNet: {malformed}"));
                Ok(None)
            }
        }
    }

    fn take(
        &mut self,
        now: HostInstant,
        datagram: &[u8],
    ) -> Result<Result<Option<Frame>, SourceError>, Malformed> {
        let (kind, payload) = message::split(datagram)?;
        match (kind, self.version) {
            (kind::SERVER_INFO, _) => return Ok(self.meet(ServerInfo::decode(payload)?).map(|()| None)),
            (kind::RESPONSE | kind::UNRECOGNIZED_REQUEST, None) => {
                let granted = kind == kind::RESPONSE && Reader::new(payload).i32_le()? == 0;
                return Ok(self.answered(granted).map(|()| None));
            }
            (kind::MODEL_DEF, Some(version)) => self.learn(&models::decode(payload, version)?),
            (kind::FRAME_OF_DATA, Some(version)) => {
                let frame = frames::decode(payload, version)?;
                self.framed = Some(now);
                self.status.link = Link::Streaming;
                self.hellos = 0;
                return Ok(Ok(Some(self.named(frame))));
            }
            (kind::ECHO_RESPONSE, Some(_)) => self.echoed(now, message::echo_response(payload)?),
            _ => {}
        }
        Ok(Ok(None))
    }

    /// A server has said what it is.
    fn meet(&mut self, info: ServerInfo) -> Result<(), SourceError> {
        let spoken = info.version;
        if spoken.can_step_down() && info.group.is_none() {
            if self.info.as_ref() != Some(&info) {
                (self.version, self.info) = (None, Some(info));
            }
            self.outbox.push(message::request("Bitstream,4.1"));
            return Ok(());
        }
        if !spoken.is_read() {
            return Err(refused(&info));
        }
        self.info = Some(info);
        self.agree(spoken);
        Ok(())
    }

    /// A newer server has answered the request for 4.1.
    fn answered(&mut self, granted: bool) -> Result<(), SourceError> {
        match &self.info {
            Some(_) if granted => self.agree(Version::V4_1),
            Some(info) => return Err(refused(info)),
            None => {}
        }
        Ok(())
    }

    /// Frames follow `version` from now on.
    fn agree(&mut self, version: Version) {
        self.version = Some(version);
        if self.status.link == Link::Connecting {
            self.status.link = Link::Connected;
            self.status.connects += 1;
            self.models_wanted = true;
            self.models = Due::default();
        }
        self.describe();
    }

    /// The group was joined on the interface with this address.
    pub fn joined_on(&mut self, interface: Ipv4Addr) {
        self.interface = Some(interface);
        self.describe();
    }

    fn describe(&mut self) {
        let (Some(info), Some(version)) = (&self.info, self.version) else { return };
        let [major, minor, build, _] = info.application_version;
        let interface =
            self.interface.map_or(String::new(), |interface| format!(" on the interface {interface}"));
        self.status.server = Some(ServerDescription {
            application: format!("{} {major}.{minor}.{build}", info.application),
            protocol: format!("NatNet {version}"),
            transport: match info.group {
                Some(group) => format!("multicast {group}:{}{interface}", info.data_port),
                None => "unicast".into(),
            },
        });
    }

    fn learn(&mut self, models: &[models::Model]) {
        self.bodies = models.iter().map(|model| Label::new(model.number, &model.name)).collect();
        let named = self.bodies.iter().filter_map(|label| Some((label.number?, label.name.clone()?)));
        self.names = named.collect();
        self.models_wanted = false;
    }

    fn echoed(&mut self, now: HostInstant, (stamp, ticks): (u64, u64)) {
        let (Some(info), Some((asked, sent))) = (&self.info, self.asked) else { return };
        if stamp == asked {
            let server = ServerInstant::from_ticks(ticks, info.clock_hz);
            self.exchange = Some(Exchange { sent, server, received: now });
            self.asked = None;
        }
    }

    fn named(&mut self, frame: FrameOfData) -> Frame {
        if frame.bodies.is_empty() && self.bodies.is_empty() && self.status.trouble.is_none() {
            self.status.note(
                "frames have no rigid bodies: switch on \"Rigid Bodies\" in Motive's streaming settings",
            );
        }
        // A body without a definition was added, or streaming of it switched on, after the definitions were asked for.
        let unknown = frame.bodies.iter().any(|body| !self.names.contains_key(&body.number));
        self.models_wanted |= frame.models_changed || unknown;
        let clock_hz = self.info.as_ref().map_or(1, |info| info.clock_hz);
        let captured = match frame.mid_exposure {
            0 => ServerInstant::from_seconds(frame.timestamp_s),
            ticks => ServerInstant::from_ticks(ticks, clock_hz),
        };
        let bodies = frame.bodies.iter().map(|body| Body {
            label: Label { number: Some(body.number), name: self.names.get(&body.number).cloned() },
            position: body.position,
            attitude: body.attitude,
            tracked: body.tracked,
            error: Some(body.error),
        });
        Frame { number: Some(frame.number), captured, bodies: bodies.collect() }
    }
}

fn refused(info: &ServerInfo) -> SourceError {
    let newer = info.version > Version::V4_2;
    SourceError::Version {
        server: info.application.clone(),
        spoken: format!("NatNet {}", info.version),
        read: "NatNet 3.0 to 4.2",
        advice: match (newer, info.group) {
            (true, Some(_)) => "; set Motive to unicast, so that it can be asked for NatNet 4.1",
            (true, None) => "",
            (false, _) => "; update Motive to 2.0 or later",
        },
    }
}
