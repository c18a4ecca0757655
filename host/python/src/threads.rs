//! How many threads to work on.

use std::thread::available_parallelism;

use pyo3::PyResult;

use crate::error::bad;

/// No more are taken.
const THREADS_MAX: usize = 1024;

/// As many as was said; 0: as many as there are cores.
pub fn threads(count: usize) -> PyResult<usize> {
    match count {
        0 => Ok(available_parallelism().map_or(1, usize::from)),
        count if count > THREADS_MAX => Err(bad(format!("threads = {count}: must be at most {THREADS_MAX}"))),
        count => Ok(count),
    }
}
