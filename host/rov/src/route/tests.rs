//! Routes against a grid ten times finer, legs against a search of all speeds, bounds against what moves cost, open water.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use reconfiguration::plan::ActionKind;
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;

use super::*;
use crate::clearance::Resting;
use crate::cost_per_metre::{CostPerMetre, Heading, PowerMap};
use crate::power::PowerLaw;
use crate::propulsion::{Propulsion, Steady};
use crate::search_graph::{Edges, SearchGraph};
use polyline::{Polyline, Pricer};

const BATTERY_V: f64 = 16.0;

fn vehicle() -> Vehicle {
    Vehicle::built_in("bluerov1").expect("it comes with the program")
}

fn propulsion(steady: Steady) -> Propulsion {
    let law = PowerLaw::fitted(BATTERY_V).expect("in the table");
    Propulsion::new(&vehicle(), law, &Rules::default(), steady).expect("six thrusters")
}

fn water(resting: Vec<Resting>, start: Pose, slot: Pose, bounds_m: [[f64; 3]; 2]) -> Clearance {
    let half_m = vehicle().box_m.map(|side| side / 2.0);
    Clearance { resting, half_m, start, slot, distance_m: 3.0 * half_m[0], water: bounds_m.into() }
}

/// Evenly in the cube of that half side.
fn vector(rng: &mut ChaCha8Rng, size: f64) -> [f64; 3] {
    [0.0; 3].map(|_: f64| rng.random_range(-size..size))
}

#[test]
fn legs_and_turns_cost_what_the_best_of_all_speeds_costs() {
    let rules = Rules::default();
    let mover = Mover::new(propulsion(Steady::Whole), &rules);
    let seed = 3;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for case in 0..150 {
        let lambda_w = [0.0, 0.5, 3.0, 20.0, 100.0][case % 5];
        let leg_m = vector(&mut rng, [0.1, 0.5, 2.0][case % 3]);
        let yaw_rad = rng.random_range(-3.0..3.0);
        let way_m = length(leg_m);
        let direction = in_body(leg_m, yaw_rad).map(|part| part / way_m);
        let a = rules.acceleration_m_s2;
        let best = mover.propulsion.best_leg(direction, way_m, rules.speeds_m_s, a, lambda_w);
        let angle_rad = rng.random_range(-3.0..3.0);
        let a = rules.yaw_acceleration_rad_s2;
        let turn = mover.propulsion.best_turn(angle_rad, rules.yaw_rates_rad_s, a, lambda_w);
        let pairs = [
            (mover.leg(leg_m, yaw_rad, lambda_w), best, mover.leg_price(leg_m, yaw_rad, lambda_w)),
            (mover.turn(angle_rad, lambda_w), turn, mover.turn_price(angle_rad, lambda_w)),
        ];
        for (own, best, price) in pairs {
            let [own, best] = [own, best].map(|e| e.expect("within the limits").with_others(lambda_w));
            let what = format!("seed {seed}, case {case}, λ = {lambda_w} W");
            assert!(own <= best * 1.002, "{what}: {own} J, at the best speed {best} J");
            assert!((price / own - 1.0).abs() < 0.04, "{what}: {price} J by the table, {own} J");
        }
    }
}

/// Moves of up to four legs at any heading, with the turns between them.
#[test]
fn no_move_is_cheaper_than_its_bound() {
    let rules = Rules::default();
    let mover = Mover::new(propulsion(Steady::Whole), &rules);
    let seed = 4;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut nearest = f64::INFINITY;
    for case in 0..3000 {
        let lambda_w = [0.0, 0.3, 1.5, 8.0, 60.0, 3000.0][case % 6];
        let way_m = vector(&mut rng, [0.05, 0.5, 3.0, 30.0][case / 6 % 4]);
        let (mut sum_j, mut done_m, mut heading) = (0.0, [0.0; 3], None);
        for left in (1..=rng.random_range(1..=4)).rev() {
            let aside = vector(&mut rng, 0.3 * length(way_m));
            let leg_m = std::array::from_fn(|k| {
                if left == 1 {
                    way_m[k] - done_m[k]
                } else {
                    (way_m[k] - done_m[k]) / f64::from(left) + aside[k]
                }
            });
            // Often ahead, which is cheap.
            let ahead = azimuth_rad(leg_m).unwrap_or(0.0);
            let yaw_rad = if rng.random_bool(0.5) { ahead } else { rng.random_range(-3.0..3.0) };
            let turn_rad = heading.map_or(0.0, |from: f64| quantity::wrap_rad(yaw_rad - from));
            let parts = [mover.turn(turn_rad, lambda_w), mover.leg(leg_m, yaw_rad, lambda_w)];
            sum_j +=
                parts.map(|part| part.expect("within the limits").with_others(lambda_w)).iter().sum::<f64>();
            done_m = std::array::from_fn(|k| done_m[k] + leg_m[k]);
            heading = Some(yaw_rad);
        }
        let bound_j = mover.bound(Criterion::Energy, Manner::Best, way_m, lambda_w);
        assert!(
            bound_j <= sum_j * (1.0 + 1e-9),
            "seed {seed}, case {case}, λ = {lambda_w} W: bound {bound_j} J above {sum_j} J along {way_m:?}"
        );
        nearest = nearest.min(sum_j / bound_j);
    }
    assert!(nearest < 1.05, "nearest {nearest}: these moves do not try the bound");
}

