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
//! Water that is not given is round, so that it depends on no heading: about the mean of start and goal, as wide as any box
//! around them with room of twice d on every side would reach.
//!
//! By the paper's rules the box is taken to be turned as at the start where its centre is nearer to the start, and as in the slot
//! where it is nearer to the slot. It turns, in this sense, where the one becomes the other, if the two headings differ. Where start and
//! slot are one place, that is where its way is farthest from there; a robot that does not swim turns there.

use std::collections::BTreeMap;

use reconfiguration::plan::{Action, ActionKind, Manner, Move};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;

use super::kinematics::{length, peak, pose_at};
use super::{Body, Condition, Judge, SAME, clearance_m, distance_m, end_of, geometry, too_near, turn_rad};

/// Longest way between two looks, m.
const STEP_M: f64 = 0.005;
/// Greatest turn between two looks, rad.
const STEP_RAD: f64 = 0.01;
/// No action is looked at more often than this.
const LOOKS_MAX: f64 = 2e6;
/// What rounding may take off a clearance, m.
const ROUNDING_M: f64 = 1e-5;

/// What a mover comes too near to, beside the corners of the water.
const EDGE: &str = "the edge";

/// The first time that something is seen, the worst value of it, and what to say about that.
type Seen = BTreeMap<(Condition, String), (f64, f64)>;

/// Looks along one move.
pub(super) fn check(judge: &mut Judge<'_>, index: usize, own: &Move, mover: usize, resting: &[Body<'_>]) {
    let problem = judge.problem;
    let robot = &problem.robots[mover];
    let Some(vehicle) = problem.vehicles.get(robot.vehicle) else { return };
    let (Some(first), Some(slot)) = (own.actions.first(), end_of(problem, own)) else { return };
    let box_m = vehicle.box_m;
    let on_the_spot = distance_m(first.from.position_m, slot.position_m) <= SAME;
    let faces_about = farthest(own).filter(|_| on_the_spot && judge.plan.manner == Manner::Paper);
    let water = Water::of(problem);
    let d_m = clearance_m(problem, box_m);
    let mut seen = Seen::new();
    let mut worst = |condition, who: &str, time_s: f64, value: f64| {
        let entry = seen.entry((condition, who.to_owned())).or_insert((time_s, value));
        entry.1 = entry.1.min(value);
    };
    for (number, action) in own.actions.iter().enumerate() {
        let Some(times) = looks(action) else {
            let message = format!("{:?} over {:.0}: too long to be judged", action.kind, length(action));
            judge.add(Some(index), action.start_s, Condition::Kinematics, message);
            return;
        };
        let turned = match faces_about {
            Some(last) => (number == last).then_some((action.start_s + action.duration_s, action.to)),
            None => turns(action, judge.plan.manner, first.from, slot),
        };
        if let Some((turns_s, at)) = turned {
            for body in resting.iter().filter(|body| geometry::swings_into((at, box_m), body_box(body))) {
                let apart_m = distance_m(at.position_m, body.pose.position_m);
                worst(Condition::V3, &format!("no room to turn beside {}", body.name), turns_s, apart_m);
            }
            let radius_m = geometry::swing_m(box_m);
            // As far aside as ahead: a square that a turn of the box stays in.
            let around = [2.0 * radius_m, 2.0 * radius_m, box_m[2]];
            let turning = Pose { yaw_rad: 0.0, ..at };
            for (what, room_m) in water.room_m(turning, around) {
                if room_m < -1e-3 {
                    worst(Condition::Bounds, what, turns_s, room_m);
                }
            }
            if let Some(bounds) = &problem.bounds {
                let place_m = [at.position_m[0], at.position_m[1]];
                let room_m = geometry::from_edge_m(&bounds.edge_m, place_m) - radius_m - bounds.margin_m;
                if room_m < -1e-3 {
                    worst(Condition::Bounds, EDGE, turns_s, room_m);
                }
            }
        }
        for t_s in times {
            let now_s = action.start_s + t_s;
            let pose = pose_at(action, t_s);
            let from_start_m = distance_m(pose.position_m, first.from.position_m);
            let from_slot_m = distance_m(pose.position_m, slot.position_m);
            let docked_rad = if from_slot_m < from_start_m { slot.yaw_rad } else { first.from.yaw_rad };
            let hull = match (judge.plan.manner, faces_about) {
                (Manner::Paper, Some(last)) if number <= last => Pose { yaw_rad: first.from.yaw_rad, ..pose },
                (Manner::Paper, Some(_)) => Pose { yaw_rad: slot.yaw_rad, ..pose },
                (Manner::Paper, None) if !on_the_spot => Pose { yaw_rad: docked_rad, ..pose },
                _ => pose,
            };
            let open = from_start_m > d_m + ROUNDING_M && from_slot_m > d_m + ROUNDING_M;
            for body in resting {
                let apart_m = distance_m(pose.position_m, body.pose.position_m);
                if open && apart_m < d_m - ROUNDING_M {
                    worst(Condition::V3, &format!("clearance to {}", body.name), now_s, apart_m);
                }
                if geometry::overlap((hull, box_m), body_box(body)) {
                    worst(Condition::V3, &format!("collision with {}", body.name), now_s, apart_m);
                }
            }
            if let Some(bounds) = &problem.bounds {
                // No point of the box is farther from its middle than half of its diagonal: mostly that is enough.
                let place_m = [hull.position_m[0], hull.position_m[1]];
                let least_m = geometry::from_edge_m(&bounds.edge_m, place_m) - geometry::swing_m(box_m);
                if least_m < bounds.margin_m {
                    let room_m = geometry::edge_room_m(&bounds.edge_m, hull, box_m) - bounds.margin_m;
                    if room_m < -1e-3 {
                        worst(Condition::Bounds, EDGE, now_s, room_m);
                    }
                }
            }
            for (what, room_m) in water.room_m(hull, box_m) {
                if room_m < -1e-3 {
                    worst(Condition::Bounds, what, now_s, room_m);
                }
            }
        }
    }
    for ((condition, who), (time_s, value)) in seen {
        let message = match condition {
            Condition::Bounds if who == EDGE => {
                let margin_m = problem.bounds.as_ref().map_or(0.0, |bounds| bounds.margin_m);
                let left_m = value + margin_m;
                format!("robot {} is {left_m:.3} m from the edge at least, {margin_m} m are asked", robot.id)
            }
            Condition::Bounds => format!("robot {} leaves the water by {:.3} m in {who}", robot.id, -value),
            _ => too_near(&who, value, d_m),
        };
        judge.add(Some(index), time_s, condition, message);
    }
}

