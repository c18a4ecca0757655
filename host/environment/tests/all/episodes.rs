//! How episodes begin and end, and what is refused.

use std::ops::Add;

use environment::batch::Batch;
use environment::settings::{ContactRule, EnvironmentError, Fidelity, Settings, Task};

use super::{Told, generator, random_action, reset, settings, shape};

fn cycles(text: &str) -> Settings {
    Settings { fidelity: Fidelity::Cycle, ..settings(text) }
}

#[test]
fn an_episode_ends_when_its_time_is_over_and_no_step_goes_on_after_it() {
    let settings = Settings { duration_s: 15.0, ..cycles(&shape("3x1")) };
    let mut batch = Batch::new(&settings, 1, 1).expect("a batch");
    let mut told = Told::of(&batch);
    assert!(matches!(batch.step(&[0.0; 9], told.seen()), Err(EnvironmentError::Over { environment: 0 })));
    reset(&mut batch, &[Some(1)], &mut told);
    // All at rest: ten periods of 1.5 s.
    for step in 1..=10 {
        batch.step(&[0.0; 9], told.seen()).expect("steps");
        assert_eq!((told.truncated[0], told.terminated[0]), (step == 10, false), "step {step}");
        assert!((told.info[0] - 1.5 * f64::from(step)).abs() < 1e-9, "{:?}", told.info);
    }
    assert!(matches!(batch.step(&[0.0; 9], told.seen()), Err(EnvironmentError::Over { .. })));
    reset(&mut batch, &[None], &mut told);
    batch.step(&[0.0; 9], told.seen()).expect("steps again");
}

#[test]
fn with_autoreset_the_step_after_the_last_begins_the_next_episode() {
    let settings = Settings { duration_s: 3.0, autoreset: true, ..cycles(&shape("2x1")) };
    let mut batch = Batch::new(&settings, 1, 1).expect("a batch");
    let mut told = Told::of(&batch);
    reset(&mut batch, &[Some(4)], &mut told);
    let first = told.observations.clone();
    for episode in 0..3 {
        for truncated in [false, true] {
            batch.step(&[0.0; 6], told.seen()).expect("steps");
            assert_eq!(told.truncated[0], truncated, "episode {episode}");
        }
        batch.step(&[0.0; 6], told.seen()).expect("begins");
        assert_eq!((told.truncated[0], told.rewards[0], told.info[0]), (false, 0.0, 0.0));
        assert_ne!(told.observations, first, "another draw");
    }
}

#[test]
fn tails_that_touch_cost_reward_or_end_the_episode() {
    // Both tails swing about each other's module: 0 towards +x, 1 towards −x.
    let meet = [0.0, 1.5, 0.0, std::f64::consts::PI, 1.5, 0.0];
    for (contact, fidelity, ends) in [
        (ContactRule::Penalty, Fidelity::Cycle, false),
        (ContactRule::Terminate, Fidelity::Cycle, true),
        (ContactRule::Terminate, Fidelity::Module, true),
    ] {
        let settings = Settings { contact, fidelity, ..settings(&shape("2x1")) };
        let mut batch = Batch::new(&settings, 1, 1).expect("a batch");
        let mut told = Told::of(&batch);
        reset(&mut batch, &[Some(2)], &mut told);
        batch.step(&meet, told.seen()).expect("steps");
        assert!(told.info[5] >= 1.0 && told.rewards[0] <= -1.0, "{fidelity:?} {told:?}");
        assert_eq!(told.terminated[0], ends, "{fidelity:?}");
    }
}

#[test]
fn legs_of_a_scenario_follow_each_other() {
    let legs = "[[leg]]\nduration_s = 6.0\nvelocity_m_s = [0.04, 0.0]\nheading_rad = 1.5\n\
                [[leg]]\nduration_s = 6.0\nposition_m = [0.2, 0.1]\nheading_rad = 0.0\n";
    let settings = Settings {
        task: Task::Legs,
        duration_s: 12.0,
        ..cycles(&shape("3x1").replace("leg = []\n", "").add(legs))
    };
    let mut batch = Batch::new(&settings, 1, 1).expect("a batch");
    let mut told = Told::of(&batch);
    reset(&mut batch, &[Some(1)], &mut told);
    for step in 0..8 {
        let asks_for_place = told.observations[0].hypot(told.observations[1]) > 0.0;
        let asks_for_speed = told.observations[2].hypot(told.observations[3]) > 0.0;
        assert_eq!((asks_for_speed, asks_for_place), (step < 4, step >= 4), "step {step}");
        batch.step(&[0.0; 9], told.seen()).expect("steps");
    }
    assert!(told.truncated[0]);
}

/// In water this thick no tail follows its reference: modules stop, and take no cycle any more.
#[test]
fn an_episode_ends_when_a_module_takes_no_cycle_any_more() {
    let mut thick = settings(&shape("2x1"));
    // A file that says so is refused.
    thick.scenario.motor.tail_drag_n_m_s2 = 0.01;
    let mut batch = Batch::new(&thick, 1, 1).expect("a batch");
    let mut told = Told::of(&batch);
    reset(&mut batch, &[Some(1)], &mut told);
    for step in 1..=3 {
        batch.step(&[1.0, 2.6, 0.0, -1.0, 2.6, 0.0], told.seen()).expect("steps");
        if told.terminated[0] {
            assert_eq!((told.info[6], told.truncated[0]), (1.0, false), "step {step}");
            return;
        }
    }
    panic!("never stopped: {told:?}");
}

#[test]
fn modules_that_do_not_join_are_told_of() {
    let mut batch =
        Batch::new(&settings(&format!("{}[radio]\nloss = 1.0\n", shape("2x1"))), 1, 1).expect("a batch");
    let mut told = Told::of(&batch);
    let error = batch.reset(&[Some(1)], &[true], &mut told.observations, &mut told.info).expect_err("deaf");
    assert_eq!(error.to_string(), "the modules were not ready within 10 s");
}

#[test]
fn what_cannot_be_is_refused_by_its_key() {
    let text = shape("3x1");
    for (settings, expected) in [
        (Settings { duration_s: f64::NAN, ..cycles(&text) }, "duration_s = NaN s"),
        (Settings { task: Task::Legs, ..cycles(&text) }, "leg = 0 legs"),
    ] {
        let error = Batch::new(&settings, 1, 1).err().expect(expected).to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let mut batch = Batch::new(&cycles(&format!("{text}[tank]\ngust_m_s = 0.01\n")), 1, 1).expect("a batch");
    let mut told = Told::of(&batch);
    let error = batch.reset(&[Some(1)], &[true], &mut told.observations, &mut told.info).expect_err("gusts");
    assert!(error.to_string().starts_with("gust_m_s = 0.01 m/s"), "{error}");
    let mut batch = Batch::new(&cycles(&text), 2, 1).expect("a batch");
    let mut told = Told::of(&batch);
    reset(&mut batch, &[Some(1), Some(2)], &mut told);
    let mut actions = random_action(&[-1.0; 18], &[1.0; 18], &mut generator(1));
    actions[11] = f64::NAN;
    let error = batch.step(&actions, told.seen()).expect_err("NaN").to_string();
    assert_eq!(error, "action 2 of environment 1 = NaN: must be a finite number");
    let error = batch.step(&actions[1..], told.seen()).expect_err("17 numbers").to_string();
    assert_eq!(error, "actions: 17 numbers for 18");
}
