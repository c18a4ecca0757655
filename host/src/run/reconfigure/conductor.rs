//! What is to be done along a plan: which action is under way, where each robot is to be, which thrusts that takes.
//!
//! ```text
//! states → Conductor → thrusts of every robot, to be sent
//!              ↓ a robot lets go, a robot takes hold
//! ```
//!
//! - The mover follows the [`ReferenceTrajectory`] of its action; every cluster of the others keeps its place, level, at least power
//!   over all of its thrusters (16). A thruster whose robot does not answer counts as one of no thrust.
//! - An action ends when its time is over and the mover is where it should be: within [`DOCK_M`] and [`DOCK_RAD`].
//! - **Hand-over.** Before a robot lets go, its share of the balance passes to the others: undocking takes at least
//!   [`HAND_OVER_S`]. Both the old and the new thrusts balance the cluster, so all mixtures do, and nothing tilts while
//!   the propellers change speed.
//! - Commands lead the propellers' lag (`lead`).
//! - A mover that is further than [`ASTRAY_M`] from its reference, or does not answer, is waited for: its reference
//!   rests until it is there again, then goes on from rest.
//! - So it is while a robot has drifted towards the edge of the water (`edge`).
//! - Moves that overlap in time follow the time of the plan, which all of them share (`together`).
//! - What takes longer than [`PATIENCE_S`] fails, by name. So does a waiting cluster that is pushed away or tilted.
//!
//! Assumptions and limits: position, attitude and velocity of every robot are taken for known. Where they are estimates, a mover that is
//! to dock keeps to a part of the tolerance ([`Conductor::keep_within`]).

mod edge;
mod failure;
mod fit;
mod known;
mod lead;
mod together;

pub use failure::Failure;
pub use together::Followed;

use super::ExecutionError;
use fit::check;
use lead::Lead;
use protocol::time::Duration;
use reconfiguration::plan::{Action, ActionKind, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;
use rov::configuration::{adjacency, clusters};
pub use rov::docking::HAND_OVER_S;
use rov::dynamics::State;
use rov::guidance::reference::{Reference, ReferenceTrajectory};
use rov::guidance::tracking::{TrackingController, TrackingError};
use rov::power::{self, PowerLaw};
use sim::rov::propellers::LAG_S;
use together::Together;

/// Pause between two thrust packets: 20 Hz.
pub const PERIOD: Duration = Duration(50_000);
/// The same, s.
const PERIOD_S: f64 = 0.050;
/// Time from sending thrusts to their beginning, s.
pub const AHEAD_S: f64 = 0.020;
/// Connectors draw a robot in from so far, m. *Assumed*.
pub const DOCK_M: f64 = 0.02;
/// And from so much turned or tilted, rad. *Assumed*: 3°.
pub const DOCK_RAD: f64 = 0.052;
/// A mover that far from its reference is waited for, m. *Assumed*.
pub const ASTRAY_M: f64 = 0.15;
/// No robot is waited for longer, s. *Assumed*.
pub const PATIENCE_S: f64 = 20.0;
/// A waiting cluster that has moved so far has got away, m. *Assumed*.
pub const ADRIFT_M: f64 = 0.5;
/// So has one that has turned or tilted so much, rad. *Assumed*.
pub const TILTED_RAD: f64 = 0.35;
/// From a measurement to the thrust that answers it, s: half a period, the time ahead, the propeller's lag where
/// nothing leads it. Gains are made for that.
const DELAY_S: f64 = AHEAD_S + PERIOD_S / 2.0 + LAG_S;
/// Until what is asked for now is given in full, s: feedforward is taken so far ahead.
const LEAD_S: f64 = AHEAD_S + PERIOD_S;

/// A change of which bodies are docked to each other. Bodies are counted robots first, then tools.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coupling {
    /// The robot lets go of its neighbours now.
    Undock(usize),
    /// The robot is to take hold in its slot; [`Conductor::docked`] says when it has.
    Dock(usize, Pose),
}

