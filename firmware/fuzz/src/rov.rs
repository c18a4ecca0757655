//! Fuzz input: bytes as events of an ROV of two thrusters: noise, genuine messages of any content, leases, replays, ticks, outputs that fail.
//!
//! | byte | then | what happens |
//! |---|---|---|
//! | 0 | length, bytes | the bytes come as a datagram |
//! | 1 | length, bytes | the host seals the message of which they are the postcard; it comes |
//! | 2 | index | a datagram that was sealed earlier comes again |
//! | 3 | 3 | thrusts that fit, and the length of their lease |
//! | 4 | ticks | so many, of 5 ms |
//! | 5 | 1 | hold, stop or release |
//! | 6 | 1 | an output fails, or works again |
//! | 7 | 1 | the host stops answering clocks, or goes on |
//!
//! Held against what may never be: a pulse out of range, thrust outside a lease or while it is stopped or arms, a datagram that is let in
//! twice, sums that are not exact, a report that its host cannot open.

use std::cell::Cell;
use std::collections::HashSet;
use std::rc::Rc;

use embedded_hal::pwm::{ErrorKind, ErrorType, SetDutyCycle};
use firmware::link::endpoint::Endpoint;
use firmware::link::session::Identity;
use firmware::module::{Module, Supply};
use firmware::rov::Rov;
use firmware::rov::lease::{SURE_WITHIN, ThrustLease};
use firmware::rov::thruster::bank::Bank;
use protocol::configuration::{BankConstants, LeaseLimits, ThrusterMounting};
use protocol::session::open_announcement;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::{Amperes, Newtons, Volts};
use protocol::{
    Connectors, Cycle, Delivery, FleetKey, Frame, Kind, MAX_DATAGRAM, Message, ModuleId, ModuleState, Motion,
    Nonce, RovCycle, Session, Side, TimeReply,
};

const MODULE: ModuleId = ModuleId(2);
const AHEAD: u64 = 1_000_000;
const TICK: u64 = 5_000;
/// 25 counts a microsecond at 400 Hz.
const DUTY_MAX: u16 = 62_500;
const NEUTRAL: u16 = 37_500;
const BYTES_MAX: usize = 1 << 12;
const TICKS_MAX: u32 = 4_000;

/// What a run met, so that a test can see that the runs go somewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Met {
    /// Ticks with thrust.
    pub thrust: u32,
    /// Ticks in which it was stopped.
    pub stopped: u32,
}

#[derive(Debug)]
pub struct Broken;

impl embedded_hal::pwm::Error for Broken {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// A pin and whether it fails.
#[derive(Clone, Default)]
pub struct Pin(Rc<Cell<u16>>, Rc<Cell<bool>>);

impl ErrorType for Pin {
    type Error = Broken;
}

impl SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        DUTY_MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Broken> {
        if self.1.get() {
            return Err(Broken);
        }
        self.0.set(duty);
        Ok(())
    }
}

struct World {
    rov: Rov<Pin>,
    pins: [Pin; 2],
    now: u64,
    answers: bool,
    calls: u32,
    session: Option<Session>,
    recorded: Vec<Vec<u8>>,
    let_in: HashSet<Vec<u8>>,
    number: u32,
    ticked: u32,
    met: Met,
}

impl World {
    fn new() -> Self {
        // One that fails from the first tick on puts out nothing else.
        let pins = [NEUTRAL; 2].map(|duty| Pin(Rc::new(Cell::new(duty)), Rc::default()));
        let mountings = [0, 1].map(|output| ThrusterMounting { output, reversed: output == 1 });
        let constants = BankConstants { arming: Duration(500_000), ..BankConstants::default() };
        let bank = Bank::new(pins.iter().cloned(), &mountings, constants).expect("a bank");
        let key = FleetKey::new([0x42; 32]);
        let identity = Identity {
            module: MODULE,
            fleet: key.fleet(),
            key: key.module(MODULE),
            boot: [0xB0; 12],
            report_every: Duration(20_000),
            sure_within: SURE_WITHIN,
        };
        let rov = Rov::new(Endpoint::new(Some(identity), ThrustLease::new(2, LeaseLimits::default())), bank);
        Self {
            rov,
            pins,
            now: 0,
            answers: true,
            calls: 0,
            session: None,
            recorded: Vec::new(),
            let_in: HashSet::new(),
            number: 0,
            ticked: 0,
            met: Met::default(),
        }
    }

    fn bring(&mut self, datagram: &[u8]) {
        let heard = self.rov.handle_datagram(LocalInstant(self.now), datagram);
        let incoming = *self.rov.endpoint().link().expect("it is provisioned").incoming();
        assert!(incoming.is_exact(), "{incoming:?}");
        assert!(heard.is_err() || self.let_in.insert(datagram.to_vec()), "let in twice");
    }

    fn say(&mut self, message: &Message) {
        let sealed = self
            .session
            .as_mut()
            .and_then(|session| Some(session.seal(message, &mut [0; MAX_DATAGRAM]).ok()?.to_vec()));
        if let Some(datagram) = sealed {
            self.recorded.push(datagram.clone());
            self.bring(&datagram);
        }
    }