/// One to three bodies between start and slot, in water as deep as the hull: one layer, so that the fine grid is searched in a moment.
fn scene(rng: &mut ChaCha8Rng) -> Clearance {
    let half_m = vehicle().box_m.map(|side| side / 2.0);
    let bounds_m = [[-1.7, -1.5, -half_m[2]], [1.7, 1.5, half_m[2]]];
    let pose = |x: f64, y: f64, yaw_rad: f64| Pose { position_m: [x, y, 0.0], yaw_rad };
    let yaw_rad = rng.random_range(-3.0..3.0);
    let start = pose(-1.2, rng.random_range(-0.6..0.6), yaw_rad);
    let slot = pose(1.2, rng.random_range(-0.6..0.6), yaw_rad);
    let bodies = (0..rng.random_range(1..=3)).map(|_| {
        let at = pose(rng.random_range(-0.6..0.6), rng.random_range(-1.0..1.0), rng.random_range(-3.0..3.0));
        Resting { pose: at, half_m }
    });
    water(bodies.collect(), start, slot, bounds_m)
}

/// Theta* on a grid ten times finer than the paper's, at the start's heading and at the cheapest one, with the cheapest headings for what it
/// finds: it shares the price of a leg and of a turn with the route finder, and nothing that chooses a way.
fn by_fine_grid(query: &RouteQuery<'_>, map: &PowerMap) -> Option<f64> {
    let edges = Edges::new(query.lattice);
    let pricer = Pricer { query, criterion: Criterion::Energy };
    let mut search = Search::new();
    let headings = [Heading::Held(query.clearance.start.yaw_rad), Heading::Free];
    let costs = headings.iter().filter_map(|&heading| {
        let cost_per_metre = CostPerMetre::energy(map, heading, query.lambda_w);
        let graph = SearchGraph::new((query.lattice, query.clearance, &edges), &cost_per_metre, None);
        let found = search.theta_star(&graph, graph.start(), graph.slot())?;
        let corners: Vec<[f64; 3]> = found.path.iter().map(|&vertex| graph.place_m(vertex)).collect();
        let mut way = Polyline::new(&corners)?;
        pricer.choose(&mut way)?;
        Some(pricer.route(&way)?.cost(Criterion::Energy, query.lambda_w))
    });
    costs.min_by(f64::total_cmp)
}

#[test]
fn no_route_is_dearer_than_on_a_grid_ten_times_finer() {
    const SCENES: u64 = 75;
    let rules = Rules::default();
    let mover = Mover::new(propulsion(Steady::Whole), &rules);
    let map = PowerMap::new(&mover.propulsion, rules.speeds_m_s);
    let cell_m = std::array::from_fn(|k| vehicle().box_m[k] / (10.0 * f64::from(rules.grid_divisions[k])));
    let mut scratch = Scratch::default();
    let (mut bent, mut ratios) = (0, Vec::new());
    for seed in 0..SCENES {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let clearance = scene(&mut rng);
        let lattice = Lattice::new(clearance.start.position_m, cell_m, clearance.water.extent_m());
        let lambda_w = [0.5, 2.0, 8.0][seed as usize % 3];
        let query =
            RouteQuery { mover: &mover, clearance: &clearance, lattice: &lattice, rules: &rules, lambda_w };
        let route = query.route(Criterion::Energy, Manner::Best, &mut scratch);
        let Some(fine) = by_fine_grid(&query, &map) else { continue };
        let route = route.unwrap_or_else(|| panic!("seed {seed}: no route, on the grid {fine} J"));
        bent += usize::from(route.path.len() > 2);
        let own = route.cost(Criterion::Energy, lambda_w);
        assert!(own <= fine * 1.002, "seed {seed}: {own} J, on the fine grid {fine} J");
        ratios.push(own / fine);
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!("{} scenes, {bent} with corners: {mean:.4} of the fine grid on average", ratios.len());
    assert!(ratios.len() >= 50 && bent >= 30, "{} scenes, {bent} with corners", ratios.len());
}

/// A square kilometre of water 40 m deep: nothing is set aside for it.
#[test]
fn open_water_costs_nothing() {
    let rules = Rules::default();
    let bounds_m = [[-500.0, -500.0, 0.0], [500.0, 500.0, 40.0]];
    let cell_m = [0.12, 0.11, 0.13];
    let lattice = Lattice::new([0.0, 0.0, 5.0], cell_m, bounds_m);
    for (start, slot) in [
        ([0.0, 0.0, 5.0, 0.0], [5.0, 0.0, 5.0, 0.0]),
        ([-400.0, -450.0, 5.0, 0.0], [450.0, 470.0, 30.0, 2.0]),
    ] {
        let clearance = water(Vec::new(), start.into(), slot.into(), bounds_m);
        for (manner, steady) in [(Manner::Paper, Steady::Published), (Manner::Best, Steady::Whole)] {
            let mover = Mover::new(propulsion(steady), &rules);
            let query = RouteQuery {
                mover: &mover,
                clearance: &clearance,
                lattice: &lattice,
                rules: &rules,
                lambda_w: 0.5,
            };
            let mut scratch = Scratch::default();
            let route = query.route(Criterion::Euclidean, manner, &mut scratch).expect("open water");
            let legs = route.actions.iter().filter(|action| action.kind == ActionKind::Leg).count();
            assert_eq!((legs, route.path.len()), (1, 2), "{manner:?}");
            assert!(scratch.search.bytes() < 40_000_000, "{} bytes", scratch.search.bytes());
        }
    }
}
