//! A module that lies: what it seals goes through here, and its reports come out with numbers that no module can have, under a seal that is
//! right.
//!
//! It has the module's key, as the module has. It seals every datagram of a session once more, so that its numbers are the module's.

use std::collections::HashMap;

use protocol::time::Duration;
use protocol::units::{Radians, RadiansPerSecond, Volts};
use protocol::{FleetId, Frame, Kind, MAX_DATAGRAM, Message, ModuleId, ModuleKey, Nonce, Session, Side};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The session of a module, from both ends.
struct Shadow {
    module: Session,
    host: Session,
}

/// See the module's documentation.
pub struct Liar {
    fleet: FleetId,
    id: ModuleId,
    key: ModuleKey,
    /// Whether it lies now.
    pub lies: bool,
    announced: Vec<Nonce>,
    /// The host's nonce of each session that it was called into.
    calls: HashMap<u32, Nonce>,
    shadow: Option<Shadow>,
    rng: ChaCha8Rng,
}

impl Liar {
    /// The module `id`; it tells the truth until it is told to lie.
    #[must_use]
    pub fn new(fleet: FleetId, id: ModuleId, key: ModuleKey, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { fleet, id, key, lies: false, announced: Vec::new(), calls: HashMap::new(), shadow: None, rng }
    }

    /// What the module hears.
    pub fn hear(&mut self, datagram: &[u8]) {
        let Ok(Frame { header, .. }) = Frame::parse(datagram) else { return };
        if let (Kind::Call, Some(nonce)) = (header.kind, header.nonce) {
            self.calls.insert(header.session, nonce);
        }
    }

    /// What it says instead of `datagram`, if that is a report.
    pub fn say(&mut self, datagram: &[u8]) -> Option<Vec<u8>> {
        let frame = Frame::parse(datagram).expect("a module seals whole datagrams");
        let header = &frame.header;
        if let Some(nonce) = header.nonce {
            if self.announced.last() != Some(&nonce) {
                self.announced.push(nonce);
            }
            return None;
        }
        if self.shadow.as_ref().is_none_or(|shadow| shadow.module.id() != header.session) {
            self.shadow = self.follow(header.session);
        }
        let shadow = self.shadow.as_mut()?;
        let message = shadow.host.open(&frame).expect("the module's own").message;
        let lie = lie(&mut self.rng, &message);
        let mut buffer = [0; MAX_DATAGRAM];
        let sealed = shadow.module.seal(lie.as_ref().unwrap_or(&message), &mut buffer).expect("room");
        (self.lies && lie.is_some()).then(|| sealed.to_vec())
    }

    fn follow(&self, session: u32) -> Option<Shadow> {
        let host = *self.calls.get(&session)?;
        let end = |side, boot| Session::new(side, self.fleet, self.id, &self.key, boot, host);
        let boot = self.announced.iter().rev().find(|boot| end(Side::Module, boot).id() == session)?;
        Some(Shadow { module: end(Side::Module, boot), host: end(Side::Host, boot) })
    }
}

/// A report with one number that is none.
fn lie(rng: &mut ChaCha8Rng, truth: &Message) -> Option<Message> {
    const NONE: [f32; 4] = [f32::NAN, f32::INFINITY, 1e30, -1e30];
    let none = NONE[rng.random_range(0..NONE.len())];
    let kind = rng.random_range(0..5);
    // More than any host of a storm gets to.
    let cycle = rng.random_range(100_000..u32::MAX);
    match truth {
        Message::Telemetry(report) => {
            let mut report = *report;
            match kind {
                0 => report.tail = Radians(none),
                1 => report.rate = RadiansPerSecond(none),
                2 => report.battery = Volts(1e30),
                3 => report.at = report.at.after(Duration(u32::MAX)),
                _ => report.cycle = cycle,
            }
            Some(Message::Telemetry(report))
        }
        Message::TailUnknown(report) => {
            let mut report = *report;
            match kind {
                0 | 1 => report.battery = Volts(-1e30),
                _ => report.cycle = cycle,
            }
            Some(Message::TailUnknown(report))
        }
        _ => None,
    }
}
