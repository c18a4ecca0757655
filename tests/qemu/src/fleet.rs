//! Emulated modules as the fleet of a run, and everything that they report written down.

use std::net::SocketAddr;

use host::link::dispatcher::Dispatcher;
use host::link::faults::FaultCount;
use host::link::identity::HostIdentity;
use host::link::udp::UdpRadio;
use host::run::RunError;
use host::run::fleet::{Fleet, OverUdp};
use host::run::scenario::Scenario;
use host::sim::TailState;
use protocol::units::Micros;
use protocol::{ModuleId, ModuleState};

use crate::bench::{self, Seen};
use crate::emulator::{Emulator, priority};

/// See the module's documentation.
pub struct Emulated {
    inner: OverUdp,
    host: HostIdentity,
    port: u16,
    /// The modules, in the order of their ids.
    pub modules: Vec<Emulator>,
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
        priority();
        let host = HostIdentity::simulated(seed, 0);
        let radio = UdpRadio::bind("127.0.0.1:0").expect("a free port");
        let port = radio.local_address().expect("bound").port();
        let roster: Vec<ModuleId> = (1..=scenario.structure.len() as u16).map(ModuleId).collect();
        let inner = OverUdp::new(scenario, radio, host.clone(), roster.clone(), seed);
        let seen = roster.iter().map(|_| Vec::new()).collect();
        let mut fleet = Self { inner, host, port, modules: Vec::new(), seen };
        fleet.modules = roster.iter().map(|&id| bench::boot(&fleet.host, id, port, &[])).collect();
        fleet
    }

    /// Takes the power of the module at `index` away, and gives it back: another life in another emulator.
    pub fn restart(&mut self, index: usize) {
        self.modules[index].kill();
        self.modules[index] = bench::boot(&self.host, self.inner.roster()[index], self.port, &[]);
    }
}

impl Fleet for Emulated {
    type Radio = <OverUdp as Fleet>::Radio;

    fn host(&self) -> &HostIdentity {
        &self.host
    }

    fn roster(&self) -> &[ModuleId] {
        self.inner.roster()
    }

    fn radio(&mut self) -> &mut Self::Radio {
        self.inner.radio()
    }

    fn advance(&mut self, now: Micros) -> Result<(), RunError> {
        self.inner.advance(now)
    }

    fn tails(&mut self, now: Micros, dispatcher: &Dispatcher<SocketAddr>, tails: &mut Vec<TailState>) {
        for (seen, link) in self.seen.iter_mut().zip(dispatcher.modules()) {
            let Some(&telemetry) = link.telemetry() else { continue };
            if telemetry.state == ModuleState::Unsynchronised {
                continue;
            }
            if seen.last().is_none_or(|last| last.telemetry.at < telemetry.at) {
                seen.push(Seen { arrival: link.heard(), telemetry });
            }
        }
        self.inner.tails(now, dispatcher, tails);
    }

    fn faults(&self) -> Option<FaultCount> {
        self.inner.faults()
    }

    fn clock_error_us(&self, now: Micros) -> Option<u64> {
        self.inner.clock_error_us(now)
    }
}
