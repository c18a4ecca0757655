//! A Modboat and its host under fuzzing, and the invariants that are checked.

use std::collections::HashSet;

use firmware::link::endpoint::{Endpoint, Robot};
use firmware::link::session::{Identity, SURE_WITHIN};
use firmware::modboat::Modboat;
use firmware::modboat::reference::{Reference, wrap};
use firmware::modboat::robot::ModboatRobot;
use firmware::modboat::schedule::POSE_TOLERANCE;
use firmware::modboat::servo::NoSense;
use firmware::module::{Module, Supply};
use protocol::configuration::TailLimits;
use protocol::ledger::Class;
use protocol::session::open_announcement;
use protocol::time::{Duration, FleetInstant, LocalInstant};
use protocol::units::{Radians, Volts};
use protocol::{
    Cycle, Delivery, FleetKey, Frame, Kind, MAX_DATAGRAM, Message, ModboatCycle, ModuleId, ModuleState,
    Motion, Nonce, Session, Side, TimeReply, TransitionLaw,
};

use super::Met;
use super::board::{Board, BoardTail, Eye, Pin, Pwm};

const MODULE: ModuleId = ModuleId(9);
/// Fleet time less the module's own.
const AHEAD: u64 = 5_000_000;
/// Between two ticks farther apart the reference may be anywhere.
const FOLLOWED_US: u64 = 100_000;

pub struct World {
    boat: Modboat<Eye, NoSense, Pwm, Pin, Pin>,
    pub board: Board,
    pub battery: Volts,
    pub answers: bool,
    now: u64,
    /// Of the host and of the module.
    lives: (u32, u32),
    calls: u32,
    session: Option<Session>,
    /// All that was ever sealed.
    pub recorded: Vec<Vec<u8>>,
    /// Those that say release.
    releases: HashSet<Vec<u8>>,
    let_in: HashSet<Vec<u8>>,
    /// Numbers of the cycles that were sealed.
    sealed: HashSet<u32>,
    number: u32,
    /// The host has told the module no other time than the right one.
    honest: bool,
    /// A release has been let in since the last tick.
    released: bool,
    last: Option<(u64, ModuleState, Option<u32>, Reference)>,
    pub ticked: u32,
    pub met: Met,
}

fn key() -> FleetKey {
    FleetKey::new([0x42; 32])
}

fn boat(board: &Board, life: u32) -> Modboat<Eye, NoSense, Pwm, Pin, Pin> {
    let key = key();
    let identity = Identity {
        module: MODULE,
        fleet: key.fleet(),
        key: key.module(MODULE),
        boot: std::array::from_fn(|k| if k < 4 { life.to_le_bytes()[k] } else { 0xB0 }),
        report_every: Duration(20_000),
        sure_within: SURE_WITHIN,
    };
    let tail: BoardTail = board.tail();
    Modboat::new(Endpoint::new(Some(identity), ModboatRobot::new(TailLimits::default())), tail)
}

impl World {
    pub fn new() -> Self {
        let board = Board::default();
        Self {
            boat: boat(&board, 0),
            board,
            battery: Volts(7.4),
            answers: true,
            now: 0,
            lives: (0, 0),
            calls: 0,
            session: None,
            recorded: Vec::new(),
            releases: HashSet::new(),
            let_in: HashSet::new(),
            sealed: HashSet::new(),
            number: 0,
            honest: true,
            released: false,
            last: None,
            ticked: 0,
            met: Met::default(),
        }
    }

    pub fn state(&self) -> ModuleState {
        self.boat.endpoint().state(LocalInstant(self.now))
    }

    /// Brings a datagram. Nothing is let in twice, and the ledger stays exact.
    pub fn bring(&mut self, datagram: &[u8]) -> Result<(), Class> {
        let heard = self.boat.handle_datagram(LocalInstant(self.now), datagram);
        let link = self.boat.endpoint().link().expect("it is provisioned");
        assert!(link.incoming().is_exact(), "{:?}", link.incoming());
        if heard.is_ok() {
            assert!(self.let_in.insert(datagram.to_vec()), "let in twice");
            self.met.accepted += 1;
            self.released |= self.releases.contains(datagram);
        } else {
            self.met.rejected += 1;
        }
        heard
    }

