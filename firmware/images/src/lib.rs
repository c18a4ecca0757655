//! Firmware images on the PC that builds them: ELF, UF2, sizes, panics.
//!
//! | module | what |
//! |---|---|
//! | [`uf2`] | UF2 files, as the boot ROM of the RP2350 takes them from its USB drive |
//! | `elf` | what a linked program loads where, its sections and its functions |
//! | `size_table` | flash and RAM of each image, as a table that is checked in |
//! | `panics` | what of Rust's panic machinery got into an image |
//! | `sites` | where a function is called |
//!
//! All but the first come with the feature `elf`, on by default, as does the program `images`.

#[cfg(feature = "elf")]
pub mod elf;
#[cfg(feature = "elf")]
pub mod panics;
#[cfg(feature = "elf")]
pub mod sites;
#[cfg(feature = "elf")]
pub mod size_table;
pub mod uf2;
