//! Tests of the environments: against the run they are a part of, against each other, and of what baselines are worth.

mod baselines;
mod batches;
mod episodes;
mod same_as_a_run;
mod steps_allocate_nothing;

use environment::batch::{Batch, Seen};
use environment::layout::INFO;
use environment::settings::Settings;
use host::run::scenario::Scenario;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Everything that a batch has told so far, in order.
#[derive(Clone, Debug, Default, PartialEq)]
struct Told {
    observations: Vec<f64>,
    rewards: Vec<f64>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
    info: Vec<f64>,
}

impl Told {
    fn of(batch: &Batch) -> Self {
        let count = batch.len();
        Self {
            observations: vec![0.0; count * batch.layout().observation],
            rewards: vec![0.0; count],
            terminated: vec![false; count],
            truncated: vec![false; count],
            info: vec![0.0; count * INFO.len()],
        }
    }

    fn seen(&mut self) -> Seen<'_> {
        Seen {
            observations: &mut self.observations,
            rewards: &mut self.rewards,
            terminated: &mut self.terminated,
            truncated: &mut self.truncated,
            info: &mut self.info,
        }
    }

    /// What is told of environment `index` of `count`.
    fn one(&self, index: usize, count: usize) -> Self {
        let part = |all: &[f64]| {
            let size = all.len() / count;
            all[index * size..(index + 1) * size].to_vec()
        };
        Self {
            observations: part(&self.observations),
            rewards: part(&self.rewards),
            terminated: vec![self.terminated[index]],
            truncated: vec![self.truncated[index]],
            info: part(&self.info),
        }
    }
}

fn reset(batch: &mut Batch, seeds: &[Option<u64>], told: &mut Told) {
    let chosen = vec![true; seeds.len()];
    batch.reset(seeds, &chosen, &mut told.observations, &mut told.info).expect("resets");
}

fn settings(text: &str) -> Settings {
    Settings::new(Scenario::parse("test.toml", text).expect("a scenario"))
}

/// A scenario of this shape without legs.
fn shape(size: &str) -> String {
    format!("name = \"t\"\nleg = []\n[structure]\nsize = \"{size}\"\n")
}

/// Actions within their bounds.
fn random_action(batch_low: &[f64], batch_high: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    batch_low.iter().zip(batch_high).map(|(low, high)| low + (high - low) * rng.random::<f64>()).collect()
}

fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}
