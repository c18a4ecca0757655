//! Fidelity `module`: the simulation of `flotilla run`, driven by commands instead of a pilot.
//!
//! Modules are [`InProcess`], the firmware crate on simulated motors at 1 kHz, with clocks and boot times of their own; the host's end is
//! the [`Dispatcher`], and the water the [`Tank`]. Only the pilot is left out, with the motion capture that it looks through. One tick is
//! the tick of the closed loop, part by part in its order:
//!
//! ```text
//! modules → datagrams to the host → tails in the tank → timers → [a command, where one is due] → datagrams to the modules
//! ```
//!
//! so that the commands of a run's decisions, at the same times, give the run's poses to the bit.
//!
//! A command is due when the pilot would decide: when all modules are ready and sure of the time, or `lead_s` before the running cycle
//! ends. Commands go to each module by itself ([`Delivery::Direct`]); a module that does not get one holds, and all wait for it to rest.

use firmware::link::session::SURE_WITHIN;
use host::run::experiment::water;
use host::run::fleet::{Fleet, InProcess};
use host::run::pilot::DECIDE_BY;
use host::run::scenario::Scenario;
use link::delivery::Knowledge;
use link::dispatcher::{Dispatcher, ModuleLink};
use link::loopback::Node;
use protocol::time::{Duration, FleetInstant};
use protocol::{Delivery, MAX_DATAGRAM, ModuleKind, ModuleState, Motion, Radio};
use record::PoseSample;
use sim::TailState;
use sim::module::TICK;
use sim::tank::Tank;

use crate::command::{Command, span};
use crate::settings::EnvironmentError;

/// As sure of the time as the pilot has modules be before it begins.
const SURE_TO_BEGIN: Duration = Duration(SURE_WITHIN.0 / 4 * 3);

/// See the module's documentation.
pub struct Modules {
    fleet: InProcess,
    links: Dispatcher<Node>,
    tank: Tank,
    tails: Vec<TailState>,
    now: FleetInstant,
    lead: Duration,
    join_s: f64,
    /// Start of the first cycle.
    origin: Option<FleetInstant>,
    /// Number of the last cycle that was sent.
    number: u32,
    /// When it ends, while modules are known to run it.
    ends: Option<FleetInstant>,
    /// When the next is to start.
    starts: FleetInstant,
    /// Where each tail rests then, rad.
    rests_rad: Vec<f64>,
    motions: Vec<Option<Motion>>,
    contacts: usize,
    is_stuck: bool,
}

impl Modules {
    /// Modules and water of `scenario` at its start, from `seed`, until the first command is due.
    ///
    /// # Errors
    /// [`EnvironmentError`] for what cannot be, and modules that do not join.
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, EnvironmentError> {
        let fleet = InProcess::boats(scenario, seed)?;
        let identity = fleet.host();
        let links =
            Dispatcher::new(fleet.roster(), &identity.key, identity.boot).of_kind(ModuleKind::Modboat);
        let count = scenario.structure.len();
        let mut modules = Self {
            fleet,
            links,
            tank: water(scenario, seed)?,
            tails: Vec::with_capacity(count),
            now: FleetInstant(0),
            lead: span(scenario.timing.lead_s),
            join_s: scenario.timing.join_s,
            origin: None,
            number: 0,
            ends: None,
            starts: FleetInstant(0),
            rests_rad: vec![0.0; count],
            motions: Vec::with_capacity(count),
            contacts: 0,
            is_stuck: false,
        };
        modules.wait()?;
        if modules.is_stuck {
            return Err(EnvironmentError::NotReady { waited_s: modules.join_s });
        }
        Ok(modules)
    }

