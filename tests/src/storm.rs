//! Storms: whole fleets on a medium worse than any radio, with reboots of host and modules, watched by code that shares
//! nothing with the link but its counts.
//!
//! ```text
//! calm 6 s │ storm 12 s: loss, bursts, delay up to a cycle, damage, replays, forgeries, reboots, clock steps │ healed
//! ╰──────── nothing may happen that must not ────────╯ ╰──── all swim again within three cycles ─────╯ ╰ the sums are exact ╯
//! ```
//!
//! The true time of the simulation is not the fleet's: each run of the host has an epoch of its own, each module a clock that is
//! off by up to 100 s and 100 ppm.
//!
//! | watched | how |
//! |---|---|
//! | tail contacts | by the tank, from the true tails |
//! | different cycles at once | the numbers that neighbours' firmware runs, every tick |
//! | stale, foreign cycles | a running cycle must be one that the host of the module's session decided, in its time |
//! | replays and forgeries let in | each ledger, class by class, is what [`count`] found at the radios: accepted are the distinct genuine datagrams of the sessions in force, and no others |
//! | exact sums | each ledger, and all of them against what the medium handed over |
//!
//! A module that loses its power in mid-swing leaves its tail wherever it is, and its neighbours go on until the host knows.
//! Plans are asked to be power tolerant; where one could not be (the first from the start pose, or the one after
//! a tail was left in a neighbour's reach), a contact with such a tail is told apart and counted.

use std::collections::{HashMap, HashSet};

use host::run::host::Host;
use host::run::pilot::Pilot;
use host::run::scenario::Scenario;
use link::faults::FaultCount;
use link::identity::HostIdentity;
use link::loopback::Node;
use protocol::time::{Duration, FleetInstant};
use protocol::{MAX_DATAGRAM, Radio};
use record::PoseSample;
use sim::TailState;
use sim::mocap::Mocap;
use sim::tank::Tank;

use count::{Classes, Count};
pub use draw::Storm;
use tap::{HOST, Tapped, TappedFleet};

pub mod count;
mod draw;
pub mod tap;
mod watch;

const TICK_US: u64 = 1_000;
const CALM_S: f64 = 6.0;
const STORM_S: f64 = 12.0;
/// Three cycles with their transitions.
pub const THREE_CYCLES_S: f64 = 6.0;
/// After healing the storm waits this long for all modules to swim, to tell late from never.
const PATIENCE_S: f64 = 20.0;
/// Clocks may differ by so much where one cycle follows another, beside what they have jumped: that is corrected slowly while
/// cycles run.
const SKEW_US: u64 = 4_000;
/// Modules' clocks jump by at most this while they swim, s: some lost ticks.
const STEP_S: f64 = 0.005;

/// Outcome of a storm.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// What must not happen, in words.
    pub violations: Vec<String>,
    /// Contacts with a tail that had lost its power in mid-swing.
    pub powerless_contacts: usize,
    /// Reboots of modules in mid-swing.
    pub powerless: usize,
    /// From healing until all modules swam, s.
    pub swam_after_s: Option<f64>,
    /// Cycles that any host decided on.
    pub decisions: usize,
    /// Datagrams that modules and hosts received, by class.
    pub received: Classes,
    /// What the medium did.
    pub faults: FaultCount,
}

/// One run of the host, from start to crash.
struct HostRun {
    boot: [u8; 12],
    /// Its time zero, true time.
    epoch_us: u64,
    /// Start and end of each decision's cycles, µs of its own time, by number; whether any module may lose its power in it.
    cycles: HashMap<u32, (u64, u64, bool)>,
    seen: usize,
}

/// Everything of one storm.
struct World<'a> {
    storm: &'a Storm,
    scenario: Scenario,
    fleet: TappedFleet,
    count: Count,
    host: Option<Host<Pilot, Node>>,
    host_runs: Vec<HostRun>,
    tank: Tank,
    mocap: Mocap,
    watch: Watch,
    outcome: Outcome,
    /// The last decision in a few words.
    last: String,
}

