//! Tracking controller: from reference and state to thrusts, for a robot and for a docked cluster.
//!
//! ```text
//! τ = M (ν̇_r + K (ν_d − ν) − a_u) + C(ν_r)ν_r + D(ν_r)ν_r + g(level)  after (7)
//! u = least power within limits with T u = τ                            (9), (16)
//! ν_d = [ Rᵀ v_d ; Rᵀ ω_r − ω_p e_R ],   K = diag(2ω),   ω_p = ω/2
//! ```
//!
//! | symbol | meaning | frame, unit |
//! |---|---|---|
//! | ν_r, ν̇_r | velocity and acceleration of the reference, turned into the body as it is | body |
//! | v_d | velocity demanded by LOS guidance, [`super::los`] | world, m/s |
//! | R, e_R | attitude; turn from the attitude wanted (level, heading of the reference) to it, as a vector | body; rad |
//! | K, ω_p | gain of the velocity, of the position | 1/s |
//! | a_u | acceleration by what no model knows, [`super::observer`]; none where it is not observed | m/s², rad/s² |
//! | ω | bandwidth | rad/s |
//! | T_d | delay from a measurement to the thrust that answers it | s |
//!
//! **Feedforward** is what the planner counted, so that a robot on its path draws what was planned. It is that of the
//! instant at which the thrusts will act. ν_r stands in the body as it *is*: a hull that has pitched by θ at speed u moves
//! down its own axis with u sin θ, and C(ν_r)ν_r holds against the Munk moment (Z_ẇ − X_u̇)uw that would pitch it on.
//!
//! **Gains.** With M taken out, each axis is a double integrator under −2ω(v − v_d), v_d = −½ω e: s² + 2ωs + ω², two
//! poles at ω. The open loop (2ωs + ω²)/s² crosses one at 2.06 ω with a margin of 76°, of which the delay takes
//! 2.06 ω T_d. ω T_d = [`POSITION`] leaves 53°, ω T_d = [`ATTITUDE`] leaves 41°: attitude has the faster disturbances.
//!
//! Errors of less than [`STILL_M`], [`STILL_RAD`] are not answered: thrust about zero would have the propellers turn
//! round again and again. Thrusts below [`LEAST_N`] are not sent: no T200 gives them.
//!
//! **Integral action** is that of the observer: a_u is the integral of what the fixes miss of the model under the thrusts that were
//! commanded, limits included, so that a demand out of reach winds nothing up.
//!
//! Assumptions and limits: the state is known, velocity included. Without an observer a force F that no model knows leaves an error of
//! F/(m ω²), and a steady current leaves one too.

use nalgebra::{UnitQuaternion, Vector3, Vector6};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use thiserror::Error;

use super::super::allocation::{AllocationError, Allocator};
use super::super::cluster::{Cluster, ClusterError};
use super::super::configuration_matrix::{ConfigurationMatrix, ThrusterError};
use super::super::dynamics::{Dynamics, DynamicsError, State, coriolis};
use super::super::power::PowerLaw;
use super::los;
use super::reference::Reference;

/// Product ω T_d of bandwidth and delay, for position.
pub const POSITION: f64 = 0.2;
/// Product ω T_d of bandwidth and delay, for attitude.
pub const ATTITUDE: f64 = 0.3;
/// Position errors not answered, m. *Assumed*.
pub const STILL_M: f64 = 5e-4;
/// Attitude errors not answered, rad. *Assumed*: a tenth of a degree.
pub const STILL_RAD: f64 = 1.7e-3;
/// Thrusts not sent, N: the table's first row beyond the dead band.
pub const LEAST_N: f64 = 0.01;
/// Attitude errors are answered as if they were smaller than this, rad. *Assumed*.
const ATTITUDE_MOST_RAD: f64 = 0.5;

