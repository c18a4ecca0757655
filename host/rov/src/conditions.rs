//! Which problems are refused, and why: everything about g1–g8 that can be checked before planning.
//!
//! | condition | what is asked of the problem |
//! |---|---|
//! | v1 | at least as many slots as robots, all in the water and inside its edge, no two bodies in one place or in each other |
//! | v2 | some robot brings what a slot requires, and robots fit one-to-one into slots |
//! | v4 | every tool has a connection at the start and at the goal |
//! | g5, g6 | start and goal are one cluster each (18) |
//!
//! Which robot ends in which slot is for the planner to choose, so a goal is refused only if no choice can mend it: two
//! slots overlap when every two kinds of robot that may be there do, and they may be connected when any two kinds are.
//! With one kind of robot that is exact. A goal may have more slots than robots; a slot's requirement says which robots
//! may be there, not that one must.
//!
//! Poses off the planner's grid are no mistake.

use super::configuration::{LevelBox, TOUCH_M, clusters, holds};
use super::vector::{length, offset};
use fitting::is_possible;
use matching::crowd;
use quantity::{ParameterError, Range, check_ranges, check_within};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot};
use reconfiguration::vehicle::Vehicle;
pub use refusal::{Configuration, Place, ProblemError};

mod fitting;
mod matching;
mod refusal;

/// A body of a configuration with every kind it may be of.
struct Node<'a> {
    place: Place,
    pose: Pose,
    kinds: Vec<&'a Vehicle>,
}

/// Whether `robot` brings what `slot` requires (v2).
#[must_use]
pub fn admits(slot: &Slot, robot: &Robot) -> bool {
    slot.requires.iter().all(|capability| robot.capabilities.contains(capability))
}

/// Conditions that a problem has to meet.
pub trait Conditions {
    /// Clearance d of (19) for a mover of that kind, m: the factor times the longest side of its box.
    #[must_use]
    fn clearance_m(&self, vehicle: &Vehicle) -> f64;

    /// Corners of the water, m: those of the rules, or twice the greatest clearance around all boxes. No part of a
    /// robot leaves it.
    #[must_use]
    fn bounds_m(&self) -> [[f64; 3]; 2];

    /// Whether the problem is one that can be planned; the first thing that is wrong with it otherwise.
    fn check(&self) -> Result<(), ProblemError>;
}

impl Conditions for Problem {
    fn clearance_m(&self, vehicle: &Vehicle) -> f64 {
        // d ≥ 3/2·max(L, W, H)                                                                              (19)
        self.rules.clearance_factor * vehicle.box_m.into_iter().fold(0.0, f64::max)
    }

    fn bounds_m(&self) -> [[f64; 3]; 2] {
        self.rules.bounds_m.unwrap_or_else(|| {
            let room_m =
                self.vehicles.iter().map(|vehicle| 2.0 * self.clearance_m(vehicle)).fold(0.0, f64::max);
            let mut bounds_m = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
            for node in start(self).into_iter().chain(goal(self)) {
                for kind in node.kinds {
                    let [least, greatest] = LevelBox::around(node.pose, kind).extent_m();
                    for k in 0..3 {
                        bounds_m[0][k] = bounds_m[0][k].min(least[k] - room_m);
                        bounds_m[1][k] = bounds_m[1][k].max(greatest[k] + room_m);
                    }
                }
            }
            bounds_m
        })
    }

