//! Rows as CSV (RFC 4180): names and texts in quotes, numbers and truths without, nothing for nothing. So what is read again is what was
//! written, type and all; a number with a point or an exponent is no whole number.

use std::io::{BufWriter, Write};

use super::Table;
use crate::cell::Cell;

/// Writes a table.
pub(super) fn write(table: &Table, to: impl Write) -> std::io::Result<()> {
    let mut to = BufWriter::new(to);
    let names: Vec<String> = table.columns.iter().map(|name| quoted(name)).collect();
    write!(to, "{}\r\n", names.join(","))?;
    for row in &table.rows {
        let cells: Vec<String> = row.iter().map(written).collect();
        write!(to, "{}\r\n", cells.join(","))?;
    }
    to.flush()
}

fn written(cell: &Cell) -> String {
    match cell {
        Cell::Null => String::new(),
        Cell::Bool(value) => value.to_string(),
        Cell::Int(value) => value.to_string(),
        // The shortest that reads as the same number, with a point or an exponent.
        Cell::Float(value) => format!("{value:?}"),
        Cell::Text(text) => quoted(text),
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// Reads a table.
///
/// # Errors
/// What is wrong with it, with its line.
pub(super) fn read(text: &str) -> Result<Table, String> {
    let mut line = 1;
    let mut rest = text;
    let (mut columns, mut rows) = (Vec::new(), Vec::new());
    while !rest.is_empty() {
        let began = line;
        let mut row = Vec::new();
        loop {
            let (cell, after) = cell(rest).map_err(|what| format!("line {line}: {what}"))?;
            line += rest[..rest.len() - after.len()].matches('\n').count();
            row.push(cell);
            rest = after;
            if let Some(after) = rest.strip_prefix(',') {
                rest = after;
                continue;
            }
            match rest.strip_prefix("\r\n").or_else(|| rest.strip_prefix('\n')) {
                Some(after) => rest = after,
                None if rest.is_empty() => {}
                None => return Err(format!("line {line}: more after a closing quote")),
            }
            line += 1;
            break;
        }
        if columns.is_empty() {
            columns = row.iter().map(Cell::shown).collect();
        } else if row.len() == columns.len() {
            rows.push(row);
        } else {
            return Err(format!("line {began}: {} values for {} columns", row.len(), columns.len()));
        }
    }
    Ok(Table { columns, rows })
}

/// The first cell of `text`, and what follows it.
fn cell(text: &str) -> Result<(Cell, &str), String> {
    let Some(mut rest) = text.strip_prefix('"') else {
        let end = text.find([',', '\n', '\r']).unwrap_or(text.len());
        let (word, after) = text.split_at(end);
        return Ok((value(word), after));
    };
    let mut content = String::new();
    loop {
        let end = rest.find('"').ok_or("a quote is not closed")?;
        content.push_str(&rest[..end]);
        rest = &rest[end + 1..];
        match rest.strip_prefix('"') {
            Some(after) => {
                content.push('"');
                rest = after;
            }
            None => return Ok((Cell::Text(content), rest)),
        }
    }
}

/// A word without quotes. Files of other makers have texts so.
fn value(word: &str) -> Cell {
    match word {
        "" => Cell::Null,
        "true" => Cell::Bool(true),
        "false" => Cell::Bool(false),
        _ => match (word.parse(), word.parse()) {
            (Ok(whole), _) => Cell::Int(whole),
            (_, Ok(float)) => Cell::Float(float),
            _ => Cell::Text(word.to_owned()),
        },
    }
}
