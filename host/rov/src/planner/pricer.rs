//! Costs of moves: what a route takes, and bounds of that.
//!
//! A bound of a move is what its route costs with nothing but the tools in the water, for a few powers λ that others may
//! draw meanwhile. The least over all routes of E + λT is concave in λ, so between two of these powers the chord lies
//! below it. Where robots may park on their way the straight-line bound is used, for which no detour is a short cut.

use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use reconfiguration::plan::{Criterion, Manner};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;
use reconfiguration::vehicle::Vehicle;

use super::super::balance::Unbalanced;
use super::super::clearance::{Clearance, Resting};
use super::super::conditions::{Conditions, admits};
use super::super::docking::with_hand_over;
use super::super::frame::Framed;
use super::super::order::extra::Extra;
use super::super::order::{Answer, DESKS, GoesOn, Hop, Layout, MoveCosts, State, Workers};
use super::super::power;
use super::super::propulsion::Steady;
use super::super::route::{Mover, Route, RouteQuery, Scratch};
use super::super::search_graph::Lattice;
use super::super::vector::{length, offset};
use super::super::water::Water;
use super::places::{Places, half_m};
use super::routes::{self, Routes, nearest_power_w};
use super::shut::Shut;
use super::speeds::{Beyond, beyond_thrust, engines};
use super::waits::{Waits, feels_nothing};
use super::{PlanError, Request};

/// Poses that differ by less are the same, m and rad.
const SAME: f64 = 1e-6;
/// Powers of others, above the least, that bounds are worked out for, W.
const POWERS_W: [f64; 4] = [0.0, 0.7, 2.0, 5.0];
/// What rounding may take off a bound.
const ROUNDING: f64 = 1.0 - 1e-9;

/// Where robots go from and to, and what is in their way.
#[derive(Clone, Copy)]
pub(super) struct Way {
    pub(super) vehicle: usize,
    from: Pose,
    to: Pose,
}

/// See the module's documentation.
pub(super) struct Pricer<'a> {
    pub(super) problem: &'a Problem,
    pub(super) request: &'a Request,
    /// Indices of slots in the file, by index in the frame.
    pub(super) slots_in_file: &'a [usize],
    pub(super) layout: Layout,
    pub(super) places: Places<'a>,
    pub(super) limits_n: (f64, f64),
    pub(super) waits: Waits,
    shut: Shut,
    pub(super) tools: Vec<usize>,
    /// By vehicle; none for tools.
    movers: Vec<Option<Mover>>,
    /// One for every move that is priced at a time.
    desks: Vec<Mutex<Scratch>>,
    pub(super) routes: Routes,
    lattice: Lattice,
    water: &'a Water,
    vehicle_of_kind: Vec<usize>,
    /// Kinds by slot that may rest there.
    admitted: Vec<Vec<u8>>,
    /// Whether what others draw depends on where they rest.
    balances: bool,
    pub(super) lambda_least_w: f64,
    /// Whether that is the least of some sets of robots that rest, and not of all.
    pub(super) samples_sets: bool,
    /// [place][kind][place]: at the powers; nothing where a robot may not rest.
    bounds: Vec<Option<[f64; POWERS_W.len()]>>,
    /// Sets of slots that are a goal; none where every one is.
    goals: Option<Vec<u32>>,
}

impl<'a> Pricer<'a> {
    /// For robots that may make so many moves, by way of these berths.
    pub(super) fn new(
        framed: &'a Framed,
        request: &'a Request,
        (berths, moves): (&[Pose], usize),
        workers: &dyn Workers,
    ) -> Result<Self, PlanError> {
        let Framed { problem, water, .. } = framed;
        let rules = &problem.rules;
        let limits_n = power::limits_n(rules.battery_v)?;
        let kinds = Kinds::of(problem);
        let slots = problem.slots.len();
        let layout = Layout::new(kinds.of_robot, kinds.settled, slots).with_berths(berths.len(), moves);
        let places = Places::new(problem, &layout, &kinds.vehicle, berths);
        // Docked poses lie on the grid when it divides the box.
        let box_m = problem.robots.first().map_or([1.0; 3], |robot| problem.vehicles[robot.vehicle].box_m);
        let cell_m = std::array::from_fn(|k| box_m[k] / f64::from(rules.grid_divisions[k].max(1)));
        let anchor_m = problem.robots.first().map_or([0.0; 3], |robot| robot.start.position_m);
        let first = Way { vehicle: 0, from: places.pose(0), to: places.pose(0) };
        let stays = |place| problem.robots.iter().any(|robot| is_same(&robot.start, &places.pose(place)));
        let shut = Shut::new(&places, &layout, &clearance(problem, water, &first, &[]), stays);
        let tools = places.tools();
        let neutral = problem.robots.iter().all(|robot| feels_nothing(&problem.vehicles[robot.vehicle]));
        let mut pricer = Self {
            problem,
            request,
            slots_in_file: framed.slots(),
            layout,
            places,
            limits_n,
            waits: Waits::new(&request.law, limits_n, rules),
            shut,
            tools,
            movers: movers(problem, request)?,
            desks: (0..DESKS).map(|_| Mutex::default()).collect(),
            routes: Routes::new(),
            lattice: Lattice::new(anchor_m, cell_m, water.extent_m()),
            water,
            vehicle_of_kind: kinds.vehicle,
            admitted: kinds.admitted,
            balances: !(neutral && problem.tools.is_empty()),
            lambda_least_w: 0.0,
            samples_sets: false,
            bounds: Vec::new(),
            goals: None,
        };
        if neutral {
            (pricer.lambda_least_w, pricer.samples_sets) = pricer.least_balance_w(workers);
        }
        pricer.goals = pricer.goals();
        pricer.bounds = pricer.all_bounds(workers);
        Ok(pricer)
    }

