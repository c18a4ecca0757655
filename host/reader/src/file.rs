//! The text of a file, or of what is built in under a name.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::names::there_are;
use crate::{line_at, without_mark};

/// No file that a person writes is longer, bytes.
pub const WRITTEN_MAX: u64 = 1 << 20;
/// No file that a program writes is longer, bytes.
pub const MADE_MAX: u64 = 1 << 28;

/// Why there is nothing to be had from a file.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FileError {
    /// No such file, and nothing of that name comes with the program.
    #[error("{name}: no such file, and no built-in {what} of that name ({})", there_are(name, names))]
    Unknown { name: String, what: &'static str, names: Vec<&'static str> },
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Unreadable { file: String, source: io::Error },
    /// The file is not what it should be.
    #[error("{file}:{line}: {message}")]
    Invalid { file: String, line: usize, message: String },
}

/// A text, and where it is from.
#[derive(Debug)]
pub struct Source {
    /// Its name in messages.
    pub file: String,
    /// Where names of files in it begin.
    pub folder: PathBuf,
    /// The text.
    pub text: Cow<'static, str>,
}

/// Opens the file `name`, or takes the one of `built_in` that has this name; `what` they are, for the message.
pub fn open(
    name: &str,
    what: &'static str,
    built_in: &[(&'static str, &'static str)],
) -> Result<Source, FileError> {
    let path = Path::new(name);
    let known = built_in.iter().find(|(known, _)| *known == name);
    // A run's folder may well bear the name of its scenario.
    if let Some((_, text)) = known.filter(|_| path.is_dir() || !path.exists()) {
        let (file, folder) = (format!("{name}.toml"), PathBuf::new());
        return Ok(Source { file, folder, text: Cow::Borrowed(*text) });
    }
    let text = text_of(path, WRITTEN_MAX)?.ok_or_else(|| FileError::Unknown {
        name: name.to_owned(),
        what,
        names: built_in.iter().map(|(name, _)| *name).collect(),
    })?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    Ok(Source { file: name.to_owned(), folder, text: Cow::Owned(text) })
}

/// The text of a file of at most `limit` bytes, without a byte order mark; `None` if there is no such file.
///
/// # Errors
/// [`FileError`]: it cannot be read, is longer, or not UTF-8.
pub fn text_of(path: &Path, limit: u64) -> Result<Option<String>, FileError> {
    let file = path.display().to_string();
    match File::open(path) {
        Ok(from) => text_from(&file, from, limit).map(Some),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(source) => Err(FileError::Unreadable { file, source }),
    }
}

/// The text that comes from `from`; `file` is its name in messages.
///
/// # Errors
/// As [`text_of`].
pub fn text_from(file: &str, from: impl Read, limit: u64) -> Result<String, FileError> {
    let unreadable = |source| FileError::Unreadable { file: file.to_owned(), source };
    let mut bytes = Vec::new();
    // `/dev/zero` has no end.
    from.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        let message = format!("is longer than {limit} bytes");
        return Err(unreadable(io::Error::new(ErrorKind::FileTooLarge, message)));
    }
    let mut text = String::from_utf8(bytes).map_err(|error| FileError::Invalid {
        file: file.to_owned(),
        line: line_at(error.as_bytes(), error.utf8_error().valid_up_to()),
        message: "is not a text in UTF-8".to_owned(),
    })?;
    // In place: the text may hold a secret, and a copy would be left behind.
    let mark = text.len() - without_mark(&text).len();
    text.drain(..mark);
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_has_no_mark_and_an_end() {
        let text = |bytes: &[u8], limit| text_from("t", bytes, limit).map_err(|error| error.to_string());
        assert_eq!(text(b"\xef\xbb\xbfa\n", 5), Ok("a\n".to_owned()));
        assert_eq!(text(b"abcdef", 5), Err("t: is longer than 5 bytes".to_owned()));
        assert_eq!(text(b"a\nb\xff", 5), Err("t:2: is not a text in UTF-8".to_owned()));
        let endless = text_from("t", io::repeat(0), 5).expect_err("no end").to_string();
        assert_eq!(endless, "t: is longer than 5 bytes");
    }

    #[test]
    fn a_folder_named_like_what_is_built_in_hides_nothing_and_a_file_does() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("six").display().to_string();
        let name: &'static str = Box::leak(path.clone().into_boxed_str());
        let built_in = [(name, "built in"), ("nine", "")];
        let text = || open(name, "scenario", &built_in).map(|source| source.text.into_owned());
        assert_eq!(text().expect("built in"), "built in");
        std::fs::create_dir(&path).expect("a folder");
        assert_eq!(text().expect("built in"), "built in");
        std::fs::remove_dir(&path).expect("a folder");
        std::fs::write(&path, "\u{feff}file").expect("a file");
        assert_eq!(text().expect("the file"), "file");
        let error = open("nin", "scenario", &[("six", ""), ("nine", "")]).expect_err("unknown").to_string();
        let expected = "nin: no such file, and no built-in scenario of that name (there are six, nine; did you mean nine?)";
        assert_eq!(error, expected);
    }
}
