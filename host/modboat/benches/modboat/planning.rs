//! Whole plans of either planner at 3 to 1,024 modules, and the potential field's transitions alone at 3, 9 and 25.

use std::hint::black_box;
use std::sync::Arc;

use criterion::Criterion;
use modboat::distance::DistanceToCollision;
use modboat::motion::Swing;
use modboat::pairs::{Pair, Pairs};
use modboat::parameters::Parameters;
use modboat::planner_config::PlannerConfig;
use modboat::planner_kind::PlannerKind;
use modboat::structure::Structure;
use modboat::transition::solver::Solver;
use modboat::transition::{self, Transition};

use crate::demands::{Question, SHAPES, Sequence, demands, planner, stream};

/// Questions that a bench goes through in turn.
const QUESTIONS: usize = 128;

/// Sizes of whole plans, and how many questions for each.
const SIZES: [(&str, usize); 5] =
    [("3x1", QUESTIONS), ("3x3", QUESTIONS), ("5x5", QUESTIONS), ("10x10", 48), ("32x32", 16)];
/// Structures from which on a plan is measured as seldom as criterion lets one.
const LARGE: usize = 100;

/// Whole plans of either planner, with their transition and the exact check. Each goes on from its own plans.
pub fn plan(criterion: &mut Criterion) {
    let distance = Arc::new(DistanceToCollision::new(&Parameters::default()));
    for kind in PlannerKind::ALL {
        let mut group = criterion.benchmark_group(format!("plan {}", kind.name()));
        for (shape, count) in SIZES {
            let structure = Structure::from_word(shape).expect(shape);
            if structure.len() >= LARGE {
                group.sample_size(10);
            }
            for sequence in Sequence::BOTH {
                let name = format!("{} modules, {}", structure.len(), sequence.name());
                let (mut planner, mut questions) = (planner(kind, &structure, &distance), Vec::new());
                // Made when it is its turn, so that a filter on the command line saves the time.
                group.bench_function(name, |b| {
                    if questions.is_empty() {
                        let demands = demands(&structure, sequence, count);
                        stream(&mut planner, &demands, sequence, |question, planner| {
                            questions.push(Question {
                                demand: question.demand,
                                tails: question.tails.clone(),
                                previous: question.previous.clone(),
                            });
                            question.ask(planner)
                        });
                    }
                    let mut turn = questions.iter().cycle();
                    b.iter(|| turn.next().map(|question| black_box(question.ask(&mut planner))));
                });
            }
        }
        group.finish();
    }
}

/// The transition solver between cycles that have nothing to do with each other, collision checks included.
pub fn transition(criterion: &mut Criterion) {
    let (parameters, config) = (Parameters::default(), PlannerConfig::default());
    let distance = Arc::new(DistanceToCollision::new(&parameters));
    let limit_rad = parameters.tail_speed_max_rad_s * parameters.transition_s;
    let mut group = criterion.benchmark_group("transition");
    for shape in SHAPES {
        let structure = Structure::from_word(shape).expect(shape);
        let pairs = distance.offsets().iter().enumerate().flat_map(|(offset, &cells)| {
            structure.neighbours(cells).map(move |(i, j)| Pair { i, j, offset })
        });
        let pairs = Pairs::new(structure.len(), pairs);
        let mut cycles: Vec<(Vec<f64>, Vec<Swing>)> = Vec::new();
        let demands = demands(&structure, Sequence::Uncorrelated, QUESTIONS);
        let field = PlannerKind::PotentialField;
        stream(
            &mut planner(field, &structure, &distance),
            &demands,
            Sequence::Uncorrelated,
            |question, planner| {
                let plan = question.ask(planner);
                cycles.extend(question.tails.clone().map(|tails| (tails, plan.cycle.clone())));
                plan
            },
        );
        let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| {
            distance.clear(offset, from, to, config.transition_margin_rad)
        };
        let mut turn = cycles.iter().cycle();
        group.bench_function(format!("{} modules", structure.len()), |b| {
            b.iter(|| {
                let (tails, cycle) = turn.next()?;
                let (mut solver, mut best) = (Solver::default(), Transition::default());
                black_box(transition::solve(&mut solver, &pairs, tails, cycle, limit_rad, clear, &mut best));
                Some(best)
            });
        });
    }
    group.finish();
}
