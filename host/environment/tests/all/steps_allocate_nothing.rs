//! Steps of a warm environment allocate nothing: in the fidelity `cycle` over ends of episodes too; in `module` a reset makes a fleet.

use std::sync::Arc;

use allocation_counter::measure;
use environment::environment::Environment;
use environment::layout::Layout;
use environment::settings::{Fidelity, Settings};

use super::{generator, random_action, settings, shape};

#[test]
fn of_mean_cycles() {
    let settings =
        Settings { fidelity: Fidelity::Cycle, duration_s: 20.0, autoreset: true, ..settings(&shape("3x3")) };
    let layout = Layout::new(&settings);
    let mut environment = Environment::new(Arc::new(settings), Arc::new(layout.clone()));
    let mut observation = vec![0.0; layout.observation];
    environment.reset(Some(6), &mut observation).expect("resets");
    let mut rng = generator(6);
    for step in 0..200 {
        let action = random_action(&layout.action_low, &layout.action_high, &mut rng);
        let count = measure(|| {
            environment.step(0, &action, &mut observation).expect("steps");
        });
        assert!(step < 3 || count.count_total == 0, "step {step}: {count:?}");
    }
}

#[test]
fn of_simulated_modules() {
    let settings = Settings { duration_s: 1e4, ..settings(&shape("3x1")) };
    let layout = Layout::new(&settings);
    let mut environment = Environment::new(Arc::new(settings), Arc::new(layout.clone()));
    let mut observation = vec![0.0; layout.observation];
    environment.reset(Some(6), &mut observation).expect("resets");
    let (mut rng, mut steps_without) = (generator(6), 0);
    for step in 0..60 {
        let action = random_action(&layout.action_low, &layout.action_high, &mut rng);
        let count = measure(|| {
            environment.step(0, &action, &mut observation).expect("steps");
        });
        // The tank lists contacts, of which actions at random have many.
        let lists = environment.info()[5] > 0.0;
        assert!(step < 5 || lists || count.count_total == 0, "step {step}: {count:?}");
        assert!(step < 5 || count.count_total <= 1, "step {step}: {count:?}");
        steps_without += u32::from(!lists);
    }
    assert!(steps_without > 5, "{steps_without}");
}