    fn tick(&mut self) {
        let now = LocalInstant(self.now);
        let supply = Supply { battery: Volts(16.0), current: Amperes(1.0) };
        let fails = self.pins.iter().any(|pin| pin.1.get());
        // As the tick finds it: what that decides, the next one puts out.
        let (state, leased) = (self.rov.endpoint().state(now), self.rov.endpoint().running(now).is_some());
        assert_eq!(self.rov.tick(now, &supply).is_err(), fails);
        let duties = self.pins.each_ref().map(|pin| pin.0.get());
        for (duty, pin) in duties.into_iter().zip(&self.pins) {
            assert!((27_500..=47_500).contains(&duty), "{duty} counts at {now:?}");
            // What fails puts out what it did before.
            let thrust = duty != NEUTRAL && !pin.1.get();
            assert!(!thrust || leased, "thrust without a lease at {now:?}");
            let may =
                !matches!(state, ModuleState::Stopped | ModuleState::Boot) && self.rov.bank().is_armed();
            assert!(!thrust || may, "thrust while {state:?}");
            self.met.thrust += u32::from(thrust);
        }
        self.met.stopped += u32::from(state == ModuleState::Stopped);
        self.listen();
        self.now += TICK;
        self.ticked += 1;
    }

    fn listen(&mut self) {
        let mut buffer = [0; MAX_DATAGRAM];
        let key = FleetKey::new([0x42; 32]).module(MODULE);
        while let Some(said) = self.rov.poll_transmit(&mut buffer) {
            let frame = Frame::parse(said).expect("a datagram");
            if frame.header.kind == Kind::Announce {
                let Ok(Message::Hello(hello)) = open_announcement(&key, &frame) else { panic!("no hello") };
                let boot = frame.header.nonce.expect("it has one");
                if hello.session == 0 {
                    self.call(boot);
                }
                continue;
            }
            let Some(session) = &mut self.session else { continue };
            let opened = session.open(&frame).expect("its host opens it");
            if let (Message::TimeRequest(request), true) = (opened.message, self.answers) {
                let fleet = FleetInstant(self.now + AHEAD);
                let reply = TimeReply { request_sent: request.sent, received: fleet, sent: fleet };
                self.say(&Message::TimeReply(reply));
            }
        }
    }

    fn call(&mut self, boot: Nonce) {
        let fleet = FleetKey::new([0x42; 32]);
        let mut nonce = [7; 16];
        nonce[12..].copy_from_slice(&self.calls.to_le_bytes());
        self.calls += 1;
        let mut session =
            Session::new(Side::Host, fleet.fleet(), MODULE, &fleet.module(MODULE), &boot, Nonce(nonce));
        let call = session.seal_call(&mut [0; MAX_DATAGRAM]).expect("fits").to_vec();
        self.session = Some(session);
        self.bring(&call);
    }
}

/// Plays it all.
pub fn run(bytes: &[u8]) -> Met {
    let mut bytes = bytes[..bytes.len().min(BYTES_MAX)].iter().copied();
    let mut world = World::new();
    // The first byte says whether it begins in a session, and armed.
    if bytes.next().is_some_and(|byte| byte % 4 != 0) {
        (0..200).for_each(|_| world.tick());
        assert_eq!(world.rov.endpoint().state(LocalInstant(world.now)), ModuleState::Ready);
    }
    while world.ticked < TICKS_MAX && step(&mut world, &mut bytes).is_some() {}
    world.met
}

fn step(world: &mut World, bytes: &mut impl Iterator<Item = u8>) -> Option<()> {
    match bytes.next()? % 8 {
        kind @ (0 | 1) => {
            let length = usize::from(bytes.next()?);
            let taken: Vec<u8> = bytes.by_ref().take(length).collect();
            if kind == 0 {
                world.bring(&taken);
            } else if let Ok((message, _)) = postcard::take_from_bytes::<Message>(&taken) {
                // Another fleet time is a lie that this world's lease cannot be held against.
                if !matches!(message, Message::TimeReply(_)) {
                    world.say(&message);
                }
            }
        }
        2 => {
            let index = usize::from(bytes.next()?);
            if !world.recorded.is_empty() {
                let datagram = world.recorded[index % world.recorded.len()].clone();
                world.bring(&datagram);
            }
        }
        3 => {
            let [a, b, lease] = [bytes.next()?, bytes.next()?, bytes.next()?];
            world.number += 1;
            let thrusts = [a, b].map(|byte| Newtons((f32::from(byte) - 128.0) / 4.0)).into_iter().collect();
            let motion = Motion::Rov(RovCycle {
                thrusts,
                lease: Duration(u32::from(lease) * 5_000),
                connectors: Connectors::Closed,
            });
            let start = FleetInstant(world.now + AHEAD + u64::from(a) * 500);
            world.say(&Message::Cycle(Cycle {
                number: world.number,
                start,
                motion,
                delivery: Delivery::Direct,
            }));
        }
        4 => (0..bytes.next()?).for_each(|_| world.tick()),
        5 => match bytes.next()? % 3 {
            0 => world.say(&Message::Hold),
            1 => world.say(&Message::EmergencyStop),
            _ => world.say(&Message::Release),
        },
        6 => {
            let byte = bytes.next()?;
            world.pins[usize::from(byte % 2)].1.set(byte / 2 % 2 == 0);
        }
        _ => world.answers = bytes.next()? % 2 == 0,
    }
    Some(())
}