fn body_box(body: &Body<'_>) -> (Pose, [f64; 3]) {
    (body.pose, body.vehicle.box_m)
}

/// The action that ends farthest from where the move begins; `None` if the robot does not swim.
fn farthest(own: &Move) -> Option<usize> {
    let start_m = own.actions.first()?.from.position_m;
    let out_m = |action: &Action| distance_m(action.to.position_m, start_m);
    let ends = own.actions.iter().enumerate().filter(|(_, action)| out_m(action) > SAME);
    // Of equal ones the first.
    let farther = |best: Option<(usize, f64)>, (number, action)| {
        let so_m = out_m(action);
        if best.is_some_and(|(_, most_m)| so_m <= most_m) { best } else { Some((number, so_m)) }
    };
    ends.fold(None, farther).map(|(number, _)| number)
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

/// The water of a problem.
enum Water {
    /// Between two corners, as given.
    Corners([[f64; 3]; 2]),
    /// Round.
    Round { centre_m: [f64; 2], radius_m: f64, depths_m: [f64; 2] },
}

impl Water {
    /// As given, or around every box at start and goal.
    fn of(problem: &Problem) -> Self {
        if let Some(corners_m) = problem.rules.bounds_m {
            return Self::Corners(corners_m);
        }
        let sides = problem.vehicles.iter().flat_map(|vehicle| vehicle.box_m);
        let longest_m = sides.fold(0.0, f64::max);
        let room_m = 2.0 * problem.rules.clearance_factor * longest_m;
        let robots = problem.robots.iter().map(|robot| robot.start);
        let slots = problem.slots.iter().map(|slot| slot.pose);
        let poses: Vec<Pose> =
            robots.chain(slots).chain(problem.tools.iter().map(|tool| tool.pose)).collect();
        let mean = |k: usize| poses.iter().map(|pose| pose.position_m[k]).sum::<f64>() / poses.len() as f64;
        let centre_m = [mean(0), mean(1)];
        let out_m =
            |pose: &Pose| f64::hypot(pose.position_m[0] - centre_m[0], pose.position_m[1] - centre_m[1]);
        let far_m = poses.iter().map(out_m).fold(0.0, f64::max);
        let reach_m = longest_m / 2.0 * 2.0_f64.sqrt();
        let heights = problem.vehicles.iter().map(|vehicle| vehicle.box_m[2]);
        let deep_m = heights.fold(0.0, f64::max) / 2.0 + room_m;
        let depths = || poses.iter().map(|pose| pose.position_m[2]);
        Self::Round {
            centre_m,
            // A box around a circle reaches √2 of its radius far.
            radius_m: 2.0_f64.sqrt() * (far_m + reach_m + room_m),
            depths_m: [
                depths().fold(f64::INFINITY, f64::min) - deep_m,
                depths().fold(f64::NEG_INFINITY, f64::max) + deep_m,
            ],
        }
    }

    /// How far a box is from the edges, m; negative beyond one.
    fn room_m(&self, hull: Pose, box_m: [f64; 3]) -> Vec<(&'static str, f64)> {
        let [least, greatest] = geometry::extent_m(hull, box_m);
        match self {
            Self::Corners([low, high]) => ["x", "y", "z"]
                .into_iter()
                .enumerate()
                .map(|(k, axis)| (axis, (least[k] - low[k]).min(high[k] - greatest[k])))
                .collect(),
            Self::Round { centre_m, radius_m, depths_m } => {
                let far = |k: usize| (greatest[k] - centre_m[k]).abs().max((least[k] - centre_m[k]).abs());
                // A box may be nearer than the corner of its extent, by half of its diagonal at most.
                let out_m = f64::hypot(far(0), far(1)).min(
                    f64::hypot(hull.position_m[0] - centre_m[0], hull.position_m[1] - centre_m[1])
                        + f64::hypot(box_m[0], box_m[1]) / 2.0,
                );
                let deep_m = (least[2] - depths_m[0]).min(depths_m[1] - greatest[2]);
                vec![("its width", radius_m - out_m), ("z", deep_m)]
            }
        }
    }
}
