//! What stands in a document, whichever its format: values, each with the bytes that it was read from.

use std::borrow::Cow;
use std::ops::Range;

/// A value and its place.
#[derive(Debug)]
pub(crate) struct Node<'t> {
    /// Bytes of the text.
    pub(crate) span: Range<usize>,
    pub(crate) value: Value<'t>,
}

#[derive(Debug)]
pub(crate) enum Value<'t> {
    Null,
    Bool(bool),
    Whole(i128),
    Float(f64),
    /// A number that none of these can hold.
    OutOfRange,
    /// A text, or a date of TOML, which nothing asks for.
    Text(Cow<'t, str>),
    List(Vec<Node<'t>>),
    Table(Vec<Entry<'t>>),
}

/// A key of a table and its value.
#[derive(Debug)]
pub(crate) struct Entry<'t> {
    pub(crate) key: Cow<'t, str>,
    /// Bytes of the key.
    pub(crate) span: Range<usize>,
    pub(crate) node: Node<'t>,
}

impl<'t> Node<'t> {
    /// The value of a key, or the item of an index, below this one.
    pub(crate) fn child(&self, step: &str) -> Option<&Node<'t>> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|entry| entry.key == step).map(|entry| &entry.node),
            Value::List(items) => items.get(step.parse::<usize>().ok()?),
            _ => None,
        }
    }
}
