//! Many plans by column, as Python sees them. Each column is copied when it is asked for.

use host::answer::batch::Plans as Columns;
use pyo3::prelude::*;

use crate::array::{Matrix, Vector, matrix, vector};

/// Many plans: row i of every column is of demand i.
#[pyclass(frozen, module = "flotilla")]
pub struct Plans(pub Columns);

#[pymethods]
impl Plans {
    fn __len__(&self) -> usize {
        self.0.outcome.len()
    }

    #[getter]
    fn outcome<'py>(&self, py: Python<'py>) -> Vector<'py, u8> {
        vector(py, self.0.outcome.clone())
    }

    #[getter]
    fn centerline_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.centerline_rad.clone(), self.0.modules)
    }

    #[getter]
    fn amplitude_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.amplitude_rad.clone(), self.0.modules)
    }

    #[getter(from_rad)]
    fn turned_from_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.from_rad.clone(), self.0.modules)
    }

    #[getter]
    fn via_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.via_rad.clone(), self.0.modules)
    }

    #[getter(to_rad)]
    fn turned_to_rad<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.to_rad.clone(), self.0.modules)
    }

    #[getter]
    fn wrench<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, self.0.wrench.clone(), 3)
    }

    #[getter]
    fn error<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.0.error.clone())
    }

    #[getter]
    fn travel_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.0.travel_rad.clone())
    }

    #[getter]
    fn transition_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.0.transition_s.clone())
    }

    #[getter]
    fn clearance_m<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.0.clearance_m.clone())
    }

    #[getter]
    fn guarantee_m<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.0.guarantee_m.clone())
    }

    #[getter]
    fn loss_tolerant<'py>(&self, py: Python<'py>) -> Vector<'py, bool> {
        vector(py, self.0.loss_tolerant.clone())
    }

    #[getter]
    fn outside_envelope<'py>(&self, py: Python<'py>) -> Vector<'py, bool> {
        vector(py, self.0.outside_envelope.clone())
    }
}
