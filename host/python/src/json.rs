//! What the program prints as JSON, as Python's dictionaries, and back: the same keys and numbers.

use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{bad, could};

/// An object with the keys and numbers that the program prints. Python's reader gives back each number to its last digit.
pub fn dict<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyDict>> {
    let text = serde_json::to_string(value).map_err(could)?;
    let read = py.import(intern!(py, "json"))?.call_method1(intern!(py, "loads"), (text,))?;
    Ok(read.cast_into::<PyDict>()?)
}

/// What a dictionary says.
pub fn read<T: DeserializeOwned>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<T> {
    let py = value.py();
    let text = py.import(intern!(py, "json"))?.call_method1(intern!(py, "dumps"), (value,))?;
    serde_json::from_str(text.extract::<&str>()?).map_err(|error| bad(format!("{name}: {error}")))
}
