//! The water that robots and tools are in: every connected cluster of them is one rigid body with six degrees of
//! freedom, pushed by the propellers of its members.
//!
//! ```text
//! M ν̇ + C(ν)ν + D(ν)ν + g(η) = Σ T u                     one cluster, by the classical Runge–Kutta method   (7), (16)
//! (P, L) = Σ (Pᵢ, Lᵢ + rᵢ × Pᵢ),   (Pᵢ, Lᵢ) = Mᵢ νᵢ      before and after robots let go or take hold
//! ```
//!
//! Bodies that let go keep the velocities of their places in the cluster. Bodies that take hold are drawn into place by
//! the connectors, and the new cluster has their momentum, that of the water that moves with them included
//! (Kirchhoff's impulse). Since M of a cluster is the sum of its members', letting go changes no momentum either.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Mᵢ, νᵢ | mass with added mass, and velocity, of member i | kg …; m/s, rad/s |
//! | P, L | linear and angular momentum about the cluster's origin | kg·m/s, kg·m²/s |
//! | rᵢ | member i from the cluster's origin | m |
//!
//! A steady, uniform current carries everything: (7) holds in the frame that drifts with it. A velocity that all members share passes
//! through the balance of momenta unchanged, so that it is drawn up over ground.
//!
//! Assumptions and limits: connectors are rigid and take hold at once; undocked robots do not touch; hulls do not
//! disturb each other's water.

use std::ops::{AddAssign, SubAssign};

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::cluster::{Cluster, ClusterError};
use rov::configuration::{groups, holds};
use rov::configuration_matrix::{ConfigurationMatrix, ThrusterError};
use rov::dynamics::{Dynamics, DynamicsError, State};
use thiserror::Error;

/// Longest step, s. The error of a step of 10 ms is far below what a propeller's lag makes.
pub const STEP_MOST_S: f64 = 0.010;

/// Errors of a [`Basin`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BasinError {
    /// A pose that is none.
    #[error(transparent)]
    Cluster(#[from] ClusterError),
    /// A body without mass.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// Bad thrusters.
    #[error(transparent)]
    Thruster(#[from] ThrusterError),
}

/// How far a body is from where connectors would hold it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Distance, m.
    pub position_m: f64,
    /// Angle, rad.
    pub angle_rad: f64,
}

/// A robot or a tool.
#[derive(Clone, Debug)]
struct Floating {
    vehicle: Vehicle,
    /// Mᵢ about its own origin.
    mass: Matrix6<f64>,
    /// Where it is docked, as the plan has it: the places of docked bodies relative to each other.
    berth: Pose,
    docked: bool,
}

/// Where a member sits in its raft's frame: place, m, and attitude.
type Seat = (Vector3<f64>, UnitQuaternion<f64>);

/// One rigid cluster, or one body alone.
#[derive(Clone, Debug)]
struct Raft {
    /// Indices of bodies; the first one's berth is the frame.
    members: Vec<usize>,
    /// Every member in that frame.
    seats: Vec<Seat>,
    dynamics: Dynamics,
    matrix: ConfigurationMatrix,
    state: State,
}

/// The water with all robots and tools in it, and their docked clusters.
#[derive(Clone, Debug)]
pub struct Basin {
    bodies: Vec<Floating>,
    rafts: Vec<Raft>,
    /// Velocity of the water, world, m/s.
    current_m_s: Vector3<f64>,
}

impl Basin {
    /// Bodies at rest; those whose connectors meet are docked.
    ///
    /// # Errors
    /// [`BasinError`].
    pub fn new(bodies: &[(Pose, &Vehicle)]) -> Result<Self, BasinError> {
        let floating = bodies.iter().map(|&(berth, vehicle)| {
            let alone = Cluster::of(&vehicle.body);
            let mass = alone.rigid_body_mass() + alone.added_mass();
            Floating { vehicle: vehicle.clone(), mass, berth, docked: true }
        });
        let mut basin = Self { bodies: floating.collect(), rafts: Vec::new(), current_m_s: Vector3::zeros() };
        basin.regroup()?;
        Ok(basin)
    }

