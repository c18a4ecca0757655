//! Any message by its schema: a walk over its values.

use super::cdr::{Cdr, CdrError, Decoder};
use super::schema::{Kind, Schema, Shape};

/// One value that is no message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// Yes or no.
    Bool(bool),
    /// A whole number, not negative.
    Unsigned(u64),
    /// A whole number.
    Signed(i64),
    /// Of 32 bits.
    Float32(f32),
    /// Of 64 bits.
    Float64(f64),
    /// Text.
    Text(&'a str),
}

/// Reads one value.
///
/// # Errors
/// [`CdrError`].
pub fn value<'a>(kind: Kind, decoder: &mut Decoder<'a>) -> Result<Value<'a>, CdrError> {
    Ok(match kind {
        Kind::Bool => Value::Bool(bool::decode(decoder)?),
        Kind::Integer { bytes, signed } => match (bytes, signed) {
            (1, false) => Value::Unsigned(u8::decode(decoder)?.into()),
            (1, true) => Value::Signed(u8::decode(decoder)?.cast_signed().into()),
            (2, false) => Value::Unsigned(u16::decode(decoder)?.into()),
            (2, true) => Value::Signed(u16::decode(decoder)?.cast_signed().into()),
            (4, false) => Value::Unsigned(u32::decode(decoder)?.into()),
            (4, true) => Value::Signed(i32::decode(decoder)?.into()),
            (_, false) => Value::Unsigned(u64::decode(decoder)?),
            (_, true) => Value::Signed(i64::decode(decoder)?),
        },
        Kind::Float32 => Value::Float32(f32::decode(decoder)?),
        Kind::Float64 => Value::Float64(f64::decode(decoder)?),
        // A message has no value of its own.
        Kind::Text | Kind::Message(_) => Value::Text(decoder.text()?),
    })
}

/// How many values of a shape come next.
///
/// # Errors
/// [`CdrError`].
pub fn count(shape: Shape, decoder: &mut Decoder<'_>) -> Result<usize, CdrError> {
    match shape {
        Shape::One => Ok(1),
        Shape::Fixed(count) => Ok(count),
        Shape::Sequence(most) => decoder.count(most),
    }
}

/// Calls `take` with every value of the message `number` of `schema`, in order.
///
/// # Errors
/// [`CdrError`].
pub fn walk<'a>(
    schema: &Schema,
    number: usize,
    decoder: &mut Decoder<'a>,
    take: &mut dyn FnMut(Value<'a>),
) -> Result<(), CdrError> {
    for field in schema.fields(number) {
        for _ in 0..count(field.shape, decoder)? {
            match field.kind {
                Kind::Message(inner) => walk(schema, inner, decoder, take)?,
                kind => take(value(kind, decoder)?),
            }
        }
    }
    Ok(())
}
