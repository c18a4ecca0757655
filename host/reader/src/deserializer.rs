//! Nodes into values, by `serde`. What a value has to be is said in the words of the file, not of the program.

use std::ops::RangeInclusive;

use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use serde::forward_to_deserialize_any;

use crate::flaw::{Flaw, Step};
use crate::node::{Entry, Node, Value};

/// Whole numbers up to this one are exact in an `f64`.
const EXACT_MAX: f64 = 9_007_199_254_740_992.0;

/// What is said of a number that no type holds.
const OUT_OF_RANGE: &str = "number out of range";
/// What a table is called; JSON has another word.
pub(crate) const TABLE: &str = "a table of keys and values";

const I64_MAX: i128 = i64::MAX as i128;
const U64_MAX: i128 = u64::MAX as i128;

/// Reads a value from a node.
pub(crate) struct At<'a, 't>(pub(crate) &'a Node<'t>);

impl<'a, 't> At<'a, 't> {
    fn must_be<T>(&self, what: &str) -> Result<T, Flaw> {
        let message = match self.0.value {
            Value::OutOfRange => OUT_OF_RANGE.to_owned(),
            _ => format!("must be {what}"),
        };
        Err(Flaw::of_value(message).at(&self.0.span))
    }

    /// A whole number in `range`; `4.0` is one.
    fn whole(&self, range: &RangeInclusive<i128>) -> Result<i128, Flaw> {
        let number = match self.0.value {
            Value::Whole(number) => Some(number),
            Value::Float(number) if number.fract() == 0.0 && number.abs() <= EXACT_MAX => {
                Some(number as i128)
            }
            _ => None,
        };
        if let Some(number) = number.filter(|number| range.contains(number)) {
            return Ok(number);
        }
        // Limits of 64 bits say nothing to a person.
        match (range.start(), range.end()) {
            (0, &U64_MAX) => self.must_be("a whole number, zero or greater"),
            (_, &I64_MAX) => self.must_be("a whole number"),
            (least, most) => self.must_be(&format!("a whole number from {least} to {most}")),
        }
    }

    /// A list of exactly `length`, or of any.
    fn list(&self, length: Option<usize>) -> Result<Items<'a, 't>, Flaw> {
        let Value::List(items) = &self.0.value else {
            return match length {
                Some(length) => self.must_be(&format!("a list of {length}")),
                None => self.must_be("a list"),
            };
        };
        match length.filter(|&length| length != items.len()) {
            Some(length) => {
                let message = format!("a list of {} where {length} are asked for", items.len());
                Err(Flaw::of_value(message).at(&self.0.span))
            }
            None => Ok(Items { items: items.iter().enumerate() }),
        }
    }

    fn table(&self) -> Result<Entries<'a, 't>, Flaw> {
        match &self.0.value {
            Value::Table(entries) => Ok(Entries { entries: entries.iter(), last: None }),
            _ => self.must_be(TABLE),
        }
    }
}

/// Reads a whole number of each type.
macro_rules! whole_numbers {
    ($($deserialize:ident $visit:ident $number:ty;)*) => {$(
        fn $deserialize<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
            let number = self.whole(&(<$number>::MIN.into()..=<$number>::MAX.into()))?;
            // It lies in the range.
            visitor.$visit(number as $number).map_err(|flaw: Flaw| flaw.at(&self.0.span))
        }
    )*};
}

impl<'de> Deserializer<'de> for At<'_, '_> {
    type Error = Flaw;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        let read = match &self.0.value {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Whole(number) => match (i64::try_from(*number), u64::try_from(*number)) {
                (Ok(number), _) => visitor.visit_i64(number),
                (_, Ok(number)) => visitor.visit_u64(number),
                _ => visitor.visit_i128(*number),
            },
            Value::Float(number) => visitor.visit_f64(*number),
            Value::OutOfRange => Err(Flaw::of_value(OUT_OF_RANGE.to_owned())),
            Value::Text(text) => visitor.visit_str(text),
            Value::List(_) => visitor.visit_seq(self.list(None)?),
            Value::Table(_) => visitor.visit_map(self.table()?),
        };
        read.map_err(|flaw: Flaw| flaw.at(&self.0.span))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        match self.0.value {
            Value::Bool(value) => visitor.visit_bool(value),
            _ => self.must_be("true or false"),
        }
    }

    whole_numbers! {
        deserialize_u8 visit_u8 u8;
        deserialize_u16 visit_u16 u16;
        deserialize_u32 visit_u32 u32;
        deserialize_u64 visit_u64 u64;
        deserialize_i8 visit_i8 i8;
        deserialize_i16 visit_i16 i16;
        deserialize_i32 visit_i32 i32;
        deserialize_i64 visit_i64 i64;
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        let number = match self.0.value {
            Value::Whole(number) => number as f64,
            Value::Float(number) => number,
            _ => return self.must_be("a number"),
        };
        visitor.visit_f64(number).map_err(|flaw: Flaw| flaw.at(&self.0.span))
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        match &self.0.value {
            Value::Text(text) => visitor.visit_str(text).map_err(|flaw: Flaw| flaw.at(&self.0.span)),
            _ => self.must_be("a text in quotes"),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        self.deserialize_str(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        match self.0.value {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Flaw> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        visitor.visit_seq(self.list(None)?).map_err(|flaw| flaw.at(&self.0.span))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Flaw> {
        visitor.visit_seq(self.list(Some(length))?).map_err(|flaw| flaw.at(&self.0.span))
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Flaw> {
        visitor.visit_map(self.table()?).map_err(|flaw| flaw.at(&self.0.span))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Flaw> {
        self.deserialize_map(visitor)
    }

    /// One of several names.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Flaw> {
        match &self.0.value {
            Value::Text(text) => {
                let name: StrDeserializer<'_, Flaw> = text.as_ref().into_deserializer();
                visitor.visit_enum(name).map_err(|flaw| flaw.at(&self.0.span))
            }
            _ => self.must_be(&format!("a text in quotes, one of {}", names.join(", "))),
        }
    }

    forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf unit unit_struct tuple_struct identifier ignored_any
    }
}

/// What is left of a list.
struct Items<'a, 't> {
    items: std::iter::Enumerate<std::slice::Iter<'a, Node<'t>>>,
}

impl<'de> SeqAccess<'de> for Items<'_, '_> {
    type Error = Flaw;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Flaw> {
        let Some((index, node)) = self.items.next() else { return Ok(None) };
        let read = seed.deserialize(At(node));
        read.map(Some).map_err(|flaw| flaw.below(Step::Index(index), &node.span))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len())
    }
}

/// What is left of a table.
struct Entries<'a, 't> {
    entries: std::slice::Iter<'a, Entry<'t>>,
    /// The entry whose key was read last.
    last: Option<&'a Entry<'t>>,
}

impl<'de> MapAccess<'de> for Entries<'_, '_> {
    type Error = Flaw;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Flaw> {
        self.last = self.entries.next();
        let Some(entry) = self.last else { return Ok(None) };
        let key: StrDeserializer<'_, Flaw> = entry.key.as_ref().into_deserializer();
        seed.deserialize(key).map(Some).map_err(|flaw| flaw.at(&entry.span))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Flaw> {
        let Some(entry) = self.last else {
            return Err(Flaw::of_value("has a value without a key".to_owned()));
        };
        let read = seed.deserialize(At(&entry.node));
        read.map_err(|flaw| flaw.below(Step::Key(entry.key.to_string()), &entry.node.span))
    }
}
