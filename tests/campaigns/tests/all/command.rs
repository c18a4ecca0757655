//! `flotilla campaign`, with `flotilla-campaign` beside it and without.

use std::fs;
use std::process::Command;

use crate::program::{PROGRAM, both, output, said};

#[test]
fn flotilla_starts_the_program_beside_it_or_says_how_to_make_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let flotilla = folder.path().join("flotilla");
    fs::copy(env!("CARGO_BIN_EXE_flotilla-that-campaigns"), &flotilla).expect("copied");
    let campaign = |arguments: &[&str]| {
        let mut command = Command::new(&flotilla);
        command
            .arg("campaign")
            .args(arguments)
            .env("PATH", folder.path().join("none"))
            .current_dir(folder.path());
        command
    };
    let missing = output(&mut campaign(&["--help"]));
    assert_eq!(missing.status.code(), Some(1));
    assert!(both(&missing).contains("cargo build --release -p campaign"), "{}", both(&missing));
    fs::copy(PROGRAM, folder.path().join("flotilla-campaign")).expect("copied");
    let help = said(&mut campaign(&["--help"]));
    assert!(help.contains("flotilla campaign loss.toml --shard 3/8"), "{help}");
    // Exit codes are those of the other program.
    fs::write(folder.path().join("c.toml"), "name = \"c\"\nscenarios = [\"holonomic-1\"]\nseeds = 0\n")
        .expect("written");
    for (arguments, told) in [
        (["c.toml", "--jobs", "1"], "flotilla: c.toml:3: seeds: 1 to 1000000 of them"),
        (["c.toml", "--shard", "9/8"], "must be two numbers such as 3/8"),
        (["merge", "none", "--partial"], "none: is no campaign's folder: campaign.json: "),
    ] {
        let bad = output(&mut campaign(&arguments));
        assert_eq!(bad.status.code(), Some(2), "{arguments:?}: {}", both(&bad));
        assert!(both(&bad).contains(told), "{}", both(&bad));
    }
}
