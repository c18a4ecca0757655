//! Emulated modules in lock step with their host: real datagrams over real UDP sockets, and one clock, which is a count of steps.
//!
//! ```text
//! host at t:   receive all that they sent before t → handle → send      modules: stand at t
//! step:        every module takes in what was sent to it, and runs to t + 1 ms
//! ```
//!
//! The clock stands still until all that was sent has come, either way, so the network takes no time but the step that a
//! datagram waits for.

use std::net::{SocketAddr, UdpSocket};
use std::time::Instant;

use link::identity::HostIdentity;
use protocol::time::{Duration, FleetInstant};
use protocol::{ModuleId, Radio};

use crate::emulator::PATIENCE;
use crate::provisioned;
use crate::stepped::{Stepped, Steps};

/// One step, which is the tick of a run as well.
pub const STEP: Duration = Duration(1_000);

/// 8 ns an instruction: 125 million a second, about a board's.
const SHIFT: u8 = 3;

/// In what the boards differ from the usual.
#[derive(Clone, Copy, Debug, Default)]
pub struct Board {
    /// As [`Steps::words`].
    pub words: &'static [&'static str],
    /// `[modboat.encoder]` of the modules' file; absolute where nothing is said.
    pub encoder: Option<&'static str>,
}

/// Emulated modules on UDP ports, in lock step with their host.
pub struct Modules {
    host: HostIdentity,
    port: u16,
    seed: u64,
    board: Board,
    boots: u64,
    /// A sender on the network that is not their host.
    stranger: UdpSocket,
    /// In the order of their ids, from 1; without those whose power is off.
    each: Vec<Option<Stepped>>,
    /// Datagrams of each that the host has had.
    came: Vec<u32>,
}

impl Modules {
    /// Modules 1 to `count` of `host`, whose socket has `port`.
    ///
    /// # Panics
    /// If one does not start.
    #[must_use]
    pub fn start(host: &HostIdentity, port: u16, count: usize, seed: u64, board: Board) -> Self {
        let stranger = UdpSocket::bind("127.0.0.1:0").expect("a free port");
        let each = (0..count).map(|_| None).collect();
        let mut modules =
            Self { host: host.clone(), port, seed, board, boots: 0, stranger, each, came: vec![0; count] };
        (0..count).for_each(|index| modules.boot(index));
        modules
    }

    /// Gives the module at `index` power: another boot, in another emulator.
    ///
    /// # Panics
    /// If it does not start.
    pub fn boot(&mut self, index: usize) {
        let configuration =
            provisioned::modboat_with(&self.host, ModuleId(index as u16 + 1), self.port, self.board.encoder);
        let seed = self.seed.wrapping_mul(1_000_003).wrapping_add(self.boots);
        let steps = Steps { length: STEP, shift: SHIFT, seed, words: self.board.words };
        self.boots += 1;
        self.came[index] = 0;
        self.each[index] = Some(Stepped::start(&provisioned::image(&configuration), self.port, steps));
    }

    /// Takes the power of the module at `index` away.
    pub fn kill(&mut self, index: usize) {
        self.each[index] = None;
    }

    /// The module at `index`.
    ///
    /// # Panics
    /// If it has no power.
    pub fn module(&mut self, index: usize) -> &mut Stepped {
        self.each[index].as_mut().expect("it has power")
    }

    /// Those that have power.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Stepped> {
        self.each.iter_mut().flatten()
    }

    /// One step of all of them.
    ///
    /// # Panics
    /// If one ends.
    pub fn step(&mut self) {
        self.iter_mut().for_each(Stepped::go);
        self.iter_mut().for_each(Stepped::stand);
    }

    /// A stranger sends a datagram to the module at `index`.
    ///
    /// # Panics
    /// If the socket fails.
    pub fn disturb(&mut self, index: usize, datagram: &[u8]) {
        let Self { stranger, each, .. } = self;
        let module = each[index].as_mut().expect("it has power");
        // An empty one is a datagram as well.
        stranger.send_to(datagram, module.address).expect("a socket");
        module.put();
    }

    /// The host sends over `radio`.
    ///
    /// # Errors
    /// The radio's.
    pub fn send<R: Radio<Address = SocketAddr>>(
        &mut self,
        radio: &mut R,
        now: FleetInstant,
        to: SocketAddr,
        datagram: &[u8],
    ) -> Result<(), R::Error> {
        if let Some(module) = self.iter_mut().find(|module| module.address == to) {
            module.put();
        }
        radio.send(now, to, datagram)
    }

    /// What has come to the host's `radio`; `None` when all has that the modules sent.
    ///
    /// # Errors
    /// The radio's.
    ///
    /// # Panics
    /// If something never comes.
    pub fn receive<R: Radio<Address = SocketAddr>>(
        &mut self,
        radio: &mut R,
        now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, SocketAddr)>, R::Error> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some((length, from)) = radio.receive(now, buffer)? {
                for (module, came) in self.each.iter().zip(&mut self.came) {
                    *came += u32::from(module.as_ref().is_some_and(|module| module.address == from));
                }
                return Ok(Some((length, from)));
            }
            let all = self.each.iter().zip(&self.came);
            let mut present = all.filter_map(|(module, came)| Some((module.as_ref()?.sent(), *came)));
            if present.all(|(sent, came)| came >= sent) {
                return Ok(None);
            }
            assert!(Instant::now() < deadline, "a datagram was lost on the loopback: {:?} came", self.came);
            std::thread::sleep(std::time::Duration::from_micros(20));
        }
    }

    /// What they have printed, for a message.
    pub fn lines(&mut self) -> String {
        let lines: Vec<String> =
            self.iter_mut().flat_map(|module| module.emulator.lines().to_vec()).collect();
        lines.join("\n")
    }
}