    /// Sends `command`, which is due, and goes on until the next one is; how often tails met.
    ///
    /// # Errors
    /// The radio's.
    pub fn run(&mut self, command: &Command) -> Result<usize, EnvironmentError> {
        self.number += 1;
        self.origin.get_or_insert(self.starts);
        self.motions.clear();
        self.motions.extend((0..self.rests_rad.len()).map(|index| command.motion(index)));
        self.links.dispatch(self.now, self.number, self.starts, &self.motions, Delivery::Direct);
        self.ends = Some(self.starts.after(command.transition).after(command.period));
        for (rest_rad, turn) in self.rests_rad.iter_mut().zip(&command.turns) {
            *rest_rad = turn.to_rad;
        }
        self.transmit()?;
        self.wait()?;
        let contacts = self.tank.contacts().len();
        Ok(contacts - std::mem::replace(&mut self.contacts, contacts))
    }

    /// True pose and velocity now; its time is the tank's.
    #[must_use]
    pub fn pose(&self) -> PoseSample {
        self.tank.pose()
    }

    /// Where each tail rests when the running cycle ends, rad.
    #[must_use]
    pub fn rests_rad(&self) -> &[f64] {
        &self.rests_rad
    }

    /// When the next cycle starts, from the start of the first, s.
    #[must_use]
    pub fn starts_s(&self) -> f64 {
        self.origin.map_or(0.0, |origin| self.starts.as_secs_f64() - origin.as_secs_f64())
    }

    /// A module took no cycle any more, for longer than one is waited for.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.is_stuck
    }

    /// Ticks until a command is due, in the middle of a tick.
    fn wait(&mut self) -> Result<(), EnvironmentError> {
        let began = self.ends.unwrap_or(self.now);
        loop {
            self.tick()?;
            if self.is_due() {
                return Ok(());
            }
            self.transmit()?;
            if self.now.as_secs_f64() - began.as_secs_f64() > self.join_s {
                self.is_stuck = true;
                return Ok(());
            }
        }
    }

    /// The tick, up to where the pilot decides.
    fn tick(&mut self) -> Result<(), EnvironmentError> {
        self.now = self.now.after(TICK);
        self.fleet.advance(self.now)?;
        let mut buffer = [0; MAX_DATAGRAM];
        while let Ok(Some((length, from))) = self.fleet.radio().receive(self.now, &mut buffer) {
            // What does not decode is counted by the link.
            let _ = self.links.handle_datagram(self.now, from, &buffer[..length]);
        }
        self.fleet.actuate(self.now, &self.links, &mut self.tails);
        self.tank.step(f64::from(TICK.as_secs_f32()), &self.tails);
        self.links.handle_timer(self.now);
        Ok(())
    }

    fn transmit(&mut self) -> Result<(), EnvironmentError> {
        let mut buffer = [0; MAX_DATAGRAM];
        while let Some((to, datagram)) = self.links.poll_transmit(self.now, &mut buffer) {
            // The loopback takes everything.
            let _ = self.fleet.radio().send(self.now, to, datagram);
        }
        Ok(())
    }

    /// Whether a command is due now; then when its cycle starts, and from where.
    fn is_due(&mut self) -> bool {
        let (links, number) = (self.links.modules(), self.number);
        if let Some(ends) = self.ends {
            if self.now.after(self.lead) < ends {
                return false;
            }
            let unknown = links.iter().any(|link| link.knowledge(number) == Knowledge::Possibly);
            if unknown && self.now.after(DECIDE_BY) < ends {
                return false;
            }
            if links.iter().all(|link| link.has(number)) {
                self.starts = ends;
                return true;
            }
            self.ends = None;
            return false;
        }
        let is_sure =
            |link: &ModuleLink<Node>| link.health().is_some_and(|health| health.uncertainty <= SURE_TO_BEGIN);
        if !links.iter().all(|link| is_sure(link) && rest_rad(link).is_some()) {
            return false;
        }
        for (rest, link) in self.rests_rad.iter_mut().zip(links) {
            *rest = rest_rad(link).unwrap_or(*rest);
        }
        self.starts = self.now.after(self.lead);
        true
    }
}

/// Where a module says that its tail rests, if it does after the start of all that it may have taken.
fn rest_rad(link: &ModuleLink<Node>) -> Option<f64> {
    let report = link.telemetry()?;
    let rests = matches!(report.state, ModuleState::Ready | ModuleState::Holding) && link.is_up_to_date();
    rests.then(|| f64::from(report.tail.0))
}
