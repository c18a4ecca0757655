//! A* over the sparse graph around the bodies at rest; edges are priced and looked at when they come up.
//!
//! Where start and slot have different headings there are two layers: at the start's heading, and at the slot's. A way goes
//! from one to the other at a place with room to turn.
//!
//! The bound is scaled to what a leg costs here: the search is quick, and its ways are near the cheapest, not always the cheapest.
//!
//! An edge waits in the queue at its lower bound; when it comes up it is priced, and looked at only if it still may be on one of the best ways.
//! The slot is reached by several edges: each gives a way, so that the search goes on to a few more, which differ.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use reconfiguration::plan::{Criterion, Manner};

use super::super::vector::{length, offset};
use super::fares::Direction;
use super::polyline::{CHOICES, MOST, Mode, Polyline, Pricer};
use super::waypoints;

/// Most ways that a search looks for, and how much dearer than the first they may be.
const WAYS: usize = 4;
const DEARER: f64 = 1.12;
/// Two ways are one if their corners are nearer to each other than this, in d.
const ALIKE: f64 = 0.25;
/// Greatest factor of the bound.
const MOST_SCALE: f64 = 3.0;
const START: usize = 0;
const SLOT: usize = 1;

/// How a leg is priced: at the heading of its layer, or at the cheapest of four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Headings {
    Held,
    Free,
}

/// f, from, to; twice the latter, and one more when the edge has been looked at.
type Entry = Reverse<(u64, u32, u32)>;

/// What is known of a vertex of one layer.
#[derive(Clone, Copy, Debug)]
struct Node {
    g: f64,
    /// The least g of a free edge that leads here and waits in the queue: no dearer one is worth a look.
    offered: f64,
    parent: u32,
    is_closed: bool,
}

/// Scratch of searches.
#[derive(Debug, Default)]
pub(super) struct Sparse {
    places: Vec<[f64; 3]>,
    /// Whether the hull has room to turn there.
    room: Vec<bool>,
    /// By layer, from, to: whether the leg is free, where that is known.
    free: Vec<Option<bool>>,
    bounds: Vec<f64>,
    nodes: Vec<Node>,
    queue: BinaryHeap<Entry>,
    /// Ways found, cheapest first.
    pub found: Vec<Polyline>,
}

impl Sparse {
    /// Forgets what was found, and collects the vertices of a query.
    pub fn begin(&mut self, pricer: &Pricer<'_>) {
        waypoints::collect(pricer.query.clearance, &mut self.places);
        let clearance = pricer.query.clearance;
        self.room.clear();
        self.room.extend(self.places.iter().map(|place| clearance.turn_is_free(*place)));
        self.found.clear();
        self.free.clear();
        self.free.resize(2 * self.places.len() * self.places.len(), None);
    }

