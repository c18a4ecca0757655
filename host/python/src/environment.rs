//! `EnvironmentBatch`: learning environments stepped in Rust's threads, the interpreter's lock released meanwhile.
//!
//! `flotilla.environments` makes the interfaces of Gymnasium and PettingZoo of it. Every array is new at each call: nothing that was
//! returned changes later.

use std::sync::{Mutex, PoisonError};

use environment::batch::{Batch, Seen};
use environment::layout::{INFO, Layout};
use environment::settings::{EnvironmentError, Settings};
use host::run::scenario::Scenario;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{self, Matrix};
use crate::error::{bad, could};
use crate::named::named;

/// What a step returns: observations, rewards, terminated, truncated, info.
type Stepped<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<f64>>,
);

/// Many environments; see the crate `environment`.
#[pyclass(frozen, module = "flotilla._flotilla")]
pub struct EnvironmentBatch {
    batch: Mutex<Batch>,
    layout: Layout,
    #[pyo3(get)]
    num_envs: usize,
    /// Centre of each module in S, m.
    positions_m: Vec<f64>,
}

#[pymethods]
impl EnvironmentBatch {
    #[new]
    #[pyo3(signature = (num_envs, *, scenario, fidelity, task, action, contact, duration_s, autoreset, threads = 0))]
    #[expect(clippy::too_many_arguments, reason = "what an environment is made of, by its names")]
    fn new(
        num_envs: usize,
        scenario: &str,
        fidelity: &str,
        task: &str,
        action: &str,
        contact: &str,
        duration_s: f64,
        autoreset: bool,
        threads: usize,
    ) -> PyResult<Self> {
        let settings = Settings {
            fidelity: named("fidelity", fidelity)?,
            task: named("task", task)?,
            action: named("action", action)?,
            contact: named("contact", contact)?,
            duration_s,
            autoreset,
            ..Settings::new(Scenario::open(scenario).map_err(bad)?)
        };
        let batch = Batch::new(&settings, num_envs, threads).map_err(raised)?;
        let layout = batch.layout().clone();
        let positions_m = layout.positions_m.as_flattened().to_vec();
        Ok(Self { batch: Mutex::new(batch), layout, num_envs, positions_m })
    }

    /// What the columns of `info` are.
    #[classattr]
    #[pyo3(name = "INFO")]
    fn info_names() -> Vec<&'static str> {
        INFO.to_vec()
    }

    #[getter]
    fn modules(&self) -> usize {
        self.layout.modules
    }

    #[getter]
    fn observation_size(&self) -> usize {
        self.layout.observation
    }

    #[getter]
    fn action_low<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array::vector(py, self.layout.action_low.clone())
    }

    #[getter]
    fn action_high<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array::vector(py, self.layout.action_high.clone())
    }

    #[getter]
    fn positions_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array::matrix(py, self.positions_m.clone(), 2)
    }

    /// Docked pairs along sway and along surge, as module numbers from 0.
    #[getter]
    fn neighbours(&self) -> [Vec<(usize, usize)>; 2] {
        self.layout.neighbours.clone()
    }

    /// Begins episodes: `seeds` one for each environment or `None`, `chosen` which of them; rows of the others are zero.
    #[pyo3(signature = (seeds, chosen = None))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        seeds: Vec<Option<u64>>,
        chosen: Option<Vec<bool>>,
    ) -> PyResult<(Matrix<'py>, Matrix<'py>)> {
        let (width, count) = (self.layout.observation, self.num_envs);
        let chosen = chosen.unwrap_or_else(|| vec![true; count]);
        let (mut observations, mut info) = (vec![0.0; count * width], vec![0.0; count * INFO.len()]);
        py.detach(|| self.lock().reset(&seeds, &chosen, &mut observations, &mut info)).map_err(raised)?;
        Ok((array::matrix(py, observations, width)?, array::matrix(py, info, INFO.len())?))
    }

    /// One step of each environment.
    fn step<'py>(&self, py: Python<'py>, actions: &Bound<'py, PyAny>) -> PyResult<Stepped<'py>> {
        let (width, count) = (self.layout.observation, self.num_envs);
        let (mut observations, mut info) = (vec![0.0; count * width], vec![0.0; count * INFO.len()]);
        let (mut rewards, mut terminated, mut truncated) =
            (vec![0.0; count], vec![false; count], vec![false; count]);
        let mut step = |actions: &[f64]| {
            py.detach(|| {
                self.lock().step(
                    actions,
                    Seen {
                        observations: &mut observations,
                        rewards: &mut rewards,
                        terminated: &mut terminated,
                        truncated: &mut truncated,
                        info: &mut info,
                    },
                )
            })
            .map_err(raised)
        };
        step(&array::table("actions", actions, count, self.layout.action())?)?;
        Ok((
            array::matrix(py, observations, width)?,
            array::vector(py, rewards),
            array::vector(py, terminated),
            array::vector(py, truncated),
            array::matrix(py, info, INFO.len())?,
        ))
    }

    /// What the baseline with this planner would do in each environment: shape (num_envs, action size).
    fn baseline<'py>(&self, py: Python<'py>, planner: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (kind, width) = (named("planner", planner)?, self.layout.action());
        let mut actions = vec![0.0; self.num_envs * width];
        py.detach(|| self.lock().advise(kind, &mut actions)).map_err(raised)?;
        array::matrix(py, actions, width)
    }
}

impl EnvironmentBatch {
    fn lock(&self) -> std::sync::MutexGuard<'_, Batch> {
        // A panic with it held has ended a thread, which the batch tells.
        self.batch.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn raised(error: EnvironmentError) -> PyErr {
    match error {
        EnvironmentError::Run(_) | EnvironmentError::NotReady { .. } | EnvironmentError::Stopped => {
            could(error)
        }
        _ => bad(error),
    }
}
