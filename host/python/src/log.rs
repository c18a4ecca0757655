//! `read_log`: the tables that `flotilla export` writes, as columns.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use runlog::reader::{Entry, LogError, read};
use runlog::schema::Schema;
use runlog::table::{Cell, Table};

use crate::error::bad;

/// A topic, column by column.
struct Sheet {
    topic: String,
    table: Table,
    names: Vec<String>,
    columns: Vec<Column>,
}

/// One kind of value. A column becomes of a wider kind where it must: whole numbers with one missing are floating.
enum Column {
    Unknown(usize),
    Bool(Vec<bool>),
    Unsigned(Vec<u64>),
    Signed(Vec<i64>),
    Float32(Vec<f32>),
    Float64(Vec<f64>),
    Text(Vec<String>),
}

impl Column {
    fn push(&mut self, cell: &Cell) {
        if let Self::Unknown(missing) = *self {
            let none = missing > 0;
            *self = match cell {
                Cell::Empty => Self::Unknown(missing + 1),
                Cell::Text(_) => Self::Text(vec![String::new(); missing]),
                Cell::Float32(_) => Self::Float32(vec![f32::NAN; missing]),
                _ if none => Self::Float64(vec![f64::NAN; missing]),
                Cell::Bool(_) => Self::Bool(Vec::new()),
                Cell::Unsigned(_) => Self::Unsigned(Vec::new()),
                Cell::Signed(_) => Self::Signed(Vec::new()),
                Cell::Float64(_) | Cell::Seconds(..) => Self::Float64(Vec::new()),
            };
        }
        match (&mut *self, cell) {
            (Self::Unknown(_), _) => {}
            (Self::Bool(values), Cell::Bool(value)) => values.push(*value),
            (Self::Unsigned(values), Cell::Unsigned(value)) => values.push(*value),
            (Self::Signed(values), Cell::Signed(value)) => values.push(*value),
            (Self::Float32(values), Cell::Float32(value)) => values.push(*value),
            (Self::Float32(values), Cell::Empty) => values.push(f32::NAN),
            (Self::Float64(values), cell) => values.push(number(cell)),
            (Self::Text(values), Cell::Text(value)) => values.push(value.clone()),
            (Self::Text(values), cell) => values.push(cell.to_string()),
            (_, cell) => {
                let mut wide = self.numbers();
                wide.push(number(cell));
                *self = Self::Float64(wide);
            }
        }
    }

    fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Unknown(missing) => vec![f64::NAN; *missing],
            Self::Bool(values) => values.iter().map(|&value| f64::from(u8::from(value))).collect(),
            Self::Unsigned(values) => values.iter().map(|&value| value as f64).collect(),
            Self::Signed(values) => values.iter().map(|&value| value as f64).collect(),
            Self::Float32(values) => values.iter().map(|&value| f64::from(value)).collect(),
            Self::Float64(values) => values.clone(),
            Self::Text(values) => vec![f64::NAN; values.len()],
        }
    }

    fn into_array<'py>(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self {
            Self::Unknown(missing) => PyArray1::from_vec(py, vec![f64::NAN; missing]).into_any(),
            Self::Bool(values) => PyArray1::from_vec(py, values).into_any(),
            Self::Unsigned(values) => PyArray1::from_vec(py, values).into_any(),
            Self::Signed(values) => PyArray1::from_vec(py, values).into_any(),
            Self::Float32(values) => PyArray1::from_vec(py, values).into_any(),
            Self::Float64(values) => PyArray1::from_vec(py, values).into_any(),
            Self::Text(values) => py.import("numpy")?.call_method1(
                "asarray",
                (PyList::new(py, values)?, py.get_type::<pyo3::types::PyString>()),
            )?,
        })
    }
}

