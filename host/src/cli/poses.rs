//! `--pose` and what belongs to it: a motion capture, and how the world lies in its laboratory.

use std::net::Ipv4Addr;

use nalgebra::Vector2;
use pose::address::{Address, Options};
use pose::structure::{Structure, Tolerances};
use protocol::ModuleId;

use super::{Failure, bad, could};
use crate::run::lab::{LabPoses, standard_unit};
use crate::run::logged::LoggedPoses;
use crate::run::roster::Roster;
use crate::run::scenario::{LengthUnit, PoseParameters, Scenario, UpAxis};

#[derive(clap::Args)]
pub(super) struct PoseArguments {
    /// Where poses come from, with --radio udp: natnet:HOST[:PORT], qtm:HOST[:PORT], vrpn:[BODY,…@]HOST[:PORT] or
    /// log:FILE [default: the scenario's, or water that is simulated in this process]
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
        let said = scenario.pose.source.as_deref().map(str::parse).transpose();
        let said = said.map_err(|error| Failure::Bad(format!("[pose] source: {error}")))?;
        let Some(address) = self.pose.clone().or(said) else { return Ok(None) };
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
        let source = self.source(&address)?;
        Ok(Some(Poses::Lab(Box::new(LabPoses::new(address.to_string(), source, axes, structure, bodies)))))
    }

    fn source(&self, address: &Address) -> Result<Box<dyn pose::source::Source>, Failure> {
        use pose::address::OpenError;
        let options = Options { interface: self.interface, ..Options::default() };
        address.open(options).map_err(|error| match error {
            OpenError::Source(_) => could(error),
            OpenError::Resolve { .. } | OpenError::Log(_) => bad(error),
        })
    }
}

/// Axes are never guessed.
fn no_up() -> Failure {
    Failure::Bad(
        "[pose] up: say which axis of the laboratory points up, \"z\" or \"y\", in the scenario or by --up (flotilla probe \
         shows what fits)"
            .to_owned(),
    )
}
