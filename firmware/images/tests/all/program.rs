//! `images` through the binary: what it says, what it leaves, and its exit codes.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::made::usual;
use images::uf2;
use tempfile::{TempDir, tempdir};

/// Exit code, standard output and standard error of `images` in `folder`.
fn images(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_images"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the binary starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("it exits"), text(output.stdout), text(output.stderr))
}

const PANIC: &str = "_ZN4core9panicking5panic17h0123456789abcdefE";

/// A folder with a program in it.
fn with_program(functions: &[&str]) -> TempDir {
    let folder = tempdir().expect("a folder");
    fs::write(folder.path().join("a.elf"), usual(functions)).expect("a file");
    folder
}

#[test]
fn a_program_becomes_uf2() {
    let folder = with_program(&["main"]);
    let (code, out, err) = images(folder.path(), &["uf2", "a.elf", "a.uf2"]);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "a.uf2: 5 pages, 1280 bytes of flash\n", ""));
    let file = fs::read(folder.path().join("a.uf2")).expect("a file");
    assert_eq!(uf2::read(&file).expect("UF2").1.len(), 5);
}

#[test]
fn bad_usage_and_input_is_two() {
    let folder = with_program(&[]);
    fs::write(folder.path().join("text"), "no program").expect("a file");
    for (arguments, expected) in [
        (&["uf2", "none.elf", "a.uf2"][..], "images: none.elf: No such file"),
        (&["uf2", "text", "a.uf2"], "images: text: is no ELF program of 32 bits"),
        (&["uf2", "a.elf", "none/a.uf2"], "images: cannot write none/a.uf2: "),
        (&["panics", "a.elf"], "images: a.elf: has no symbols: it was stripped\n"),
        (
            &["panics", "a.elf", "--allow", "text"],
            "images: text:1: \"no program\": a line is NAME # REASON\n",
        ),
        (&["table", "a=a.elf", "--limit", "b:flash=1"], "images: --limit b: no such image\n"),
        (&["table", "a=a.elf", "--check", "none.md"], "images: none.md: No such file"),
        (&["table", "a.elf"], "error: invalid value 'a.elf'"),
        (&["table", "a=a.elf", "--limit", "a:flesh=1"], "error: invalid value 'a:flesh=1'"),
        (&["table", "a=a.elf", "--limit", "a:flash=x"], "error: invalid value 'a:flash=x'"),
        (&["table"], "error: "),
        (&[], "Turn linked firmware into UF2 files"),
    ] {
        let (code, _, err) = images(folder.path(), arguments);
        assert_eq!(code, 2, "{arguments:?}: {err}");
        assert!(err.starts_with(expected), "{arguments:?}: {err}");
        assert!(!folder.path().join("a.uf2").exists());
    }
}

#[test]
fn budgets_and_the_table_are_kept_or_it_is_one() {
    let folder = with_program(&["main"]);
    let at = |arguments: &[&str]| images(folder.path(), arguments);
    let (code, table, err) =
        at(&["table", "--write", "sizes.md", "--limit", "a:flash=940,ram=4064", "a=a.elf"]);
    assert_eq!((code, err.as_str()), (0, ""));
    assert_eq!(fs::read_to_string(folder.path().join("sizes.md")).expect("a file"), table);
    assert_eq!(at(&["table", "--check", "sizes.md", "a=a.elf"]), (0, table.clone(), String::new()));

    let (code, out, err) = at(&["table", "--limit", "a:flash=900,ram=4000", "a=a.elf"]);
    assert_eq!((code, &out), (1, &table));
    assert_eq!(
        err,
        "images: a: 940 bytes of flash, 40 more than the 900 allowed\n\
         images: a: 4064 bytes of RAM, 64 more than the 4000 allowed\n"
    );
    // What is too large is not written down as it should be.
    let spoilt = table.replace(" 3000 |", " 300 |");
    fs::write(folder.path().join("sizes.md"), &spoilt).expect("a file");
    assert_eq!(at(&["table", "--write", "sizes.md", "--limit", "a:ram=1", "a=a.elf"]).0, 1);
    let (code, _, err) = at(&["table", "--check", "sizes.md", "a=a.elf"]);
    assert_eq!(code, 1);
    assert_eq!(
        err,
        "images: sizes.md: a: .bss is 3000 bytes, the table says 300\n\
         images: write it again: images table --write sizes.md a=a.elf\n"
    );
}

#[test]
fn panics_are_found_and_allowed_with_a_reason() {
    let clean = with_program(&["main", "_ZN4core3fmt5write17h0123456789abcdefE"]);
    assert_eq!(images(clean.path(), &["panics", "a.elf"]), (0, String::new(), String::new()));

    let folder = with_program(&["main", "rust_begin_unwind", PANIC]);
    let (code, out, err) = images(folder.path(), &["panics", "a.elf"]);
    assert_eq!((code, out.as_str()), (1, "PANIC    core::panicking::panic\nPANIC    rust_begin_unwind\n"));
    assert_eq!(err, "images: a.elf: 2 functions or calls of the panic machinery that may not be\n");

    let list = folder.path().join("panics.txt");
    fs::write(&list, "core::panicking::panic # a driver\nrust_begin_unwind # its handler\n").expect("a file");
    let (code, out, err) = images(folder.path(), &["panics", "a.elf", "--allow", "panics.txt"]);
    assert_eq!((code, err.as_str()), (0, ""));
    assert_eq!(out, "allowed  core::panicking::panic: a driver\nallowed  rust_begin_unwind: its handler\n");

    fs::write(&list, "core::panicking::panic # a driver\ncore::gone # was there\n").expect("a file");
    let (code, out, _) = images(folder.path(), &["panics", "a.elf", "--allow", "panics.txt"]);
    assert_eq!(code, 1);
    let expected = "allowed  core::panicking::panic: a driver\nPANIC    rust_begin_unwind\n\
                    absent   core::gone: it need not be allowed\n";
    assert_eq!(out, expected);
}