/// A cell as a number. Times are read from their decimals, so that they are the nearest to these.
fn number(cell: &Cell) -> f64 {
    match cell {
        Cell::Empty | Cell::Text(_) => f64::NAN,
        Cell::Bool(value) => f64::from(u8::from(*value)),
        Cell::Unsigned(value) => *value as f64,
        Cell::Signed(value) => *value as f64,
        Cell::Float32(value) => f64::from(*value),
        Cell::Float64(value) => *value,
        Cell::Seconds(whole, nanos) => {
            // Both are whole and below 2⁵³, so the quotient is the nearest number.
            let all = whole.checked_mul(1_000_000_000).and_then(|all| all.checked_add_unsigned(*nanos));
            match all.filter(|all| all.unsigned_abs() < 1 << 53) {
                Some(all) => all as f64 / 1e9,
                None => cell.to_string().parse().unwrap_or(f64::NAN),
            }
        }
    }
}

/// The topics of a log in columns, and whether the file ends as a log does.
#[pyfunction]
#[pyo3(signature = (path, topics = None))]
pub fn read_log<'py>(
    py: Python<'py>,
    path: PathBuf,
    topics: Option<Vec<String>>,
) -> PyResult<(Bound<'py, PyDict>, bool)> {
    let of_log = |error: &dyn std::fmt::Display| bad(format!("{}: {error}", path.display()));
    let read = py.detach(|| sheets(&path, topics.as_deref()));
    let (sheets, whole) = read.map_err(|error| of_log(&error))?;
    if let Some(missing) =
        topics.iter().flatten().find(|&topic| !sheets.iter().any(|sheet| sheet.topic == *topic))
    {
        return Err(of_log(&format!("has no topic {missing}")));
    }
    let all = PyDict::new(py);
    for sheet in sheets {
        let columns = PyDict::new(py);
        for (name, column) in sheet.names.into_iter().zip(sheet.columns) {
            columns.set_item(name, column.into_array(py)?)?;
        }
        all.set_item(sheet.topic, columns)?;
    }
    Ok((all, whole))
}

fn sheets(path: &PathBuf, topics: Option<&[String]>) -> Result<(Vec<Sheet>, bool), LogError> {
    let mut sheets: Vec<Sheet> = Vec::new();
    let mut known: HashMap<u16, Option<usize>> = HashMap::new();
    let (mut told, mut ended) = (false, false);
    let extent = read(BufReader::new(File::open(path)?), |entry, _| {
        told |= entry.topic == "/scenario";
        ended |= entry.topic == "/end";
        let place = match known.get(&entry.channel) {
            Some(place) => *place,
            None => {
                let wanted = topics.is_none_or(|topics| topics.iter().any(|topic| topic == entry.topic));
                let sheet = if wanted { sheet(entry)? } else { None };
                let place = sheet.map(|sheet| {
                    sheets.push(sheet);
                    sheets.len() - 1
                });
                known.insert(entry.channel, place);
                place
            }
        };
        let Some(sheet) = place.and_then(|place| sheets.get_mut(place)) else { return Ok(()) };
        sheet.table.take(entry.data).map_err(|error| entry.no_message(error))?;
        for row in sheet.table.rows(entry.at_ns) {
            for (column, cell) in sheet.columns.iter_mut().zip(row) {
                column.push(&cell);
            }
        }
        Ok::<(), LogError>(())
    })?;
    Ok((sheets, extent.whole && (!told || ended)))
}

/// Of a topic; none where its schema is not one of ROS 2.
fn sheet(entry: &Entry<'_>) -> Result<Option<Sheet>, LogError> {
    let Some(definition) = entry.definition else { return Ok(None) };
    let topic = entry.topic.to_owned();
    let schema = Schema::parse(entry.schema, definition)
        .map_err(|reason| LogError::Schema { topic: topic.clone(), reason })?;
    let table = Table::new(schema);
    let mut names: Vec<String> = Vec::new();
    for name in table.header() {
        // As pandas tells apart columns of a table that have the same name.
        let copies = (1..).map(|copy| format!("{name}.{copy}"));
        let mut candidates = std::iter::once(name.to_owned()).chain(copies);
        names.extend(candidates.find(|candidate| !names.contains(candidate)));
    }
    let columns = names.iter().map(|_| Column::Unknown(0)).collect();
    Ok(Some(Sheet { topic, table, names, columns }))
}
