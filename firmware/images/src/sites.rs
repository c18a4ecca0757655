//! Call sites in a linked image: the instruction that calls a function, and its line of source.
//!
//! A call is a Thumb-2 `BL` (encoding T1), and a `B.W` (T4) where the caller ends with it (Arm DDI 0403, A7.7.12 and A7.7.18). The line
//! is that of the innermost frame that is not of Rust's own library: `x.unwrap()` is where it is written, not in `core`.
//!
//! Assumptions and limits: code is looked at halfword by halfword, so data between it could look like a call; that it goes to just the
//! function in question is next to impossible. Calls through a pointer are not seen. The image has line tables.

use std::path::Path;

use addr2line::Loader;

use crate::elf::{ElfError, Program};

/// One call of a panic function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Site {
    /// Where the instruction is.
    pub address: u32,
    /// What is called.
    pub function: String,
    /// The package whose source it comes from; empty if unknown.
    pub package: String,
    /// File and line.
    pub place: String,
}

/// Every call of a function that `wanted` names, from one that it does not, by address.
///
/// # Errors
/// [`ElfError`], also where the lines cannot be read.
pub fn calls(
    path: &Path,
    program: &Program<'_>,
    wanted: impl Fn(&str) -> bool,
) -> Result<Vec<Site>, ElfError> {
    let functions = program.places()?;
    let named = |at: u32| {
        let after = functions.partition_point(|function| function.address <= at);
        functions[..after].last().map_or("", |function| function.name.as_str())
    };
    let loader = Loader::new(path).map_err(|error| ElfError::Lines(error.to_string()))?;
    let mut sites = Vec::new();
    for (base, code) in program.code()? {
        for (offset, pair) in (0..).step_by(2).zip(code.windows(4).step_by(2)) {
            let address = base + offset;
            let Some(target) = branch(
                address,
                u16::from_le_bytes([pair[0], pair[1]]),
                u16::from_le_bytes([pair[2], pair[3]]),
            ) else {
                continue;
            };
            let begins = functions.binary_search_by_key(&target, |function| function.address).is_ok();
            let function = named(target);
            if !begins || !wanted(function) || wanted(named(address)) {
                continue;
            }
            let (package, place) = source(&loader, address)?;
            sites.push(Site { address, function: function.to_owned(), package, place });
        }
    }
    Ok(sites)
}

/// Where the instruction of these two halfwords at `address` branches to, if it is a `BL` or a `B.W`.
fn branch(address: u32, first: u16, second: u16) -> Option<u32> {
    // 11110 S imm10 and 1 L J1 1 J2 imm11, L: the link is kept
    if first & 0xf800 != 0xf000 || second & 0x9000 != 0x9000 {
        return None;
    }
    let (first, second) = (u32::from(first), u32::from(second));
    let (s, j1, j2) = (first >> 10 & 1, second >> 13 & 1, second >> 11 & 1);
    let (i1, i2) = (!(j1 ^ s) & 1, !(j2 ^ s) & 1);
    let offset = s << 24 | i1 << 23 | i2 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    let signed = offset | if s == 1 { 0xfe00_0000 } else { 0 };
    Some(address.wrapping_add(4).wrapping_add(signed))
}

/// Package, file and line that an instruction comes from.
fn source(loader: &Loader, address: u32) -> Result<(String, String), ElfError> {
    let unread = |error: Box<dyn std::error::Error>| ElfError::Lines(error.to_string());
    let mut frames = loader.find_frames(u64::from(address)).map_err(unread)?;
    let mut innermost = None;
    while let Some(frame) = frames.next().map_err(|error| ElfError::Lines(error.to_string()))? {
        let Some(location) = frame.location else { continue };
        let file = location.file.unwrap_or("").to_owned();
        let place = format!("{file}:{}", location.line.unwrap_or(0));
        let rusts_own = file.starts_with("/rustc/") || file.contains("/lib/rustlib/");
        if !rusts_own && !file.is_empty() {
            return Ok((package(&file), place));
        }
        innermost.get_or_insert((package(&file), place));
    }
    Ok(innermost.unwrap_or_default())
}

/// The package that a source file is of: the folder above its `src`, without a version.
fn package(file: &str) -> String {
    let folder = file.rsplit_once("/src/").map_or("", |(folder, _)| folder);
    let name = folder.rsplit('/').next().unwrap_or("");
    match name.rsplit_once('-') {
        Some((name, version)) if version.starts_with(|c: char| c.is_ascii_digit()) => name.to_owned(),
        _ => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_go_where_an_assembler_says() {
        // arm-none-eabi-as: at 0x1000 `bl 0x2000`, `bl 0xf00`, `b.w 0x1800`; and `blx r3; nop`, `movw r0, #1`.
        for (first, second, target) in [
            (0xf000, 0xfffe, Some(0x2000)),
            (0xf7ff, 0xff7e, Some(0x0f00)),
            (0xf000, 0xbbfe, Some(0x1800)),
            (0x4798, 0xbf00, None),
            (0xf240, 0x0001, None),
        ] {
            assert_eq!(branch(0x1000, first, second), target, "{first:04x} {second:04x}");
        }
    }

    #[test]
    fn packages_are_told_by_their_folder() {
        for (file, expected) in [
            (
                "/root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/postcard-1.2.0/src/varint.rs",
                "postcard",
            ),
            ("/home/a/flotilla/protocol/src/session.rs", "protocol"),
            ("/x/embassy-net-wiznet-0.3.0/src/lib.rs", "embassy-net-wiznet"),
            ("/rustc/59807616e1fa/library/core/src/result.rs", "core"),
            ("", ""),
        ] {
            assert_eq!(package(file), expected, "{file}");
        }
    }
}
