//! Steps a second of 256 environments by both fidelities, on one thread and on all cores.
//!
//! `cargo bench -p environment` prints the medians of nine rounds and their ratios; with `cycle` or `module` behind `--`, of that one.

use std::time::Instant;

use environment::batch::{Batch, Seen};
use environment::layout::INFO;
use environment::settings::{Fidelity, Settings};
use host::run::scenario::Scenario;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

const ENVIRONMENTS: usize = 256;
const ROUNDS: usize = 9;

/// Median steps a second.
fn rate(fidelity: Fidelity, threads: usize, steps: usize) -> f64 {
    let scenario = Scenario::parse("bench.toml", "name = \"bench\"\nleg = []\n[structure]\nsize = \"3x1\"\n")
        .expect("a scenario");
    let settings = Settings { fidelity, autoreset: true, ..Settings::new(scenario) };
    let mut batch = Batch::new(&settings, ENVIRONMENTS, threads).expect("a batch");
    let seeds: Vec<Option<u64>> = (0..ENVIRONMENTS as u64).map(Some).collect();
    let mut observations = vec![0.0; ENVIRONMENTS * batch.layout().observation];
    let mut info = vec![0.0; ENVIRONMENTS * INFO.len()];
    batch.reset(&seeds, &[true; ENVIRONMENTS], &mut observations, &mut info).expect("resets");
    let (mut rewards, mut ends) = ([0.0; ENVIRONMENTS], [[false; ENVIRONMENTS]; 2]);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let highs = batch.layout().action_high.clone();
    let actions: Vec<Vec<f64>> = (0..8)
        .map(|_| {
            let one = highs.iter().cycle().take(ENVIRONMENTS * highs.len());
            one.map(|high| high * rng.random_range(-1.0..1.0)).collect()
        })
        .collect();
    let mut rates: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let began = Instant::now();
            for step in 0..steps {
                let [terminated, truncated] = &mut ends;
                let seen = Seen {
                    observations: &mut observations,
                    rewards: &mut rewards,
                    terminated,
                    truncated,
                    info: &mut info,
                };
                batch.step(&actions[step % actions.len()], seen).expect("steps");
            }
            (steps * ENVIRONMENTS) as f64 / began.elapsed().as_secs_f64()
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    rates[ROUNDS / 2]
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let quick = asked.iter().any(|argument| argument == "--test");
    let names = asked.iter().filter(|argument| !argument.starts_with('-')).collect::<Vec<_>>();
    for (name, fidelity, steps) in [("cycle", Fidelity::Cycle, 400), ("module", Fidelity::Module, 2)] {
        if !names.is_empty() && names.iter().all(|asked| *asked != name) {
            continue;
        }
        let steps = if quick { 1 } else { steps };
        let (one, all) = (rate(fidelity, 1, steps), rate(fidelity, 0, steps));
        println!(
            "{name:<7} {ENVIRONMENTS} environments of 3 modules: {one:.0} steps/s on one thread, {all:.0} on all cores, × {:.2}",
            all / one
        );
    }
}
