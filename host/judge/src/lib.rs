//! Whether a plan keeps every condition: a judge that shares no code with the planner, not even its geometry.
//!
//! It takes the data types of [`reconfiguration`] and nothing of the planner, plays the plan back move by move, and names
//! every condition that is broken.
//!
//! | condition | what is looked at |
//! |---|---|
//! | v1 | one mover at a time, from where it is to its slot or to where it parks, position and heading; in the end one robot a slot |
//! | v2 | it brings what the slot requires |
//! | v3 | farther than d (19) from its own start and its own slot, its centre keeps d to the centre of everything at rest; everywhere, boxes do not overlap |
//! | v4 | every tool keeps a connection while a robot is away |
//! | v5 | no robot moves more often than `moves_per_robot` allows (once by the paper's manner): a resting robot stays connected |
//! | v6 | thrusts balance weight and buoyancy of every waiting cluster, all six components; roll and pitch may be left to its stability |
//! | connection | what is reached is one cluster, and what waits where the rules ask for it |
//! | bounds | no part of a mover leaves the water, or comes nearer to its edge than the margin |
//! | thrusters | no thrust beyond the measured table at the battery's voltage, none of a thruster out of order |
//! | kinematics | legs are straight, turns in place, durations follow from speed and acceleration |
//! | continuity, timing, energy, number | no robot jumps; no gaps; sums add up; everything is finite |
//! | identity | the plan speaks of this problem |
//!
//! A plan whose moves overlap in time (it has intervals) is played back in time: `meanwhile` says what is looked at.
//!
//! Limits. Motion is sampled every 5 mm and 0.01 rad at most. Between two samples a box corner of a BlueROV1 is never
//! farther than 2.5 mm + 0.005 rad · 0.29 m = 4 mm from where it was looked at, and boxes may run into each other by
//! 1 mm before they overlap: what is deeper than 5 mm is always found, and so is a clearance broken by 3 mm over more than 5 mm of
//! way. Energies of actions are not computed again, only their signs and sums.

use reconfiguration::plan::{Holding, Manner, Move, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;
use serde::Serialize;

mod accounts;
mod balance;
mod connections;
mod geometry;
mod kinematics;
mod meanwhile;
mod numbers;
mod passage;

/// Poses that are further apart than this are two, m and rad.
const SAME: f64 = 1e-6;

/// A condition that a plan has to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Condition {
    /// v1: one mover, from its start to its slot, the others at rest.
    V1,
    /// v2: capabilities.
    V2,
    /// v3 with (19): clearance and collisions.
    V3,
    /// v4: tools keep a connection.
    V4,
    /// v5: no robot disconnects to clear a passage.
    V5,
    /// v6: waiting clusters are balanced.
    V6,
    /// What is reached is one cluster, and what waits where the rules ask for it.
    Connection,
    /// The water.
    Bounds,
    /// Limits of thrust.
    Thrusters,
    /// Straight legs, turns in place, durations.
    Kinematics,
    /// Every action starts where the one before it ended.
    Continuity,
    /// Moves and actions follow each other without a gap.
    Timing,
    /// Energies and their sums.
    Energy,
    /// A number that is none.
    Number,
    /// The plan is one for another problem.
    Identity,
}

impl std::fmt::Display for Condition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&format!("{self:?}").to_lowercase())
    }
}

/// One condition that a plan breaks, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Violation {
    /// In which move, from 0; `None` if it is about the whole plan.
    pub index: Option<usize>,
    /// When it is first seen, s from the beginning of the plan.
    pub time_s: f64,
    /// Which condition.
    pub condition: Condition,
    /// What is wrong, with values and units.
    pub message: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: ", self.condition)?;
        if let Some(index) = self.index {
            write!(f, "move {} at {:.2} s: ", index + 1, self.time_s)?;
        }
        f.write_str(&self.message)
    }
}

