//! Underwater vehicles, each by a body of its own: poses in north-east-down, velocities, and labels that were swapped.
//!
//! A vehicle that is seen further than [`Limits::jump_m`] from where it should be has not swum there. Where two vehicles are seen in
//! each other's place their labels are swapped: each is followed by the other's body from then on, until they are swapped back.
//! Otherwise the vehicle was carried, and is followed from its new place; what was known of its motion is forgotten.
//!
//! Limits: two vehicles closer together than [`Limits::jump_m`] cannot be told apart by their places.

use std::collections::BTreeMap;

use crate::axes::{Pose, swap_world_and_ned};
use crate::gate::Fix;
use crate::roster::Roster;
use crate::velocity::{Motion, Tracker};

/// What vehicles are held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Bandwidth of the velocities, rad/s.
    pub bandwidth_rad_s: f64,
    /// A vehicle does not get further than this from where it should be, m.
    pub jump_m: f64,
}

impl Default for Limits {
    /// *Assumed*: 10 rad/s, well above what thrusters of 3.7 kg vehicles move; 12 cm, less than half of the shortest distance of two docked
    /// vehicles (0.267 m), more than a vehicle at 0.5 m/s strays in 0.2 s without a fix.
    fn default() -> Self {
        Self { bandwidth_rad_s: 10.0, jump_m: 0.12 }
    }
}

/// What a fix showed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sighting {
    /// The vehicles that were seen, with their motions.
    pub seen: Vec<(u16, Motion)>,
    /// Pairs whose labels are swapped at present, the lower number first.
    pub swapped: Vec<(u16, u16)>,
    /// Vehicles that were carried.
    pub carried: Vec<u16>,
}

/// The vehicles of a fleet.
#[derive(Clone, Debug)]
pub struct Vehicles {
    roster: Roster,
    limits: Limits,
    trackers: Vec<Tracker>,
    /// Entries that are followed by each other's body.
    swapped: BTreeMap<usize, usize>,
}

impl Vehicles {
    /// The vehicles of a roster.
    pub fn new(roster: Roster, limits: Limits) -> Self {
        let trackers = vec![Tracker::new(limits.bandwidth_rad_s); roster.entries().len()];
        Self { roster, limits, trackers, swapped: BTreeMap::new() }
    }

    /// Takes a fix.
    pub fn take(&mut self, fix: &Fix) -> Sighting {
        let at_s = fix.captured_s;
        let bodies = fix.bodies.iter().filter_map(|(label, pose)| {
            let entry = self.roster.place_of(label)?;
            Some((entry, swap_world_and_ned(pose)))
        });
        let bodies: BTreeMap<usize, Pose> = bodies.collect();
        let jumped: Vec<usize> = bodies
            .keys()
            .map(|&body| self.follows(body))
            .filter(|&entry| self.place(&bodies, entry).is_some_and(|pose| self.jumps(entry, at_s, &pose)))
            .collect();
        let partner = |&entry: &usize| {
            let mut others = jumped.iter().copied().filter(|&other| other != entry);
            (entry, others.find(|&other| self.exchanged(&bodies, entry, other, at_s)))
        };
        let partners: Vec<(usize, Option<usize>)> = jumped.iter().map(partner).collect();
        let mut carried = Vec::new();
        for (entry, partner) in partners {
            match partner {
                // Each pair is met twice.
                Some(other) if entry < other => self.exchange(entry, other),
                Some(_) => {}
                None => {
                    carried.extend(self.roster.entries().get(entry).map(|entry| entry.module));
                    self.trackers.iter_mut().skip(entry).take(1).for_each(Tracker::reset);
                }
            }
        }
        let mut seen = Vec::new();
        for at in 0..self.trackers.len() {
            let Some(pose) = self.place(&bodies, at) else { continue };
            let (Some(tracker), Some(entry)) = (self.trackers.get_mut(at), self.roster.entries().get(at))
            else {
                continue;
            };
            tracker.take(at_s, &pose);
            seen.extend(tracker.at(at_s).map(|motion| (entry.module, motion)));
        }
        Sighting { seen, swapped: self.pairs(), carried }
    }

    /// A vehicle's motion at another moment; `None` until it was seen.
    pub fn at(&self, module: u16, at_s: f64) -> Option<Motion> {
        let at = self.roster.entries().iter().position(|entry| entry.module == module)?;
        self.trackers.get(at)?.at(at_s)
    }

    /// Whose body the entry is followed by, and which entry the body is followed for: an exchange is its own inverse.
    fn follows(&self, entry: usize) -> usize {
        self.swapped.get(&entry).copied().unwrap_or(entry)
    }

    /// The vehicle of an entry by the body that it is followed by: the physical body is the entry's own, whatever its label.
    fn place(&self, bodies: &BTreeMap<usize, Pose>, entry: usize) -> Option<Pose> {
        Some(self.roster.entries().get(entry)?.vehicle(bodies.get(&self.follows(entry))?))
    }

    fn jumps(&self, entry: usize, at_s: f64, pose: &Pose) -> bool {
        let due = self.trackers.get(entry).and_then(|tracker| tracker.at(at_s));
        due.is_some_and(|due| (due.pose.position - pose.position).norm() > self.limits.jump_m)
    }

    /// Whether each of two entries that have jumped is where it should be by the other's body.
    fn exchanged(&self, bodies: &BTreeMap<usize, Pose>, one: usize, other: usize, at_s: f64) -> bool {
        let fits = |entry: usize, by: usize| {
            let vehicle = self.roster.entries().get(entry).zip(bodies.get(&self.follows(by)));
            vehicle.is_some_and(|(entry_of, body)| !self.jumps(entry, at_s, &entry_of.vehicle(body)))
        };
        fits(one, other) && fits(other, one)
    }

    /// Exchanges the bodies of two entries.
    fn exchange(&mut self, one: usize, other: usize) {
        let (first, second) = (self.follows(one), self.follows(other));
        for (entry, body) in [(one, second), (other, first)] {
            if entry == body {
                self.swapped.remove(&entry);
            } else {
                self.swapped.insert(entry, body);
            }
        }
    }

    fn pairs(&self) -> Vec<(u16, u16)> {
        let module = |at: usize| self.roster.entries().get(at).map(|entry| entry.module);
        let pairs = self.swapped.iter().filter(|(one, other)| one < other);
        pairs
            .filter_map(|(&one, &other)| module(one).zip(module(other)))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect()
    }
}
