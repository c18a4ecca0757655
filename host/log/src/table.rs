//! A topic as a tidy table: one row a message, or one a module where a message has a list of them.
//!
//! | in the message | in the table |
//! |---|---|
//! | time in the log | column `t_s` |
//! | a message within | its fields, names joined by `_` |
//! | `T[N]` | N columns, numbered from 0 |
//! | `T[<=1]` | as one value; empty where there is none |
//! | `T[]` of the message itself | one row an element, numbered in the column `index`; what is not in a list is repeated |
//! | `T[]` further within | one cell: elements separated by `;`, their values by spaces |
//! | `Time`, `Duration` | seconds with nine decimals, column ending with `_s` |
//! | a number with a unit | column ending with it, see [`units`](super::units) |
//!
//! Numbers are written with as many digits as it takes to read them back exactly. Text with a comma, quote or line end is quoted (RFC 4180).

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::io::{self, Write};
use std::iter;

use super::cdr::{CdrError, Decoder};
use super::schema::{Field, Kind, Schema, Shape};
use super::units::unit;
use super::value::{Value, count, value, walk};

/// Where a column's cells come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// The same in all rows of a message.
    Shared,
    /// An element's own.
    Own,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Table {
    schema: Schema,
    names: Vec<String>,
    columns: Vec<Column>,
    /// Whether a message may have several rows.
    listed: bool,
    /// Whether a message with empty lists says nothing.
    bare: bool,
    /// By column: the cells of the message that is being written, one or one a row.
    cells: Vec<Vec<Cell>>,
}

/// What stands in one place of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// Yes or no.
    Bool(bool),
    /// A whole number, not negative.
    Unsigned(u64),
    /// A whole number.
    Signed(i64),
    /// Of 32 bits.
    Float32(f32),
    /// Of 64 bits.
    Float64(f64),
    /// A time: seconds, and nanoseconds beside them.
    Seconds(i64, u64),
    /// Text, a list within an element among it.
    Text(String),
}

impl fmt::Display for Cell {
    /// As it stands in a file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Unsigned(value) => write!(f, "{value}"),
            Self::Signed(value) => write!(f, "{value}"),
            Self::Float32(value) => write!(f, "{value:?}"),
            Self::Float64(value) => write!(f, "{value:?}"),
            Self::Seconds(whole, nanos) => write!(f, "{whole}.{nanos:09}"),
            Self::Text(text) => f.write_str(&quoted(text)),
        }
    }
}

impl From<Value<'_>> for Cell {
    fn from(value: Value<'_>) -> Self {
        match value {
            Value::Bool(value) => Self::Bool(value),
            Value::Unsigned(value) => Self::Unsigned(value),
            Value::Signed(value) => Self::Signed(value),
            Value::Float32(value) => Self::Float32(value),
            Value::Float64(value) => Self::Float64(value),
            Value::Text(value) => Self::Text(value.to_owned()),
        }
    }
}

impl Table {
    /// Of messages with this schema.
    #[must_use]
    pub fn new(schema: Schema) -> Self {
        let fields = schema.fields(0);
        let listed = fields.iter().any(is_list);
        let bare =
            fields.iter().all(|field| is_list(field) || matches!(field.name.as_str(), "header" | "stamp"));
        let mut table = Self {
            names: Vec::new(),
            columns: Vec::new(),
            listed,
            bare,
            cells: Vec::new(),
            schema: Schema::default(),
        };
        for field in fields {
            let column = if is_list(field) { Column::Own } else { Column::Shared };
            table.head(&schema, 0, field, "", None, column);
        }
        table.cells = vec![Vec::new(); table.names.len()];
        Self { schema, ..table }
    }

    /// Names of all columns, in order.
    pub fn header(&self) -> impl Iterator<Item = &str> {
        let index = self.listed.then_some("index");
        ["t_s"].into_iter().chain(index).chain(self.names.iter().map(String::as_str))
    }

    /// Adds the columns of a field, or one of a list within a list.
    fn head(
        &mut self,
        schema: &Schema,
        message: usize,
        field: &Field,
        path: &str,
        inherited: Option<&'static str>,
        column: Column,
    ) {
        let path = if path.is_empty() { field.name.clone() } else { format!("{path}_{}", field.name) };
        let unit = match inherited {
            Some(unit) if schema.name(message) == "geometry_msgs/Vector3" => Some(unit),
            _ => unit(schema.name(message), &field.name),
        };
        let copies = if let Shape::Fixed(count) = field.shape { count } else { 1 };
        for copy in 0..copies {
            let path =
                if matches!(field.shape, Shape::Fixed(_)) { format!("{path}_{copy}") } else { path.clone() };
            match field.kind {
                Kind::Message(inner) if !is_time(schema, field.kind) => {
                    for field in schema.fields(inner) {
                        if is_list(field) {
                            self.add(&format!("{path}_{}", field.name), None, column);
                        } else {
                            self.head(schema, inner, field, &path, unit, column);
                        }
                    }
                }
                kind => self.add(&path, if is_time(schema, kind) { Some("s") } else { unit }, column),
            }
        }
    }

    fn add(&mut self, path: &str, unit: Option<&str>, column: Column) {
        self.names.push(unit.map_or_else(|| path.to_owned(), |unit| format!("{path}_{unit}")));
        self.columns.push(column);
    }

