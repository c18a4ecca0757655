use std::fs;
#[cfg(unix)]
use std::os::unix::fs::{PermissionsExt, symlink};

use tempfile::tempdir;

use super::*;

const KEY: [u8; 32] = [0xa5; 32];

fn fleet_text() -> String {
    text::of_fleet(&FleetKey::new(KEY)).to_string()
}

/// What is wrong with a file that has this text, mode 0600.
#[track_caller]
fn complaint(text: impl AsRef<[u8]>) -> String {
    let folder = tempdir().unwrap();
    let path = folder.path().join("k");
    fs::write(&path, text).unwrap();
    #[cfg(unix)]
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    let error = KeyFile::credentials(&path, ModuleId(1)).unwrap_err();
    for shown in [format!("{error}"), format!("{error:?}")] {
        assert!(!shown.contains("a5a5a5"), "{shown}");
    }
    error.to_string().replace(&format!("{}", folder.path().display()), "").trim_start_matches('/').to_owned()
}

#[test]
fn what_was_written_is_read() {
    let folder = tempdir().unwrap();
    let (fleet, module) = (folder.path().join("new").join("fleet.key"), folder.path().join("module-3.key"));
    let key = KeyFile::create(&fleet, false).unwrap();
    assert_eq!(KeyFile::read(&fleet).unwrap().bytes(), key.bytes());
    let written = KeyFile::create_module(&module, &key, ModuleId(3), false).unwrap();
    let read = KeyFile::read_module(&module).unwrap();
    assert_eq!((read.id, read.fleet), (ModuleId(3), key.fleet()));
    assert_eq!(read.key.bytes(), key.module(ModuleId(3)).bytes());
    assert_eq!(read.key.bytes(), written.key.bytes());
    assert_ne!(read.key.bytes(), key.bytes());
    // Either will do for a module, if it is that module's.
    for path in [&fleet, &module] {
        let found = KeyFile::credentials(path, ModuleId(3)).unwrap();
        assert_eq!((found.id, found.fleet, found.key.bytes()), (read.id, read.fleet, read.key.bytes()));
    }
    let other = KeyFile::credentials(&fleet, ModuleId(4)).unwrap();
    assert_ne!(other.key.bytes(), read.key.bytes());
    assert!(matches!(
        KeyFile::credentials(&module, ModuleId(4)),
        Err(KeyFileError::OfOther { module: ModuleId(3), asked: ModuleId(4), .. })
    ));
    assert!(matches!(KeyFile::read(&module), Err(KeyFileError::OfModule { module: ModuleId(3), .. })));
    assert!(
        matches!(KeyFile::read_module(&fleet), Err(KeyFileError::OfFleet { fleet, .. }) if fleet == key.fleet())
    );
}

#[test]
fn the_format_stays() {
    let key = FleetKey::new(KEY);
    let digits = "a5".repeat(32);
    let fleet = key.fleet();
    assert_eq!(
        fleet_text(),
        format!(
            "# Flotilla fleet key. Its holder commands the fleet; keep it to yourself.\n\
             fleet = \"{fleet}\"\nkey = \"{digits}\"\n"
        )
    );
    let credentials = ModuleCredentials { id: ModuleId(3), fleet, key: ModuleKey::new(KEY) };
    assert_eq!(
        text::of_module(&credentials).as_str(),
        format!(
            "# Flotilla key of module 3. Its holder can pass for this module; keep it to yourself.\n\
             module = 3\nfleet = \"{fleet}\"\nkey = \"{digits}\"\n"
        )
    );
    // Order, capitals and comments are the owner's.
    let loose = format!("key = '{}' # mine\n\nfleet = \"{fleet}\"", digits.to_uppercase());
    assert!(matches!(text::parse(loose.as_bytes()).unwrap(), Content::Fleet(read) if read.bytes() == &KEY));
}

#[test]
fn no_key_comes_twice() {
    let folder = tempdir().unwrap();
    let [one, other] =
        ["one", "other"].map(|name| KeyFile::create(&folder.path().join(name), false).unwrap());
    assert_ne!(one.bytes(), other.bytes());
    assert_ne!(one.fleet(), other.fleet());
}

#[test]
fn mistakes_are_named_with_their_line_and_never_with_a_digit() {
    let good = fleet_text();
    let digits = "a5".repeat(32);
    let fleet = FleetKey::new(KEY).fleet().to_string();
    let other = FleetKey::new([1; 32]).fleet().to_string();
    for (text, expected) in [
        (String::new(), "k:1: has no fleet"),
        (good.replace("key = ", "# key = "), "k:1: has no key"),
        (good.replace(&digits, &digits[2..]), "k:3: key: 62 characters where 64 hexadecimal digits"),
        (good.replace(&digits, &format!("{digits}a5")), "k:3: key: 66 characters where 64"),
        (good.replace(&digits, &format!("{}g", &digits[1..])), "k:3: key: character 64 is no hexadecimal"),
        (good.replace(&digits, &format!("ü{}", &digits[1..])), "k:3: key: character 1 is no hexadecimal"),
        (good.replace(&format!("\"{digits}\""), "5"), "k:3: key: must be 64 hexadecimal digits in quotes"),
        (good.replace(&format!("\"{digits}\""), &digits), "k:3: is not TOML"),
        (good.replace(&format!("\"{digits}\""), &format!("[\"{digits}\"]")), "k:3: key: must be 64"),
        (good.replace(&format!("{digits}\""), &digits), "k:3: is not TOML"),
        (
            good.replace(&fleet, &other),
            &format!("k:2: fleet = \"{other}\", but the key is that of fleet {fleet}"),
        ),
        (good.replace(&fleet, &digits), "k:2: fleet: 64 characters where 8 hexadecimal digits"),
        (format!("{good}{digits} = 1\n"), "k:4: unknown key"),
        (format!("{good}\n[{digits}]\n"), "k:5: unknown key"),
        (format!("{good}key = \"{digits}\"\n"), "k:4: is not TOML"),
        (digits.clone(), "k:1: is not TOML"),
        (format!("{good}module = 0\n"), "k:4: module = 0: must be from 1 to 1024"),
        (format!("{good}module = 1025\n"), "k:4: module = 1025: must be from 1 to 1024"),
        (format!("{good}module = -3\n"), "k:4: module: must be a whole number from 1 to 1024"),
        (format!("{good}module = \"{digits}\"\n"), "k:4: module: must be a whole number"),
        (format!("{good}module = 2\n"), "k: is the key of module 2, not of module 1"),
        (format!("\u{feff}{good}module = 2\n"), "k: is the key of module 2, not of module 1"),
        (" ".repeat(5000), "k:1: is longer than 4096 bytes"),
    ] {
        let complaint = complaint(&text);
        assert!(complaint.starts_with(expected), "{complaint}\nexpected {expected}");
    }
    assert!(complaint(b"fleet = \"\n\xff").starts_with("k:2: is not a text in UTF-8"));
}

