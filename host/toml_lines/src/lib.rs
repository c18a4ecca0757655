//! Reading TOML so that whatever is wrong in it is told with its line.

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The line of the byte at `offset`, from 1.
pub fn line_at(text: &[u8], offset: usize) -> usize {
    text.iter().take(offset).filter(|&&byte| byte == b'\n').count() + 1
}

/// Lists of fixed length by their path; `*` is every item. The reader of TOML refuses those that are too short, and
/// takes no notice of what a list has too much.
pub type Lengths<'a> = &'a [(&'a [&'a str], usize)];

/// Reads `text`, or says in which line it is not what it should be, and why.
pub fn read<T: DeserializeOwned>(text: &str, lengths: Lengths<'_>) -> Result<T, (usize, String)> {
    let parsed = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(text.as_bytes(), span.start));
        let message = error.message().replace('\n', " ");
        // "invalid type" and the like tell the value but not the key.
        match text.lines().nth(line - 1) {
            Some(source) if message.starts_with("invalid ") => {
                (line, format!("{}: {message}", source.trim()))
            }
            _ => (line, message),
        }
    })?;
    too_long(text, lengths).map_or(Ok(parsed), Err)
}

/// Line of the first list that is longer than it should be, and what to say about it.
fn too_long(text: &str, lengths: Lengths<'_>) -> Option<(usize, String)> {
    fn search(value: &Spanned<DeValue<'_>>, path: &[&str], length: usize) -> Option<(usize, usize)> {
        match (value.get_ref(), path) {
            (DeValue::Array(items), []) if items.len() > length => Some((value.span().start, items.len())),
            (DeValue::Array(items), ["*", rest @ ..]) => {
                items.iter().find_map(|item| search(item, rest, length))
            }
            (DeValue::Table(table), [key, rest @ ..]) => {
                let (_, inner) = table.iter().find(|(name, _)| name.get_ref() == key)?;
                search(inner, rest, length)
            }
            _ => None,
        }
    }
    let document = DeTable::parse(text).ok()?;
    lengths.iter().find_map(|(path, length)| {
        let (first, rest) = path.split_first()?;
        let (_, value) = document.get_ref().iter().find(|(name, _)| name.get_ref() == first)?;
        let (offset, found) = search(value, rest, *length)?;
        let key = path.iter().rfind(|step| **step != "*")?;
        let line = line_at(text.as_bytes(), offset);
        Some((line, format!("{key}: a list of {found} where {length} numbers are asked for")))
    })
}

/// The line where the value at `path` (keys, or indices of arrays) stands, or where the last part of the path that
/// exists stands.
pub fn line_of(text: &str, path: &[&str]) -> usize {
    fn descend<'a>(value: &'a DeValue<'a>, step: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        match value {
            DeValue::Table(table) => {
                table.iter().find(|(key, _)| key.get_ref() == step).map(|(_, value)| value)
            }
            DeValue::Array(array) => array.get(step.parse::<usize>().ok()?),
            _ => None,
        }
    }
    let Ok(document) = DeTable::parse(text) else { return 1 };
    let Some((first, rest)) = path.split_first() else { return 1 };
    let entry = document.get_ref().iter().find(|(key, _)| key.get_ref() == first);
    let Some(mut value) = entry.map(|(_, value)| value) else { return 1 };
    for step in rest {
        match descend(value.get_ref(), step) {
            Some(inner) => value = inner,
            None => break,
        }
    }
    line_at(text.as_bytes(), value.span().start)
}
