//! Order, start times and speeds of overlapping moves.
//!
//! 1. *List scheduling.* Moves are placed one after the other in the order of a list, each at the start time of least
//!    E + w·T of what is placed by then, with all conditions kept; a move that finds no place waits in the list. In the
//!    order of the plan the end of what is placed is always possible.
//! 2. *Paces.* That is done with all moves at every pace ω of [`OMEGAS_W`], and with a second worth more or less than it
//!    is while moves are placed.
//! 3. *Local search.* Neighbours in the list change places, and single moves their pace, as long as that pays.
//!
//! What takes more energy than the plan given is dropped.

use reconfiguration::plan::{Interval, Manner, Plan};
use reconfiguration::problem::Problem;

use super::super::planner::{PlanError, engines};
use super::super::power::{PowerLaw, limits_n};
use super::super::propulsion::Steady;
use super::pace::paced;
use super::timetable::{SAME_S, Timetable};

/// What a second is worth to a single robot when it chooses its speeds, J/s. *Assumed*: from idle waiting to more than the balance
/// of any cluster that was seen.
const OMEGAS_W: [f64; 8] = [0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
/// What a second is worth while moves are placed, J/s, besides what it is.
const PLACING_W: [f64; 3] = [0.0, 1.0, 1e3];
/// Start times are tried so far apart, and so far around the best one, s.
const STEP_S: f64 = 0.25;
const FINE_S: f64 = 0.05;
/// What a second is worth at least, J/s: of plans of one energy the quickest is taken.
const LEAST_W: f64 = 1e-4;
/// Rounds of local search.
const ROUNDS: usize = 3;
/// Less is no progress, J.
const PROGRESS_J: f64 = 1e-6;

/// A table that keeps all conditions.
#[derive(Clone)]
struct Found {
    cost_j: f64,
    list: Vec<usize>,
    placing_w: f64,
    paces: Vec<usize>,
    starts: Vec<Option<f64>>,
}

/// See the module's documentation.
pub(super) struct Search<'a> {
    plan: &'a Plan,
    table: Timetable<'a>,
    /// Paces that all moves have.
    paces: usize,
}

impl<'a> Search<'a> {
    pub fn new(problem: &'a Problem, plan: &'a Plan, law: &'a PowerLaw) -> Result<Self, PlanError> {
        let rules = &problem.rules;
        let limits_n = limits_n(rules.battery_v)?;
        let engines = engines(problem, law, Steady::Whole).collect::<Result<Vec<_>, _>>()?;
        let omegas: &[f64] = if plan.manner == Manner::Best { &OMEGAS_W } else { &[] };
        let moves = plan.moves.iter().map(|own| {
            let robot = problem.robots.iter().find(|robot| robot.id == own.robot);
            let engine = robot.and_then(|robot| engines.get(robot.vehicle)?.as_ref());
            let engine = engine.map(|(_, propulsion)| propulsion);
            let as_planned = paced(own, rules, None);
            let others = engine.into_iter().flat_map(|engine| {
                omegas.iter().map(move |&omega_w| paced(own, rules, Some((engine, omega_w))))
            });
            // A pace that cannot be swum is left as planned.
            let paces = std::iter::once(as_planned.clone()).chain(others);
            paces.filter_map(|pace| pace.or_else(|| as_planned.clone())).collect::<Vec<_>>()
        });
        let moves: Vec<_> = moves.collect();
        let paces = moves.iter().map(Vec::len).min().unwrap_or(0);
        Ok(Self { plan, table: Timetable::new(problem, law, limits_n, moves), paces })
    }

    /// The best that is found, as a plan.
    pub fn best(mut self, weight_w: f64) -> Result<Plan, PlanError> {
        let weight_w = weight_w.max(LEAST_W);
        let given = self.plan.energy_total_j + weight_w * self.plan.time_s;
        let list: Vec<usize> = (0..self.table.moves()).collect();
        let mut best: Option<Found> = None;
        let mut placings = PLACING_W.to_vec();
        placings.push(weight_w);
        for pace in 0..self.paces {
            let paces = vec![pace; list.len()];
            for &placing_w in &placings {
                let found = self.tried(&list, placing_w, &paces, weight_w);
                better(&mut best, found);
            }
        }
        for _ in 0..ROUNDS {
            let Some(before) = best.as_ref().map(|found| found.cost_j) else { break };
            self.reorder(&mut best, weight_w);
            self.repace(&mut best, weight_w);
            if best.as_ref().is_none_or(|found| found.cost_j > before - PROGRESS_J) {
                break;
            }
        }
        Ok(match best.filter(|found| found.cost_j < given - PROGRESS_J) {
            Some(found) => self.written(&found).unwrap_or_else(|| self.plan.clone()),
            None => self.plan.clone(),
        })
    }

    /// Neighbours in the list change places.
    fn reorder(&mut self, best: &mut Option<Found>, weight_w: f64) {
        for at in 1..self.table.moves() {
            let Some(now) = best.clone() else { return };
            let mut list = now.list.clone();
            list.swap(at - 1, at);
            let found = self.tried(&list, now.placing_w, &now.paces, weight_w);
            better(best, found);
        }
    }

    /// Single moves change their pace.
    fn repace(&mut self, best: &mut Option<Found>, weight_w: f64) {
        for own in 0..self.table.moves() {
            for pace in 0..self.table.paces_of(own) {
                let Some(now) = best.clone() else { return };
                let mut paces = now.paces.clone();
                if std::mem::replace(&mut paces[own], pace) != pace {
                    let found = self.tried(&now.list, now.placing_w, &paces, weight_w);
                    better(best, found);
                }
            }
        }
    }

