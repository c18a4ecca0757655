//! What the [closed loop](super::closed_loop) of Modboats is made of: the tank is its water, simulated cameras tell its poses.

use std::convert::Infallible;

use modboat::observer::Fix;
use protocol::time::FleetInstant;
use sim::TailState;
use sim::mocap::Mocap;
use sim::module::TICK;
use sim::tank::Tank;

use super::RunError;
use super::closed_loop::{Run, World};
use super::pilot::Pilot;
use super::pose_source::PoseSource;

/// A run of Modboats with the fleet `F` and poses from `P`.
pub type BoatRun<'a, F, P = Cameras> = Run<'a, Pilot, F, Tank, P>;

impl World for Tank {
    type Actuation = TailState;
    type Coupling = Infallible;

    fn step(&mut self, _now: FleetInstant, _begun: bool, tails: &[TailState]) {
        self.step(f64::from(TICK.as_secs_f32()), tails);
    }

    fn skip(&mut self, now: FleetInstant) {
        // Less the step that follows.
        self.skip(now.as_secs_f64() - f64::from(TICK.as_secs_f32()));
    }

    fn couple(&mut self, never: Infallible) -> Result<Option<Infallible>, RunError> {
        match never {}
    }
}

/// Simulated motion capture of the tank.
pub struct Cameras {
    mocap: Mocap,
    fix: Option<Fix>,
}

impl Cameras {
    /// That have not looked yet.
    #[must_use]
    pub fn new(mocap: Mocap) -> Self {
        Self { mocap, fix: None }
    }
}

impl PoseSource<Tank> for Cameras {
    type Pose = Fix;

    fn poll<'a>(&'a mut self, _: FleetInstant, tank: Option<&'a Tank>) -> Result<Option<&'a Fix>, RunError> {
        let Some(pose) = tank.map(Tank::pose) else { return Ok(None) };
        self.fix = self.mocap.sample(pose.t_s, &pose);
        Ok(self.fix.as_ref())
    }
}
