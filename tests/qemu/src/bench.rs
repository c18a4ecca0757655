//! A host on a bench: the real dispatcher on a real UDP socket, in lock step with as many emulated modules as are asked for.

use std::net::SocketAddr;

use link::dispatcher::{Dispatcher, DispatcherEvent};
use link::identity::HostIdentity;
use link::udp::UdpRadio;
use protocol::time::{Duration, FleetInstant};
use protocol::{Delivery, Frame, Kind, MAX_DATAGRAM, ModuleId, ModuleState, Motion, Nonce, Telemetry};

use crate::modules::{Board, Modules, STEP};

/// How long the bench waits for what must come, by the modules' clock.
const PATIENCE: Duration = Duration(60_000_000);

/// Fleet time must be known so well before the first cycle, as for `flotilla run`.
const SURE: Duration = Duration(1_500);

/// One report of a module.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// When it came, by the host's clock.
    pub arrival: FleetInstant,
    /// What it says.
    pub telemetry: Telemetry,
}

/// A host with its dispatcher and socket, in lock step with emulated modules.
pub struct Bench {
    /// Their host.
    pub dispatcher: Dispatcher<SocketAddr>,
    /// The modules.
    pub modules: Modules,
    /// The reports of each that it sent with a known fleet time, in the order in which they came.
    pub seen: Vec<Vec<Seen>>,
    /// The boot nonce of the newest announcement.
    pub announced: Option<Nonce>,
    radio: UdpRadio,
    now: FleetInstant,
}

impl Bench {
    /// With modules 1 to `count`, and keys from `seed`.
    ///
    /// # Panics
    /// If there is no free port or no emulator.
    #[must_use]
    pub fn start(count: u16, seed: u64) -> Self {
        Self::start_on(count, seed, Board::default())
    }

    /// The same on such boards.
    ///
    /// # Panics
    /// As [`start`](Self::start).
    #[must_use]
    pub fn start_on(count: u16, seed: u64, board: Board) -> Self {
        let host = HostIdentity::simulated(seed, 0);
        let radio = UdpRadio::bind("127.0.0.1:0").expect("a free port");
        let port = radio.local_address().expect("bound").port();
        let roster: Vec<ModuleId> = (1..=count).map(ModuleId).collect();
        let dispatcher = Dispatcher::new(&roster, &host.key, host.boot);
        let modules = Modules::start(&host, port, roster.len(), seed, board);
        let seen = roster.iter().map(|_| Vec::new()).collect();
        Self { dispatcher, modules, seen, announced: None, radio, now: FleetInstant(0) }
    }

    /// The host's clock, which is the fleet's: steps of the modules.
    #[must_use]
    pub fn now(&self) -> FleetInstant {
        self.now
    }

    /// One step: what came, what is due, what is to be sent. What came meant this.
    ///
    /// # Panics
    /// If the socket fails.
    pub fn turn(&mut self) -> Vec<DispatcherEvent> {
        self.modules.step();
        self.now = self.now.after(STEP);
        let (now, mut events, mut buffer) = (self.now, Vec::new(), [0; MAX_DATAGRAM]);
        while let Some((length, from)) =
            self.modules.receive(&mut self.radio, now, &mut buffer).expect("a socket")
        {
            let announced = Frame::parse(&buffer[..length]).ok().map(|frame| frame.header);
            if let Some(header) = announced.filter(|header| header.kind == Kind::Announce) {
                self.announced = header.nonce;
            }
            // What is not to be followed is counted there.
            let Ok(Some(event)) = self.dispatcher.handle_datagram(now, from, &buffer[..length]) else {
                continue;
            };
            if let DispatcherEvent::Reported(index) = event {
                self.keep(index);
            }
            events.push(event);
        }
        self.dispatcher.handle_timer(now);
        while let Some((to, datagram)) = self.dispatcher.poll_transmit(now, &mut buffer) {
            self.modules.send(&mut self.radio, now, to, datagram).expect("a socket");
        }
        events
    }

    fn keep(&mut self, index: usize) {
        let link = &self.dispatcher.modules()[index];
        let Some(&telemetry) = link.telemetry() else { return };
        if !matches!(telemetry.state, ModuleState::Boot | ModuleState::Unsynchronised) {
            self.seen[index].push(Seen { arrival: link.heard(), telemetry });
        }
    }

    /// Goes on until `is` so; everything that came meanwhile.
    ///
    /// # Panics
    /// If it does not come within a minute.
    pub fn until(
        &mut self,
        what: &str,
        mut is: impl FnMut(&Self, &[DispatcherEvent]) -> bool,
    ) -> Vec<DispatcherEvent> {
        let (deadline, mut all) = (self.now.after(PATIENCE), Vec::new());
        loop {
            let events = self.turn();
            let done = is(self, &events);
            all.extend(events);
            if done {
                return all;
            }
            assert!(self.now < deadline, "no {what}; the modules said:\n{}", self.modules.lines());
        }
    }

    /// Waits until every module knows where it is and what time it is, well enough to begin.
    pub fn until_ready(&mut self) {
        self.until("ready modules", |bench, _| {
            bench.dispatcher.modules().iter().all(|link| {
                let sure = link.health().is_some_and(|health| health.uncertainty <= SURE);
                sure && matches!(link.state(), Some(ModuleState::Ready | ModuleState::Holding))
            })
        });
    }

    /// Dispatches one cycle to all of them.
    pub fn dispatch(&mut self, number: u32, start: FleetInstant, motions: &[Motion]) {
        let motions: Vec<Option<Motion>> = motions.iter().cloned().map(Some).collect();
        self.dispatcher.dispatch(self.now, number, start, &motions, Delivery::Direct);
    }
}
