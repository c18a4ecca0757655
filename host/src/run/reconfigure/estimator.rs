//! States of all bodies from their fixes, where nothing knows them exactly: an [`Observer`] for each robot and docked cluster, and a
//! [`Residual`] that finds thrusters that give nothing.
//!
//! ```text
//! fixes ────→ Observer of every cluster ──→ states of all bodies now, a_u ──→ Conductor
//! commands ─→ propellers as they should be ──↑      │
//!                                                    └→ Residual ──→ a thruster that gives nothing
//! ```
//!
//! Docked bodies are one: a fix of any of them is a fix of the cluster, but for one that is further than [`PLACED_M`] from where the others
//! have it: it has broken away, or its body was moved on it. What robots were told begins when the packet says, ends with its lease and is
//! followed with the propellers' lag.
//!
//! Assumptions and limits: commands arrive. One that is lost is one in five of a lease, and the fixes show the rest.

use std::collections::VecDeque;

use nalgebra::{UnitQuaternion, Vector3, Vector6};
use protocol::time::FleetInstant;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;
use rov::cluster::Cluster;
use rov::configuration::groups;
use rov::configuration_matrix::ConfigurationMatrix;
use rov::dynamics::{Dynamics, State};
use rov::guidance::observer::Observer;
use rov::guidance::residual::{Residual, TRIAL_S};
use sim::rov::basin::BasinError;
use sim::rov::propellers::LAG_S;

/// A body that is further from its place than this is not taken for docked there, m. *Assumed.*
pub const PLACED_M: f64 = 0.15;
/// Nor one that is turned by more, rad. *Assumed.*
pub const PLACED_RAD: f64 = 0.35;

/// What one frame of a motion capture shows of the bodies, robots first, north-east-down.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sighting {
    /// When it was captured, s of fleet time.
    pub at_s: f64,
    /// Place, m, and attitude of each body that was seen.
    pub bodies: Vec<Option<(Vector3<f64>, UnitQuaternion<f64>)>>,
}

/// What is seen of the bodies.
#[derive(Clone, Debug, PartialEq)]
pub enum Seen {
    /// Their states, as they are.
    Exact(Vec<State>),
    /// A fix.
    Fix(Sighting),
}

/// A robot or a tool.
#[derive(Clone, Debug)]
struct Body {
    vehicle: Vehicle,
    berth: Pose,
    docked: bool,
    seen_s: Option<f64>,
    misplaced: bool,
    /// Of each thruster, N: told, and given by now; and whether it works.
    told_n: Vec<f64>,
    given_n: Vec<f64>,
    works: Vec<bool>,
}

/// Docked bodies, or one alone.
#[derive(Clone, Debug)]
struct Group {
    members: Vec<usize>,
    /// Place and turn of each in the frame of the first.
    seats: Vec<(Vector3<f64>, UnitQuaternion<f64>)>,
    observer: Observer,
    residual: Residual,
}

/// What has become of a thruster: which robot's, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It may give nothing: nothing is to be asked of it for a while.
    Suspected(usize, usize),
    /// It does not: it is to be used again.
    Acquitted(usize, usize),
    /// It gives nothing.
    Dead(usize, usize),
}

/// A thruster that is out, to see what that changes.
#[derive(Clone, Copy, Debug)]
struct Trial {
    body: usize,
    thruster: usize,
    /// Which of its cluster.
    column: usize,
    ends_s: f64,
    charge: (Vector6<f64>, f64),
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Estimator {
    bodies: Vec<Body>,
    groups: Vec<Group>,
    /// Commands that wait for their time, s.
    coming: VecDeque<(f64, Vec<Vec<f64>>)>,
    /// When the newest command ends, s.
    lease_ends_s: f64,
    lease_s: f64,
    newest_s: Option<f64>,
    sighting: Sighting,
    states: Vec<State>,
    unknown: Vec<Vector6<f64>>,
    trial: Option<Trial>,
    /// A docked body that the newest fix showed elsewhere than its cluster.
    strayed: Option<usize>,
    /// A thruster of a robot that swims alone, which cannot do without it.
    suspect: Option<(usize, usize)>,
}

impl Estimator {
    /// Of bodies, robots first, each docked where it is; a command lasts for `lease_s`.
    ///
    /// # Errors
    /// [`BasinError`] for bodies that cannot be in water.
    pub fn new(bodies: &[(Pose, &Vehicle)], lease_s: f64) -> Result<Self, BasinError> {
        let body = |&(berth, vehicle): &(Pose, &Vehicle)| {
            let thrusters = vehicle.thrusters.len();
            Body {
                vehicle: vehicle.clone(),
                berth,
                docked: true,
                seen_s: None,
                misplaced: false,
                told_n: vec![0.0; thrusters],
                given_n: vec![0.0; thrusters],
                works: vec![true; thrusters],
            }
        };
        let mut estimator = Self {
            bodies: bodies.iter().map(body).collect(),
            groups: Vec::new(),
            coming: VecDeque::new(),
            lease_ends_s: 0.0,
            lease_s,
            newest_s: None,
            sighting: Sighting::default(),
            states: Vec::new(),
            unknown: Vec::new(),
            trial: None,
            strayed: None,
            suspect: None,
        };
        estimator.regroup()?;
        estimator.look();
        Ok(estimator)
    }

