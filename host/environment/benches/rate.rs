//! Steps a second of 256 environments by both fidelities, on one thread and on all cores.
//!
//! `cargo bench -p environment` prints the medians of nine rounds and their ratios. Behind `--`, `serve cycle` or `serve module` steps on
//! all cores for each line that comes in, so often as the line says, and answers with the seconds that took: what
//! `host/python/bench/environments.py` takes turns with.

use std::io::{BufRead, Write};
use std::time::Instant;

use environment::batch::{Batch, Seen};
use environment::layout::INFO;
use environment::settings::{Fidelity, Settings};
use host::run::scenario::Scenario;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

const ENVIRONMENTS: usize = 256;
const ROUNDS: usize = 9;
const FIDELITIES: [(&str, Fidelity, usize); 2] =
    [("cycle", Fidelity::Cycle, 400), ("module", Fidelity::Module, 2)];

/// A batch that is warm, and what it is stepped with.
struct Bench {
    batch: Batch,
    actions: Vec<Vec<f64>>,
    observations: Vec<f64>,
    rewards: Vec<f64>,
    ends: [Vec<bool>; 2],
    info: Vec<f64>,
}

impl Bench {
    fn new(fidelity: Fidelity, threads: usize) -> Self {
        let scenario = Scenario::open("holonomic-1").expect("a scenario");
        let settings = Settings { fidelity, autoreset: true, ..Settings::new(scenario) };
        let mut batch = Batch::new(&settings, ENVIRONMENTS, threads).expect("a batch");
        let seeds: Vec<Option<u64>> = (0..ENVIRONMENTS as u64).map(Some).collect();
        let mut observations = vec![0.0; ENVIRONMENTS * batch.layout().observation];
        let mut info = vec![0.0; ENVIRONMENTS * INFO.len()];
        batch.reset(&seeds, &[true; ENVIRONMENTS], &mut observations, &mut info).expect("resets");
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let highs = &batch.layout().action_high;
        let mut action = || {
            let all = highs.iter().cycle().take(ENVIRONMENTS * highs.len());
            all.map(|high| high * rng.random_range(-1.0..1.0)).collect()
        };
        let actions = (0..8).map(|_| action()).collect();
        let ends = [vec![false; ENVIRONMENTS], vec![false; ENVIRONMENTS]];
        Self { batch, actions, observations, rewards: vec![0.0; ENVIRONMENTS], ends, info }
    }

    /// Seconds that so many steps of all take.
    fn seconds(&mut self, steps: usize) -> f64 {
        let began = Instant::now();
        for step in 0..steps {
            let [terminated, truncated] = &mut self.ends;
            let seen = Seen {
                observations: &mut self.observations,
                rewards: &mut self.rewards,
                terminated,
                truncated,
                info: &mut self.info,
            };
            self.batch.step(&self.actions[step % self.actions.len()], seen).expect("steps");
        }
        began.elapsed().as_secs_f64()
    }
}

/// Median steps a second.
fn rate(fidelity: Fidelity, threads: usize, steps: usize) -> f64 {
    let mut bench = Bench::new(fidelity, threads);
    let mut seconds: Vec<f64> = (0..ROUNDS).map(|_| bench.seconds(steps)).collect();
    seconds.sort_by(f64::total_cmp);
    (steps * ENVIRONMENTS) as f64 / seconds[ROUNDS / 2]
}

fn serve(fidelity: Fidelity) {
    let mut bench = Bench::new(fidelity, 0);
    for line in std::io::stdin().lock().lines() {
        let steps = line.ok().and_then(|line| line.trim().parse().ok()).expect("a number of steps");
        println!("{}", bench.seconds(steps));
        std::io::stdout().flush().expect("told");
    }
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let names = |name: &str| asked.iter().any(|asked| asked == name);
    for (name, fidelity, steps) in FIDELITIES {
        if names("serve") {
            if names(name) {
                serve(fidelity);
            }
            continue;
        }
        let steps = if names("--test") { 1 } else { steps };
        let (one, all) = (rate(fidelity, 1, steps), rate(fidelity, 0, steps));
        println!(
            "{name:<7} {ENVIRONMENTS} environments of 3 modules: {one:.0} steps/s on one thread, {all:.0} on all cores, × {:.2}",
            all / one
        );
    }
}