/// What is checked otherwise for this plan than for others, if anything is.
#[must_use]
pub fn note(plan: &Plan) -> Option<&'static str> {
    (plan.manner == Manner::Paper).then_some(
        "by the paper's rules a hull is taken to be turned as at the start where it is nearer to the start, and as in the slot where \
         it is nearer to the slot; whether it has room to turn is judged where the one becomes the other, and nowhere else",
    )
}

/// Where a move is to end.
fn end_of(problem: &Problem, own: &Move) -> Option<Pose> {
    own.to.or_else(|| Some(problem.slots.get(own.slot?)?.pose))
}

/// A body at rest.
struct Body<'a> {
    name: String,
    pose: Pose,
    vehicle: &'a Vehicle,
}

/// Judges a plan. Nothing found means that all conditions are kept.
#[must_use]
pub fn verify(problem: &Problem, plan: &Plan) -> Vec<Violation> {
    let mut judge = Judge { problem, plan, found: Vec::new() };
    numbers::check(&mut judge);
    if judge.found.is_empty() {
        judge.identity();
        accounts::check(&mut judge);
        if plan.is_parallel() {
            meanwhile::account(&mut judge);
        }
    }
    // Nothing can be played back of robots and slots that are not there.
    if !judge.found.iter().any(|v| matches!(v.condition, Condition::Number | Condition::Identity)) {
        judge.play();
    }
    judge.found
}

struct Judge<'a> {
    problem: &'a Problem,
    plan: &'a Plan,
    found: Vec<Violation>,
}

impl<'a> Judge<'a> {
    fn add(&mut self, index: Option<usize>, time_s: f64, condition: Condition, message: String) {
        self.found.push(Violation { index, time_s, condition, message });
    }

    /// The plan names the problem's robots and slots, and every move one of them.
    fn identity(&mut self) {
        let (problem, plan) = (self.problem, self.plan);
        let mut wrong = Vec::new();
        if plan.problem != problem.name {
            wrong.push(format!("the plan is for {:?}, not for {:?}", plan.problem, problem.name));
        }
        if plan.robots.len() != problem.robots.len() {
            wrong.push(format!("{} robots instead of {}", plan.robots.len(), problem.robots.len()));
        }
        for robot in &problem.robots {
            match plan.robots.iter().find(|placed| placed.id == robot.id) {
                Some(placed) if same(placed.start, robot.start) => {}
                Some(placed) => wrong.push(format!(
                    "robot {} starts at {}, not at {}",
                    robot.id,
                    show(robot.start),
                    show(placed.start)
                )),
                None => wrong.push(format!("robot {} is missing", robot.id)),
            }
            if problem.vehicles.get(robot.vehicle).is_none() {
                wrong.push(format!("robot {}: there is no vehicle {}", robot.id, robot.vehicle));
            }
        }
        if problem.tools.iter().any(|tool| problem.vehicles.get(tool.vehicle).is_none()) {
            wrong.push("a tool without a vehicle".to_owned());
        }
        if plan.slots.len() != problem.slots.len() {
            wrong.push(format!("{} slots instead of {}", plan.slots.len(), problem.slots.len()));
        }
        for (number, (planned, slot)) in plan.slots.iter().zip(&problem.slots).enumerate() {
            if !same(*planned, slot.pose) {
                let (number, is, not) = (number + 1, show(slot.pose), show(*planned));
                wrong.push(format!("slot {number} is at {is}, not at {not}"));
            }
        }
        for message in wrong {
            self.add(None, 0.0, Condition::Identity, message);
        }
        for (index, own) in plan.moves.iter().enumerate() {
            if !problem.robots.iter().any(|robot| robot.id == own.robot) {
                let message = format!("there is no robot {}", own.robot);
                self.add(Some(index), own.start_s, Condition::Identity, message);
            }
            let message = match (own.slot, own.to) {
                (Some(slot), None) if slot < problem.slots.len() => continue,
                (Some(slot), None) => format!("there is no slot {} of {}", slot + 1, problem.slots.len()),
                (Some(slot), Some(_)) => format!("to slot {} and to another place as well", slot + 1),
                (None, Some(_)) => continue,
                (None, None) => "to no slot and to no other place".to_owned(),
            };
            self.add(Some(index), own.start_s, Condition::Identity, message);
        }
    }

