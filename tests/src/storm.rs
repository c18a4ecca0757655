//! Storms: whole fleets on a medium worse than any radio, with faults of machines, hosts and modules and with strangers, watched by code that
//! shares nothing with the link but its counts.
//!
//! ```text
//! calm 6 s │ storm 12 s: loss, bursts, delay up to a cycle, damage, replays, forgeries, reboots, clock steps │ healed
//! ╰──────── nothing may happen that must not ────────╯ ╰──── all swim again within three cycles ─────╯ ╰ the sums are exact ╯
//! ```
//!
//! Beside what befalls the medium a storm has kinds of its own, each drawn by its seed, in whatever combination:
//!
//! | kind | what |
//! |---|---|
//! | send errors | the operating system refuses single sends, or all of one node for up to 2 s: the radio of runs on UDP over a socket that fails |
//! | host pauses | for 0.6 to 5 s the host does not run; then it skips to now |
//! | a doubled module | a second module with the number of one of them has power for a while |
//! | recorded announcements | of up to 20 old boots, 1,000 a second, to the end |
//! | forged calls | up to 1,000 a second |
//! | a module that lies | NaN, 10³⁰, times and cycle numbers that cannot be, under its right seal |
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
//! | who is named | a doubled module with both addresses, a liar; neither is counted on by a decision, and what judges a run says so (`named`) |
//!
//! A module that loses its power in mid-swing leaves its tail wherever it is, and its neighbours go on until the host knows.
//! Plans are asked to be power tolerant; where one could not be (the first from the start pose, or the one after
//! a tail was left in a neighbour's reach), a contact with such a tail is told apart and counted.

use std::collections::{HashMap, HashSet};
use std::net::SocketAddr;

use host::run::closed_loop::Gap;
use host::run::host::Controller as _;
use host::run::host::Host;
use host::run::pilot::Pilot;
use host::run::scenario::Scenario;
use link::faults::FaultCount;
use link::identity::HostIdentity;
use link::loopback::Node;
use protocol::time::{Duration, FleetInstant};
use protocol::{MAX_DATAGRAM, ModuleId, Radio};
use record::PoseSample;
use sim::TailState;
use sim::mocap::Mocap;
use sim::tank::Tank;

use count::{Classes, Count};
pub use draw::Storm;
use liar::Liar;
use named::{HostRun, Named};
use strangers::Player;
use tap::TappedFleet;

pub mod count;
mod draw;
mod ends;
mod liar;
mod named;
mod settle;
mod strangers;
pub mod tap;
mod watch;
mod wire;

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

/// Why the host's radio is not broken.
const REFUSED: &str = "no machine refuses for that long";

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
    /// How often each kind of a storm's own struck.
    pub kinds: KindCount,
}

/// How often each kind of a storm's own struck.
#[derive(Clone, Copy, Debug, Default)]
pub struct KindCount {
    /// Sends that the operating system refused.
    pub send_errors: u64,
    /// Pauses of a host.
    pub pauses: u64,
    /// Runs of a host that met a doubled module.
    pub doubled: u64,
    /// Announcements played to the host.
    pub played: u64,
    /// Forged calls.
    pub called: u64,
    /// Lies that modules told.
    pub lies: u64,
    /// Runs of a host that named a liar.
    pub liars: u64,
}

