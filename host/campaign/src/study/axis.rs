//! Keys of a scenario and the values that they take: lists and ranges.

use reader::{Document, Mistake};
use serde::Deserialize;
use toml::{Table, Value};

/// A key of a scenario, with dots between its parts, and its value.
pub type Setting = (String, Value);
/// The same, of a study.
pub type Set<'s> = (&'s str, &'s Value);
/// The values of a key on a grid.
pub type Axis = Vec<Value>;

/// Keys that are not varied, and why.
const FIXED: [(&str, &str); 3] = [
    ("name", "names the scenario in the rows"),
    ("description", "changes nothing"),
    ("seed", "`seeds` at the top of the campaign says which"),
];
/// Most values of one key.
const VALUES_MAX: u64 = 100_000;

/// An interval of numbers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    from: f64,
    to: f64,
    /// Of a grid: how many values, ends included.
    steps: Option<u64>,
    #[serde(default)]
    scale: Scale,
    /// Whole numbers only.
    #[serde(default)]
    whole: bool,
}

/// What is even between the ends of a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Scale {
    /// Differences.
    #[default]
    Linear,
    /// Ratios.
    Log,
}

impl Range {
    /// The value at `share` of [0, 1) of the range.
    pub fn at(&self, share: f64) -> Value {
        if self.whole {
            // Every whole number has the same share.
            let count = self.to - self.from + 1.0;
            return Value::Integer((self.from + (share * count).floor()).min(self.to) as i64);
        }
        Value::Float(self.between(share))
    }

    fn between(&self, share: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => self.from + share * (self.to - self.from),
            Scale::Log => self.from * (self.to / self.from).powf(share),
        };
        value.clamp(self.from, self.to)
    }

    /// `steps` values, ends included.
    fn values(&self, steps: u64) -> Axis {
        let at = |step: u64| {
            let value = match step {
                0 => self.from,
                _ if step == steps - 1 => self.to,
                _ => self.between(step as f64 / (steps - 1) as f64),
            };
            if self.whole { Value::Integer(value.round() as i64) } else { Value::Float(value) }
        };
        let mut values: Axis = (0..steps).map(at).collect();
        values.dedup();
        values
    }

    fn check(&self, on_grid: bool) -> Result<(), String> {
        let Self { from, to, steps, scale, whole } = self;
        if !(from.is_finite() && to.is_finite() && from < to) {
            return Err(format!("from = {from}, to = {to}: `from` must lie below `to`"));
        }
        if *scale == Scale::Log && *from <= 0.0 {
            return Err(format!("from = {from}: must be greater than zero where scale = \"log\""));
        }
        if *whole && (from.fract() != 0.0 || to.fract() != 0.0 || from.abs().max(to.abs()) > 1e15) {
            return Err(format!("from = {from}, to = {to}: must be whole numbers where whole = true"));
        }
        if *whole && *scale == Scale::Log && !on_grid {
            return Err("whole = true and scale = \"log\" do not go together in a sample".to_owned());
        }
        match (steps, on_grid) {
            (None, false) => Ok(()),
            (Some(steps), true) if (2..=VALUES_MAX).contains(steps) => Ok(()),
            (Some(steps), true) => Err(format!("steps = {steps}: must lie between 2 and {VALUES_MAX}")),
            (None, true) => Err("steps: says how many values, ends included".to_owned()),
            (Some(_), false) => Err("steps: `points` of [sample] says how many".to_owned()),
        }
    }
}

/// A table of the campaign's file with the path to it and the keys of the scenario that stand in it.
struct Place<'d, 't> {
    document: &'d Document<'t>,
    /// Where in the file.
    path: Vec<String>,
    /// What of the scenario.
    key: String,
}

impl Place<'_, '_> {
    fn mistake(&self, table: &[&str], message: &str) -> Mistake {
        let path: Vec<&str> = self.path.iter().map(String::as_str).collect();
        let head = self.document.mistake_in(table, "", "").message;
        self.document.mistake(&path, format!("{head}{}: {message}", self.key))
    }
}

