//! `simulate` and `RovSimulation`: `flotilla simulate`.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

use host::answer::response::{self as answer, Described, Request};
use host::run::vehicles;
use nalgebra::Vector6;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use reconfiguration::vehicle::Vehicle;
use rov::dynamics::{Dynamics, State};
use rov::response::response;

use crate::array::{self, Matrix};
use crate::error::{bad, could};
use crate::json;
use crate::threads::threads;

/// A vehicle by its name or file; or a body by all of its numbers.
fn described(value: &Bound<'_, PyAny>) -> PyResult<Described> {
    match value.cast::<PyString>() {
        Ok(name) => vehicles::open(name.to_str()?).map(|v| Described::Named(Box::new(v))).map_err(bad),
        Err(_) => Ok(Described::Body(Box::new(json::read("vehicle", value)?))),
    }
}

/// States at times `at_s` under one wrench, or under pulses: `flotilla simulate` with one request.
#[pyfunction]
#[pyo3(signature = (vehicle, at_s, *, eta = None, nu = None, tau = None, pwm_us = None, voltage_v = None))]
pub fn simulate<'py>(
    vehicle: &Bound<'py, PyAny>,
    at_s: &Bound<'py, PyAny>,
    eta: Option<&Bound<'py, PyAny>>,
    nu: Option<&Bound<'py, PyAny>>,
    tau: Option<&Bound<'py, PyAny>>,
    pwm_us: Option<&Bound<'py, PyAny>>,
    voltage_v: Option<f64>,
) -> PyResult<(Matrix<'py>, Matrix<'py>)> {
    let py = vehicle.py();
    let list = |name: &str, value: Option<&Bound<'py, PyAny>>| {
        value.map(|value| array::list(name, value)).transpose()
    };
    let zero = || vec![0.0; 6];
    let request = Request {
        vehicle: Some(described(vehicle)?),
        eta: list("eta", eta)?.unwrap_or_else(zero),
        nu: list("nu", nu)?.unwrap_or_else(zero),
        tau: list("tau", tau)?,
        pwm_us: list("pwm_us", pwm_us)?,
        voltage_v,
        at_s: array::list("at_s", at_s)?,
    };
    let reply = py.detach(|| answer::reply(request, None)).map_err(bad)?;
    let etas: Vec<f64> = reply.states.iter().flat_map(|sample| sample.eta).collect();
    let nus: Vec<f64> = reply.states.iter().flat_map(|sample| sample.nu).collect();
    Ok((array::matrix(py, etas, 6)?, array::matrix(py, nus, 6)?))
}

/// From what pushes to a wrench.
type Wrenched<'a> = &'a dyn Fn(&[f64]) -> Result<Vector6<f64>, String>;

/// ROVs of one kind, each in a water of its own.
#[pyclass(frozen, module = "flotilla")]
pub struct RovSimulation {
    vehicle: Option<Box<Vehicle>>,
    dynamics: Dynamics,
    now: Mutex<Now>,
}

#[derive(Clone)]
struct Now {
    t_s: f64,
    states: Vec<State>,
}

impl RovSimulation {
    fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What pushes each vehicle: of the three ways to say it, the one that is given.
    fn wrenches(
        &self,
        count: usize,
        tau: Option<&Bound<'_, PyAny>>,
        thrust_n: Option<&Bound<'_, PyAny>>,
        pwm_us: Option<&Bound<'_, PyAny>>,
        voltage_v: Option<f64>,
    ) -> PyResult<Vec<Vector6<f64>>> {
        let vehicle = self.vehicle.as_deref();
        let thrusters = vehicle.map_or(0, |vehicle| vehicle.thrusters.len());
        let each = |name: &str, value: &Bound<'_, PyAny>, width: usize, of: Wrenched<'_>| {
            if width == 0 {
                return Err(bad(format!("{name}: this vehicle has no thrusters")));
            }
            let rows = array::rows_or_row(name, value, count, width)?;
            rows.chunks(width).map(of).collect::<Result<_, _>>().map_err(bad)
        };
        match (tau, thrust_n, pwm_us, voltage_v) {
            (Some(tau), None, None, None) => each("tau", tau, 6, &answer::wrench),
            (None, Some(thrust_n), None, None) => {
                each("thrust_n", thrust_n, thrusters, &|thrusts_n| answer::thrust(vehicle, thrusts_n))
            }
            (None, None, Some(pwm_us), Some(voltage_v)) => {
                each("pwm_us", pwm_us, thrusters, &|pulses_us| answer::pushed(vehicle, pulses_us, voltage_v))
            }
            _ => Err(bad("takes one of tau, thrust_n, or pwm_us with voltage_v")),
        }
    }
}

