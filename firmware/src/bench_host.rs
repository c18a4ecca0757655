//! A host on a bench, for the tests of this crate: it serves one module, over a way that takes no time and loses nothing.

use std::vec::Vec;

use protocol::ledger::{Class, Incoming, Outgoing};
use protocol::session::open_announcement;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::{
    FleetKey, Frame, Kind, MAX_DATAGRAM, Message, ModuleId, Nonce, Session, Side, TimeReply, Verdict,
};

use crate::link::endpoint::{Endpoint, Robot};
use crate::link::session::{Identity, SURE_WITHIN};
use crate::module::Module;

/// The module on the bench.
pub const MODULE: ModuleId = ModuleId(2);
/// Fleet time less the module's own.
pub const AHEAD: u64 = 1_000_000;

pub fn fleet_key() -> FleetKey {
    FleetKey::new([0x42; 32])
}

/// The module's, of the boot that `boot` names.
pub fn identity(boot: u8) -> Identity {
    let key = fleet_key();
    Identity {
        module: MODULE,
        fleet: key.fleet(),
        key: key.module(MODULE),
        boot: [boot; 12],
        report_every: Duration(20_000),
        sure_within: SURE_WITHIN,
    }
}

/// What the bench host talks to: an endpoint alone or a whole module.
pub trait Counterpart {
    fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class>;
    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]>;
    fn incoming(&self) -> Incoming;
    fn outgoing(&self) -> Outgoing;
}

impl<R: Robot> Counterpart for Endpoint<R> {
    fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class> {
        self.handle_datagram(now, datagram)
    }

    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        self.poll_transmit(buffer)
    }

    fn incoming(&self) -> Incoming {
        *self.link().unwrap().incoming()
    }

    fn outgoing(&self) -> Outgoing {
        self.link().unwrap().outgoing()
    }
}

impl<M: Module> Counterpart for M {
    fn handle_datagram(&mut self, now: LocalInstant, datagram: &[u8]) -> Result<(), Class> {
        Module::handle_datagram(self, now, datagram)
    }

    fn poll_transmit<'a>(&mut self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        Module::poll_transmit(self, buffer)
    }

    fn incoming(&self) -> Incoming {
        self.endpoint().incoming()
    }

    fn outgoing(&self) -> Outgoing {
        self.endpoint().outgoing()
    }
}

/// The sums of both ledgers of a module.
pub fn assert_exact(module: &impl Counterpart) {
    let (incoming, outgoing) = (module.incoming(), module.outgoing());
    assert!(incoming.is_exact(), "{incoming:?}");
    let Outgoing { sent, acknowledged, late, lost } = outgoing;
    assert_eq!(sent, acknowledged + late + lost + outgoing.under_way(), "{outgoing:?}");
}

/// A host that serves one module in tests.
pub struct BenchHost {
    boot: u8,
    calls: u32,
    session: Option<Session>,
    /// Told instead of the right time.
    pub error_us: i64,
    /// While false it leaves clock exchanges unanswered.
    pub tells_time: bool,
    /// Everything it ever sent.
    pub recorded: Vec<Vec<u8>>,
}

impl BenchHost {
    /// Of the boot that `boot` names.
    pub fn new(boot: u8) -> Self {
        Self { boot, calls: 0, session: None, error_us: 0, tells_time: true, recorded: Vec::new() }
    }

    /// Its session, once it has called.
    pub fn session(&self) -> &Session {
        self.session.as_ref().unwrap()
    }

    /// A copy that knows its keys and all it has sent, of a boot of its own.
    pub fn clone_as(&self, boot: u8) -> Self {
        Self { recorded: self.recorded.clone(), ..Self::new(boot) }
    }

    /// The next datagram of the session.
    pub fn seal(&mut self, message: &Message) -> Vec<u8> {
        let mut buffer = [0; MAX_DATAGRAM];
        let datagram = self.session.as_mut().unwrap().seal(message, &mut buffer).unwrap().to_vec();
        self.recorded.push(datagram.clone());
        datagram
    }

    /// Its answer to an announcement: a session of its own.
    pub fn call(&mut self, announcement: &[u8]) -> Vec<u8> {
        let key = fleet_key();
        let boot = Frame::parse(announcement).unwrap().header.nonce.unwrap();
        let mut nonce = [self.boot; 16];
        nonce[12..].copy_from_slice(&self.calls.to_le_bytes());
        self.calls += 1;
        let module = key.module(MODULE);
        let mut session = Session::new(Side::Host, key.fleet(), MODULE, &module, &boot, Nonce(nonce));
        let call = session.seal_call(&mut [0; MAX_DATAGRAM]).unwrap().to_vec();
        self.session = Some(session);
        self.recorded.push(call.clone());
        call
    }

    /// Takes in what the module sends at `now`, its own clock; calls it, and tells it the time. All else comes back.
    pub fn listen(&mut self, now: LocalInstant, module: &mut impl Counterpart) -> Vec<Message> {
        let (mut said, mut buffer) = (Vec::new(), [0; MAX_DATAGRAM]);
        while let Some(datagram) = module.poll_transmit(&mut buffer) {
            let frame = Frame::parse(datagram).unwrap();
            if frame.header.kind == Kind::Announce {
                let hello = open_announcement(&fleet_key().module(MODULE), &frame).unwrap();
                let Message::Hello(hello) = hello else { panic!("{hello:?}") };
                if hello.session == 0 {
                    let call = self.call(datagram);
                    let _ = module.handle_datagram(now, &call);
                }
                said.push(Message::Hello(hello));
                continue;
            }
            // Of a session that is over, or another host's.
            let Some(Ok(opened)) = self.session.as_mut().map(|session| session.open(&frame)) else {
                continue;
            };
            match opened.message {
                Message::TimeRequest(request) if self.tells_time => {
                    let fleet = FleetInstant((now.0 + AHEAD).saturating_add_signed(self.error_us));
                    let reply = TimeReply { request_sent: request.sent, received: fleet, sent: fleet };
                    let reply = self.seal(&Message::TimeReply(reply));
                    let _ = module.handle_datagram(now, &reply);
                }
                other => said.push(other),
            }
        }
        assert_exact(module);
        said
    }

    /// Says it, and everything that the module says then.
    pub fn say(
        &mut self,
        now: LocalInstant,
        module: &mut impl Counterpart,
        message: &Message,
    ) -> Vec<Message> {
        let datagram = self.seal(message);
        assert_eq!(module.handle_datagram(now, &datagram), Ok(()));
        self.listen(now, module)
    }

    /// Says a cycle or a commit, and what the module decides.
    pub fn ask(&mut self, now: LocalInstant, module: &mut impl Counterpart, message: &Message) -> Verdict {
        let number = match message {
            Message::Cycle(cycle) => cycle.number,
            Message::Commit(number) => *number,
            other => panic!("{other:?} is not acknowledged"),
        };
        let said = self.say(now, module, message);
        let mut verdicts = said.iter().filter_map(|message| match message {
            Message::Acknowledge(answer) if answer.cycle == number => Some(answer.verdict),
            _ => None,
        });
        let verdict = verdicts.next().unwrap_or_else(|| panic!("no verdict in {said:?}"));
        assert_eq!(verdicts.next(), None);
        verdict
    }
}

/// The datagram with another number of session, under a right checksum.
pub fn in_session(datagram: &[u8], session: u32) -> Vec<u8> {
    let mut other = datagram[..datagram.len() - 4].to_vec();
    other[8..12].copy_from_slice(&session.to_le_bytes());
    // CRC-32, ISO-HDLC.
    let crc = other.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    });
    other.extend((!crc).to_le_bytes());
    other
}
