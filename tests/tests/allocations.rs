//! A planner that is warm allocates nothing: every allocation of a decision is counted, over walks of demands, each decision from
//! where the one before leaves the tails.
//!
//! `cargo test -p tests --test allocations -- --nocapture` prints the table.

use allocation_counter::measure;
use host::modboat::parameters::Parameters;
use host::modboat::plan::{Outcome, Plan};
use host::modboat::planner_config::PlannerConfig;
use host::modboat::structure::Structure;
use tests::stream::{Kind, Sequence};

/// Structures, with the decisions of a walk.
const WALKS: [(&str, usize); 5] = [("3x1", 2000), ("2x2", 2000), ("3x3", 2000), ("5x5", 1000), ("32x32", 60)];
const SEED: u64 = 11;

fn walk(
    kind: &Kind,
    word: &str,
    config: &PlannerConfig,
    sequence: Sequence,
    share: f64,
    count: usize,
) -> Vec<u64> {
    let structure = Structure::from_word(word).unwrap();
    let mut planner = kind.planner(&structure, config);
    let demands = sequence.demands(&kind.envelope(&structure), share, SEED, count);
    let (mut plan, mut before) = (Plan::default(), Plan::default());
    let mut tails: Vec<f64> = Vec::new();
    let mut counts = Vec::new();
    for (k, demand) in demands.into_iter().enumerate() {
        let known = (k > 0).then_some(&tails[..]);
        let previous = (k > 0).then_some(&before.cycle[..]);
        counts.push(measure(|| planner.plan_into(demand, known, previous, &mut plan)).count_total);
        if let Some(turns) = &plan.transition {
            tails.clear();
            tails.extend(turns.iter().map(|turn| turn.to_rad));
        } else if k == 0 {
            tails.extend(plan.cycle.iter().map(|swing| swing.start_rad()));
        }
        if plan.outcome != Outcome::Held || k == 0 {
            std::mem::swap(&mut plan, &mut before);
        }
    }
    counts
}

#[test]
fn a_warm_planner_allocates_nothing() {
    let kind = Kind::new(Parameters::default());
    let mut table = "shape   demands        share | decisions | first | 1st half, mean | 2nd half: mean   most  decisions with any\n".to_owned();
    let mut failed = Vec::new();
    for (word, count) in WALKS {
        for (sequence, share) in [
            (Sequence::Walk(0.05), 0.6),
            (Sequence::Walk(0.3), 0.6),
            (Sequence::Apart, 0.95),
            (Sequence::Apart, 1.2),
        ] {
            let counts = walk(&kind, word, &PlannerConfig::default(), sequence, share, count);
            let (first, second) = counts.split_at(count / 2);
            let mean = |counts: &[u64]| counts.iter().sum::<u64>() as f64 / counts.len() as f64;
            let most = second.iter().max().copied().unwrap_or(0);
            let any = second.iter().filter(|count| **count > 0).count();
            table += &format!(
                "{word:<7} {sequence:<14} {share:>5} | {count:>9} | {:>5} | {:>14.2} | {:>14.2} {most:>6} {any:>6}\n",
                counts[0],
                mean(first),
                mean(second)
            );
            if most > 0 {
                failed.push(format!("{word}, {sequence}, {share} of the envelope, seed {SEED}: {most} allocations in one decision, {any} decisions"));
            }
        }
    }
    println!("{table}");
    assert!(failed.is_empty(), "{failed:#?}");
}