/// What is kept from tick to tick.
#[derive(Default)]
struct Watch {
    /// By module: its power failed in mid-swing, and it has not begun a cycle since. True while all cycles since then were such
    /// that any module may lose its power.
    powerless: Vec<Option<bool>>,
    /// By module: running cycle, with the run of the host that decided it.
    running: Vec<Option<(usize, u32)>>,
    /// By pair of neighbours: since when they run different cycles.
    apart_since: HashMap<(usize, usize), u64>,
    neighbours: Vec<(usize, usize)>,
    /// Cycles that were complained of.
    told: HashSet<(usize, u32)>,
    contacts: usize,
    /// By module, of boots that are over: datagrams received, and sent.
    module_received: Vec<Classes>,
    module_sent: u64,
    /// Of runs of the host that are over.
    host_received: Classes,
    host_sent: Vec<u64>,
    discarded: u64,
}

fn classes(incoming: &protocol::ledger::Incoming) -> Classes {
    let i = incoming;
    [i.received, i.accepted, i.duplicate, i.stale, i.corrupt, i.forged, i.foreign].map(u64::from)
}

fn add(sum: &mut Classes, more: Classes) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

impl<'a> World<'a> {
    fn new(storm: &'a Storm) -> Self {
        let scenario = storm.scenario();
        let fleet = TappedFleet::new(&scenario, storm.seed);
        let count = Count::new(HostIdentity::simulated(storm.seed, 0).key, storm.modules);
        let start = PoseSample { heading_rad: scenario.start_heading_rad(), ..PoseSample::default() };
        let tank = Tank::new(&scenario.structure, &scenario.modboat, &scenario.tank, &start, storm.seed);
        let mocap = Mocap::new(&scenario.mocap, storm.seed).expect("cameras");
        let neighbours =
            [[1, 0], [0, 1]].into_iter().flat_map(|offset| scenario.structure.neighbours(offset));
        let watch = Watch {
            powerless: vec![None; storm.modules],
            running: vec![None; storm.modules],
            neighbours: neighbours.collect(),
            module_received: vec![[0; 7]; storm.modules],
            host_sent: vec![0; storm.modules],
            ..Watch::default()
        };
        let tank = tank.expect("a tank");
        let (host_runs, outcome) = (Vec::new(), Outcome::default());
        Self {
            storm,
            scenario,
            fleet,
            count,
            host: None,
            host_runs,
            tank,
            mocap,
            watch,
            outcome,
            last: String::new(),
        }
    }

    fn run(mut self) -> Outcome {
        let (storm_us, healed_us) = ((CALM_S * 1e6) as u64, ((CALM_S + STORM_S) * 1e6) as u64);
        let end_us = healed_us + (PATIENCE_S * 1e6) as u64;
        let mut restart_us = 0;
        let mut now_us = 0;
        while now_us < end_us {
            now_us += TICK_US;
            if now_us == storm_us {
                self.fleet.set_weather(self.storm.weather);
            }
            if now_us == healed_us {
                self.fleet.heal(self.storm.drop_under_way);
            }
            for &(_, module, off) in self.storm.reboots.iter().filter(|(at, ..)| *at == now_us) {
                self.reboot(now_us, module, off);
            }
            for &(_, module, by_s) in self.storm.steps.iter().filter(|(at, ..)| *at == now_us) {
                self.fleet.modules[module].step_clock(by_s);
            }
            for &(_, off_us) in self.storm.deaths.iter().filter(|(at, _)| *at == now_us) {
                self.stop_host();
                restart_us = restart_us.max((now_us + off_us).min(healed_us));
            }
            if self.host.is_none() && now_us >= restart_us {
                self.start_host(now_us);
            }
            self.tick(now_us);
            if now_us > healed_us && self.all_swim() {
                self.outcome.swam_after_s = Some((now_us - healed_us) as f64 * 1e-6);
                break;
            }
        }
        self.settle(now_us);
        self.outcome
    }

    fn violation(&mut self, now_us: u64, what: &str) {
        self.outcome.violations.push(format!("at {:.3} s: {what}", now_us as f64 * 1e-6));
    }

