//! The two ends of a storm's links: starts and crashes of the host, reboots of modules, and whether what each says came to it is what was counted
//! at its radio.

use std::net::SocketAddr;

use host::run::host::Host;
use host::run::pilot::Pilot;
use link::identity::HostIdentity;
use protocol::time::{Duration, FleetInstant};

use super::count::{Class, Classes, Doubtful};
use super::named::HostRun;
use super::tap::{HOST, Tapped};
use super::wire::node;
use super::{TICK_US, World, add, classes};

impl World<'_> {
    pub(super) fn start_host(&mut self, now_us: u64) {
        let host = HostIdentity::simulated(self.storm.seed, self.host_runs.len() as u64);
        // Time of the first run is the true one; that of later runs begins when they do.
        let epoch_us = if self.host_runs.is_empty() { 0 } else { now_us - TICK_US };
        let pilot = Pilot::new(&self.scenario, None, || FleetInstant(0)).expect("a pilot");
        self.host = Some(Host::new(pilot, &host, &self.fleet.roster));
        self.host_runs.push(HostRun::new(host.boot, epoch_us));
    }

    /// The host crashes.
    pub(super) fn stop_host(&mut self) {
        let Some(host) = self.host.take() else { return };
        self.paused = None;
        self.judge();
        let (counted, strays) = self.count.end_host();
        let told = classes(host.dispatcher().strays());
        add(&mut self.watch.host_received, told);
        self.compare("the host, of strays", told, strays);
        for (index, link) in host.dispatcher().modules().iter().enumerate() {
            let told = classes(link.incoming());
            add(&mut self.watch.host_received, told);
            self.watch.host_sent[index] += link.outgoing().sent;
            self.compare(&format!("the host, of module {}", index + 1), told, counted[index]);
            self.check_sums(index, &host);
        }
    }

    /// What a module says came to it, and what was counted at its radio. A call that it does not take is stale, or foreign while it hears its
    /// host: a tap cannot tell which.
    pub(super) fn compare_module(&mut self, whose: &str, told: Classes, (mut counted, doubtful): Doubtful) {
        // Of those that are doubtful some were looked at.
        let looked_at =
            told[Class::Forged as usize].saturating_sub(counted[Class::Forged as usize]).min(doubtful);
        counted[Class::Forged as usize] += looked_at;
        counted[Class::Stale as usize] -= looked_at;
        let not_taken = |[received, accepted, duplicate, stale, corrupt, forged, foreign]: Classes| {
            [received, accepted, duplicate, stale + foreign, corrupt, forged, 0]
        };
        self.compare(whose, not_taken(told), not_taken(counted));
    }

    /// What an end says came to it, and what was counted at its radio.
    pub(super) fn compare(&mut self, whose: &str, told: Classes, counted: Classes) {
        if told != counted {
            let what = "received, accepted, duplicate, stale, corrupt, forged, foreign";
            self.violation(0, &format!("{whose}: {what}: {told:?}, counted {counted:?}"));
        }
    }

    /// Counts what passed the taps in the tick at `host_now`.
    pub(super) fn count_tape(&mut self, host_now: FleetInstant) {
        for tapped in self.fleet.take_tape() {
            match tapped {
                Tapped::Sent(HOST, datagram) => {
                    self.player.hear(&datagram);
                    self.count.host_sent(&datagram);
                }
                Tapped::Lied(node, datagram) => {
                    let module = usize::from(node.0) - 1;
                    self.count.module_lied(module, self.session(module).unwrap_or(0), &datagram);
                    self.outcome.kinds.lies += 1;
                }
                Tapped::Came(HOST, datagram) => {
                    if let Some(host) = &self.host {
                        let links = host.dispatcher().modules();
                        let second = |module: usize| {
                            let [_, other] = links[module].doubled()?;
                            Some(usize::from(node(other).0) - 1)
                        };
                        self.count.came_to_host(host_now.0, &datagram, second);
                    }
                }
                Tapped::Sent(node, datagram) => {
                    let module = usize::from(node.0) - 1;
                    self.count.module_sent(module, self.session(module).unwrap_or(0), &datagram);
                }
                Tapped::Came(node, datagram) => {
                    let module = usize::from(node.0) - 1;
                    if let Some(session) = self.session(module) {
                        self.count.came_to_module(module, session, &datagram);
                    }
                }
            }
        }
    }

    /// The session that a module is in, 0 for none; `None` without power.
    pub(super) fn session(&self, module: usize) -> Option<u32> {
        self.fleet.modules[module].link().map(|link| link.session())
    }

    pub(super) fn check_sums(&mut self, index: usize, host: &Host<Pilot, SocketAddr>) {
        let link = &host.dispatcher().modules()[index];
        let (out, cycles) = (link.outgoing(), link.ledger());
        if out.acknowledged + out.late + out.lost + out.under_way() != out.sent || !link.incoming().is_exact()
        {
            self.violation(0, &format!("module {}: {out:?}, {:?}", index + 1, link.incoming()));
        }
        let closed = cycles.acknowledged + cycles.late + cycles.refused + cycles.unanswered;
        if cycles.cycles < closed || cycles.cycles - closed > 1 {
            self.violation(0, &format!("module {}: {cycles:?}", index + 1));
        }
    }

    pub(super) fn reboot(&mut self, now_us: u64, module: usize, off: Duration) {
        self.note_boot(module);
        let in_place = module < self.storm.modules;
        let swings = in_place && self.fleet.modules[module].running(FleetInstant(now_us)).is_some();
        self.outcome.powerless += usize::from(swings);
        if swings {
            self.watch.powerless[module].get_or_insert(true);
        }
        self.fleet.modules[module].reboot(FleetInstant(now_us), off);
    }

    /// Counts of a boot that is over.
    pub(super) fn note_boot(&mut self, module: usize) {
        let counted = self.count.end_boot(module);
        let Some(link) = self.fleet.modules[module].link() else { return };
        let (incoming, outgoing) = (*link.incoming(), link.outgoing());
        self.watch.module_sent += outgoing.sent + link.announced();
        add(&mut self.watch.module_received[module], classes(&incoming));
        self.compare_module(&format!("module {}", module + 1), classes(&incoming), counted);
        let closed = outgoing.acknowledged + outgoing.late + outgoing.lost + outgoing.under_way();
        if !incoming.is_exact() || closed != outgoing.sent {
            self.violation(0, &format!("module {}: {incoming:?}, {outgoing:?}", module + 1));
        }
    }
}
