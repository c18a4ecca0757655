//! Vehicles by name or from files.

use std::path::Path;

use reconfiguration::vehicle::{BUILT_IN, Vehicle, VehicleError};
use thiserror::Error;

use super::scenario::{ScenarioError, text_of};

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
    #[error(transparent)]
    File(#[from] ScenarioError),
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
    let text = text_of(path)?.ok_or_else(|| OpenError::Unknown { name: name.to_owned() })?;
    Ok(Vehicle::parse(name, &text)?)
}
