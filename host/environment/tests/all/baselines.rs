//! What baselines are worth: far more than actions at random, in both tasks and fidelities, with either planner and kind of action.

use environment::batch::Batch;
use environment::settings::{ActionKind, Fidelity, Settings, Task};
use modboat::planner_kind::PlannerKind;

use super::{Told, generator, random_action, reset, settings, shape};

/// Mean reward of episodes, and contacts in them; by a baseline or at random.
fn episodes(settings: &Settings, seeds: std::ops::Range<u64>, by: Option<PlannerKind>) -> (f64, f64) {
    let seeds: Vec<Option<u64>> = seeds.map(Some).collect();
    let mut batch = Batch::new(settings, seeds.len(), 2).expect("a batch");
    let mut told = Told::of(&batch);
    reset(&mut batch, &seeds, &mut told);
    let (mut rewards, mut contacts, mut rng) = (0.0, 0.0, generator(5));
    let mut running = vec![true; seeds.len()];
    let size = batch.layout().action();
    let mut actions = vec![0.0; seeds.len() * size];
    while running.contains(&true) {
        match by {
            Some(kind) => batch.advise(kind, &mut actions).expect("advice"),
            None => {
                for action in actions.chunks_exact_mut(size) {
                    let layout = batch.layout();
                    action.copy_from_slice(&random_action(&layout.action_low, &layout.action_high, &mut rng));
                }
            }
        }
        batch.step(&actions, told.seen()).expect("steps");
        for (index, running) in running.iter_mut().enumerate().filter(|(_, running)| **running) {
            rewards += told.rewards[index];
            contacts += told.one(index, seeds.len()).info[5];
            *running = !(told.terminated[index] || told.truncated[index]);
        }
    }
    (rewards / seeds.len() as f64, contacts)
}

fn compare(settings: &Settings, seeds: std::ops::Range<u64>, kinds: &[PlannerKind]) {
    let settings = Settings { autoreset: true, ..settings.clone() };
    let (random, _) = episodes(&settings, seeds.clone(), None);
    for &kind in kinds {
        let (reward, contacts) = episodes(&settings, seeds.clone(), Some(kind));
        println!(
            "{:?} {:?} {:?} {}: {reward:.1}, at random {random:.1}",
            settings.fidelity,
            settings.task,
            settings.action,
            kind.name()
        );
        let what = format!("{kind:?}, {seeds:?}: {reward} against {random}, {contacts} contacts");
        // Less than a quarter of what random actions lose.
        assert!(reward > 0.25 * random, "{what}");
        assert!(contacts == 0.0, "{what}");
    }
}

const BOTH: [PlannerKind; 2] = [PlannerKind::Exact, PlannerKind::PotentialField];

#[test]
fn in_mean_cycles() {
    for task in [Task::Velocity, Task::Station] {
        for action in [ActionKind::Swing, ActionKind::Wrench] {
            let kinds = if action == ActionKind::Swing { &BOTH[..] } else { &BOTH[..1] };
            let settings = Settings { fidelity: Fidelity::Cycle, task, action, ..settings(&shape("3x1")) };
            compare(&settings, 0..16, kinds);
        }
    }
}

#[test]
fn in_simulated_modules() {
    for task in [Task::Velocity, Task::Station] {
        let settings = Settings { task, duration_s: 60.0, ..settings(&shape("3x1")) };
        compare(&settings, 0..4, &BOTH);
    }
}
