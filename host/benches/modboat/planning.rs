//! Whole plans and transitions alone, at 3, 9 and 25 modules.

use std::hint::black_box;
use std::sync::Arc;

use criterion::Criterion;
use host::modboat::distance::DistanceToCollision;
use host::modboat::motion::Swing;
use host::modboat::pairs::{Pair, Pairs};
use host::modboat::parameters::Parameters;
use host::modboat::planner_config::PlannerConfig;
use host::modboat::structure::Structure;
use host::modboat::transition;

use crate::demands::{Question, SHAPES, Sequence, demands, planner, stream};

/// Questions that a bench goes through in turn.
const QUESTIONS: usize = 128;

/// Potential-field plans with their transition and the exact check.
pub fn plan(criterion: &mut Criterion) {
    let distance = Arc::new(DistanceToCollision::new(&Parameters::default()));
    let mut group = criterion.benchmark_group("plan");
    for shape in SHAPES {
        let structure = Structure::from_word(shape).expect(shape);
        for sequence in Sequence::BOTH {
            let mut planner = planner(&structure, &distance);
            let mut questions = Vec::new();
            stream(&mut planner, &demands(&structure, sequence, QUESTIONS), sequence, |question, planner| {
                questions.push(Question {
                    demand: question.demand,
                    tails: question.tails.clone(),
                    previous: question.previous.clone(),
                });
                question.ask(planner)
            });
            let mut turn = questions.iter().cycle();
            group.bench_function(format!("{} modules, {}", structure.len(), sequence.name()), |b| {
                b.iter(|| turn.next().map(|question| black_box(question.ask(&mut planner))));
            });
        }
    }
    group.finish();
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
        stream(&mut planner(&structure, &distance), &demands, Sequence::Uncorrelated, |question, planner| {
            let plan = question.ask(planner);
            cycles.extend(question.tails.clone().map(|tails| (tails, plan.cycle.clone())));
            plan
        });
        let clear = |offset: usize, from: [f64; 2], to: [f64; 2]| {
            distance.clear(offset, from, to, config.transition_margin_rad)
        };
        let mut turn = cycles.iter().cycle();
        group.bench_function(format!("{} modules", structure.len()), |b| {
            b.iter(|| {
                let (tails, cycle) = turn.next()?;
                black_box(transition::solve(&pairs, structure.cells(), tails, cycle, limit_rad, clear))
            });
        });
    }
    group.finish();
}
