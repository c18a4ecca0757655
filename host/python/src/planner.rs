//! `plan` and `Planner`.

use host::answer::plan::{Stream, Tails};
use host::run::progress::Quiet;
use host::run::scenario::Scenario;
use modboat::motion::Wrench;
use modboat::parameters::Parameters;
use modboat::planner_config::PlannerConfig;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::array;
use crate::error::bad;
use crate::named::named;
use crate::plan::Plan;

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
pub fn tails(value: Option<&Bound<'_, PyAny>>) -> PyResult<Tails> {
    let Some(value) = value else { return Ok(Tails::Unknown) };
    match value.cast::<PyString>() {
        Ok(word) if word == "previous" => Ok(Tails::Previous),
        Ok(_) => Err(bad("tail_rad must be a list of angles, None or \"previous\"")),
        Err(_) => Ok(Tails::Angles(array::list("tail_rad", value)?)),
    }
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
    let (cells, demand) = (array::cells(cells)?, Wrench::from_array(array::point("demand", demand)?));
    let tails = tails(tail_rad)?;
    let (parameters, config) = settings(scenario, planner, loss_tolerant)?;
    py.detach(|| {
        let mut stream = Stream::new(parameters, config, &mut Quiet);
        let name = stream.planner();
        let (plan, took) = stream.plan(&cells, demand, tails)?;
        Ok(Plan::new(plan.clone(), name, took))
    })
    .map_err(|error: String| bad(error))
}
