//! Emulated modules as the fleet of a run, and everything that they report written down.
//!
//! A run at [`Pace::Simulated`](host::run::experiment::Pace::Simulated) is in lock step with them: each of its ticks is a step.

use std::net::SocketAddr;

use host::run::RunError;
use host::run::fleet::{Fleet, OverUdp};
use host::run::scenario::Scenario;
use link::dispatcher::Dispatcher;
use link::faults::FaultCount;
use link::identity::HostIdentity;
use link::udp::{BrokenRadio, UdpRadio};
use protocol::time::FleetInstant;
use protocol::{ModuleId, ModuleState, Radio};
use sim::TailState;

use crate::bench::Seen;
use crate::modules::Modules;

/// Emulated modules as the fleet of a run.
pub struct Emulated {
    inner: OverUdp,
    /// The modules.
    pub modules: Modules,
    /// The reports of each, in the order in which they came.
    pub seen: Vec<Vec<Seen>>,
}

impl Emulated {
    /// As many modules as `scenario` has.
    ///
    /// # Panics
    /// If one does not start.
    #[must_use]
    pub fn start(scenario: &Scenario, seed: u64) -> Self {
        let host = HostIdentity::simulated(seed, 0);
        let radio = UdpRadio::bind("127.0.0.1:0").expect("a free port");
        let port = radio.local_address().expect("bound").port();
        let roster: Vec<ModuleId> = (1..=scenario.structure.len() as u16).map(ModuleId).collect();
        let modules = Modules::start(&host, port, roster.len(), seed);
        let seen = roster.iter().map(|_| Vec::new()).collect();
        Self { inner: OverUdp::boats(scenario, radio, host, roster, seed), modules, seen }
    }
}

impl Radio for Emulated {
    type Address = SocketAddr;
    type Error = BrokenRadio;

    fn send(&mut self, now: FleetInstant, to: SocketAddr, datagram: &[u8]) -> Result<(), BrokenRadio> {
        self.modules.send(self.inner.radio(), now, to, datagram)
    }

    fn receive(
        &mut self,
        now: FleetInstant,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, SocketAddr)>, BrokenRadio> {
        self.modules.receive(self.inner.radio(), now, buffer)
    }
}

impl Fleet for Emulated {
    type Radio = Self;
    type Actuation = TailState;

    fn host(&self) -> &HostIdentity {
        self.inner.host()
    }

    fn roster(&self) -> &[ModuleId] {
        self.inner.roster()
    }

    fn radio(&mut self) -> &mut Self {
        self
    }

    fn advance(&mut self, now: FleetInstant) -> Result<(), RunError> {
        self.modules.step();
        self.inner.advance(now)
    }

    fn actuate(
        &mut self,
        now: FleetInstant,
        dispatcher: &Dispatcher<SocketAddr>,
        tails: &mut Vec<TailState>,
    ) {
        for (seen, link) in self.seen.iter_mut().zip(dispatcher.modules()) {
            let Some(&telemetry) = link.telemetry() else { continue };
            if telemetry.state == ModuleState::Unsynchronised {
                continue;
            }
            if seen.last().is_none_or(|last| last.telemetry.at < telemetry.at) {
                seen.push(Seen { arrival: link.heard(), telemetry });
            }
        }
        self.inner.actuate(now, dispatcher, tails);
    }

    fn faults(&self) -> Option<FaultCount> {
        self.inner.faults()
    }

    fn clock_error_us(&self, now: FleetInstant) -> Option<u64> {
        self.inner.clock_error_us(now)
    }
}
