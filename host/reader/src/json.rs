//! JSON into nodes, by the parser of the crate `serde_json`: a `RawValue` borrows from the text, which tells its place.

use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt;
use std::ops::Range;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::error::Category;
use serde_json::value::RawValue;

use crate::mistake::Mistake;
use crate::node::{Entry, Node, Value};

/// Lists and objects in each other, at most; as many as `serde_json` takes.
const DEPTH_MAX: usize = 128;

/// Reads `text`.
pub(crate) fn parse(text: &str) -> Result<Node<'_>, Mistake> {
    let raw: &RawValue = serde_json::from_str(text).map_err(|error| explain(text, &error))?;
    Parser { text }.node(raw, DEPTH_MAX)
}

struct Parser<'t> {
    text: &'t str,
}

impl<'t> Parser<'t> {
    fn node(&self, raw: &'t RawValue, depth: usize) -> Result<Node<'t>, Mistake> {
        let shown = raw.get();
        let span = self.span(raw);
        let refused = |message: String| Mistake::at(self.text, span.start, message);
        let value = match shown.as_bytes().first() {
            Some(b'{' | b'[') if depth == 0 => {
                return Err(refused(format!(
                    "recursion limit exceeded: more than {DEPTH_MAX} in each other"
                )));
            }
            Some(b'{') => self.object(shown, span.start, depth - 1)?,
            Some(b'[') => {
                let items: Vec<&RawValue> =
                    serde_json::from_str(shown).map_err(|error| refused(error.to_string()))?;
                let items = items.into_iter().map(|item| self.node(item, depth - 1));
                Value::List(items.collect::<Result<_, _>>()?)
            }
            Some(b'"') => Value::Text(self.string(raw)?),
            Some(b't') => Value::Bool(true),
            Some(b'f') => Value::Bool(false),
            Some(b'n') => Value::Null,
            _ => number(shown),
        };
        Ok(Node { span, value })
    }

    fn object(&self, shown: &'t str, start: usize, depth: usize) -> Result<Value<'t>, Mistake> {
        let Fields(fields) = serde_json::from_str(shown)
            .map_err(|error: serde_json::Error| Mistake::at(self.text, start, error.to_string()))?;
        let mut known = HashSet::with_capacity(fields.len());
        let mut entries = Vec::with_capacity(fields.len());
        for (key, value) in fields {
            let (span, key) = (self.span(key), self.string(key)?);
            if !known.insert(key.clone()) {
                let message = format!("duplicate field `{}`", key.escape_debug());
                return Err(Mistake::at(self.text, span.start, message));
            }
            entries.push(Entry { key, span, node: self.node(value, depth)? });
        }
        Ok(Value::Table(entries))
    }

    fn string(&self, raw: &'t RawValue) -> Result<Cow<'t, str>, Mistake> {
        let shown = raw.get();
        if !shown.contains('\\') {
            return Ok(Cow::Borrowed(shown.trim_matches('"')));
        }
        serde_json::from_str(shown)
            .map(Cow::Owned)
            .map_err(|error| Mistake::at(self.text, self.span(raw).start, error.to_string()))
    }

    /// Which bytes of the text `raw` is.
    fn span(&self, raw: &RawValue) -> Range<usize> {
        let start = (raw.get().as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        start..start + raw.get().len()
    }
}

/// A number as it is written: whole without point and exponent, and not −0, which is none.
fn number(shown: &str) -> Value<'_> {
    let whole = shown.parse::<i128>().ok().filter(|&whole| whole != 0 || !shown.starts_with('-'));
    let float = || shown.parse::<f64>().ok().filter(|number| number.is_finite()).map(Value::Float);
    whole.map(Value::Whole).or_else(float).unwrap_or(Value::OutOfRange)
}

/// Keys and values of an object, in their order.
struct Fields<'t>(Vec<(&'t RawValue, &'t RawValue)>);

impl<'t> Deserialize<'t> for Fields<'t> {
    fn deserialize<D: Deserializer<'t>>(deserializer: D) -> Result<Self, D::Error> {
        struct Object;
        impl<'t> Visitor<'t> for Object {
            type Value = Fields<'t>;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("an object")
            }

            fn visit_map<A: MapAccess<'t>>(self, mut map: A) -> Result<Fields<'t>, A::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                }
                Ok(Fields(fields))
            }
        }
        deserializer.deserialize_map(Object)
    }
}

/// What the parser says, with the word that it stumbled over.
fn explain(text: &str, error: &serde_json::Error) -> Mistake {
    let (whole, line, column) = (error.to_string(), error.line(), error.column());
    let message = whole.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&whole);
    let source = text.lines().nth(line.saturating_sub(1)).unwrap_or("");
    let between = |c: char| c.is_whitespace() || ",:[]{}\"".contains(c);
    let start = source.get(..column).and_then(|before| before.rfind(between)).map_or(0, |at| at + 1);
    let rest = source.get(start..).unwrap_or("");
    let word: String = rest.chars().take_while(|&c| !between(c)).take(24).collect();
    let message = match error.classify() {
        Category::Syntax if !word.is_empty() => format!("{message}, found {}", word.escape_debug()),
        _ => message.to_owned(),
    };
    Mistake { line, column, message }
}
