//! Build script of both boards: tells the linker the memory of the chip.

use std::path::PathBuf;
use std::{env, error, fs};

/// The memory of both boards, from the directory of either.
const MEMORY: &str = "../../../memory.x";

fn main() -> Result<(), Box<dyn error::Error>> {
    println!("cargo::rerun-if-changed={MEMORY}");
    // A check of types on the PC links nothing.
    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        let directory = PathBuf::from(env::var("OUT_DIR")?);
        fs::copy(MEMORY, directory.join("memory.x"))?;
        println!("cargo::rustc-link-search={}", directory.display());
        println!("cargo::rustc-link-arg-bins=--nmagic");
        println!("cargo::rustc-link-arg-bins=-Tlink.x");
    }
    Ok(())
}
