//! Reading and writing of wire bytes with bounds checked: hostile bytes give an error, never a panic.

use thiserror::Error;

/// Bytes that do not follow their protocol.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("{what} at byte {at}")]
pub struct Malformed {
    /// What is wrong.
    pub what: &'static str,
    /// Where it was met, from the start of the message.
    pub at: usize,
}

/// A place in bytes that are read from the front.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// At the start of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Bytes that are left.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// An error at this place.
    pub fn malformed(&self, what: &'static str) -> Malformed {
        Malformed { what, at: self.at }
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..count).ok_or(self.malformed("cut short"))?;
        self.at += count;
        Ok(taken)
    }

    /// A reader of the next `count` bytes alone; this one goes on behind them.
    pub fn section(&mut self, count: usize) -> Result<Self, Malformed> {
        Ok(Reader::new(self.take(count)?))
    }

    /// The next `N` bytes.
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let taken = self.take(N)?;
        taken.try_into().map_err(|_| self.malformed("cut short"))
    }

    /// An unsigned byte.
    pub fn u8(&mut self) -> Result<u8, Malformed> {
        self.array::<1>().map(|[byte]| byte)
    }

    /// Two bytes, low byte first.
    pub fn u16_le(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    /// Four bytes, low byte first.
    pub fn u32_le(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    /// Four bytes, low byte first, signed.
    pub fn i32_le(&mut self) -> Result<i32, Malformed> {
        self.array().map(i32::from_le_bytes)
    }

    /// Eight bytes, low byte first.
    pub fn u64_le(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }

    /// A single-precision number, low byte first.
    pub fn f32_le(&mut self) -> Result<f32, Malformed> {
        self.array().map(f32::from_le_bytes)
    }

    /// A double-precision number, low byte first.
    pub fn f64_le(&mut self) -> Result<f64, Malformed> {
        self.array().map(f64::from_le_bytes)
    }

    /// Four bytes, high byte first.
    pub fn u32_be(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_be_bytes)
    }

    /// Four bytes, high byte first, signed.
    pub fn i32_be(&mut self) -> Result<i32, Malformed> {
        self.array().map(i32::from_be_bytes)
    }

    /// A double-precision number, high byte first.
    pub fn f64_be(&mut self) -> Result<f64, Malformed> {
        self.array().map(f64::from_be_bytes)
    }

    /// How many entries follow, each of at least `least` bytes: a count that the rest cannot hold is refused, so that no memory is
    /// set aside on a stranger's word.
    pub fn count_le(&mut self, least: usize) -> Result<usize, Malformed> {
        let count = self.u32_le()?;
        let fits = usize::try_from(count).ok().filter(|&count| count <= self.left() / least.max(1));
        fits.ok_or(self.malformed("a count larger than the rest of the message"))
    }

    /// Text up to its zero byte; what is no UTF-8 is replaced.
    pub fn text(&mut self) -> Result<String, Malformed> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|&byte| byte == 0).ok_or(self.malformed("text without an end"))?;
        let text = self.take(end)?;
        self.take(1)?;
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

/// Text in a field of fixed length: up to its zero byte, or all of it.
pub fn text_of(field: &[u8]) -> String {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    String::from_utf8_lossy(field.get(..end).unwrap_or_default()).into_owned()
}

/// Writes text and its zero byte; text ends at a zero byte of its own.
pub fn put_text(out: &mut Vec<u8>, text: &str) {
    out.extend(text.bytes().take_while(|&byte| byte != 0));
    out.push(0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_beyond_the_rest_is_refused() {
        let bytes = [255, 255, 255, 127, 0, 0];
        assert_eq!(
            Reader::new(&bytes).count_le(1),
            Err(Malformed { what: "a count larger than the rest of the message", at: 4 })
        );
        assert_eq!(Reader::new(&[2, 0, 0, 0, 9, 9]).count_le(1), Ok(2));
    }

    #[test]
    fn text_without_an_end_is_refused() {
        assert_eq!(Reader::new(b"ab\0c").text().as_deref(), Ok("ab"));
        assert!(Reader::new(b"abc").text().is_err());
        assert_eq!(text_of(b"Motive\0ib\0"), "Motive");
    }
}