    fn start_host(&mut self, now_us: u64) {
        let host = HostIdentity::simulated(self.storm.seed, self.host_runs.len() as u64);
        // Time of the first run is the true one; that of later runs begins when they do.
        let epoch_us = if self.host_runs.is_empty() { 0 } else { now_us - TICK_US };
        let pilot = Pilot::new(&self.scenario, None, || FleetInstant(0)).expect("a pilot");
        self.host = Some(Host::new(pilot, &host, &self.fleet.roster));
        self.host_runs.push(HostRun { boot: host.boot, epoch_us, cycles: HashMap::new(), seen: 0 });
    }

    /// The host crashes.
    fn stop_host(&mut self) {
        let Some(host) = self.host.take() else { return };
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
    fn compare_module(&mut self, whose: &str, told: Classes, counted: Classes) {
        let not_taken = |[received, accepted, duplicate, stale, corrupt, forged, foreign]: Classes| {
            [received, accepted, duplicate, stale + foreign, corrupt, forged, 0]
        };
        self.compare(whose, not_taken(told), not_taken(counted));
    }

    /// What an end says came to it, and what was counted at its radio.
    fn compare(&mut self, whose: &str, told: Classes, counted: Classes) {
        if told != counted {
            let what = "received, accepted, duplicate, stale, corrupt, forged, foreign";
            self.violation(0, &format!("{whose}: {what}: {told:?}, counted {counted:?}"));
        }
    }

    /// Counts what passed the taps in the tick at `host_now`.
    fn count_tape(&mut self, host_now: FleetInstant) {
        for tapped in self.fleet.take_tape() {
            match tapped {
                Tapped::Sent(HOST, datagram) => self.count.host_sent(&datagram),
                Tapped::Came(HOST, datagram) if self.host.is_some() => {
                    self.count.came_to_host(host_now.0, &datagram);
                }
                Tapped::Came(HOST, _) => {}
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
    fn session(&self, module: usize) -> Option<u32> {
        self.fleet.modules[module].link().map(|link| link.session())
    }

    fn check_sums(&mut self, index: usize, host: &Host<Pilot, Node>) {
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

    fn reboot(&mut self, now_us: u64, module: usize, off: Duration) {
        self.note_boot(module);
        let swings = self.fleet.modules[module].running(FleetInstant(now_us)).is_some();
        self.outcome.powerless += usize::from(swings);
        if swings {
            self.watch.powerless[module].get_or_insert(true);
        }
        self.fleet.modules[module].reboot(FleetInstant(now_us), off);
    }

    /// Counts of a boot that is over.
    fn note_boot(&mut self, module: usize) {
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

    fn tick(&mut self, now_us: u64) {
        let now = FleetInstant(now_us);
        let mut buffer = [0; MAX_DATAGRAM];
        self.fleet.advance(now);
        let host_now = self
            .host_runs
            .last()
            .map_or(FleetInstant(0), |host_run| FleetInstant(now_us - host_run.epoch_us));
        while let Ok(Some((length, from))) = self.fleet.radio.receive(now, &mut buffer) {
            match &mut self.host {
                Some(host) => {
                    let _ = host.handle_datagram(host_now, from, &buffer[..length]);
                }
                None => self.watch.discarded += 1,
            }
        }
        let tails: Vec<TailState> = self.fleet.modules.iter().map(|module| module.tail()).collect();
        self.tank.step(TICK_US as f64 * 1e-6, &tails);
        let pose = self.tank.pose();
        if let Some(mut fix) = self.mocap.sample(pose.t_s, &pose)
            && let Some(host) = &mut self.host
        {
            fix.t_s -= now.as_secs_f64() - host_now.as_secs_f64();
            host.handle_pose(&fix);
        }
        if let Some(host) = &mut self.host {
            host.handle_timer(host_now).expect("a pilot does not fail");
            while let Some((to, datagram)) = host.poll_transmit(host_now, &mut buffer) {
                self.fleet.radio.send(now, to, datagram).expect("the loopback does not fail");
            }
        }
        self.count_tape(host_now);
        self.note_decisions();
        self.watch_cycles(now_us);
        self.watch_contacts(now_us);
    }

    fn note_decisions(&mut self) {
        let (Some(host), Some(host_run)) = (&self.host, self.host_runs.last_mut()) else { return };
        let pilot = &host.controller;
        for decision in &pilot.decisions()[host_run.seen..] {
            self.outcome.decisions += 1;
            let (outcome, tolerant) = (decision.plan.outcome.name(), decision.plan.loss_tolerant);
            self.last = format!(
                "{} {outcome}, loss tolerant: {tolerant}, clearance {}, {:?}",
                decision.number, decision.plan.clearance_m, decision.plan.cycle
            );
            let span = (decision.start.0, decision.end().0, decision.plan.power_tolerant);
            // Of a transition in two steps each is a cycle of its own.
            host_run.cycles.insert(decision.number, span);
            host_run.cycles.insert(decision.number + u32::from(decision.via.is_some()), span);
        }
        host_run.seen = pilot.decisions().len();
    }

    /// Whether every module runs the same cycle of the running host.
    fn all_swim(&self) -> bool {
        let host_run = self.host_runs.len().wrapping_sub(1);
        let first = self.watch.running[0];
        let decisions = self.host.as_ref().map_or(&[][..], |host| host.controller.decisions());
        // A module with a cycle of no amplitude does not swim.
        let swims = decisions.iter().rev().take(2).any(|decision| {
            let moves = decision.plan.cycle.iter().any(|swing| swing.amplitude_rad != 0.0);
            moves && first.is_some_and(|(_, number)| number == decision.last_number())
        });
        swims
            && first.is_some_and(|(of, _)| of == host_run)
            && self.watch.running.iter().all(|running| *running == first)
    }

    /// Lets everything arrive that is on its way, and compares all counts.
    fn settle(&mut self, now_us: u64) {
        self.fleet.heal(true);
        let now = FleetInstant(now_us + TICK_US);
        self.fleet.advance(now);
        let mut buffer = [0; MAX_DATAGRAM];
        let host_now = FleetInstant(now.0 - self.host_runs.last().map_or(0, |host_run| host_run.epoch_us));
        while let Ok(Some((length, from))) = self.fleet.radio.receive(now, &mut buffer) {
            if let Some(host) = &mut self.host {
                let _ = host.handle_datagram(host_now, from, &buffer[..length]);
            }
        }
        self.count_tape(host_now);
        self.stop_host();
        (0..self.storm.modules).for_each(|module| self.note_boot(module));
        let host = self.fleet.radio.radio().count();
        let modules = self
            .fleet
            .modules
            .iter()
            .map(|m| m.radio().radio().count())
            .reduce(|a, b| a + b)
            .unwrap_or_default();
        let unheard: u64 = self.fleet.modules.iter().map(|module| module.unheard()).sum();
        let mut heard = [0; 7];
        self.watch.module_received.iter().for_each(|classes| add(&mut heard, *classes));
        let told = self.watch.host_received;
        let claims = [
            ("datagrams handed to modules", host.delivered, heard[0] + unheard),
            ("datagrams handed to hosts", modules.delivered, told[0] + self.watch.discarded),
            ("datagrams hosts sealed", host.sent, self.watch.host_sent.iter().sum()),
            ("datagrams modules sealed", modules.sent, self.watch.module_sent),
        ];
        for (what, one, other) in claims {
            if one != other {
                self.violation(now_us, &format!("{what}: {one} and {other}"));
            }
        }
        add(&mut heard, told);
        self.outcome.received = heard;
        self.outcome.faults = host + modules;
        match self.outcome.swam_after_s {
            None => {
                let states: Vec<_> = self.fleet.modules.iter().map(|module| module.state(now)).collect();
                let what = format!(
                    "they do not all swim, long after the medium healed: {states:?}; last decision {:?}, tails {:?}",
                    self.last,
                    self.fleet.modules.iter().map(|m| m.tail().angle_rad).collect::<Vec<_>>()
                );
                self.violation(now_us, &what);
            }
            Some(s) if s > THREE_CYCLES_S => {
                self.violation(now_us, &format!("it took {s:.2} s to swim after the medium healed"));
            }
            Some(_) => {}
        }
    }
}