    fn check(&self) -> Result<(), ProblemError> {
        check_rules(&self.rules)?;
        check_bodies(self)?;
        check_slots(self)?;
        let bounds_m = self.bounds_m();
        if let Some(bounds) = &self.bounds {
            bounds.validate().map_err(ProblemError::Edge)?;
        }
        for node in start(self).into_iter().chain(goal(self)) {
            // A slot is refused only if no robot that may be there fits.
            if !node.kinds.iter().any(|kind| LevelBox::around(node.pose, kind).is_within(bounds_m)) {
                let position_m = node.pose.position_m;
                return Err(ProblemError::OutsideWater { place: node.place, position_m, bounds_m });
            }
            let Some(bounds) = &self.bounds else { continue };
            let room_m = |kind: &&Vehicle| bounds.room_m(&LevelBox::around(node.pose, kind).outline_m());
            let most_m = node.kinds.iter().map(room_m).fold(f64::NEG_INFINITY, f64::max);
            if most_m < bounds.margin_m - TOUCH_M {
                let (place, margin_m) = (node.place, bounds.margin_m);
                return Err(ProblemError::NearEdge { place, room_m: most_m, margin_m });
            }
        }
        check_configuration(Configuration::Start, &start(self), self.robots.len())?;
        check_configuration(Configuration::Goal, &goal(self), self.robots.len())?;
        check_fitting(self)
    }
}

fn tools(problem: &Problem) -> impl Iterator<Item = Node<'_>> {
    problem.tools.iter().enumerate().map(|(index, tool)| Node {
        place: Place::Tool(index),
        pose: tool.pose,
        kinds: problem.vehicles.get(tool.vehicle).into_iter().collect(),
    })
}

fn start(problem: &Problem) -> Vec<Node<'_>> {
    let robots = problem.robots.iter().map(|robot| Node {
        place: Place::Robot(robot.id),
        pose: robot.start,
        kinds: problem.vehicles.get(robot.vehicle).into_iter().collect(),
    });
    robots.chain(tools(problem)).collect()
}

fn goal(problem: &Problem) -> Vec<Node<'_>> {
    let slots = problem.slots.iter().enumerate().map(|(index, slot)| {
        let mut kinds: Vec<usize> =
            problem.robots.iter().filter(|robot| admits(slot, robot)).map(|robot| robot.vehicle).collect();
        kinds.sort_unstable();
        kinds.dedup();
        let kinds = kinds.into_iter().filter_map(|kind| problem.vehicles.get(kind)).collect();
        Node { place: Place::Slot(index), pose: slot.pose, kinds }
    });
    slots.chain(tools(problem)).collect()
}

/// Robots and tools have valid ids and finite poses.
fn check_bodies(problem: &Problem) -> Result<(), ProblemError> {
    if problem.robots.is_empty() {
        return Err(ProblemError::NoRobots);
    }
    let mut ids: Vec<u16> = problem.robots.iter().map(|robot| robot.id).collect();
    ids.sort_unstable();
    if ids.first() == Some(&0) {
        return Err(ProblemError::IdZero);
    }
    if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(ProblemError::IdTwice { id: pair[0] });
    }
    let robots =
        problem.robots.iter().map(|robot| (Place::Robot(robot.id), robot.start, Some(robot.vehicle)));
    let tools =
        problem.tools.iter().enumerate().map(|(k, tool)| (Place::Tool(k), tool.pose, Some(tool.vehicle)));
    let slots = problem.slots.iter().enumerate().map(|(k, slot)| (Place::Slot(k), slot.pose, None));
    for (place, pose, vehicle) in robots.chain(tools).chain(slots) {
        let [x, y, z] = pose.position_m;
        check_ranges(&[
            ("x", x, "m", Range::Finite),
            ("y", y, "m", Range::Finite),
            ("z", z, "m", Range::Finite),
            ("yaw", pose.yaw_rad, "rad", Range::Finite),
        ])
        .map_err(|number| ProblemError::Pose { place, number })?;
        let Some(vehicle) = vehicle else { continue };
        let Some(kind) = problem.vehicles.get(vehicle) else {
            return Err(ProblemError::NoSuchVehicle { place, vehicle, vehicles: problem.vehicles.len() });
        };
        if !kind.box_m.iter().all(|&side| side.is_finite() && side > 0.0) {
            return Err(ProblemError::Box { place, name: kind.name.clone(), box_m: kind.box_m });
        }
        if let (Place::Robot(id), true) = (place, kind.thrusters.is_empty()) {
            return Err(ProblemError::NoThrusters { id, name: kind.name.clone() });
        }
    }
    Ok(())
}

