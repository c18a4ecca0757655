//! The water of a reconfiguration with all robots and tools in it, and their poses as by a motion capture without noise.

use protocol::time::{Duration, FleetInstant};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::dynamics::State;
use sim::rov::RovActuation;
use sim::rov::basin::{Basin, BasinError, Misfit};

use super::super::RunError;
use super::super::closed_loop::World;
use super::super::pose_source::PoseSource;
use super::ExecutionError;
use super::conductor::{Coupling, DOCK_M, DOCK_RAD};
use super::estimator::Seen;

/// A step of water and controller: 200 Hz.
pub const STEP: Duration = Duration(5_000);
/// The same, s.
pub const STEP_S: f64 = 0.005;

/// Whether a step ends at `now`.
#[must_use]
pub const fn is_step(now: FleetInstant) -> bool {
    now.0.is_multiple_of(STEP.0 as u64)
}

/// See the module's documentation. Bodies are counted robots first, then tools.
pub struct Water {
    basin: Basin,
    states: Vec<State>,
    drawn_in: Option<Misfit>,
}

impl Water {
    /// Every body docked where it is.
    ///
    /// # Errors
    /// [`BasinError`] for bodies that cannot be in water.
    pub fn new(bodies: &[(Pose, &Vehicle)]) -> Result<Self, BasinError> {
        let basin = Basin::new(bodies)?;
        let states = (0..bodies.len()).map(|body| basin.state(body)).collect();
        Ok(Self { basin, states, drawn_in: None })
    }

    /// Lets the water flow, world, m/s.
    pub fn set_current(&mut self, current_m_s: [f64; 3]) {
        self.basin.set_current(current_m_s);
    }

    /// States of all bodies.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// How far from its slot, and turned, the robot was that connectors drew in last.
    #[must_use]
    pub fn drawn_in(&self) -> Option<&Misfit> {
        self.drawn_in.as_ref()
    }

    /// Restoring moments K and M (5) on the cluster of a body, N·m.
    #[must_use]
    pub fn restoring_nm(&self, body: usize) -> [f64; 2] {
        self.basin.restoring_nm(body)
    }

    fn look(&mut self) {
        for (body, state) in self.states.iter_mut().enumerate() {
            *state = self.basin.state(body);
        }
    }
}

impl World for Water {
    type Actuation = RovActuation;
    type Coupling = Coupling;

    /// Before the plan begins all bodies are held in their places.
    fn step(&mut self, now: FleetInstant, begun: bool, actuation: &[RovActuation]) {
        if begun && is_step(now) {
            self.basin.step(STEP_S, actuation);
            self.look();
        }
    }

    fn couple(&mut self, coupling: Coupling) -> Result<Option<Coupling>, RunError> {
        match coupling {
            Coupling::Undock(robot) => self.basin.undock(robot).map_err(ExecutionError::from)?,
            Coupling::Dock(robot, slot) => {
                let misfit = self.basin.misfit(robot, slot);
                let within = misfit.position_m <= DOCK_M && misfit.angle_rad <= DOCK_RAD;
                if !within {
                    return Ok(None);
                }
                self.basin.dock(robot, slot).map_err(ExecutionError::from)?;
                self.drawn_in = Some(misfit);
                self.look();
            }
        }
        Ok(Some(coupling))
    }
}

/// States of all bodies as they are.
pub struct ExactPoses(Seen);

impl Default for ExactPoses {
    fn default() -> Self {
        Self(Seen::Exact(Vec::new()))
    }
}

impl PoseSource<Water> for ExactPoses {
    type Pose = Seen;

    fn poll<'a>(
        &'a mut self,
        _: FleetInstant,
        water: Option<&'a Water>,
    ) -> Result<Option<&'a Seen>, RunError> {
        let (Some(water), Seen::Exact(states)) = (water, &mut self.0) else { return Ok(None) };
        states.clear();
        states.extend_from_slice(water.states());
        Ok(Some(&self.0))
    }
}
