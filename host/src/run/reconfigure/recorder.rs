//! Collects what the execution of a plan leaves behind: samples of all bodies, and its [`Accounts`].

use protocol::time::FleetInstant;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use record::reconfigure::{RobotSample, Sample};
use rov::configuration_matrix::{ConfigurationMatrix, ThrusterError};
use sim::rov::RovActuation;

use super::super::RunError;
use super::super::closed_loop::{Observer, Run};
use super::super::fleet::Fleet;
use super::super::host::Controller;
use super::accounts::Accounts;
use super::conductor::PERIOD;
use super::controller::Execution;
use super::summary::MoveFigures;
use super::water::{ExactPoses, STEP, STEP_S, Water, is_step};

/// The closed loop of a reconfiguration with the fleet `F`.
pub type RovRun<'a, 'p, F> = Run<'a, Execution<'p>, F, Water, ExactPoses>;

/// See the module's documentation.
pub struct Recorder<'a> {
    accounts: Accounts,
    /// Of robots, then tools.
    vehicles: Vec<&'a Vehicle>,
    /// Of robots, about their own origins.
    matrices: Vec<ConfigurationMatrix>,
    samples: Vec<Sample>,
    /// The last sample is of the beginning of the next step, whose thrusts are not known yet.
    open: bool,
    /// The move that was under way when the step began, with its robot.
    moving: Option<(usize, usize)>,
}

impl<'a> Recorder<'a> {
    /// For these bodies, of which the first `robots` are robots.
    ///
    /// # Errors
    /// [`ThrusterError`] for a robot whose thrusters cannot be.
    pub fn new(
        accounts: Accounts,
        bodies: &[(Pose, &'a Vehicle)],
        robots: usize,
    ) -> Result<Self, ThrusterError> {
        let vehicles: Vec<&Vehicle> = bodies.iter().map(|(_, vehicle)| *vehicle).collect();
        let matrices = vehicles.iter().take(robots).map(|vehicle| ConfigurationMatrix::of_vehicle(vehicle));
        let matrices = matrices.collect::<Result<_, _>>()?;
        Ok(Self { accounts, vehicles, matrices, samples: Vec::new(), open: false, moving: None })
    }

    /// The samples, and the moves that were begun. The last sample is of the end, whenever that was.
    pub fn finish<F: Fleet<Actuation = RovActuation>>(
        mut self,
        now: FleetInstant,
        run: &RovRun<'_, '_, F>,
    ) -> (Vec<Sample>, Vec<MoveFigures>) {
        let t_s = plan_time_s(now, run);
        if self.samples.last().is_none_or(|last| last.t_s < t_s) {
            self.sample(t_s, run);
        }
        (self.samples, self.accounts.finish())
    }

    fn sample<F: Fleet<Actuation = RovActuation>>(&mut self, t_s: f64, run: &RovRun<'_, '_, F>) {
        let Some(water) = &run.world else { return };
        let (conductor, states) = (run.host.controller.conductor(), water.states());
        self.accounts.look(conductor, states, &self.vehicles);
        let reference = conductor.reference();
        let robots = (0..self.matrices.len()).map(|robot| RobotSample {
            eta: states[robot].eta(),
            nu: states[robot].nu.into(),
            tau: [0.0; 6],
            thrusts_n: Vec::new(),
            pulses_us: Vec::new(),
            power_w: 0.0,
            reference: reference.filter(|(mover, _)| *mover == robot).map(|(_, reference)| reference.pose),
            arrived: conductor.arrived()[robot],
        });
        let robots: Vec<RobotSample> = robots.collect();
        let tool = (robots.len() < states.len()).then_some(robots.len());
        let restoring_nm = tool.map_or([0.0; 2], |tool| water.restoring_nm(tool));
        self.samples.push(Sample { t_s, moving: conductor.moving(), restoring_nm, robots });
        self.note_thrusts(&run.actuation);
    }

    /// What robots do, in the last sample.
    fn note_thrusts(&mut self, actuation: &[RovActuation]) {
        let Some(Sample { robots, .. }) = self.samples.last_mut() else { return };
        for ((sample, matrix), RovActuation { thrusts_n, pulses_us }) in
            robots.iter_mut().zip(&self.matrices).zip(actuation)
        {
            (sample.tau, sample.power_w) = (matrix.wrench(thrusts_n), self.accounts.power_w(thrusts_n));
            sample.thrusts_n.clone_from(thrusts_n);
            sample.pulses_us.clone_from(pulses_us);
        }
    }
}

/// Time since the water let go, in whole steps, s; 0 before.
fn plan_time_s<F: Fleet>(now: FleetInstant, run: &RovRun<'_, '_, F>) -> f64 {
    let since_us = run.host.controller.origin().map_or(0, |origin| now.0.saturating_sub(origin.0));
    (since_us / u64::from(STEP.0)) as f64 * STEP_S
}

impl<F: Fleet<Actuation = RovActuation>> Observer<RovRun<'_, '_, F>> for Recorder<'_> {
    fn observe(&mut self, now: FleetInstant, run: &RovRun<'_, '_, F>) -> Result<(), RunError> {
        let controller = &run.host.controller;
        let Some(origin) = controller.origin().filter(|_| is_step(now)) else { return Ok(()) };
        if run.is_blind() {
            return Ok(());
        }
        let conductor = controller.conductor();
        if std::mem::take(&mut self.open) {
            self.note_thrusts(&run.actuation);
        }
        if let Some((number, mover)) = self.moving.filter(|_| now > origin) {
            self.accounts.spend(STEP_S, number, mover, &run.actuation);
            let ended = conductor.moving() != Some(number);
            if ended && let Some(misfit) = run.world.as_ref().and_then(Water::drawn_in) {
                self.accounts.end(number, misfit);
            }
        }
        self.moving = conductor.moving().zip(conductor.mover());
        if now >= origin && (now.0 - origin.0).is_multiple_of(u64::from(PERIOD.0)) {
            self.sample(plan_time_s(now, run), run);
            self.open = true;
        }
        Ok(())
    }
}