    /// What the host says, if it is in a session.
    pub fn seal(&mut self, message: &Message) -> Option<Vec<u8>> {
        let datagram = self.session.as_mut()?.seal(message, &mut [0; MAX_DATAGRAM]).ok()?.to_vec();
        match message {
            Message::Cycle(cycle) => drop(self.sealed.insert(cycle.number)),
            Message::Release => drop(self.releases.insert(datagram.clone())),
            Message::TimeReply(_) => self.honest = false,
            _ => {}
        }
        self.recorded.push(datagram.clone());
        Some(datagram)
    }

    pub fn command(&self, byte: u8) -> Message {
        match byte % 4 {
            0 => Message::Hold,
            1 => Message::EmergencyStop,
            2 => Message::Release,
            _ => Message::Commit(self.number),
        }
    }

    /// A cycle that sets out from where the reference is, most of the time within the limits.
    pub fn cycle(&mut self, start: u8, amplitude: u8, rotation: u8, delivery: u8) -> Message {
        let law = match delivery >> 1 {
            0 => TransitionLaw::ConstantSpeed,
            // Up to somewhat more than half of the transition.
            ramp => TransitionLaw::RestToRest { ramp: Duration(u32::from(ramp) * 2_500) },
        };
        self.number += 1;
        let angle = self.boat.endpoint().reference(LocalInstant(self.now)).map_or(0.0, |at| at.angle_rad);
        let size = 0.9 + f32::from(amplitude >> 1) / 70.0;
        let amplitude = if amplitude.is_multiple_of(2) { size } else { -size };
        let rotation = (f32::from(rotation) - 128.0) / 40.0;
        let motion = Motion::Modboat(ModboatCycle {
            rotation: Radians(rotation),
            centerline: Radians(angle + rotation - amplitude),
            amplitude: Radians(amplitude),
            transition: Duration(500_000),
            period: Duration(1_500_000),
            law,
        });
        let delivery = if delivery.is_multiple_of(2) { Delivery::Direct } else { Delivery::Prepare };
        let start = FleetInstant(self.now + AHEAD + u64::from(start) * 2_000);
        Message::Cycle(Cycle { number: self.number, start, motion, delivery })
    }

    pub fn ticks(&mut self, count: u32) {
        for _ in 0..count {
            self.tick();
        }
    }

    fn tick(&mut self) {
        let (now, may_drive) = (LocalInstant(self.now), self.boat.endpoint().failsafe().may_drive());
        let was_stopped = self.boat.endpoint().failsafe().state() == ModuleState::Stopped;
        let supply = Supply { battery: self.battery, ..Supply::default() };
        self.boat.tick(now, &supply).expect("these pins cannot fail");
        assert!(may_drive || self.board.drive() == 0.0, "drives though it may not");
        let endpoint = self.boat.endpoint();
        let state = endpoint.failsafe().state();
        assert!(!was_stopped || self.released || state == ModuleState::Stopped, "a stop is latched");
        if let Some(reference) = endpoint.reference(now) {
            assert!(reference.is_finite(), "{reference:?}");
            let running = endpoint.clock().fleet(now).and_then(|fleet| endpoint.robot().running(fleet));
            assert!(
                running.is_none_or(|number| self.sealed.contains(&number)),
                "runs a cycle that was not sent"
            );
            self.look(now.0, state, running, reference);
        }
        self.released = false;
        self.met.executing += u32::from(state == ModuleState::Executing);
        self.met.stopped += u32::from(state == ModuleState::Stopped);
        self.listen();
        self.board.step_ms();
        self.now += 1_000;
        self.ticked += 1;
    }

