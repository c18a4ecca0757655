//! Vehicles by name or from files.

use reader::FileError;
use reader::file::{self, Source};
use reconfiguration::vehicle::{BUILT_IN, Vehicle};

/// The built-in vehicle of that name, or the one in that file.
///
/// # Errors
/// [`FileError`].
pub fn open(name: &str) -> Result<Vehicle, FileError> {
    let Source { file, text, .. } = file::open(name, "vehicle", &BUILT_IN)?;
    Vehicle::parse(&file, &text)
}
