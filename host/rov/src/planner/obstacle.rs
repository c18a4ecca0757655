//! What keeps robots from moving, in words: for messages about dead ends.
//!
//! | condition | what keeps a robot |
//! |---|---|
//! | v2 | the slot requires what it does not bring, or is of no use to a goal that is one cluster |
//! | v4, v6, `one_cluster` | what stays cannot wait without it |
//! | v3 | a hull at rest overlaps the slot, or no way leads there |
//!
//! Every robot that waits is looked at with every empty slot, so that nothing said is a matter of luck: no pair is left out.
//! Where there is no way by the paper's rules, but one for a robot that chooses where it turns, that is said too.

use reconfiguration::plan::Manner;
use reconfiguration::pose::Pose;

use super::super::balance::{Unbalanced, balance};
use super::super::order::{Answer, Hop, MoveCosts, State};
use super::pricer::Pricer;

impl Pricer<'_> {
    /// What keeps the robots that wait from moving, robot by robot; empty slots by what keeps the robot from them.
    pub(super) fn obstacle(&self, state: &State) -> String {
        let mut stuck = Vec::new();
        for (from, kind) in self.layout.waiting(state) {
            let robot = self.name(Some(from));
            if let Err(reason) = self.lambda_w(state, from) {
                let reason = match reason {
                    Unbalanced::Alone(_) => "a tool would be left alone (v4)".to_owned(),
                    Unbalanced::Apart(..) => "the rest would not be one cluster (one_cluster)".to_owned(),
                    Unbalanced::OutOfReach { .. } => {
                        let served = self.served(state, from);
                        format!("the rest could give {:.0} % of the balancing wrench (v6)", served * 100.0)
                    }
                };
                stuck.push(format!("{robot} cannot leave: {reason}"));
                continue;
            }
            let mut reasons: Vec<(String, Vec<usize>)> = Vec::new();
            let hops: Vec<Hop> = self.layout.hops(state).map(|(hop, _)| hop).collect();
            for hop in hops.into_iter().filter(|hop| hop.ends().0 == from) {
                let Some(slot) = self.layout.slot(hop.ends().1) else { continue };
                let slot = self.slots_in_file[slot];
                // One slot that can be reached, and the robot is not stuck.
                let Some(reason) = self.kept_from(state, hop, kind) else {
                    reasons.clear();
                    break;
                };
                match reasons.iter_mut().find(|known| known.0 == reason) {
                    Some(known) => known.1.push(slot + 1),
                    None => reasons.push((reason, vec![slot + 1])),
                }
            }
            for (reason, slots) in reasons {
                let numbers: Vec<String> = slots.iter().map(ToString::to_string).collect();
                let slots = if slots.len() == 1 { "slot" } else { "slots" };
                stuck.push(format!("{robot}, {slots} {}: {reason}", numbers.join(", ")));
            }
        }
        if stuck.is_empty() { "every order of moves ends before it".to_owned() } else { stuck.join("; ") }
    }

    /// What keeps a robot, whose leaving the others can bear, from an empty slot; `None` if nothing does.
    fn kept_from(&self, state: &State, hop: Hop, kind: u8) -> Option<String> {
        let (from, to) = hop.ends();
        if self.bound(from, kind, to).is_none() {
            return Some("it may not rest there (v2)".to_owned());
        }
        if !self.may_fill(self.layout.filled(&self.layout.after(state, hop))) {
            return Some("with it filled no goal is one cluster".to_owned());
        }
        if self.stays(hop) || self.cost(0, state, hop, f64::INFINITY) != Answer::Price(f64::INFINITY) {
            return None;
        }
        let taken = self.places.taken(&self.layout, state, from);
        if let Some(&seat) = taken.iter().find(|&&seat| self.places.is_blocked(to, kind, &[seat])) {
            return Some(format!("{} is in it (v3)", self.name(self.places.place(seat))));
        }
        let free = self.request.manner == Manner::Paper && self.has_free_way(state, hop);
        let but = if free { ", though there is one for a robot that chooses where it turns" } else { "" };
        Some(format!("no way there keeps clear of hulls at rest (v3){but}"))
    }

    /// What rests in a place, in the numbers of the file; a tool if it is none.
    fn name(&self, place: Option<usize>) -> String {
        let Some(place) = place else { return "a tool".to_owned() };
        match (self.problem.robots.get(place), self.layout.slot(place)) {
            (Some(robot), _) => format!("robot {}", robot.id),
            (None, Some(slot)) => format!("the robot in slot {}", self.slots_in_file[slot] + 1),
            (None, None) => "a parked robot".to_owned(),
        }
    }

    /// The share of the balancing wrench that the others could give while the robot of a place is away.
    fn served(&self, state: &State, away: usize) -> f64 {
        let taken = self.places.taken(&self.layout, state, away);
        let bodies: Vec<(Pose, _)> = taken.iter().map(|&seat| self.places.body(seat)).collect();
        match balance(&bodies, &self.request.law, self.limits_n, &self.problem.rules) {
            Err(Unbalanced::OutOfReach { served, .. }) => served,
            _ => 0.0,
        }
    }
}
