//! The plan of an order: which robot hops, along which route, and who balances meanwhile.

use reconfiguration::plan::{Holding, Move, Placed, Plan};
use reconfiguration::pose::Pose;
use reconfiguration::problem::Robot;
use reconfiguration::vehicle::Vehicle;

use super::super::balance::balance;
use super::super::order::{Order, State};
use super::pricer::Pricer;
use super::routes::Answer;

impl Pricer<'_> {
    /// `None` for an order that cannot be carried out; not for one that was priced.
    pub(super) fn write(&self, order: &Order) -> Option<Plan> {
        let (problem, layout) = (self.problem, &self.layout);
        let mut state = State::default();
        let mut now_s = 0.0;
        let mut moves = Vec::new();
        // The robot in each place.
        let mut resting: Vec<Option<usize>> =
            (0..layout.places()).map(|place| (place < layout.robots()).then_some(place)).collect();
        for &hop in &order.moves {
            let (from, to) = hop.ends();
            let here = state;
            state = layout.after(&here, hop);
            let robot = resting[from].take()?;
            let others: Vec<usize> = resting.iter().flatten().copied().collect();
            resting[to] = Some(robot);
            if self.stays(hop) {
                continue;
            }
            let taken = self.places.taken(layout, &here, from);
            let bodies: Vec<(Pose, &Vehicle)> = taken.iter().map(|&seat| self.places.body(seat)).collect();
            let thrusts_n =
                balance(&bodies, &self.request.law, self.limits_n, &problem.rules).ok()?.thrusts_n;
            let lambda_w = self.lambda_w(&here, from).ok()?;
            // In the order of the bodies: tools, then robots by their places.
            let balance = others
                .iter()
                .zip(thrusts_n.into_iter().skip(problem.tools.len()))
                .map(|(&other, thrusts_n)| Holding { robot: problem.robots[other].id, thrusts_n })
                .collect();
            let Answer::Route(route) = self.route_of(0, &here, hop, (lambda_w, lambda_w), f64::INFINITY)
            else {
                return None;
            };
            let mut actions = route.actions.clone();
            for action in &mut actions {
                action.start_s += now_s;
            }
            let slot = layout.slot(to);
            moves.push(Move {
                robot: problem.robots[robot].id,
                slot,
                to: slot.is_none().then(|| self.places.pose(to)),
                path: route.path.clone(),
                start_s: now_s,
                duration_s: route.duration_s,
                energy_navigate_j: route.energy_j,
                energy_balance_j: lambda_w * route.duration_s,
                balance_w: lambda_w,
                balance,
                actions,
            });
            now_s += route.duration_s;
        }
        // An empty sum of floats is −0.
        let sum = |of: fn(&Move) -> f64| moves.iter().map(of).sum::<f64>() + 0.0;
        let (energy_navigate_j, energy_balance_j) =
            (sum(|m| m.energy_navigate_j), sum(|m| m.energy_balance_j));
        let placed = |robot: &Robot| Placed { id: robot.id, start: robot.start };
        Some(Plan {
            problem: problem.name.clone(),
            criterion: self.request.criterion,
            manner: self.request.manner,
            robots: problem.robots.iter().map(placed).collect(),
            slots: problem.slots.iter().map(|slot| slot.pose).collect(),
            moves,
            intervals: Vec::new(),
            energy_navigate_j,
            energy_balance_j,
            energy_total_j: energy_navigate_j + energy_balance_j,
            time_s: now_s,
            lower_bound_j: None,
            gap: None,
            proved: None,
        })
    }
}
