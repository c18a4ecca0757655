//! The whole planner, p1 and p2 of section VII: from a problem to a plan.
//!
//! | part | where |
//! |---|---|
//! | which configurations can wait, and what that draws | [`balance`](super::balance) |
//! | one robot's route | [`route`](super::route); by the paper's rules over [`search_graph`](super::search_graph), Theta* of [`grid`] |
//! | the order of moves, and robots to slots | [`super::order`] |
//! | places, and what is docked in them | `places` |
//! | costs and bounds of moves | `pricer`, with `routes`, `finding`, `detours` and `shut` |
//! | what others draw at least while a robot moves | `least_wait` |
//! | what keeps robots from moving, in words | `obstacle` |
//!
//! At first every robot moves once. If no order of such moves leads to the goal, robots may park on their way, as often
//! as [`moves_per_robot`](reconfiguration::problem::Rules::moves_per_robot) allows.
//!
//! Pure: the same problem gives the same plan, unless its [`Progress`] ends the search by a clock.

use reconfiguration::plan::{Criterion, Manner, Plan};
use reconfiguration::problem::Problem;
use thiserror::Error;

use super::frame::Framed;
use super::order::paper::NoRule;
use super::order::search::{Found, NoOrder};
use super::order::{self, Finder, InTurn, Known, Patience, Progress, State, Workers};
use super::power::{PowerError, PowerLaw};
use super::propulsion::PropulsionError;
use pricer::Pricer;
pub(crate) use speeds::engines;

mod detours;
mod finding;
mod least_wait;
mod obstacle;
mod parking;
mod places;
mod pricer;
mod routes;
mod shut;
mod speeds;
mod waits;
mod write;

/// Moves priced at most by [`plan`] before the best order known is returned unproved.
pub const PATIENCE: usize = 20_000;
/// Moves priced without any order found before robots are allowed to park.
const ONCE_MOST: usize = 4_000;

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
    /// No order and assignment costs less, given these routes; 0 where nothing is known.
    pub bound: f64,
    /// Whether no order and assignment is cheaper, given these routes.
    pub proved: bool,
    /// Whether the bound is no proof: it takes what the sets of robots at rest that were met draw for the least of all sets.
    pub samples_sets: bool,
    /// How often a robot may move in the orders that were compared.
    pub moves: usize,
    /// How many moves were priced.
    pub priced: usize,
}

impl Planned {
    /// How much dearer than the least the plan can be, as a share of the least; `None` where nothing is known of that.
    #[must_use]
    pub fn gap(&self) -> Option<f64> {
        let known = Known { best: Some(self.cost), bound: self.bound, priced: self.priced };
        if self.proved { Some(0.0) } else { known.gap() }
    }
}

/// Why there is no plan.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PlanError {
    /// Its thrusters' forces cannot be computed.
    #[error("robot {robot}, {vehicle}: {source}")]
    Propulsion { robot: u16, vehicle: String, source: PropulsionError },
    /// A speed that it has not the thrust for.
    #[error(
        "robot {robot}, {vehicle}: [rules] {key} = {asked} {unit} takes more thrust than there is: {attainable:.2} {unit} can be reached"
    )]
    BeyondThrust {
        robot: u16,
        vehicle: String,
        key: &'static str,
        asked: f64,
        unit: &'static str,
        attainable: f64,
    },
    /// Nothing is known of the thrusters at this voltage.
    #[error(transparent)]
    Power(#[from] PowerError),
    /// More than the order can be decided for.
    #[error("{count} robots or slots: at most {} can be ordered", order::MOST)]
    TooMany { count: usize },
    /// The paper's rule leads into a dead end: every robot that waits was looked at with every slot.
    #[error(
        "a dead end of the paper's rules: after {moves} moves, the least g + h next, no robot can move: {why} (exact order may \
         know better)"
    )]
    DeadEnd { moves: usize, why: String },
    /// The search for an order was given up: the goal may be reachable or not.
    #[error("no order of moves to the goal was found among {priced} moves priced; there may be one")]
    OutOfPatience { priced: usize },
    /// No order of moves leads to the goal.
    #[error("the goal cannot be reached: {why} ({states} configurations searched, every one there is)")]
    Unreachable { why: String, states: usize },
    /// No order leads there by way of parking places either.
    #[error(
        "no order with at most {moves} moves a robot reaches the goal: {why} ({states} configurations searched, every one \
         there is with {berths} parking places; [rules] moves_per_robot allows more moves)"
    )]
    Blocked { why: String, states: usize, moves: usize, berths: usize },
}

/// Plans a reconfiguration in its own [frame](super::frame), one move priced after the other, at most [`PATIENCE`] of them.
pub fn plan(problem: &Problem, request: &Request) -> Result<Planned, PlanError> {
    plan_with(problem, request, &InTurn, &mut Patience(PATIENCE))
}

