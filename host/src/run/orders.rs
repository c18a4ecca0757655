//! What an operator orders while a run goes on, and what the run tells of itself.

use std::sync::atomic::{AtomicBool, Ordering};

use link::dispatcher::ModuleLink;
use protocol::ModuleId;
use protocol::time::FleetInstant;
use serde::{Deserialize, Serialize};

use super::steering::Steering;

/// An order to a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Emergency stop: every module takes the drive off at once, brakes, and stays so until a release.
    Stop,
    /// Modules finish their cycle and hold; ROVs keep their place. Until a release.
    Hold,
    /// Ends a stop or a hold: the run goes on from where the fleet is. Of one module alone: the stop of that one, and the others'
    /// stays in force.
    Release(Option<ModuleId>),
    /// Ends the run: modules finish their cycle and hold, and what was measured is kept.
    End,
    /// Another target, or none.
    Steer(Steering),
}

impl Order {
    /// In a few words, for the log.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Stop => "stop".to_owned(),
            Self::Hold => "hold".to_owned(),
            Self::Release(None) => "release".to_owned(),
            Self::Release(Some(id)) => format!("release of {id}"),
            Self::End => "end".to_owned(),
            Self::Steer(steering) => steering.words(),
        }
    }
}

/// An order that was followed, or refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordered {
    /// When.
    pub at: FleetInstant,
    /// Who gave it.
    pub by: String,
    /// What, in a few words.
    pub what: String,
    /// Whether it is a target, or the end of one.
    pub steers: bool,
    /// What came of it.
    pub outcome: Result<String, String>,
}

/// Where orders come from: signals of the operating system, a socket, a console.
pub trait Operator {
    /// The next order by now, if there is one. Whether or not, it may ask for `status` and show it.
    fn poll(&mut self, status: &dyn Fn() -> RunStatus) -> Option<Order>;

    /// Who gave the last order.
    fn by(&self) -> String {
        "an operator".to_owned()
    }

    /// What came of the last order.
    fn answer(&mut self, _outcome: &Result<String, String>) {}
}

/// An operator that orders nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unattended;

impl Operator for Unattended {
    fn poll(&mut self, _: &dyn Fn() -> RunStatus) -> Option<Order> {
        None
    }
}

/// Ends the run when a flag is set, and orders nothing else.
#[derive(Debug)]
pub struct EndWhen<'a> {
    flag: &'a AtomicBool,
    told: bool,
}

impl<'a> EndWhen<'a> {
    /// When `flag` is set.
    #[must_use]
    pub const fn new(flag: &'a AtomicBool) -> Self {
        Self { flag, told: false }
    }
}

impl Operator for EndWhen<'_> {
    fn poll(&mut self, _: &dyn Fn() -> RunStatus) -> Option<Order> {
        let ends = !self.told && self.flag.load(Ordering::Relaxed);
        self.told |= ends;
        ends.then_some(Order::End)
    }
}

/// A run at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunStatus {
    /// Time of the scenario, s; below zero while modules join.
    pub t_s: f64,
    /// How long the scenario takes, s.
    pub duration_s: f64,
    /// What the fleet does, in a sentence.
    pub fleet: String,
    /// `stop` or `hold`, while one is in force.
    pub order: Option<String>,
    /// Every module of the roster.
    pub modules: Vec<ModuleStatus>,
}

/// A module as it last said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModuleStatus {
    /// Its number.
    pub id: u16,
    /// What it was doing; `None` before its first report.
    pub state: Option<String>,
    /// What was wrong with it.
    pub faults: Vec<String>,
    /// Battery voltage, V; `None` before its first report, and where there is no sensor.
    pub battery_v: Option<f64>,
    /// How long ago it was heard, s; `None` if never.
    pub silent_s: Option<f64>,
}

impl ModuleStatus {
    /// Of a module's link at `now`.
    pub fn of<A: Copy>(now: FleetInstant, id: u16, link: &ModuleLink<A>) -> Self {
        let boat = link.telemetry().map(|report| report.battery);
        let battery = boat.or(link.rov_telemetry().map(|report| report.battery));
        Self {
            id,
            state: link.state().map(|state| format!("{state:?}")),
            faults: link.faults().names().map(str::to_owned).collect(),
            battery_v: battery.map(|battery| f64::from(battery.0)).filter(|volts| volts.is_finite()),
            silent_s: link.is_known().then(|| f64::from(now.since(link.heard()).as_secs_f32())),
        }
    }
}