    /// States of all bodies.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// Accelerations of all bodies by what no model knows: linear part in the world, angular part in the body.
    #[must_use]
    pub fn unknown(&self) -> &[Vector6<f64>] {
        &self.unknown
    }

    /// The fix that was taken last.
    #[must_use]
    pub fn sighting(&self) -> &Sighting {
        &self.sighting
    }

    /// How old the newest fix is at `now`, s; infinite before the first.
    #[must_use]
    pub fn age_s(&self, now: FleetInstant) -> f64 {
        self.newest_s.map_or(f64::INFINITY, |newest_s| now.as_secs_f64() - newest_s)
    }

    /// A body that was not seen at all, or not where the plan has it.
    #[must_use]
    pub fn missing(&self) -> Option<usize> {
        self.bodies.iter().position(|body| body.seen_s.is_none() || body.misplaced)
    }

    /// A body that has not been seen for `after_s` at `now`, alone or docked to none that was.
    #[must_use]
    pub fn lost(&self, now: FleetInstant, after_s: f64) -> Option<usize> {
        let seen =
            |&body: &usize| self.bodies[body].seen_s.is_some_and(|at_s| now.as_secs_f64() - at_s <= after_s);
        self.groups.iter().find(|group| !group.members.iter().any(&seen))?.members.first().copied()
    }

    /// A docked body that the newest fix showed elsewhere than its cluster.
    #[must_use]
    pub fn strayed(&self) -> Option<usize> {
        self.strayed
    }

    /// Robots are told these thrusts, N, from `start` on.
    pub fn command(&mut self, start: FleetInstant, thrusts_n: &[Vec<f64>]) {
        self.lease_ends_s = start.as_secs_f64() + self.lease_s;
        self.coming.push_back((start.as_secs_f64(), thrusts_n.to_vec()));
    }

    /// A thruster of a robot that swims alone that may give nothing. Nothing is tried: without it the robot does not steer.
    #[must_use]
    pub fn suspect(&self) -> Option<(usize, usize)> {
        self.suspect
    }

