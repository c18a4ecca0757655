//! A planner that is warm allocates nothing: every allocation of a decision is counted, over walks of demands, each decision from
//! where the one before leaves the tails. The first half of a walk is for the planner to warm up.
//!
//! `cargo test -p tests --test allocations -- --nocapture` prints the table.

use allocation_counter::measure;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::plan::{Outcome, Plan};
use modboat::planner::Planner;
use modboat::planner_config::{LossTolerance, PlannerConfig};
use modboat::planner_kind::PlannerKind;
use modboat::structure::Structure;
use tests::seeds::on_all_cores;
use tests::stream::{Kind, Sequence, settings};

const SEED: u64 = 11;
/// Structures, with the decisions of a walk.
const WALKS: [(&str, usize); 5] = [("3x1", 600), ("2x2", 600), ("3x3", 600), ("5x5", 400), ("32x32", 20)];
/// How demands follow each other, and the share of the envelope that they keep to: walks as of a closed loop and in long steps, demands
/// near the envelope's border, some of them outside.
const DEMANDS: [(Sequence, f64); 4] = [
    (Sequence::Walk(0.03), 0.6),
    (Sequence::Walk(0.3), 0.6),
    (Sequence::Apart, 0.95),
    (Sequence::Apart, 1.2),
];

/// Allocations of each decision.
fn walk(planner: &mut Planner, demands: impl IntoIterator<Item = Wrench>) -> Vec<u64> {
    let (mut plan, mut before) = (Plan::default(), Plan::default());
    let mut tails: Vec<f64> = Vec::new();
    let mut counts = Vec::new();
    for demand in demands {
        let is_first = counts.is_empty();
        let known = (!is_first).then_some(&tails[..]);
        let previous = (!is_first).then(|| before.as_previous());
        counts.push(measure(|| planner.plan_into(demand, known, previous, &mut plan)).count_total);
        if let Some(turns) = &plan.transition {
            tails.clear();
            tails.extend(turns.iter().map(|turn| turn.to_rad));
        } else if is_first {
            tails.extend(plan.cycle.iter().map(|swing| swing.start_rad()));
        }
        if is_first || plan.outcome != Outcome::Held {
            std::mem::swap(&mut plan, &mut before);
        }
    }
    counts
}

#[test]
fn a_warm_planner_allocates_nothing() {
    let kind = Kind::new(Parameters::default());
    let mut jobs = Vec::new();
    for (shape, count) in WALKS {
        jobs.extend(DEMANDS.map(|demands| ("exact", PlannerConfig::default(), shape, count, demands)));
    }
    for (shape, count) in [("3x1", 600), ("3x3", 200)] {
        for (name, loss_tolerant) in [("require", LossTolerance::Require), ("power", LossTolerance::Power)] {
            let config = PlannerConfig { loss_tolerant, ..PlannerConfig::default() };
            jobs.extend([0, 2].map(|k| (name, config.clone(), shape, count, DEMANDS[k])));
        }
        let kind = PlannerKind::PotentialField;
        jobs.extend([0, 2].map(|k| (kind.name(), settings(kind), shape, count, DEMANDS[k])));
    }
    println!("allocations per decision");
    println!(
        "planner         | structure | demands      share | decisions | 1st half | 2nd half | most | decisions with any"
    );
    let mut failed = Vec::new();
    // What is counted is what the thread allocates.
    let counted = on_all_cores(0..jobs.len() as u64, |job| {
        let (_, config, shape, count, (sequence, share)) = &jobs[job as usize];
        let structure = Structure::from_word(shape).unwrap();
        let demands = sequence.demands(&kind.envelope(&structure), *share, SEED, *count);
        walk(&mut kind.planner(&structure, config), demands)
    });
    for ((name, _, shape, count, (sequence, share)), counts) in jobs.iter().zip(counted) {
        let (first, second) = counts.split_at(count / 2);
        let mean = |counts: &[u64]| counts.iter().sum::<u64>() as f64 / counts.len() as f64;
        let most = second.iter().max().copied().unwrap_or(0);
        let any = second.iter().filter(|count| **count > 0).count();
        let (warm, cold) = (mean(second), mean(first));
        println!(
            "{name:<15} | {shape:<9} | {sequence:<12} {share:>5} | {count:>9} | {cold:>8.2} | {warm:>8.2} | {most:>4} | {any}"
        );
        if most > 0 {
            failed.push(format!(
                "{name}, {shape}, {sequence}, {share} of the envelope, seed {SEED}: up to {most} in {any} decisions"
            ));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
