//! Rust's messages as Python's exceptions.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::{PyRuntimeError, PyValueError};

/// What is the caller's to mend: `ValueError`.
pub fn bad(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// What could not be done: `RuntimeError`.
pub fn could(error: impl Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}
