//! Checks of v3 and of the bounds of the water, every few millimetres of a mover's way.
//!
//! ```text
//! d = k·max(L, W, H)      (19)
//! ```
//!
//! | where the mover's centre is | what is asked |
//! |---|---|
//! | farther than d from its start and from its slot | at least d to the centre of every body at rest |
//! | anywhere | its box overlaps no box at rest, and lies in the water |
//!
//! | where the mover turns | the upright cylinder around its box overlaps no box at rest, and lies in the water |
//!
//! By the paper's rules the box is taken to be turned as at the start where its centre is nearer to the start, and as in the slot
//! where it is nearer to the slot. It turns, in this sense, where the one becomes the other, if the two headings differ.

use std::collections::BTreeMap;

use reconfiguration::plan::{Action, ActionKind, Manner, Move};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;

use super::kinematics::{length, peak, pose_at};
use super::{Body, Condition, Judge, SAME, distance_m, end_of, geometry, turn_rad};

/// Longest way between two looks, m.
const STEP_M: f64 = 0.005;
/// Greatest turn between two looks, rad.
const STEP_RAD: f64 = 0.01;
/// No action is looked at more often than this.
const LOOKS_MAX: f64 = 2e6;
/// What rounding may take off a clearance, m.
const ROUNDING_M: f64 = 1e-5;

/// The first time that something is seen, the worst value of it, and what to say about that.
type Seen = BTreeMap<(Condition, String), (f64, f64)>;

/// Looks along one move.
pub(super) fn check(judge: &mut Judge<'_>, index: usize, own: &Move, mover: usize, resting: &[Body<'_>]) {
    let problem = judge.problem;
    let robot = &problem.robots[mover];
    let Some(vehicle) = problem.vehicles.get(robot.vehicle) else { return };
    let (Some(first), Some(slot)) = (own.actions.first(), end_of(problem, own)) else { return };
    let box_m = vehicle.box_m;
    let turns_on_the_spot = distance_m(first.from.position_m, slot.position_m) <= SAME;
    let water_m = water_m(problem);
    let longest_m = box_m.into_iter().fold(0.0, f64::max);
    // d = k·max(L, W, H)                                                                                    (19)
    let d_m = problem.rules.clearance_factor * longest_m;
    let mut seen = Seen::new();
    let mut worst = |condition, who: &str, time_s: f64, value: f64| {
        let entry = seen.entry((condition, who.to_owned())).or_insert((time_s, value));
        entry.1 = entry.1.min(value);
    };
    for action in &own.actions {
        let Some(times) = looks(action) else {
            let message = format!("{:?} over {:.0}: too long to be judged", action.kind, length(action));
            judge.add(Some(index), action.start_s, Condition::Kinematics, message);
            return;
        };
        if let Some((turns_s, at)) = turns(action, judge.plan.manner, first.from, slot) {
            for body in resting.iter().filter(|body| geometry::swings_into((at, box_m), body_box(body))) {
                let apart_m = distance_m(at.position_m, body.pose.position_m);
                worst(Condition::V3, &format!("no room to turn beside {}", body.name), turns_s, apart_m);
            }
            let radius_m = geometry::swing_m(box_m);
            for k in 0..2 {
                let (at_m, [low, high]) = (at.position_m[k], [water_m[0][k], water_m[1][k]]);
                let room_m = (at_m - low).min(high - at_m) - radius_m;
                if room_m < -1e-3 {
                    worst(Condition::Bounds, ["x", "y"][k], turns_s, room_m);
                }
            }
        }
        for t_s in times {
            let now_s = action.start_s + t_s;
            let pose = pose_at(action, t_s);
            let from_start_m = distance_m(pose.position_m, first.from.position_m);
            let from_slot_m = distance_m(pose.position_m, slot.position_m);
            let docked_rad = if from_slot_m < from_start_m { slot.yaw_rad } else { first.from.yaw_rad };
            let hull = match judge.plan.manner {
                Manner::Paper if !turns_on_the_spot => Pose { yaw_rad: docked_rad, ..pose },
                _ => pose,
            };
            let open = from_start_m > d_m + ROUNDING_M && from_slot_m > d_m + ROUNDING_M;
            for body in resting {
                let apart_m = distance_m(pose.position_m, body.pose.position_m);
                if open && apart_m < d_m - ROUNDING_M {
                    worst(Condition::V3, &format!("clearance to {}", body.name), now_s, apart_m);
                }
                let reach_m: f64 = box_m.iter().zip(body.vehicle.box_m).map(|(a, b)| (a + b).powi(2)).sum();
                // Nothing overlaps beyond half the sum of the diagonals.
                if apart_m <= reach_m.sqrt() && geometry::overlap((hull, box_m), body_box(body)) {
                    worst(Condition::V3, &format!("collision with {}", body.name), now_s, apart_m);
                }
            }
            let [least, greatest] = geometry::extent_m(hull, box_m);
            for k in 0..3 {
                let room_m = (least[k] - water_m[0][k]).min(water_m[1][k] - greatest[k]);
                if room_m < -1e-3 {
                    worst(Condition::Bounds, ["x", "y", "z"][k], now_s, room_m);
                }
            }
        }
    }
    for ((condition, who), (time_s, value)) in seen {
        let message = match condition {
            Condition::Bounds => format!("robot {} leaves the water by {:.3} m in {who}", robot.id, -value),
            _ if who.starts_with("clearance") => {
                format!("{who} {value:.3} m at least, {d_m:.3} m away from start and slot are asked (19)")
            }
            _ => format!("{who}, centres {value:.3} m apart"),
        };
        judge.add(Some(index), time_s, condition, message);
    }
}

