//! `flotilla keygen` through the binary: files that only their owner reads, and no digit of a key anywhere else.
#![cfg(unix)]

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::said::{done, mode, refused, text};
use link::key_file::KeyFile;
use protocol::ModuleId;
use tempfile::{TempDir, tempdir};

/// `flotilla keygen` in `folder`, which is also the user's home, under this umask.
fn keygen_under(umask: &str, folder: &Path, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", "umask \"$0\" && exec \"$@\"", umask, env!("CARGO_BIN_EXE_flotilla"), "keygen"])
        .args(arguments)
        .current_dir(folder)
        .env_remove("XDG_CONFIG_HOME")
        .env("HOME", folder)
        .stdin(Stdio::null())
        .output()
        .expect("the binary starts")
}

fn keygen(folder: &Path, arguments: &[&str]) -> Output {
    keygen_under("022", folder, arguments)
}

/// The digits of the key in a file.
fn digits(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a file");
    let (_, rest) = text.split_once("\nkey = \"").expect("a key");
    let digits = rest.split('"').next().expect("digits").to_owned();
    assert_eq!(digits.len(), 64);
    digits
}

/// Nothing that was said has eight digits of the key in a row.
#[track_caller]
fn assert_silent(outputs: &[Output], key: &str) {
    for output in outputs {
        let said = (text(&output.stdout) + &text(&output.stderr)).to_lowercase();
        for k in 0..=key.len() - 8 {
            assert!(!said.contains(&key[k..k + 8]), "digits of the key in: {said}");
        }
    }
}

/// A folder, and a fleet's key in it.
fn with_fleet() -> (TempDir, PathBuf) {
    let folder = tempdir().expect("a folder");
    done(&keygen(folder.path(), &["--out", "fleet.key"]));
    let path = folder.path().join("fleet.key");
    (folder, path)
}

#[test]
fn a_key_is_its_owners_alone_whatever_the_umask() {
    for umask in ["000", "022", "027", "077", "0277", "0777"] {
        let folder = tempdir().expect("a folder");
        done(&keygen_under(umask, folder.path(), &["--out", "fleet.key"]));
        let fleet = folder.path().join("fleet.key");
        assert_eq!(mode(&fleet), 0o600, "umask {umask}");
        KeyFile::read(&fleet).expect("a key");
        done(&keygen_under(umask, folder.path(), &["--module", "3", "--from", "fleet.key"]));
        assert_eq!(mode(&folder.path().join("module-3.key")), 0o600, "umask {umask}");
        fs::set_permissions(&fleet, Permissions::from_mode(0o666)).expect("its owner may");
        done(&keygen_under(umask, folder.path(), &["--out", "fleet.key", "--force"]));
        assert_eq!(mode(&fleet), 0o600, "umask {umask}, replaced");
    }
}

#[test]
fn without_a_name_it_goes_where_the_others_look() {
    let home = tempdir().expect("a folder");
    let said = done(&keygen(home.path(), &[]));
    let path = home.path().join(".config/flotilla/fleet.key");
    let key = KeyFile::read(&path).expect("a key");
    assert!(said.contains(path.to_str().expect("UTF-8")), "{said}");
    assert!(said.contains(&key.fleet().to_string()), "{said}");
    assert_eq!(said.lines().count(), 2, "{said}");
    assert!(!said.contains("--key"), "{said}");
    assert_eq!((mode(&path), mode(path.parent().expect("a folder"))), (0o600, 0o700));
    // A module's stands beside it.
    done(&keygen(home.path(), &["--module", "12"]));
    let module = KeyFile::read_module(&path.with_file_name("module-12.key")).expect("a key");
    assert_eq!((module.id, module.fleet), (ModuleId(12), key.fleet()));
}

#[test]
fn nothing_is_replaced_unless_told() {
    let (folder, path) = with_fleet();
    let before = fs::read(&path).expect("a file");
    let fleet = KeyFile::read(&path).expect("a key").fleet();
    let again = refused(&keygen(folder.path(), &["--out", "fleet.key"]));
    assert!(again.starts_with("fleet.key: exists already") && again.contains("--force"), "{again}");
    assert_eq!(fs::read(&path).expect("a file"), before);
    let said = done(&keygen(folder.path(), &["--out", "fleet.key", "--force"]));
    let after = KeyFile::read(&path).expect("a key").fleet();
    assert_ne!(after, fleet);
    assert!(said.contains(&after.to_string()), "{said}");
    // A module's key never takes the place of the fleet's.
    let before = fs::read(&path).expect("a file");
    for force in [&["--force"][..], &[]] {
        let arguments = [&["--module", "3", "--from", "fleet.key", "--out", "fleet.key"], force].concat();
        refused(&keygen(folder.path(), &arguments));
        assert_eq!(fs::read(&path).expect("a file"), before);
    }
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing else is left");
}

