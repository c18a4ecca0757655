//! Vehicles by name or from files.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::scenario::read;
use crate::rov::vehicle::{BUILT_IN, Vehicle, VehicleError};
use crate::toml_lines::line_at;

/// Why there is no such vehicle.
#[derive(Debug, Error)]
pub enum OpenError {
    /// No such file, and no built-in vehicle of that name.
    #[error("{name}: no such file, and no built-in vehicle of that name (there are {})", names())]
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
        source: std::io::Error,
    },
    /// The file is no vehicle.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
}

/// The names of those that come with the program.
#[must_use]
pub fn names() -> String {
    BUILT_IN.map(|(name, _)| name).join(", ")
}

/// The built-in vehicle of that name, or the one in that file.
///
/// # Errors
/// [`OpenError`].
pub fn open(name: &str) -> Result<Vehicle, OpenError> {
    let path = Path::new(name);
    if let Some(vehicle) = Vehicle::built_in(name).filter(|_| path.is_dir() || !path.exists()) {
        return Ok(vehicle);
    }
    let bytes = read(path).map_err(|source| match source.kind() {
        ErrorKind::NotFound => OpenError::Unknown { name: name.to_owned() },
        _ => OpenError::Unreadable { path: path.to_owned(), source },
    })?;
    let text = std::str::from_utf8(&bytes).map_err(|error| VehicleError::Invalid {
        file: name.to_owned(),
        line: line_at(&bytes, error.valid_up_to()),
        message: "is not a text in UTF-8".to_owned(),
    })?;
    Ok(Vehicle::parse(name, text)?)
}