/// Every robot has a slot to go to (v1, v2).
fn check_slots(problem: &Problem) -> Result<(), ProblemError> {
    if problem.slots.len() < problem.robots.len() {
        return Err(ProblemError::TooFewSlots { slots: problem.slots.len(), robots: problem.robots.len() });
    }
    for (index, slot) in problem.slots.iter().enumerate() {
        let brought = |capability: &&String| {
            problem.robots.iter().any(|robot| robot.capabilities.contains(*capability))
        };
        if let Some(capability) = slot.requires.iter().find(|capability| !brought(capability)) {
            return Err(ProblemError::MissingCapability { slot: index, capability: capability.clone() });
        }
    }
    let fits: Vec<Vec<usize>> = problem
        .robots
        .iter()
        .map(|robot| (0..problem.slots.len()).filter(|&slot| admits(&problem.slots[slot], robot)).collect())
        .collect();
    match crowd(&fits, problem.slots.len()) {
        None => Ok(()),
        Some((robots, slots)) => {
            let robots = robots.into_iter().map(|robot| problem.robots[robot].id).collect();
            Err(ProblemError::NoAssignment { robots, slots })
        }
    }
}

/// Robots of several kinds fit into the slots without being in each other, in some assignment. Two slots for which no
/// pair of kinds does are named before.
fn check_fitting(problem: &Problem) -> Result<(), ProblemError> {
    let boxed = |robot: usize, slot: usize| {
        let kind = problem.vehicles.get(problem.robots[robot].vehicle)?;
        Some(LevelBox::around(problem.slots[slot].pose, kind))
    };
    let tools: Vec<LevelBox> = tools(problem)
        .flat_map(|tool| tool.kinds.into_iter().map(move |kind| LevelBox::around(tool.pose, kind)))
        .collect();
    let fits = |robot: usize, slot: usize| {
        admits(&problem.slots[slot], &problem.robots[robot])
            && boxed(robot, slot).is_some_and(|own| !tools.iter().any(|tool| own.overlaps(tool)))
    };
    let clash = |a: (usize, usize), b: (usize, usize)| match (boxed(a.0, a.1), boxed(b.0, b.1)) {
        (Some(a), Some(b)) => a.overlaps(&b),
        _ => false,
    };
    match is_possible(problem.robots.len(), problem.slots.len(), &fits, &clash) {
        Some(false) => Err(ProblemError::NoFit),
        Some(true) | None => Ok(()),
    }
}

fn check_rules(rules: &Rules) -> Result<(), ProblemError> {
    check_ranges(&[
        ("clearance_factor", rules.clearance_factor, "", Range::NonNegative),
        ("speed_m_s", rules.speed_m_s, "m/s", Range::Positive),
        ("yaw_rate_rad_s", rules.yaw_rate_rad_s, "rad/s", Range::Positive),
        ("acceleration_m_s2", rules.acceleration_m_s2, "m/s²", Range::Positive),
        ("yaw_acceleration_rad_s2", rules.yaw_acceleration_rad_s2, "rad/s²", Range::Positive),
        ("undock_s", rules.undock_s, "s", Range::NonNegative),
        ("dock_s", rules.dock_s, "s", Range::NonNegative),
        ("tilt_limit_rad", rules.tilt_limit_rad, "rad", Range::Share),
    ])?;
    for value in rules.current_m_s {
        check_within(&[("current_m_s", value, "m/s", -10.0..=10.0, "must lie between -10 and 10")])?;
    }
    let refuse = |key, value, unit, reason| Err(ParameterError { key, value, unit, reason }.into());
    if !(10.0..=20.0).contains(&rules.battery_v) {
        let reason = "the table of the thrusters covers 10 to 20 V";
        return refuse("battery_v", rules.battery_v, "V", reason);
    }
    for (key, [least, greatest], unit) in
        [("speeds_m_s", rules.speeds_m_s, "m/s"), ("yaw_rates_rad_s", rules.yaw_rates_rad_s, "rad/s")]
    {
        check_ranges(&[(key, least, unit, Range::Positive), (key, greatest, unit, Range::Positive)])?;
        if least > greatest {
            return refuse(key, least, unit, "the least must not be above the greatest");
        }
    }
    if let Some(&cells) = rules.grid_divisions.iter().find(|&&cells| !(1..=64).contains(&cells)) {
        return refuse("grid_divisions", f64::from(cells), "cells", "must lie between 1 and 64");
    }
    if !(1..=4).contains(&rules.moves_per_robot) {
        let moves = f64::from(rules.moves_per_robot);
        return refuse("moves_per_robot", moves, "moves", "must lie between 1 and 4");
    }
    if let Some(bounds_m) = rules.bounds_m {
        let [low, high] = bounds_m;
        for value in low.into_iter().chain(high) {
            check_ranges(&[("bounds_m", value, "m", Range::Finite)])?;
        }
        if (0..3).any(|k| low[k] >= high[k]) {
            return Err(ProblemError::Bounds { bounds_m });
        }
    }
    Ok(())
}

