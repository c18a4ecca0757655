//! From a module's TOML file and its key to the image in its flash, and back.
//!
//! ```text
//! module.toml ─→ tables ─→ constants, network ─┐
//! key file ────────────────────────────────────┴─→ Configuration ─→ trial ─→ image: UF2 or bare bytes
//!        the same file, without secrets ←─ shown ←─┘
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`file`](ModuleFile) | a file read: every mistake with its line, key, value and unit |
//! | `tables` | its shape |
//! | `constants` | what the firmware takes, checked as the firmware would |
//! | `network` | how the module gets to its host |
//! | `configuration` | both together, and `trial` of it |
//! | `trial` | the firmware itself, built from what is about to be written |
//! | [`image`] | the bytes, in either format |
//! | [`shown`] | what an image holds, without its secrets |
//! | [`memory`] | where it goes |
//!
//! Assumptions and limits: a board has at most eight thruster outputs, and timers fine enough; its own firmware looks again.

mod configuration;
mod constants;
mod file;
pub mod image;
pub mod memory;
mod network;
pub mod shown;
mod tables;
mod trial;

pub use file::{BUILT_IN, ModuleFile, NetworkOptions, ProvisionError};

#[cfg(test)]
mod tests;
