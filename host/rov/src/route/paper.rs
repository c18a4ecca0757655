//! Routes by the paper's rules: Basic Theta* on the regular grid; turns in place to the heading of every leg, constant
//! speed, and a turn to the slot's heading at the end. A robot that is to face about where it rests, and has no room there, swims out to
//! the nearest place that has, and back. Under the energy criterion Theta* counts those turns.

use grid::theta::Search;
use quantity::wrap_rad;
use reconfiguration::plan::Criterion;
use reconfiguration::problem::Rules;

use super::super::clearance::Clearance;
use super::super::cost_per_metre::CostPerMetre;
use super::super::search_graph::{CornerCost, Edges, Lattice, SearchGraph};
use super::super::vector::{length, offset};
use super::timeline::Timeline;
use super::{Route, RouteQuery, SAME_RAD, azimuth_rad, in_body};

/// The best of the paths that Theta* finds.
pub(super) fn route(query: &RouteQuery<'_>, criterion: Criterion, search: &mut Search) -> Option<Route> {
    let [start, slot] = [&query.clearance.start, &query.clearance.slot];
    let turns = wrap_rad(start.yaw_rad - slot.yaw_rad).abs() >= SAME_RAD;
    let lattice = query.lattice.around_bodies(query.clearance);
    if turns && length(offset(start.position_m, slot.position_m)) < 1e-9 {
        if query.clearance.turn_is_free(start.position_m) {
            return at_constant_speed(query, &[start.position_m]);
        }
        return out_and_back(&lattice.with_docks(query.clearance, query.rules.grid_divisions), query);
    }
    // Docks turned against the grid, or between its points, may be closed to it.
    on(&lattice, query, criterion, search).or_else(|| {
        on(&lattice.clone().with_docks(query.clearance, query.rules.grid_divisions), query, criterion, search)
    })
}

/// Straight out to the nearest grid point with room to turn, and back as in the slot: for a robot that is to face about where it is.
fn out_and_back(lattice: &Lattice, query: &RouteQuery<'_>) -> Option<Route> {
    let Clearance { start, slot, .. } = query.clearance;
    let mut out: Vec<(f64, [f64; 3])> = lattice
        .places_m()
        .map(|place_m| (length(offset(start.position_m, place_m)), place_m))
        .filter(|(way_m, _)| *way_m > 1e-9)
        .collect();
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_open = |place_m: [f64; 3]| {
        query.clearance.turn_is_free(place_m)
            && query.clearance.leg_is_free(start.position_m, place_m, start.yaw_rad)
            && query.clearance.leg_is_free(place_m, slot.position_m, slot.yaw_rad)
    };
    let (_, turn_m) = out.into_iter().find(|(_, place_m)| is_open(*place_m))?;
    at_constant_speed(query, &[start.position_m, turn_m, slot.position_m])
}

/// The best of the paths that Theta* finds on a grid.
fn on(lattice: &Lattice, query: &RouteQuery<'_>, criterion: Criterion, search: &mut Search) -> Option<Route> {
    let [start, slot] = [&query.clearance.start, &query.clearance.slot];
    let edges = Edges::new(lattice);
    let graph =
        |cost_per_metre, corner| SearchGraph::new((lattice, query.clearance, &edges), cost_per_metre, corner);
    let euclidean = CostPerMetre::euclidean();
    let shortest = graph(&euclidean, None);
    if !shortest.slot_is_open() {
        return None;
    }
    let yaw_rate_rad_s = query.rules.yaw_rate_rad_s;
    let paths = match criterion {
        Criterion::Euclidean => vec![path(&shortest, search)?],
        Criterion::Energy => {
            let a_radian =
                query.mover.propulsion.turn(1.0, yaw_rate_rad_s, None)?.with_others(query.lambda_w);
            let turn = |from: f64, to: f64| a_radian * wrap_rad(to - from).abs();
            let corner = |came_m: Option<[f64; 3]>, leg_m: [f64; 3], last: bool| {
                let before = came_m.map_or(Some(start.yaw_rad), azimuth_rad);
                let along = azimuth_rad(leg_m);
                // Straight up or down the heading stays: what it was is not told, and not charged.
                let first = before.zip(along).map_or(0.0, |(a, b)| turn(a, b));
                first + along.filter(|_| last).map_or(0.0, |a| turn(a, slot.yaw_rad))
            };
            // With a cost at corners Theta* is not monotone: what it finds without is sometimes cheaper.
            let cost_per_metre = query.mover.paper_cost_per_metre(query.lambda_w);
            let corner: CornerCost<'_> = &corner;
            let with = path(&graph(&cost_per_metre, Some(corner)), search)?;
            let without = path(&graph(&cost_per_metre, None), search)?;
            vec![with, without, path(&shortest, search)?]
        }
    };
    let routes = paths.iter().filter_map(|path| at_constant_speed(query, path));
    routes.min_by(|a, b| a.cost(criterion, query.lambda_w).total_cmp(&b.cost(criterion, query.lambda_w)))
}

fn path(graph: &SearchGraph<'_>, search: &mut Search) -> Option<Vec<[f64; 3]>> {
    let found = search.theta_star(graph, graph.start(), graph.slot())?;
    let mut path: Vec<[f64; 3]> = found.path.iter().map(|&vertex| graph.place_m(vertex)).collect();
    // The start may be a grid point as well.
    path.dedup_by(|b, a| length(offset(*a, *b)) < 1e-9);
    Some(path)
}

/// The paper's actions along a path.
fn at_constant_speed(query: &RouteQuery<'_>, path: &[[f64; 3]]) -> Option<Route> {
    let Rules { speed_m_s, yaw_rate_rad_s, .. } = *query.rules;
    let propulsion = &query.mover.propulsion;
    let mut timeline = Timeline::new(query.clearance.start, query.rules);
    for leg in path.windows(2) {
        let leg_m = offset(leg[0], leg[1]);
        let heading_rad = azimuth_rad(leg_m).unwrap_or(timeline.at.yaw_rad);
        let angle_rad = wrap_rad(heading_rad - timeline.at.yaw_rad);
        timeline.turn(angle_rad, propulsion.turn(angle_rad, yaw_rate_rad_s, None)?);
        let way_m = length(leg_m);
        let body = in_body(leg_m, heading_rad).map(|component| component / way_m);
        timeline.leg(leg[1], propulsion.leg(body, way_m, speed_m_s, None)?);
    }
    let angle_rad = wrap_rad(query.clearance.slot.yaw_rad - timeline.at.yaw_rad);
    timeline.turn(angle_rad, propulsion.turn(angle_rad, yaw_rate_rad_s, None)?);
    Some(timeline.finish())
}