    /// Sets of as many slots as there are robots that are one cluster with all tools, where there are more slots.
    fn goals(&self) -> Option<Vec<u32>> {
        let (robots, slots) = (self.layout.robots(), self.layout.slots());
        if slots == robots {
            return None;
        }
        let sets = (0..1_u32 << slots).filter(|set| set.count_ones() as usize == robots);
        let sets = sets.filter(|set| {
            let filled: Vec<usize> = (0..slots).filter(|slot| set >> slot & 1 == 1).collect();
            self.places.is_one_cluster(&self.layout, &filled, &self.admitted)
        });
        Some(sets.collect())
    }

    fn all_bounds(&self, workers: &dyn Workers) -> Vec<Option<[f64; POWERS_W.len()]>> {
        let places = self.layout.places();
        let kinds = self.vehicle_of_kind.len();
        let mut found = vec![None; places * kinds * places];
        let mut ways: Vec<(usize, Hop, Way)> = Vec::new();
        for from in (0..places).filter(|&from| self.layout.slot(from).is_none()) {
            for kind in 0..kinds {
                if from < self.layout.robots() && usize::from(self.layout.kind(from)) != kind {
                    continue;
                }
                for to in self.layout.robots()..places {
                    let allowed =
                        self.layout.slot(to).is_none_or(|slot| self.admitted[slot].contains(&(kind as u8)));
                    if allowed && from != to {
                        let (from_pose, to_pose) = (self.places.pose(from), self.places.pose(to));
                        let vehicle = self.vehicle_of_kind[kind];
                        let index = (from * kinds + kind) * places + to;
                        ways.push((index, Hop::new(from, to), Way { vehicle, from: from_pose, to: to_pose }));
                    }
                }
            }
        }
        let answers: Vec<Mutex<Vec<_>>> = (0..DESKS).map(|_| Mutex::default()).collect();
        workers.run(DESKS, &|desk| {
            let own = ways.iter().skip(desk).step_by(DESKS);
            let own = own.map(|(index, hop, way)| (*index, self.bounds_of(desk, *hop, way))).collect();
            *answers[desk].lock().unwrap_or_else(PoisonError::into_inner) = own;
        });
        self.routes.share();
        for answers in answers {
            for (index, bounds) in answers.into_inner().unwrap_or_else(PoisonError::into_inner) {
                found[index] = bounds;
            }
        }
        found
    }

    /// Bounds of one way at the powers; `None` if there is none even in open water.
    fn bounds_of(&self, desk: usize, hop: Hop, way: &Way) -> Option<[f64; POWERS_W.len()]> {
        let Request { criterion, manner, .. } = *self.request;
        if is_same(&way.from, &way.to) {
            return Some([0.0; POWERS_W.len()]);
        }
        let mut found = [0.0; POWERS_W.len()];
        let powers = POWERS_W.map(|power_w| self.lambda_least_w + power_w);
        let parks = self.layout.berths() > 0;
        if parks || manner == Manner::Paper {
            let mover = self.movers[way.vehicle].as_ref()?;
            let way_m = offset(way.from.position_m, way.to.position_m);
            return Some(powers.map(|lambda_w| mover.bound(criterion, manner, way_m, lambda_w)));
        }
        for (k, &lambda_w) in powers.iter().enumerate() {
            if k > 0 && (criterion == Criterion::Euclidean || !self.balances) {
                found[k] = found[0];
                continue;
            }
            let cost = self.route_around_tools(desk, hop, way, lambda_w);
            if !cost.is_finite() {
                return None;
            }
            found[k] = cost * ROUNDING;
        }
        Some(found)
    }

