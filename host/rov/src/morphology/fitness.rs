//! Which configurations do a task, and the least that getting into one costs.
//!
//! Each service takes the place nearest to where it is wanted, of those whose kind of robot can serve it.

use std::collections::HashMap;
use std::fmt;

use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Slot};
use reconfiguration::task::{Service, Task};
use reconfiguration::vehicle::Vehicle;

use super::super::balance::balance;
use super::super::configuration::{TOUCH_M, adjacency, clusters};
use super::super::order::MOST;
use super::super::order::assignment::{Assignment, Costs};
use super::super::planner::{PlanError, engines};
use super::super::power::PowerLaw;
use super::super::propulsion::Steady;
use super::super::route::Mover;
use super::super::vector::{length, offset};
use super::growth::Place;

/// What is left of the least over sampled directions for those between.
const SAMPLING: f64 = 0.98;

/// What keeps a configuration from doing the task.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lack {
    /// A service is not in its place.
    Service,
    /// It is not one cluster.
    Connection,
    /// It cannot be balanced.
    Balance,
}

/// How many configurations lack what.
#[derive(Default)]
pub(super) struct Refused {
    services: usize,
    connection: usize,
    balance: usize,
}

impl Refused {
    /// One more.
    pub const fn count(&mut self, lack: Lack) {
        match lack {
            Lack::Service => self.services += 1,
            Lack::Connection => self.connection += 1,
            Lack::Balance => self.balance += 1,
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { services, connection, balance } = self;
        write!(
            f,
            "{services} lack a service in its place, {connection} are not one cluster, {balance} cannot be balanced"
        )
    }
}

/// See the module's documentation.
pub(super) struct Fitness<'a> {
    problem: &'a Problem,
    task: &'a Task,
    law: &'a PowerLaw,
    limits_n: (f64, f64),
    /// Least energy of a way of a metre, by vehicle, J/m.
    per_metre_j: HashMap<usize, f64>,
}

impl<'a> Fitness<'a> {
    pub fn new(
        problem: &'a Problem,
        task: &'a Task,
        law: &'a PowerLaw,
        limits_n: (f64, f64),
    ) -> Result<Self, PlanError> {
        let mut per_metre_j = HashMap::new();
        for (kind, engine) in engines(problem, law, Steady::Whole).enumerate() {
            let Some((_, propulsion)) = engine? else { continue };
            let mover = Mover::new(propulsion, &problem.rules);
            // It is least in one of many directions, or not far from one.
            let least_j = directions()
                .map(|way_m| mover.bound(Criterion::Energy, Manner::Best, way_m, 0.0))
                .fold(f64::INFINITY, f64::min);
            per_metre_j.insert(kind, SAMPLING * least_j);
        }
        Ok(Self { problem, task, law, limits_n, per_metre_j })
    }

    /// Lower bound of what a configuration costs that has these places, and more for the robots left, and does the task, J; infinite
    /// where they cannot reach a service any more.
    pub fn bound_j(&self, places: &[Place]) -> f64 {
        // One robot may do several services: each alone bounds.
        let open = self.task.services.iter().filter(|service| self.nearest(service, places).is_none());
        open.map(|service| self.filled_j(places, Some(service))).fold(self.filled_j(places, None), f64::max)
    }

    /// The nearest of the places whose kind of robot can do a service there.
    fn nearest(&self, service: &Service, places: &[Place]) -> Option<usize> {
        let robots = &self.problem.robots;
        let serves = |place: &Place| {
            robots
                .iter()
                .any(|robot| robot.vehicle == place.kind && robot.capabilities.contains(&service.capability))
        };
        let apart_m = |place: &Place| length(offset(service.place_m, place.pose.position_m));
        (0..places.len())
            .filter(|&index| serves(&places[index]) && apart_m(&places[index]) <= service.within_m)
            .min_by(|&a, &b| apart_m(&places[a]).total_cmp(&apart_m(&places[b])))
    }

