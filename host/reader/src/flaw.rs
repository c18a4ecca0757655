//! Why a value cannot be read, on its way out of the document: each table and list adds where it was.

use std::fmt;
use std::ops::Range;

use serde::de;

use crate::names;

/// What is wrong, and where.
#[derive(Debug)]
pub(crate) struct Flaw {
    pub(crate) of: Of,
    pub(crate) message: String,
    /// Bytes of the text, once they are known.
    pub(crate) span: Option<Range<usize>>,
    /// From the innermost out.
    pub(crate) path: Vec<Step>,
}

/// What the message speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    /// The value at the end of the path.
    Value,
    /// A key in the table at the end of the path.
    Key,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Key(String),
    Index(usize),
}

impl Flaw {
    pub(crate) fn of_value(message: String) -> Self {
        Self { of: Of::Value, message, span: None, path: Vec::new() }
    }

    fn of_key(message: String) -> Self {
        Self { of: Of::Key, ..Self::of_value(message) }
    }

    /// The same, at `span` unless its place is known more closely.
    pub(crate) fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }

    /// The same in a value at `span`, below `step`.
    pub(crate) fn below(mut self, step: Step, span: &Range<usize>) -> Self {
        self.path.push(step);
        self.at(span)
    }
}

impl fmt::Display for Flaw {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.message)
    }
}

impl std::error::Error for Flaw {}

impl de::Error for Flaw {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::of_value(message.to_string())
    }

    fn invalid_type(_: de::Unexpected<'_>, expected: &dyn de::Expected) -> Self {
        Self::of_value(format!("must be {expected}"))
    }

    fn unknown_variant(name: &str, names: &'static [&'static str]) -> Self {
        Self::of_value(format!("unknown name, {}", names::expected(name, names)))
    }

    fn unknown_field(key: &str, keys: &'static [&'static str]) -> Self {
        Self::of_key(format!("unknown field `{}`, {}", key.escape_debug(), names::expected(key, keys)))
    }

    fn missing_field(key: &'static str) -> Self {
        Self::of_key(format!("missing field `{key}`"))
    }
}
