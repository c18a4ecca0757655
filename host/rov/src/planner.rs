//! The whole planner, p1 and p2 of section VII: from a problem to a plan.
//!
//! | part | where |
//! |---|---|
//! | which configurations can wait, and what that draws | [`balance`](super::balance) |
//! | one robot's route | [`route`](super::route); by the paper's rules over [`search_graph`](super::search_graph), Theta* of [`grid`] |
//! | the order of moves, and robots to slots | [`super::order`] |
//!
//! Pure: the same problem gives the same plan.

use std::collections::HashMap;

use reconfiguration::plan::{Criterion, Holding, Manner, Move, Placed, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot};
use reconfiguration::vehicle::Vehicle;
use thiserror::Error;

use super::balance::{Balance, Unbalanced, balance};
use super::clearance::{Clearance, Resting};
use super::conditions::{Conditions, admits};
use super::order::{self, MoveCosts, NoOrder, Order, State};
use super::power::{self, PowerError, PowerLaw};
use super::propulsion::{Propulsion, PropulsionError, Steady};
use super::route::{Mover, Route, RouteQuery, Scratch};
use super::search_graph::Lattice;
use super::vector::{length, offset};

/// Moves priced at most before the best order known is returned unproved.
pub const PATIENCE: usize = 20_000;

/// How the order of moves and the assignment are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OrderRule {
    /// The least g + h moves next.
    Paper,
    /// The least sum over all orders and assignments.
    Exact,
}

/// What to plan: criterion, manner of motion, rule for the order, power law.
#[derive(Clone, Debug)]
pub struct Request {
    /// What is minimised.
    pub criterion: Criterion,
    /// How robots move.
    pub manner: Manner,
    /// How the order is found.
    pub order: OrderRule,
    /// What thrust costs.
    pub law: PowerLaw,
}

/// A plan and what is known of it.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The plan.
    pub plan: Plan,
    /// Its cost by the criterion, J or m.
    pub cost: f64,
    /// The same for the order of the paper's rule, where that leads to the end.
    pub rule_cost: Option<f64>,
    /// Whether no order and assignment is cheaper, given these routes.
    pub proved: bool,
    /// How many moves were priced.
    pub priced: usize,
}

/// Why there is no plan.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PlanError {
    /// Its thrusters' forces cannot be computed.
    #[error("{vehicle}: {source}")]
    Propulsion { vehicle: String, source: PropulsionError },
    /// Nothing is known of the thrusters at this voltage.
    #[error(transparent)]
    Power(#[from] PowerError),
    /// More than the order can be decided for.
    #[error("{count} robots or slots: at most {} can be ordered", order::MOST)]
    TooMany { count: usize },
    /// The paper's rule leads into a dead end.
    #[error("after {moves} moves by the paper's rule no robot can move (exact order may know better)")]
    DeadEnd { moves: usize },
    /// The search for an order was given up: the goal may be reachable or not.
    #[error("no order of moves to the goal was found among {priced} moves priced; there may be one")]
    OutOfPatience { priced: usize },
    /// No order of moves leads to the goal.
    #[error("the goal cannot be reached: {why} ({states} configurations searched, every one there is)")]
    Unreachable { why: String, states: usize },
}

/// Plans a reconfiguration.
pub fn plan(problem: &Problem, request: &Request) -> Result<Planned, PlanError> {
    let count = problem.robots.len().max(problem.slots.len());
    if count > order::MOST {
        return Err(PlanError::TooMany { count });
    }
    let mut pricer = MovePricer::new(problem, request)?;
    let rule = order::by_paper(&mut pricer);
    let rule_cost = rule.as_ref().ok().map(|order| order.cost);
    let order = match (request.order, rule) {
        (OrderRule::Paper, rule) => rule.map_err(|moves| PlanError::DeadEnd { moves })?,
        (OrderRule::Exact, rule) => {
            order::exact(&mut pricer, rule.ok(), PATIENCE).map_err(|none| match none {
                NoOrder::Proved { states } => PlanError::Unreachable { why: pricer.obstacle(), states },
                NoOrder::OutOfPatience => PlanError::OutOfPatience { priced: PATIENCE },
            })?
        }
    };
    let plan = pricer.write(&order);
    Ok(Planned { plan, cost: order.cost, rule_cost, proved: order.proved, priced: order.priced })
}

