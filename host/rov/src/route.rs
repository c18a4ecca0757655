//! One robot's route from its start to its slot: corners, headings, speeds; as timed actions.
//!
//! By the paper's rules ([`Manner::Paper`]) the robot turns in place to the heading of every leg, swims it at constant
//! speed, and turns to the slot's heading at the end; under the energy criterion Theta* counts those turns.
//!
//! By Flotilla's ([`Manner::Best`]) Theta* runs once for a robot that holds its heading and once for one that is free to
//! choose it, and every corner path found is then given the cheapest headings: for each leg the start's, the slot's, along
//! the leg or against it, with turns only where the hull may turn. A leg may be parted where its hull first has room to
//! turn, and where it last has. Each leg and turn takes its best speed, ramps included.
//!
//! Assumptions and limits: Theta* prices legs at steady state and without turns for a robot that is free; the headings
//! are best for the path, the path is not best for the headings.

use std::cell::RefCell;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use grid::theta::Search;
use quantity::wrap_rad;
use reconfiguration::plan::{Action, ActionKind, Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Rules;

use super::clearance::Clearance;
use super::cost_per_metre::{CostPerMetre, Heading, PowerMap};
use super::propulsion::{Expense, Propulsion};
use super::search_graph::{CornerCost, Edges, Lattice, SearchGraph};
use super::vector::{length, offset, turned};

/// Headings that differ by less are the same, rad.
const SAME_RAD: f64 = 1e-9;

/// One kind of robot, with the costs of its motion under the rules of a problem.
#[derive(Clone, Debug)]
pub struct Mover {
    propulsion: Propulsion,
    /// At the paper's speed, and at all speeds.
    constant: PowerMap,
    any: PowerMap,
    costs_per_metre: RefCell<HashMap<(u64, Way), Arc<CostPerMetre>>>,
    expenses: RefCell<HashMap<[i64; 5], Option<Expense>>>,
}

/// Which cost per metre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Way {
    Paper,
    Free,
    /// Held heading, in 10⁻⁶ rad.
    Held(i64),
}

impl Mover {
    /// A mover with every direction of motion priced once.
    #[must_use]
    pub fn new(propulsion: Propulsion, rules: &Rules) -> Self {
        let constant = PowerMap::new(&propulsion, [rules.speed_m_s; 2]);
        let any = PowerMap::new(&propulsion, rules.speeds_m_s);
        Self { propulsion, constant, any, costs_per_metre: RefCell::default(), expenses: RefCell::default() }
    }

    /// What a metre costs in `way` while others draw `lambda_w`.
    fn cost_per_metre(&self, way: Way, lambda_w: f64) -> Arc<CostPerMetre> {
        let make = || match way {
            Way::Paper => CostPerMetre::energy(&self.constant, Heading::Along, lambda_w),
            Way::Free => CostPerMetre::energy(&self.any, Heading::Free, lambda_w),
            Way::Held(yaw) => CostPerMetre::energy(&self.any, Heading::Held(yaw as f64 * 1e-6), lambda_w),
        };
        self.costs_per_metre
            .borrow_mut()
            .entry((lambda_w.to_bits(), way))
            .or_insert_with(|| Arc::new(make()))
            .clone()
    }

    /// Lower bound of what any route along `way_m` costs under a criterion, J or m.
    #[must_use]
    pub fn bound(&self, criterion: Criterion, manner: Manner, way_m: [f64; 3], lambda_w: f64) -> f64 {
        let way = if manner == Manner::Paper { Way::Paper } else { Way::Free };
        match criterion {
            Criterion::Euclidean => length(way_m),
            Criterion::Energy => self.cost_per_metre(way, lambda_w).bound(way_m),
        }
    }

    fn remembered(
        &self,
        key: [f64; 4],
        lambda_w: f64,
        make: impl FnOnce() -> Option<Expense>,
    ) -> Option<Expense> {
        let [a, b, c, d] = key.map(|value| (value * 1e7).round() as i64);
        let key = [a, b, c, d, (lambda_w * 1e7).round() as i64];
        if let Some(known) = self.expenses.borrow().get(&key) {
            return *known;
        }
        let expense = make();
        self.expenses.borrow_mut().insert(key, expense);
        expense
    }

