//! `route` and `Map`: `flotilla path`.

use std::path::Path;

use grid::Map as Place;
use grid::any_angle::Shortest;
use grid::plane::Plane;
use grid::read;
use grid::volume::Volume;
use host::answer::route::{Algorithm, Answer, Scratch, ask};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use reader::file::{MADE_MAX, text_of};

use crate::array::{self, Matrix};
use crate::error::bad;
use crate::json;
use crate::named::named;

enum Kind {
    Plane(Plane),
    Volume(Box<Volume>),
}

/// A map in 2D or 3D.
#[pyclass(frozen, module = "flotilla")]
pub struct Map(Kind);

/// A way from a place to another.
#[pyclass(frozen, module = "flotilla")]
pub struct Route(Answer);

impl Map {
    fn open(name: &str) -> Result<Self, String> {
        let text = text_of(Path::new(name), MADE_MAX).map_err(|error| error.to_string())?;
        let text = text.ok_or_else(|| format!("{name}: no such file"))?;
        let kind = if text.split_whitespace().next() == Some("voxel") {
            read::volume(&text).map(|volume| Kind::Volume(Box::new(volume)))
        } else {
            read::plane(&text).map(Kind::Plane)
        };
        kind.map(Self).map_err(|error| format!("{name}:{error}"))
    }

    /// Of cells that are blocked: `[y, x]` or `[z, y, x]`.
    fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (shape, blocked) = array::flags("blocked", value)?;
        let sides: Vec<u32> = shape.iter().map(|&side| u32::try_from(side).unwrap_or(u32::MAX)).collect();
        let kind = match *sides.as_slice() {
            [height, width] => {
                let at = |x: u32, y: u32| y as usize * width as usize + x as usize;
                Plane::new(width, height, |x, y| !blocked[at(x, y)]).map(Kind::Plane)
            }
            [depth, height, width] => Volume::new([width, height, depth]).map(|mut volume| {
                let cells = (0..depth)
                    .flat_map(|z| (0..height).flat_map(move |y| (0..width).map(move |x| [x, y, z])));
                for (cell, _) in cells.zip(&blocked).filter(|(_, blocked)| **blocked) {
                    volume.block(cell);
                }
                Kind::Volume(Box::new(volume))
            }),
            _ => return Err(bad(format!("blocked has the shape {shape:?}: must be (y, x) or (z, y, x)"))),
        };
        kind.map(Self).ok_or_else(|| bad(format!("blocked has the shape {shape:?}: a map has no such size")))
    }

    fn from_any(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        match value.cast::<PyString>() {
            Ok(name) => Self::open(name.to_str()?).map_err(bad),
            Err(_) if value.hasattr("__fspath__")? => {
                Self::open(&value.call_method0("__fspath__")?.extract::<String>()?).map_err(bad)
            }
            Err(_) => Self::of(value),
        }
    }

    fn find(&self, start: &Bound<'_, PyAny>, goal: &Bound<'_, PyAny>, algorithm: &str) -> PyResult<Route> {
        let algorithm = named("algorithm", algorithm)?;
        match &self.0 {
            Kind::Plane(plane) => way(plane, start, goal, algorithm),
            Kind::Volume(volume) => way(&**volume, start, goal, algorithm),
        }
    }
}

fn way<const N: usize>(
    map: &(impl Shortest<N> + Sync),
    start: &Bound<'_, PyAny>,
    goal: &Bound<'_, PyAny>,
    algorithm: Algorithm,
) -> PyResult<Route> {
    let (start_at, goal_at) = (place("start", start, map)?, place("goal", goal, map)?);
    let search = || ask(algorithm, &mut Scratch::new(), map, start_at, goal_at);
    Ok(Route(start.py().detach(search)))
}

/// A place on the map.
fn place<const N: usize>(name: &str, value: &Bound<'_, PyAny>, map: &impl Place<N>) -> PyResult<[u32; N]> {
    let place = array::whole::<N>(name, value)?;
    match map.vertex(place) {
        Some(_) => Ok(place),
        None => Err(bad(format!("{name} {place:?}: is outside the map, whose last is {:?}", map.last()))),
    }
}

#[pymethods]
impl Map {
    #[new]
    fn new(map: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::from_any(map)
    }

    /// The last place in each direction.
    #[getter]
    fn last(&self) -> Vec<u32> {
        match &self.0 {
            Kind::Plane(plane) => plane.last().to_vec(),
            Kind::Volume(volume) => volume.last().to_vec(),
        }
    }

    #[pyo3(signature = (start, goal, *, algorithm = "theta"))]
    fn route(&self, start: &Bound<'_, PyAny>, goal: &Bound<'_, PyAny>, algorithm: &str) -> PyResult<Route> {
        self.find(start, goal, algorithm)
    }
}

/// A shortest path on a map: `flotilla path`.
#[pyfunction]
#[pyo3(signature = (map, start, goal, *, algorithm = "theta"))]
pub fn route(
    map: &Bound<'_, PyAny>,
    start: &Bound<'_, PyAny>,
    goal: &Bound<'_, PyAny>,
    algorithm: &str,
) -> PyResult<Route> {
    match map.cast::<Map>() {
        Ok(map) => map.get().find(start, goal, algorithm),
        Err(_) => Map::from_any(map)?.find(start, goal, algorithm),
    }
}

#[pymethods]
impl Route {
    #[getter]
    fn length(&self) -> Option<f64> {
        self.0.length
    }

    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Option<Matrix<'py, u32>>> {
        let width = self.0.start.len();
        self.0.path.as_ref().map(|path| array::matrix(py, path.concat(), width)).transpose()
    }

    #[getter]
    fn expanded(&self) -> usize {
        self.0.expanded
    }

    #[getter]
    fn time_us(&self) -> u64 {
        self.0.time_us
    }

    /// What `flotilla path --json` prints.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        json::dict(py, &self.0)
    }
}
