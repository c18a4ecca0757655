//! A scenario as its file has it, to be changed key by key.

use std::borrow::Cow;
use std::path::Path;

use host::run::scenario::{BUILT_IN, Scenario};
use reader::{FileError, file};
use toml::Table;

use super::axis::Set;
use super::path;

/// See the module's documentation.
#[derive(Debug)]
pub struct Base {
    /// Its name in messages.
    file: String,
    /// The text of its file.
    pub text: Cow<'static, str>,
    table: Table,
    scenario: Scenario,
}

impl Base {
    /// The scenario that comes with the program, or the file, seen from `folder`.
    pub fn open(name: &str, folder: &Path) -> Result<Self, FileError> {
        let built_in = BUILT_IN.iter().any(|(known, _)| *known == name);
        let beside = folder.join(name).display().to_string();
        // What is neither is told by the name that the campaign gives it.
        let name = if built_in || !Path::new(&beside).exists() { name } else { beside.as_str() };
        let scenario = Scenario::open(name)?;
        let file::Source { file, text, .. } = file::open(name, "scenario", &BUILT_IN)?;
        let table = text.parse::<Table>().map_err(|error| FileError::Invalid {
            file: file.clone(),
            line: 1,
            message: error.message().to_owned(),
        })?;
        Ok(Self { file, text, table, scenario })
    }

    /// The scenario's name.
    pub fn name(&self) -> &str {
        &self.scenario.name
    }

    /// The scenario with `settings`.
    ///
    /// # Errors
    /// What is wrong with them, as the reader of scenarios says it: with table, key, value and unit.
    pub fn with(&self, settings: &[Set<'_>]) -> Result<Scenario, String> {
        if settings.is_empty() {
            return Ok(self.scenario.clone());
        }
        let mut table = self.table.clone();
        for (key, value) in settings {
            path::set(&mut table, key, value)?;
        }
        let text = toml::to_string(&table).map_err(|error| error.to_string())?;
        // Lines of a text that no person has written say nothing.
        Scenario::parse(&self.file, &text).map_err(|error| match error {
            FileError::Invalid { message, .. } => message,
            other => other.to_string(),
        })
    }
}
