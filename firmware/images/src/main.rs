//! `images`: checks and conversions of linked firmware on the PC. Exit codes: 0 done, 1 a check failed, 2 bad usage or input.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;

use clap::{Parser, Subcommand};
use images::elf::{ElfError, Program};
use images::sites::{self, Site};
use images::size_table::{Row, disagreements, rendered, replaced};
use images::{panics, uf2};

/// Turn linked firmware into UF2 files, weigh it, and look for panics in it.
#[derive(Parser)]
#[command(
    name = "images",
    version,
    after_help = "Example:\n  \
          images uf2 target/images/pico2w.elf target/images/pico2w.uf2"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a program for the RP2350 as a UF2 file, to be dragged onto the board's drive
    #[command(after_help = "Example:\n  images uf2 target/images/pico2w.elf target/images/pico2w.uf2")]
    Uf2 {
        /// The linked program
        elf: PathBuf,
        /// The file to write
        out: PathBuf,
    },
    /// Print flash and RAM of each image as a Markdown table, write it to a file, or compare it with one
    #[command(after_help = "Example:\n  images table --check firmware/boards/sizes.md \
                  --limit qemu:flash=49152,ram=8192 qemu=target/images/qemu.elf")]
    Table(TableArguments),
    /// List what of Rust's panic machinery is in an image, and fail if it may not be there
    #[command(
        after_help = "Example:\n  images panics target/images/core.elf --allow firmware/boards/panics.txt --never firmware"
    )]
    Panics {
        /// The linked program
        elf: PathBuf,
        /// What may be there: one NAME # REASON a line
        #[arg(long, value_name = "FILE")]
        allow: Option<PathBuf>,
        /// A package whose source may call none of it, whatever may be there; may be given again
        #[arg(long, value_name = "PACKAGE")]
        never: Vec<String>,
    },
}

#[derive(clap::Args)]
struct TableArguments {
    /// Put the table into this file, in place of the one in it
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    write: Option<PathBuf>,
    /// Fail if the table in this file differs by more than 2 % and 512 bytes
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
    /// Fail if an image is larger, bytes, such as qemu:flash=49152,ram=8192; may be given again
    #[arg(long = "limit", value_name = "NAME:LIMITS")]
    limits: Vec<Limit>,
    /// Images by name
    #[arg(required = true, value_name = "NAME=ELF")]
    images: Vec<Named>,
}

/// `NAME=ELF`.
#[derive(Clone)]
struct Named {
    name: String,
    elf: PathBuf,
}

impl FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, elf) = text.split_once('=').ok_or("is not NAME=ELF")?;
        if name.is_empty() || elf.is_empty() || name.contains(['|', '`']) || name.contains(char::is_control) {
            return Err("is not NAME=ELF".to_owned());
        }
        Ok(Self { name: name.to_owned(), elf: elf.into() })
    }
}

/// `NAME:flash=BYTES,ram=BYTES`.
#[derive(Clone)]
struct Limit {
    name: String,
    flash: Option<u64>,
    ram: Option<u64>,
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, limits) = text.split_once(':').ok_or("is not NAME:flash=BYTES,ram=BYTES")?;
        let mut limit = Self { name: name.to_owned(), flash: None, ram: None };
        for part in limits.split(',') {
            let (key, value) = part.split_once('=').ok_or_else(|| format!("{part:?} is not KEY=BYTES"))?;
            let bytes = value.parse().map_err(|error| format!("{part:?}: {error}"))?;
            match key {
                "flash" => limit.flash = Some(bytes),
                "ram" => limit.ram = Some(bytes),
                _ => return Err(format!("{key:?} is neither flash nor ram")),
            }
        }
        Ok(limit)
    }
}

/// How a command ended, if not well.
enum Failure {
    /// What was checked is not so.
    Check(String),
    /// Usage or input is wrong.
    Bad(String),
}

fn main() -> ExitCode {
    let outcome = match &Arguments::parse().command {
        Command::Uf2 { elf, out } => to_uf2(elf, out),
        Command::Table(arguments) => table(arguments),
        Command::Panics { elf, allow, never } => find_panics(elf, allow.as_deref(), never),
    };
    let (code, message) = match outcome {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Check(message)) => (1, message),
        Err(Failure::Bad(message)) => (2, message),
    };
    // Failing to write to a closed stderr changes nothing.
    let _ = writeln!(std::io::stderr(), "images: {message}");
    ExitCode::from(code)
}

