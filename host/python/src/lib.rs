//! The native part of the Python package `flotilla`: the same functions as the program's, with numpy in and out.
//!
//! | file | what |
//! |---|---|
//! | `named`, `json` | choices by name; what the program prints, as dictionaries |
//! | `error` | Rust's messages as Python's exceptions |
//! | `array` | numpy to and from what Rust computes with |
//! | `threads` | how many threads to work on |
//! | `plan`, `plans` | one plan, and many by column, as Python sees them |
//! | `planner` | `plan`, `Planner` |
//! | `envelope` | `envelope` |
//! | `transition` | `transition` |
//! | `run` | `run` |
//! | `simulation` | `Simulation`: tanks with Modboats |
//! | `rov` | `simulate`, `RovSimulation`, `vehicle` |
//! | `reconfigure` | `reconfigure` |
//! | `route` | `route`, `Map` |
//! | `log` | what `read_log` reads |
//! | `identify` | `identify` |
//! | `environment` | `EnvironmentBatch`, under `flotilla.environments` |

mod array;
mod envelope;
mod environment;
mod error;
mod identify;
mod json;
mod log;
mod named;
mod plan;
mod planner;
mod plans;
mod reconfigure;
mod route;
mod rov;
mod run;
mod simulation;
mod threads;
mod transition;

/// Everything that `flotilla/__init__.py` names.
#[pyo3::pymodule]
mod _flotilla {
    #[pymodule_export]
    use super::envelope::{Envelope, envelope};
    #[pymodule_export]
    use super::environment::EnvironmentBatch;
    #[pymodule_export]
    use super::identify::{Identified, identify};
    #[pymodule_export]
    use super::log::read_log;
    #[pymodule_export]
    use super::plan::Plan;
    #[pymodule_export]
    use super::planner::{Planner, plan};
    #[pymodule_export]
    use super::plans::Plans;
    #[pymodule_export]
    use super::reconfigure::{Reconfiguration, reconfigure};
    #[pymodule_export]
    use super::route::{Map, Route, route};
    #[pymodule_export]
    use super::rov::{RovSimulation, simulate, vehicle};
    #[pymodule_export]
    use super::run::{Run, run};
    #[pymodule_export]
    use super::simulation::Simulation;
    #[pymodule_export]
    use super::transition::{Transition, transition};
}