/// Whether one of start and goal is a cluster of bodies that are not in each other, as far as that is decided.
/// `robots` of the nodes that are no tools will be there.
fn check_configuration(
    configuration: Configuration,
    nodes: &[Node<'_>],
    robots: usize,
) -> Result<(), ProblemError> {
    let mut joined = vec![vec![None; nodes.len()]; nodes.len()];
    for (j, second) in nodes.iter().enumerate() {
        for (i, first) in nodes[..j].iter().enumerate() {
            if length(offset(first.pose.position_m, second.pose.position_m)) <= TOUCH_M {
                let position_m = second.pose.position_m;
                return Err(ProblemError::SamePlace { first: first.place, second: second.place, position_m });
            }
            let kinds = || first.kinds.iter().flat_map(|a| second.kinds.iter().map(move |b| (*a, *b)));
            let boxed = |(a, b)| (LevelBox::around(first.pose, a), LevelBox::around(second.pose, b));
            let depth_m = kinds().map(boxed).map(|(a, b)| -a.gap_m(&b)).fold(f64::INFINITY, f64::min);
            if depth_m.is_finite() && depth_m > TOUCH_M {
                return Err(ProblemError::Overlap { first: first.place, second: second.place, depth_m });
            }
            let held = kinds().find_map(|(a, b)| holds((first.pose, a), (second.pose, b)));
            (joined[i][j], joined[j][i]) = held.unzip();
        }
    }
    if nodes.len() == 1 {
        return Ok(());
    }
    let is_tool = |node: usize| matches!(nodes[node].place, Place::Tool(_));
    let all_used = nodes.len() - (0..nodes.len()).filter(|&node| is_tool(node)).count() == robots;
    let alone = |node: &usize| joined[*node].iter().all(Option::is_none);
    for node in (0..nodes.len()).filter(alone) {
        if let Place::Tool(tool) = nodes[node].place {
            return Err(ProblemError::ToolAlone { tool, configuration });
        }
    }
    if let Some(node) = (0..nodes.len()).find(alone).filter(|_| all_used) {
        return Err(ProblemError::Unconnected { place: nodes[node].place, configuration });
    }
    // One cluster has to hold every tool, and as many robots or slots as are needed.
    let clusters = clusters(&joined);
    let home = |node: usize| clusters.iter().position(|cluster| cluster.contains(&node));
    let fits = |cluster: &Vec<usize>| {
        cluster.iter().filter(|&&node| !is_tool(node)).count() >= robots
            && (0..nodes.len()).all(|node| !is_tool(node) || cluster.contains(&node))
    };
    if clusters.iter().any(fits) {
        return Ok(());
    }
    let first = (0..nodes.len()).find(|&node| is_tool(node)).unwrap_or(0);
    let second = (0..nodes.len())
        .filter(|&node| home(node) != home(first))
        .min_by_key(|&node| !is_tool(node))
        .unwrap_or(first);
    Err(ProblemError::Apart { configuration, first: nodes[first].place, second: nodes[second].place })
}

#[cfg(test)]
mod tests;