    /// Lets `dt_s` pass until `now`. `begun`: nothing holds the bodies in their places. What has become of a thruster, if that is news.
    pub fn advance(&mut self, now: FleetInstant, dt_s: f64, begun: bool) -> Option<Verdict> {
        let now_s = now.as_secs_f64();
        while self.coming.front().is_some_and(|(start_s, _)| *start_s <= now_s) {
            let Some((_, thrusts_n)) = self.coming.pop_front() else { break };
            for (body, thrusts_n) in self.bodies.iter_mut().zip(thrusts_n) {
                body.told_n = thrusts_n;
            }
        }
        let (ended, follows) = (now_s > self.lease_ends_s, 1.0 - (-dt_s / LAG_S).exp());
        for body in &mut self.bodies {
            for ((given_n, told_n), works) in body.given_n.iter_mut().zip(&body.told_n).zip(&body.works) {
                let told_n = if ended { 0.0 } else { *told_n };
                *given_n = if *works { *given_n + (told_n - *given_n) * follows } else { 0.0 };
            }
        }
        let mut verdict = None;
        for group in &mut self.groups {
            let given_n: Vec<f64> =
                group.members.iter().flat_map(|&body| self.bodies[body].given_n.iter().copied()).collect();
            group.observer.advance(now_s, dt_s, begun.then_some(given_n.as_slice()));
            let wrench = group.observer.unknown_wrench();
            if let Some(trial) = self.trial.filter(|trial| group.members.contains(&trial.body)) {
                if now_s >= trial.ends_s {
                    let dead = Residual::is_explained(&trial.charge, &wrench);
                    let of = (trial.body, trial.thruster);
                    verdict =
                        Some(if dead { Verdict::Dead(of.0, of.1) } else { Verdict::Acquitted(of.0, of.1) });
                    if dead {
                        group.residual = Residual::new(given_n.len());
                    } else if trial.ends_s.is_finite() {
                        group.residual.clear(trial.column);
                    }
                }
                continue;
            }
            if !begun || self.trial.is_some() {
                continue;
            }
            let found = group.residual.update(dt_s, group.observer.matrix(), &wrench, &given_n);
            let Some(column) = found else { continue };
            let mut left = column;
            let of = group.members.iter().find_map(|&body| {
                let own = self.bodies[body].works.len();
                if left < own { Some((body, left)) } else { (left -= own, None).1 }
            });
            let Some((body, thruster)) = of else { continue };
            if group.members.len() == 1 {
                self.suspect = Some((body, thruster));
                continue;
            }
            // What it does not give is explained by that.
            let given = given_n.get(column).copied().unwrap_or(0.0);
            let lost = group.observer.matrix().matrix().column(column) * -given;
            group.observer.explain(&lost.into_owned());
            self.trial = Some(Trial {
                body,
                thruster,
                column,
                ends_s: now_s + TRIAL_S,
                charge: group.residual.charge(),
            });
            verdict = Some(Verdict::Suspected(body, thruster));
        }
        // Bodies that have let go or taken hold meanwhile have ended the trial.
        if verdict.is_none() && self.trial.is_some_and(|trial| now_s > trial.ends_s) {
            verdict = self.trial.map(|trial| Verdict::Acquitted(trial.body, trial.thruster));
        }
        match verdict {
            Some(Verdict::Suspected(body, thruster)) => self.bodies[body].works[thruster] = false,
            Some(Verdict::Acquitted(body, thruster)) => {
                (self.bodies[body].works[thruster], self.trial) = (true, None);
            }
            Some(Verdict::Dead(..)) => self.trial = None,
            None => {}
        }
        self.look();
        verdict
    }

    /// Takes a fix. A docked body that is far from where its cluster has it is no fix of the cluster.
    pub fn take(&mut self, sighting: &Sighting, begun: bool) {
        self.sighting.clone_from(sighting);
        for (body, seen) in self.bodies.iter_mut().zip(&sighting.bodies) {
            if let Some((position_m, attitude)) = seen {
                body.seen_s = Some(sighting.at_s);
                let level = UnitQuaternion::from_euler_angles(0.0, 0.0, body.berth.yaw_rad);
                let off_m = (position_m - Vector3::from(body.berth.position_m)).norm();
                body.misplaced = !begun && (off_m > PLACED_M || attitude.angle_to(&level) > PLACED_RAD);
            }
        }
        let mut any = false;
        self.strayed = None;
        for Group { members, seats, observer, .. } in &mut self.groups {
            let (mut count, mut position_m) = (0.0, Vector3::zeros());
            let held = observer.state().attitude;
            let mut turn = Vector3::zeros();
            for (&body, (arm, seat)) in members.iter().zip(seats.iter()) {
                let Some(Some((seen_m, attitude))) = sighting.bodies.get(body) else { continue };
                // Where the first body is if this one is there; an arm is laid on with the attitude that many fixes have made.
                let first = attitude * seat.inverse();
                let place_m = seen_m - held * arm;
                if begun && members.len() > 1 && (place_m - observer.state().position_m).norm() > PLACED_M {
                    self.strayed = Some(body);
                    continue;
                }
                position_m += place_m;
                turn += (held.inverse() * first).scaled_axis();
                count += 1.0;
            }
            if count > 0.0 {
                any = true;
                let attitude = held * UnitQuaternion::from_scaled_axis(turn / count);
                observer.take(sighting.at_s, &(position_m / count), &attitude);
            }
        }
        if any {
            self.newest_s = Some(self.newest_s.map_or(sighting.at_s, |newest_s| newest_s.max(sighting.at_s)));
        }
        self.look();
    }