/// Plans a reconfiguration until the least order is proved or `progress` ends the search.
pub fn plan_with(
    problem: &Problem,
    request: &Request,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Planned, PlanError> {
    let count = problem.robots.len().max(problem.slots.len());
    if count > order::MOST {
        return Err(PlanError::TooMany { count });
    }
    let framed = Framed::of(problem);
    let planned = plan_in_frame(&framed, request, workers, progress)?;
    Ok(Planned { plan: framed.into_world(planned.plan, problem), ..planned })
}

fn plan_in_frame(
    framed: &Framed,
    request: &Request,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Planned, PlanError> {
    let Framed { problem, water, .. } = framed;
    let moves = if request.manner == Manner::Paper { 1 } else { problem.rules.moves_per_robot as usize };
    let may_park = moves > 1 && request.order == OrderRule::Exact;
    let pricer = Pricer::new(framed, request, (&[], 1), workers)?;
    let mut once = Once { progress, most: if may_park { ONCE_MOST } else { usize::MAX }, gave_up: false };
    let first = ordered(&pricer, workers, &mut once);
    let (why, states) = match first {
        Err(PlanError::Unreachable { why, states }) if may_park => (why, states),
        Err(PlanError::OutOfPatience { priced }) if once.gave_up => {
            (format!("no order was found among {priced} moves priced"), 0)
        }
        settled => return settled,
    };
    let mut berths = parking::open(problem, water);
    let mut last = PlanError::Unreachable { why: why.clone(), states };
    for docked in [false, true] {
        if docked {
            berths.extend(parking::docked(problem, water));
        }
        if berths.is_empty() {
            continue;
        }
        let pricer = Pricer::new(framed, request, (&berths, moves), workers)?;
        let mut parked = Once { progress: &mut *once.progress, most: usize::MAX, gave_up: false };
        match ordered(&pricer, workers, &mut parked) {
            Err(PlanError::Unreachable { states, .. }) => {
                let berths = pricer.layout.berths();
                last = PlanError::Blocked { why: why.clone(), states, moves, berths };
            }
            settled => return settled,
        }
    }
    Err(last)
}

/// Ends a search that has found nothing after so many moves priced.
struct Once<'a> {
    progress: &'a mut dyn Progress,
    most: usize,
    gave_up: bool,
}

impl Progress for Once<'_> {
    fn report(&mut self, known: &Known) -> std::ops::ControlFlow<()> {
        self.gave_up = known.best.is_none() && known.priced >= self.most;
        if self.gave_up { std::ops::ControlFlow::Break(()) } else { self.progress.report(known) }
    }
}

/// The best order by what is asked for, as a plan.
fn ordered(
    pricer: &Pricer<'_>,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Planned, PlanError> {
    let mut finder = Finder::new(pricer, workers, progress);
    let out_of_patience = |finder: &Finder<'_, Pricer<'_>>| {
        let priced = finder.known().priced;
        PlanError::OutOfPatience { priced }
    };
    let Found { order, bound, proved } = match pricer.request.order {
        OrderRule::Paper => match finder.by_paper() {
            Ok(order) => Found { order, bound: 0.0, proved: false },
            Err(NoRule::DeadEnd(state)) => {
                let moves = pricer.layout.robots() - pricer.layout.waiting(&state).count();
                return Err(PlanError::DeadEnd { moves, why: pricer.obstacle(&state) });
            }
            Err(NoRule::Stopped) => return Err(out_of_patience(&finder)),
        },
        OrderRule::Exact => {
            let found = finder.first().and_then(|()| finder.search(true));
            found.map_err(|none| match none {
                NoOrder::Proved { states } => {
                    PlanError::Unreachable { why: pricer.obstacle(&State::default()), states }
                }
                NoOrder::Stopped => out_of_patience(&finder),
            })?
        }
    };
    let rule_cost =
        finder.rule().or_else(|| (pricer.request.order == OrderRule::Paper).then_some(order.cost));
    let priced = finder.known().priced;
    let share = pricer.share_of_bounds();
    let samples_sets = pricer.samples_sets;
    let (bound, proved) = (share * bound, proved && share >= 1.0 && !samples_sets);
    let Some(mut plan) = pricer.write(&order) else { return Err(out_of_patience(&finder)) };
    // Its routes are found for what others draw exactly, and may be cheaper than what they were chosen by.
    let cost = match pricer.request.criterion {
        Criterion::Energy => plan.energy_total_j,
        Criterion::Euclidean => order.cost,
    };
    // The rule's order is priced as it was chosen; written, it would change as this one did.
    let rule_cost = rule_cost.map(|rule| if order.cost > 0.0 { rule * (cost / order.cost) } else { rule });
    let planned = Planned {
        plan: plan.clone(),
        cost,
        rule_cost,
        bound: bound.min(cost),
        proved,
        samples_sets,
        moves: pricer.layout.moves(),
        priced,
    };
    if pricer.request.order == OrderRule::Exact {
        let in_joules = pricer.request.criterion == Criterion::Energy;
        plan.lower_bound_j = in_joules.then_some(planned.bound);
        (plan.gap, plan.proved) = (planned.gap(), Some(proved));
    }
    Ok(Planned { plan, ..planned })
}

#[cfg(test)]
mod tests;
