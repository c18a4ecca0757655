//! numpy to and from what Rust computes with. Values are copied whole, never by a loop in Python.

use numpy::{PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;

/// What Python gets: one row of numbers, and rows of them.
pub type Vector<'py, T = f64> = Bound<'py, PyArray1<T>>;
/// See [`Vector`].
pub type Matrix<'py, T = f64> = Bound<'py, PyArray2<T>>;

/// A one-dimensional array.
pub fn vector<'py, T: numpy::Element>(py: Python<'py>, values: Vec<T>) -> Bound<'py, PyArray1<T>> {
    PyArray1::from_vec(py, values)
}

/// A two-dimensional array of rows of this width, one after the other in `values`.
pub fn matrix<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    width: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let rows = values.len().checked_div(width).unwrap_or(0);
    PyArray1::from_vec(py, values).reshape([rows, width])
}

/// `array_like` as an array of numbers in double precision.
fn numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if let Ok(array) = value.cast::<PyArrayDyn<f64>>() {
        return Ok(array.readonly());
    }
    let py = value.py();
    let array = numpy_module(py)?
        .call_method1(intern!(py, "asarray"), (value, numpy::dtype::<f64>(py)))
        .map_err(|error| PyTypeError::new_err(format!("{name}: {}", error.value(py))))?;
    Ok(array.cast::<PyArrayDyn<f64>>()?.readonly())
}

fn numpy_module(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import(intern!(py, "numpy"))
}

/// The values of an array in the order of C, copied.
fn values<T: numpy::Element + Copy>(array: &PyReadonlyArrayDyn<'_, T>) -> Vec<T> {
    array.as_slice().map_or_else(|_| array.as_array().iter().copied().collect(), <[T]>::to_vec)
}

/// One number after the other: shape (n,).
pub fn list(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = numbers(name, value)?;
    if array.ndim() != 1 {
        return Err(shape(name, array.shape(), "(n,)"));
    }
    Ok(values(&array))
}

/// Exactly N numbers: shape (N,).
pub fn point<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let array = numbers(name, value)?;
    match <[f64; N]>::try_from(values(&array)) {
        Ok(point) if array.ndim() == 1 => Ok(point),
        _ => Err(shape(name, array.shape(), &format!("({N},)"))),
    }
}

/// Rows of N numbers: shape (n, N).
pub fn rows<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; N]>> {
    let array = numbers(name, value)?;
    if array.ndim() != 2 || array.shape()[1] != N {
        return Err(shape(name, array.shape(), &format!("(n, {N})")));
    }
    Ok(values(&array).as_chunks::<N>().0.to_vec())
}

/// Rows of `width` numbers, flat: shape (`count`, `width`).
pub fn table(name: &str, value: &Bound<'_, PyAny>, count: usize, width: usize) -> PyResult<Vec<f64>> {
    let array = numbers(name, value)?;
    if array.shape() != [count, width] {
        return Err(shape(name, array.shape(), &format!("({count}, {width})")));
    }
    Ok(values(&array))
}

/// One row of `width` numbers for all, or a row for each of `count`, flat: shape (`width`,) or (`count`, `width`).
pub fn rows_or_row(name: &str, value: &Bound<'_, PyAny>, count: usize, width: usize) -> PyResult<Vec<f64>> {
    let array = numbers(name, value)?;
    match *array.shape() {
        [found] if found == width => Ok(values(&array).repeat(count)),
        [rows, found] if rows == count && found == width => Ok(values(&array)),
        _ => Err(shape(name, array.shape(), &format!("({width},) or ({count}, {width})"))),
    }
}

/// `array_like` of whole numbers, and its shape.
fn integers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<i64>)> {
    let py = value.py();
    let array = numpy_module(py)?.call_method1(intern!(py, "asarray"), (value,))?;
    let untyped = array.cast::<numpy::PyUntypedArray>()?;
    let kind = untyped.dtype().getattr(intern!(py, "kind"))?.extract::<char>()?;
    if !matches!(kind, 'i' | 'u') {
        return Err(PyTypeError::new_err(format!("{name}: must be whole numbers, not {}", untyped.dtype())));
    }
    let shape = untyped.shape().to_vec();
    let array = array.call_method1(intern!(py, "astype"), (numpy::dtype::<i64>(py),))?;
    Ok((shape, values(&array.cast::<PyArrayDyn<i64>>()?.readonly())))
}

/// Cells `[column, row]`: whole numbers of shape (n, 2).
pub fn cells(value: &Bound<'_, PyAny>) -> PyResult<Vec<[i32; 2]>> {
    let (found, wide) = integers("cells", value)?;
    if found.len() != 2 || found[1] != 2 {
        return Err(shape("cells", &found, "(n, 2)"));
    }
    let narrow = |&[column, row]: &[i64; 2]| -> PyResult<[i32; 2]> {
        let limited = |c: i64| {
            let far = || PyValueError::new_err(format!("cells: [{column}, {row}] lies too far out"));
            i32::try_from(c).map_err(|_| far())
        };
        Ok([limited(column)?, limited(row)?])
    };
    wide.as_chunks::<2>().0.iter().map(narrow).collect()
}

/// N whole numbers that are not negative: shape (N,).
pub fn whole<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[u32; N]> {
    let (found, wide) = integers(name, value)?;
    if found != [N] {
        return Err(shape(name, &found, &format!("({N},)")));
    }
    let narrow = |&number: &i64| {
        u32::try_from(number)
            .map_err(|_| PyValueError::new_err(format!("{name}: {number} is outside the map")))
    };
    let place: Vec<u32> = wide.iter().map(narrow).collect::<PyResult<_>>()?;
    <[u32; N]>::try_from(place).map_err(|_| shape(name, &found, &format!("({N},)")))
}

/// `array_like` of truth values (whatever is not zero), and its shape.
pub fn flags(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<bool>)> {
    let py = value.py();
    let array = numpy_module(py)?
        .call_method1(intern!(py, "asarray"), (value, numpy::dtype::<bool>(py)))
        .map_err(|error| PyTypeError::new_err(format!("{name}: {}", error.value(py))))?;
    let array = array.cast::<PyArrayDyn<bool>>()?.readonly();
    Ok((array.shape().to_vec(), values(&array)))
}

fn shape(name: &str, found: &[usize], wanted: &str) -> PyErr {
    PyValueError::new_err(format!("{name} has the shape {found:?}: must be {wanted}"))
}
