//! What a conductor is told of robots and water, and the thrusts that follow from all it knows.

use nalgebra::Vector6;
use reconfiguration::plan::ActionKind;
use rov::dynamics::State;

use super::super::ExecutionError;
use super::together::Together;
use super::{Conductor, Station};

impl Conductor<'_> {
    /// States are estimates from now on: a mover that is to dock keeps to this share of the tolerance.
    pub fn keep_within(&mut self, share: f64) {
        self.within = share;
    }

    /// Whether a thruster of a robot works, as far as is known: of one that does not no thrust is asked.
    ///
    /// # Errors
    /// As for [`new`](Self::new); not for thrusters that there are.
    pub fn set_working(
        &mut self,
        robot: usize,
        thruster: usize,
        working: bool,
    ) -> Result<(), ExecutionError> {
        if let Some(works) = self.working.get_mut(robot).and_then(|own| own.get_mut(thruster)) {
            *works = working;
        }
        if self.mover() == Some(robot) {
            self.mover = Some((robot, self.controller(&[robot], true)?));
        }
        if self.together.as_ref().is_some_and(|together| together.has(robot)) {
            let own = self.controller(&[robot], true)?;
            let mut all = self.together.iter_mut().flat_map(Together::controllers);
            if let Some((_, controller)) = all.find(|(other, _)| *other == robot) {
                *controller = own;
            }
        }
        self.station()
    }

    /// Tells what acts on every body that no model knows, as accelerations; see `TrackingController::oppose`.
    pub fn oppose(&mut self, unknown: &[Vector6<f64>]) {
        for Station { bodies, controller, .. } in &mut self.stations {
            controller.oppose(bodies.first().and_then(|&body| unknown.get(body)).copied());
        }
        if let Some((robot, controller)) = &mut self.mover {
            controller.oppose(unknown.get(*robot).copied());
        }
        for (robot, controller) in self.together.iter_mut().flat_map(Together::controllers) {
            controller.oppose(unknown.get(robot).copied());
        }
    }

    /// Thrusts that the tracking controllers want of every robot, N.
    pub(super) fn wanted_n(&self, states: &[State]) -> Result<Vec<Vec<f64>>, ExecutionError> {
        let robots = self.problem.robots.len();
        let mut thrusts_n: Vec<Vec<f64>> =
            self.bodies[..robots].iter().map(|(_, vehicle)| vec![0.0; vehicle.thrusters.len()]).collect();
        for Station { bodies, hold, controller } in &self.stations {
            let (together, _) = controller.thrusts_n(hold, hold, Some(&states[bodies[0]]))?;
            let mut rest = together.as_slice();
            for &body in bodies.iter().filter(|&&body| body < robots) {
                let (own, others) = rest.split_at(thrusts_n[body].len());
                thrusts_n[body].copy_from_slice(own);
                rest = others;
            }
        }
        if let Some((robot, controller)) = &self.mover {
            // As long as it is held, what it pushes for itself would push the whole cluster.
            let state = (self.trajectory.kind() != ActionKind::Undock).then(|| &states[*robot]);
            (thrusts_n[*robot], _) = controller.thrusts_n(&self.now(), &self.ahead(), state)?;
        }
        if let Some(together) = &self.together {
            for (robot, own_n) in together.wanted_n(states)? {
                thrusts_n[robot] = own_n;
            }
        }
        Ok(thrusts_n)
    }
}
