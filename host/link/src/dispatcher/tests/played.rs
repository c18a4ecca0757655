//! Modules as a test plays them, and a dispatcher that they talk to.

pub(super) use protocol::ModuleState;
use protocol::session::Opened;
pub(super) use protocol::time::Duration;
use protocol::time::FleetInstant;
use protocol::units::{Amperes, Newtons, PulseMicros, Radians, RadiansPerSecond, Volts};
use protocol::{
    Announcer, Connectors, Faults, FleetKey, Hello, MAX_DATAGRAM, ModboatCycle, ModuleKey, ModuleKind,
    RovCycle, RovTelemetry, Session, Side, Telemetry,
};

use super::super::*;

pub(super) const KEY: FleetKey = FleetKey::new([7; 32]);
pub(super) const HOST: [u8; 12] = [9; 12];

pub(super) const SWIM: Motion = Motion::Modboat(ModboatCycle {
    rotation: Radians(0.5),
    centerline: Radians(0.0),
    amplitude: Radians(1.0),
    transition: Duration(500_000),
    period: Duration(1_500_000),
    law: protocol::TransitionLaw::ConstantSpeed,
});

pub(super) fn thrust(lease: Duration) -> Motion {
    Motion::Rov(RovCycle {
        thrusts: [Newtons(4.0)].into_iter().collect(),
        lease,
        connectors: Connectors::Closed,
    })
}

pub(super) fn answer(cycle: u32, verdict: Verdict) -> Message {
    Message::Acknowledge(Acknowledge { cycle, verdict })
}

pub(super) fn health() -> Message {
    Message::Health(protocol::Health::default())
}

/// A Modboat's report of `at`, µs.
pub(super) fn report(at: u64, cycle: u32, state: ModuleState) -> Message {
    Message::Telemetry(Telemetry {
        at: FleetInstant(at),
        state,
        cycle,
        tail: Radians(0.0),
        rate: RadiansPerSecond(0.0),
        current: Amperes(0.0),
        battery: Volts(7.4),
        faults: Faults::default(),
    })
}

/// An ROV's report of `at`, µs.
pub(super) fn rov_report(at: u64, cycle: u32) -> Message {
    Message::RovTelemetry(RovTelemetry {
        at: FleetInstant(at),
        state: ModuleState::Executing,
        cycle,
        pulses: [PulseMicros(1580.0)].into_iter().collect(),
        battery: Volts(16.0),
        current: Amperes(1.0),
        faults: Faults::default(),
    })
}

/// The module's side of the link; it draws a nonce at every boot and counts its sessions on.
#[derive(Debug)]
pub(super) struct Played {
    id: ModuleId,
    fleet: FleetId,
    key: ModuleKey,
    boot: [u8; 12],
    sessions: u32,
    pub(super) announcer: Announcer,
    pub(super) session: Option<Session>,
}

impl Played {
    pub(super) fn new(key: &FleetKey, id: ModuleId) -> Self {
        let (fleet, key, boot) = (key.fleet(), key.module(id), [1; 12]);
        let announcer = Announcer::new(fleet, id, &key, nonce(boot, 0));
        Self { id, fleet, key, boot, sessions: 0, announcer, session: None }
    }

    /// Another one with the same number, in a boot of its own.
    pub(super) fn twin(&self, first: u8) -> Self {
        let (id, fleet, key) = (self.id, self.fleet, self.key.clone());
        let mut boot = [1; 12];
        boot[0] = first;
        let announcer = Announcer::new(fleet, id, &key, nonce(boot, 0));
        Self { id, fleet, key, boot, sessions: 0, announcer, session: None }
    }

    pub(super) fn reboot(&mut self) {
        self.boot[0] += 1;
        (self.sessions, self.session) = (0, None);
        self.draw();
    }

    fn draw(&mut self) {
        self.announcer = Announcer::new(self.fleet, self.id, &self.key, nonce(self.boot, self.sessions));
    }

    fn hello(&self) -> Message {
        let session = self.session.as_ref().map_or(0, Session::id);
        Message::Hello(Hello { kind: ModuleKind::Modboat, firmware: (0, 2, 0), session })
    }

    pub(super) fn announce(&mut self) -> Vec<u8> {
        let (hello, mut buffer) = (self.hello(), [0; MAX_DATAGRAM]);
        self.announcer.seal(&hello, &mut buffer).expect("room").to_vec()
    }

    pub(super) fn say(&mut self, message: &Message) -> Vec<u8> {
        let mut buffer = [0; MAX_DATAGRAM];
        self.session.as_mut().expect("in a session").seal(message, &mut buffer).expect("room").to_vec()
    }

