//! `reconfigure`: `flotilla reconfigure`.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use host::answer::reconfigure::{NotMade, ParallelKind, PowerKind, Together, planned, usual_order};
use host::run::progress::Quiet;
use host::run::reconfigure::execution::{Executed, Options, execute};
use host::run::reconfigure::scenario::ReconfigureScenario;
use link::faults::FaultParameters;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use reconfiguration::plan::{Criterion, Manner};
use rov::order::{Known, Progress};
use rov::planner::{OrderRule, Planned, Request};

use crate::error::{bad, could};
use crate::json;
use crate::named::named;

/// A plan, and what its execution came to where it was executed.
#[pyclass(frozen, module = "flotilla")]
pub struct Reconfiguration {
    planned: Planned,
    executed: Option<Executed>,
}

/// Ends a search when its time is up.
struct Until(Instant);

impl Progress for Until {
    fn report(&mut self, _: &Known) -> ControlFlow<()> {
        if Instant::now() >= self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Plans how ROVs change their configuration, and executes that in simulation if it is asked for.
#[pyfunction]
#[pyo3(signature = (
    scenario, *, criterion = "energy", manner = "best", order = None, power = "table", time_limit_s = 60.0,
    parallel = None, weight = None, execute = false, seed = None, loss = 0.0
))]
#[expect(clippy::too_many_arguments, reason = "the options of the command, by name")]
pub fn reconfigure(
    py: Python<'_>,
    scenario: &str,
    criterion: &str,
    manner: &str,
    order: Option<&str>,
    power: &str,
    time_limit_s: f64,
    parallel: Option<&str>,
    weight: Option<f64>,
    execute: bool,
    seed: Option<u64>,
    loss: f64,
) -> PyResult<Reconfiguration> {
    let opened = ReconfigureScenario::open(scenario).map_err(bad)?;
    let criterion: Criterion = named("criterion", criterion)?;
    let manner: Manner = named("manner", manner)?;
    let order = match order {
        None => usual_order(manner),
        Some("exact") => OrderRule::Exact,
        Some("paper") => OrderRule::Paper,
        Some(other) => {
            return Err(bad(format!("order: unknown variant `{other}`, expected `exact` or `paper`")));
        }
    };
    let power: PowerKind = named("power", power)?;
    let parallel: Option<ParallelKind> = parallel.map(|kind| named("parallel", kind)).transpose()?;
    let together = Together { parallel, weight };
    together.check(manner).map_err(bad)?;
    if !(0.1..=86_400.0).contains(&time_limit_s) {
        return Err(bad(format!("time_limit_s = {time_limit_s} s: must lie between 0.1 and 86400")));
    }
    let radio = FaultParameters { loss, ..FaultParameters::default() };
    radio.validate().map_err(|error| bad(format!("loss: {error}")))?;
    let law = power.law(opened.problem.rules.battery_v).map_err(bad)?;
    let request = Request { criterion, manner, order, law };
    let seed = seed.unwrap_or(opened.seed);
    py.detach(|| {
        let mut until = Until(Instant::now() + Duration::from_secs_f64(time_limit_s));
        let planned = planned(&opened.problem, &request, &together, &mut until).map_err(|why| match why {
            NotMade::Unfit(why) => bad(format!("{scenario}: {why}")),
            why => could(why),
        })?;
        let options = Options { seed, radio, law: request.law };
        let executed = execute
            .then(|| self::execute(&opened.problem, &planned.plan, &options, &mut Quiet))
            .transpose()
            .map_err(could)?;
        Ok(Reconfiguration { planned, executed })
    })
}

#[pymethods]
impl Reconfiguration {
    /// What `flotilla reconfigure --json` prints.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        json::dict(py, &self.planned.plan)
    }

    #[getter]
    fn energy_navigate_j(&self) -> f64 {
        self.planned.plan.energy_navigate_j
    }

    #[getter]
    fn energy_balance_j(&self) -> f64 {
        self.planned.plan.energy_balance_j
    }

    #[getter]
    fn energy_total_j(&self) -> f64 {
        self.planned.plan.energy_total_j
    }

    #[getter]
    fn time_s(&self) -> f64 {
        self.planned.plan.time_s
    }

    /// No order and assignment costs less, J or m.
    #[getter]
    fn bound(&self) -> f64 {
        self.planned.bound
    }

    /// What this plan costs by its criterion, J or m.
    #[getter]
    fn cost(&self) -> f64 {
        self.planned.cost
    }

    /// The figures of its execution, as in `summary.json`.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.executed.as_ref().map(|executed| json::dict(py, &executed.summary)).transpose()
    }
}
