//! What is wrong with a document, and where.

use crate::file::FileError;
use crate::line_at;

/// What is wrong with a document, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Which line, from 1.
    pub line: usize,
    /// Which byte of the line, from 1.
    pub column: usize,
    /// What is wrong there.
    pub message: String,
}

impl Mistake {
    /// At the byte `offset` of `text`.
    pub(crate) fn at(text: &str, offset: usize, message: String) -> Self {
        let before = text.as_bytes().get(..offset).unwrap_or_default();
        let column =
            offset.saturating_sub(before.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1)) + 1;
        Self { line: line_at(text.as_bytes(), offset), column, message }
    }

    /// The same with the name of the file.
    #[must_use]
    pub fn in_file(self, file: &str) -> FileError {
        FileError::Invalid { file: file.to_owned(), line: self.line, message: self.message }
    }
}