    /// A leg along `leg_m` with the heading held, at its best speed.
    fn best_leg(&self, rules: &Rules, leg_m: [f64; 3], yaw_rad: f64, lambda_w: f64) -> Option<Expense> {
        let way_m = length(leg_m);
        if way_m == 0.0 {
            return Some(Expense::default());
        }
        let body = in_body(leg_m, yaw_rad);
        let direction = body.map(|component| component / way_m);
        self.remembered([body[0], body[1], body[2], 0.0], lambda_w, || {
            let acceleration = rules.acceleration_m_s2;
            self.propulsion.best_leg(direction, way_m, rules.speeds_m_s, acceleration, lambda_w)
        })
    }

    fn best_turn(&self, rules: &Rules, angle_rad: f64, lambda_w: f64) -> Option<Expense> {
        self.remembered([0.0, 0.0, 0.0, angle_rad], lambda_w, || {
            let acceleration = rules.yaw_acceleration_rad_s2;
            self.propulsion.best_turn(angle_rad, rules.yaw_rates_rad_s, acceleration, lambda_w)
        })
    }
}

/// A route with its actions and its energy.
#[derive(Clone, Debug)]
pub struct Route {
    /// Its corners, start and slot included.
    pub path: Vec<[f64; 3]>,
    /// What the robot does, from time 0.
    pub actions: Vec<Action>,
    /// How long that takes, s.
    pub duration_s: f64,
    /// What its thrusters draw, J.
    pub energy_j: f64,
}

impl Route {
    /// Cost by a criterion: (17), or its length.
    #[must_use]
    pub fn cost(&self, criterion: Criterion, lambda_w: f64) -> f64 {
        match criterion {
            Criterion::Energy => self.energy_j + lambda_w * self.duration_s,
            Criterion::Euclidean => self.path.windows(2).map(|leg| length(offset(leg[0], leg[1]))).sum(),
        }
    }
}

/// One question for a route, with everything that the answer depends on.
pub struct RouteQuery<'a> {
    /// The robot that moves.
    pub mover: &'a Mover,
    /// Where it may move.
    pub clearance: &'a Clearance,
    /// The grid.
    pub lattice: &'a Lattice,
    /// The rules' numbers.
    pub rules: &'a Rules,
    /// What all others draw meanwhile, W.
    pub lambda_w: f64,
}

