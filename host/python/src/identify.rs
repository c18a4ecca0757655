//! `identify`: `flotilla identify`.

use std::path::PathBuf;

use ::identify::data::Boat;
use ::identify::outcome::{Outcome, Scale};
use host::run::identified::tables;
use host::run::identify::logged_files;
use host::run::progress::Quiet;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::bad;
use crate::json;

/// Constants of the boat, with intervals.
#[pyclass(frozen, module = "flotilla")]
pub struct Identified {
    boat: Boat,
    outcome: Outcome,
}

/// Constants of the boat from logs of its runs.
#[pyfunction]
#[pyo3(signature = (logs, *, scale = "rotor"))]
pub fn identify(py: Python<'_>, logs: Vec<PathBuf>, scale: &str) -> PyResult<Identified> {
    let scale = match scale {
        "rotor" => Scale::Rotor,
        "thrust" => Scale::Thrust,
        other => return Err(bad(format!("scale: unknown variant `{other}`, expected `rotor` or `thrust`"))),
    };
    py.detach(|| {
        let (boat, recordings) = logged_files(&logs, |_| Quiet)?.boats()?;
        let outcome = ::identify::identify(&boat, &recordings, scale).map_err(|error| error.to_string())?;
        Ok(Identified { boat, outcome })
    })
    .map_err(|error: String| bad(error))
}

#[pymethods]
impl Identified {
    /// What `flotilla identify --json` prints.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        json::dict(py, &self.outcome)
    }

    /// The tables to paste into a scenario: `flotilla identify --toml`.
    fn to_toml(&self) -> String {
        tables(&self.boat, &self.outcome)
    }

    /// The value of a constant, and the ends of its 95 % interval.
    fn constant(&self, name: &str) -> PyResult<(f64, f64, f64)> {
        let constant = self.outcome.constant(name);
        let known = || self.outcome.constants.iter().map(|constant| constant.name.to_string());
        let constant = constant.ok_or_else(|| {
            bad(format!("{name}: no such constant (there are {})", known().collect::<Vec<_>>().join(", ")))
        })?;
        Ok((constant.value, constant.low, constant.high))
    }
}
