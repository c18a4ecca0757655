//! Robots that are shut in: that can move in no direction at all, and slots that can be filled no longer.
//!
//! Hulls are upright boxes, so a body that a hull touches keeps it from moving up, or down, or against one of the upright faces of
//! either of the two. The directions that are left form a cone; where it holds more than the hull at rest, it holds up, or down, or a
//! level direction along one of those faces. So it is enough to try these few, a little way.
//!
//! Slots that are filled stay filled. So the rest of a goal can be filled only if it can be taken apart again, down to the slots that are filled; and
//! what can be taken out first can as well be taken out later, as the others only become fewer. So taking out whatever is not shut in
//! decides it.
//!
//! Limits: what rests at starts and in parking places is left out of the second question, and problems with several vehicles
//! or more slots than robots are not asked it. A robot that can move a little may still find no way.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::super::clearance::{Clearance, Resting};
use super::super::order::Layout;
use super::places::Places;
use super::pricer::half_m;

/// A little way, m: far more than hulls may overlap, far less than they are wide.
const LITTLE_M: f64 = 1e-3;

/// By direction: the seats that a robot in a place cannot move against.
type Against = Vec<Vec<usize>>;

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Shut {
    /// Of every seat of a robot.
    against: HashMap<usize, Against>,
    /// Seats of the slots, and whether a robot may be there from the beginning; none where that is not asked.
    goal: Option<Vec<(usize, bool)>>,
    known: Mutex<HashMap<u32, bool>>,
}

impl Shut {
    /// For robots that keep clear of others as `of` says.
    pub(super) fn new(
        places: &Places<'_>,
        layout: &Layout,
        of: &Clearance,
        stays: impl Fn(usize) -> bool,
    ) -> Self {
        let seats: Vec<usize> = places.robots_and_tools().collect();
        let tools = places.tools();
        let robots = seats.iter().filter(|seat| !tools.contains(seat));
        let against = robots.map(|&seat| (seat, against(places, seat, &seats, of))).collect();
        let is_asked = layout.slots() == layout.robots() && places.has_one_vehicle();
        let goal = is_asked.then(|| {
            let slots = layout.robots()..layout.robots() + layout.slots();
            slots.map(|place| (places.seat(place, 0), stays(place))).collect()
        });
        Self { against, goal, known: Mutex::default() }
    }

    /// Whether a robot in a seat can move in no direction while these seats are taken.
    pub(super) fn is_shut(&self, seat: usize, taken: &[usize]) -> bool {
        let against = self.against.get(&seat);
        against.is_some_and(|all| all.iter().all(|seats| seats.iter().any(|other| taken.contains(other))))
    }

    /// Whether all other slots may still be filled when these are (bit k: slot k).
    pub(super) fn may_fill(&self, tools: &[usize], filled: u32) -> bool {
        let Some(goal) = &self.goal else { return true };
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&filled).copied();
        known.unwrap_or_else(|| {
            let may = self.comes_apart(goal, tools, filled);
            self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(filled, may);
            may
        })
    }

    fn comes_apart(&self, goal: &[(usize, bool)], tools: &[usize], filled: u32) -> bool {
        let mut left: Vec<usize> = (0..goal.len()).collect();
        loop {
            let leaves = |slot: &usize| {
                let (seat, stays) = goal[*slot];
                let others = left.iter().filter(|other| *other != slot).map(|&other| goal[other].0);
                let taken: Vec<usize> = others.chain(tools.iter().copied()).collect();
                filled >> slot & 1 == 0 && (stays || !self.is_shut(seat, &taken))
            };
            let Some(out) = left.iter().position(leaves) else { break };
            left.swap_remove(out);
        }
        left.len() == filled.count_ones() as usize
    }
}

fn against(places: &Places<'_>, seat: usize, seats: &[usize], of: &Clearance) -> Against {
    let (pose, vehicle) = places.body(seat);
    let reach_m = |half_m: [f64; 3]| half_m.iter().map(|side| side * side).sum::<f64>().sqrt();
    let near = seats.iter().copied().filter(|&other| {
        let (there, vehicle_there) = places.body(other);
        let apart_m = (0..3).map(|k| (pose.position_m[k] - there.position_m[k]).powi(2)).sum::<f64>().sqrt();
        // In the same place there is no other one.
        apart_m > LITTLE_M && apart_m < reach_m(half_m(vehicle)) + reach_m(half_m(vehicle_there)) + LITTLE_M
    });
    let near: Vec<usize> = near.collect();
    let mut directions = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    for yaw_rad in near.iter().map(|&other| places.body(other).0.yaw_rad).chain([pose.yaw_rad]) {
        let (sin, cos) = yaw_rad.sin_cos();
        for direction in [[cos, sin, 0.0], [-cos, -sin, 0.0], [-sin, cos, 0.0], [sin, -cos, 0.0]] {
            let is_same = |other: &[f64; 3]| (0..3).all(|k| (other[k] - direction[k]).abs() < 1e-9);
            if !directions.iter().any(is_same) {
                directions.push(direction);
            }
        }
    }
    let mut clearance = Clearance { half_m: half_m(vehicle), start: pose, slot: pose, ..of.clone() };
    let mut blocks = |other: usize, direction: &[f64; 3]| {
        let (pose_there, vehicle) = places.body(other);
        clearance.resting = vec![Resting { pose: pose_there, half_m: half_m(vehicle) }];
        let to_m = std::array::from_fn(|k| pose.position_m[k] + LITTLE_M * direction[k]);
        !clearance.leg_is_free(pose.position_m, to_m, pose.yaw_rad)
    };
    directions
        .iter()
        .map(|direction| near.iter().copied().filter(|&other| blocks(other, direction)).collect())
        .collect()
}