    fn bound_at(&self, from: usize, kind: u8, to: usize, lambda_w: f64) -> Option<f64> {
        let (places, kinds) = (self.layout.places(), self.vehicle_of_kind.len());
        let bounds = self.bounds[(from * kinds + usize::from(kind)) * places + to].as_ref()?;
        let above_w = lambda_w - self.lambda_least_w;
        if above_w < 0.0 {
            // Nothing is paid below zero, and the least is concave in λ.
            return Some(bounds[0] * lambda_w / self.lambda_least_w);
        }
        let k = POWERS_W.iter().rposition(|&power_w| power_w <= above_w).unwrap_or(0);
        Some(match (POWERS_W.get(k + 1), bounds.get(k + 1)) {
            (Some(next_w), Some(next)) => {
                let share = (above_w - POWERS_W[k]) / (next_w - POWERS_W[k]);
                bounds[k] + share * (next - bounds[k])
            }
            _ => bounds[k],
        })
    }

    pub(super) fn clearance(&self, way: &Way, resting: &[(Pose, &Vehicle)]) -> Clearance {
        clearance(self.problem, self.water, way, resting)
    }

    pub(super) fn route(
        &self,
        desk: usize,
        way: &Way,
        resting: &[(Pose, &Vehicle)],
        lambda_w: f64,
    ) -> Option<Route> {
        let Request { criterion, manner, .. } = *self.request;
        let route = self.route_by(criterion, manner, desk, way, resting, lambda_w);
        match manner {
            Manner::Paper => route,
            Manner::Best => route.map(with_hand_over),
        }
    }

    fn route_by(
        &self,
        criterion: Criterion,
        manner: Manner,
        desk: usize,
        way: &Way,
        resting: &[(Pose, &Vehicle)],
        lambda_w: f64,
    ) -> Option<Route> {
        let clearance = self.clearance(way, resting);
        let mover = self.movers[way.vehicle].as_ref()?;
        let query = RouteQuery {
            mover,
            clearance: &clearance,
            lattice: &self.lattice,
            rules: &self.problem.rules,
            lambda_w,
        };
        let mut scratch = self.desks[desk].lock().unwrap_or_else(PoisonError::into_inner);
        query.route(criterion, manner, &mut scratch)
    }

    /// Whether there is a way for a robot that chooses where it turns.
    pub(super) fn has_free_way(&self, state: &State, hop: Hop) -> bool {
        self.way(state, hop).is_some_and(|way| {
            let taken = self.places.taken(&self.layout, state, hop.ends().0);
            self.route_by(Criterion::Euclidean, Manner::Best, 0, &way, &self.bodies(&taken), 0.0).is_some()
        })
    }

    /// The vehicle that hops, and its ends.
    pub(super) fn way(&self, state: &State, hop: Hop) -> Option<Way> {
        let kind = self.layout.occupant(state, hop.ends().0)?;
        Some(self.way_of(hop, kind))
    }

    pub(super) fn way_of(&self, hop: Hop, kind: u8) -> Way {
        let (from, to) = hop.ends();
        let vehicle = self.vehicle_of_kind[usize::from(kind)];
        Way { vehicle, from: self.places.pose(from), to: self.places.pose(to) }
    }

    /// The bound of a hop while others draw the least that they may.
    pub(super) fn bound_of(&self, from: usize, kind: u8, to: usize) -> Option<f64> {
        self.bound_at(from, kind, to, self.lambda_least_w)
    }

    /// Whether a hop is none: the robot rests where it is to go.
    pub(super) fn stays(&self, hop: Hop) -> bool {
        let (from, to) = hop.ends();
        is_same(&self.places.pose(from), &self.places.pose(to))
    }

    /// What the others draw while the robot of a place is away, W.
    pub(super) fn lambda_w(&self, state: &State, away: usize) -> Result<f64, Unbalanced> {
        if !self.balances {
            return Ok(0.0);
        }
        self.waits.power_w(&self.places, &self.places.taken(&self.layout, state, away))
    }

    pub(super) fn bodies(&self, seats: &[usize]) -> Vec<(Pose, &'a Vehicle)> {
        seats.iter().map(|&seat| self.places.body(seat)).collect()
    }
}

fn clearance(problem: &Problem, water: &Water, way: &Way, resting: &[(Pose, &Vehicle)]) -> Clearance {
    let vehicle = &problem.vehicles[way.vehicle];
    Clearance {
        resting: resting
            .iter()
            .map(|(pose, vehicle)| Resting { pose: *pose, half_m: half_m(vehicle) })
            .collect(),
        half_m: half_m(vehicle),
        start: way.from,
        slot: way.to,
        distance_m: problem.clearance_m(vehicle),
        water: water.clone(),
    }
}

