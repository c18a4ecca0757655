//! What an environment is made of, and why one cannot be.

use host::run::RunError;
use host::run::scenario::Scenario;
use quantity::{ParameterError, check_within};
use serde::Deserialize;
use thiserror::Error;

/// How much of a module is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fidelity {
    /// The firmware crate on a simulated motor, tails in the tank, milliseconds; datagrams between host and modules.
    #[default]
    Module,
    /// The mean wrench (7) of each cycle on the floating structure: what the planner believes.
    Cycle,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// A velocity in the world and a heading, drawn at each reset.
    #[default]
    Velocity,
    /// A place in the world to go to and to keep, and a heading, drawn at each reset.
    Station,
    /// The start and the legs of the scenario.
    Legs,
}

/// What an action says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ActionKind {
    /// Centreline, amplitude and way of turning of every module.
    #[default]
    Swing,
    /// A wrench, for which the exact planner finds the cycles.
    Wrench,
}

/// What follows when two tails touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactRule {
    /// It costs reward; the structure stays in one piece.
    #[default]
    Penalty,
    /// The episode is over too: tails that touch push modules off their docks.
    Terminate,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Structure, modules, water, motors, clocks and radio; its legs and its start only with [`Task::Legs`].
    pub scenario: Scenario,
    /// How much of a module is simulated.
    pub fidelity: Fidelity,
    /// What is asked for.
    pub task: Task,
    /// What an action says.
    pub action: ActionKind,
    /// What follows when two tails touch.
    pub contact: ContactRule,
    /// Length of an episode, s.
    pub duration_s: f64,
    /// Whether the step after the last one of an episode begins the next.
    pub autoreset: bool,
}

impl Settings {
    /// All defaults, with episodes of 90 s, the length of the paper's experiments.
    #[must_use]
    pub fn new(scenario: Scenario) -> Self {
        Self {
            scenario,
            fidelity: Fidelity::default(),
            task: Task::default(),
            action: ActionKind::default(),
            contact: ContactRule::default(),
            duration_s: 90.0,
            autoreset: false,
        }
    }

    /// Refuses what no environment can have, by the first offending key.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn validate(&self) -> Result<(), ParameterError> {
        let reason = "must be from 1 to 100000";
        check_within(&[("duration_s", self.duration_s, "s", 1.0..=1e5, reason)])?;
        if self.task == Task::Legs && self.scenario.legs.is_empty() {
            let reason = "must be at least 1 where the legs of the scenario are the task";
            return Err(ParameterError { key: "leg", value: 0.0, unit: "legs", reason });
        }
        Ok(())
    }
}

/// Why an environment is not there, or does not go on.
#[derive(Debug, Error)]
pub enum EnvironmentError {
    /// A number that cannot be.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The simulation failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Something of another length than the batch.
    #[error("{what}: {given} numbers for {wanted}")]
    Length {
        /// What it is.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there should be.
        wanted: usize,
    },
    /// An action that is no number.
    #[error("action {index} of environment {environment} = {value}: must be a finite number")]
    Action {
        /// Of which environment.
        environment: usize,
        /// Which of its numbers.
        index: usize,
        /// What it is.
        value: f64,
    },
    /// A step after the end of an episode, or before the first.
    #[error("environment {environment}: no episode is under way; reset it first")]
    Over {
        /// Which one.
        environment: usize,
    },
    /// The modules did not join.
    #[error("the modules were not ready within {waited_s} s")]
    NotReady {
        /// How long they were waited for, s.
        waited_s: f64,
    },
    /// A worker is gone.
    #[error("a thread of the batch has stopped")]
    Stopped,
}