    /// Lower bound of what it costs to fill the places, and to bring one robot more to a service, J.
    fn filled_j(&self, places: &[Place], open: Option<&Service>) -> f64 {
        let problem = self.problem;
        let robots = &problem.robots;
        let cost_j = |place: &Place, robot: usize| {
            let Some(per_metre_j) = self.per_metre_j.get(&place.kind) else { return f64::INFINITY };
            let matches = robots[robot].vehicle == place.kind;
            let way_m = offset(robots[robot].start.position_m, place.pose.position_m);
            if matches { per_metre_j * length(way_m) } else { f64::INFINITY }
        };
        let serving_j = |service: &Service, robot: usize| {
            let Robot { vehicle, start, capabilities, .. } = &robots[robot];
            let way_m = length(offset(start.position_m, service.place_m)) - service.within_m;
            match self.per_metre_j.get(vehicle).filter(|_| capabilities.contains(&service.capability)) {
                Some(per_metre_j) => per_metre_j * way_m.max(0.0),
                None => f64::INFINITY,
            }
        };
        if let Some(service) = open {
            // Docked centres are no farther apart than their connectors reach.
            let tools = problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle]));
            let kinds = robots.iter().map(|robot| &problem.vehicles[robot.vehicle]);
            let kinds = kinds.chain(tools.clone().map(|(_, tool)| tool));
            let reach_m = |kind: &Vehicle| {
                kind.connectors().iter().map(|own| length(own.position_m)).fold(0.0, f64::max)
            };
            let longest_m = 2.0 * kinds.map(reach_m).fold(0.0, f64::max);
            let bodies = tools.map(|(pose, _)| pose).chain(places.iter().map(|place| place.pose));
            let apart_m = bodies.map(|pose| length(offset(pose.position_m, service.place_m)));
            let left = robots.len().saturating_sub(places.len()) as f64;
            if apart_m.fold(f64::INFINITY, f64::min) > service.within_m + left * longest_m + TOUCH_M {
                return f64::INFINITY;
            }
        }
        let mut costs: Costs = [[f64::INFINITY; MOST]; MOST];
        let wanted = places.iter().map(|place| (Some(place), None));
        let rows = wanted.chain(open.map(|service| (None, Some(service))));
        for ((place, service), row) in rows.zip(&mut costs) {
            for (robot, cost) in row.iter_mut().enumerate().take(robots.len()) {
                let placing_j = place.map_or(0.0, |place| cost_j(place, robot));
                *cost = placing_j + service.map_or(0.0, |service| serving_j(service, robot));
            }
        }
        let count = places.len() + usize::from(open.is_some());
        if count > robots.len() {
            return f64::INFINITY;
        }
        Assignment::new(&costs, count, robots.len()).map_or(f64::INFINITY, |found| found.cost)
    }

    /// The configuration as slots, with its bound.
    ///
    /// # Errors
    /// What keeps it from doing the task.
    pub fn slots(&self, places: &[Place]) -> Result<(f64, Vec<Slot>), Lack> {
        let problem = self.problem;
        let mut slots: Vec<Slot> = places
            .iter()
            .map(|place| Slot { pose: place.pose, requires: self.kind_of(place.kind).into_iter().collect() })
            .collect();
        for service in &self.task.services {
            let nearest = self.nearest(service, places);
            let index = nearest.ok_or(Lack::Service)?;
            slots[index].requires.push(service.capability.clone());
        }
        let tools = problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle]));
        let robots = places.iter().map(|place| (place.pose, &problem.vehicles[place.kind]));
        let bodies: Vec<(Pose, &Vehicle)> = tools.chain(robots).collect();
        if clusters(&adjacency(&bodies)).len() > 1 {
            return Err(Lack::Connection);
        }
        if balance(&bodies, self.law, self.limits_n, &self.problem.rules).is_err() {
            return Err(Lack::Balance);
        }
        Ok((self.bound_j(places), slots))
    }

    /// What a slot asks for where there are several kinds of robots: the name of its own.
    fn kind_of(&self, kind: usize) -> Option<String> {
        let several = self.per_metre_j.len() > 1;
        several.then(|| self.problem.vehicles[kind].name.clone())
    }
}

/// The problem with a goal. Of several kinds of robots each brings its name, which slots ask for.
pub(super) fn with_slots(problem: &Problem, slots: Vec<Slot>) -> Problem {
    let mut goal = Problem { slots, ..problem.clone() };
    let mixed = problem.robots.iter().any(|robot| robot.vehicle != problem.robots[0].vehicle);
    for robot in goal.robots.iter_mut().filter(|_| mixed) {
        robot.capabilities.push(problem.vehicles[robot.vehicle].name.clone());
    }
    goal
}

/// Unit vectors all around, evenly: the golden spiral.
fn directions() -> impl Iterator<Item = [f64; 3]> {
    const COUNT: u32 = 500;
    (0..COUNT).map(|k| {
        let z = 1.0 - f64::from(2 * k + 1) / f64::from(COUNT);
        let (sin, cos) = (std::f64::consts::PI * (3.0 - 5.0_f64.sqrt()) * f64::from(k)).sin_cos();
        let level = (1.0 - z * z).sqrt();
        [level * cos, level * sin, z]
    })
}
