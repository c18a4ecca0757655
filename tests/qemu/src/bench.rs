//! A host on a bench: the real dispatcher on a real UDP socket, in real time, for as many emulated modules as are asked for.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use host::link::dispatcher::{Dispatcher, Event};
use host::link::identity::HostIdentity;
use host::link::udp::UdpRadio;
use protocol::units::{Micros, MicrosSpan};
use protocol::{Delivery, MAX_DATAGRAM, ModuleId, ModuleState, Motion, Radio, Telemetry};

use crate::emulator::{Emulator, Setup, free_port, priority};
use crate::provisioned;

/// How long the bench waits for what must come.
const PATIENCE: Duration = Duration::from_secs(60);

/// Fleet time must be known so well before the first cycle, as for `flotilla run`.
const SURE: MicrosSpan = MicrosSpan(1_500);

/// One report of a module.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// When it came, by the host's clock.
    pub arrival: Micros,
    /// What it says.
    pub telemetry: Telemetry,
}

/// Module `id` of `host`, whose socket has `port`, in an emulator with these `arguments` besides.
#[must_use]
pub fn boot(host: &HostIdentity, id: ModuleId, port: u16, arguments: &[&str]) -> Emulator {
    let configuration = provisioned::image(&provisioned::modboat(host, id, port));
    let forward = Some((free_port(), port));
    Emulator::start(&Setup {
        image: "qemu.elf",
        configuration: &configuration,
        forward,
        arguments,
        ..Setup::default()
    })
}

/// See the module's documentation.
pub struct Bench {
    /// Who the modules obey.
    pub host: HostIdentity,
    /// Their host.
    pub dispatcher: Dispatcher<SocketAddr>,
    /// The modules, in the order of their ids.
    pub modules: Vec<Emulator>,
    /// The reports of each that it sent with a known fleet time, in the order in which they came.
    pub seen: Vec<Vec<Seen>>,
    radio: UdpRadio,
    began: Instant,
    ticks: u32,
    /// Longest time that this machine kept the bench from its turn.
    pub stalled: Duration,
}

impl Bench {
    /// With modules 1 to `count`, and keys from `seed`.
    ///
    /// # Panics
    /// If there is no free port or no emulator.
    #[must_use]
    pub fn start(count: u16, seed: u64) -> Self {
        priority();
        let host = HostIdentity::simulated(seed, 0);
        let radio = UdpRadio::bind("127.0.0.1:0").expect("a free port");
        let port = radio.local_address().expect("bound").port();
        let roster: Vec<ModuleId> = (1..=count).map(ModuleId).collect();
        let dispatcher = Dispatcher::new(&roster, &host.key, host.boot);
        let modules = roster.iter().map(|&id| boot(&host, id, port, &[])).collect();
        let seen = roster.iter().map(|_| Vec::new()).collect();
        Self {
            host,
            dispatcher,
            modules,
            seen,
            radio,
            began: Instant::now(),
            ticks: 0,
            stalled: Duration::ZERO,
        }
    }

    /// The host's clock, which is the fleet's.
    #[must_use]
    pub fn now(&self) -> Micros {
        Micros(self.began.elapsed().as_micros() as u64)
    }

    /// One millisecond: what came, what is due, what is to be sent. What came meant this.
    ///
    /// # Panics
    /// If the socket fails.
    pub fn turn(&mut self) -> Vec<Event> {
        self.ticks += 1;
        let due = self.began + Duration::from_millis(self.ticks.into());
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        self.stalled = self.stalled.max(due.elapsed());
        let (mut events, mut buffer) = (Vec::new(), [0; MAX_DATAGRAM]);
        while let Some((length, from)) = self.radio.receive(self.now(), &mut buffer).expect("a socket") {
            let now = self.now();
            // What is not to be followed is counted there.
            let Ok(Some(event)) = self.dispatcher.handle_datagram(now, from, &buffer[..length]) else {
                continue;
            };
            if let Event::Reported(index) = event {
                self.keep(index);
            }
            events.push(event);
        }
        self.dispatcher.handle_timer(self.now());
        while let Some((to, datagram)) = self.dispatcher.poll_transmit(self.now(), &mut buffer) {
            let now = Micros(self.began.elapsed().as_micros() as u64);
            self.radio.send(now, to, datagram).expect("a socket");
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
    pub fn until(&mut self, what: &str, mut is: impl FnMut(&Self, &[Event]) -> bool) -> Vec<Event> {
        let (deadline, mut all) = (Instant::now() + PATIENCE, Vec::new());
        loop {
            let events = self.turn();
            let done = is(self, &events);
            all.extend(events);
            if done {
                return all;
            }
            if Instant::now() > deadline {
                let lines: Vec<String> = self.modules.iter_mut().flat_map(|m| m.lines().to_vec()).collect();
                panic!("no {what}; the modules said:\n{}", lines.join("\n"));
            }
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

    /// Dispatches one cycle to everybody.
    pub fn dispatch(&mut self, number: u32, start: Micros, motions: &[Motion]) {
        let motions: Vec<Option<Motion>> = motions.iter().cloned().map(Some).collect();
        self.dispatcher.dispatch(self.now(), number, start, &motions, Delivery::Direct);
    }
}
