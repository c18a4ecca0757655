//! Key files: the fleet's key, and the key of a single module for where the fleet's has no business to be.
//!
//! ```toml
//! # Flotilla fleet key. Its holder commands the fleet; keep it to yourself.
//! fleet = "1f2e3d4c"                 # public
//! key = "64 hexadecimal digits"
//! ```
//!
//! A module's has `module = 3` before these, and the key is that module's: with it one can pass for module 3 and for
//! no other. `fleet` is compared with a fleet's key when it is read; from a module's key it cannot be told.
//!
//! They are files that only their owner reads ([`private_file`]). Errors and `Debug` show no digit of a key, not even of a file
//! that is none.
//!
//! Limits: text and keys are wiped after use; the reader of TOML copies what it refuses, and that copy is not.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use protocol::{FleetId, FleetKey, ModuleId, ModuleKey};
use thiserror::Error;
use zeroize::Zeroizing;

use super::entropy::{self, EntropyError};
use super::private_file::{self, PrivateFileError};
use text::Content;

mod text;

/// What one module needs to know to be spoken to.
#[derive(Clone, Debug)]
pub struct ModuleCredentials {
    /// Its number in the fleet.
    pub id: ModuleId,
    /// Its fleet.
    pub fleet: FleetId,
    /// Its key.
    pub key: ModuleKey,
}

impl ModuleCredentials {
    /// Those of module `id` in the fleet of `key`.
    #[must_use]
    pub fn derive(key: &FleetKey, id: ModuleId) -> Self {
        Self { id, fleet: key.fleet(), key: key.module(id) }
    }
}

/// Why there is no key.
#[derive(Debug, Error)]
pub enum KeyFileError {
    /// No path was given, and there is no home to look in.
    #[error(
        "no key file is named, and neither XDG_CONFIG_HOME nor HOME is an absolute path to look for one in"
    )]
    NoHome,
    /// No such file.
    #[error("{}: no such key file: run `flotilla keygen` first", path.display())]
    Missing {
        /// Which file.
        path: PathBuf,
    },
    /// The file is not what it should be.
    #[error("{}:{line}: {message}", path.display())]
    Invalid {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// A module's key, where the fleet's is needed.
    #[error("{}: is the key of module {module} alone, not the fleet's", path.display())]
    OfModule {
        /// Which file.
        path: PathBuf,
        /// Whose key it is.
        module: ModuleId,
    },
    /// The fleet's key, where a module's is needed or where one is to be written.
    #[error("{}: is the key of the whole fleet {fleet}, not a module's", path.display())]
    OfFleet {
        /// Which file.
        path: PathBuf,
        /// Whose key it is.
        fleet: FleetId,
    },
    /// Another module's key.
    #[error("{}: is the key of module {module}, not of module {asked}", path.display())]
    OfOther {
        /// Which file.
        path: PathBuf,
        /// Whose key it is.
        module: ModuleId,
        /// Whose is needed.
        asked: ModuleId,
    },
    /// The file itself: it cannot be read or written, or is not its owner's alone.
    #[error(transparent)]
    File(PrivateFileError),
    /// No random bytes to make a key of.
    #[error(transparent)]
    Entropy(#[from] EntropyError),
}

impl From<PrivateFileError> for KeyFileError {
    fn from(error: PrivateFileError) -> Self {
        match error {
            PrivateFileError::Missing { path } => Self::Missing { path },
            error => Self::File(error),
        }
    }
}

/// A key file: the key of a fleet or of one module.
pub struct KeyFile;

impl KeyFile {
    /// Where the fleet's key is by default: `flotilla/fleet.key` in `$XDG_CONFIG_HOME`, if that is an
    /// absolute path, or else in `$HOME/.config`.
    ///
    /// # Errors
    /// [`KeyFileError::NoHome`].
    pub fn default_path() -> Result<PathBuf, KeyFileError> {
        default_in(env::var_os("XDG_CONFIG_HOME"), env::var_os("HOME")).ok_or(KeyFileError::NoHome)
    }

    /// Draws a fleet's key and writes it to `path`; makes the folder, with mode 0700, if need be. With `force` it takes
    /// the place of a file that is there.
    ///
    /// # Errors
    /// [`KeyFileError`]; what was there is there still.
    pub fn create(path: &Path, force: bool) -> Result<FleetKey, KeyFileError> {
        let mut bytes = Zeroizing::new([0; 32]);
        entropy::fill(&mut *bytes)?;
        let key = FleetKey::new(*bytes);
        private_file::write(path, text::of_fleet(&key).as_bytes(), force)?;
        Ok(key)
    }

    /// Derives the key of `module` from the fleet's and writes it to `path`, as [`create`](Self::create) does. It never
    /// takes the place of a fleet's key.
    ///
    /// # Errors
    /// [`KeyFileError`]; what was there is there still.
    pub fn create_module(
        path: &Path,
        fleet: &FleetKey,
        module: ModuleId,
        force: bool,
    ) -> Result<ModuleCredentials, KeyFileError> {
        if force && let Ok(there) = Self::read(path) {
            return Err(KeyFileError::OfFleet { path: path.to_owned(), fleet: there.fleet() });
        }
        let credentials = ModuleCredentials::derive(fleet, module);
        private_file::write(path, text::of_module(&credentials).as_bytes(), force)?;
        Ok(credentials)
    }

    /// The fleet's key in `path`.
    ///
    /// # Errors
    /// [`KeyFileError`].
    pub fn read(path: &Path) -> Result<FleetKey, KeyFileError> {
        match content(path)? {
            Content::Fleet(key) => Ok(key),
            Content::Module(ModuleCredentials { id: module, .. }) => {
                Err(KeyFileError::OfModule { path: path.to_owned(), module })
            }
        }
    }

    /// The module's key in `path`.
    ///
    /// # Errors
    /// [`KeyFileError`].
    pub fn read_module(path: &Path) -> Result<ModuleCredentials, KeyFileError> {
        match content(path)? {
            Content::Module(credentials) => Ok(credentials),
            Content::Fleet(key) => Err(KeyFileError::OfFleet { path: path.to_owned(), fleet: key.fleet() }),
        }
    }

    /// What module `id` needs, from a file of its own or, on the machine that has it, from the fleet's.
    ///
    /// # Errors
    /// [`KeyFileError`]; [`KeyFileError::OfOther`] if the file is another module's.
    pub fn credentials(path: &Path, id: ModuleId) -> Result<ModuleCredentials, KeyFileError> {
        match content(path)? {
            Content::Fleet(key) => Ok(ModuleCredentials::derive(&key, id)),
            Content::Module(credentials) if credentials.id == id => Ok(credentials),
            Content::Module(ModuleCredentials { id: module, .. }) => {
                Err(KeyFileError::OfOther { path: path.to_owned(), module, asked: id })
            }
        }
    }
}

fn content(path: &Path) -> Result<Content, KeyFileError> {
    let mut buffer = Zeroizing::new([0; text::LENGTH_MAX + 1]);
    let length = private_file::read(path, &mut *buffer)?;
    text::parse(&buffer[..length]).map_err(|(line, message)| KeyFileError::Invalid {
        path: path.to_owned(),
        line,
        message,
    })
}

fn default_in(config: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let absolute = |value: Option<OsString>| value.map(PathBuf::from).filter(|path| path.is_absolute());
    let folder = absolute(config).or_else(|| Some(absolute(home)?.join(".config")))?;
    Some(folder.join("flotilla").join("fleet.key"))
}

#[cfg(test)]
mod tests;
