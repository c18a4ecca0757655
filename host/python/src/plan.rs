//! One plan, as Python sees it.

use std::time::Duration;

use host::answer;
use modboat::motion::{Swing, Turn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::{Vector, vector};
use crate::json;

/// One decision: a transition and a swim cycle for every module.
#[pyclass(frozen, module = "flotilla")]
pub struct Plan {
    plan: modboat::plan::Plan,
    planner: &'static str,
    took: Duration,
}

impl Plan {
    /// Of a planner with this name, which took this time.
    pub fn new(plan: modboat::plan::Plan, planner: &'static str, took: Duration) -> Self {
        Self { plan, planner, took }
    }

    fn turns(&self, of: impl Fn(&Turn) -> f64) -> Option<Vec<f64>> {
        self.plan.transition.as_ref().map(|turns| turns.iter().map(of).collect())
    }

    fn swings(&self, of: impl Fn(&Swing) -> f64) -> Vec<f64> {
        self.plan.cycle.iter().map(of).collect()
    }
}

#[pymethods]
impl Plan {
    #[getter]
    fn outcome(&self) -> &'static str {
        self.plan.outcome.name()
    }

    #[getter]
    fn centerline_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.swings(|swing| swing.centerline_rad))
    }

    #[getter]
    fn amplitude_rad<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.swings(|swing| swing.amplitude_rad))
    }

    #[getter(from_rad)]
    fn turned_from_rad<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        self.turns(|turn| turn.from_rad).map(|angles| vector(py, angles))
    }

    #[getter(to_rad)]
    fn turned_to_rad<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        self.turns(|turn| turn.to_rad).map(|angles| vector(py, angles))
    }

    #[getter]
    fn via_rad<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        self.plan.via_rad.clone().map(|angles| vector(py, angles))
    }

    #[getter]
    fn transition_s(&self) -> f64 {
        self.plan.transition_s
    }

    #[getter]
    fn wrench<'py>(&self, py: Python<'py>) -> Vector<'py> {
        vector(py, self.plan.wrench.to_array().to_vec())
    }

    #[getter]
    fn error(&self) -> f64 {
        self.plan.error
    }

    #[getter]
    fn travel_rad(&self) -> f64 {
        self.plan.travel_rad
    }

    #[getter]
    fn clearance_m(&self) -> Option<f64> {
        answer::plan::clearance_m(&self.plan)
    }

    #[getter]
    fn guarantee_m(&self) -> Option<f64> {
        answer::plan::guarantee_m(&self.plan)
    }

    #[getter]
    fn loss_tolerant(&self) -> bool {
        self.plan.loss_tolerant
    }

    #[getter]
    fn power_tolerant(&self) -> bool {
        self.plan.power_tolerant
    }

    #[getter]
    fn outside_envelope(&self) -> bool {
        self.plan.outside_envelope
    }

    #[getter]
    fn reason(&self) -> Option<String> {
        self.plan.reason.map(|reason| reason.to_string())
    }

    #[getter]
    fn planner(&self) -> &'static str {
        self.planner
    }

    #[getter]
    fn solve_us(&self) -> u64 {
        self.took.as_micros() as u64
    }

    /// The plan as `flotilla plan` prints it.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        json::dict(py, &answer::plan::Reply::new(&self.plan, self.planner, self.took))
    }

    fn __repr__(&self) -> String {
        let [fx_n, fy_n, tau_nm] = self.plan.wrench.to_array();
        format!(
            "Plan({}, {} modules, wrench [{fx_n}, {fy_n}, {tau_nm}], error {})",
            self.outcome(),
            self.plan.cycle.len(),
            self.plan.error
        )
    }
}
