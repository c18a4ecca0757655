//! A text in TOML or JSON, and mistakes in it: found by reading, or by what is made of the values afterwards.
//!
//! In TOML a mistake is told as `[table] key = value: what is wrong`, or `[[table]] 2: key = value: what is wrong` for the
//! second of several tables; in JSON as `table[1].key = value: what is wrong`.

use std::fmt::{Display, Write};
use std::ops::Range;

use serde::de::DeserializeOwned;

use crate::deserializer::{At, TABLE};
use crate::flaw::{Flaw, Of, Step};
use crate::mistake::Mistake;
use crate::node::{Node, Value};
use crate::{json, line_at, toml, without_mark};

/// No more characters of a value are shown.
const SHOWN_MAX: usize = 40;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Toml,
    Json,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Document<'t> {
    text: &'t str,
    format: Format,
    root: Node<'t>,
}

impl<'t> Document<'t> {
    /// Parses a text in TOML.
    ///
    /// # Errors
    /// [`Mistake`]: it is none. No value of it is quoted.
    pub fn toml(text: &'t str) -> Result<Self, Mistake> {
        let text = without_mark(text);
        Ok(Self { text, format: Format::Toml, root: toml::parse(text)? })
    }

    /// Parses a text in JSON.
    pub fn json(text: &'t str) -> Result<Self, Mistake> {
        let text = without_mark(text);
        Ok(Self { text, format: Format::Json, root: json::parse(text)? })
    }

    /// Reads a value of type `T` from the document.
    ///
    /// # Errors
    /// [`Mistake`]: the first value that is not what it should be, or key that is too much or missing.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, Mistake> {
        T::deserialize(At(&self.root)).map_err(|mut flaw| {
            flaw.path.reverse();
            let offset = flaw.span.as_ref().map_or(self.root.span.start, |span| span.start);
            Mistake::at(self.text, offset, self.told(&flaw))
        })
    }

    /// A mistake in what stands at `path`, of keys and of indices of lists, or in the last part of the path that exists.
    pub fn mistake(&self, path: &[&str], message: impl Into<String>) -> Mistake {
        Mistake::at(self.text, self.span(path).start, message.into())
    }

    /// A mistake in `key` of the table at `path`, with the table's name before the message.
    pub fn mistake_in(&self, table: &[&str], key: &str, message: impl Display) -> Mistake {
        let step = |name: &&str| name.parse().map_or_else(|_| Step::Key((*name).to_owned()), Step::Index);
        let steps: Vec<Step> = table.iter().map(step).collect();
        let path: Vec<&str> = table.iter().copied().chain([key]).collect();
        self.mistake(&path, format!("{}{message}", self.head(&steps)))
    }

    /// Lines that the value at `path` stands on, if there is one.
    #[must_use]
    pub fn lines(&self, path: &[&str]) -> Option<std::ops::RangeInclusive<usize>> {
        let node = path.iter().try_fold(&self.root, |node, step| node.child(step))?;
        let line = |offset| line_at(self.text.as_bytes(), offset);
        Some(line(node.span.start)..=line(node.span.end))
    }

    fn span(&self, path: &[&str]) -> Range<usize> {
        let mut node = &self.root;
        for step in path {
            let Some(inner) = node.child(step) else { break };
            node = inner;
        }
        node.span.clone()
    }

    fn told(&self, flaw: &Flaw) -> String {
        let message = match self.format {
            Format::Toml => flaw.message.clone(),
            Format::Json => flaw.message.replace(TABLE, "an object"),
        };
        if flaw.of == Of::Key {
            return format!("{}{message}", self.head(&flaw.path));
        }
        let (table, key, node) = self.split(&flaw.path);
        let head = self.head(table);
        let key = match self.format {
            Format::Toml => dotted(key),
            Format::Json => dotted(&flaw.path),
        };
        let head = if self.format == Format::Toml { head.as_str() } else { "" };
        match &node.value {
            _ if key.is_empty() => format!("{head}{message}"),
            // Tables are long, and may hold a secret.
            Value::Table(_) => format!("{head}{key}: {message}"),
            Value::List(items) if items.iter().any(|item| matches!(item.value, Value::Table(_))) => {
                format!("{head}{key}: {message}")
            }
            _ => format!("{head}{key} = {}: {message}", self.excerpt(&node.span)),
        }
    }

    /// A path in parts: to the innermost table around its end, and from there; and what stands at its end.
    fn split<'p>(&self, path: &'p [Step]) -> (&'p [Step], &'p [Step], &Node<'t>) {
        let (mut node, mut at) = (&self.root, 0);
        for (index, step) in path.iter().enumerate() {
            if matches!(node.value, Value::Table(_)) {
                at = index;
            }
            let inner = match step {
                Step::Key(key) => node.child(key),
                Step::Index(index) => node.child(&index.to_string()),
            };
            let Some(inner) = inner else { break };
            node = inner;
        }
        let (table, key) = path.split_at(at);
        (table, key, node)
    }

    /// What stands before a message about something in the table at `path`.
    fn head(&self, path: &[Step]) -> String {
        match (self.format, path) {
            (_, []) => String::new(),
            (Format::Json, path) => format!("{}: ", dotted(path)),
            (Format::Toml, [names @ .., Step::Index(index)]) => {
                format!("[[{}]] {}: ", dotted(names), index + 1)
            }
            (Format::Toml, names) => format!("[{}] ", dotted(names)),
        }
    }

    /// The beginning of what stands at `span`, in one line.
    fn excerpt(&self, span: &Range<usize>) -> String {
        let whole = self.text.get(span.clone()).unwrap_or_default();
        let first = whole.lines().next().unwrap_or_default();
        let mut shown = String::new();
        for c in first.chars().take(SHOWN_MAX) {
            if c.is_control() { shown.extend(c.escape_default()) } else { shown.push(c) }
        }
        if first.chars().count() > SHOWN_MAX || first.len() < whole.len() {
            shown.push('…');
        }
        shown
    }
}

/// Keys and indices as they are written in a program: `robots[1].start`.
fn dotted(path: &[Step]) -> String {
    let mut dotted = String::new();
    for step in path {
        // Writing to a String cannot fail.
        let _ = match step {
            Step::Key(key) if dotted.is_empty() => write!(dotted, "{}", key.escape_debug()),
            Step::Key(key) => write!(dotted, ".{}", key.escape_debug()),
            Step::Index(index) => write!(dotted, "[{index}]"),
        };
    }
    dotted
}

#[cfg(test)]
mod tests;