    /// Lets the water flow with this velocity, the same everywhere and always, world, m/s.
    pub fn set_current(&mut self, current_m_s: [f64; 3]) {
        self.current_m_s = current_m_s.into();
    }

    /// Lets `dt_s` pass under the thrusts of every body, N; a tool's are none.
    pub fn step(&mut self, dt_s: f64, thrusts_n: &[impl AsRef<[f64]>]) {
        let mut together = Vec::new();
        for raft in &mut self.rafts {
            together.clear();
            for &member in &raft.members {
                together.extend(thrusts_n.get(member).into_iter().flat_map(AsRef::as_ref));
            }
            let tau = Vector6::from(raft.matrix.wrench(&together));
            let current_m_s = self.current_m_s;
            if current_m_s == Vector3::zeros() {
                raft.dynamics.advance(&mut raft.state, &tau, dt_s, STEP_MOST_S);
                continue;
            }
            // In the frame that drifts with it the water rests, and the same laws hold there.
            let flow = raft.state.attitude.inverse_transform_vector(&current_m_s);
            raft.state.nu.fixed_rows_mut::<3>(0).sub_assign(flow);
            raft.dynamics.advance(&mut raft.state, &tau, dt_s, STEP_MOST_S);
            raft.state.position_m += current_m_s * dt_s;
            let flow = raft.state.attitude.inverse_transform_vector(&current_m_s);
            raft.state.nu.fixed_rows_mut::<3>(0).add_assign(flow);
        }
    }

    /// Where a body is and how it moves.
    #[must_use]
    pub fn state(&self, body: usize) -> State {
        match self.seat(body) {
            Some((raft, (arm, turn))) => raft.state.carried(arm, turn),
            None => State::from_eta(&[0.0; 6], &[0.0; 6]),
        }
    }

    /// Restoring moments K and M (5) on the cluster of a body, about its origin in its own axes, N·m.
    #[must_use]
    pub fn restoring_nm(&self, body: usize) -> [f64; 2] {
        let Some((raft, (arm, turn))) = self.seat(body) else { return [0.0; 2] };
        let down = raft.state.attitude.inverse_transform_vector(&Vector3::z());
        let g = raft.dynamics.cluster().hydrostatics().restoring(&down);
        let (force, moment) = (g.fixed_rows::<3>(0).into_owned(), g.fixed_rows::<3>(3).into_owned());
        let there = turn.inverse_transform_vector(&(moment - arm.cross(&force)));
        [there.x, there.y]
    }

    /// A body lets go of all that it holds.
    ///
    /// # Errors
    /// [`BasinError`]; not for bodies that could be docked before.
    pub fn undock(&mut self, body: usize) -> Result<(), BasinError> {
        if let Some(floating) = self.bodies.get_mut(body) {
            floating.docked = false;
        }
        self.regroup()
    }

    /// How far a body is from `berth`, as that place is carried by the cluster it would be docked to.
    #[must_use]
    pub fn misfit(&self, body: usize, berth: Pose) -> Misfit {
        let level = |yaw_rad: f64| UnitQuaternion::from_euler_angles(0.0, 0.0, yaw_rad);
        let vehicle = &self.bodies[body].vehicle;
        let neighbour = (self.bodies.iter().enumerate()).find(|(other, floating)| {
            *other != body
                && floating.docked
                && holds((berth, vehicle), (floating.berth, &floating.vehicle)).is_some()
        });
        let (mut place, mut attitude) = (Vector3::from(berth.position_m), level(berth.yaw_rad));
        if let Some((other, floating)) = neighbour {
            let (state, turn) = (self.state(other), level(floating.berth.yaw_rad));
            let arm = turn.inverse_transform_vector(&(place - Vector3::from(floating.berth.position_m)));
            place = state.position_m + state.attitude * arm;
            attitude = state.attitude * (turn.inverse() * attitude);
        }
        let state = self.state(body);
        Misfit {
            position_m: (state.position_m - place).norm(),
            angle_rad: state.attitude.angle_to(&attitude),
        }
    }

