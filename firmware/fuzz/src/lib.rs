//! What is asked of every input, by the fuzz targets as by the plain tests of `firmware/tests/fuzz.rs`.

pub mod configuration;
pub mod endpoint;
