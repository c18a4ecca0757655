//! Plan of a reconfiguration, the answer of its planner, and its JSON form: the contract of `reconfigure --json`.
//!
//! A plan is read as strictly as it is written: a key that does not exist is refused, for one that is misspelt and may
//! be left out would change what is judged.
//!
//! Moves follow each other without a gap; within a move its actions do. In a *parallel* plan moves overlap in time: it
//! is told by its [`intervals`](Plan::intervals), which say what balances from one departure or arrival to the next.
//! Distances in m, angles in rad, times in s from the beginning of the plan, energies in J.

use serde::{Deserialize, Serialize};

use super::pose::Pose;

/// The criterion that a plan minimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Electric energy (17).
    Energy,
    /// Length of the path.
    Euclidean,
}

/// How robots move and how the order is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Manner {
    /// As published: turn in place at every corner (the hull is taken as if it kept its docked heading), constant
    /// speed, steady-state power, the least g + h moves next.
    Paper,
    /// Flotilla's: exact order and assignment, best speed and heading for every leg, the heading held where hulls are
    /// near, acceleration counted.
    Best,
}

/// Kind of an action: leg, turn, undock or dock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ActionKind {
    /// Lets go of its neighbours.
    Undock,
    /// Turns in place, the shorter way.
    Turn,
    /// Swims straight on with its heading held.
    Leg,
    /// Takes hold of its neighbours.
    Dock,
}

/// One timed action of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Action {
    /// What.
    pub kind: ActionKind,
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// Where it begins.
    pub from: Pose,
    /// Where it ends.
    pub to: Pose,
    /// Greatest speed, m/s for a leg and rad/s for a turn; zero otherwise.
    pub speed: f64,
    /// Acceleration up to that speed and down again, m/s² or rad/s²; `None` for the paper's constant speed.
    pub acceleration: Option<f64>,
    /// What its thrusters draw, J.
    pub energy_j: f64,
}

/// One robot's way from where it rests to its slot, or to where it parks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// The robot's id.
    pub robot: u16,
    /// Index of its slot, from 0; null where it parks, never left out.
    #[serde(deserialize_with = "Option::deserialize")]
    pub slot: Option<usize>,
    /// Where it parks, until it moves again; left out where it goes to a slot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Pose>,
    /// Corners of its path, both ends included.
    pub path: Vec<[f64; 3]>,
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub duration_s: f64,
    /// What the mover's thrusters draw, J (15).
    pub energy_navigate_j: f64,
    /// What the waiting robots draw to balance meanwhile, J (17); in a parallel plan its share, equal among the robots
    /// that are under way at an instant.
    pub energy_balance_j: f64,
    /// The power of that, W; in a parallel plan its mean.
    pub balance_w: f64,
    /// Thrust of every waiting robot's thrusters meanwhile, N (16); empty in a parallel plan.
    pub balance: Vec<Holding>,
    /// What it does, in order.
    pub actions: Vec<Action>,
}

impl Move {
    /// Where it leads, in words; slots are counted from 1.
    #[must_use]
    pub fn destination(&self) -> String {
        destination(self.slot)
    }
}

/// A slot, or a parking place, in words; slots are counted from 1.
#[must_use]
pub fn destination(slot: Option<usize>) -> String {
    slot.map_or_else(|| "a parking place".to_owned(), |slot| format!("slot {}", slot + 1))
}

/// Thrusts of one waiting robot while another moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Holding {
    /// The robot's id.
    pub robot: u16,
    /// Thrust of each of its thrusters, N.
    pub thrusts_n: Vec<f64>,
}

/// A robot and where it starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placed {
    /// Its id.
    pub id: u16,
    /// Its start.
    pub start: Pose,
}

/// What waits in a parallel plan between two departures or arrivals, and what that draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// When it begins, s.
    pub start_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// What the waiting robots draw to balance, W.
    pub balance_w: f64,
    /// Thrust of every waiting robot's thrusters, N (16).
    pub balance: Vec<Holding>,
}

/// A whole plan. A robot that has no move stays where it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the problem.
    pub problem: String,
    /// What was minimised.
    pub criterion: Criterion,
    /// By which rules.
    pub manner: Manner,
    /// All robots at their starts.
    pub robots: Vec<Placed>,
    /// Where to.
    pub slots: Vec<Pose>,
    /// The moves, in order; in a parallel plan in the order in which they begin.
    pub moves: Vec<Move>,
    /// What balances when, without a gap from the beginning to the end, in a parallel plan; empty in one whose moves
    /// follow each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub intervals: Vec<Interval>,
    /// Σ over moves, J.
    pub energy_navigate_j: f64,
    /// Σ over moves, J.
    pub energy_balance_j: f64,
    /// Their sum (17), J.
    pub energy_total_j: f64,
    /// How long it takes, s.
    pub time_s: f64,
    /// No order of moves and assignment takes less, given these routes, J; left out where nothing was proved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower_bound_j: Option<f64>,
    /// How much dearer than the least it can be, as a share of the least; left out where nothing was proved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Whether it is the least over all orders and assignments, given these routes; left out where that was not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proved: Option<bool>,
}

impl Plan {
    /// Whether several robots may be under way at once.
    #[must_use]
    pub fn is_parallel(&self) -> bool {
        !self.intervals.is_empty()
    }
}
