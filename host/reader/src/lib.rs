//! Files that a person writes: TOML and JSON, read by one deserializer that tells every mistake with its place.
//!
//! | module | what |
//! |---|---|
//! | [`document`] | a text in TOML or JSON, what it is read into, and where in it a key stands |
//! | [`mod@file`] | the text of a file, or of what is built in under a name |
//! | [`names`] | a name that is unknown, the nearest one, and those that there are |
//!
//! What the two formats have in common, beyond what `serde` asks of a format:
//!
//! - a byte order mark at the beginning is skipped;
//! - `4` and `4.0` are one number, where a whole number is meant and where any number is; `4.5` for a whole number is refused;
//! - a list of fixed length has that length, neither less nor more;
//! - an unknown key or name is answered with the nearest one, and with those that there are;
//! - a mistake names its line, its key with the table around it, and its value. The unit is the end of the key.
//!
//! Limits: lists and tables lie at most 128 deep in each other; a number outside an `f64` is refused.

mod deserializer;
pub mod document;
pub mod file;
mod flaw;
mod json;
mod mistake;
pub mod names;
mod node;
mod toml;

pub use document::Document;
pub use file::FileError;
pub use mistake::Mistake;

/// The line of the byte at `offset`, from 1.
#[must_use]
pub fn line_at(text: &[u8], offset: usize) -> usize {
    text.iter().take(offset).filter(|&&byte| byte == b'\n').count() + 1
}

/// The text without the byte order mark (U+FEFF) that some editors put before it.
#[must_use]
pub fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}
