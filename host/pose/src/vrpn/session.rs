//! The client's end of VRPN, sans-IO: bytes and time in, frames and bytes out.
//!
//! A tracker is a sender of its own, and each of its poses a message of its own. Poses captured within a millisecond make one frame;
//! it is complete when every tracker that was heard lately is in it, when one comes a second time, or after 5 ms.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use super::message::{self, Message, Pose};
use crate::bytes::Malformed;
use crate::frame::{Body, Frame, Label};
use crate::source::{Link, ServerDescription, SourceError, Status};
use crate::time::{HostInstant, ServerInstant};

/// Poses with times no further apart belong to one frame, s. Servers that stamp every message by itself are off by as much.
/// *Assumed*: a tenth of a period at 100 Hz.
const TOGETHER_S: f64 = 1e-3;
/// How long a frame waits for the trackers that are missing. *Assumed.*
const WAIT: Duration = Duration::from_millis(5);
/// A tracker that was heard within this time is waited for. *Assumed*: several periods of the slowest stream worth having, 10 Hz.
const LATELY: Duration = Duration::from_millis(500);
/// Without a frame for this time there is no stream. *Assumed.*
const QUIET_AFTER: Duration = Duration::from_secs(1);
/// Pause between two signs of life that are asked for: VRPN's own.
const PING: Duration = Duration::from_secs(1);
/// Without any message for this time the server is away: VRPN warns from 3 s on.
const LOST_AFTER: Duration = Duration::from_secs(4);
/// Names that are remembered: `vrpn_CONNECTION_MAX_SENDERS`.
const MOST_NAMES: usize = 2000;
/// The kind of a ping, by the numbers of this end.
const PING_KIND: i32 = 0;

/// A client's session; a new connection needs a new one.
#[derive(Debug)]
pub struct Session {
    /// The trackers that are wanted; all if there are none.
    wanted: Vec<Arc<str>>,
    met: bool,
    outgoing: Vec<u8>,
    senders: BTreeMap<i32, Arc<str>>,
    kinds: BTreeMap<i32, String>,
    bodies: Vec<Label>,
    /// When each of `bodies` was heard last.
    last: Vec<HostInstant>,
    /// The frame that is being put together, and when its first pose came.
    open: Option<(Frame, HostInstant)>,
    ready: VecDeque<Frame>,
    since: HostInstant,
    heard: HostInstant,
    framed: Option<HostInstant>,
    pinged: Option<HostInstant>,
}

impl Session {
    /// A session on a connection made at `now`.
    pub fn new(now: HostInstant, wanted: &[Arc<str>]) -> Self {
        let mut outgoing = message::cookie().to_vec();
        outgoing.extend(Message::description(message::KIND_DESCRIPTION, PING_KIND, message::PING).encode());
        Self {
            wanted: wanted.to_vec(),
            met: false,
            outgoing,
            senders: BTreeMap::new(),
            kinds: BTreeMap::new(),
            bodies: Vec::new(),
            last: Vec::new(),
            open: None,
            ready: VecDeque::new(),
            since: now,
            heard: now,
            framed: None,
            pinged: None,
        }
    }

    /// The trackers that have sent poses, in the order of the first.
    pub fn bodies(&self) -> &[Label] {
        &self.bodies
    }