/// Robots, and tools between them, that wait together.
#[derive(Clone, Debug)]
struct Station {
    bodies: Vec<usize>,
    hold: Reference,
    controller: TrackingController,
}

/// See the module's documentation.
pub struct Conductor<'a> {
    problem: &'a Problem,
    plan: &'a Plan,
    law: PowerLaw,
    limits_n: (f64, f64),
    /// Robots, then tools: what they are, and where they are docked.
    bodies: Vec<(Pose, &'a Vehicle)>,
    answering: Vec<bool>,
    /// Which thrusters of each body give what they are told.
    working: Vec<Vec<bool>>,
    /// Share of [`DOCK_M`] and [`DOCK_RAD`] that a mover keeps to: less than one where its state is an estimate.
    within: f64,
    arrived: Vec<bool>,
    /// Move and action; the number of moves when all is done.
    number: usize,
    action: usize,
    trajectory: ReferenceTrajectory,
    t_s: f64,
    waited_s: f64,
    astray: bool,
    /// The body that has drifted towards the edge of the water, and its room there, m.
    drifted: Option<(usize, f64)>,
    /// An operator holds the cluster: time stands still, and every robot keeps its place.
    held: bool,
    /// Where the mover is, relative to its reference, at the last look: m, rad.
    off: (f64, f64),
    mover: Option<(usize, TrackingController)>,
    /// Of a parallel plan, in place of all that is said of one move above.
    together: Option<Together>,
    stations: Vec<Station>,
    lead: Lead,
}

impl<'a> Conductor<'a> {
    /// At the beginning of `plan`, allocating by `law`.
    ///
    /// # Errors
    /// [`ExecutionError::Misfit`] for a plan of another problem; [`ExecutionError::Tracking`] for bodies that the
    /// tracking controller refuses.
    pub fn new(problem: &'a Problem, plan: &'a Plan, law: PowerLaw) -> Result<Self, ExecutionError> {
        let robots = problem.robots.iter().map(|robot| (robot.start, robot.vehicle));
        let tools = problem.tools.iter().map(|tool| (tool.pose, tool.vehicle));
        let bodies = robots
            .chain(tools)
            .map(|(pose, kind)| Some((pose, problem.vehicles.get(kind)?)))
            .collect::<Option<Vec<_>>>()
            .ok_or_else(|| ExecutionError::Misfit("a vehicle is missing".to_owned()))?;
        check(problem, plan)?;
        let count = problem.robots.len();
        let thrusters = bodies.iter().take(count).map(|(_, vehicle)| vehicle.thrusters.len());
        let works = |vehicle: &Vehicle| vehicle.thrusters.iter().map(|own| !own.failed).collect();
        let working = bodies.iter().map(|(_, vehicle)| works(vehicle)).collect();
        let limits_n = power::limits_n(problem.rules.battery_v)?;
        let lead = Lead::new(thrusters, limits_n, PERIOD_S);
        let nowhere = Action {
            kind: ActionKind::Dock,
            start_s: 0.0,
            duration_s: 0.0,
            from: Pose::default(),
            to: Pose::default(),
            speed: 0.0,
            acceleration: None,
            energy_j: 0.0,
        };
        let mut conductor = Self {
            problem,
            plan,
            law,
            limits_n,
            bodies,
            answering: vec![true; count],
            working,
            within: 1.0,
            arrived: vec![false; count],
            number: 0,
            action: 0,
            trajectory: ReferenceTrajectory::new(&nowhere, &problem.rules),
            t_s: 0.0,
            waited_s: 0.0,
            astray: false,
            drifted: None,
            held: false,
            off: (0.0, 0.0),
            mover: None,
            together: plan.is_parallel().then(Together::new),
            stations: Vec::new(),
            lead,
        };
        match plan.is_parallel() {
            true => conductor.station()?,
            false => conductor.begin_move()?,
        }
        Ok(conductor)
    }

    /// Robots, then tools: where they are docked, and what they are.
    #[must_use]
    pub fn bodies(&self) -> &[(Pose, &'a Vehicle)] {
        &self.bodies
    }

    /// Whether the plan has come to its end.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.number >= self.plan.moves.len()
    }

