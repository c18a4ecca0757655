//! Free rest poses: angles at which a module's tail is out of every present neighbour's reach, whatever they do.
//!
//! A tail touches a neighbour at lattice offset o only within ±reach(o) of the direction β(o) towards it
//! ([`Tail::reach_rad`](crate::tail::Tail::reach_rad)), so that the free poses of a module are what its neighbours leave of the circle:
//!
//! free = { φ : |wrap(φ − β(o))| ≥ reach(o) for every occupied o }
//!
//! With the default geometry reach = 0.76 rad < π/4: in the middle of a lattice the four diagonals are left, ±0.02 rad;
//! where a neighbour is missing, much more. From free poses
//! - a plan is loss tolerant if it is free of collisions: a module that misses it rests out of every tail's reach,
//! - a transition in two steps always exists: black cells of the lattice turn first, white cells second.
//!
//! Reach includes how far a tail may be from where it rests ([`Reach::within_rad`]).

use std::f64::consts::{PI, TAU};

use super::neighbours::Cycle;
use crate::setting::{Participation, Reach, Setting};
use quantity::wrap_rad;

/// Arcs are offered at least this densely, rad.
const STATION_RAD: f64 = PI / 8.0;
/// Arcs narrower than this are left out, rad.
const NARROW_RAD: f64 = 1e-6;
/// What is turned to the end of an arc stays so far inside: more than the rounding of an angle of a thousand turns, rad.
const INSIDE_RAD: f64 = 1e-9;

/// An arc of free poses: from its start counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Where it begins, rad in (−π, π].
    pub start_rad: f64,
    /// How far it goes, rad, up to 2π.
    pub length_rad: f64,
}

impl Arc {
    /// How far `pose_rad` is past the start, rad in [0, 2π).
    fn past_rad(self, pose_rad: f64) -> f64 {
        (pose_rad - self.start_rad).rem_euclid(TAU)
    }

    /// Whether the pose lies in the arc.
    #[must_use]
    pub fn holds(self, pose_rad: f64) -> bool {
        self.length_rad >= TAU || self.past_rad(pose_rad) <= self.length_rad
    }
}

/// The free poses of every module of a structure, and poses on offer for each.
#[derive(Clone, Debug)]
pub struct RestPoses {
    /// The arcs of module m are `arcs[first_arc[m]..first_arc[m + 1]]`.
    arcs: Vec<Arc>,
    first_arc: Vec<usize>,
    stations_rad: Vec<f64>,
    first_station: Vec<usize>,
    /// Whether a module has free poses at all; if not, its stations are the diagonals.
    free: Vec<bool>,
}

impl RestPoses {
    /// Of the modules of one structure.
    #[must_use]
    pub fn new(setting: &Setting) -> Self {
        let modules = setting.cells.len();
        let mut blocked: Vec<Vec<(f64, f64)>> = vec![Vec::new(); modules];
        for pair in setting.pairs.all() {
            let Reach { towards_rad, within_rad } = setting.reaches[pair.offset];
            blocked[pair.i].push((towards_rad, within_rad));
            blocked[pair.j].push((towards_rad + PI, within_rad));
        }
        let mut rest = Self {
            arcs: Vec::new(),
            first_arc: vec![0],
            stations_rad: Vec::new(),
            first_station: vec![0],
            free: Vec::with_capacity(modules),
        };
        for (blocked, participation) in blocked.iter_mut().zip(&setting.participation) {
            // A module that is not active stays where it is; if its angle is unknown, any value will do.
            let stays_rad = match participation {
                Participation::Active => None,
                Participation::Held(pose_rad) => Some(*pose_rad),
                Participation::Unknown => Some(0.0),
            };
            if let Some(pose_rad) = stays_rad {
                rest.free.push(false);
                rest.stations_rad.push(pose_rad);
                rest.first_arc.push(rest.arcs.len());
                rest.first_station.push(rest.stations_rad.len());
                continue;
            }
            let arcs = left(blocked);
            rest.free.push(!arcs.is_empty());
            if arcs.is_empty() {
                rest.stations_rad.extend([1.0, 3.0, -3.0, -1.0].map(|k| k * PI / 4.0));
            }
            arcs.iter().for_each(|&arc| rest.stations_rad.extend(stations(arc)));
            rest.arcs.extend(arcs);
            rest.first_arc.push(rest.arcs.len());
            rest.first_station.push(rest.stations_rad.len());
        }
        rest
    }