    /// Adds the ways of one price model to those found.
    pub fn search(&mut self, pricer: &Pricer<'_>, headings: Headings) {
        let query = pricer.query;
        let clearance = query.clearance;
        let yaws = [clearance.start.yaw_rad, clearance.slot.yaw_rad];
        let layers = 1 + usize::from(pricer.turns());
        let count = self.places.len();
        let at = query.mover.bound_at(Manner::Best, query.lambda_w);
        let bound = |way_m: [f64; 3]| match pricer.criterion {
            Criterion::Energy => at.of(way_m),
            Criterion::Euclidean => length(way_m),
        };
        // What a leg costs above its bound differs little between legs of one query: ramps, and how the hull is turned. Scaled by
        // it, the bound is close, and the search looks at a few edges; the ways that it finds are near the cheapest.
        let straight_m = offset(clearance.start.position_m, clearance.slot.position_m);
        let closest = yaws.map(|yaw_rad| leg_price(pricer, headings, straight_m, yaw_rad));
        let scale = (closest[0].min(closest[1]) / bound(straight_m)).clamp(1.0, MOST_SCALE);
        let bound = |way_m: [f64; 3]| scale * bound(way_m);
        let turn = if layers == 2 { pricer.turn(yaws[0], yaws[1]) } else { 0.0 };
        self.bounds.clear();
        self.bounds.extend(self.places.iter().map(|place| bound(offset(*place, clearance.slot.position_m))));
        let slot_yaw = yaws[layers - 1];
        if !(0..count).any(|from| from != SLOT && self.is_free(pricer, layers - 1, (from, SLOT), slot_yaw)) {
            return;
        }
        self.nodes.clear();
        self.nodes.resize(
            count * layers,
            Node { g: f64::INFINITY, offered: f64::INFINITY, parent: 0, is_closed: false },
        );
        self.queue.clear();
        let goal = SLOT + (layers - 1) * count;
        let mut ways = 0;
        // A way by one place limits what is worth a look from the beginning.
        let (mut limit, mut by) = (f64::INFINITY, None);
        for place in SLOT + 1..count {
            let at_m = self.places[place];
            let first_m = offset(self.places[START], at_m);
            if (layers == 2 && !self.room[place]) || DEARER * (bound(first_m) + self.bounds[place]) >= limit {
                continue;
            }
            if self.is_free(pricer, 0, (START, place), yaws[0])
                && self.is_free(pricer, layers - 1, (place, SLOT), slot_yaw)
            {
                let last_m = offset(at_m, self.places[SLOT]);
                let first = leg_price(pricer, headings, first_m, yaws[0]);
                let price = first + turn + leg_price(pricer, headings, last_m, slot_yaw);
                if DEARER * price < limit {
                    (limit, by) = (DEARER * price, Some(place));
                }
            }
        }
        // The scaled bound may hide that way from the search.
        if let Some(place) = by {
            let corners = [START, place, SLOT].map(|place| self.places[place]);
            ways += usize::from(self.keep(&corners, clearance.distance_m));
        }
        self.queue.push(entry(self.bounds[START], START, START, true));
        while let Some(Reverse((f, from, to))) = self.queue.pop() {
            let (f, from, to, looked) = (f64::from_bits(f), from as usize, (to / 2) as usize, to % 2 == 1);
            if f >= limit {
                break;
            }
            if self.nodes[to].is_closed {
                continue;
            }
            let (layer, place) = (to / count, to % count);
            if !looked {
                if f - self.bounds[place] >= self.nodes[to].offered {
                    continue;
                }
                // To look is cheaper than to price, and most edges are blocked.
                if self.is_free(pricer, layer, (from % count, place), yaws[layer]) {
                    let leg_m = offset(self.places[from % count], self.places[place]);
                    let price = leg_price(pricer, headings, leg_m, yaws[layer]);
                    let g = self.nodes[from].g + price;
                    let f = g + self.bounds[place];
                    if f < limit && g < self.nodes[to].offered {
                        self.nodes[to].offered = g;
                        self.queue.push(entry(f, from, to, true));
                    }
                }
                continue;
            }
            let g = f - self.bounds[place];
            if to == goal {
                if let Some((corners, used)) = self.way_by(from) {
                    ways += usize::from(self.keep(&corners[MOST - used..], clearance.distance_m));
                }
                limit = limit.min(DEARER * f);
                if ways == WAYS {
                    break;
                }
                continue;
            }
            self.nodes[to] = Node { g, parent: from as u32, is_closed: true, ..self.nodes[to] };
            // The slot is entered at its own heading; what is known to lead there limits what else is worth a look.
            if layer + 1 == layers && place != SLOT && self.is_free(pricer, layer, (place, SLOT), slot_yaw) {
                let f =
                    g + leg_price(pricer, headings, offset(self.places[place], self.places[SLOT]), slot_yaw);
                limit = limit.min(DEARER * f);
                self.queue.push(entry(f, place + layer * count, goal, true));
            }
            for next in (0..count).filter(|&next| next != place && next > SLOT) {
                let to = next + layer * count;
                if self.nodes[to].is_closed {
                    continue;
                }
                let leg = bound(offset(self.places[place], self.places[next]));
                let f = g + leg + self.bounds[next];
                if f < limit && g + leg < self.nodes[to].offered {
                    self.queue.push(entry(f, place + layer * count, to, false));
                }
            }
            if layer + 1 < layers && self.room[place] {
                self.queue.push(entry(f + turn, to, to + count, true));
            }
        }
    }

    fn is_free(
        &mut self,
        pricer: &Pricer<'_>,
        layer: usize,
        (from, to): (usize, usize),
        yaw_rad: f64,
    ) -> bool {
        let count = self.places.len();
        let (low, high) = (from.min(to), from.max(to));
        let (from_m, to_m) = (self.places[from], self.places[to]);
        let look = || pricer.query.clearance.leg_is_free(from_m, to_m, yaw_rad);
        *self.free[(layer * count + low) * count + high].get_or_insert_with(look)
    }

    /// The way to the slot by a vertex that is closed, if it has not too many corners.
    fn way_by(&self, last: usize) -> Option<([[f64; 3]; MOST], usize)> {
        let count = self.places.len();
        let mut corners = [self.places[SLOT]; MOST];
        let (mut used, mut vertex) = (1, last);
        loop {
            used += 1;
            *corners.get_mut(MOST.checked_sub(used)?)? = self.places[vertex % count];
            if vertex == START {
                break;
            }
            vertex = self.nodes[vertex].parent as usize;
        }
        Some((corners, used))
    }

    /// Keeps a way, unless it is like one that is known.
    fn keep(&mut self, corners: &[[f64; 3]], d_m: f64) -> bool {
        let Some(way) = Polyline::new(corners) else { return false };
        let is_like = |other: &Polyline| {
            let pairs = || other.corners().iter().zip(way.corners());
            other.count == way.count && pairs().all(|(a, b)| length(offset(*a, *b)) < ALIKE * d_m)
        };
        let is_new = !self.found.iter().any(is_like);
        if is_new {
            self.found.push(way);
        }
        is_new
    }
}

fn entry(f: f64, from: usize, to: usize, looked: bool) -> Entry {
    Reverse((f.to_bits(), from as u32, 2 * to as u32 + u32::from(looked)))
}

fn leg_price(pricer: &Pricer<'_>, headings: Headings, leg_m: [f64; 3], yaw_rad: f64) -> f64 {
    let along = Direction::of(leg_m);
    match (headings, pricer.criterion) {
        (Headings::Held, _) | (_, Criterion::Euclidean) => pricer.leg(&along, yaw_rad),
        (Headings::Free, Criterion::Energy) => CHOICES
            .into_iter()
            .filter(|&mode| mode != Mode::Slot || pricer.turns())
            .map(|mode| pricer.leg(&along, pricer.heading(mode, &along)))
            .fold(f64::INFINITY, f64::min),
    }
}
