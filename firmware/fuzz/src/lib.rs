//! Checks on every input, shared by the fuzz targets and the plain tests of `firmware/tests/all/fuzzing.rs`.

pub mod configuration;
pub mod endpoint;
pub mod rov;
