//! TOML into nodes, by the parser of the crate `toml`.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::mistake::Mistake;
use crate::node::{Entry, Node, Value};

/// Reads `text`.
pub(crate) fn parse(text: &str) -> Result<Node<'_>, Mistake> {
    let document = DeTable::parse(text).map_err(|error| {
        let span = error.span().unwrap_or_default();
        let message = match (error.message(), text.get(span.clone())) {
            ("duplicate key", Some(key)) => format!("duplicate key `{}`", key.escape_debug()),
            (message, _) => message.replace('\n', " "),
        };
        Mistake::at(text, span.start, message)
    })?;
    let span = document.span();
    Ok(Node { span, value: table(document.into_inner()) })
}

fn table(table: DeTable<'_>) -> Value<'_> {
    let entries = table.into_iter().map(|(key, value)| {
        let span = key.span();
        Entry { key: key.into_inner(), span, node: node(value) }
    });
    Value::Table(entries.collect())
}

fn node(value: Spanned<DeValue<'_>>) -> Node<'_> {
    let span = value.span();
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text),
        DeValue::Integer(number) => {
            let whole = i128::from_str_radix(number.as_str(), number.radix());
            whole.map_or(Value::OutOfRange, Value::Whole)
        }
        DeValue::Float(number) => {
            let shown = number.as_str();
            // Infinite only where it is written so.
            let float = shown.parse().ok().filter(|f: &f64| !f.is_infinite() || shown.ends_with("inf"));
            float.map_or(Value::OutOfRange, Value::Float)
        }
        DeValue::Boolean(value) => Value::Bool(value),
        DeValue::Datetime(date) => Value::Text(date.to_string().into()),
        DeValue::Array(items) => Value::List(items.into_iter().map(node).collect()),
        DeValue::Table(inner) => table(inner),
    };
    Node { span, value }
}
