//! `transition`: which way round each tail turns into a given cycle.

use host::answer::transition::least;
use modboat::motion::{StepTime, Swing, Turn};
use modboat::transition::Transition as Found;
use pyo3::prelude::*;

use crate::array::{self, Vector};
use crate::error::bad;
use crate::planner::settings;

/// A transition of least travel, in one step.
#[pyclass(frozen, module = "flotilla")]
pub struct Transition {
    found: Found,
    time: StepTime,
}

/// The transition of least travel from tails at `from_rad` into the cycle, or `None` where it is proved that there is none.
#[pyfunction]
#[pyo3(signature = (cells, from_rad, centerline_rad, amplitude_rad, *, scenario = None, planner = None))]
pub fn transition(
    cells: &Bound<'_, PyAny>,
    from_rad: &Bound<'_, PyAny>,
    centerline_rad: &Bound<'_, PyAny>,
    amplitude_rad: &Bound<'_, PyAny>,
    scenario: Option<&str>,
    planner: Option<&str>,
) -> PyResult<Option<Transition>> {
    let py = cells.py();
    let cells = array::cells(cells)?;
    let from_rad = array::list("from_rad", from_rad)?;
    let centerlines = array::list("centerline_rad", centerline_rad)?;
    let amplitudes = array::list("amplitude_rad", amplitude_rad)?;
    if centerlines.len() != amplitudes.len() {
        let (one, other) = (centerlines.len(), amplitudes.len());
        return Err(bad(format!("centerline_rad has {one} numbers, amplitude_rad {other}")));
    }
    let swing = |(centerline_rad, amplitude_rad)| Swing { centerline_rad, amplitude_rad };
    let cycle: Vec<Swing> = centerlines.into_iter().zip(amplitudes).map(swing).collect();
    let (parameters, config) = settings(scenario, planner, None)?;
    let found = py.detach(|| least(&cells, &from_rad, &cycle, &parameters, &config)).map_err(bad)?;
    Ok(found.map(|(found, time)| Transition { found, time }))
}

impl Transition {
    fn turns<'py>(&self, py: Python<'py>, of: fn(&Turn) -> f64) -> Vector<'py> {
        array::vector(py, self.found.turns.iter().map(of).collect())
    }
}

#[pymethods]
impl Transition {
    #[getter(from_rad)]
    fn turned_from_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.turns(py, |turn| turn.from_rad)
    }

    #[getter(to_rad)]
    fn turned_to_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.turns(py, |turn| turn.to_rad)
    }

    #[getter]
    fn negated(&self) -> bool {
        self.found.negated
    }

    #[getter]
    fn travel_rad(&self) -> f64 {
        self.found.travel_rad
    }

    #[getter]
    fn exact(&self) -> bool {
        self.found.exact
    }

    #[getter]
    fn duration_s(&self) -> f64 {
        self.time.duration_s
    }

    #[getter]
    fn ramp_s(&self) -> f64 {
        self.time.ramp_s
    }
}
