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
//! A slot that can be left straight ahead, astern, sideways, up or down as far as d of (19) is *open*. Orders that fill each slot while it
//! is open end in no dead end where start and goal are far apart. That is no condition, but a first order is found quickly by it.
//!
//! Limits: what rests at starts and in parking places is left out of the second question, and problems with several vehicles
//! or more slots than robots are not asked it. A robot that can move a little may still find no way.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::super::clearance::{Clearance, Resting};
use super::super::order::Layout;
use super::places::{Places, half_m};

/// A little way, m: far more than hulls may overlap, far less than they are wide.
const LITTLE_M: f64 = 1e-3;
/// How far out of a slot the water is open, in d of (19).
const OUT: f64 = 1.1;

/// By direction: the seats that a robot in a place cannot move against.
type Against = Vec<Vec<usize>>;

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Shut {
    /// Of every seat of a robot.
    against: HashMap<usize, Against>,
    /// Seats of the slots, and whether a robot may be there from the beginning; none where that is not asked.
    goal: Option<Vec<(usize, bool)>>,
    /// As `against`, for ways out of the slots.
    out: HashMap<usize, Against>,
    /// By filled slots: whether the rest can be filled, and whether it can while each slot is open.
    known: [Mutex<HashMap<u32, bool>>; 2],
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
        let ways = |reach_m: f64| {
            let robots = seats.iter().filter(|seat| !tools.contains(seat));
            robots.map(|&seat| (seat, against(places, seat, &seats, (of, reach_m)))).collect()
        };
        let (against, out) = (ways(LITTLE_M), ways(OUT * of.distance_m));
        let is_asked = layout.slots() == layout.robots() && places.has_one_vehicle();
        let goal = is_asked.then(|| {
            let slots = layout.robots()..layout.robots() + layout.slots();
            slots.map(|place| (places.seat(place, 0), stays(place))).collect()
        });
        Self { against, goal, out, known: Default::default() }
    }

    /// Whether a robot in a seat can move in no direction while these seats are taken.
    pub(super) fn is_shut(&self, seat: usize, taken: &[usize]) -> bool {
        is_against(&self.against, seat, taken)
    }

    /// Whether all other slots may still be filled when these are (bit k: slot k).
    pub(super) fn may_fill(&self, tools: &[usize], filled: u32) -> bool {
        self.comes_apart(0, tools, filled)
    }

    /// Whether all other slots can be filled while each is open.
    pub(super) fn stays_open(&self, tools: &[usize], filled: u32) -> bool {
        self.comes_apart(1, tools, filled)
    }

    fn comes_apart(&self, way: usize, tools: &[usize], filled: u32) -> bool {
        let Some(goal) = &self.goal else { return true };
        let known = &self.known[way];
        if let Some(known) = known.lock().unwrap_or_else(PoisonError::into_inner).get(&filled) {
            return *known;
        }
        let against = [&self.against, &self.out][way];
        let mut left: Vec<usize> = (0..goal.len()).collect();
        loop {
            let leaves = |slot: &usize| {
                let (seat, stays) = goal[*slot];
                let others = left.iter().filter(|other| *other != slot).map(|&other| goal[other].0);
                let taken: Vec<usize> = others.chain(tools.iter().copied()).collect();
                filled >> slot & 1 == 0 && (stays || !is_against(against, seat, &taken))
            };
            let Some(out) = left.iter().position(leaves) else { break };
            left.swap_remove(out);
        }
        let may = left.len() == filled.count_ones() as usize;
        known.lock().unwrap_or_else(PoisonError::into_inner).insert(filled, may);
        may
    }
}

/// Whether every direction is against one of the seats.
fn is_against(against: &HashMap<usize, Against>, seat: usize, taken: &[usize]) -> bool {
    let all = against.get(&seat);
    all.is_some_and(|all| all.iter().all(|seats| seats.iter().any(|other| taken.contains(other))))
}

/// For ways of that length in every direction that the water allows.
fn against(places: &Places<'_>, seat: usize, seats: &[usize], (of, way_m): (&Clearance, f64)) -> Against {
    let (pose, vehicle) = places.body(seat);
    let reach_m = |half_m: [f64; 3]| half_m.iter().map(|side| side * side).sum::<f64>().sqrt();
    let near = seats.iter().copied().filter(|&other| {
        let (there, vehicle_there) = places.body(other);
        let apart_m = (0..3).map(|k| (pose.position_m[k] - there.position_m[k]).powi(2)).sum::<f64>().sqrt();
        // In the same place there is no other one.
        apart_m > LITTLE_M
            && apart_m < reach_m(half_m(vehicle)) + reach_m(half_m(vehicle_there)) + way_m + of.distance_m
    });
    let near: Vec<usize> = near.collect();
    let mut directions = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    // What is only met farther out keeps no face beside it.
    let touching = near.iter().copied().filter(|_| way_m <= LITTLE_M);
    for yaw_rad in touching.map(|other| places.body(other).0.yaw_rad).chain([pose.yaw_rad]) {
        let (sin, cos) = yaw_rad.sin_cos();
        for direction in [[cos, sin, 0.0], [-cos, -sin, 0.0], [-sin, cos, 0.0], [sin, -cos, 0.0]] {
            let is_same = |other: &[f64; 3]| (0..3).all(|k| (other[k] - direction[k]).abs() < 1e-9);
            if !directions.iter().any(is_same) {
                directions.push(direction);
            }
        }
    }
    let mut clearance = Clearance { half_m: half_m(vehicle), start: pose, slot: pose, ..of.clone() };
    let mut is_free = |other: Option<usize>, direction: &[f64; 3]| {
        let body = other.map(|other| places.body(other));
        clearance.resting = body.map(|(pose, of)| Resting { pose, half_m: half_m(of) }).into_iter().collect();
        let to_m = std::array::from_fn(|k| pose.position_m[k] + way_m * direction[k]);
        clearance.leg_is_free(pose.position_m, to_m, pose.yaw_rad)
    };
    directions.retain(|direction| is_free(None, direction));
    let mut ways = Vec::with_capacity(directions.len());
    for direction in &directions {
        ways.push(near.iter().copied().filter(|&other| !is_free(Some(other), direction)).collect());
    }
    ways
}
