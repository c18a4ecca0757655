//! Several robots under way at once: a parallel plan, by the time of the plan.
//!
//! ```text
//! dt_p = r dt,   0 ≤ r ≤ 1,   |ṙ| ≤ B                      the plan's time t_p, and how fast it passes
//! p(t) = p_ref(t_p),   v = r·v_ref,   v̇ = r²·v̇_ref + ṙ·v_ref   what every mover follows
//! r² ≤ 2B (t_b − t_p)                                          where t_b may not be passed yet
//! ```
//!
//! One time for all: where robots are relative to each other is what the plan has at that time, however long it takes,
//! so that the clearance that is kept in time there is kept here. It stands still as long as something is missing that
//! the plan builds on:
//!
//! - A robot leaves, or another one arrives, only when all have docked that were to have by then. One that is about to
//!   be late slows the time down before.
//! - A mover that is astray, or does not answer, is waited for by all.
//! - So is a robot that has drifted towards the edge of the water.
//! - While a host was away the propellers have stopped: those that are to hand over do so again.
//!
//! An action under way is not waited for at its end: the next one begins from there, and only docking asks for more.

use super::super::ExecutionError;
use super::{ASTRAY_M, Conductor, Coupling, Failure, HAND_OVER_S, LEAD_S, PATIENCE_S, apart, edge, is_near};
use reconfiguration::plan::ActionKind;
use reconfiguration::pose::Pose;
use rov::dynamics::State;
use rov::guidance::reference::{Reference, ReferenceTrajectory};
use rov::guidance::tracking::TrackingController;

/// How fast the rate of the time of a plan changes, 1/s. *Assumed*: a robot at 0.3 m/s is braked at 0.3 m/s² at most.
const RATE_PER_S: f64 = 1.0;
/// How long before its end a mover is looked at, whether it will be late, s: what braking from the full rate takes.
const FORESIGHT_S: f64 = 0.5 / RATE_PER_S;
/// Times that differ by less are the same, s.
const SAME_S: f64 = 1e-6;

/// A robot under way, or handing over.
struct Underway {
    number: usize,
    robot: usize,
    end_s: f64,
    /// Its actions, and when they begin.
    actions: Vec<(f64, ReferenceTrajectory)>,
    controller: TrackingController,
    let_go: bool,
    /// Where it is, relative to its reference, at the last look: m, rad.
    off: (f64, f64),
}

impl Underway {
    fn action(&self, plan_s: f64) -> Option<&(f64, ReferenceTrajectory)> {
        let begun = self.actions.iter().rfind(|(start_s, _)| *start_s <= plan_s);
        begun.or_else(|| self.actions.first())
    }

    /// The reference at a time of the plan that passes at `rate`, which changes by `change_per_s`.
    fn at(&self, plan_s: f64, rate: f64, change_per_s: f64) -> Reference {
        let Some((start_s, trajectory)) = self.action(plan_s) else { return Reference::default() };
        let planned = trajectory.at(plan_s - start_s);
        let faster = |acceleration: f64, speed: f64| rate * rate * acceleration + change_per_s * speed;
        let (v, a) = (planned.velocity_m_s, planned.acceleration_m_s2);
        Reference {
            pose: planned.pose,
            velocity_m_s: v.map(|component| rate * component),
            acceleration_m_s2: [0, 1, 2].map(|k| faster(a[k], v[k])),
            yaw_rate_rad_s: rate * planned.yaw_rate_rad_s,
            yaw_acceleration_rad_s2: faster(planned.yaw_acceleration_rad_s2, planned.yaw_rate_rad_s),
        }
    }

    fn end(&self) -> Pose {
        self.actions.last().map_or_else(Pose::default, |(_, trajectory)| trajectory.end())
    }
}

/// See the module's documentation.
pub(super) struct Together {
    plan_s: f64,
    rate: f64,
    change_per_s: f64,
    movers: Vec<Underway>,
    /// The first move that has not begun.
    next: usize,
    astray: bool,
    waited_s: f64,
    /// The time stands still for this time whatever else is, s.
    rest_s: f64,
}

/// A robot that is under way, and what it follows.
#[derive(Clone, Copy, Debug)]
pub struct Followed<'a> {
    /// The move, from 0.
    pub number: usize,
    /// The robot, by its place in the problem.
    pub robot: usize,
    /// Its reference; nothing before it has let go.
    pub reference: Option<Reference>,
    /// The trajectory of its action.
    pub trajectory: &'a ReferenceTrajectory,
}

impl Together {
    /// At the beginning, with all robots at rest: time passes as fast as it may.
    pub fn new() -> Self {
        Self {
            plan_s: 0.0,
            rate: 1.0,
            change_per_s: 0.0,
            movers: Vec::new(),
            next: 0,
            astray: false,
            waited_s: 0.0,
            rest_s: 0.0,
        }
    }