#[test]
fn nothing_is_written_through_a_link() {
    let folder = tempdir().expect("a folder");
    let dear = folder.path().join("dear");
    fs::write(&dear, "dear").expect("a file");
    for (name, target) in [("there", "dear"), ("gone", "nowhere")] {
        symlink(target, folder.path().join(name)).expect("a link");
        for arguments in [&["--out", name][..], &["--out", name, "--force"]] {
            let said = refused(&keygen(folder.path(), arguments));
            assert!(said.contains("symbolic link"), "{said}");
        }
    }
    assert_eq!(fs::read_to_string(&dear).expect("a file"), "dear");
    assert!(!folder.path().join("nowhere").exists());
}

#[test]
fn a_key_that_others_can_read_is_refused_with_its_mode() {
    let (folder, path) = with_fleet();
    for (bad, shown) in [(0o644, "0644"), (0o640, "0640"), (0o602, "0602")] {
        fs::set_permissions(&path, Permissions::from_mode(bad)).expect("its owner may");
        let output = keygen(folder.path(), &["--module", "3", "--from", "fleet.key"]);
        let said = refused(&output);
        assert!(said.starts_with("fleet.key: ") && said.contains(shown), "{said}");
        assert!(said.contains("chmod 600 fleet.key"), "{said}");
        assert_silent(&[output], &digits(&path));
        assert!(!folder.path().join("module-3.key").exists());
    }
}

#[test]
fn a_modules_key_is_the_protocols() {
    let (folder, path) = with_fleet();
    let said = done(&keygen(folder.path(), &["--module", "3", "--from", "fleet.key", "--out", "three"]));
    let fleet = KeyFile::read(&path).expect("a key");
    let module = KeyFile::read_module(&folder.path().join("three")).expect("a key");
    assert_eq!((module.id, module.fleet), (ModuleId(3), fleet.fleet()));
    assert_eq!(module.key.bytes(), fleet.module(ModuleId(3)).bytes());
    assert_ne!(module.key.bytes(), fleet.bytes());
    assert!(
        said.contains("three") && said.contains("module 3") && said.contains(&fleet.fleet().to_string()),
        "{said}"
    );
    // From a module's key no other can be derived.
    let said = refused(&keygen(folder.path(), &["--module", "4", "--from", "three"]));
    assert!(said.contains("module 3 alone"), "{said}");
}

#[test]
fn no_digit_of_a_key_is_ever_said() {
    let folder = tempdir().expect("a folder");
    let path = folder.path().join("fleet.key");
    let at = |arguments: &[&str]| keygen(folder.path(), arguments);
    let mut said = vec![at(&["--out", "fleet.key"])];
    let (key, fleet) = (digits(&path), KeyFile::read(&path).expect("a key").fleet().to_string());
    said.push(at(&["--out", "fleet.key"]));
    said.push(at(&["--module", "3", "--from", "fleet.key"]));
    said.push(at(&["--module", "3", "--from", "fleet.key"]));
    assert_silent(&said[2..], &digits(&folder.path().join("module-3.key")));
    // Spoilt in every way that leaves digits standing somewhere.
    let good = fs::read_to_string(&path).expect("a file");
    for (spoilt, expected) in [
        (good.replace(&key, &key[1..]), "fleet.key:3: key: 63 characters"),
        (good.replace(&key, &format!("{key}0")), "fleet.key:3: key: 65 characters"),
        (good.replace(&key, &format!("{}x", &key[1..])), "fleet.key:3: key: character 64"),
        (good.replace(&format!("\"{key}\""), &key), "fleet.key:3: "),
        (good.replace(&format!("{key}\""), &key), "fleet.key:3: "),
        (good.replace(&format!("key = \"{key}\""), &format!("x{key} = 1")), "fleet.key:3: unknown key"),
        (good.replace(&fleet, &key), "fleet.key:2: fleet: 64 characters"),
        (good.replace(&fleet, "00000000"), "fleet.key:2: fleet = \"00000000\""),
        (format!("{good}[[{key}]]\n"), "fleet.key:4: unknown key"),
        (key.clone(), "fleet.key:1: "),
    ] {
        fs::write(&path, &spoilt).expect("its owner may");
        let output = at(&["--module", "4", "--from", "fleet.key"]);
        let line = refused(&output);
        assert!(line.starts_with(expected), "{line}\nexpected {expected}");
        said.push(output);
    }
    assert_silent(&said, &key);
}

#[test]
fn without_a_fleets_key_there_is_no_modules() {
    let home = tempdir().expect("a folder");
    let said = refused(&keygen(home.path(), &["--module", "3"]));
    assert!(
        said.contains(".config/flotilla/fleet.key: no such key file: run `flotilla keygen` first"),
        "{said}"
    );
    for arguments in [&["--module", "0"][..], &["--module", "1025"], &["--from", "fleet.key"]] {
        let output = keygen(home.path(), arguments);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{output:?}");
    }
    assert_eq!(fs::read_dir(home.path()).expect("a folder").count(), 0, "nothing is left");
}