    /// The move under way, from 0; of several the first.
    #[must_use]
    pub fn moving(&self) -> Option<usize> {
        match &self.together {
            Some(together) => together.under_way().map(|(number, _)| number).min(),
            None => (!self.is_finished()).then_some(self.number),
        }
    }

    /// All moves that are under way, docked or not, from 0, with their robots.
    pub fn under_way(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let together = self.together.as_ref();
        let own = self.moving().zip(self.mover()).filter(|_| together.is_none());
        own.into_iter().chain(together.into_iter().flat_map(Together::under_way))
    }

    /// All robots whose moves are under way, docked or not, and what they follow.
    #[must_use]
    pub fn followed(&self) -> Vec<Followed<'_>> {
        if let Some(together) = &self.together {
            return together.followed().collect();
        }
        let own = self.moving().zip(self.mover()).map(|(number, robot)| Followed {
            number,
            robot,
            reference: self.reference().map(|(_, reference)| reference),
            trajectory: &self.trajectory,
        });
        own.into_iter().collect()
    }

    /// The robot that moves, by its place in the problem, and its reference; nothing before it has let go.
    fn reference(&self) -> Option<(usize, Reference)> {
        let (robot, _) = self.mover.as_ref()?;
        (self.trajectory.kind() != ActionKind::Undock).then(|| (*robot, self.now()))
    }

    /// The robot whose move is under way, docked or not.
    #[must_use]
    pub fn mover(&self) -> Option<usize> {
        self.mover.as_ref().map(|(robot, _)| *robot)
    }

    /// Which robots are where their move was to bring them.
    #[must_use]
    pub fn arrived(&self) -> &[bool] {
        &self.arrived
    }

    /// Lets `dt_s` pass; `states` are those of all bodies, `answering` says which robots would obey now. Docking is told
    /// again until it has been followed.
    ///
    /// # Errors
    /// [`Failure`] where it does not go on.
    pub fn advance(
        &mut self,
        dt_s: f64,
        states: &[State],
        answering: &[bool],
    ) -> Result<Option<Coupling>, ExecutionError> {
        if self.together.is_some() {
            if answering != self.answering {
                self.answering.copy_from_slice(answering);
                self.station()?;
            }
            return self.advance_together(dt_s, states);
        }
        let Some((robot, _)) = self.mover else { return Ok(None) };
        if self.held {
            self.astray = true;
            return Ok(None);
        }
        if answering != self.answering {
            self.answering.copy_from_slice(answering);
            self.station()?;
        }
        if let Some(failure) = self.adrift(states) {
            return Err(failure.into());
        }
        if !self.astray {
            self.t_s += dt_s;
        }
        let undocking = self.trajectory.kind() == ActionKind::Undock;
        if let Some(bounds) = &self.problem.bounds {
            let reference_m_s = |body: usize| (!undocking && body == robot).then(|| self.now().velocity_m_s);
            self.drifted = edge::drifted(bounds, &self.bodies, states, reference_m_s, self.drifted.is_some());
        }
        self.off = if undocking { (0.0, 0.0) } else { apart(&states[robot], &self.now().pose) };
        let there = self.is_there();
        if self.astray {
            self.waited_s += dt_s;
            if there && self.answering[robot] && self.drifted.is_none() {
                self.trajectory = self.trajectory.resumed(self.t_s);
                (self.t_s, self.waited_s, self.astray) = (0.0, 0.0, false);
            }
        } else if self.off.0 > ASTRAY_M || self.drifted.is_some() || (!undocking && !self.answering[robot]) {
            self.astray = true;
        } else if self.t_s >= self.trajectory.duration_s() {
            if there && self.answering[robot] {
                return Ok(self.end_action(robot, dt_s));
            }
            self.waited_s += dt_s;
        }
        if self.waited_s > PATIENCE_S { Err(self.late(robot).into()) } else { Ok(None) }
    }

    /// Lets time stand still: every robot keeps its place, and the mover's reference rests where it is. Released, it goes on from
    /// rest once the mover is there.
    pub fn hold(&mut self, held: bool) {
        self.held = held;
    }

    /// Whether the mover is waited for: it is astray, or does not answer, or a robot has drifted towards the edge of the water.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.astray
            || self.drifted.is_some()
            || self.mover().is_some_and(|robot| !self.answering[robot])
            || self.together.as_ref().is_some_and(Together::waits)
    }

    /// The body that has drifted towards the edge of the water, with its room there, m: the plan waits until it is back.
    #[must_use]
    pub fn drifted(&self) -> Option<(usize, f64)> {
        self.drifted
    }

    /// No robot was told anything for a while: the reference rests until the mover is there. One that has not let go yet hands over
    /// its balance again.
    pub fn pause(&mut self) {
        if let Some(together) = &mut self.together {
            together.pause();
            return;
        }
        if self.trajectory.kind() == ActionKind::Undock {
            self.t_s = 0.0;
        } else {
            self.astray = self.mover.is_some();
        }
    }

    /// `robot`, which was told to, has taken hold in its slot, or rests where it parks.
    ///
    /// # Errors
    /// As for [`new`](Self::new); not for a plan that has come that far.
    pub fn docked(&mut self, robot: usize) -> Result<(), ExecutionError> {
        if self.together.is_some() {
            return self.docked_together(robot);
        }
        if let Some((robot, _)) = self.mover {
            self.bodies[robot].0 = self.trajectory.end();
            self.arrived[robot] = self.plan.moves.get(self.number).is_some_and(|of| of.slot.is_some());
            self.number += 1;
            self.begin_move()?;
        }
        Ok(())
    }

    /// Commands to every robot for the next period, N: to be called once in each.
    ///
    /// # Errors
    /// [`ExecutionError::Tracking`] for states that are no numbers.
    pub fn commands_n(&mut self, states: &[State]) -> Result<Vec<Vec<f64>>, ExecutionError> {
        let mut commands_n = self.wanted_n(states)?;
        for (robot, (commands_n, &answers)) in commands_n.iter_mut().zip(&self.answering).enumerate() {
            self.lead.lead(robot, commands_n, answers);
        }
        Ok(commands_n)
    }

    fn now(&self) -> Reference {
        if self.astray {
            Reference::at_rest(self.trajectory.at(self.t_s).pose)
        } else {
            self.trajectory.at(self.t_s)
        }
    }

    /// Whether the mover is where it should be.
    fn is_there(&self) -> bool {
        is_near(self.off, self.within)
    }

    /// The reference when the thrusts of now will act, across the end of the action if that is going to come.
    fn ahead(&self) -> Reference {
        if self.astray {
            return self.now();
        }
        let (then_s, duration_s) = (self.t_s + LEAD_S, self.trajectory.duration_s());
        let next = self.plan.moves.get(self.number).and_then(|of| of.actions.get(self.action + 1));
        match next.filter(|_| then_s > duration_s && self.is_there()) {
            Some(next) => {
                ReferenceTrajectory::new(next, &self.problem.rules).at(then_s - duration_s.max(self.t_s))
            }
            None => self.trajectory.at(then_s),
        }
    }

    /// On to the next action; what became of this one.
    fn end_action(&mut self, robot: usize, dt_s: f64) -> Option<Coupling> {
        let kind = self.trajectory.kind();
        if kind == ActionKind::Dock {
            // Until `docked` says that it holds.
            self.waited_s += dt_s;
            return Some(Coupling::Dock(robot, self.trajectory.end()));
        }
        let next = self.plan.moves.get(self.number).and_then(|of| of.actions.get(self.action + 1))?;
        let over_s = self.t_s - self.trajectory.duration_s();
        self.trajectory = ReferenceTrajectory::new(next, &self.problem.rules);
        // What is left of the tick belongs to the next action, what was waited for does not.
        (self.t_s, self.waited_s) = (over_s.min(dt_s), 0.0);
        self.action += 1;
        (kind == ActionKind::Undock).then_some(Coupling::Undock(robot))
    }

    fn begin_move(&mut self) -> Result<(), ExecutionError> {
        (self.action, self.t_s, self.waited_s, self.astray, self.off) = (0, 0.0, 0.0, false, (0.0, 0.0));
        self.mover = None;
        if let Some(next) = self.plan.moves.get(self.number)
            && let Some(robot) = self.problem.robots.iter().position(|robot| robot.id == next.robot)
            && let Some(first) = next.actions.first()
        {
            self.trajectory = ReferenceTrajectory::new(first, &self.problem.rules).lasting(HAND_OVER_S);
            self.mover = Some((robot, self.controller(&[robot], true)?));
        }
        self.station()
    }

    /// The clusters of the bodies that wait.
    fn station(&mut self) -> Result<(), ExecutionError> {
        let mover = self.mover();
        let moves =
            |body: usize| Some(body) == mover || self.together.as_ref().is_some_and(|own| own.has(body));
        let waiting: Vec<usize> = (0..self.bodies.len()).filter(|&body| !moves(body)).collect();
        let placed: Vec<(Pose, &Vehicle)> = waiting.iter().map(|&body| self.bodies[body]).collect();
        self.stations.clear();
        for cluster in clusters(&adjacency(&placed)) {
            let bodies: Vec<usize> = cluster.iter().map(|&index| waiting[index]).collect();
            let controller = self.controller(&bodies, false)?;
            let hold = Reference::at_rest(self.bodies[bodies[0]].0);
            self.stations.push(Station { hold, bodies, controller });
        }
        Ok(())
    }

    /// A tracking controller of these bodies, docked to each other. A robot that does not answer gives nothing; one that moves is waited for.
    fn controller(&self, bodies: &[usize], moves: bool) -> Result<TrackingController, TrackingError> {
        let members: Vec<(Pose, &Vehicle)> = bodies.iter().map(|&body| self.bodies[body]).collect();
        let mut limits_n = Vec::new();
        for &body in bodies {
            let silent = !moves && self.answering.get(body) == Some(&false);
            let works = self.working.get(body).into_iter().flatten();
            limits_n.extend(works.map(|works| if silent || !works { (0.0, 0.0) } else { self.limits_n }));
        }
        TrackingController::new(&members, &limits_n, self.law.clone(), DELAY_S)
    }

    fn adrift(&self, states: &[State]) -> Option<Failure> {
        self.stations.iter().find_map(|Station { bodies, hold, .. }| {
            let (off_m, off_rad) = apart(&states[bodies[0]], &hold.pose);
            (off_m > ADRIFT_M || off_rad > TILTED_RAD).then(|| {
                let robots = bodies.iter().filter_map(|&body| self.problem.robots.get(body));
                let silent = bodies.iter().any(|&body| self.answering.get(body) == Some(&false));
                Failure::adrift(robots.map(|robot| robot.id), silent, self.number, (off_m, off_rad))
            })
        })
    }

    fn late(&self, robot: usize) -> Failure {
        let (id, hint) = (self.problem.robots[robot].id, self.hint(robot));
        Failure::late(id, self.number, self.trajectory.kind(), self.off, hint)
    }

    /// Why a mover is late, where that is known.
    fn hint(&self, robot: usize) -> &'static str {
        match self.drifted {
            _ if !self.answering[robot] => " (it does not answer)",
            Some(_) => " (a robot is too near to the edge of the water)",
            None => "",
        }
    }
}

/// Distance, m, and angle, rad, from a level pose.
pub(super) fn apart(state: &State, pose: &Pose) -> (f64, f64) {
    let level = nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, pose.yaw_rad);
    let away = state.position_m - nalgebra::Vector3::from(pose.position_m);
    (away.norm(), state.attitude.angle_to(&level))
}

/// Whether a deviation, m and rad, is that part of what docking tolerates.
fn is_near((off_m, off_rad): (f64, f64), within: f64) -> bool {
    off_m <= within * DOCK_M && off_rad <= within * DOCK_RAD
}