/// A configuration that waits: robots that have moved or move now, one bit each, and what is in the slots.
type Waiting = (u16, [u8; order::MOST]);

/// Computes and keeps balances, routes and costs of moves.
struct MovePricer<'a> {
    problem: &'a Problem,
    request: &'a Request,
    /// By vehicle; none for tools.
    movers: Vec<Option<Mover>>,
    lattice: Lattice,
    limits_n: (f64, f64),
    /// What every waiting cluster draws at least, W.
    lambda_least_w: f64,
    balances: HashMap<Waiting, Result<Balance, Unbalanced>>,
    routes: HashMap<(State, usize, usize), Option<Route>>,
    scratch: Scratch,
}

impl<'a> MovePricer<'a> {
    fn new(problem: &'a Problem, request: &'a Request) -> Result<Self, PlanError> {
        let rules = &problem.rules;
        let steady = match request.manner {
            Manner::Paper => Steady::Published,
            Manner::Best => Steady::Whole,
        };
        let mut movers = Vec::with_capacity(problem.vehicles.len());
        for (index, vehicle) in problem.vehicles.iter().enumerate() {
            let swims = problem.robots.iter().any(|robot| robot.vehicle == index);
            let mover = swims
                .then(|| Propulsion::new(vehicle, request.law.clone(), rules.battery_v, steady))
                .transpose()
                .map_err(|source| PlanError::Propulsion { vehicle: vehicle.name.clone(), source })?;
            movers.push(mover.map(|propulsion| Mover::new(propulsion, rules)));
        }
        // Docked poses lie on the grid when it divides the box.
        let box_m = problem.robots.first().map_or([1.0; 3], |robot| problem.vehicles[robot.vehicle].box_m);
        let cell_m = std::array::from_fn(|k| box_m[k] / f64::from(rules.grid_divisions[k].max(1)));
        let anchor_m = problem.robots.first().map_or([0.0; 3], |robot| robot.start.position_m);
        let lattice = Lattice::new(anchor_m, cell_m, problem.bounds_m());
        let limits_n = power::limits_n(rules.battery_v)?;
        let mut pricer = Self {
            problem,
            request,
            movers,
            lattice,
            limits_n,
            lambda_least_w: 0.0,
            balances: HashMap::new(),
            routes: HashMap::new(),
            scratch: Scratch::default(),
        };
        pricer.lambda_least_w = pricer.least_balance_w();
        Ok(pricer)
    }