    /// The free arcs of a module; none if it has no free pose.
    #[must_use]
    pub fn arcs(&self, module: usize) -> &[Arc] {
        &self.arcs[self.first_arc[module]..self.first_arc[module + 1]]
    }

    /// Poses on offer for a module, rad in (−π, π].
    #[must_use]
    pub fn stations_rad(&self, module: usize) -> &[f64] {
        &self.stations_rad[self.stations(module)]
    }

    /// Where they stand in the list of all modules' stations.
    #[must_use]
    pub fn stations(&self, module: usize) -> std::ops::Range<usize> {
        self.first_station[module]..self.first_station[module + 1]
    }

    /// Whether the module is out of reach in this pose.
    #[must_use]
    pub fn is_free(&self, module: usize, pose_rad: f64) -> bool {
        self.arcs(module).iter().any(|arc| arc.holds(pose_rad))
    }

    /// Whether the module has any free pose.
    #[must_use]
    pub fn has_free(&self, module: usize) -> bool {
        self.free[module]
    }

    /// The cycle of a module that rests in this pose, at rest or of some amplitude.
    #[must_use]
    pub fn cycle(&self, module: usize, rest_rad: f64, amplitude_rad: f64) -> Cycle {
        Cycle { rest_rad, amplitude_rad, free: self.is_free(module, rest_rad), turns: false }
    }

    /// Whether the module is where it may start a cycle from: in a free pose, or anywhere if it has none.
    #[must_use]
    pub fn may_stay(&self, module: usize, pose_rad: f64) -> bool {
        !self.free[module] || self.is_free(module, pose_rad)
    }

    /// How far a pose may turn, clockwise (≤ 0) and counter-clockwise (≥ 0), without leaving its arc, rad; not at all
    /// outside. It stays a little off the ends, so that it is still in the arc after many turns.
    #[must_use]
    pub fn room_rad(&self, module: usize, pose_rad: f64) -> [f64; 2] {
        let Some(arc) = self.arcs(module).iter().find(|arc| arc.holds(pose_rad)) else { return [0.0; 2] };
        if arc.length_rad >= TAU {
            return [-PI, PI];
        }
        let past_rad = arc.past_rad(pose_rad);
        [(INSIDE_RAD - past_rad).min(0.0), (arc.length_rad - INSIDE_RAD - past_rad).max(0.0)]
    }
}

/// What blocked arcs (centre, half-width) leave of the circle.
fn left(blocked: &mut [(f64, f64)]) -> Vec<Arc> {
    if blocked.is_empty() {
        return vec![Arc { start_rad: 0.0, length_rad: TAU }];
    }
    for arc in blocked.iter_mut() {
        *arc = ((arc.0 - arc.1).rem_euclid(TAU), 2.0 * arc.1);
    }
    blocked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Once around from the start of the first: what no arc covers is left.
    let zero_rad = blocked[0].0;
    let (mut covered_rad, mut arcs) = (0.0_f64, Vec::new());
    for next in blocked.iter().map(|arc| (arc.0 - zero_rad, arc.1)).chain([(TAU, 0.0)]) {
        if next.0 > covered_rad + NARROW_RAD {
            arcs.push(Arc { start_rad: wrap_rad(zero_rad + covered_rad), length_rad: next.0 - covered_rad });
        }
        covered_rad = covered_rad.max(next.0 + next.1);
    }
    arcs
}

/// Poses spread over an arc: its middle alone if it is short.
fn stations(arc: Arc) -> impl Iterator<Item = f64> {
    let around = arc.length_rad >= TAU;
    let count = (arc.length_rad / STATION_RAD) as usize + 1;
    (0..count).map(move |k| {
        // A little inside the ends, or evenly around.
        let share = if around { k as f64 / count as f64 } else { (k as f64 + 0.5) / count as f64 };
        wrap_rad(arc.start_rad + share * arc.length_rad)
    })
}