    /// A body is drawn into `berth` and held there.
    ///
    /// # Errors
    /// [`BasinError`] for a berth that is no place.
    pub fn dock(&mut self, body: usize, berth: Pose) -> Result<(), BasinError> {
        if let Some(floating) = self.bodies.get_mut(body) {
            (floating.berth, floating.docked) = (berth, true);
        }
        self.regroup()
    }

    fn seat(&self, body: usize) -> Option<(&Raft, &Seat)> {
        self.rafts.iter().find_map(|raft| {
            let index = raft.members.iter().position(|&member| member == body)?;
            Some((raft, &raft.seats[index]))
        })
    }

    /// Forms the clusters again after an undocking or a docking.
    fn regroup(&mut self) -> Result<(), BasinError> {
        let berths = self.bodies.iter().map(|body| body.docked.then_some((body.berth, &body.vehicle)));
        let groups = groups(&berths.collect::<Vec<_>>());
        let rafts = groups.into_iter().map(|members| self.raft(members)).collect::<Result<_, _>>()?;
        self.rafts = rafts;
        Ok(())
    }

    /// The members as one body that has their momentum, in the place of the largest cluster among them.
    fn raft(&self, members: Vec<usize>) -> Result<Raft, BasinError> {
        let placed: Vec<(Pose, &Vehicle)> =
            members.iter().map(|&body| (self.bodies[body].berth, &self.bodies[body].vehicle)).collect();
        let origin = placed.first().map(|(pose, _)| *pose).ok_or(ClusterError::Empty)?;
        let dynamics = Dynamics::new(&Cluster::new(&origin, &placed)?)?;
        let thrusters: Vec<(&Vehicle, Pose)> =
            placed.iter().map(|&(pose, vehicle)| (vehicle, pose)).collect();
        let matrix = ConfigurationMatrix::of_cluster(&thrusters, &origin)?;
        let level = UnitQuaternion::from_euler_angles(0.0, 0.0, origin.yaw_rad);
        let seats: Vec<Seat> = placed
            .iter()
            .map(|(pose, _)| {
                let arm = Vector3::from(pose.position_m) - Vector3::from(origin.position_m);
                let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, pose.yaw_rad - origin.yaw_rad);
                (level.inverse_transform_vector(&arm), turn)
            })
            .collect();
        let state = State { position_m: origin.position_m.into(), attitude: level, nu: Vector6::zeros() };
        let mut raft = Raft { members, seats, dynamics, matrix, state };
        let size = |body: &usize| self.seat(*body).map_or(0, |(raft, _)| raft.members.len());
        // The last of the greatest, turned round: the first.
        let lead = raft.members.iter().enumerate().rev().max_by_key(|(_, body)| size(body));
        let Some((index, &lead)) = lead.filter(|_| !self.rafts.is_empty()) else { return Ok(raft) };
        let (was, (arm, turn)) = (self.state(lead), raft.seats[index]);
        raft.state.attitude = was.attitude * turn.inverse();
        raft.state.position_m = was.position_m - raft.state.attitude * arm;
        // (P, L) = Σ (Pᵢ, Lᵢ + rᵢ × Pᵢ)
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        for &member in &raft.members {
            let (p, l) = self.momentum(member);
            linear += p;
            angular += l + (self.state(member).position_m - raft.state.position_m).cross(&p);
        }
        let (p, l) = (
            raft.state.attitude.inverse_transform_vector(&linear),
            raft.state.attitude.inverse_transform_vector(&angular),
        );
        let momentum = Vector6::new(p.x, p.y, p.z, l.x, l.y, l.z);
        // M is positive definite: Dynamics has seen to that.
        raft.state.nu =
            raft.dynamics.mass_matrix().cholesky().map(|factor| factor.solve(&momentum)).unwrap_or_default();
        Ok(raft)
    }

    /// Mᵢ νᵢ of a body about its own origin, world.
    fn momentum(&self, body: usize) -> (Vector3<f64>, Vector3<f64>) {
        let state = self.state(body);
        let own = self.bodies[body].mass * state.nu;
        (state.attitude * own.fixed_rows::<3>(0), state.attitude * own.fixed_rows::<3>(3))
    }
}

#[cfg(test)]
mod tests;