/// Everything of one storm.
struct World<'a> {
    storm: &'a Storm,
    scenario: Scenario,
    fleet: TappedFleet,
    count: Count,
    host: Option<Host<Pilot, SocketAddr>>,
    player: Player,
    /// Until then the host does not run; since when.
    paused: Option<(u64, u64)>,
    named: Named,
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
        let key = HostIdentity::simulated(storm.seed, 0).key;
        let doubles: Vec<u16> = storm.kinds.double.iter().map(|(module, ..)| *module as u16 + 1).collect();
        let mut fleet = TappedFleet::new(&scenario, &doubles, storm.seed);
        let mut count = Count::new(&key, storm.modules, &doubles);
        if let Some((_, from_us, _)) = storm.kinds.double {
            fleet.modules[storm.modules].reboot(FleetInstant(0), Duration(from_us as u32));
        }
        if let Some((liar, ..)) = storm.kinds.liar {
            let id = ModuleId(liar as u16 + 1);
            let liar = Liar::new(key.fleet(), id, key.module(id), storm.seed);
            fleet.modules[usize::from(id.0) - 1].radio_mut().liar = Some(liar);
        }
        let node = Node((1 + fleet.modules.len()) as u16);
        let boots = storm.kinds.recordings;
        let player = Player::new(&fleet.ether, node, &key, storm.modules as u16, boots, storm.seed);
        player.recorded.iter().for_each(|(datagram, session)| count.recorded(*session, datagram));
        let start = PoseSample { heading_rad: scenario.start_heading_rad(), ..PoseSample::default() };
        let tank = Tank::new(&scenario.structure, &scenario.modboat, &scenario.tank, &start, storm.seed);
        let mocap = Mocap::new(&scenario.mocap, storm.seed).expect("cameras");
        let neighbours =
            [[1, 0], [0, 1]].into_iter().flat_map(|offset| scenario.structure.neighbours(offset));
        let watch = Watch {
            powerless: vec![None; storm.modules],
            running: vec![None; storm.modules],
            neighbours: neighbours.collect(),
            module_received: vec![[0; 7]; fleet.modules.len()],
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
            player,
            paused: None,
            named: Named::default(),
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
            self.strike(now_us);
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

    /// Faults of ends, and strangers, that are due.
    fn strike(&mut self, now_us: u64) {
        let (kinds, storm_us) = (&self.storm.kinds, (CALM_S * 1e6) as u64);
        let healed_us = storm_us + (STORM_S * 1e6) as u64;
        if kinds.send_errors > 0.0 {
            for (node, trouble) in self.fleet.troubles.iter().enumerate() {
                let mut refusals = kinds.refusals.iter();
                let refuses = refusals
                    .any(|&(from_us, until_us, of)| of == node && (from_us..until_us).contains(&now_us));
                let share = if (storm_us..healed_us).contains(&now_us) { kinds.send_errors } else { 0.0 };
                trouble.share.set(if refuses { 1.0 } else { share });
            }
        }
        for &(_, length_us) in kinds.pauses.iter().filter(|(at, _)| *at == now_us) {
            if self.host.is_some() && self.paused.is_none() {
                self.paused = Some((now_us - TICK_US, (now_us + length_us).min(healed_us)));
                self.outcome.kinds.pauses += 1;
            }
        }
        if let Some((liar, from_us, until_us)) = kinds.liar
            && let Some(liar) = &mut self.fleet.modules[liar].radio_mut().liar
        {
            liar.lies = (from_us..until_us).contains(&now_us);
        }
        let calls = kinds.calls_per_s * TICK_US as f64 * 1e-6;
        if now_us >= storm_us {
            self.player.play();
            // Without a remainder that is kept: so many by then, less those made.
            let due =
                if now_us < healed_us { (calls * ((now_us - storm_us) / TICK_US) as f64) as u64 } else { 0 };
            (self.player.called..due).for_each(|_| self.player.call());
        }
        self.player.listen();
        if kinds.double.is_some_and(|(.., until_us)| until_us == now_us) {
            self.reboot(now_us, self.storm.modules, Duration(u32::MAX));
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
        let runs = self.paused.is_none_or(|(_, until_us)| now_us >= until_us);
        let gap = self.paused.take_if(|_| runs).map(|(since_us, _)| since_us);
        if let (Some(since_us), Some(host), Some(run)) = (gap, &mut self.host, self.host_runs.last()) {
            let start = FleetInstant(since_us.saturating_sub(run.epoch_us));
            host.controller.handle_gap(&Gap { start, end: host_now });
        }
        if runs {
            self.receive(now, host_now);
        }
        let places = &self.fleet.modules[..self.storm.modules];
        let tails: Vec<TailState> = places.iter().map(|module| module.tail()).collect();
        self.tank.step(TICK_US as f64 * 1e-6, &tails);
        let pose = self.tank.pose();
        if let Some(mut fix) = self.mocap.sample(pose.t_s, &pose)
            && let Some(host) = self.host.as_mut().filter(|_| runs)
        {
            fix.t_s -= now.as_secs_f64() - host_now.as_secs_f64();
            host.handle_pose(&fix);
        }
        if let Some(host) = self.host.as_mut().filter(|_| runs) {
            host.handle_timer(host_now).expect("a pilot does not fail");
            let links = host.dispatcher().modules();
            self.count.host_timer(host_now.0, |module| {
                let of = |address| usize::from(wire::node(address).0) - 1;
                (links[module].is_doubled(), links[module].address().map(of))
            });
            while let Some((to, datagram)) = host.poll_transmit(host_now, &mut buffer) {
                self.fleet.radio.send(now, to, datagram).expect(REFUSED);
            }
        }
        self.count_tape(host_now);
        self.note_decisions(host_now);
        self.watch_names(now_us, host_now, runs, gap.is_some());
        self.watch_cycles(now_us);
        self.watch_contacts(now_us);
    }

    /// What came to the host by now, one by one, each counted when it has been handled.
    fn receive(&mut self, now: FleetInstant, host_now: FleetInstant) {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((length, from)) = self.fleet.radio.receive(now, &mut buffer).expect(REFUSED) {
            match &mut self.host {
                Some(host) => {
                    let _ = host.handle_datagram(host_now, from, &buffer[..length]);
                }
                None => self.watch.discarded += 1,
            }
            self.count_tape(host_now);
        }
    }
}
