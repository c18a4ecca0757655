//! The line that an emulated module prints every second: pairs of a name and a value.

use std::collections::BTreeMap;

/// One line.
#[derive(Clone, Debug, Default)]
pub struct Report(BTreeMap<String, String>);

impl Report {
    /// Reads a line; `None` if it is another.
    #[must_use]
    pub fn read(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.first() != Some(&"tick") || !words.len().is_multiple_of(2) {
            return None;
        }
        Some(Self(words.chunks(2).map(|pair| (pair[0].to_owned(), pair[1].to_owned())).collect()))
    }

    /// The number with this name.
    ///
    /// # Panics
    /// If the line has none.
    #[must_use]
    pub fn number(&self, name: &str) -> u64 {
        let value = self.0.get(name).unwrap_or_else(|| panic!("no {name} in {self:?}"));
        value.parse().unwrap_or_else(|error| panic!("{name} {value}: {error}"))
    }

    /// What the module does.
    ///
    /// # Panics
    /// If the line does not say.
    #[must_use]
    pub fn state(&self) -> &str {
        self.0.get("state").unwrap_or_else(|| panic!("no state in {self:?}"))
    }
}
