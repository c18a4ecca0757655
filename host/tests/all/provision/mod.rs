//! `flotilla provision` through the binary: what is in its files, who may read them, what it says and what it refuses.
#![cfg(unix)]

mod mistakes;
mod showing;

use std::fs::{self, Permissions};
use std::net::Ipv4Addr;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::said::{done, mode, refused, text};
use images::uf2::{self, Family};
use link::key_file::KeyFile;
use protocol::configuration::{Host, IMAGE_MAX, Own, Robot};
use protocol::units::{Radians, RadiansPerSecond};
use protocol::{Configuration, ModuleId};
use tempfile::{TempDir, tempdir};

const PASSPHRASE: &str = "correct horse battery";
/// A Modboat without a mistake; line 2 is the network's name, 5 the table of the encoder.
const MODBOAT: &str = "[network]\nssid = \"tank\"\npassphrase = \"correct horse battery\"\nhost = \"192.168.4.1:4870\"\n\
                       [modboat.encoder]\ncounts_per_turn = 4800\n";
/// An ROV without a mistake; line 4 is its first thruster, 6 the second.
const ROV: &str = "[network]\nhost = \"192.168.4.1:4870\"\n[rov]\n[[rov.thruster]]\noutput = 1\n[[rov.thruster]]\n\
                   output = 0\nreversed = true\n";

/// `flotilla` in `folder`, which is also the user's home.
fn flotilla(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flotilla"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("XDG_CONFIG_HOME")
        .env("HOME", folder)
        .stdin(Stdio::null())
        .output()
        .expect("the binary starts")
}

fn provision(folder: &Path, arguments: &[&str]) -> Output {
    flotilla(folder, &[&["provision"], arguments].concat())
}

/// A folder with a fleet's key where commands look for it, and `m.toml`.
fn with(text: &str) -> TempDir {
    let folder = tempdir().expect("a folder");
    done(&flotilla(folder.path(), &["keygen"]));
    fs::write(folder.path().join("m.toml"), text).expect("a file");
    folder
}

/// The image in a file, and where it goes if the file says so.
fn image(path: &Path) -> (Vec<u8>, Option<u32>) {
    let file = fs::read(path).expect("a file");
    if !uf2::is_uf2(&file) {
        return (file, None);
    }
    let (family, blocks) = uf2::read(&file).expect("UF2");
    assert_eq!(family, Family::ABSOLUTE);
    let first = blocks.first().expect("a block").address;
    let pages = blocks.iter().zip((first..).step_by(256));
    (
        pages.flat_map(|(block, at)| (block.address == at).then_some(*block.payload)).flatten().collect(),
        Some(first),
    )
}

fn configuration(path: &Path) -> Configuration {
    Configuration::read(&image(path).0).expect("a configuration")
}

/// The files of a folder but those that were there before.
fn left(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("it").file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().expect("UTF-8")).collect();
    names.retain(|name| name != ".config" && name != "m.toml");
    names.sort();
    names
}

/// Nothing that was said has a part of the passphrase, or eight digits of the module's key, in whatever base or order.
#[track_caller]
fn assert_silent(output: &Output, configuration: &Configuration) {
    let said = text(&output.stdout) + &text(&output.stderr);
    for word in ["correct", "horse", "battery"] {
        assert!(!said.contains(word), "{said}");
    }
    let key = configuration.key.bytes();
    for four in key.windows(4) {
        let hex: String = four.iter().map(|byte| format!("{byte:02x}")).collect();
        assert!(!said.to_lowercase().contains(&hex), "{said}");
    }
    let list: Vec<String> = key.iter().map(u8::to_string).collect();
    assert!(!said.contains(&list[..4].join(", ")), "{said}");
}

