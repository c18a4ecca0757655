//! A module's TOML file, and what is wrong with one.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use link::private_file::PrivateFileError;
use protocol::time::Duration;
use quantity::{Range, check_ranges};
use reader::file::{self, Source};
use reader::{Document, FileError, Mistake};
use thiserror::Error;
use zeroize::Zeroizing;

use super::tables::Tables;

/// The files that come with the program, by name.
pub const BUILT_IN: [(&str, &str); 2] = [
    ("modboat", include_str!("../../data/modules/modboat.toml")),
    ("rov", include_str!("../../data/modules/rov.toml")),
];

/// Why a module cannot be provisioned.
#[derive(Debug, Error)]
pub enum ProvisionError {
    /// The file cannot be read, or is not what it should be.
    #[error(transparent)]
    File(#[from] FileError),
    /// An option that takes the place of something in the file.
    #[error("{option} {message}")]
    Option {
        /// Which.
        option: &'static str,
        /// Its value, and what is wrong with it.
        message: String,
    },
    /// The file with the passphrase.
    #[error(transparent)]
    Passphrase(#[from] PrivateFileError),
}

/// What takes the place of the file's network.
#[derive(Clone, Debug, Default)]
pub struct NetworkOptions {
    /// Where the host listens.
    pub host: Option<String>,
    /// Name of the wireless network.
    pub ssid: Option<String>,
    /// File with its passphrase.
    pub passphrase_file: Option<PathBuf>,
}

/// See the module's documentation.
pub struct ModuleFile {
    file: String,
    /// Where names of files in it begin.
    pub(super) folder: PathBuf,
    text: Zeroizing<String>,
    pub(super) tables: Tables,
}

impl ModuleFile {
    /// Reads a file, or one of [`BUILT_IN`] by its name.
    ///
    /// # Errors
    /// [`ProvisionError`].
    pub fn open(name: &str) -> Result<Self, ProvisionError> {
        let Source { file, folder, text } = file::open(name, "module", &BUILT_IN)?;
        Self::parse(&file, &folder, text.into_owned())
    }

    /// Reads `text`; `file` is its name in messages, and names of files in it begin at `folder`.
    ///
    /// # Errors
    /// [`FileError::Invalid`].
    pub fn parse(file: &str, folder: &Path, text: String) -> Result<Self, ProvisionError> {
        let text = Zeroizing::new(text);
        let tables = tables_of(&text).map_err(|mistake| mistake.in_file(file))?;
        let module = Self { file: file.to_owned(), folder: folder.to_owned(), text, tables };
        match (&module.tables.modboat, &module.tables.rov) {
            (None, None) => Err(module.wrong(&[], "", "says neither [modboat] nor [rov]: write one of them")),
            (Some(_), Some(_)) => {
                Err(module.wrong(&["rov"], "", "stands beside [modboat]: a module is one of them"))
            }
            _ => Ok(module),
        }
    }

    /// What is wrong with `key` of `table`, both perhaps empty.
    pub(super) fn wrong(&self, table: &[&str], key: &str, message: &str) -> ProvisionError {
        // The text has been read once: it is TOML.
        let mistake = Document::toml(&self.text)
            .map_or_else(|mistake| mistake, |document| document.mistake_in(table, key, message));
        mistake.in_file(&self.file).into()
    }

    /// A number of `table`, or the default.
    pub(super) fn number(
        &self,
        table: &[&str],
        (key, unit): (&'static str, &'static str),
        given: Option<f64>,
        default: f32,
        range: Range,
    ) -> Result<f32, ProvisionError> {
        let Some(value) = given else { return Ok(default) };
        // On the module it is an f32, in which little may be nothing.
        for value in [value, f64::from(value as f32)] {
            check_ranges(&[(key, value, unit, range)])
                .map_err(|error| self.wrong(table, key, &error.to_string()))?;
        }
        Ok(value as f32)
    }

    /// A time of `table`, or the default. Its unit is the end of its key; it must lie in `range`, µs.
    pub(super) fn span(
        &self,
        table: &[&str],
        key: &'static str,
        given: Option<f64>,
        default: Duration,
        range: RangeInclusive<u32>,
    ) -> Result<Duration, ProvisionError> {
        let Some(value) = given else { return Ok(default) };
        let (unit, us) = if key.ends_with("_ms") { ("ms", 1e3) } else { ("s", 1e6) };
        let (least, most) = (f64::from(*range.start()) / us, f64::from(*range.end()) / us);
        // Not so for NaN.
        if value >= least && value <= most {
            return Ok(Duration((value * us).round() as u32));
        }
        let message = format!("{key} = {value} {unit}: must lie between {least} and {most} {unit}");
        Err(self.wrong(table, key, &message))
    }

    /// A whole number of `table`.
    pub(super) fn count(
        &self,
        table: &[&str],
        key: &'static str,
        value: i64,
        range: RangeInclusive<u32>,
    ) -> Result<u32, ProvisionError> {
        u32::try_from(value).ok().filter(|value| range.contains(value)).ok_or_else(|| {
            let (least, most) = (range.start(), range.end());
            self.wrong(table, key, &format!("{key} = {value}: must be a whole number from {least} to {most}"))
        })
    }
}

/// Reads `text`; no message quotes what stands on the lines of a passphrase.
fn tables_of(text: &str) -> Result<Tables, Mistake> {
    let document = Document::toml(text)?;
    let secret = document.lines(&["network", "passphrase"]);
    document.read().map_err(|mistake| match secret {
        Some(lines) if lines.contains(&mistake.line) => Mistake { message: HIDDEN.to_owned(), ..mistake },
        _ => mistake,
    })
}

const HIDDEN: &str =
    "passphrase, or what stands beside it, is not what it should be: a text in quotes (it is not shown)";
