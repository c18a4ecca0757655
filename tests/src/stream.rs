//! Streams of demands for planners: each plan starts where the last one left the tails; figures of what came of it.
//!
//! The first plan of a stream, before which the tail angles are unknown, is made and not counted.

use std::sync::Arc;
use std::time::{Duration, Instant};

use modboat::distance::DistanceToCollision;
use modboat::envelope::Envelope;
use modboat::motion::{Swing, Wrench};
use modboat::parameters::Parameters;
use modboat::plan::{Outcome, Plan, Previous};
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::planner_kind::PlannerKind;
use modboat::structure::Structure;

use crate::checker::Request;
use crate::convert::swings;
use crate::demands::{Correlated, Uniform};
use crate::figures::{Quantiles, mean};
use crate::seeds::on_all_cores;

/// Modules of one kind and what is known of their tails.
#[derive(Clone)]
pub struct Kind {
    /// The modules.
    pub parameters: Parameters,
    distance: Arc<DistanceToCollision>,
}

impl Kind {
    /// Of modules with these parameters.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        let distance = Arc::new(DistanceToCollision::new(&parameters));
        Self { parameters, distance }
    }

    /// A planner for `structure` of such modules.
    #[must_use]
    pub fn planner(&self, structure: &Structure, config: &PlannerConfig) -> Planner {
        Planner::with_distance(structure, &self.parameters, config, Arc::clone(&self.distance))
    }

    /// Every wrench that `structure` of such modules could give if no tail were in another's way.
    #[must_use]
    pub fn envelope(&self, structure: &Structure) -> Envelope {
        Envelope::new(&structure.positions_m(self.parameters.pitch_m), &self.parameters)
    }
}

/// How demands follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sequence {
    /// Each has nothing to do with the last.
    Apart,
    /// A walk whose steps have this deviation, as a part of half the bounding box, along each axis.
    Walk(f64),
}

impl Sequence {
    /// So many demands inside `share` of `envelope`.
    #[must_use]
    pub fn demands(self, envelope: &Envelope, share: f64, seed: u64, count: usize) -> Vec<Wrench> {
        match self {
            Self::Apart => Uniform::new(envelope.clone(), share, seed).take(count).collect(),
            Self::Walk(step) => Correlated::new(envelope.clone(), share, step, seed).take(count).collect(),
        }
    }
}

impl std::fmt::Display for Sequence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Apart => f.pad("uncorrelated"),
            Self::Walk(step) => f.pad(&format!("steps {step}")),
        }
    }
}

/// One question to a planner.
#[derive(Clone, Debug)]
pub struct Asked {
    /// F_des.
    pub demand: Wrench,
    /// The tails' angles, rad.
    pub tails: Vec<f64>,
    /// The cycle before.
    pub previous: Vec<Swing>,
    /// The plan before, all of which may still be under way; `None` where nothing is.
    pub before: Option<Plan>,
}

impl Asked {
    /// The same for the checker.
    #[must_use]
    pub fn request(&self, structure: &Structure) -> Request {
        Request {
            cells: structure.cells().to_vec(),
            demand: self.demand.to_array(),
            tail_rad: Some(self.tails.clone()),
            previous: Some(swings(&self.previous)),
        }
    }
}

/// Asks `planner` for a plan for each demand and shows all but the first to `look`, with the question and the time that
/// the answer took. Each question is put so many `times`, with the same answer, and the least time counts: the one that
/// other work on the machine disturbs least.
pub fn follow(
    planner: &mut Planner,
    demands: impl IntoIterator<Item = Wrench>,
    times: usize,
    mut look: impl FnMut(&Asked, &Plan, Duration),
) {
    let mut next: Option<(Vec<f64>, Vec<Swing>, Option<Plan>)> = None;
    for demand in demands {
        let Some((tails, previous, before)) = next.take() else {
            let plan = planner.plan(demand, None, None);
            let starts = plan.cycle.iter().map(|swing| swing.start_rad()).collect();
            next = Some((starts, plan.cycle.clone(), Some(plan)));
            continue;
        };
        let asked = Asked { demand, tails, previous, before };
        let over = Previous { is_over: true, ..Previous::cycle(&asked.previous) };
        let previous = asked.before.as_ref().map_or(over, Plan::as_previous);
        let mut ask = || {
            let (began, mut plan) = (Instant::now(), Plan::default());
            planner.plan_into(demand, Some(&asked.tails), Some(previous), &mut plan);
            (plan, began.elapsed())
        };
        let (plan, mut took) = ask();
        for _ in 1..times {
            took = took.min(ask().1);
        }
        look(&asked, &plan, took);
        let tails = match &plan.transition {
            Some(turns) => turns.iter().map(|turn| turn.to_rad).collect(),
            None => asked.tails,
        };
        // After a rest, the cycle before it may be done again.
        let held = plan.outcome == Outcome::Held;
        let previous = if held { asked.previous } else { plan.cycle.clone() };
        next = Some((tails, previous, (!held).then_some(plan)));
    }
}