    /// What comes of a list, if that keeps all conditions and takes no more energy than the plan given.
    fn tried(&mut self, list: &[usize], placing_w: f64, paces: &[usize], weight_w: f64) -> Option<Found> {
        self.table.paces.copy_from_slice(paces);
        let navigate_j = self.table.navigate_j();
        let most_j = self.plan.energy_total_j * (1.0 + 1e-9);
        if navigate_j > most_j {
            return None;
        }
        let starts = self.placed(list, placing_w)?;
        let laid = self.table.laid(&starts)?;
        let energy_j = navigate_j + laid.balance_j;
        (energy_j <= most_j).then(|| Found {
            cost_j: energy_j + weight_w * laid.time_s,
            list: list.to_vec(),
            placing_w,
            paces: paces.to_vec(),
            starts,
        })
    }

    /// List scheduling.
    fn placed(&mut self, list: &[usize], placing_w: f64) -> Option<Vec<Option<f64>>> {
        let mut starts: Vec<Option<f64>> = vec![None; list.len()];
        let mut pending = list.to_vec();
        while !pending.is_empty() {
            let next = pending.iter().position(|&own| {
                let start_s = self.place(own, &starts, placing_w);
                starts[own] = start_s;
                start_s.is_some()
            })?;
            pending.remove(next);
        }
        Some(starts)
    }

    /// The best start time for a move among those that are placed.
    fn place(&mut self, own: usize, placed: &[Option<f64>], placing_w: f64) -> Option<f64> {
        let earliest_s = self.table.earliest_s(own, placed)?;
        let ends = (0..placed.len())
            .filter_map(|other| placed[other].map(|s| s + self.table.passage(other).own.duration_s));
        let ends: Vec<f64> = ends.collect();
        let latest_s = ends.iter().copied().fold(earliest_s, f64::max);
        let steps = ((latest_s - earliest_s) / STEP_S).floor() as usize;
        let mut times: Vec<f64> = (0..=steps).map(|step| earliest_s + STEP_S * step as f64).collect();
        times.extend(ends.into_iter().filter(|end_s| *end_s > earliest_s));
        times.sort_by(f64::total_cmp);
        let mut starts = placed.to_vec();
        let mut best: Option<(f64, f64)> = None;
        let mut look = |times: &[f64], best: &mut Option<(f64, f64)>, table: &mut Timetable<'_>| {
            for &start_s in times {
                starts[own] = Some(start_s);
                let Some(laid) = table.laid(&starts) else { continue };
                // Of equal ones the earliest.
                let cost_j = laid.balance_j + placing_w * laid.time_s;
                if best.is_some_and(|(least_j, at_s)| {
                    cost_j > least_j - SAME_S && (start_s > at_s || cost_j > least_j + SAME_S)
                }) {
                    continue;
                }
                if table.is_clear(own, &starts) {
                    *best = Some((cost_j, start_s));
                }
            }
        };
        look(&times, &mut best, &mut self.table);
        let (_, found_s) = best?;
        let nearer = (1..(STEP_S / FINE_S) as usize).map(|step| found_s - FINE_S * step as f64);
        let nearer: Vec<f64> = nearer.filter(|start_s| *start_s >= earliest_s).collect();
        look(&nearer, &mut best, &mut self.table);
        best.map(|(_, start_s)| start_s)
    }

    fn written(&mut self, found: &Found) -> Option<Plan> {
        self.table.paces.copy_from_slice(&found.paces);
        let laid = self.table.laid(&found.starts)?;
        let mut moves: Vec<_> = (0..self.table.moves())
            .map(|own| {
                let mut written = self.table.passage(own).own.clone();
                written.start_s = found.starts[own].unwrap_or_default();
                let mut now_s = written.start_s;
                for action in &mut written.actions {
                    action.start_s = now_s;
                    now_s += action.duration_s;
                }
                written
            })
            .collect();
        let mut intervals = Vec::with_capacity(laid.spans.len());
        for span in laid.spans {
            let duration_s = span.to_s - span.from_s;
            let share_j = span.waiting.power_w * duration_s / span.movers.len() as f64;
            for &own in &span.movers {
                moves[own].energy_balance_j += share_j;
            }
            intervals.push(Interval {
                start_s: span.from_s,
                duration_s,
                balance_w: span.waiting.power_w,
                balance: span.waiting.balance.clone(),
            });
        }
        for own in &mut moves {
            own.balance_w = if own.duration_s > 0.0 { own.energy_balance_j / own.duration_s } else { 0.0 };
        }
        moves.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        let energy_navigate_j = moves.iter().map(|own| own.energy_navigate_j).sum();
        let energy_balance_j = moves.iter().map(|own| own.energy_balance_j).sum();
        Some(Plan {
            moves,
            intervals,
            energy_navigate_j,
            energy_balance_j,
            energy_total_j: energy_navigate_j + energy_balance_j,
            time_s: laid.time_s,
            ..self.plan.clone()
        })
    }
}

fn better(best: &mut Option<Found>, found: Option<Found>) {
    if let Some(found) = found
        && best.as_ref().is_none_or(|best| found.cost_j < best.cost_j - PROGRESS_J)
    {
        *best = Some(found);
    }
}