    /// Plays the moves back and looks at what is reached.
    fn play(&mut self) {
        let (problem, plan) = (self.problem, self.plan);
        let mut poses: Vec<Pose> = problem.robots.iter().map(|robot| robot.start).collect();
        let most = if plan.manner == Manner::Paper { 1 } else { problem.rules.moves_per_robot };
        let mut moved = vec![(0, 0); problem.robots.len()];
        for (index, own) in plan.moves.iter().enumerate() {
            let Some(mover) = problem.robots.iter().position(|robot| robot.id == own.robot) else { continue };
            let (moves, before) = moved[mover];
            moved[mover] = (moves + 1, index);
            if moves >= most {
                let message = format!("robot {} has moved in move {} already", own.robot, before + 1);
                self.add(Some(index), own.start_s, Condition::V5, message);
            } else if moves > 0 && plan.moves[before].slot.is_some() {
                let message = format!("robot {} has come to its slot in move {}", own.robot, before + 1);
                self.add(Some(index), own.start_s, Condition::V5, message);
            }
            // Of moves that overlap only tools are known to rest all the time.
            let resting = bodies(problem, &poses, |robot| !plan.is_parallel() && robot != mover);
            self.judge_slot(index, own, mover);
            kinematics::check(self, index, own, poses[mover]);
            passage::check(self, index, own, mover, &resting);
            if !plan.is_parallel() {
                let meanwhile = format_args!("while robot {} is away", own.robot);
                self.judge_waiting((Some(index), own.start_s), &own.balance, &resting, meanwhile);
            }
            poses[mover] = own.actions.last().map_or(poses[mover], |last| last.to);
        }
        if plan.is_parallel() {
            meanwhile::check(self);
        }
        self.judge_end(&poses);
    }

    /// v2.
    fn judge_slot(&mut self, index: usize, own: &Move, mover: usize) {
        let Some((number, slot)) = own.slot.and_then(|slot| Some((slot, self.problem.slots.get(slot)?)))
        else {
            return;
        };
        let Some(robot) = self.problem.robots.get(mover) else { return };
        for wanted in slot.requires.iter().filter(|wanted| !robot.capabilities.contains(wanted)) {
            let message = format!("slot {} requires {wanted:?}, robot {} brings none", number + 1, robot.id);
            self.add(Some(index), own.start_s, Condition::V2, message);
        }
    }

