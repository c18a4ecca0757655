//! The wire: golden bytes, vectors of others, attacks, arbitrary input, configuration images.

mod attacks;
mod common;
mod configuration;
mod fuzzing;
mod golden;
mod vectors;