/// To standard output; a reader that has gone away has seen enough.
fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|error| Failure::Bad(format!("{}: {error}", path.display())))
}

fn text_of(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| Failure::Bad(format!("{}: {error}", path.display())))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    fs::write(path, bytes).map_err(|error| Failure::Bad(format!("cannot write {}: {error}", path.display())))
}

/// What `use_it` makes of the program in `path`.
fn with_program<T>(
    path: &Path,
    use_it: impl FnOnce(&Program<'_>) -> Result<T, ElfError>,
) -> Result<T, Failure> {
    let bytes = bytes_of(path)?;
    Program::read(&bytes)
        .and_then(|program| use_it(&program))
        .map_err(|error| Failure::Bad(format!("{}: {error}", path.display())))
}

fn to_uf2(elf: &Path, out: &Path) -> Result<(), Failure> {
    let file = with_program(elf, |program| program.uf2())?;
    write(out, &file)?;
    let pages = file.len() / uf2::BLOCK;
    say(&format!("{}: {pages} pages, {} bytes of flash\n", out.display(), pages * uf2::PAYLOAD));
    Ok(())
}

fn table(arguments: &TableArguments) -> Result<(), Failure> {
    let measure = |image: &Named| with_program(&image.elf, |program| Row::measure(&image.name, program));
    let rows: Vec<Row> = arguments.images.iter().map(measure).collect::<Result<_, _>>()?;
    say(&rendered(&rows));
    let mut wrong = Vec::new();
    for limit in &arguments.limits {
        let row = rows.iter().find(|row| row.name == limit.name);
        let row = row.ok_or_else(|| Failure::Bad(format!("--limit {}: no such image", limit.name)))?;
        for (what, is, most) in [("flash", row.flash(), limit.flash), ("RAM", row.ram(), limit.ram)] {
            if let Some(most) = most.filter(|most| is > *most) {
                let name = &row.name;
                wrong.push(format!(
                    "{name}: {is} bytes of {what}, {} more than the {most} allowed",
                    is - most
                ));
            }
        }
    }
    if let Some(path) = &arguments.check {
        let found = disagreements(&text_of(path)?, &rows);
        if !found.is_empty() {
            let path = path.display();
            wrong.extend(found.into_iter().map(|line| format!("{path}: {line}")));
            let images: Vec<String> = arguments
                .images
                .iter()
                .map(|image| format!("{}={}", image.name, image.elf.display()))
                .collect();
            wrong.push(format!("write it again: images table --write {path} {}", images.join(" ")));
        }
    }
    if !wrong.is_empty() {
        return Err(Failure::Check(wrong.join("\nimages: ")));
    }
    if let Some(path) = &arguments.write {
        let former = if path.exists() { text_of(path)? } else { String::new() };
        write(path, replaced(&former, &rows).as_bytes())?;
    }
    Ok(())
}

fn find_panics(elf: &Path, allow: Option<&Path>, never: &[String]) -> Result<(), Failure> {
    let allowed = match allow {
        Some(path) => panics::allowed(&text_of(path)?)
            .map_err(|error| Failure::Bad(format!("{}:{error}", path.display())))?,
        None => Vec::new(),
    };
    let functions = with_program(elf, |program| program.functions())?;
    let mut refused = 0;
    for function in functions.iter().filter(|function| panics::is_panic(function)) {
        match allowed.iter().find(|allowed| allowed.name == *function) {
            Some(allowed) => say(&format!("allowed  {function}: {}\n", allowed.reason)),
            None => {
                refused += 1;
                say(&format!("PANIC    {function}\n"));
            }
        }
    }
    for allowed in allowed.iter().filter(|allowed| !functions.contains(&allowed.name)) {
        say(&format!("absent   {}: it need not be allowed\n", allowed.name));
    }
    if !never.is_empty() {
        let sites = with_program(elf, |program| sites::calls(elf, program, panics::is_panic))?;
        for Site { address, function, package, place } in &sites {
            let refuse = never.contains(package) || package.is_empty();
            refused += u32::from(refuse);
            let word = if refuse { "PANIC  " } else { "called " };
            say(&format!("{word}  {address:#010x} {function} from {package}: {place}\n"));
        }
    }
    if refused > 0 {
        let elf = elf.display();
        return Err(Failure::Check(format!(
            "{elf}: {refused} functions or calls of the panic machinery that may not be"
        )));
    }
    Ok(())
}