impl RouteQuery<'_> {
    /// The best route found, or `None`: then there is no way on this grid.
    #[must_use]
    pub fn route(&self, criterion: Criterion, manner: Manner, search: &mut Search) -> Option<Route> {
        let edges = Edges::new(self.lattice);
        if !self.graph(&edges, &CostPerMetre::euclidean(), None).slot_is_open() {
            return None;
        }
        match manner {
            Manner::Paper => self.by_paper(criterion, &edges, search),
            Manner::Best => self.at_best(criterion, &edges, search),
        }
    }

    fn graph<'a>(
        &'a self,
        edges: &'a Edges,
        cost_per_metre: &'a CostPerMetre,
        corner: Option<CornerCost<'a>>,
    ) -> SearchGraph<'a> {
        SearchGraph::new((self.lattice, self.clearance, edges), cost_per_metre, corner)
    }

    fn path(&self, graph: &SearchGraph<'_>, search: &mut Search) -> Option<Vec<[f64; 3]>> {
        let found = search.theta_star(graph, graph.start(), graph.slot())?;
        let mut path: Vec<[f64; 3]> = found.path.iter().map(|&vertex| graph.place_m(vertex)).collect();
        // The start may be a grid point as well.
        path.dedup_by(|b, a| length(offset(*a, *b)) < 1e-9);
        Some(path)
    }

    /// Turn in place, constant speed.
    fn by_paper(&self, criterion: Criterion, edges: &Edges, search: &mut Search) -> Option<Route> {
        let yaw_rate_rad_s = self.rules.yaw_rate_rad_s;
        let propulsion = &self.mover.propulsion;
        let [start, slot] = [&self.clearance.start, &self.clearance.slot].map(|pose| pose.yaw_rad);
        let euclidean = CostPerMetre::euclidean();
        let shortest = self.graph(edges, &euclidean, None);
        let paths = match criterion {
            Criterion::Euclidean => vec![self.path(&shortest, search)?],
            Criterion::Energy => {
                let a_radian = propulsion.turn(1.0, yaw_rate_rad_s, None)?.with_others(self.lambda_w);
                let turn = |from: f64, to: f64| a_radian * wrap_rad(to - from).abs();
                let corner = |came_m: Option<[f64; 3]>, leg_m: [f64; 3], last: bool| {
                    let before = came_m.map_or(Some(start), azimuth_rad);
                    let along = azimuth_rad(leg_m);
                    // Straight up or down the heading stays: what it was is not told, and not charged.
                    let first = before.zip(along).map_or(0.0, |(a, b)| turn(a, b));
                    first + along.filter(|_| last).map_or(0.0, |a| turn(a, slot))
                };
                // With a cost at corners Theta* is not monotone: what it finds without is sometimes cheaper.
                let cost_per_metre = self.mover.cost_per_metre(Way::Paper, self.lambda_w);
                let with = self.path(&self.graph(edges, &cost_per_metre, Some(&corner)), search)?;
                let without = self.path(&self.graph(edges, &cost_per_metre, None), search)?;
                vec![with, without, self.path(&shortest, search)?]
            }
        };
        let routes = paths.iter().filter_map(|path| self.at_constant_speed(path));
        routes.min_by(|a, b| a.cost(criterion, self.lambda_w).total_cmp(&b.cost(criterion, self.lambda_w)))
    }

    /// The paper's actions along a path.
    fn at_constant_speed(&self, path: &[[f64; 3]]) -> Option<Route> {
        let Rules { speed_m_s, yaw_rate_rad_s, .. } = *self.rules;
        let propulsion = &self.mover.propulsion;
        let slot = self.clearance.slot.yaw_rad;
        let mut timeline = Timeline::new(self.clearance.start, self.rules);
        for leg in path.windows(2) {
            let leg_m = offset(leg[0], leg[1]);
            let heading_rad = azimuth_rad(leg_m).unwrap_or(timeline.at.yaw_rad);
            let angle_rad = wrap_rad(heading_rad - timeline.at.yaw_rad);
            timeline.turn(angle_rad, propulsion.turn(angle_rad, yaw_rate_rad_s, None)?);
            let way_m = length(leg_m);
            let body = in_body(leg_m, heading_rad).map(|component| component / way_m);
            timeline.leg(leg[1], propulsion.leg(body, way_m, speed_m_s, None)?);
        }
        let angle_rad = wrap_rad(slot - timeline.at.yaw_rad);
        timeline.turn(angle_rad, propulsion.turn(angle_rad, yaw_rate_rad_s, None)?);
        Some(timeline.finish())
    }

    /// Best headings and speeds on every path worth a look.
    fn at_best(&self, criterion: Criterion, edges: &Edges, search: &mut Search) -> Option<Route> {
        let costs_per_metre = match criterion {
            Criterion::Euclidean => vec![Arc::new(CostPerMetre::euclidean())],
            Criterion::Energy => {
                let held = (wrap_rad(self.clearance.start.yaw_rad) * 1e6).round() as i64;
                vec![
                    self.mover.cost_per_metre(Way::Held(held), self.lambda_w),
                    self.mover.cost_per_metre(Way::Free, self.lambda_w),
                ]
            }
        };
        let mut paths: Vec<Vec<[f64; 3]>> = Vec::new();
        for cost_per_metre in &costs_per_metre {
            let path = self.path(&self.graph(edges, cost_per_metre, None), search)?;
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
        let parted = paths.iter().flat_map(|path| self.parted(path)).collect::<Vec<_>>();
        let routes = parted.iter().filter_map(|path| self.with_headings(path));
        routes.min_by(|a, b| {
            let price = |route: &Route| route.cost(Criterion::Energy, self.lambda_w);
            price(a).total_cmp(&price(b))
        })
    }

    /// The path, and the path with a corner more where the hull first has room to turn, last has, and both.
    fn parted(&self, path: &[[f64; 3]]) -> Vec<Vec<[f64; 3]>> {
        let first = self.first_room(path);
        let backwards: Vec<[f64; 3]> = path.iter().rev().copied().collect();
        let last = self.first_room(&backwards).map(|(leg, at_m)| (path.len() - 2 - leg, at_m));
        let with = |corners: &[Option<(usize, [f64; 3])>]| {
            let mut parted = path.to_vec();
            // From the end on, so that the places before stay where they are.
            for &(leg, at_m) in corners.iter().rev().flatten() {
                parted.insert(leg + 1, at_m);
            }
            parted
        };
        let mut all = vec![path.to_vec()];
        if first.is_some() {
            all.push(with(&[first]));
        }
        if last.is_some() {
            all.push(with(&[last]));
        }
        if let (Some((a, p)), Some((b, q))) = (first, last) {
            let in_order = a < b || (a == b && length(offset(path[a], p)) < length(offset(path[a], q)));
            if in_order {
                all.push(with(&[first, last]));
            }
        }
        all
    }

    /// The leg and the place on it where the hull first has room to turn; `None` if that is a corner, or nowhere.
    fn first_room(&self, path: &[[f64; 3]]) -> Option<(usize, [f64; 3])> {
        const STEP_M: f64 = 0.02;
        for (index, leg) in path.windows(2).enumerate() {
            if self.clearance.turn_is_free(leg[0]) {
                return None;
            }
            let leg_m = offset(leg[0], leg[1]);
            let steps = (length(leg_m) / STEP_M).floor() as usize;
            for step in 1..=steps {
                let share = step as f64 * STEP_M / length(leg_m);
                let at_m = std::array::from_fn(|k| leg[0][k] + share * leg_m[k]);
                if share < 1.0 - 1e-9 && self.clearance.turn_is_free(at_m) {
                    return Some((index, at_m));
                }
            }
        }
        None
    }

    /// The cheapest headings for a path: over the legs in order, the least cost of ending each at each heading.
    fn with_headings(&self, path: &[[f64; 3]]) -> Option<Route> {
        const CHOICES: usize = 4;
        let [start, slot] = [self.clearance.start.yaw_rad, self.clearance.slot.yaw_rad];
        // The paper's turn, priced: whether it is allowed, and what it takes.
        let turn = |from: f64, to: f64, at_m: [f64; 3]| {
            let angle_rad = wrap_rad(to - from);
            if angle_rad.abs() < SAME_RAD {
                return Some(0.0);
            }
            let expense = self.mover.best_turn(self.rules, angle_rad, self.lambda_w)?;
            self.clearance.turn_is_free(at_m).then(|| expense.with_others(self.lambda_w))
        };
        let mut ends = vec![(start, 0.0, usize::MAX)];
        let mut stages: Vec<Vec<(f64, f64, usize)>> = Vec::with_capacity(path.len() - 1);
        for leg in path.windows(2) {
            let leg_m = offset(leg[0], leg[1]);
            let along = azimuth_rad(leg_m).unwrap_or(start);
            let headings: [f64; CHOICES] = [start, slot, along, wrap_rad(along + PI)];
            let mut stage = Vec::with_capacity(CHOICES);
            for heading in headings {
                let Some(swum) = self.mover.best_leg(self.rules, leg_m, heading, self.lambda_w) else {
                    continue;
                };
                if !self.clearance.leg_is_free(leg[0], leg[1], heading) {
                    continue;
                }
                let come = ends.iter().enumerate().filter_map(|(index, &(before, cost, _))| {
                    Some((index, cost + turn(before, heading, leg[0])?))
                });
                if let Some((index, cost)) = come.min_by(|a, b| a.1.total_cmp(&b.1)) {
                    stage.push((heading, cost + swum.with_others(self.lambda_w), index));
                }
            }
            stages.push(stage.clone());
            ends = stage;
        }
        let last_m = *path.last()?;
        let finals = ends
            .iter()
            .enumerate()
            .filter_map(|(index, &(heading, cost, _))| Some((index, cost + turn(heading, slot, last_m)?)));
        let (mut index, _) = finals.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut headings = vec![0.0; stages.len()];
        for (heading, stage) in headings.iter_mut().zip(&stages).rev() {
            *heading = stage[index].0;
            index = stage[index].2;
        }
        let mut timeline = Timeline::new(self.clearance.start, self.rules);
        let turn_to = |timeline: &mut Timeline, heading: f64| {
            let angle_rad = wrap_rad(heading - timeline.at.yaw_rad);
            if angle_rad.abs() >= SAME_RAD {
                let expense = self.mover.best_turn(self.rules, angle_rad, self.lambda_w)?;
                timeline.turn(angle_rad, expense);
            }
            Some(())
        };
        for (leg, &heading) in path.windows(2).zip(&headings) {
            turn_to(&mut timeline, heading)?;
            let leg_m = offset(leg[0], leg[1]);
            let swum = self.mover.best_leg(self.rules, leg_m, timeline.at.yaw_rad, self.lambda_w)?;
            timeline.leg(leg[1], swum);
        }
        turn_to(&mut timeline, slot)?;
        Some(timeline.finish())
    }
}