    /// A body has let go of all that it held.
    ///
    /// # Errors
    /// [`BasinError`]; not for bodies that could be docked before.
    pub fn undock(&mut self, body: usize) -> Result<(), BasinError> {
        self.bodies[body].docked = false;
        self.regroup()?;
        self.look();
        Ok(())
    }

    /// A body has taken hold in `berth`.
    ///
    /// # Errors
    /// [`BasinError`] for a berth that is no place.
    pub fn dock(&mut self, body: usize, berth: Pose) -> Result<(), BasinError> {
        (self.bodies[body].berth, self.bodies[body].docked) = (berth, true);
        self.regroup()?;
        self.look();
        Ok(())
    }

    fn look(&mut self) {
        let still = State::from_eta(&[0.0; 6], &[0.0; 6]);
        self.states.resize(self.bodies.len(), still);
        self.unknown.resize(self.bodies.len(), Vector6::zeros());
        for Group { members, seats, observer, .. } in &self.groups {
            for (&body, (arm, turn)) in members.iter().zip(seats) {
                self.states[body] = observer.state().carried(arm, turn);
                let mut unknown = *observer.unknown();
                let angular: Vector3<f64> = unknown.fixed_rows::<3>(3).into();
                unknown.fixed_rows_mut::<3>(3).copy_from(&turn.inverse_transform_vector(&angular));
                self.unknown[body] = unknown;
            }
        }
    }

    fn regroup(&mut self) -> Result<(), BasinError> {
        let berths = self.bodies.iter().map(|body| body.docked.then_some((body.berth, &body.vehicle)));
        let groups = groups(&berths.collect::<Vec<_>>());
        self.groups = groups.into_iter().map(|members| self.group(members)).collect::<Result<_, _>>()?;
        self.suspect = None;
        if let Some(trial) = &mut self.trial {
            // Nothing can be compared any more.
            trial.ends_s = f64::NEG_INFINITY;
            trial.charge = (Vector6::zeros(), 0.0);
        }
        Ok(())
    }

    /// The members as one, by what the greatest of their groups until now knows.
    fn group(&self, members: Vec<usize>) -> Result<Group, BasinError> {
        let placed: Vec<(Pose, &Vehicle)> =
            members.iter().map(|&body| (self.bodies[body].berth, &self.bodies[body].vehicle)).collect();
        let origin = placed.first().map_or_else(Pose::default, |(pose, _)| *pose);
        let dynamics = Dynamics::new(&Cluster::new(&origin, &placed)?)?;
        let thrusters: Vec<(&Vehicle, Pose)> =
            placed.iter().map(|&(pose, vehicle)| (vehicle, pose)).collect();
        let matrix = ConfigurationMatrix::of_cluster(&thrusters, &origin)?;
        let level = UnitQuaternion::from_euler_angles(0.0, 0.0, origin.yaw_rad);
        let seats: Vec<(Vector3<f64>, UnitQuaternion<f64>)> = placed
            .iter()
            .map(|(pose, _)| {
                let arm = Vector3::from(pose.position_m) - Vector3::from(origin.position_m);
                let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, pose.yaw_rad - origin.yaw_rad);
                (level.inverse_transform_vector(&arm), turn)
            })
            .collect();
        let residual = Residual::new(matrix.thrusters());
        let known =
            self.groups.iter().filter(|group| members.iter().any(|body| group.members.contains(body)));
        let Some(known) = known.max_by_key(|group| group.members.len()) else {
            let state = State { position_m: origin.position_m.into(), attitude: level, nu: Vector6::zeros() };
            let observer = Observer::new(dynamics, matrix, state);
            return Ok(Group { members, seats, observer, residual });
        };
        // From the frame of the known group to a body that is in both, and on to the first of the members.
        let shared = members
            .iter()
            .enumerate()
            .find_map(|(index, body)| Some((index, known.members.iter().position(|member| member == body)?)));
        let (index, place) = shared.unwrap_or_default();
        let ((there, turned), (here, seat)) = (known.seats[place], seats[index]);
        let turn = turned * seat.inverse();
        let observer = known.observer.passed_on((dynamics, matrix), &(there - turn * here), &turn);
        Ok(Group { members, seats, observer, residual })
    }
}