fn body_box(body: &Body<'_>) -> (Pose, [f64; 3]) {
    (body.pose, body.vehicle.box_m)
}

/// When and where an action turns the box: a turn as such; by the paper's rules where the way comes nearer to the slot than to the
/// start, or the other way round, and the headings of the two differ.
fn turns(action: &Action, manner: Manner, start: Pose, slot: Pose) -> Option<(f64, Pose)> {
    let turned = |from: f64, to: f64| turn_rad(from, to).abs() > SAME;
    let on_the_spot = distance_m(start.position_m, slot.position_m) <= SAME;
    if manner == Manner::Best || on_the_spot {
        let does = action.kind == ActionKind::Turn && turned(action.from.yaw_rad, action.to.yaw_rad);
        return does.then_some((action.start_s, action.from));
    }
    let lead_m = |t_s: f64| {
        let at_m = pose_at(action, t_s).position_m;
        distance_m(at_m, slot.position_m) - distance_m(at_m, start.position_m)
    };
    let (mut early_s, mut late_s) = (0.0, action.duration_s);
    let (first_m, last_m) = (lead_m(early_s), lead_m(late_s));
    if !turned(start.yaw_rad, slot.yaw_rad) || first_m.min(last_m) > 0.0 || first_m.max(last_m) < 0.0 {
        return None;
    }
    for _ in 0..60 {
        let middle_s = 0.5 * (early_s + late_s);
        if (lead_m(middle_s) > 0.0) == (first_m > 0.0) {
            early_s = middle_s;
        } else {
            late_s = middle_s;
        }
    }
    Some((action.start_s + late_s, pose_at(action, late_s)))
}

/// When to look, s from the beginning of an action; `None` if that would be too often.
fn looks(action: &Action) -> Option<impl Iterator<Item = f64>> {
    let step = if action.kind == ActionKind::Turn { STEP_RAD } else { STEP_M };
    let length = length(action);
    let (speed, duration_s) = (peak(action), action.duration_s.max(0.0));
    // At the greatest speed, a step is not longer than it may be.
    let looks = if length > 0.0 { (duration_s * speed / step).max(length / step).ceil() } else { 1.0 };
    let looks = if looks.is_finite() && looks <= LOOKS_MAX { looks } else { return None };
    // Whole numbers below 2²¹.
    Some((0..=looks as u32).map(move |k| duration_s * f64::from(k) / looks))
}

/// Corners of the water: those given, or twice the greatest clearance around every box at start and goal.
fn water_m(problem: &Problem) -> [[f64; 3]; 2] {
    if let Some(bounds_m) = problem.rules.bounds_m {
        return bounds_m;
    }
    let sides = problem.vehicles.iter().flat_map(|vehicle| vehicle.box_m);
    let room_m = 2.0 * problem.rules.clearance_factor * sides.fold(0.0, f64::max);
    let placed = problem.robots.iter().map(|robot| (robot.start, robot.vehicle));
    let tools = problem.tools.iter().map(|tool| (tool.pose, tool.vehicle));
    let slots = problem.slots.iter().flat_map(|slot| {
        let brings = |wanted: &String, id: usize| problem.robots[id].capabilities.contains(wanted);
        (0..problem.robots.len())
            .filter(move |&robot| slot.requires.iter().all(|wanted| brings(wanted, robot)))
            .map(|robot| (slot.pose, problem.robots[robot].vehicle))
    });
    let mut water_m = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for (pose, vehicle) in placed.chain(tools).chain(slots) {
        let Some(vehicle) = problem.vehicles.get(vehicle) else { continue };
        let [least, greatest] = geometry::extent_m(pose, vehicle.box_m);
        for k in 0..3 {
            water_m[0][k] = water_m[0][k].min(least[k] - room_m);
            water_m[1][k] = water_m[1][k].max(greatest[k] + room_m);
        }
    }
    water_m
}