    /// Writes the header.
    ///
    /// # Errors
    /// The sink's.
    pub fn write_header(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "{}", self.header().collect::<Vec<_>>().join(","))
    }

    /// Takes in a message, whose rows [`write_rows`](Self::write_rows) then writes.
    ///
    /// # Errors
    /// [`CdrError`].
    pub fn take(&mut self, data: &[u8]) -> Result<(), CdrError> {
        self.cells.iter_mut().for_each(Vec::clear);
        let mut decoder = Decoder::new(data)?;
        let schema = std::mem::take(&mut self.schema);
        let taken =
            schema.fields(0).iter().try_fold(0, |at, field| self.fill(&schema, field, at, &mut decoder));
        self.schema = schema;
        taken.map(|_| ())
    }

    /// Reads a field into the columns from `at` on; the column behind them.
    fn fill(
        &mut self,
        schema: &Schema,
        field: &Field,
        at: usize,
        decoder: &mut Decoder<'_>,
    ) -> Result<usize, CdrError> {
        let width = width(schema, field.kind);
        let number = count(field.shape, decoder)?;
        let side_by_side = matches!(field.shape, Shape::Fixed(_));
        for element in 0..number {
            let at = if side_by_side { at + element * width } else { at };
            self.fill_one(schema, field.kind, at, decoder)?;
        }
        if let (Shape::Sequence(1), 0) = (field.shape, number) {
            for cells in self.cells.iter_mut().skip(at).take(width) {
                cells.push(Cell::Empty);
            }
        }
        Ok(at + if side_by_side { number * width } else { width })
    }

    fn fill_one(
        &mut self,
        schema: &Schema,
        kind: Kind,
        at: usize,
        decoder: &mut Decoder<'_>,
    ) -> Result<(), CdrError> {
        let inner = match kind {
            Kind::Message(inner) if !is_time(schema, kind) => inner,
            _ => {
                let cell = cell(schema, kind, decoder)?;
                if let Some(cells) = self.cells.get_mut(at) {
                    cells.push(cell);
                }
                return Ok(());
            }
        };
        let mut at = at;
        for field in schema.fields(inner) {
            if is_list(field) {
                let joined = joined(schema, field, decoder)?;
                if let Some(cells) = self.cells.get_mut(at) {
                    cells.push(Cell::Text(joined));
                }
                at += 1;
            } else {
                at = self.fill(schema, field, at, decoder)?;
            }
        }
        Ok(())
    }

    /// The rows of the message that was taken in, of the instant `at_ns`: the cells under [`header`](Self::header).
    pub fn rows(&self, at_ns: u64) -> impl Iterator<Item = impl Iterator<Item = Cow<'_, Cell>>> {
        let own = self.cells.iter().zip(&self.columns).filter(|(_, column)| **column == Column::Own);
        let longest = own.map(|(cells, _)| cells.len()).max().unwrap_or(0);
        let rows = if self.bare { longest } else { longest.max(1) };
        let at = Cell::Seconds((at_ns / 1_000_000_000).cast_signed(), at_ns % 1_000_000_000);
        (0..rows).map(move |row| {
            let index = self.listed.then_some(Cell::Unsigned(row as u64));
            let cells = self.cells.iter().zip(&self.columns).map(move |(cells, column)| {
                let cell = cells.get(if *column == Column::Shared { 0 } else { row });
                Cow::Borrowed(cell.unwrap_or(&Cell::Empty))
            });
            iter::once(at.clone()).chain(index).map(Cow::Owned).chain(cells)
        })
    }

    /// Writes these rows.
    ///
    /// # Errors
    /// The sink's.
    pub fn write_rows(&self, at_ns: u64, out: &mut impl Write) -> io::Result<()> {
        for mut row in self.rows(at_ns) {
            if let Some(first) = row.next() {
                write!(out, "{first}")?;
            }
            for cell in row {
                write!(out, ",{cell}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

/// Whether it has any number of elements.
fn is_list(field: &Field) -> bool {
    matches!(field.shape, Shape::Sequence(most) if most != 1)
}

fn is_time(schema: &Schema, kind: Kind) -> bool {
    matches!(kind, Kind::Message(inner)
        if matches!(schema.name(inner), "builtin_interfaces/Time" | "builtin_interfaces/Duration"))
}

/// Columns of one value.
fn width(schema: &Schema, kind: Kind) -> usize {
    match kind {
        Kind::Message(inner) if !is_time(schema, kind) => {
            let fields = schema.fields(inner).iter();
            let of = |field: &Field| match field.shape {
                Shape::Fixed(count) => count * width(schema, field.kind),
                _ if is_list(field) => 1,
                _ => width(schema, field.kind),
            };
            fields.map(of).sum()
        }
        _ => 1,
    }
}

fn cell(schema: &Schema, kind: Kind, decoder: &mut Decoder<'_>) -> Result<Cell, CdrError> {
    if !is_time(schema, kind) {
        return Ok(value(kind, decoder)?.into());
    }
    let [sec, nanosec] = [true, false].map(|signed| Kind::Integer { bytes: 4, signed });
    match (value(sec, decoder)?, value(nanosec, decoder)?) {
        (Value::Signed(sec), Value::Unsigned(nanos)) => Ok(Cell::Seconds(sec, nanos)),
        _ => Ok(Cell::Empty),
    }
}

/// A list within an element.
fn joined(schema: &Schema, field: &Field, decoder: &mut Decoder<'_>) -> Result<String, CdrError> {
    let mut text = String::new();
    for element in 0..count(field.shape, decoder)? {
        if element > 0 {
            text.push(';');
        }
        let mut first = true;
        let mut put = |value: Value<'_>| {
            let gap = if std::mem::take(&mut first) { "" } else { " " };
            let _ = write!(text, "{gap}{}", plain(value));
        };
        match field.kind {
            Kind::Message(inner) => walk(schema, inner, decoder, &mut put)?,
            kind => put(value(kind, decoder)?),
        }
    }
    Ok(text)
}

fn plain(value: Value<'_>) -> String {
    match value {
        Value::Text(value) => value.to_owned(),
        value => Cell::from(value).to_string(),
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