    /// v4, one cluster where the rules ask for it, and v6: only connections among those at rest count, the mover has let go.
    /// `meanwhile` says how a message goes on.
    fn judge_waiting(
        &mut self,
        (index, start_s): (Option<usize>, f64),
        balance: &[Holding],
        resting: &[Body<'_>],
        meanwhile: std::fmt::Arguments<'_>,
    ) {
        let cluster = connections::clusters(resting);
        let first_tool = resting.len() - self.problem.tools.len();
        for tool in first_tool..resting.len() {
            if cluster.iter().filter(|&&other| other == cluster[tool]).count() == 1 {
                let message = format!("{} is left alone {meanwhile}", resting[tool].name);
                self.add(index, start_s, Condition::V4, message);
            }
        }
        if self.problem.rules.one_cluster
            && let Some(apart) = apart(&cluster, resting)
        {
            let message = format!("what waits is not one cluster (one_cluster): {apart}");
            self.add(index, start_s, Condition::Connection, message);
        }
        balance::check(self, (index, start_s), balance, (resting, &cluster));
    }

    /// v1, v2 and the cluster that is reached.
    fn judge_end(&mut self, poses: &[Pose]) {
        let problem = self.problem;
        let end_s = self.plan.time_s;
        let mut taken: Vec<Option<u16>> = vec![None; problem.slots.len()];
        for (robot, pose) in problem.robots.iter().zip(poses) {
            let Some(slot) = problem.slots.iter().position(|slot| same(slot.pose, *pose)) else {
                let message = format!("robot {} ends at {}, in no slot", robot.id, show(*pose));
                self.add(None, end_s, Condition::V1, message);
                continue;
            };
            if let Some(other) = taken[slot].replace(robot.id) {
                let message = format!("robots {other} and {} both end in slot {}", robot.id, slot + 1);
                self.add(None, end_s, Condition::V1, message);
            }
            let stayed = !self.plan.moves.iter().any(|own| own.robot == robot.id);
            for wanted in &problem.slots[slot].requires {
                if stayed && !robot.capabilities.contains(wanted) {
                    let message =
                        format!("slot {} requires {wanted:?}, robot {} brings none", slot + 1, robot.id);
                    self.add(None, end_s, Condition::V2, message);
                }
            }
        }
        let reached = bodies(problem, poses, |_| true);
        if let Some(apart) = apart(&connections::clusters(&reached), &reached) {
            let message = format!("what is reached is not one cluster: {apart}");
            self.add(None, end_s, Condition::Connection, message);
        }
    }
}

/// Two bodies of different clusters, in words; `None` if all are one.
fn apart(cluster: &[usize], bodies: &[Body<'_>]) -> Option<String> {
    let other = cluster.iter().position(|other| *other != cluster[0])?;
    Some(format!("no connection between {} and {}", bodies[0].name, bodies[other].name))
}

/// Clearance of a box from others, m.
fn clearance_m(problem: &Problem, box_m: [f64; 3]) -> f64 {
    // d = k·max(L, W, H)                                                                                    (19)
    problem.rules.clearance_factor * box_m.into_iter().fold(0.0, f64::max)
}

/// What is said of a mover whose centre came too near to another, its clearance being `d_m`.
fn too_near(what: &str, apart_m: f64, d_m: f64) -> String {
    match what.starts_with("clearance") {
        true => format!("{what} {apart_m:.3} m at least, {d_m:.3} m away from start and slot are asked (19)"),
        false => format!("{what}, centres {apart_m:.3} m apart"),
    }
}

/// Bodies at rest: robots that do, at their poses, then tools.
fn bodies<'a>(problem: &'a Problem, poses: &[Pose], rests: impl Fn(usize) -> bool) -> Vec<Body<'a>> {
    let robots = problem.robots.iter().zip(poses).enumerate();
    let robots = robots.filter(|(index, _)| rests(*index)).filter_map(|(_, (robot, &pose))| {
        let name = format!("robot {}", robot.id);
        Some(Body { name, pose, vehicle: problem.vehicles.get(robot.vehicle)? })
    });
    let tools = problem.tools.iter().enumerate().filter_map(|(index, tool)| {
        let name = format!("tool {}", index + 1);
        Some(Body { name, pose: tool.pose, vehicle: problem.vehicles.get(tool.vehicle)? })
    });
    robots.chain(tools).collect()
}

/// Smallest turn between two headings, rad.
fn turn_rad(from_rad: f64, to_rad: f64) -> f64 {
    (to_rad - from_rad).sin().atan2((to_rad - from_rad).cos())
}

fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

fn same(a: Pose, b: Pose) -> bool {
    distance_m(a.position_m, b.position_m) <= SAME && turn_rad(a.yaw_rad, b.yaw_rad).abs() <= SAME
}

fn show(pose: Pose) -> String {
    let [x, y, z] = pose.position_m;
    format!("({x:.3}, {y:.3}, {z:.3}) m heading {:.3} rad", pose.yaw_rad)
}

#[cfg(test)]
mod tests;
