//! A schema read back: the concatenated definitions of `ros2msg`.
//!
//! Source: the form that rosbag2 writes, <https://mcap.dev/spec/registry#ros2msg>: the definition, and behind a line of `=` each the
//! definitions of the messages in it, headed `MSG: package/Name`. Comments, constants and default values do not lie in a message.

use std::collections::HashMap;

/// What one value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `bool`
    Bool,
    /// `byte`, `char`, `uint8` … `int64`: bytes, and whether it has a sign.
    Integer {
        /// How many bytes.
        bytes: u8,
        /// Whether it may be negative.
        signed: bool,
    },
    /// `float32`
    Float32,
    /// `float64`
    Float64,
    /// `string`, bounded or not.
    Text,
    /// The message with this number in [`Schema::messages`].
    Message(usize),
}

/// How many of it there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One.
    One,
    /// So many.
    Fixed(usize),
    /// Any number up to this.
    Sequence(usize),
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// How many.
    pub shape: Shape,
}

/// One definition.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    /// `package/Name`.
    pub name: String,
    /// In order.
    pub fields: Vec<Field>,
}

/// See the module's documentation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schema {
    /// The message itself, and those in it.
    pub messages: Vec<Definition>,
}

impl Schema {
    /// Of the message `name` (`package/msg/Name`).
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut parts: Vec<(String, Vec<&str>)> = vec![(short(name), Vec::new())];
        for line in text.lines() {
            let line = line.trim();
            if line.len() >= 3 && line.chars().all(|c| c == '=') {
                parts.push((String::new(), Vec::new()));
            } else if let Some((known, lines)) = parts.last_mut() {
                match line.strip_prefix("MSG:") {
                    Some(name) if known.is_empty() => *known = short(name.trim()),
                    _ => lines.push(line),
                }
            }
        }
        let numbers: HashMap<String, usize> =
            parts.iter().enumerate().rev().map(|(number, (name, _))| (name.clone(), number)).collect();
        let messages = parts.iter().map(|(name, lines)| {
            let package = name.split('/').next().unwrap_or_default();
            let fields = lines.iter().filter_map(|line| field(line, package, &numbers).transpose());
            Ok(Definition { name: name.clone(), fields: fields.collect::<Result<_, String>>()? })
        });
        let schema = Self { messages: messages.collect::<Result<_, String>>()? };
        if schema.is_circular(0, 0) { Err("a message contains itself".to_owned()) } else { Ok(schema) }
    }

    /// Whether a definition leads back to itself.
    fn is_circular(&self, number: usize, depth: usize) -> bool {
        let fields = self.messages.get(number).map_or(&[][..], |definition| &definition.fields);
        depth > self.messages.len()
            || fields.iter().any(|field| match field.kind {
                Kind::Message(inner) => self.is_circular(inner, depth + 1),
                _ => false,
            })
    }

    /// The fields of a message.
    #[must_use]
    pub fn fields(&self, number: usize) -> &[Field] {
        self.messages.get(number).map_or(&[], |definition| &definition.fields)
    }

    /// Its `package/Name`.
    #[must_use]
    pub fn name(&self, number: usize) -> &str {
        self.messages.get(number).map_or("", |definition| &definition.name)
    }
}

/// Without the `msg` in the middle.
fn short(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// The field on a line; none on an empty one, or one with a comment or a constant.
fn field(line: &str, package: &str, numbers: &HashMap<String, usize>) -> Result<Option<Field>, String> {
    let code = line.split('#').next().unwrap_or_default().trim();
    let Some((what, rest)) = code.split_once(char::is_whitespace) else {
        return if code.is_empty() { Ok(None) } else { Err(format!("{code:?} is no field")) };
    };
    let rest = rest.trim();
    let name = rest.split(char::is_whitespace).next().unwrap_or_default();
    if name.contains('=') || rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (kind, shape) = match what.split_once('[') {
        None => (what, Shape::One),
        Some((kind, count)) => {
            let count = count.strip_suffix(']').ok_or_else(|| format!("{what:?} is no type"))?;
            let number = |text: &str| text.parse().map_err(|_| format!("{what:?} is no type"));
            let shape = match count.strip_prefix("<=") {
                Some(most) => Shape::Sequence(number(most)?),
                None if count.is_empty() => Shape::Sequence(usize::MAX),
                None => Shape::Fixed(number(count)?),
            };
            (kind, shape)
        }
    };
    let integer = |bytes, signed| Kind::Integer { bytes, signed };
    let kind = match kind {
        "bool" => Kind::Bool,
        "byte" | "char" | "uint8" => integer(1, false),
        "int8" => integer(1, true),
        "uint16" => integer(2, false),
        "int16" => integer(2, true),
        "uint32" => integer(4, false),
        "int32" => integer(4, true),
        "uint64" => integer(8, false),
        "int64" => integer(8, true),
        "float32" => Kind::Float32,
        "float64" => Kind::Float64,
        _ if kind == "string" || kind.starts_with("string<=") => Kind::Text,
        _ => {
            let full = if kind.contains('/') { short(kind) } else { format!("{package}/{kind}") };
            Kind::Message(*numbers.get(&full).ok_or_else(|| format!("{kind:?} is not defined"))?)
        }
    };
    Ok(Some(Field { name: name.to_owned(), kind, shape }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Message;
    use crate::{flotilla, ros};

    #[test]
    fn a_definition_of_ros_is_read() {
        let text = "# A comment\nHeader header\nint32 ADD=0 # none\nint32 MODIFY = 0\nuint8[] data\n\
                    geometry_msgs/msg/Point[2] corners\nstring<=10[<=3] names\nbool on true\n\
                    ===\nMSG: p/Header\nstring frame\n===\nMSG: geometry_msgs/Point\nfloat64 x\n";
        let schema = Schema::parse("p/msg/Scene", text).expect("a schema");
        let fields: Vec<_> = schema.fields(0).iter().map(|f| (f.name.as_str(), f.kind, f.shape)).collect();
        let byte = Kind::Integer { bytes: 1, signed: false };
        assert_eq!(
            fields,
            [
                ("header", Kind::Message(1), Shape::One),
                ("data", byte, Shape::Sequence(usize::MAX)),
                ("corners", Kind::Message(2), Shape::Fixed(2)),
                ("names", Kind::Text, Shape::Sequence(3)),
                ("on", Kind::Bool, Shape::One),
            ]
        );
    }

    #[test]
    fn what_is_no_definition_is_named() {
        for (text, expected) in [
            ("Pose pose\n", "\"Pose\" is not defined"),
            ("float64[x] a\n", "\"float64[x]\" is no type"),
            ("float64\n", "\"float64\" is no field"),
            ("p/A a\n===\nMSG: p/B\np/A a\n", "a message contains itself"),
        ] {
            assert_eq!(Schema::parse("p/msg/A", text).expect_err(text), expected);
        }
    }

    #[test]
    fn own_schemas_read_back() {
        for (name, text, count) in [
            (ros::Odometry::NAME, ros::Odometry::schema(), 10),
            (ros::MarkerArray::NAME, ros::MarkerArray::schema(), 13),
            (flotilla::Links::NAME, flotilla::Links::schema(), 5),
        ] {
            let schema = Schema::parse(name, &text).expect(name);
            assert_eq!(schema.messages.len(), count, "{text}");
        }
    }
}