    /// Bytes for the server.
    pub fn take_outgoing(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.outgoing)
    }

    /// Whether the server is away.
    pub fn is_lost(&self, now: HostInstant) -> bool {
        now.since(self.heard) >= LOST_AFTER
    }

    /// Does what is due.
    pub fn handle_timer(&mut self, now: HostInstant, status: &mut Status) {
        if self.open.as_ref().is_some_and(|(_, since)| now.since(*since) >= WAIT) {
            self.complete();
        }
        let quiet = self.framed.is_none_or(|framed| now.since(framed) >= QUIET_AFTER);
        if quiet && status.link == Link::Streaming {
            status.link = Link::Connected;
        }
        if quiet && self.met && self.pinged.is_none_or(|pinged| now.since(pinged) >= PING) {
            self.pinged = Some(now);
            // A tracker answers for its server; its number here is that of the server.
            if let Some((&number, name)) = self.senders.iter().find(|(_, name)| &***name != message::CONTROL)
            {
                self.outgoing
                    .extend(Message::description(message::SENDER_DESCRIPTION, number, name).encode());
                let ping = Message {
                    time: ServerInstant::default(),
                    sender: number,
                    kind: PING_KIND,
                    payload: Vec::new(),
                };
                self.outgoing.extend(ping.encode());
            } else {
                // There is nothing to ask, and TCP itself shows a server that has gone.
                self.heard = now;
            }
            if self.bodies.is_empty() && now.since(self.since) >= QUIET_AFTER {
                status.note(self.missing());
            }
        }
    }

    /// Why there are no poses.
    fn missing(&self) -> String {
        let there: Vec<String> = self
            .senders
            .values()
            .filter(|name| &***name != message::CONTROL)
            .map(|name| format!("\"{name}\""))
            .collect();
        match (&*self.wanted, there.is_empty()) {
            (_, true) => "the VRPN server has no trackers".into(),
            ([], false) => format!("the VRPN server sends no poses of its trackers {}", there.join(", ")),
            (wanted, false) => {
                let wanted: Vec<String> = wanted.iter().map(|name| format!("\"{name}\"")).collect();
                format!(
                    "the VRPN server sends no poses of {}; it has {}",
                    wanted.join(", "),
                    there.join(", ")
                )
            }
        }
    }

    /// Takes bytes of the server, as far as they are whole, and leaves the rest.
    ///
    /// # Errors
    /// A server of a version that is not read. Bytes that cannot be followed are `Ok(Err)`.
    pub fn handle_bytes(
        &mut self,
        now: HostInstant,
        stream: &mut Vec<u8>,
        status: &mut Status,
    ) -> Result<Result<(), Malformed>, SourceError> {
        if !self.met {
            if stream.len() < message::COOKIE_LENGTH {
                return Ok(Ok(()));
            }
            let cookie: Vec<u8> = stream.drain(..message::COOKIE_LENGTH).collect();
            self.meet(&cookie, status)?;
        }
        loop {
            match message::take(stream) {
                Ok(None) => return Ok(Ok(())),
                Ok(Some(message)) => {
                    self.heard = now;
                    if let Err(malformed) = self.take(now, &message, status) {
                        status.undecodable += 1;
                        status.note(format!("a message of the server does not follow VRPN: {malformed}"));
                    }
                }
                Err(malformed) => return Ok(Err(malformed)),
            }
        }
    }

    fn meet(&mut self, cookie: &[u8], status: &mut Status) -> Result<(), SourceError> {
        let text: String =
            crate::bytes::text_of(cookie).chars().filter(|letter| !letter.is_control()).collect();
        let spoken = text.split_whitespace().take(3).collect::<Vec<_>>().join(" ");
        if !message::is_read(cookie) {
            return Err(SourceError::Version {
                server: "the server".into(),
                spoken: format!("\"{spoken}\""),
                read: "VRPN 07",
                advice: "",
            });
        }
        self.met = true;
        status.link = Link::Connected;
        status.connects += 1;
        status.server = Some(ServerDescription {
            application: "VRPN server".into(),
            protocol: spoken.replace("vrpn: ver. ", "VRPN "),
            transport: "TCP".into(),
        });
        Ok(())
    }

    fn take(&mut self, now: HostInstant, message: &Message, status: &mut Status) -> Result<(), Malformed> {
        match message.kind {
            message::SENDER_DESCRIPTION if self.senders.len() < MOST_NAMES => {
                self.senders.insert(message.sender, message.described()?.into());
            }
            message::KIND_DESCRIPTION if self.kinds.len() < MOST_NAMES => {
                self.kinds.insert(message.sender, message.described()?);
            }
            kind if self.kinds.get(&kind).is_some_and(|name| name == message::POSE) => {
                let Some(name) = self.senders.get(&message.sender).cloned() else { return Ok(()) };
                if self.wanted.is_empty() || self.wanted.contains(&name) {
                    if self.bodies.is_empty() {
                        // What was missing is here.
                        status.trouble = None;
                    }
                    self.framed = Some(now);
                    status.link = Link::Streaming;
                    self.add(now, message.time, &name, &Pose::decode(&message.payload)?);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn add(&mut self, now: HostInstant, time: ServerInstant, name: &Arc<str>, pose: &Pose) {
        let name = match pose.sensor {
            0 => name.clone(),
            sensor => format!("{name}/{sensor}").into(),
        };
        let label = Label { number: None, name: Some(name) };
        match self.bodies.iter().position(|known| *known == label) {
            Some(at) => self.last.iter_mut().skip(at).take(1).for_each(|last| *last = now),
            None if self.bodies.len() < MOST_NAMES => {
                self.bodies.push(label.clone());
                self.last.push(now);
            }
            None => return,
        }
        let fits = |(frame, _): &(Frame, HostInstant)| {
            let apart = time.seconds_since(frame.captured).abs();
            apart <= TOGETHER_S && frame.bodies.iter().all(|body| body.label != label)
        };
        if !self.open.as_ref().is_some_and(fits) {
            self.complete();
        }
        let (frame, _) = self
            .open
            .get_or_insert_with(|| (Frame { number: None, captured: time, bodies: Vec::new() }, now));
        frame.bodies.push(Body {
            label,
            position: pose.position,
            attitude: pose.attitude,
            // A tracker that sees nothing sends nothing.
            tracked: true,
            error: None,
        });
        let waited_for = self.last.iter().filter(|&&last| now.since(last) < LATELY).count();
        if frame.bodies.len() >= waited_for {
            self.complete();
        }
    }

    fn complete(&mut self) {
        self.ready.extend(self.open.take().map(|(frame, _)| frame));
    }

    /// The next frame that is complete.
    pub fn take_frame(&mut self) -> Option<Frame> {
        self.ready.pop_front()
    }
}
