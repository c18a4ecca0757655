//! The native part of the Python package `flotilla`: the same functions as the program's, with numpy in and out.
//!
//! | file | what |
//! |---|---|
//! | `named`, `json` | choices by name; what the program prints, as dictionaries |
//! | `error` | Rust's messages as Python's exceptions |
//! | `array` | numpy to and from what Rust computes with |
//! | `plan` | one plan, as Python sees it |
//! | `environment` | `EnvironmentBatch`, under `flotilla.environments` |
//! | `planner` | `plan`, `Planner` |

mod array;
mod environment;
mod error;
mod json;
mod named;
mod plan;
mod planner;

/// Everything that `flotilla/__init__.py` names.
#[pyo3::pymodule]
mod _flotilla {
    #[pymodule_export]
    use super::environment::EnvironmentBatch;
    #[pymodule_export]
    use super::plan::Plan;
    #[pymodule_export]
    use super::planner::plan;
}