    fn vehicle(&self, robot: usize) -> &'a Vehicle {
        &self.problem.vehicles[self.problem.robots[robot].vehicle]
    }

    /// Tools, robots that have not moved and do not move now, and robots in slots; with the robot's index where it has
    /// one.
    fn bodies(&self, moved: u16, filled: &[u8; order::MOST]) -> Vec<(Pose, &'a Vehicle)> {
        let problem = self.problem;
        let tools = problem.tools.iter().map(|tool| (tool.pose, &problem.vehicles[tool.vehicle]));
        let waiting = (0..problem.robots.len())
            .filter(|&robot| moved >> robot & 1 == 0)
            .map(|robot| (problem.robots[robot].start, self.vehicle(robot)));
        let arrived = problem.slots.iter().zip(filled).filter_map(|(slot, &kind)| {
            let vehicle = usize::from(kind).checked_sub(1)?;
            Some((slot.pose, &problem.vehicles[vehicle]))
        });
        tools.chain(waiting).chain(arrived).collect()
    }

    fn balance(&mut self, state: &State, robot: usize) -> Result<&Balance, Unbalanced> {
        let waiting = (state.moved | 1 << robot, state.filled);
        if !self.balances.contains_key(&waiting) {
            let bodies = self.bodies(waiting.0, &waiting.1);
            let balanced = balance(&bodies, &self.request.law, self.limits_n);
            self.balances.insert(waiting, balanced);
        }
        self.balances[&waiting].as_ref().map_err(|error| *error)
    }

    /// No configuration has more thrusters than all robots at all starts and in all slots at once would have: with one
    /// tool and robots that feel nothing themselves, that is a lower bound of P_bal.
    fn least_balance_w(&self) -> f64 {
        let problem = self.problem;
        let neutral = problem.robots.iter().all(|robot| {
            let body = &problem.vehicles[robot.vehicle].body;
            (body.weight_n - body.buoyancy_n).abs() < 1e-12
                && (0..2).all(|k| (body.r_g_m[k] - body.r_b_m[k]).abs() < 1e-12)
        });
        let [tool] = problem.tools.as_slice() else { return 0.0 };
        if !neutral {
            return 0.0;
        }
        let mut members = vec![(tool.pose, &problem.vehicles[tool.vehicle])];
        let starts = problem.robots.iter().map(|robot| (robot.start, &problem.vehicles[robot.vehicle]));
        members.extend(starts);
        for kind in 0..problem.vehicles.len() {
            if problem.robots.iter().any(|robot| robot.vehicle == kind) {
                members.extend(problem.slots.iter().map(|slot| (slot.pose, &problem.vehicles[kind])));
            }
        }
        super::balance::power_of_cluster(&members, &self.request.law, self.limits_n).unwrap_or(0.0)
    }

    fn clearance(&self, state: &State, robot: usize, slot: usize) -> Clearance {
        let bodies = self.bodies(state.moved | 1 << robot, &state.filled);
        let half = |vehicle: &Vehicle| vehicle.box_m.map(|side| side / 2.0);
        let resting =
            bodies.iter().map(|(pose, vehicle)| Resting { pose: *pose, half_m: half(vehicle) }).collect();
        let vehicle = self.vehicle(robot);
        let (start, slot) = (self.problem.robots[robot].start, self.problem.slots[slot].pose);
        Clearance {
            resting,
            half_m: half(vehicle),
            start,
            slot,
            distance_m: self.problem.clearance_m(vehicle),
            bounds_m: self.problem.bounds_m(),
        }
    }

    /// Whether the robot's start is the slot.
    fn stays(&self, robot: usize, slot: usize) -> bool {
        let (start, slot) = (&self.problem.robots[robot].start, &self.problem.slots[slot].pose);
        length(way(start, slot)) < 1e-9 && quantity::wrap_rad(start.yaw_rad - slot.yaw_rad).abs() < 1e-9
    }

    fn route(&mut self, state: &State, robot: usize, slot: usize) -> Option<&Route> {
        let key = (*state, robot, slot);
        if !self.routes.contains_key(&key) {
            let lambda_w = self.balance(state, robot).ok().map(|balance| balance.power_w);
            let route = lambda_w.and_then(|lambda_w| {
                let clearance = self.clearance(state, robot, slot);
                let mover = self.movers[self.problem.robots[robot].vehicle].as_ref()?;
                let rules = &self.problem.rules;
                let query =
                    RouteQuery { mover, clearance: &clearance, lattice: &self.lattice, rules, lambda_w };
                query.route(self.request.criterion, self.request.manner, &mut self.scratch)
            });
            self.routes.insert(key, route);
        }
        self.routes[&key].as_ref()
    }

    fn bound_at(&self, robot: usize, slot: usize, lambda_w: f64) -> Option<f64> {
        let (from, to) = (&self.problem.robots[robot], &self.problem.slots[slot]);
        if !admits(to, from) {
            return None;
        }
        if self.stays(robot, slot) {
            return Some(0.0);
        }
        let mover = self.movers[from.vehicle].as_ref()?;
        let Request { criterion, manner, .. } = *self.request;
        Some(mover.bound(criterion, manner, way(&from.start, &to.pose), lambda_w))
    }

    /// What keeps robots from moving at the start, for the error message.
    fn obstacle(&mut self) -> String {
        let state = State::default();
        let mut stuck = Vec::new();
        for (robot, &Robot { id, .. }) in self.problem.robots.iter().enumerate() {
            if let Err(reason) = self.balance(&state, robot).cloned() {
                let reason = match reason {
                    Unbalanced::Alone(_) => "a tool would be left alone (v4)".to_owned(),
                    Unbalanced::OutOfReach { served, .. } => {
                        format!("the rest could give {:.0} % of the balancing wrench (v6)", served * 100.0)
                    }
                };
                stuck.push(format!("robot {id} cannot leave: {reason}"));
            } else if (0..self.problem.slots.len()).all(|slot| self.cost(&state, robot, slot).is_none()) {
                stuck.push(format!("robot {id} finds no way to any slot (v3)"));
            }
        }
        if stuck.is_empty() { "every order of moves ends before it".to_owned() } else { stuck.join("; ") }
    }

    /// The plan of an order.
    fn write(&mut self, order: &Order) -> Plan {
        let problem = self.problem;
        let mut state = State::default();
        let mut now_s = 0.0;
        let mut moves = Vec::new();
        // The robot in each slot.
        let mut arrived: Vec<Option<usize>> = vec![None; problem.slots.len()];
        for &(robot, slot) in &order.moves {
            let here = state;
            state = state.after(robot, slot, self.kind(robot));
            if self.stays(robot, slot) {
                arrived[slot] = Some(robot);
                continue;
            }
            let Ok(Balance { power_w, thrusts_n }) = self.balance(&here, robot).cloned() else { continue };
            // In the order of the bodies: tools, robots that have not moved, robots in slots.
            let waiting = (0..problem.robots.len()).filter(|&other| other != robot && !here.has_moved(other));
            let waiting = waiting.chain(arrived.iter().flatten().copied());
            let balance = waiting
                .zip(thrusts_n.into_iter().skip(problem.tools.len()))
                .map(|(other, thrusts_n)| Holding { robot: problem.robots[other].id, thrusts_n })
                .collect();
            let Some(route) = self.route(&here, robot, slot).cloned() else { continue };
            let mut actions = route.actions;
            for action in &mut actions {
                action.start_s += now_s;
            }
            moves.push(Move {
                robot: problem.robots[robot].id,
                slot,
                path: route.path,
                start_s: now_s,
                duration_s: route.duration_s,
                energy_navigate_j: route.energy_j,
                energy_balance_j: power_w * route.duration_s,
                balance_w: power_w,
                balance,
                actions,
            });
            now_s += route.duration_s;
            arrived[slot] = Some(robot);
        }
        let sum = |of: fn(&Move) -> f64| moves.iter().map(of).sum::<f64>();
        let (energy_navigate_j, energy_balance_j) =
            (sum(|m| m.energy_navigate_j), sum(|m| m.energy_balance_j));
        let placed = |robot: &Robot| Placed { id: robot.id, start: robot.start };
        Plan {
            problem: problem.name.clone(),
            criterion: self.request.criterion,
            manner: self.request.manner,
            robots: problem.robots.iter().map(placed).collect(),
            slots: problem.slots.iter().map(|slot| slot.pose).collect(),
            moves,
            energy_navigate_j,
            energy_balance_j,
            energy_total_j: energy_navigate_j + energy_balance_j,
            time_s: now_s,
        }
    }
}

impl MoveCosts for MovePricer<'_> {
    fn robots(&self) -> usize {
        self.problem.robots.len()
    }

    fn slots(&self) -> usize {
        self.problem.slots.len()
    }

    fn kind(&self, robot: usize) -> u8 {
        self.problem.robots[robot].vehicle as u8
    }

    fn bound(&self, robot: usize, slot: usize) -> Option<f64> {
        self.bound_at(robot, slot, self.lambda_least_w)
    }

    fn bound_from(&mut self, state: &State, robot: usize, slot: usize) -> Option<f64> {
        if self.stays(robot, slot) {
            return self.bound(robot, slot);
        }
        let lambda_w = self.balance(state, robot).ok()?.power_w;
        self.bound_at(robot, slot, lambda_w)
    }

    fn cost(&mut self, state: &State, robot: usize, slot: usize) -> Option<f64> {
        if self.stays(robot, slot) {
            return Some(0.0);
        }
        let lambda_w = self.balance(state, robot).ok()?.power_w;
        let criterion = self.request.criterion;
        self.route(state, robot, slot).map(|route| route.cost(criterion, lambda_w))
    }
}

fn way(from: &Pose, to: &Pose) -> [f64; 3] {
    offset(from.position_m, to.position_m)
}
