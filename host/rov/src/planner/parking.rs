//! Parking places: where a robot may rest between two of its moves.
//!
//! - In open water: straight out from a start or a slot, along the axes of the first robot's box, as near as the clearance
//!   d of (19) to every start, slot and tool allows; there it is in no robot's way for longer than a move takes.
//! - Docked: on a face of a start, slot or tool, headed alike, where it overlaps none of them.
//!
//! Those nearest to all starts and slots come first. Limits: other places are not looked at, so that what cannot be planned
//! by way of these is no proof for all places.

use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;

use super::super::clearance::TOUCH_M;
use super::super::conditions::Conditions;
use super::super::configuration::{LevelBox, connectors};
use super::super::vector::{dot, length, offset, turned};
use super::super::water::Water;

/// Most places in open water, and most that are docked.
const OPEN_MOST: usize = 6;
const DOCKED_MOST: usize = 6;
/// How far out a place is looked for, in clearances, and in which steps.
const OUT_MOST: usize = 24;
const STEP: f64 = 0.25;

/// Places in open water.
pub(super) fn open(problem: &Problem, water: &Water) -> Vec<Pose> {
    let Some(first) = problem.robots.first() else { return Vec::new() };
    let yaw_rad = first.start.yaw_rad;
    let clearance_m =
        problem.robots.iter().map(|robot| problem.clearance_m(&problem.vehicles[robot.vehicle]));
    let clearance_m = clearance_m.fold(0.0, f64::max);
    let taken: Vec<Pose> = taken(problem).map(|(pose, _)| pose).collect();
    let anchors = ends(problem);
    let mut found = Vec::new();
    for anchor in &anchors {
        for axis in 0..6 {
            let mut out = [0.0; 3];
            out[axis / 2] = if axis % 2 == 0 { 1.0 } else { -1.0 };
            let out = turned(out, yaw_rad);
            let place = (1..=OUT_MOST).map(|step| {
                let way_m = step as f64 * STEP * clearance_m;
                let position_m = std::array::from_fn(|k| anchor.position_m[k] + way_m * out[k]);
                Pose { position_m, yaw_rad }
            });
            let is_clear = |pose: &Pose| {
                taken.iter().all(|other| length(offset(pose.position_m, other.position_m)) >= clearance_m)
            };
            let fits = |pose: &Pose| {
                let all = problem.robots.iter().map(|robot| &problem.vehicles[robot.vehicle]);
                all.into_iter()
                    .all(|vehicle| water.holds(pose.position_m, half_m(vehicle), pose.yaw_rad, TOUCH_M))
            };
            found.extend(place.filter(is_clear).take(1).filter(fits));
        }
    }
    chosen(found, &anchors, clearance_m, OPEN_MOST)
}

/// Places on faces of what rests at the start or in the end.
pub(super) fn docked(problem: &Problem, water: &Water) -> Vec<Pose> {
    let Some(vehicle) = problem.robots.first().and_then(|robot| problem.vehicles.get(robot.vehicle)) else {
        return Vec::new();
    };
    let all: Vec<(Pose, &Vehicle)> = taken(problem).collect();
    let mut found = Vec::new();
    for &(body, of) in &all {
        let own = connectors(Pose { position_m: [0.0; 3], yaw_rad: body.yaw_rad }, vehicle);
        for (face_m, normal) in connectors(body, of) {
            for (own_m, own_normal) in &own {
                if dot(normal, *own_normal) < -1.0 + 1e-9 {
                    let pose = Pose { position_m: offset(*own_m, face_m), yaw_rad: body.yaw_rad };
                    let own = LevelBox::around(pose, vehicle);
                    let is_free = all.iter().all(|(other, of)| !own.overlaps(&LevelBox::around(*other, of)));
                    if is_free && water.holds(pose.position_m, half_m(vehicle), pose.yaw_rad, TOUCH_M) {
                        found.push(pose);
                    }
                }
            }
        }
    }
    chosen(found, &ends(problem), 1e-3, DOCKED_MOST)
}

/// The nearest to all ends, no two nearer to each other than `apart_m`.
fn chosen(mut found: Vec<Pose>, ends: &[Pose], apart_m: f64, most: usize) -> Vec<Pose> {
    let way_m = |pose: &Pose| {
        let ways = ends.iter().map(|end| length(offset(pose.position_m, end.position_m)));
        // Equal ones stay in their order.
        (ways.sum::<f64>() * 1e6).round()
    };
    found.sort_by(|a, b| way_m(a).total_cmp(&way_m(b)));
    let mut chosen: Vec<Pose> = Vec::new();
    for pose in found {
        let apart = |other: &Pose| length(offset(pose.position_m, other.position_m)) >= apart_m;
        if chosen.len() < most && chosen.iter().all(apart) {
            chosen.push(pose);
        }
    }
    chosen
}

/// Half its length, width and height, m.
fn half_m(vehicle: &Vehicle) -> [f64; 3] {
    vehicle.box_m.map(|side| side / 2.0)
}

/// Starts and slots.
fn ends(problem: &Problem) -> Vec<Pose> {
    let starts = problem.robots.iter().map(|robot| robot.start);
    starts.chain(problem.slots.iter().map(|slot| slot.pose)).collect()
}

/// Starts, slots with every robot in them, tools.
fn taken(problem: &Problem) -> impl Iterator<Item = (Pose, &Vehicle)> {
    let vehicle = |robot: usize| &problem.vehicles[problem.robots[robot].vehicle];
    let starts = problem.robots.iter().enumerate().map(move |(index, robot)| (robot.start, vehicle(index)));
    let slots = problem.slots.iter().map(move |slot| (slot.pose, vehicle(0)));
    let tools = problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle]));
    starts.chain(slots).chain(tools)
}
