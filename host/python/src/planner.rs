//! `plan` and `Planner`: `flotilla plan`.

use std::sync::{Mutex, MutexGuard, PoisonError};

use host::answer::batch::{Plans as Columns, batch};
use host::answer::plan::{Stream, Tails, check_demand, check_tails};
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::planner::Planner as Engine;
use modboat::planner_config::PlannerConfig;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::array::{self, Matrix};
use crate::error::bad;
use crate::named::named;
use crate::plan::Plan;
use crate::plans::Plans;
use crate::threads::threads;

/// Which modules and which planner: what the options of `flotilla plan` say.
pub fn settings(
    scenario: Option<&str>,
    planner: Option<&str>,
    loss_tolerant: Option<&str>,
) -> PyResult<(Parameters, PlannerConfig)> {
    let (parameters, mut config) = match scenario {
        Some(name) => {
            let scenario = Scenario::open(name).map_err(bad)?;
            (scenario.modboat, scenario.planner)
        }
        None => (Parameters::default(), PlannerConfig::default()),
    };
    if let Some(kind) = planner {
        config.kind = named("planner", kind)?;
    }
    if let Some(how) = loss_tolerant {
        config.loss_tolerant = named("loss_tolerant", how)?;
    }
    Ok((parameters, config))
}

/// Angles, `None` or `"previous"`.
fn tails(value: Option<&Bound<'_, PyAny>>) -> PyResult<Tails> {
    let Some(value) = value else { return Ok(Tails::Unknown) };
    match value.cast::<PyString>() {
        Ok(word) if word == "previous" => Ok(Tails::Previous),
        Ok(_) => Err(bad("tail_rad must be a list of angles, None or \"previous\"")),
        Err(_) => Ok(Tails::Angles(array::list("tail_rad", value)?)),
    }
}

fn one(stream: &mut Stream, cells: &[[i32; 2]], demand: [f64; 3], tails: Tails) -> Result<Plan, String> {
    let name = stream.planner();
    let (plan, took) = stream.plan(cells, Wrench::from_array(demand), tails)?;
    Ok(Plan::new(plan.clone(), name, took))
}

/// One plan, by a planner of its own: `flotilla plan` with one request.
#[pyfunction]
#[pyo3(signature = (cells, demand, tail_rad = None, *, scenario = None, planner = None, loss_tolerant = None))]
pub fn plan(
    cells: &Bound<'_, PyAny>,
    demand: &Bound<'_, PyAny>,
    tail_rad: Option<&Bound<'_, PyAny>>,
    scenario: Option<&str>,
    planner: Option<&str>,
    loss_tolerant: Option<&str>,
) -> PyResult<Plan> {
    let py = cells.py();
    let (cells, demand, tails) = (array::cells(cells)?, array::point("demand", demand)?, tails(tail_rad)?);
    let (parameters, config) = settings(scenario, planner, loss_tolerant)?;
    py.detach(|| one(&mut Stream::new(parameters, config, &mut Quiet), &cells, demand, tails)).map_err(bad)
}

/// A planner of one structure, which remembers its last plan.
#[pyclass(frozen, module = "flotilla")]
pub struct Planner {
    cells: Vec<[i32; 2]>,
    /// As it was made, for plans that know of no others.
    engine: Engine,
    name: &'static str,
    stream: Mutex<Stream>,
}

impl Planner {
    fn stream(&self) -> MutexGuard<'_, Stream> {
        self.stream.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Planner {
    #[new]
    #[pyo3(signature = (cells, *, scenario = None, planner = None, loss_tolerant = None))]
    fn new(
        cells: &Bound<'_, PyAny>,
        scenario: Option<&str>,
        planner: Option<&str>,
        loss_tolerant: Option<&str>,
    ) -> PyResult<Self> {
        let py = cells.py();
        let cells = array::cells(cells)?;
        let (parameters, config) = settings(scenario, planner, loss_tolerant)?;
        py.detach(|| {
            let mut stream = Stream::new(parameters, config, &mut Quiet);
            let engine = stream.prepare(&cells)?.clone();
            Ok(Self { name: stream.planner(), engine, cells, stream: Mutex::new(stream) })
        })
        .map_err(|error: String| bad(error))
    }

    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py, i32>> {
        array::matrix(py, self.cells.concat(), 2)
    }

    #[getter]
    fn planner(&self) -> &'static str {
        self.name
    }

    /// The next plan of this planner's stream.
    #[pyo3(signature = (demand, tail_rad = None))]
    fn plan(&self, demand: &Bound<'_, PyAny>, tail_rad: Option<&Bound<'_, PyAny>>) -> PyResult<Plan> {
        let (demand_of, tails) = (array::point("demand", demand)?, tails(tail_rad)?);
        demand.py().detach(|| one(&mut self.stream(), &self.cells, demand_of, tails)).map_err(bad)
    }

    /// A plan after the other, each from where the tails are when the one before is over.
    #[pyo3(signature = (demands, tail_rad = None))]
    fn sequence(&self, demands: &Bound<'_, PyAny>, tail_rad: Option<&Bound<'_, PyAny>>) -> PyResult<Plans> {
        let (rows, mut tails) = (array::rows::<3>("demands", demands)?, tails(tail_rad)?);
        demands
            .py()
            .detach(|| {
                let (mut stream, mut columns) =
                    (self.stream(), Columns::with_room(self.cells.len(), rows.len()));
                for (index, &demand) in rows.iter().enumerate() {
                    let tails = std::mem::replace(&mut tails, Tails::Previous);
                    let (plan, _) = stream
                        .plan(&self.cells, Wrench::from_array(demand), tails)
                        .map_err(|error| format!("demands[{index}]: {error}"))?;
                    columns.push(plan);
                }
                Ok(Plans(columns))
            })
            .map_err(|error: String| bad(error))
    }

    /// A plan for each demand by itself, as the first plan of a planner that was just made.
    #[pyo3(signature = (demands, tail_rad = None, *, threads = 1))]
    fn batch(
        &self,
        demands: &Bound<'_, PyAny>,
        tail_rad: Option<&Bound<'_, PyAny>>,
        threads: usize,
    ) -> PyResult<Plans> {
        let (rows, modules) = (array::rows::<3>("demands", demands)?, self.cells.len());
        let tails = match tail_rad {
            Some(angles) => array::table("tail_rad", angles, rows.len(), modules)?,
            None => Vec::new(),
        };
        let threads = self::threads(threads)?;
        demands
            .py()
            .detach(|| {
                for (index, &demand) in rows.iter().enumerate() {
                    check_demand(Wrench::from_array(demand))
                        .map_err(|error| format!("demands[{index}]: {error}"))?;
                }
                for (index, angles) in tails.chunks(modules).enumerate() {
                    check_tails(angles, modules).map_err(|error| format!("tail_rad[{index}]: {error}"))?;
                }
                Ok(Plans(batch(&self.engine, modules, &rows, &tails, threads)))
            })
            .map_err(|error: String| bad(error))
    }
}
