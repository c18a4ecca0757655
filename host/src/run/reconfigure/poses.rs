//! Poses of robots and tools from a motion capture: each its own body, in six degrees of freedom.
//!
//! ```text
//! Source ─ frames → Gate ─ bodies in the world, on the host's clock → roster, north-east-down → Estimator
//! ```
//!
//! A frame shows nothing while two labels are swapped, or in which a vehicle is where it cannot have swum ([`Vehicles`]): so a run with
//! swapped labels is blind, says why, and holds.

use nalgebra::{UnitQuaternion, Vector3};
use pose::axes::{Axes, Pose, swap_world_and_ned};
use pose::feed::Event;
use pose::frame::Arrival;
use pose::gate::{Fix, Gate, Limits};
use pose::roster::Roster;
use pose::source::Source;
use pose::time::HostInstant;
use pose::vehicles::Vehicles;
use protocol::time::FleetInstant;
use sim::lab::Cameras;

use super::super::RunError;
use super::super::pose_source::{PoseAccount, PoseSource};
use super::super::stream::{Doubt, Stream};
use super::estimator::{Seen, Sighting};
use super::water::Water;

/// What is made of frames.
struct Sightings {
    /// In the order of the problem: robots, then tools.
    roster: Roster,
    vehicles: Vehicles,
    seen: Seen,
}

impl Sightings {
    fn new(roster: Roster) -> Self {
        let vehicles = Vehicles::new(roster.clone(), pose::vehicles::Limits::default());
        Self { roster, vehicles, seen: Seen::Fix(Sighting::default()) }
    }

    /// Takes in a frame.
    fn take(&mut self, fix: &Fix) -> Result<(), String> {
        let found = self.vehicles.take(fix);
        if let Some((first, second)) = found.swapped.first() {
            return Err(format!("the bodies of modules {first} and {second} have each other's label"));
        }
        if let Some(module) = found.carried.first() {
            return Err(format!("module {module} is where it cannot have swum"));
        }
        let entries = self.roster.entries();
        let mut bodies: Vec<Option<(Vector3<f64>, UnitQuaternion<f64>)>> = vec![None; entries.len()];
        for (label, said) in &fix.bodies {
            let Some(body) = self.roster.place_of(label) else { continue };
            let Pose { position, attitude } = entries[body].vehicle(&swap_world_and_ned(said));
            bodies[body] = Some((position, attitude));
        }
        if bodies.iter().all(Option::is_none) {
            return Err("no body of the roster is tracked".to_owned());
        }
        self.seen = Seen::Fix(Sighting { at_s: fix.captured_s, bodies });
        Ok(())
    }
}

/// Of a motion capture.
pub struct LabBodies {
    stream: Stream,
    sightings: Sightings,
}

impl LabBodies {
    /// Of the bodies of `roster`, robots then tools, in a laboratory with these axes.
    #[must_use]
    pub fn new(name: String, source: Box<dyn Source>, axes: Axes, roster: Roster) -> Self {
        Self { stream: Stream::new(name, source, axes), sightings: Sightings::new(roster) }
    }
}

impl<W> PoseSource<W> for LabBodies {
    type Pose = Seen;

    fn poll<'a>(&'a mut self, now: FleetInstant, _: Option<&'a W>) -> Result<Option<&'a Seen>, RunError> {
        let Self { stream, sightings } = self;
        let is_new = stream.poll(now, |_, fix| sightings.take(fix))?;
        Ok(is_new.then_some(&sightings.seen))
    }

    fn trouble(&self) -> Option<&str> {
        self.stream.trouble()
    }

    fn account(&self) -> Option<PoseAccount> {
        Some(self.stream.account())
    }
}

/// Of simulated cameras over the water of this process: in simulated time, with all that goes wrong in a laboratory.
pub struct SimulatedBodies {
    cameras: Cameras,
    gate: Gate,
    doubt: Doubt,
    sightings: Sightings,
}

impl SimulatedBodies {
    /// Of the bodies of `roster`, robots then tools, by `cameras` in a laboratory with these axes.
    #[must_use]
    pub fn new(cameras: Cameras, axes: Axes, roster: Roster) -> Self {
        let gate = Gate::new(axes, Limits::default());
        Self { cameras, gate, doubt: Doubt::default(), sightings: Sightings::new(roster) }
    }
}

/// Every body in the world of the cameras: east, north, up.
fn in_the_world(states: &[rov::dynamics::State]) -> Vec<Pose> {
    let ned = |state: &rov::dynamics::State| Pose { position: state.position_m, attitude: state.attitude };
    states.iter().map(|state| swap_world_and_ned(&ned(state))).collect()
}

impl PoseSource<Water> for SimulatedBodies {
    type Pose = Seen;

    fn poll<'a>(
        &'a mut self,
        now: FleetInstant,
        water: Option<&'a Water>,
    ) -> Result<Option<&'a Seen>, RunError> {
        let Some(water) = water else { return Ok(None) };
        self.cameras.look(now.as_secs_f64(), &in_the_world(water.states()));
        let arrived = HostInstant(std::time::Duration::from_micros(now.0));
        let mut is_new = false;
        while let Some(frame) = self.cameras.poll(now.as_secs_f64()) {
            let event = self.gate.take(&Arrival { frame, arrived }).map_or_else(Event::Dropped, Event::Fix);
            is_new |= self.doubt.judge(event, |fix| self.sightings.take(fix));
        }
        Ok(is_new.then_some(&self.sightings.seen))
    }

    fn trouble(&self) -> Option<&str> {
        self.doubt.trouble()
    }
}