    /// Moves that are under way, with their robots.
    pub fn under_way(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.movers.iter().filter(|mover| !mover.actions.is_empty()).map(|mover| (mover.number, mover.robot))
    }

    /// Robots that are under way or hand over.
    pub fn followed(&self) -> impl Iterator<Item = Followed<'_>> {
        self.movers.iter().filter_map(|mover| {
            let (_, trajectory) = mover.action(self.plan_s)?;
            let reference = mover.let_go.then(|| mover.at(self.plan_s, self.rate, self.change_per_s));
            Some(Followed { number: mover.number, robot: mover.robot, reference, trajectory })
        })
    }

    pub fn has(&self, robot: usize) -> bool {
        self.movers.iter().any(|mover| mover.robot == robot)
    }

    pub fn waits(&self) -> bool {
        self.astray
    }

    /// Velocity of the reference that a robot follows, m/s; `None` if it follows none.
    fn velocity_m_s(&self, robot: usize) -> Option<[f64; 3]> {
        let mover = self.movers.iter().find(|mover| mover.robot == robot && mover.let_go)?;
        Some(mover.at(self.plan_s, self.rate, 0.0).velocity_m_s)
    }

    /// Controllers of the movers, with their robots.
    pub fn controllers(&mut self) -> impl Iterator<Item = (usize, &mut TrackingController)> {
        self.movers.iter_mut().map(|mover| (mover.robot, &mut mover.controller))
    }

    /// The propellers have stopped meanwhile.
    pub fn pause(&mut self) {
        (self.rate, self.change_per_s) = (0.0, 0.0);
        self.astray = true;
        if self.movers.iter().any(|mover| !mover.let_go) {
            self.rest_s = HAND_OVER_S;
        }
    }

    /// Thrusts of the movers, N, by robot.
    pub fn wanted_n(&self, states: &[State]) -> Result<Vec<(usize, Vec<f64>)>, ExecutionError> {
        let thrusts_n = self.movers.iter().map(|mover| {
            let now = mover.at(self.plan_s, self.rate, self.change_per_s);
            let ahead = mover.at(self.plan_s + self.rate * LEAD_S, self.rate, self.change_per_s);
            // As long as it is held, what it pushes for itself would push the whole cluster.
            let state = mover.let_go.then(|| &states[mover.robot]);
            let (thrusts_n, _) = mover.controller.thrusts_n(&now, &ahead, state)?;
            Ok((mover.robot, thrusts_n))
        });
        thrusts_n.collect()
    }
}