    /// Follows whatever host calls it.
    pub(super) fn handle_datagram(&mut self, datagram: &[u8]) -> Result<Opened, Class> {
        let frame = Frame::parse(datagram).map_err(|_| Class::Corrupt)?;
        let header = frame.header;
        if (header.fleet, header.module) != (self.fleet, self.id) || header.kind.is_for_host() {
            return Err(Class::Foreign);
        }
        if let Some(session) = self.session.as_mut().filter(|session| session.id() == header.session) {
            return session.open(&frame);
        }
        let host = header.nonce.ok_or(Class::Stale)?;
        let boot = nonce(self.boot, self.sessions);
        let mut session = Session::new(Side::Module, self.fleet, self.id, &self.key, &boot, host);
        if session.id() != header.session {
            return Err(Class::Stale);
        }
        let opened = session.open(&frame)?;
        self.session = Some(session);
        self.sessions += 1;
        self.draw();
        Ok(opened)
    }
}

fn nonce(boot: [u8; 12], session: u32) -> Nonce {
    let mut nonce = [0; 16];
    nonce[..12].copy_from_slice(&boot);
    nonce[12..].copy_from_slice(&session.to_le_bytes());
    Nonce(nonce)
}

/// A dispatcher and its modules; module k is at address `'a' + k`, and nothing is ever lost between them.
pub(super) struct Bench {
    pub(super) dispatcher: Dispatcher<char>,
    pub(super) modules: Vec<Played>,
    pub(super) now: FleetInstant,
}

impl Bench {
    /// Modules 1 … `count`, of whom the host has not heard.
    pub(super) fn new(count: u16) -> Self {
        let roster: Vec<ModuleId> = (1..=count).map(ModuleId).collect();
        let modules = roster.iter().map(|&id| Played::new(&KEY, id)).collect();
        Self { dispatcher: Dispatcher::new(&roster, &KEY, HOST), modules, now: FleetInstant(0) }
    }

    /// The same, all in sessions.
    pub(super) fn joined(count: u16) -> Self {
        let mut bench = Self::new(count);
        for index in 0..usize::from(count) {
            assert_eq!(bench.join(index), Some(DispatcherEvent::Joined(index)));
        }
        bench
    }

    /// Announcement, call, and the first word in the session.
    pub(super) fn join(&mut self, index: usize) -> Option<DispatcherEvent> {
        let announcement = self.modules[index].announce();
        assert_eq!(self.deliver(index, &announcement), Ok(None));
        assert_eq!(self.heard(), [(index, Message::Called)]);
        self.say(index, &health())
    }

    pub(super) fn link(&self, index: usize) -> &ModuleLink<char> {
        &self.dispatcher.modules()[index]
    }

    /// The host hears `datagram` from where module `index` is.
    pub(super) fn deliver(
        &mut self,
        index: usize,
        datagram: &[u8],
    ) -> Result<Option<DispatcherEvent>, Class> {
        self.dispatcher.handle_datagram(self.now, address(index), datagram)
    }

    /// Module `index` says something, and is heard.
    pub(super) fn say(&mut self, index: usize, message: &Message) -> Option<DispatcherEvent> {
        let datagram = self.modules[index].say(message);
        self.deliver(index, &datagram).expect("it is followed")
    }

    /// Everything the host has to send now, and where to.
    pub(super) fn sent(&mut self) -> Vec<(char, Vec<u8>)> {
        let mut buffer = [0; MAX_DATAGRAM];
        std::iter::from_fn(|| {
            let (to, datagram) = self.dispatcher.poll_transmit(self.now, &mut buffer)?;
            Some((to, datagram.to_vec()))
        })
        .collect()
    }

    /// The same, heard by its modules: who hears what.
    pub(super) fn heard(&mut self) -> Vec<(usize, Message)> {
        let sent = self.sent();
        let deliver = |(to, datagram): (char, Vec<u8>)| {
            let index = (0..self.modules.len()).find(|&index| address(index) == to).expect("of the fleet");
            (index, self.modules[index].handle_datagram(&datagram).expect("it opens").message)
        };
        sent.into_iter().map(deliver).collect()
    }

    /// Lets it be `us`: what the modules hear then.
    pub(super) fn at(&mut self, us: u64) -> Vec<(usize, Message)> {
        self.now = FleetInstant(us);
        self.dispatcher.handle_timer(self.now);
        self.heard()
    }

    /// Dispatches the same motion to every module.
    pub(super) fn dispatch(&mut self, number: u32, start: u64, motion: &Motion, delivery: Delivery) {
        let motions = vec![Some(motion.clone()); self.modules.len()];
        self.dispatcher.dispatch(self.now, number, FleetInstant(start), &motions, delivery);
    }
}

pub(super) fn address(index: usize) -> char {
    char::from(b'a' + u8::try_from(index).expect("few modules"))
}

/// Who hears something.
pub(super) fn who(heard: &[(usize, Message)]) -> Vec<usize> {
    heard.iter().map(|(index, _)| *index).collect()
}
