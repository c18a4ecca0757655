//! A batch is so many single environments, digit for digit, whatever the threads and the place in it.

use environment::batch::Batch;
use environment::settings::{Fidelity, Settings, Task};
use rand::rngs::ChaCha8Rng;

use super::{Told, generator, random_action, reset, settings, shape};

/// Steps of environments with these seeds on so many threads, each by actions of its own generator; what each was told.
fn steps(settings: &Settings, seeds: &[u64], threads: usize, steps: usize) -> Vec<Vec<Told>> {
    let mut batch = Batch::new(settings, seeds.len(), threads).expect("a batch");
    let mut told = Told::of(&batch);
    let all: Vec<Option<u64>> = seeds.iter().copied().map(Some).collect();
    reset(&mut batch, &all, &mut told);
    let mut generators: Vec<ChaCha8Rng> = seeds.iter().map(|seed| generator(seed ^ 0xAC)).collect();
    let mut each: Vec<Vec<Told>> = (0..seeds.len()).map(|index| vec![told.one(index, seeds.len())]).collect();
    for _ in 0..steps {
        let layout = batch.layout();
        let actions: Vec<f64> = generators
            .iter_mut()
            .flat_map(|rng| random_action(&layout.action_low, &layout.action_high, rng))
            .collect();
        batch.step(&actions, told.seen()).expect("steps");
        for (index, told_of) in each.iter_mut().enumerate() {
            told_of.push(told.one(index, seeds.len()));
        }
    }
    each
}

fn are_the_same(settings: &Settings, seeds: &[u64], count: usize) {
    let alone: Vec<Vec<Told>> = seeds.iter().flat_map(|&seed| steps(settings, &[seed], 1, count)).collect();
    for threads in [1, 2, 3] {
        assert_eq!(steps(settings, seeds, threads, count), alone, "seeds {seeds:?}, {threads} threads");
    }
    let back: Vec<u64> = seeds.iter().rev().copied().collect();
    let mut turned = steps(settings, &back, 2, count);
    turned.reverse();
    assert_eq!(turned, alone, "seeds {back:?}");
    assert_ne!(alone[0], alone[1], "seeds {seeds:?}");
}

#[test]
fn of_mean_cycles() {
    for task in [Task::Velocity, Task::Station] {
        // Short episodes: all of them end and begin again.
        let settings = Settings {
            fidelity: Fidelity::Cycle,
            task,
            duration_s: 12.0,
            autoreset: true,
            ..settings(&shape("3x2"))
        };
        are_the_same(&settings, &[7, 8, 1 << 60, 9, 0, 11, 12], 40);
    }
}

#[test]
fn of_simulated_modules() {
    // With everything that draws: spread of motors and thrust, gusts, clocks, loss.
    let text = format!(
        "{}[motor]\nspread = 0.1\n[tank]\ngust_m_s = 0.005\n[tank.thrust]\nspread = 0.1\n[radio]\nloss = 0.1\n",
        shape("2x1")
    );
    let settings = Settings { duration_s: 6.0, autoreset: true, ..settings(&text) };
    are_the_same(&settings, &[3, 4, 5, 6], 6);
}
