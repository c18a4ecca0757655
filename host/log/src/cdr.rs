//! Plain CDR, as ROS 2 puts messages on the wire: XCDR version 1, little endian.
//!
//! | what | bytes |
//! |---|---|
//! | encapsulation header | `00 01 00 00`; alignment counts from behind it |
//! | a number of n bytes | little endian, at a multiple of n |
//! | `bool` | one byte, 0 or 1 |
//! | `string` | length with its final NUL as `uint32`, the bytes, NUL |
//! | `T[]`, `T[<=N]` | count as `uint32`, the elements |
//! | `T[N]` | the elements |
//!
//! Source: OMG DDS-XTYPES 1.3, 7.4.1 and 7.6.2.1.2; `PLAIN_CDR` with `final` types.

use thiserror::Error;

/// In front of every message: plain CDR, little endian, no options.
pub const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Why bytes are no message of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CdrError {
    /// It is not plain little-endian CDR.
    #[error("the encapsulation is {0:02x?}, not plain little-endian CDR")]
    Encapsulation([u8; 4]),
    /// The message ends inside a value.
    #[error("it ends at byte {0}, within a value")]
    Short(usize),
    /// A text is no UTF-8, or does not end with NUL.
    #[error("the text at byte {0} is no text")]
    Text(usize),
    /// More elements than the type has room for.
    #[error("{count} elements at byte {at}, of at most {most}")]
    Count {
        /// Where.
        at: usize,
        /// How many.
        count: usize,
        /// How many there may be.
        most: usize,
    },
}

/// Writes values behind each other.
#[derive(Debug, Default)]
pub struct Encoder {
    bytes: Vec<u8>,
}

impl Encoder {
    /// Begins a message; the last one is forgotten, its memory is used again.
    pub fn begin(&mut self) {
        self.bytes.clear();
        self.bytes.extend_from_slice(&ENCAPSULATION);
    }

    /// Writes numbers that lie behind each other.
    pub(crate) fn put_doubles(&mut self, values: &[f64]) {
        if let Some((first, rest)) = values.split_first() {
            self.put(first.to_le_bytes());
            rest.iter().for_each(|value| self.bytes.extend_from_slice(&value.to_le_bytes()));
        }
    }

    /// Makes room for numbers that come one after the other, so that each is only copied.
    fn reserve(&mut self, bytes: usize) {
        self.bytes.reserve(bytes);
    }

    /// The message so far.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn put<const N: usize>(&mut self, value: [u8; N]) {
        let end = (self.bytes.len() - ENCAPSULATION.len()).next_multiple_of(N) + ENCAPSULATION.len();
        self.bytes.resize(end, 0);
        self.bytes.extend_from_slice(&value);
    }

    /// A count or length. Nothing that is logged has four thousand million of anything.
    fn put_count(&mut self, count: usize) {
        self.put(u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
    }
}

/// Reads values behind each other.
#[derive(Clone, Debug)]
pub struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    /// Of one message.
    ///
    /// # Errors
    /// [`CdrError`] for bytes that are not plain little-endian CDR.
    pub fn new(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let Some(header) = bytes.first_chunk::<4>() else { return Err(CdrError::Short(bytes.len())) };
        if header[..2] != ENCAPSULATION[..2] {
            return Err(CdrError::Encapsulation(*header));
        }
        Ok(Self { bytes, at: ENCAPSULATION.len() })
    }

    /// Where the next value is looked for.
    #[must_use]
    pub fn at(&self) -> usize {
        self.at
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        let at = (self.at - ENCAPSULATION.len()).next_multiple_of(N) + ENCAPSULATION.len();
        let value = self.bytes.get(at..).and_then(<[u8]>::first_chunk::<N>);
        let value = *value.ok_or(CdrError::Short(self.bytes.len()))?;
        self.at = at + N;
        Ok(value)
    }

    /// The count of a sequence of at most `most`. A message cannot hold more elements than it has bytes left.
    ///
    /// # Errors
    /// [`CdrError`].
    pub fn count(&mut self, most: usize) -> Result<usize, CdrError> {
        let at = self.at;
        let count = u32::decode(self)? as usize;
        if count > most {
            return Err(CdrError::Count { at, count, most });
        }
        if count > self.bytes.len().saturating_sub(self.at) {
            return Err(CdrError::Short(self.bytes.len()));
        }
        Ok(count)
    }

    /// The text that comes next.
    ///
    /// # Errors
    /// [`CdrError`].
    pub fn text(&mut self) -> Result<&'a str, CdrError> {
        let length = self.count(usize::MAX)?;
        let at = self.at;
        self.at += length;
        match self.bytes.get(at..self.at) {
            // Some writers leave an empty text without its NUL.
            Some([]) => Ok(""),
            Some([text @ .., 0]) => str::from_utf8(text).map_err(|_| CdrError::Text(at)),
            _ => Err(CdrError::Text(at)),
        }
    }
}

/// A type that has a form in CDR and a name in a `.msg` file.
pub trait Cdr: Sized {
    /// Its name as the type of a field: `float64`, `geometry_msgs/Pose`, `string[]`.
    fn ros_type() -> String;