/// Keys with the tables below them written out: `radio.loss`, whether it stands as `"radio.loss"`, `radio.loss` or in a table of its own.
fn leaves<'a, 'd, 't>(
    document: &'d Document<'t>,
    path: &[&str],
    table: &'a Table,
    is_leaf: fn(&Value) -> bool,
) -> Vec<(Place<'d, 't>, &'a Value)> {
    let mut open: Vec<(Vec<String>, String, &Value)> = Vec::new();
    let path: Vec<String> = path.iter().map(|step| (*step).to_owned()).collect();
    let below = |path: &[String], key: &str, table: &'a Table| {
        let entry = |(name, value): (&'a String, &'a Value)| {
            let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            ([path, std::slice::from_ref(name)].concat(), key, value)
        };
        table.iter().map(entry).collect::<Vec<_>>()
    };
    open.extend(below(&path, "", table));
    let mut found = Vec::new();
    while let Some((path, key, value)) = open.pop() {
        match value {
            Value::Table(table) if !is_leaf(value) => open.extend(below(&path, &key, table)),
            _ => found.push((Place { document, path, key }, value)),
        }
    }
    found.sort_by(|a, b| a.0.key.cmp(&b.0.key));
    found
}

fn is_range(value: &Value) -> bool {
    value
        .as_table()
        .is_some_and(|table| table.contains_key("from") || table.contains_key("to") || table.is_empty())
}

/// Refuses keys that are not varied, and those that stand twice.
fn check_keys(table: &[&str], found: &[(Place<'_, '_>, &Value)]) -> Result<(), Mistake> {
    for (index, (place, _)) in found.iter().enumerate() {
        let fixed = FIXED.iter().find(|(key, _)| *key == place.key);
        if let Some((_, why)) = fixed {
            return Err(place.mistake(table, &format!("is not varied: {why}")));
        }
        if index > 0 && found[index - 1].0.key == place.key {
            return Err(place.mistake(table, "is there twice"));
        }
    }
    Ok(())
}

fn range(place: &Place<'_, '_>, table: &[&str], value: &Value, on_grid: bool) -> Result<Range, Mistake> {
    let read: Result<Range, _> = value.clone().try_into();
    let range = read.map_err(|error: toml::de::Error| place.mistake(table, error.message()))?;
    range.check(on_grid).map_err(|message| place.mistake(table, &message))?;
    Ok(range)
}

/// The axes of a grid, by key.
pub fn axes(document: &Document<'_>, path: &[&str], table: &Table) -> Result<Vec<(String, Axis)>, Mistake> {
    let found = leaves(document, path, table, is_range);
    check_keys(path, &found)?;
    let axis = |(place, value): (Place<'_, '_>, &Value)| {
        let values = match value {
            Value::Array(values) if values.is_empty() => {
                return Err(place.mistake(path, "names at least one value"));
            }
            Value::Array(values) => values.clone(),
            Value::Table(_) => {
                let range = range(&place, path, value, true)?;
                range.values(range.steps.unwrap_or(2))
            }
            _ => return Err(place.mistake(path, "must be a list of values, or { from, to, steps }")),
        };
        if let Some(twice) = (1..values.len()).find(|&k| values[..k].contains(&values[k])) {
            return Err(place.mistake(path, &format!("{} is there twice", values[twice])));
        }
        Ok((place.key, values))
    };
    found.into_iter().map(axis).collect()
}

/// The ranges of a sample, by key.
pub fn ranges(
    document: &Document<'_>,
    path: &[&str],
    table: &Table,
) -> Result<Vec<(String, Range)>, Mistake> {
    let found = leaves(document, path, table, is_range);
    check_keys(path, &found)?;
    let one = |(place, value): (Place<'_, '_>, &Value)| {
        let range = range(&place, path, value, false)?;
        Ok((place.key, range))
    };
    found.into_iter().map(one).collect()
}

/// Keys, each with one value.
pub fn settings(document: &Document<'_>, path: &[&str], table: &Table) -> Result<Vec<Setting>, Mistake> {
    let found = leaves(document, path, table, |_| false);
    check_keys(&path[..path.len() - 1], &found)?;
    Ok(found.into_iter().map(|(place, value)| (place.key, value.clone())).collect())
}

/// Where `key` of a scenario stands below `table` of the campaign's file.
pub fn place(document: &Document<'_>, table: &[&str], key: &str) -> Vec<String> {
    let mut path: Vec<String> = table.iter().map(|step| (*step).to_owned()).collect();
    let parts: Vec<&str> = key.split('.').collect();
    let mut from = 0;
    // Any parts of the key may stand in quotes together.
    while from < parts.len() {
        let longest = (from + 1..=parts.len()).rev().find(|&to| {
            let step = parts[from..to].join(".");
            let all: Vec<&str> = path.iter().map(String::as_str).chain([step.as_str()]).collect();
            document.lines(&all).is_some()
        });
        let Some(to) = longest else { break };
        path.push(parts[from..to].join("."));
        from = to;
    }
    path
}

/// A value as a number, if it is one.
pub fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(number) => Some(*number as f64),
        Value::Float(number) => Some(*number),
        _ => None,
    }
}
