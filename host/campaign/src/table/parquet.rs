//! Rows as Apache Parquet: one row group, every column optional, BOOLEAN, INT64, DOUBLE, or BYTE_ARRAY as a string; not compressed, but
//! with dictionaries, which is what figures of many runs need.

use std::fs::File;
use std::io::Write;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::Field;
use parquet::schema::types::{Type, TypePtr};

use super::Table;
use crate::cell::Cell;

/// What all cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Bool,
    Int,
    Float,
    Text,
}

/// The narrowest kind that holds all cells; text where there is nothing.
fn kind<'c>(cells: impl Iterator<Item = &'c Cell>) -> Kind {
    let of = |cell: &Cell| match cell {
        Cell::Null => None,
        Cell::Bool(_) => Some(Kind::Bool),
        Cell::Int(_) => Some(Kind::Int),
        Cell::Float(_) => Some(Kind::Float),
        Cell::Text(_) => Some(Kind::Text),
    };
    let wider = |a, b| match (a, b) {
        (a, b) if a == b => a,
        (Kind::Int, Kind::Float) | (Kind::Float, Kind::Int) => Kind::Float,
        _ => Kind::Text,
    };
    cells.filter_map(of).reduce(wider).unwrap_or(Kind::Text)
}

/// Writes a table.
///
/// # Errors
/// Whatever the writer says.
pub(super) fn write(table: &Table, to: impl Write + Send) -> Result<(), ParquetError> {
    let kinds: Vec<Kind> =
        (0..table.columns.len()).map(|column| kind(table.rows.iter().map(|row| &row[column]))).collect();
    let fields: Result<Vec<TypePtr>, ParquetError> = table.columns.iter().zip(&kinds).map(field).collect();
    let schema = Type::group_type_builder("row").with_fields(fields?).build()?;
    let properties = WriterProperties::builder().set_created_by("flotilla-campaign".to_owned()).build();
    let mut writer = SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (column, kind) in kinds.into_iter().enumerate() {
        let cells = || table.rows.iter().map(|row| &row[column]);
        match kind {
            Kind::Bool => put::<BoolType, _>(
                &mut group,
                cells().map(|cell| if let Cell::Bool(v) = cell { Some(*v) } else { None }),
            ),
            Kind::Int => put::<Int64Type, _>(
                &mut group,
                cells().map(|cell| if let Cell::Int(v) = cell { Some(*v) } else { None }),
            ),
            Kind::Float => put::<DoubleType, _>(&mut group, cells().map(Cell::number)),
            Kind::Text => put::<ByteArrayType, _>(
                &mut group,
                cells().map(|cell| (*cell != Cell::Null).then(|| ByteArray::from(cell.shown().into_bytes()))),
            ),
        }?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn field((name, kind): (&String, &Kind)) -> Result<TypePtr, ParquetError> {
    let (physical, logical) = match kind {
        Kind::Bool => (Physical::BOOLEAN, None),
        Kind::Int => (Physical::INT64, None),
        Kind::Float => (Physical::DOUBLE, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let builder = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
    Ok(Arc::new(builder.with_logical_type(logical).build()?))
}

/// Writes the next column.
fn put<D: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: impl Iterator<Item = Option<D::T>>,
) -> Result<(), ParquetError> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    for cell in cells {
        levels.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("more columns than the schema has".to_owned()));
    };
    column.typed::<D>().write_batch(&values, Some(&levels), None)?;
    column.close()
}

/// Reads a table.
///
/// # Errors
/// Whatever the reader says; columns within columns.
pub(super) fn read(from: File) -> Result<Table, ParquetError> {
    let reader = SerializedFileReader::new(from)?;
    let schema = reader.metadata().file_metadata().schema();
    let columns = schema.get_fields().iter().map(|field| field.name().to_owned()).collect();
    let mut rows = Vec::new();
    for row in reader.get_row_iter(None)? {
        let cells = row?.into_columns().into_iter().map(|(name, field)| match field {
            Field::Null => Ok(Cell::Null),
            Field::Bool(value) => Ok(Cell::Bool(value)),
            Field::Int(value) => Ok(Cell::Int(value.into())),
            Field::Long(value) => Ok(Cell::Int(value)),
            Field::Float(value) => Ok(Cell::Float(value.into())),
            Field::Double(value) => Ok(Cell::Float(value)),
            Field::Str(text) => Ok(Cell::Text(text)),
            other => Err(ParquetError::General(format!("column {name:?}: {other} is no figure"))),
        });
        rows.push(cells.collect::<Result<Vec<Cell>, _>>()?);
    }
    Ok(Table { columns, rows })
}