/// Actions, one after the other.
struct Timeline {
    at: Pose,
    dock_s: f64,
    path: Vec<[f64; 3]>,
    actions: Vec<Action>,
    now_s: f64,
    energy_j: f64,
}

impl Timeline {
    fn new(start: Pose, rules: &Rules) -> Self {
        let mut timeline = Self {
            at: start,
            dock_s: rules.dock_s,
            path: vec![start.position_m],
            actions: Vec::new(),
            now_s: 0.0,
            energy_j: 0.0,
        };
        timeline.pause(ActionKind::Undock, rules.undock_s);
        timeline
    }

    fn pause(&mut self, kind: ActionKind, duration_s: f64) {
        self.push(kind, self.at, Expense { duration_s, ..Expense::default() });
    }

    fn turn(&mut self, angle_rad: f64, expense: Expense) {
        if angle_rad.abs() >= SAME_RAD {
            let to = Pose { yaw_rad: wrap_rad(self.at.yaw_rad + angle_rad), ..self.at };
            self.push(ActionKind::Turn, to, expense);
        }
    }

    fn leg(&mut self, to_m: [f64; 3], expense: Expense) {
        self.path.push(to_m);
        let to = Pose { position_m: to_m, ..self.at };
        self.push(ActionKind::Leg, to, expense);
    }

    fn push(&mut self, kind: ActionKind, to: Pose, expense: Expense) {
        let Expense { duration_s, energy_j, speed, acceleration } = expense;
        let (from, start_s) = (self.at, self.now_s);
        self.actions.push(Action { kind, start_s, duration_s, from, to, speed, acceleration, energy_j });
        self.at = to;
        self.now_s += duration_s;
        self.energy_j += energy_j;
    }

    fn finish(mut self) -> Route {
        self.pause(ActionKind::Dock, self.dock_s);
        let Self { path, actions, now_s, energy_j, .. } = self;
        Route { path, actions, duration_s: now_s, energy_j }
    }
}

/// Heading of a leg; `None` straight up or down.
fn azimuth_rad([x, y, _]: [f64; 3]) -> Option<f64> {
    (x.hypot(y) > 1e-9).then(|| y.atan2(x))
}

/// A world vector in the body of a level robot.
fn in_body(vector: [f64; 3], yaw_rad: f64) -> [f64; 3] {
    turned(vector, -yaw_rad)
}