impl MoveCosts for Pricer<'_> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn bound(&self, from: usize, kind: u8, to: usize) -> Option<f64> {
        self.bound_of(from, kind, to)
    }

    fn bound_from(&self, state: &State, hop: Hop) -> Option<f64> {
        let (from, to) = hop.ends();
        let kind = self.layout.occupant(state, from)?;
        if self.stays(hop) {
            return self.bound(from, kind, to);
        }
        let taken = self.places.taken(&self.layout, state, from);
        let is_shut = |place| self.shut.is_shut(self.places.seat(place, kind), &taken);
        if self.places.is_blocked(to, kind, &taken) || is_shut(from) || is_shut(to) {
            return None;
        }
        let lambda_w = if self.balances { self.waits.power_w(&self.places, &taken).ok()? } else { 0.0 };
        self.bound_at(from, kind, to, lambda_w)
    }

    fn cost(&self, desk: usize, state: &State, hop: Hop, most: f64) -> Answer {
        if self.stays(hop) {
            return Answer::Price(0.0);
        }
        let Ok(lambda_w) = self.lambda_w(state, hop.ends().0) else { return Answer::Price(f64::INFINITY) };
        let power_w = if self.request.manner == Manner::Paper { lambda_w } else { nearest_power_w(lambda_w) };
        match self.route_of(desk, state, hop, (lambda_w, power_w), most) {
            routes::Answer::Route(route) => Answer::Price(route.cost(self.request.criterion, lambda_w)),
            routes::Answer::AtLeast(bound) => Answer::AtLeast(bound),
            routes::Answer::None => Answer::Price(f64::INFINITY),
        }
    }

    fn share(&self) {
        self.routes.share();
    }

    fn extra(&self, workers: &dyn Workers, goes_on: &mut GoesOn<'_>) -> ControlFlow<(), Option<Extra>> {
        if self.request.manner == Manner::Best {
            self.detours(workers, goes_on)
        } else {
            ControlFlow::Continue(None)
        }
    }

    fn stays_open(&self, filled: u32) -> bool {
        self.shut.stays_open(&self.tools, filled)
    }

    fn depends_on_state(&self) -> bool {
        // Without what others draw it is the overlaps that are known before a price.
        self.balances && self.request.criterion == Criterion::Energy
    }

    fn may_fill(&self, filled: u32) -> bool {
        self.goals.as_ref().is_none_or(|goals| goals.iter().any(|goal| goal & filled == filled))
            && self.shut.may_fill(&self.tools, filled)
    }
}

pub(super) fn is_same(from: &Pose, to: &Pose) -> bool {
    length(offset(from.position_m, to.position_m)) < SAME
        && quantity::wrap_rad(from.yaw_rad - to.yaw_rad).abs() < SAME
}

fn movers(problem: &Problem, request: &Request) -> Result<Vec<Option<Mover>>, PlanError> {
    let rules = &problem.rules;
    let steady = match request.manner {
        Manner::Paper => Steady::Published,
        Manner::Best => Steady::Whole,
    };
    let mut movers = Vec::with_capacity(problem.vehicles.len());
    for (vehicle, engine) in problem.vehicles.iter().zip(engines(problem, &request.law, steady)) {
        let Some((robot, propulsion)) = engine? else {
            movers.push(None);
            continue;
        };
        if let Some(Beyond { key, asked, unit, attainable }) =
            beyond_thrust(&propulsion, rules, request.manner)
        {
            let vehicle = vehicle.name.clone();
            return Err(PlanError::BeyondThrust { robot, vehicle, key, asked, unit, attainable });
        }
        movers.push(Some(Mover::new(propulsion, rules)));
    }
    Ok(movers)
}

/// Robots that are alike: the same vehicle, and the same slots where it may rest.
struct Kinds {
    of_robot: Vec<u8>,
    vehicle: Vec<usize>,
    settled: Vec<u8>,
    admitted: Vec<Vec<u8>>,
}

impl Kinds {
    fn of(problem: &Problem) -> Self {
        let mut kinds: Vec<(usize, Vec<bool>)> = Vec::new();
        let mut of_robot = Vec::new();
        for robot in &problem.robots {
            let may: Vec<bool> = problem.slots.iter().map(|slot| admits(slot, robot)).collect();
            let kind = (robot.vehicle, may);
            let known = kinds.iter().position(|known| *known == kind);
            of_robot.push(known.unwrap_or(kinds.len()) as u8);
            if known.is_none() {
                kinds.push(kind);
            }
        }
        let vehicle: Vec<usize> = kinds.iter().map(|(vehicle, _)| *vehicle).collect();
        // In a slot only the vehicle counts.
        let first = |of: &usize| vehicle.iter().position(|other| other == of).unwrap_or(0) as u8;
        let settled = vehicle.iter().map(first).collect();
        let admitted = (0..problem.slots.len())
            .map(|slot| (0..kinds.len()).filter(|&kind| kinds[kind].1[slot]).map(|kind| kind as u8).collect())
            .collect();
        Self { of_robot, vehicle, settled, admitted }
    }
}
