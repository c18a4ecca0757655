//! Routes by Flotilla's rules: straight where that is free, around the bodies otherwise; the cheapest headings, and both refined.
//!
//! 1. The straight line, with a corner more where the hull first has room to turn, where it last has, and both. If a choice of headings makes it free, that is
//!    the way: no grid, no graph.
//! 2. Otherwise the sparse graph gives a few ways, for a robot that holds its heading and for one that is free to choose, parted alike.
//! 3. The cheapest are refined: corners and headings together, each leg and turn at its best speed, ramps included.
//!
//! Assumptions and limits: the graph bends at [`waypoints`](super::waypoints) only. A passage that takes more bends than those is not seen.

use reconfiguration::plan::Criterion;

use super::super::clearance::Clearance;
use super::super::vector::{length, offset};
use super::fares::Direction;
use super::polyline::{CHOICES, Polyline, Pricer};
use super::refine::{finely, roughly};
use super::sparse::{Headings, Sparse};
use super::{Route, RouteQuery};

/// Ways that are refined, and how much dearer than the cheapest they may be before.
const REFINED: usize = 5;
const DEARER: f64 = 1.12;
/// Ways that are refined to the end, and how much dearer than the cheapest they may be by then.
const FINISHED: usize = 2;
const CLOSE: f64 = 1.01;
/// How much dearer than in open water the straight line may be to be the way at once.
const OPEN: f64 = 1.03;
/// Steps along a leg in which room to turn is looked for, in d.
const STEP: f64 = 0.03;

/// The cheapest route found.
pub(super) fn route(query: &RouteQuery<'_>, criterion: Criterion, sparse: &mut Sparse) -> Option<Route> {
    let pricer = Pricer::new(query, criterion);
    let mut ways = Vec::with_capacity(8 * REFINED);
    let straight = Polyline::new(&[query.clearance.start.position_m, query.clearance.slot.position_m])?;
    add_parted(&pricer, &straight, &mut ways);
    if !is_open(&pricer, &ways) {
        sparse.begin(&pricer);
        sparse.search(&pricer, Headings::Held);
        if !sparse.found.is_empty() && criterion == Criterion::Energy {
            sparse.search(&pricer, Headings::Free);
        }
        for way in &sparse.found {
            add_parted(&pricer, way, &mut ways);
        }
    }
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    let limit = DEARER * ways.first()?.0;
    let mut chosen: Vec<(f64, Polyline)> = Vec::with_capacity(REFINED);
    for (price, way) in ways.drain(..).filter(|way| way.0 <= limit).take(REFINED) {
        let (way, price) = roughly(&pricer, way, price);
        chosen.push((price, way));
    }
    chosen.sort_by(|a, b| a.0.total_cmp(&b.0));
    // What is close after large steps may be changed about by small ones.
    let limit = CLOSE * chosen.first()?.0;
    chosen.retain(|way| way.0 <= limit);
    chosen.truncate(FINISHED);
    let mut rival = f64::INFINITY;
    for (price, way) in &mut chosen {
        (*way, *price) = finely(&pricer, *way, *price, rival);
        rival = rival.min(*price);
    }
    chosen.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Where the corners are now, other headings may be cheaper.
    ways = Vec::with_capacity(4);
    let (price, way) = *chosen.first()?;
    add_parted(&pricer, &way, &mut ways);
    let again = ways.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).filter(|way| way.0 < 1.02 * price);
    if let Some((price, way)) = again {
        let (way, price) = roughly(&pricer, way, price);
        let (way, price) = finely(&pricer, way, price, rival);
        chosen.push((price, way));
        chosen.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    // The table that chose them is some 2 % off.
    let routes = chosen.iter().take(2).filter_map(|(_, way)| pricer.route(way));
    routes.min_by(|a, b| {
        let price = |route: &Route| route.cost(criterion, query.lambda_w);
        price(a).total_cmp(&price(b))
    })
}

/// Whether the straight line costs little more than it would with room to turn everywhere and no hull beside it.
fn is_open(pricer: &Pricer<'_>, ways: &[(f64, Polyline)]) -> bool {
    let (start, slot) = (&pricer.query.clearance.start, &pricer.query.clearance.slot);
    let along = Direction::of(offset(start.position_m, slot.position_m));
    let free = CHOICES.iter().map(|&mode| {
        let yaw_rad = pricer.heading(mode, &along);
        pricer.turn(start.yaw_rad, yaw_rad) + pricer.leg(&along, yaw_rad) + pricer.turn(yaw_rad, slot.yaw_rad)
    });
    let limit = OPEN * free.fold(f64::INFINITY, f64::min);
    ways.iter().any(|way| way.0 <= limit)
}

/// The way, and the way with a corner more where the hull first has room to turn, last has, and both; each with its cheapest headings, if
/// any are free.
fn add_parted(pricer: &Pricer<'_>, way: &Polyline, ways: &mut Vec<(f64, Polyline)>) {
    let clearance = pricer.query.clearance;
    let first = first_room(clearance, way.corners());
    let last = {
        let mut backwards = *way;
        backwards.points[..way.count].reverse();
        first_room(clearance, backwards.corners()).map(|(leg, at_m)| (way.count - 2 - leg, at_m))
    };
    let mut add = |parted: Option<Polyline>| {
        let Some(mut parted) = parted else { return };
        if let Some(price) = pricer.choose(&mut parted) {
            ways.push((price, parted));
        }
    };
    add(Some(*way));
    let with_last = last.and_then(|(leg, at_m)| way.with(leg, at_m));
    add(with_last);
    if let Some((leg, at_m)) = first {
        add(way.with(leg, at_m));
        if let (Some((after, to_m)), Some(with_last)) = (last, with_last) {
            let from_m = way.points[leg];
            let in_order =
                leg < after || (leg == after && length(offset(from_m, at_m)) < length(offset(from_m, to_m)));
            if in_order {
                add(with_last.with(leg, at_m));
            }
        }
    }
}

/// The leg and the place on it where the hull first has room to turn; `None` if that is a corner, or nowhere.
fn first_room(clearance: &Clearance, corners: &[[f64; 3]]) -> Option<(usize, [f64; 3])> {
    for (index, leg) in corners.windows(2).enumerate() {
        if clearance.turn_is_free(leg[0]) {
            return None;
        }
        let leg_m = offset(leg[0], leg[1]);
        let share = STEP * clearance.distance_m / length(leg_m);
        let mut along = share;
        while along < 1.0 - 1e-9 {
            let at_m = std::array::from_fn(|k| leg[0][k] + along * leg_m[k]);
            if clearance.turn_is_free(at_m) {
                return Some((index, at_m));
            }
            along += share;
        }
    }
    None
}
