//! A module's TOML file, and what is wrong with one.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use link::private_file::PrivateFileError;
use protocol::time::Duration;
use quantity::{Range, check_ranges};
use thiserror::Error;
use toml::de::{DeTable, DeValue};
use toml_lines::{self, line_at, line_of};
use zeroize::Zeroizing;

use super::tables::Tables;

/// The files that come with the program, by name.
pub const BUILT_IN: [(&str, &str); 2] = [
    ("modboat", include_str!("../../data/modules/modboat.toml")),
    ("rov", include_str!("../../data/modules/rov.toml")),
];

/// No file is longer, bytes.
const FILE_MAX: u64 = 1 << 20;

/// Why a module cannot be provisioned.
#[derive(Debug, Error)]
pub enum ProvisionError {
    /// No such file, and nothing of that name.
    #[error("{name}: no such file (the ones that come with the program are modboat and rov)")]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The file is not what it should be.
    #[error("{file}:{line}: {message}")]
    Invalid {
        /// Which file.
        file: String,
        /// Which line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
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
        let path = Path::new(name);
        let built_in = BUILT_IN.iter().find(|(built_in, _)| *built_in == name);
        if let Some((_, text)) = built_in.filter(|_| path.is_dir() || !path.exists()) {
            return Self::parse(&format!("{name}.toml"), Path::new(""), (*text).to_owned());
        }
        let bytes = read(path).map_err(|source| match source.kind() {
            ErrorKind::NotFound => ProvisionError::Unknown { name: name.to_owned() },
            _ => ProvisionError::Unreadable { path: path.to_owned(), source },
        })?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let line = line_at(error.as_bytes(), error.utf8_error().valid_up_to());
            let message = "is not a text in UTF-8".to_owned();
            ProvisionError::Invalid { file: name.to_owned(), line, message }
        })?;
        Self::parse(name, path.parent().unwrap_or(Path::new("")), text)
    }

    /// Reads `text`; `file` is its name in messages, and names of files in it begin at `folder`.
    ///
    /// # Errors
    /// [`ProvisionError::Invalid`].
    pub fn parse(file: &str, folder: &Path, text: String) -> Result<Self, ProvisionError> {
        let text = Zeroizing::new(text);
        let tables = tables_of(&text).map_err(|(line, message)| ProvisionError::Invalid {
            file: file.to_owned(),
            line,
            message,
        })?;
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
        let path: Vec<&str> =
            table.iter().copied().chain([key].into_iter().filter(|key| !key.is_empty())).collect();
        let line = line_of(&self.text, &path);
        let names: Vec<&str> =
            table.iter().copied().take_while(|name| name.parse::<usize>().is_err()).collect();
        let head = match table.last().and_then(|index| index.parse::<usize>().ok()) {
            Some(index) => format!("[[{}]] {}: ", names.join("."), index + 1),
            None if names.is_empty() => String::new(),
            None => format!("[{}] ", names.join(".")),
        };
        ProvisionError::Invalid { file: self.file.clone(), line, message: format!("{head}{message}") }
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

/// The whole of a file that is not absurdly long.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(FILE_MAX + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > FILE_MAX {
        let message = format!("is longer than {FILE_MAX} bytes");
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// Reads `text`; no message quotes what stands on the lines of a passphrase.
fn tables_of(text: &str) -> Result<Tables, (usize, String)> {
    // What is no TOML at all is not quoted: nobody knows what stands where.
    let secret = match DeTable::parse(text) {
        Ok(document) => secret_lines(text, document.get_ref()),
        Err(error) => {
            let line = error.span().map_or(1, |span| line_at(text.as_bytes(), span.start));
            return Err((line, error.message().replace('\n', " ")));
        }
    };
    toml_lines::read(text, &[]).map_err(|(line, message)| {
        let hidden = secret.is_some_and(|lines| lines.contains(&line));
        let message = if hidden { HIDDEN.to_owned() } else { message };
        (line, message)
    })
}

const HIDDEN: &str =
    "passphrase, or what stands beside it, is not what it should be: a text in quotes (it is not shown)";

/// The lines that the passphrase stands on.
fn secret_lines(text: &str, document: &DeTable<'_>) -> Option<RangeInclusive<usize>> {
    let (_, network) = document.iter().find(|(name, _)| name.get_ref() == "network")?;
    let DeValue::Table(network) = network.get_ref() else { return None };
    let (_, value) = network.iter().find(|(name, _)| name.get_ref() == "passphrase")?;
    let line = |offset| line_at(text.as_bytes(), offset);
    Some(line(value.span().start)..=line(value.span().end))
}
