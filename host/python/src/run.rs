//! `run`: a run of Modboats in simulation, as `flotilla run` makes it.

use std::path::PathBuf;

use host::run::closed_loop::Drive;
use host::run::experiment::{Pace, RunResult, run_into};
use host::run::fleet::InProcess;
use host::run::log::Log;
use host::run::orders::Unattended;
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use record::{CycleRecord, PoseSample};

use crate::array::{Matrix, Vector, matrix, vector};
use crate::error::{bad, could};
use crate::json;
use crate::named::named;

/// What a run leaves behind.
#[pyclass(frozen, module = "flotilla")]
pub struct Run(RunResult);

/// Runs a scenario of Modboats in simulation, as fast as the machine can; writes its log where a path is given.
#[pyfunction]
#[pyo3(signature = (scenario = "holonomic-1", *, seed = None, planner = None, log = None))]
pub fn run(
    py: Python<'_>,
    scenario: &str,
    seed: Option<u64>,
    planner: Option<&str>,
    log: Option<PathBuf>,
) -> PyResult<Run> {
    let mut scenario = Scenario::open(scenario).map_err(bad)?;
    if let Some(kind) = planner {
        scenario.planner.kind = named("planner", kind)?;
    }
    let seed = seed.unwrap_or(scenario.seed);
    py.detach(|| {
        let log = log.map_or_else(|| Ok(Log::default()), |path| Log::create(&path))?;
        let mut fleet = InProcess::boats(&scenario, seed).map_err(|error| error.to_string())?;
        let drive = Drive { pace: Pace::Simulated, operator: &mut Unattended, hook: &mut |_, _, _| {} };
        let result = run_into(log, &scenario, seed, &mut fleet, drive, &mut Quiet);
        let result = result.map_err(|error| error.to_string())?;
        match &result.log_failure {
            Some(failure) => Err(failure.clone()),
            None => Ok(Run(result)),
        }
    })
    .map_err(|error: String| could(error))
}

impl Run {
    fn poses(&self, of: fn(&PoseSample) -> f64) -> Vec<f64> {
        self.0.record.poses.iter().map(of).collect()
    }

    fn cycles<T>(&self, of: fn(&CycleRecord) -> T) -> Vec<T> {
        self.0.record.cycles.iter().map(of).collect()
    }
}

#[pymethods]
impl Run {
    /// The figures, as `summary.json` has them.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        json::dict(py, &self.0.summary)
    }

    /// What was asked and not done, a line each; empty if the run did what it was to do.
    #[getter]
    fn complaints(&self) -> Vec<String> {
        self.0.summary.complaints()
    }

    #[getter]
    fn t_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.poses(|pose| pose.t_s))
    }

    #[getter]
    fn position_m<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.record.poses.iter().flat_map(|pose| pose.position_m).collect(), 2)
    }

    #[getter]
    fn heading_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.poses(|pose| pose.heading_rad))
    }

    #[getter]
    fn velocity_m_s<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.record.poses.iter().flat_map(|pose| pose.velocity_m_s).collect(), 2)
    }

    #[getter]
    fn yaw_rate_rad_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.poses(|pose| pose.yaw_rate_rad_s))
    }

    #[getter]
    fn tail_t_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.0.record.tails.iter().map(|tails| tails.t_s).collect())
    }

    #[getter]
    fn tail_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let angles = self.0.record.tails.iter().flat_map(|tails| tails.actual_rad.iter().copied());
        matrix(py, angles.collect(), self.0.record.cells.len())
    }

    #[getter]
    fn cycle_start_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.cycles(|cycle| cycle.start_s))
    }

    #[getter]
    fn demanded<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.cycles(|cycle| cycle.demand.to_array()).concat(), 3)
    }

    #[getter]
    fn commanded<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.cycles(|cycle| cycle.commanded.to_array()).concat(), 3)
    }
}