#[test]
fn nothing_is_replaced_unless_told() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("fleet.key");
    let first = KeyFile::create(&path, false).unwrap();
    assert!(matches!(
        KeyFile::create(&path, false),
        Err(KeyFileError::File(PrivateFileError::Exists { .. }))
    ));
    assert_eq!(KeyFile::read(&path).unwrap().bytes(), first.bytes());
    let second = KeyFile::create(&path, true).unwrap();
    assert_ne!(second.bytes(), first.bytes());
    assert_eq!(KeyFile::read(&path).unwrap().bytes(), second.bytes());
    // A module's key never takes the place of the fleet's, by whatever name.
    let taken =
        KeyFile::create_module(&folder.path().join(".").join("fleet.key"), &second, ModuleId(1), true);
    assert!(matches!(taken, Err(KeyFileError::OfFleet { .. })));
    assert_eq!(KeyFile::read(&path).unwrap().bytes(), second.bytes());
    // What it was written to first is gone.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(matches!(
        KeyFile::create(folder.path(), true),
        Err(KeyFileError::File(PrivateFileError::NotAFile { .. }))
    ));
}

#[test]
fn what_cannot_be_is_said() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("fleet.key");
    let error = KeyFile::read(&path).unwrap_err();
    assert!(matches!(error, KeyFileError::Missing { .. }));
    assert!(
        error.to_string().ends_with("fleet.key: no such key file: run `flotilla keygen` first"),
        "{error}"
    );
    assert!(matches!(
        KeyFile::read(folder.path()),
        Err(KeyFileError::File(PrivateFileError::NotAFile { .. }))
    ));
    fs::write(folder.path().join("file"), "").unwrap();
    let below = folder.path().join("file").join("fleet.key");
    assert!(matches!(
        KeyFile::create(&below, false),
        Err(KeyFileError::File(PrivateFileError::Unwritable { .. }))
    ));
}

#[cfg(unix)]
#[test]
fn only_the_owner_reads() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a").join("b").join("fleet.key");
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o7777;
    KeyFile::create(&path, false).unwrap();
    assert_eq!((mode(&path), mode(path.parent().unwrap())), (0o600, 0o700));
    for bad in [0o644, 0o640, 0o620, 0o604, 0o602, 0o666, 0o777] {
        fs::set_permissions(&path, fs::Permissions::from_mode(bad)).unwrap();
        let error = KeyFile::read(&path).unwrap_err().to_string();
        let expected = format!("mode {bad:04o} lets others than its owner read or write it");
        assert!(error.contains(&expected), "{error}");
        assert!(error.contains(&format!("chmod 600 {}", path.display())), "{error}");
    }
    for good in [0o600, 0o400, 0o700] {
        fs::set_permissions(&path, fs::Permissions::from_mode(good)).unwrap();
        KeyFile::read(&path).unwrap();
    }
    // Whatever mode the one before had.
    fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).unwrap();
    KeyFile::create(&path, true).unwrap();
    assert_eq!(mode(&path), 0o600);
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_a_link() {
    let folder = tempdir().unwrap();
    let [there, gone] = ["there", "gone"].map(|name| folder.path().join(name));
    fs::write(&there, "something dear").unwrap();
    for target in [&there, &gone] {
        let link = folder.path().join("link");
        symlink(target, &link).unwrap();
        for force in [false, true] {
            assert!(matches!(
                KeyFile::create(&link, force),
                Err(KeyFileError::File(PrivateFileError::Link { .. }))
            ));
        }
        fs::remove_file(&link).unwrap();
    }
    assert_eq!(fs::read_to_string(&there).unwrap(), "something dear");
    assert!(!gone.exists());
}

#[test]
fn the_default_is_in_the_users_configuration() {
    let found =
        |config: Option<&str>, home: Option<&str>| default_in(config.map(Into::into), home.map(Into::into));
    assert_eq!(found(Some("/c"), Some("/h")), Some("/c/flotilla/fleet.key".into()));
    for config in [None, Some(""), Some("c")] {
        assert_eq!(found(config, Some("/h")), Some("/h/.config/flotilla/fleet.key".into()));
        assert_eq!(found(config, None), None);
        assert_eq!(found(config, Some("")), None);
    }
}