    /// Adds the definitions of the messages in it, each once: name and text.
    fn define(_definitions: &mut Vec<(&'static str, String)>) {}

    /// Writes it.
    fn encode(&self, encoder: &mut Encoder);

    /// Reads it.
    ///
    /// # Errors
    /// [`CdrError`].
    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError>;
}

macro_rules! numbers {
    ($($type:ident = $name:literal),*) => {$(
        impl Cdr for $type {
            fn ros_type() -> String {
                $name.to_owned()
            }

            fn encode(&self, encoder: &mut Encoder) {
                encoder.put(self.to_le_bytes());
            }

            fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
                decoder.take().map($type::from_le_bytes)
            }
        }
    )*};
}

numbers!(
    u8 = "uint8",
    u16 = "uint16",
    i32 = "int32",
    u32 = "uint32",
    i64 = "int64",
    u64 = "uint64",
    f32 = "float32",
    f64 = "float64"
);

impl Cdr for bool {
    fn ros_type() -> String {
        "bool".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.put([u8::from(*self)]);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
        decoder.take().map(|[byte]| byte != 0)
    }
}

impl Cdr for String {
    fn ros_type() -> String {
        "string".to_owned()
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.put_count(self.len() + 1);
        encoder.bytes.extend_from_slice(self.as_bytes());
        encoder.bytes.push(0);
    }

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
        decoder.text().map(str::to_owned)
    }
}

impl<T: Cdr> Cdr for Vec<T> {
    fn ros_type() -> String {
        format!("{}[]", T::ros_type())
    }

    fn define(definitions: &mut Vec<(&'static str, String)>) {
        T::define(definitions);
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.put_count(self.len());
        self.iter().for_each(|element| element.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
        let count = decoder.count(usize::MAX)?;
        (0..count).map(|_| T::decode(decoder)).collect()
    }
}

/// One or none: `T[<=1]`.
impl<T: Cdr> Cdr for Option<T> {
    fn ros_type() -> String {
        format!("{}[<=1]", T::ros_type())
    }

    fn define(definitions: &mut Vec<(&'static str, String)>) {
        T::define(definitions);
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.put_count(usize::from(self.is_some()));
        self.iter().for_each(|element| element.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
        Ok(if decoder.count(1)? == 1 { Some(T::decode(decoder)?) } else { None })
    }
}

impl<T: Cdr + Copy + Default, const N: usize> Cdr for [T; N] {
    fn ros_type() -> String {
        format!("{}[{N}]", T::ros_type())
    }

    fn define(definitions: &mut Vec<(&'static str, String)>) {
        T::define(definitions);
    }

    fn encode(&self, encoder: &mut Encoder) {
        encoder.reserve(size_of::<Self>());
        self.iter().for_each(|element| element.encode(encoder));
    }

    fn decode(decoder: &mut Decoder<'_>) -> Result<Self, CdrError> {
        let mut all = [T::default(); N];
        for element in &mut all {
            *element = T::decode(decoder)?;
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(values: &[&dyn Fn(&mut Encoder)]) -> Vec<u8> {
        let mut encoder = Encoder::default();
        encoder.begin();
        values.iter().for_each(|value| value(&mut encoder));
        encoder.bytes().to_vec()
    }

    #[test]
    fn values_lie_where_the_standard_puts_them() {
        // Worked by hand from the alignment rules; the header does not count.
        let written = bytes(&[
            &|e| true.encode(e),
            &|e| 1.0_f64.encode(e),
            &|e| "ab".to_owned().encode(e),
            &|e| 7_u16.encode(e),
            &|e| vec![1_u8, 2].encode(e),
        ]);
        let mut expected = vec![0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];
        expected.extend([0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0, 7, 0, 0, 0]);
        expected.extend([2, 0, 0, 0, 1, 2]);
        assert_eq!(written, expected);
        let mut decoder = Decoder::new(&written).expect("CDR");
        assert_eq!(bool::decode(&mut decoder), Ok(true));
        assert_eq!(f64::decode(&mut decoder).map(f64::to_bits), Ok(1.0_f64.to_bits()));
        assert_eq!(String::decode(&mut decoder).as_deref(), Ok("ab"));
        assert_eq!(u16::decode(&mut decoder), Ok(7));
        assert_eq!(Vec::<u8>::decode(&mut decoder), Ok(vec![1, 2]));
        assert_eq!(decoder.at(), written.len());
    }

    #[test]
    fn what_is_cut_or_claims_too_much_is_refused() {
        let whole = bytes(&[&|e| vec!["one".to_owned(), "two".to_owned()].encode(e)]);
        for length in 4..whole.len() {
            let mut decoder = Decoder::new(&whole[..length]).expect("CDR");
            assert!(Vec::<String>::decode(&mut decoder).is_err(), "of {length} bytes");
        }
        let claims = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0x7f];
        assert_eq!(Vec::<u8>::decode(&mut Decoder::new(&claims).expect("CDR")), Err(CdrError::Short(8)));
        let two = bytes(&[&|e| vec![1_u32, 2].encode(e)]);
        let refused = Option::<u32>::decode(&mut Decoder::new(&two).expect("CDR"));
        assert_eq!(refused, Err(CdrError::Count { at: 4, count: 2, most: 1 }));
        assert_eq!(Decoder::new(&[0, 0, 0, 0]).err(), Some(CdrError::Encapsulation([0; 4])));
        assert_eq!(Decoder::new(&[0, 1]).err(), Some(CdrError::Short(2)));
    }
}
