//! One run, executed, as a row.
//!
//! A row has `run`, the number of the run, then what was asked: `scenario`, `modules`, `controller`, `planner`, `seed` and the keys that
//! are varied; then `error`, why there was no run at all, if so; then every figure of `summary.json`.

use host::run::experiment::simulate;
use host::run::scenario::Scenario;
use serde_json::{Map, Value};

use crate::cell::flatten;
use crate::study::{Run, Study};
use crate::work::{Work, caught};

/// The columns that come first, where they are there; those of the keys that are varied follow.
pub const HEAD: [&str; 7] = ["run", "scenario", "modules", "controller", "planner", "seed", "error"];
/// Figures of time on this machine.
const TIMES: [&str; 3] = ["wall_s", "cycles.solve_us_median", "cycles.solve_us_max"];

impl Work for Study {
    fn name(&self) -> &str {
        &self.name
    }

    fn runs(&self) -> usize {
        self.runs()
    }

    fn told(&self) -> String {
        self.told()
    }

    fn fingerprint(&self) -> String {
        self.fingerprint()
    }

    fn grid(&self) -> Vec<String> {
        self.on_grid().map(str::to_owned).collect()
    }

    fn sampled(&self) -> Vec<String> {
        self.sampled.clone()
    }

    fn row(&self, number: usize) -> Map<String, Value> {
        row(&self.run(number), self.times)
    }
}

/// The row of `run`; without what was measured of time on this machine unless `times`. A run that cannot be begun, or panics, has a row
/// too, that says why.
fn row(run: &Run<'_>, times: bool) -> Map<String, Value> {
    let mut row = Map::new();
    if let Some(controller) = run.controller {
        row.insert("controller".to_owned(), controller.into());
    }
    for (key, value) in &run.varied {
        flatten(&mut row, key, json(value));
    }
    let error = match run.scenario() {
        Ok((scenario, seed)) => {
            row.insert("scenario".to_owned(), scenario.name.clone().into());
            row.insert("modules".to_owned(), scenario.structure.len().into());
            row.insert("planner".to_owned(), scenario.planner.kind.name().into());
            row.insert("seed".to_owned(), seed.into());
            summary(&mut row, &scenario, seed).err()
        }
        Err(message) => Some(message),
    };
    row.insert("error".to_owned(), error.map_or(Value::Null, Value::String));
    if !times {
        TIMES.iter().for_each(|key| drop(row.remove(*key)));
    }
    row
}

fn summary(row: &mut Map<String, Value>, scenario: &Scenario, seed: u64) -> Result<(), String> {
    let result = caught(|| simulate(scenario, seed));
    let result = result.map_err(|panic| format!("a defect of this program: {panic}"))?;
    let result = result.map_err(|error| error.to_string())?;
    let summary = serde_json::to_value(&result.summary).map_err(|error| error.to_string())?;
    flatten(row, "", summary);
    Ok(())
}

/// A value of TOML in JSON.
fn json(value: &toml::Value) -> Value {
    match value {
        toml::Value::Integer(number) => (*number).into(),
        toml::Value::Float(number) => (*number).into(),
        toml::Value::Boolean(value) => (*value).into(),
        toml::Value::String(text) => text.as_str().into(),
        toml::Value::Array(items) => items.iter().map(json).collect(),
        other => other.to_string().into(),
    }
}