/// One plan's figures.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Relative weighted error.
    pub error: f64,
    /// Whether the outcome is *planned*.
    pub planned: bool,
    /// Whether no tail turns before the cycle.
    pub still: bool,
    /// Whether tails turn in two steps.
    pub two_steps: bool,
    /// Mean rotation of a tail before the cycle, rad.
    pub travel_rad: f64,
    /// T + t_trans, s.
    pub interval_s: f64,
    /// Whether any module may miss it.
    pub loss_tolerant: bool,
    /// How long it took, µs.
    pub plan_us: f64,
}

impl Row {
    /// Of one plan of modules with these parameters.
    #[must_use]
    pub fn new(plan: &Plan, parameters: &Parameters, took: Duration) -> Self {
        Self {
            error: plan.error,
            planned: plan.outcome == Outcome::Planned,
            still: plan.transition.is_none(),
            two_steps: plan.via_rad.is_some(),
            travel_rad: plan.travel_rad / plan.cycle.len() as f64,
            interval_s: parameters.period_s + plan.transition_s,
            loss_tolerant: plan.loss_tolerant,
            plan_us: took.as_secs_f64() * 1e6,
        }
    }
}

/// Figures of a number of plans.
#[derive(Clone, Debug, Default)]
pub struct Rows(pub Vec<Row>);

impl Rows {
    /// The share of which `is` is true, %.
    #[must_use]
    pub fn percent(&self, is: impl Fn(&Row) -> bool) -> f64 {
        100.0 * self.0.iter().filter(|row| is(row)).count() as f64 / self.0.len() as f64
    }

    /// The mean of a figure.
    #[must_use]
    pub fn mean(&self, of: impl Fn(&Row) -> f64) -> f64 {
        mean(self.0.iter().map(of))
    }

    /// The quantiles of a figure.
    #[must_use]
    pub fn quantiles(&self, of: impl Fn(&Row) -> f64) -> Quantiles {
        Quantiles::of(self.0.iter().map(of))
    }
}

/// A stream of demands for one planner: some walks or sequences apart, each with a seed of its own.
#[derive(Clone)]
pub struct DemandStream {
    /// The structure.
    pub structure: Structure,
    /// Its modules.
    pub kind: Kind,
    /// The planner.
    pub config: PlannerConfig,
    /// Share of the envelope that demands keep to.
    pub share: f64,
    /// How they follow each other.
    pub sequence: Sequence,
    /// How many sequences.
    pub walks: usize,
    /// How many plans in each are counted.
    pub each: usize,
    /// How often each question is put, for the sake of the time.
    pub times: usize,
}

impl DemandStream {
    /// Makes the plans; their figures.
    #[must_use]
    pub fn run(&self) -> Rows {
        let envelope = self.kind.envelope(&self.structure);
        let mut rows = Rows::default();
        for walk in 0..self.walks {
            let demands = self.sequence.demands(&envelope, self.share, 1 + walk as u64, self.each + 1);
            let mut planner = self.kind.planner(&self.structure, &self.config);
            follow(&mut planner, demands, self.times, |_, plan, took| {
                rows.0.push(Row::new(plan, &self.kind.parameters, took));
            });
        }
        rows
    }
}

/// The default settings with this planner.
#[must_use]
pub fn settings(kind: PlannerKind) -> PlannerConfig {
    PlannerConfig { kind, ..PlannerConfig::default() }
}

/// What `work` makes of each of `jobs`, in their order, done on all cores.
///
/// # Panics
/// If `work` does.
pub fn on_both_cores<J: Sync, R: Send>(jobs: &[J], work: impl Fn(&J) -> R + Sync) -> Vec<R> {
    on_all_cores(0..jobs.len() as u64, |index| work(&jobs[index as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_come_back_in_order() {
        let jobs: Vec<usize> = (0..100).collect();
        assert_eq!(on_both_cores(&jobs, |job| 2 * job), jobs.iter().map(|job| 2 * job).collect::<Vec<_>>());
    }

    /// One of two planners of the same demands sees what the other sees: every question begins where its own last answer
    /// ended, and nothing is asked without known tails.
    #[test]
    fn every_question_begins_where_the_last_answer_ended() {
        let kind = Kind::new(Parameters::default());
        let structure = Structure::from_word("2x2").unwrap();
        let envelope = kind.envelope(&structure);
        let demands = Sequence::Apart.demands(&envelope, 0.6, 3, 21);
        let mut planner = kind.planner(&structure, &settings(PlannerKind::Exact));
        let (mut ends, mut seen): (Option<Vec<f64>>, usize) = (None, 0);
        follow(&mut planner, demands.iter().copied(), 2, |asked, plan, _| {
            seen += 1;
            assert_eq!(asked.demand, demands[seen]);
            assert!(ends.as_ref().is_none_or(|ends| *ends == asked.tails));
            ends = plan.transition.as_ref().map_or_else(
                || Some(asked.tails.clone()),
                |turns| Some(turns.iter().map(|turn| turn.to_rad).collect()),
            );
        });
        assert_eq!(seen, 20);
    }
}