/// Why these bodies cannot be controlled.
#[derive(Debug, Error)]
pub enum TrackingError {
    /// No cluster.
    #[error(transparent)]
    Cluster(#[from] ClusterError),
    /// No mass.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// Bad thrusters.
    #[error(transparent)]
    Thruster(#[from] ThrusterError),
    /// Bad limits, or a demand that is no number.
    #[error(transparent)]
    Allocation(#[from] AllocationError),
}

/// Tracking controller of one robot or docked cluster; the law is in the module's documentation.
#[derive(Clone, Debug)]
pub struct TrackingController {
    dynamics: Dynamics,
    allocator: Allocator,
    delay_s: f64,
    /// a_u: linear part in the world, angular part in the body.
    unknown: Option<Vector6<f64>>,
}

impl TrackingController {
    /// For docked bodies (level poses in the world, tools among them), steered about the pose of the first. `limits_n`
    /// are those of every thruster, body after body; `delay_s` is T_d.
    pub fn new(
        members: &[(Pose, &Vehicle)],
        limits_n: &[(f64, f64)],
        law: PowerLaw,
        delay_s: f64,
    ) -> Result<Self, TrackingError> {
        let origin = members.first().map(|(pose, _)| *pose).ok_or(ClusterError::Empty)?;
        let dynamics = Dynamics::new(&Cluster::new(&origin, members)?)?;
        let thrusters: Vec<(&Vehicle, Pose)> =
            members.iter().map(|&(pose, vehicle)| (vehicle, pose)).collect();
        let matrix = ConfigurationMatrix::of_cluster(&thrusters, &origin)?;
        let depths = members.iter().map(|(pose, _)| pose.position_m[2] - origin.position_m[2]);
        let depth_m = depths.sum::<f64>() / members.len() as f64;
        let stable = dynamics.cluster().hydrostatics().stiffness_nm(depth_m) > 0.0;
        // What no thruster can turn, stability does: the demand there is nothing that others should give way to.
        let passive_nm = if stable { f64::INFINITY } else { 0.0 };
        let allocator = Allocator::new(matrix, limits_n, law)?.with_passive(passive_nm);
        Ok(Self { dynamics, allocator, delay_s, unknown: None })
    }

    /// Tells a_u as [`Observer::unknown`](super::observer::Observer::unknown) has it, for all that follows.
    pub fn oppose(&mut self, unknown: Option<Vector6<f64>>) {
        self.unknown = unknown;
    }

    /// τ: `now` is the reference of this instant, `ahead` that of when the thrusts act. Without a state, feedforward alone.
    #[must_use]
    pub fn demand(&self, now: &Reference, ahead: &Reference, state: Option<&State>) -> [f64; 6] {
        let mass = self.dynamics.mass_matrix();
        let wanted = UnitQuaternion::from_euler_angles(0.0, 0.0, now.pose.yaw_rad);
        let attitude = state.map_or(wanted, |state| state.attitude);
        let in_body = |v: &[f64; 3]| attitude.inverse_transform_vector(&Vector3::from(*v));
        let turning = |rate: f64| attitude.inverse_transform_vector(&Vector3::new(0.0, 0.0, rate));
        let nu_r = joined(&in_body(&ahead.velocity_m_s), &turning(ahead.yaw_rate_rad_s));
        let mut nu_dot = joined(&in_body(&ahead.acceleration_m_s2), &turning(ahead.yaw_acceleration_rad_s2));
        if let Some(state) = state {
            let (position, turn) = (POSITION / self.delay_s, ATTITUDE / self.delay_s);
            let off_m = beyond(&(state.position_m - Vector3::from(now.pose.position_m)), STILL_M);
            let v_d = los::velocity(&off_m, &now.velocity_m_s.into(), 0.5 * position);
            let e_r = beyond(&(wanted.inverse() * attitude).scaled_axis(), STILL_RAD);
            let e_r = e_r / (1.0 + (e_r.norm() / ATTITUDE_MOST_RAD).powi(2)).sqrt();
            let omega_d = turning(now.yaw_rate_rad_s) - 0.5 * turn * e_r;
            // K (ν_d − ν)
            let miss = joined(&in_body(&v_d.into()), &omega_d) - state.nu;
            let gains = joined(&Vector3::repeat(2.0 * position), &Vector3::repeat(2.0 * turn));
            nu_dot += gains.component_mul(&miss);
            if let Some(unknown) = &self.unknown {
                let [linear, angular]: [Vector3<f64>; 2] =
                    [unknown.fixed_rows::<3>(0).into(), unknown.fixed_rows::<3>(3).into()];
                nu_dot -= joined(&in_body(&linear.into()), &angular);
            }
        }
        let steady = Vector6::from(self.dynamics.cluster().force_needed(&nu_r.into()));
        // τ = M (ν̇_r + K (ν_d − ν)) + C(ν_r)ν_r + D(ν_r)ν_r + g(level)
        (mass * nu_dot + coriolis(mass, &nu_r) * nu_r + steady).into()
    }

    /// Thrusts for that, N, and the share of it that they serve.
    ///
    /// # Errors
    /// [`TrackingError::Allocation`] for a state or reference that is no number.
    pub fn thrusts_n(
        &self,
        now: &Reference,
        ahead: &Reference,
        state: Option<&State>,
    ) -> Result<(Vec<f64>, f64), TrackingError> {
        let mut allocation = self.allocator.allocate(&self.demand(now, ahead, state))?;
        for thrust_n in &mut allocation.thrusts_n {
            if thrust_n.abs() < LEAST_N {
                *thrust_n = 0.0;
            }
        }
        Ok((allocation.thrusts_n, allocation.served))
    }
}

fn joined(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// What of an error is larger than `still`.
fn beyond(error: &Vector3<f64>, still: f64) -> Vector3<f64> {
    let size = error.norm();
    if size > still { error * ((size - still) / size) } else { Vector3::zeros() }
}

#[cfg(test)]
mod tests {
    use reconfiguration::problem::Rules;

    use super::super::super::balance::balance;
    use super::super::super::power::limits_n;
    use super::super::super::propulsion::{Propulsion, Steady};
    use super::*;

    const DELAY_S: f64 = 0.145;

    fn vehicle(name: &str) -> Vehicle {
        Vehicle::built_in(name).expect("built in")
    }

    fn controller(members: &[(Pose, &Vehicle)]) -> TrackingController {
        let limits = limits_n(16.0).expect("in the table");
        let count = members.iter().map(|(_, vehicle)| vehicle.thrusters.len()).sum();
        let law = PowerLaw::fitted(16.0).expect("in the table");
        TrackingController::new(members, &vec![limits; count], law, DELAY_S).expect("a controller")
    }

    /// On its path a robot is asked for exactly what the planner counted.
    #[test]
    fn on_its_path_the_demand_is_the_planners() {
        let robot = vehicle("bluerov1");
        let pose = Pose::from([1.0, 2.0, 3.0, 0.7]);
        let controller = controller(&[(pose, &robot)]);
        let law = PowerLaw::fitted(16.0).expect("in the table");
        let propulsion = Propulsion::new(&robot, law, &Rules::default(), Steady::Whole).expect("six");
        let turned = |v: [f64; 3]| {
            let q = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.7);
            <[f64; 3]>::from(q * Vector3::from(v))
        };
        let reference = Reference {
            pose,
            velocity_m_s: turned([0.3, -0.1, 0.05]),
            acceleration_m_s2: turned([0.2, 0.0, 0.1]),
            ..Reference::default()
        };
        let nu = [0.3, -0.1, 0.05, 0.0, 0.0, 0.0];
        let state = State {
            position_m: pose.position_m.into(),
            attitude: UnitQuaternion::from_euler_angles(0.0, 0.0, 0.7),
            nu: nu.into(),
        };
        let asked = controller.demand(&reference, &reference, Some(&state));
        let counted = propulsion.wrench(&nu, &[0.2, 0.0, 0.1, 0.0, 0.0, 0.0]);
        for axis in 0..6 {
            assert!((asked[axis] - counted[axis]).abs() < 1e-9, "{asked:?} {counted:?}");
        }
    }

    /// A cluster in its place pushes what the plan lets it push.
    #[test]
    fn a_waiting_cluster_in_its_place_balances_as_planned() {
        let (robot, tool) = (vehicle("bluerov1"), vehicle("tool-20n"));
        let members = [
            (Pose::from([0.0, -0.33, 0.0, 0.0]), &robot),
            (Pose::from([0.0, 0.33, 0.0, 0.0]), &robot),
            (Pose::from([0.0, 0.0, 0.0, 0.0]), &tool),
        ];
        let law = PowerLaw::fitted(16.0).expect("in the table");
        let planned = balance(&members, &law, limits_n(16.0).expect("in the table"), &Rules::default())
            .expect("balanced");
        let here = Reference::at_rest(members[0].0);
        let state = State::from_eta(&[0.0, -0.33, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]);
        let (thrusts_n, served) =
            controller(&members).thrusts_n(&here, &here, Some(&state)).expect("numbers");
        assert!(served > 1.0 - 1e-9 && planned.power_w > 1.0);
        for (thrust_n, planned_n) in thrusts_n.iter().zip(planned.thrusts_n.concat()) {
            // The least thrust is not sent.
            assert!((thrust_n - planned_n).abs() <= LEAST_N, "{thrusts_n:?} {:?}", planned.thrusts_n);
        }
    }

    /// Pushed aside, turned and pitched at speed, it comes back to its path: with the delay, as an exact pure one.
    #[test]
    fn comes_back_to_its_path_in_spite_of_the_delay() {
        let robot = vehicle("bluerov1");
        let pose = Pose::default();
        let controller = controller(&[(pose, &robot)]);
        let dynamics = Dynamics::new(&Cluster::of(&robot.body)).expect("a body");
        let matrix = ConfigurationMatrix::of_vehicle(&robot).expect("thrusters");
        for speed in [0.0, 0.3, 0.5] {
            let mut state =
                State::from_eta(&[-0.1, 0.15, 0.1, 0.1, 0.2, -0.3], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let at = |t_s: f64| Reference {
                pose: Pose { position_m: [speed * t_s, 0.0, 0.0], yaw_rad: 0.0 },
                velocity_m_s: [speed, 0.0, 0.0],
                ..Reference::default()
            };
            // Commands act 29 steps of 5 ms after they are computed.
            let mut queue = std::collections::VecDeque::from(vec![vec![0.0; 6]; 29]);
            let mut worst = 0.0_f64;
            for step in 0..4_000 {
                let t_s = f64::from(step) * 0.005;
                let (thrusts_n, _) =
                    controller.thrusts_n(&at(t_s), &at(t_s + DELAY_S), Some(&state)).expect("numbers");
                queue.push_back(thrusts_n);
                let acting = queue.pop_front().expect("29 waiting");
                dynamics.step(&mut state, &matrix.wrench(&acting).into(), 0.005);
                if t_s > 12.0 {
                    let off = (state.position_m - Vector3::from(at(t_s + 0.005).pose.position_m)).norm();
                    worst = worst.max(off).max(state.attitude.angle());
                }
            }
            println!("{speed} m/s: {worst:.4} m or rad");
            assert!(worst < 8e-3, "{speed} m/s: {worst} m or rad");
        }
    }
}
