//! Runs of the checker: explores all states of a configuration and prints how many.

use std::collections::BTreeSet;
use std::io::Write;
use std::time::Instant;

use stateright::{Checker, HasDiscoveries, Model};

use crate::fleet::{Action, Config};
use crate::properties::{HOLD, RECOVERS};

/// Result of an exploration.
#[derive(Clone, Debug)]
pub struct Exploration {
    /// Different states.
    pub states: usize,
    /// The property that is broken, if one of those looked for is, and what led there.
    pub broken: Option<(&'static str, Vec<Action>)>,
}

/// Explores all states, and stops at the first that breaks one of the properties `wanted`.
#[must_use]
pub fn explore(name: &str, config: Config, wanted: &[&'static str], threads: usize) -> Exploration {
    let began = Instant::now();
    let wanted: BTreeSet<&'static str> = wanted.iter().copied().collect();
    let checker = config
        .checker()
        .threads(threads)
        .finish_when(HasDiscoveries::AnyOf(wanted.clone()))
        .spawn_bfs()
        .join();
    let (states, steps, depth) = (checker.unique_state_count(), checker.state_count(), checker.max_depth());
    let found = checker.discoveries().into_iter().filter(|(property, _)| wanted.contains(property));
    let broken =
        found.map(|(property, path)| (property, path.into_actions())).min_by_key(|(_, path)| path.len());
    let outcome = broken.as_ref().map_or_else(
        || "all keep to it".to_owned(),
        |(property, path)| format!("broken after {} steps: {property}", path.len()),
    );
    let seconds = began.elapsed().as_secs_f64();
    print(&format!("{name}: {states} states, {steps} steps, depth {depth}, {seconds:.1} s; {outcome}"));
    Exploration { states, broken }
}

/// Explores all states; how many there are.
///
/// # Panics
/// If a property of [`HOLD`] is broken: with the trace.
pub fn holds(name: &str, config: Config) -> usize {
    let wanted: Vec<&str> = HOLD.iter().copied().chain((config.recovery > 0).then_some(RECOVERS)).collect();
    keeps(name, config, &wanted)
}

/// Explores all states; how many there are, all of which have the properties `wanted`.
///
/// # Panics
/// If one is broken: with the trace.
pub fn keeps(name: &str, config: Config, wanted: &[&'static str]) -> usize {
    let found = explore(name, config, wanted, 2);
    if let Some((property, path)) = &found.broken {
        panic!("{name}: {property}\n{}", trace(path));
    }
    found.states
}

/// Looks for a state that breaks one of the properties `wanted`, prints the shortest way there and returns how long it is.
///
/// # Panics
/// If there is none.
pub fn breaks(name: &str, config: Config, wanted: &[&'static str]) -> usize {
    let Some((_, path)) = explore(name, config, wanted, 1).broken else { panic!("{name}: nothing breaks") };
    print(trace(&path).trim_end());
    path.len()
}

/// Past the capture of test output: what was explored is to be seen.
fn print(text: &str) {
    // A closed standard error is no failure.
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// The actions, one a line.
fn trace(path: &[Action]) -> String {
    path.iter().enumerate().map(|(k, action)| format!("  {:2} {action:?}\n", k + 1)).collect()
}
