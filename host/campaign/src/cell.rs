//! One value of a row, and rows made of figures.
//!
//! A [`Summary`](host::run::summary::Summary) becomes one row by these rules, which hold for every figure that is added to it:
//!
//! - a table becomes a column for each of its keys, `cycles.total`;
//! - the legs and the links, of which a scenario says how many there are, and lists of numbers become a column for each item, counted
//!   from 0: `legs.0.mean_m_s.1`;
//! - any other list becomes its length, `contacts.count`, and its items as a text in JSON, `contacts.list`, none where it is empty.

use serde_json::{Map, Value};

/// Lists that a scenario gives their length.
const INDEXED: [&str; 2] = ["legs", "link"];

/// See the module's documentation.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing.
    Null,
    /// A truth.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// Any number.
    Float(f64),
    /// A text.
    Text(String),
}

impl Cell {
    /// As a number; a truth is 1 or 0.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Bool(value) => Some(f64::from(u8::from(*value))),
            Self::Int(value) => Some(*value as f64),
            Self::Float(value) => Some(*value),
            Self::Null | Self::Text(_) => None,
        }
    }

    /// For a person.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Null => "–".to_owned(),
            Self::Bool(value) => value.to_string(),
            Self::Int(value) => value.to_string(),
            Self::Float(value) => value.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

impl From<&Value> for Cell {
    fn from(value: &Value) -> Self {
        match value {
            Value::Null => Self::Null,
            Value::Bool(value) => Self::Bool(*value),
            Value::Number(number) => match (number.as_i64(), number.as_f64()) {
                (Some(whole), _) => Self::Int(whole),
                (None, Some(float)) => Self::Float(float),
                (None, None) => Self::Null,
            },
            Value::String(text) => Self::Text(text.clone()),
            Value::Array(_) | Value::Object(_) => Self::Text(value.to_string()),
        }
    }
}

/// Puts `value` into `row` under `key`, by the rules above.
pub fn flatten(row: &mut Map<String, Value>, key: &str, value: Value) {
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match value {
        Value::Object(inner) => {
            inner.into_iter().for_each(|(name, value)| flatten(row, &below(&name), value));
        }
        Value::Array(items) => {
            let numbers = !items.is_empty() && items.iter().all(Value::is_number);
            if numbers || INDEXED.contains(&key) {
                let items = items.into_iter().enumerate();
                items.for_each(|(index, item)| flatten(row, &below(&index.to_string()), item));
                return;
            }
            row.insert(below("count"), items.len().into());
            let list = if items.is_empty() { Value::Null } else { Value::Array(items).to_string().into() };
            row.insert(below("list"), list);
        }
        value => drop(row.insert(key.to_owned(), value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_become_columns() {
        let figures = serde_json::json!({
            "name": "n", "on": true, "none": null, "count": 3, "mean": 2.0,
            "legs": [{ "v": [0.5, 1], "station": null }, { "v": [2, 3], "faults": ["a", "b"] }],
            "contacts": [{ "t_s": 1.5 }], "gaps": [], "link": [],
            "inner": { "a": { "b": 1 } },
        });
        let mut row = Map::new();
        flatten(&mut row, "", figures);
        let expected = serde_json::json!({
            "name": "n", "on": true, "none": null, "count": 3, "mean": 2.0,
            "legs.0.v.0": 0.5, "legs.0.v.1": 1, "legs.0.station": null,
            "legs.1.v.0": 2, "legs.1.v.1": 3, "legs.1.faults.count": 2, "legs.1.faults.list": "[\"a\",\"b\"]",
            "contacts.count": 1, "contacts.list": "[{\"t_s\":1.5}]", "gaps.count": 0, "gaps.list": null,
            "inner.a.b": 1,
        });
        assert_eq!(Value::Object(row), expected);
    }
}