#[test]
fn a_modboats_file_holds_its_configuration_where_memory_x_says() {
    let folder = with(MODBOAT);
    let output = provision(folder.path(), &["--id", "3", "--from", "m.toml"]);
    let said = done(&output);
    let path = folder.path().join("module-3.uf2");
    let fleet = KeyFile::read(&folder.path().join(".config/flotilla/fleet.key")).expect("a key");
    assert_eq!(
        said,
        format!(
            "module-3.uf2: module 3 of fleet {}, a Modboat, in \"tank\" at DHCP, host 192.168.4.1:4870\n\
             next: hold BOOTSEL while you plug a board in, and copy module-3.uf2 to the drive RP2350; then delete it: \
             it holds the module's key\n",
            fleet.fleet()
        )
    );
    // Read here by other means than there.
    let memory = include_str!("../../../../memory.x");
    let line = memory.lines().find(|line| line.trim_start().starts_with("CONFIGURATION ")).expect("a region");
    let origin = line.split("0x").nth(1).expect("an origin").split(',').next().expect("digits");
    assert_eq!(image(&path).1, Some(u32::from_str_radix(origin, 16).expect("hexadecimal")));

    let configuration = configuration(&path);
    assert_eq!((configuration.module, configuration.fleet), (ModuleId(3), fleet.fleet()));
    assert_eq!(configuration.key.bytes(), fleet.module(ModuleId(3)).bytes());
    let network = &configuration.network;
    assert_eq!((&network.ssid[..], network.passphrase.bytes()), (&b"tank"[..], PASSPHRASE.as_bytes()));
    assert_eq!((network.host, network.own), (Host { address: [192, 168, 4, 1], port: 4870 }, Own::Dhcp));
    let Robot::Modboat(tail) = &configuration.robot else { panic!("{configuration:?}") };
    assert_eq!((tail.limits.amplitude_max, tail.servo.speed_max), (Radians(2.6), RadiansPerSecond(15.0)));
    assert_eq!(tail.encoder.counts_per_turn, 4800);
    assert_silent(&output, &configuration);
}

#[test]
fn an_rovs_file_may_be_bare() {
    let folder = with(ROV);
    let said = done(&provision(folder.path(), &["--id", "7", "--from", "m.toml", "--out", "seven.bin"]));
    let path = folder.path().join("seven.bin");
    assert!(
        said.ends_with(
            "\nnext: probe-rs download --chip RP235x --binary-format bin --base-address 0x101ff000 seven.bin, and probe-rs \
             reset --chip RP235x; then delete it: it holds the module's key\n"
        ),
        "{said}"
    );
    assert!(said.contains("an ROV, on a wire at DHCP"), "{said}");
    let (bytes, place) = image(&path);
    assert!(place.is_none() && bytes.starts_with(b"FLOT") && bytes.len() < IMAGE_MAX);
    let Robot::Rov(rov) = configuration(&path).robot else { panic!("no ROV") };
    let wiring: Vec<(u8, bool)> = rov.thrusters.iter().map(|t| (t.output, t.reversed)).collect();
    assert_eq!(wiring, [(1, false), (0, true)]);
}

#[test]
fn what_ships_needs_no_more_than_a_network() {
    let folder = with("");
    fs::write(folder.path().join("wifi.txt"), format!("{PASSPHRASE}\n")).expect("a file");
    fs::set_permissions(folder.path().join("wifi.txt"), Permissions::from_mode(0o600))
        .expect("its owner may");
    let host = ["--host", "192.168.4.1:4870"];
    let arguments = [
        &["--id", "3", "--from", "modboat"][..],
        &host,
        &["--ssid", "tank", "--passphrase-file", "wifi.txt"],
    ];
    done(&provision(folder.path(), &arguments.concat()));
    let made = configuration(&folder.path().join("module-3.uf2"));
    assert_eq!(made.network.passphrase.bytes(), PASSPHRASE.as_bytes());
    let arguments = [&["--id", "4", "--from", "rov"][..], &host].concat();
    done(&provision(folder.path(), &arguments));
    assert!(matches!(configuration(&folder.path().join("module-4.uf2")).robot, Robot::Rov(_)));
    for name in ["modboat", "rov"] {
        let said = refused(&provision(folder.path(), &["--id", "5", "--from", name]));
        assert!(said.starts_with(&format!("{name}.toml:")), "{said}");
        assert!(said.contains("[network] host is missing: write host = \"ADDRESS:PORT\""), "{said}");
    }
}

