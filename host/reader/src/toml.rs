//! TOML into nodes, by the parser of the crate `toml`.

use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use crate::document::Mistake;
use crate::node::{Entry, Node, Value};

/// Reads `text`.
pub(crate) fn parse(text: &str) -> Result<Node<'_>, Mistake> {
    let document = DeTable::parse(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        Mistake::at(text, start, error.message().replace('\n', " "))
    })?;
    let span = document.span();
    let value =
        table(document.into_inner()).map_err(|(offset, message)| Mistake::at(text, offset, message))?;
    Ok(Node { span, value })
}

type Refused = (usize, String);

fn table(table: DeTable<'_>) -> Result<Value<'_>, Refused> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        let span = key.span();
        entries.push(Entry { key: key.into_inner(), span, node: node(value)? });
    }
    Ok(Value::Table(entries))
}

fn node(value: Spanned<DeValue<'_>>) -> Result<Node<'_>, Refused> {
    let span = value.span();
    let out_of_range = |shown: &str| (span.start, format!("{shown}: number out of range"));
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text),
        DeValue::Integer(number) => {
            Value::Whole(whole(&number).ok_or_else(|| out_of_range(number.as_str()))?)
        }
        DeValue::Float(number) => {
            Value::Float(float(number.as_str()).ok_or_else(|| out_of_range(number.as_str()))?)
        }
        DeValue::Boolean(value) => Value::Bool(value),
        DeValue::Datetime(date) => Value::Text(date.to_string().into()),
        DeValue::Array(items) => Value::List(items.into_iter().map(node).collect::<Result<_, _>>()?),
        DeValue::Table(inner) => table(inner)?,
    };
    Ok(Node { span, value })
}

fn whole(number: &DeInteger<'_>) -> Option<i128> {
    i128::from_str_radix(number.as_str(), number.radix()).ok()
}

/// Infinite only where it is written so.
fn float(shown: &str) -> Option<f64> {
    shown.parse().ok().filter(|number: &f64| !number.is_infinite() || shown.ends_with("inf"))
}