#[pymethods]
impl RovSimulation {
    #[new]
    #[pyo3(signature = (vehicle, count = 1, *, eta = None, nu = None))]
    fn new(
        vehicle: &Bound<'_, PyAny>,
        count: usize,
        eta: Option<&Bound<'_, PyAny>>,
        nu: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (body, vehicle) = match described(vehicle)? {
            Described::Named(vehicle) => (vehicle.body.clone(), Some(vehicle)),
            Described::Body(body) => {
                body.validate().map_err(|error| bad(format!("vehicle: {error}")))?;
                (*body, None)
            }
        };
        let given = |name: &str, value: Option<&Bound<'_, PyAny>>| match value {
            Some(value) => array::rows_or_row(name, value, count, 6),
            None => Ok(vec![0.0; 6 * count]),
        };
        let (eta, nu) = (given("eta", eta)?, given("nu", nu)?);
        let states = eta.chunks(6).zip(nu.chunks(6)).map(|(eta, nu)| answer::state(eta, nu));
        let states = states.collect::<Result<_, _>>().map_err(bad)?;
        let dynamics = answer::dynamics(&body).map_err(bad)?;
        Ok(Self { vehicle, dynamics, now: Mutex::new(Now { t_s: 0.0, states }) })
    }

    fn __len__(&self) -> usize {
        self.now().states.len()
    }

    #[getter]
    fn t_s(&self) -> f64 {
        self.now().t_s
    }

    #[getter]
    fn thrusters(&self) -> usize {
        self.vehicle.as_ref().map_or(0, |vehicle| vehicle.thrusters.len())
    }

    #[getter]
    fn eta<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let etas = self.now().states.iter().flat_map(State::eta).collect();
        array::matrix(py, etas, 6)
    }

    #[getter]
    fn nu<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let nus = self.now().states.iter().flat_map(|state| <[f64; 6]>::from(state.nu)).collect();
        array::matrix(py, nus, 6)
    }

    /// Goes on for `duration_s` under what pushes. If one vehicle's motion cannot be computed, none has moved.
    #[pyo3(signature = (duration_s, *, tau = None, thrust_n = None, pwm_us = None, voltage_v = None, threads = 1))]
    #[expect(clippy::too_many_arguments, reason = "three ways to say what pushes")]
    fn step(
        &self,
        py: Python<'_>,
        duration_s: f64,
        tau: Option<&Bound<'_, PyAny>>,
        thrust_n: Option<&Bound<'_, PyAny>>,
        pwm_us: Option<&Bound<'_, PyAny>>,
        voltage_v: Option<f64>,
        threads: usize,
    ) -> PyResult<()> {
        answer::check_times(&[duration_s]).map_err(bad)?;
        let (count, threads) = (self.__len__(), self::threads(threads)?);
        let wrenches = self.wrenches(count, tau, thrust_n, pwm_us, voltage_v)?;
        py.detach(|| {
            let mut now = self.now();
            let mut states = now.states.clone();
            let share = count.div_ceil(threads).max(1);
            let advance = |states: &mut [State], wrenches: &[Vector6<f64>]| -> Result<(), String> {
                for (state, wrench) in states.iter_mut().zip(wrenches) {
                    let after = response(&self.dynamics, state, wrench, &[duration_s]);
                    let after = after.map_err(|error| error.to_string())?;
                    *state = after.first().copied().unwrap_or(*state);
                }
                Ok(())
            };
            thread::scope(|scope| {
                let parts = states.chunks_mut(share).zip(wrenches.chunks(share));
                let parts: Vec<_> = parts.map(|(s, w)| scope.spawn(move || advance(s, w))).collect();
                let mut outcomes = parts
                    .into_iter()
                    .map(|part| part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
                outcomes.try_for_each(|outcome| outcome)
            })?;
            (now.states, now.t_s) = (states, now.t_s + duration_s);
            Ok(())
        })
        .map_err(|error: String| could(error))
    }
}

/// A description as the dictionary that it is.
#[pyfunction]
pub fn vehicle<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
    json::dict(py, &vehicles::open(name).map_err(bad)?.body)
}