#[test]
fn several_modules_have_a_file_and_an_address_each() {
    let folder = with(&MODBOAT.replace("ssid", "address = \"192.168.4.{id}/24\"\nssid"));
    let said = done(&provision(folder.path(), &["--id", "2-4,9,3", "--from", "m.toml", "--out", "out/"]));
    assert_eq!(said.lines().count(), 5, "{said}");
    assert!(said.contains("copy its file to the drive"), "{said}");
    assert_eq!(
        left(&folder.path().join("out")),
        ["module-2.uf2", "module-3.uf2", "module-4.uf2", "module-9.uf2"]
    );
    for id in [2, 3, 4, 9] {
        let made = configuration(&folder.path().join(format!("out/module-{id}.uf2")));
        let own = Own::Static { address: Ipv4Addr::new(192, 168, 4, id).octets(), prefix: 24, gateway: None };
        assert_eq!((made.module, made.network.own), (ModuleId(id.into()), own));
    }
    // One that is there already stops all of them; and bare ones are others.
    let arguments = ["--id", "4-6", "--from", "m.toml", "--out", "out"];
    let said = refused(&provision(folder.path(), &arguments));
    assert!(said.starts_with("out/module-4.uf2: exists already"), "{said}");
    assert_eq!(left(&folder.path().join("out")).len(), 4);
    done(&provision(folder.path(), &[&arguments[..], &["--bin"]].concat()));
    done(&provision(folder.path(), &[&arguments[..], &["--force"]].concat()));
    assert_eq!(left(&folder.path().join("out")).len(), 9);
}

#[test]
fn its_files_are_their_owners_alone_and_are_not_replaced() {
    let folder = with(MODBOAT);
    let arguments = ["--id", "3", "--from", "m.toml", "--out", "new/a.uf2"];
    done(&provision(folder.path(), &arguments));
    let path = folder.path().join("new/a.uf2");
    assert_eq!((mode(&path), mode(path.parent().expect("a folder"))), (0o600, 0o700));
    let before = fs::read(&path).expect("a file");
    let said = refused(&provision(folder.path(), &arguments));
    assert!(said.starts_with("new/a.uf2: exists already") && said.contains("--force"), "{said}");
    assert_eq!(fs::read(&path).expect("a file"), before);
    fs::set_permissions(&path, Permissions::from_mode(0o666)).expect("its owner may");
    done(&provision(folder.path(), &[&arguments[..], &["--force"]].concat()));
    assert_eq!((mode(&path), left(&folder.path().join("new"))), (0o600, vec!["a.uf2".to_owned()]));
    symlink("dear", folder.path().join("link.uf2")).expect("a link");
    let said = refused(&provision(
        folder.path(),
        &["--id", "3", "--from", "m.toml", "--out", "link.uf2", "--force"],
    ));
    assert!(said.contains("symbolic link") && !folder.path().join("dear").exists(), "{said}");
}

#[test]
fn keys_are_looked_for_as_elsewhere() {
    let folder = with(MODBOAT);
    done(&flotilla(folder.path(), &["keygen", "--module", "3", "--out", "three.key"]));
    let own = ["--from", "m.toml", "--key", "three.key", "--id"];
    done(&provision(folder.path(), &[&own[..], &["3"]].concat()));
    for (id, expected) in
        [("4", "three.key: is the key of module 3, not of module 4"), ("3-4", "three.key: is the key")]
    {
        let said = refused(&provision(folder.path(), &[&own[..], &[id, "--force"]].concat()));
        assert!(said.starts_with(expected), "{said}");
    }
    let said = refused(&provision(folder.path(), &["--from", "m.toml", "--id", "5", "--key", "none.key"]));
    assert_eq!(said, "none.key: no such key file: run `flotilla keygen` first");
    assert_eq!(left(folder.path()), ["module-3.uf2", "three.key"]);
}
