//! `envelope`: `flotilla plan --envelope`.

use host::answer::envelope::{self as answer, Reply};
use host::answer::plan::check_demand;
use modboat::envelope::Envelope as Shape;
use modboat::motion::Wrench;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{self, Matrix, Vector};
use crate::error::bad;
use crate::json;
use crate::planner::settings;

/// The wrenches that a structure could give if no tail were in another's way.
#[pyclass(frozen, module = "flotilla")]
pub struct Envelope(Shape);

/// The envelope of modules in these cells.
#[pyfunction]
#[pyo3(signature = (cells, *, scenario = None))]
pub fn envelope(cells: &Bound<'_, PyAny>, scenario: Option<&str>) -> PyResult<Envelope> {
    let (parameters, _) = settings(scenario, None, None)?;
    answer::envelope(&array::cells(cells)?, &parameters).map(Envelope).map_err(bad)
}

fn demands(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let demands = array::rows::<3>("demands", value)?;
    for (index, &demand) in demands.iter().enumerate() {
        check_demand(Wrench::from_array(demand))
            .map_err(|error| bad(format!("demands[{index}]: {error}")))?;
    }
    Ok(demands)
}

impl Envelope {
    /// What is said of each demand.
    fn each<T: Send>(&self, value: &Bound<'_, PyAny>, of: fn(&Reply) -> T) -> PyResult<Vec<T>> {
        let demands = demands(value)?;
        let reply = |&demand: &[f64; 3]| of(&Reply::new(&self.0, Wrench::from_array(demand)));
        Ok(value.py().detach(|| demands.iter().map(reply).collect()))
    }
}

#[pymethods]
impl Envelope {
    #[getter]
    fn extremes<'py>(&self, py: Python<'py>) -> Vector<'py> {
        array::vector(py, answer::extremes(&self.0).to_array().to_vec())
    }

    fn gauge<'py>(&self, demands: &Bound<'py, PyAny>) -> PyResult<Vector<'py>> {
        let gauges = self.each(demands, |reply| reply.gauge.unwrap_or(f64::INFINITY))?;
        Ok(array::vector(demands.py(), gauges))
    }

    fn inside<'py>(&self, demands: &Bound<'py, PyAny>) -> PyResult<Vector<'py, bool>> {
        let inside = self.each(demands, |reply| reply.inside)?;
        Ok(array::vector(demands.py(), inside))
    }

    fn boundary<'py>(&self, demands: &Bound<'py, PyAny>) -> PyResult<Matrix<'py>> {
        let farthest = self.each(demands, |reply| reply.boundary.map_or([f64::NAN; 3], Wrench::to_array))?;
        array::matrix(demands.py(), farthest.concat(), 3)
    }

    /// What `flotilla plan --envelope` prints for this demand.
    fn locate<'py>(&self, demand: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let asked = Wrench::from_array(array::point("demand", demand)?);
        check_demand(asked).map_err(bad)?;
        json::dict(demand.py(), &Reply::new(&self.0, asked))
    }
}