    /// The reference steps no faster than the limits allow, but where a stop lets go of it.
    fn look(&mut self, now: u64, state: ModuleState, running: Option<u32>, reference: Reference) {
        let last = self.last.replace((now, state, running, reference));
        let Some((then, before, ran, last)) = last else { return };
        let lets_go = |state| matches!(state, ModuleState::Stopped | ModuleState::Boot);
        if !self.honest || now - then > FOLLOWED_US || self.released || lets_go(state) || lets_go(before) {
            return;
        }
        let step_rad = wrap(reference.angle_rad - last.angle_rad).abs();
        let seconds = (now - then) as f32 * 1e-6;
        let joint_rad = if ran == running { 0.0 } else { POSE_TOLERANCE.0 };
        let allowed_rad = TailLimits::default().speed_max.0 * seconds * 1.001 + 1e-3 + joint_rad;
        assert!(step_rad <= allowed_rad, "{step_rad} rad in {seconds} s at {now} µs, {state:?}");
    }

    /// The host hears it out: calls it, answers its clock exchanges.
    fn listen(&mut self) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some(datagram) = self.boat.poll_transmit(&mut buffer) {
            let frame = Frame::parse(datagram).expect("the module makes datagrams");
            if frame.header.kind == Kind::Announce {
                let hello = open_announcement(&key().module(MODULE), &frame).expect("its own key");
                let Message::Hello(hello) = hello else { panic!("announced {hello:?}") };
                let served = self.session.as_ref().is_some_and(|session| session.id() == hello.session);
                if self.answers && !served {
                    self.call(frame.header.nonce.expect("announcements have one"));
                }
                continue;
            }
            let Some(Ok(opened)) = self.session.as_mut().map(|session| session.open(&frame)) else {
                continue;
            };
            if let Message::TimeRequest(request) = opened.message
                && self.answers
            {
                let fleet = FleetInstant(self.now + AHEAD);
                let reply = TimeReply { request_sent: request.sent, received: fleet, sent: fleet };
                let honest = self.honest;
                if let Some(reply) = self.seal(&Message::TimeReply(reply)) {
                    self.honest = honest;
                    let _ = self.bring(&reply);
                }
            }
        }
        let outgoing = self.boat.endpoint().link().expect("it is provisioned").outgoing();
        let known = outgoing.acknowledged + outgoing.late + outgoing.lost + outgoing.under_way();
        assert_eq!(outgoing.sent, known, "{outgoing:?}");
    }

    fn call(&mut self, boot: Nonce) {
        let (key, mut nonce) = (key(), [0xA0; 16]);
        nonce[..4].copy_from_slice(&self.lives.0.to_le_bytes());
        nonce[12..].copy_from_slice(&self.calls.to_le_bytes());
        self.calls += 1;
        let module = key.module(MODULE);
        let mut session = Session::new(Side::Host, key.fleet(), MODULE, &module, &boot, Nonce(nonce));
        let call = session.seal_call(&mut [0; MAX_DATAGRAM]).expect("the first of its session").to_vec();
        self.recorded.push(call.clone());
        let hears = self.boat.endpoint().link().is_some_and(|link| link.hears_host(LocalInstant(self.now)));
        let taken = self.bring(&call);
        assert!(taken.is_err() || !hears, "a host is heard, and another one was let in");
        // A host that is not let in keeps its words for itself; they are sealed all the same.
        if taken.is_ok() || self.session.is_none() {
            self.session = Some(session);
        }
    }

    /// The host is gone, another one begins.
    pub fn other_host(&mut self) {
        self.lives.0 += 1;
        self.session = None;
    }

    /// The module loses its power.
    pub fn reboot(&mut self) {
        self.lives.1 += 1;
        self.boat = boat(&self.board, self.lives.1);
        self.last = None;
        self.released = true;
    }

    /// Time passes without a tick.
    pub fn miss(&mut self, us: u64) {
        self.now += us;
    }
}
