//! `--pose` and what belongs to it: a motion capture, and how the world lies in its laboratory.

use std::net::Ipv4Addr;
use std::path::Path;

use nalgebra::{Vector2, Vector3};
use pose::address::{Address, OpenError, Options};
use pose::roster::{Entry, Name, Roster as Bodies};
use pose::source::Source;
use pose::structure::{Structure, Tolerances};
use protocol::{ModuleId, ModuleKind};
use reconfiguration::problem::Problem;

use super::{Failure, bad, could};
use crate::run::lab::{LabPoses, standard_unit};
use crate::run::logged::LoggedPoses;
use crate::run::reconfigure::poses::LabBodies;
use crate::run::reconfigure::scenario::ReconfigureScenario;
use crate::run::roster::Roster;
use crate::run::scenario::{LengthUnit, PoseParameters, Scenario, UpAxis};

#[derive(clap::Args)]
pub(super) struct PoseArguments {
    /// Where poses come from, with --radio udp: natnet:HOST[:PORT], qtm:HOST[:PORT], vrpn:[BODY,…@]HOST[:PORT],
    /// ros2:[BODY=]/TOPIC[,…][@FRAME] or log:FILE [default: the scenario's, or water that is simulated in this process]
    #[arg(long, value_name = "SOURCE")]
    pub(super) pose: Option<Address>,
    #[command(flatten)]
    lab: LabArguments,
    /// This machine's address in the network of a NatNet server, where the operating system would choose another
    #[arg(long, value_name = "ADDRESS")]
    interface: Option<Ipv4Addr>,
}

/// How the laboratory lies.
#[derive(clap::Args)]
pub(super) struct LabArguments {
    /// The laboratory's axis that points up, instead of the scenario's
    #[arg(long, value_enum)]
    pub(super) up: Option<UpAxis>,
    /// The laboratory's unit, instead of the scenario's [default: mm with qtm, m with others]
    #[arg(long, value_enum)]
    pub(super) unit: Option<LengthUnit>,
}

/// Where poses of a real structure come from.
pub(super) enum Poses {
    /// A motion capture.
    Lab(Box<LabPoses>),
    /// A log.
    Logged(LoggedPoses),
}

impl LabArguments {
    /// Goes before what a scenario says.
    pub(super) fn apply(&self, parameters: &mut PoseParameters) {
        parameters.up = self.up.or(parameters.up);
        parameters.unit = self.unit.or(parameters.unit);
    }
}

impl PoseArguments {
    /// Goes before what a scenario says.
    pub(super) fn apply(&self, parameters: &mut PoseParameters) {
        self.lab.apply(parameters);
    }

    /// What was asked for, which sees the modules `seats` of `roster`.
    pub(super) fn open(
        &self,
        scenario: &Scenario,
        roster: &Roster,
        seats: &[ModuleId],
    ) -> Result<Option<Poses>, Failure> {
        let Some(address) = self.address(&scenario.pose)? else { return Ok(None) };
        if let Address::Log(path) = &address {
            return LoggedPoses::open(path).map(|poses| Some(Poses::Logged(poses))).map_err(Failure::Bad);
        }
        let axes = scenario.pose.axes(standard_unit(&address)).ok_or_else(no_up)?;
        let by_number = matches!(address, Address::NatNet(_));
        let bodies = roster.bodies(by_number, seats).map_err(bad)?;
        let positions_m = scenario.structure.positions_m(scenario.modboat.pitch_m);
        let places: Vec<(u16, Vector2<f64>)> =
            seats.iter().zip(positions_m).map(|(id, place)| (id.0, place.into())).collect();
        let structure = Structure::new(bodies.clone(), &places, Tolerances::default());
        let source = open(&address, self.interface)?;
        Ok(Some(Poses::Lab(Box::new(LabPoses::new(address.to_string(), source, axes, structure, bodies)))))
    }

    /// The motion capture that was asked for, which sees the robots and tools of a reconfiguration.
    pub(super) fn open_rovs(
        &self,
        scenario: &ReconfigureScenario,
        roster: &Roster,
        seats: &[ModuleId],
    ) -> Result<Option<LabBodies>, Failure> {
        let Some(address) = self.address(&scenario.pose)? else { return Ok(None) };
        if matches!(address, Address::Log(_)) {
            return Err(Failure::Bad(format!("{address}: a log steers no robots")));
        }
        let axes = scenario.pose.axes(standard_unit(&address)).ok_or_else(no_up)?;
        let by_number = matches!(address, Address::NatNet(_));
        let bodies = rov_bodies(&scenario.problem, roster, seats, by_number)?;
        let source = open(&address, self.interface)?;
        Ok(Some(LabBodies::new(address.to_string(), source, axes, bodies)))
    }

    /// What was asked for: `--pose` goes before the scenario.
    fn address(&self, pose: &PoseParameters) -> Result<Option<Address>, Failure> {
        let said = pose.source.as_deref().map(str::parse).transpose();
        let said = said.map_err(|error| Failure::Bad(format!("[pose] source: {error}")))?;
        Ok(self.pose.clone().or(said))
    }
}

/// Opens a motion capture; `interface` is this machine's address in its network.
pub(super) fn open(address: &Address, interface: Option<Ipv4Addr>) -> Result<Box<dyn Source>, Failure> {
    let options = Options { interface, ..Options::default() };
    address.open(options).map_err(|error| match error {
        OpenError::Source(_) | OpenError::Ros2 { .. } => could(error),
        OpenError::Resolve { .. } | OpenError::Log(_) => bad(error),
    })
}

/// Which bodies are the robots of a problem, which are the modules `seats` of `roster`, and then its tools, in order. Tools are called `tool-1`
/// and on, and numbered on behind the robot with the greatest number.
pub(super) fn rov_bodies(
    problem: &Problem,
    roster: &Roster,
    seats: &[ModuleId],
    by_number: bool,
) -> Result<Bodies, Failure> {
    let robots = roster.bodies(by_number, seats).map_err(bad)?;
    let robots = seats.iter().filter_map(|id| robots.entries().iter().find(|entry| entry.module == id.0));
    let greatest = seats.iter().map(|id| id.0).max().unwrap_or_default();
    let tools = (1..=problem.tools.len() as u16).map(|tool| {
        let module = greatest.saturating_add(tool);
        let body =
            if by_number { Name::Number(i32::from(module)) } else { Name::Name(format!("tool-{tool}")) };
        Entry { module, body, offset_m: Vector3::zeros(), turn_rad: 0.0 }
    });
    Bodies::new(robots.cloned().chain(tools).collect()).map_err(bad)
}

/// The ROVs of a roster file, or robots 1, 2, … where there is none; and which of them is which robot of `problem`.
pub(super) fn rovs(path: Option<&Path>, problem: &Problem) -> Result<(Roster, Vec<ModuleId>), Failure> {
    let count = problem.robots.len();
    let roster = match path {
        Some(path) => Roster::read(path).map_err(bad)?,
        None => Roster::numbered(count, ModuleKind::Rov),
    };
    let seats = roster.rov_seats(count).map_err(bad)?;
    Ok((roster, seats))
}

/// Axes are never guessed.
fn no_up() -> Failure {
    Failure::Bad(
        "[pose] up: say which axis of the laboratory points up, \"z\" or \"y\", in the scenario or by --up (flotilla probe \
         shows what fits)"
            .to_owned(),
    )
}