impl Conductor<'_> {
    /// [`advance`](Conductor::advance) of a parallel plan.
    pub(super) fn advance_together(
        &mut self,
        dt_s: f64,
        states: &[State],
    ) -> Result<Option<Coupling>, ExecutionError> {
        if let Some(failure) = self.adrift(states) {
            return Err(failure.into());
        }
        if let (Some(bounds), Some(together)) = (&self.problem.bounds, &self.together) {
            let reference_m_s = |body: usize| together.velocity_m_s(body);
            self.drifted = edge::drifted(bounds, &self.bodies, states, reference_m_s, self.drifted.is_some());
        }
        let (held, within, drifted) = (self.held, self.within, self.drifted.is_some());
        let block_s = self.barrier_s();
        let Some(together) = &mut self.together else { return Ok(None) };
        for mover in together.movers.iter_mut().filter(|mover| mover.let_go) {
            let reference = mover.at(together.plan_s, 0.0, 0.0);
            mover.off = apart(&states[mover.robot], &reference.pose);
        }
        let there = |mover: &Underway| is_near(mover.off, within);
        let silent = together.movers.iter().any(|mover| !self.answering[mover.robot]);
        let lost = silent || together.movers.iter().any(|mover| mover.off.0 > ASTRAY_M);
        together.astray = lost || (together.astray && !together.movers.iter().all(there));
        together.rest_s = (together.rest_s - dt_s).max(0.0);
        let stands = held || together.astray || drifted || together.rest_s > 0.0;
        // How fast the time may pass.
        let mut most = if stands { 0.0 } else { 1.0 };
        if let Some(block_s) = block_s {
            let late = together.movers.iter().any(|mover| {
                mover.end_s < block_s + SAME_S && together.plan_s > mover.end_s - FORESIGHT_S && !there(mover)
            });
            if late {
                most = f64::min(most, (2.0 * RATE_PER_S * (block_s - together.plan_s).max(0.0)).sqrt());
            }
        }
        let step = RATE_PER_S * dt_s;
        let rate = (together.rate + (most - together.rate).clamp(-step, step)).clamp(0.0, 1.0);
        together.change_per_s = (rate - together.rate) / dt_s;
        together.rate = rate;
        let to_s = together.plan_s + rate * dt_s;
        let blocked = block_s.is_some_and(|block_s| to_s >= block_s);
        if let Some(block_s) = block_s.filter(|_| blocked) {
            // One that docks as soon as it may delays no other.
            if together.plan_s >= block_s {
                (together.rate, together.change_per_s) = (0.0, 0.0);
            }
            together.plan_s = block_s;
        } else {
            together.plan_s = to_s;
        }
        let waits = !held && (together.astray || drifted || blocked);
        together.waited_s = if waits { together.waited_s + dt_s } else { 0.0 };
        if together.waited_s > PATIENCE_S
            && let Some(failure) = self.late_together()
        {
            return Err(failure.into());
        }
        self.couple_together()
    }

    /// The time that may not be passed as long as a robot that is under way has not docked: the next departure or arrival that
    /// builds on it. The end of a plan is none.
    fn barrier_s(&self) -> Option<f64> {
        let together = self.together.as_ref()?;
        let moves = &self.plan.moves;
        let departs_s = moves.get(together.next).map(|own| own.start_s);
        let arrives_s = together.movers.iter().map(|mover| mover.end_s);
        together
            .movers
            .iter()
            .filter_map(|mover| {
                let after = departs_s.into_iter().filter(|start_s| *start_s > mover.end_s - SAME_S);
                let later = arrives_s.clone().filter(|end_s| *end_s > mover.end_s + SAME_S);
                after.chain(later).reduce(f64::min)
            })
            .reduce(f64::min)
    }

    /// What is to be coupled now; moves whose time has come begin.
    fn couple_together(&mut self) -> Result<Option<Coupling>, ExecutionError> {
        let within = self.within;
        let Some(together) = &mut self.together else { return Ok(None) };
        let now_s = together.plan_s + SAME_S;
        if let Some(mover) = together
            .movers
            .iter_mut()
            .find(|mover| !mover.let_go && mover.actions.get(1).is_none_or(|(start_s, _)| *start_s <= now_s))
        {
            mover.let_go = true;
            return Ok(Some(Coupling::Undock(mover.robot)));
        }
        let docks = together.movers.iter().position(|mover| {
            let there = is_near(mover.off, within);
            mover.end_s <= now_s && mover.let_go && there && self.answering[mover.robot]
        });
        if let Some(index) = docks {
            // One that is refused lets the others try.
            let mover = together.movers.remove(index);
            let coupling = Coupling::Dock(mover.robot, mover.end());
            together.movers.push(mover);
            return Ok(Some(coupling));
        }
        let missing = together.movers.iter().map(|mover| mover.end_s).reduce(f64::min);
        let begins = self.plan.moves.get(together.next).is_some_and(|own| {
            // What was to have docked by then has.
            own.start_s <= now_s && missing.is_none_or(|end_s| end_s > own.start_s + SAME_S)
        });
        if begins {
            self.begin_together()?;
        }
        Ok(None)
    }

    /// The next move begins: its robot hands over.
    fn begin_together(&mut self) -> Result<(), ExecutionError> {
        let Some(number) = self.together.as_ref().map(|together| together.next) else { return Ok(()) };
        let Some(own) = self.plan.moves.get(number) else { return Ok(()) };
        let Some(robot) = self.problem.robots.iter().position(|robot| robot.id == own.robot) else {
            return Ok(());
        };
        let trajectory = |action| ReferenceTrajectory::new(action, &self.problem.rules);
        let mover = Underway {
            number,
            robot,
            end_s: own.start_s + own.duration_s,
            actions: own.actions.iter().map(|action| (action.start_s, trajectory(action))).collect(),
            controller: self.controller(&[robot], true)?,
            let_go: false,
            off: (0.0, 0.0),
        };
        if let Some(together) = &mut self.together {
            together.movers.push(mover);
            together.next += 1;
        }
        self.station()
    }

    /// The robot has taken hold in its slot, or rests where it parks.
    pub(super) fn docked_together(&mut self, robot: usize) -> Result<(), ExecutionError> {
        let Some(together) = &mut self.together else { return Ok(()) };
        if let Some(index) = together.movers.iter().position(|mover| mover.robot == robot) {
            let mover = together.movers.remove(index);
            self.bodies[robot].0 = mover.end();
            self.arrived[robot] = self.plan.moves.get(mover.number).is_some_and(|of| of.slot.is_some());
            self.number += 1;
        }
        self.station()
    }

    /// Which mover is waited for.
    fn late_together(&self) -> Option<Failure> {
        let together = self.together.as_ref()?;
        let silent = |mover: &Underway| !self.answering[mover.robot];
        let by_distance = |a: &&Underway, b: &&Underway| a.off.0.total_cmp(&b.off.0);
        let worst =
            together.movers.iter().max_by(|a, b| silent(a).cmp(&silent(b)).then(by_distance(a, b)))?;
        let action = worst.action(together.plan_s);
        let kind = action.map_or(ActionKind::Dock, |(_, trajectory)| trajectory.kind());
        let (id, hint) = (self.problem.robots[worst.robot].id, self.hint(worst.robot));
        Some(Failure::late(id, worst.number, kind, worst.off, hint))
    }
}
