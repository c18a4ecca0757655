//! `flotilla provision` through the binary: what is in its files, who may read them, what it says and what it refuses.
#![cfg(unix)]

use std::fs::{self, Permissions};
use std::net::Ipv4Addr;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use host::link::key_file::KeyFile;
use images::uf2::{self, Family};
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

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// What was said on standard output by one that did well.
#[track_caller]
fn done(output: &Output) -> String {
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    text(&output.stdout)
}

/// The one line with which `flotilla` refuses, without its first word.
#[track_caller]
fn refused(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    let said = text(&output.stderr);
    assert_eq!(said.lines().count(), 1, "{said}");
    said.trim_end().strip_prefix("flotilla: ").expect("says who speaks").to_owned()
}

/// A folder with a fleet's key where everybody looks for it, and `m.toml`.
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

fn mode(path: &Path) -> u32 {
    fs::metadata(path).expect("a file").permissions().mode() & 0o7777
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
             whoever has it has the module's key\n",
            fleet.fleet()
        )
    );
    // Read here by other means than there.
    let memory = include_str!("../../memory.x");
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
    assert_eq!((tail.amplitude_max, tail.servo.speed_max), (Radians(2.6), RadiansPerSecond(15.0)));
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
             reset --chip RP235x; then delete it: whoever has it has the module's key\n"
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

#[test]
fn mistakes_in_a_module_file_are_named_with_line_value_and_unit() {
    let boat = |more: &str| format!("{MODBOAT}{more}\n");
    let network = |from: &str, to: &str| MODBOAT.replace(from, to);
    let address = |line: &str| MODBOAT.replace("ssid", &format!("{line}\nssid"));
    let rov = |from: &str, to: &str| ROV.replace(from, to);
    let cases: Vec<(String, &str)> = vec![
        (boat("[modboat.servo]\ntime_constant = 1"), "8: unknown field `time_constant`"),
        (boat("[boat]"), "7: unknown field `boat`"),
        (
            boat("[modboat.servo]\ntime_constant_s = nan"),
            "8: [modboat.servo] time_constant_s = NaN s: must be a finite",
        ),
        (
            boat("[modboat.servo]\nspeed_max_rad_s = -1"),
            "8: [modboat.servo] speed_max_rad_s = -1 rad/s: must be a finite number greater",
        ),
        (boat("[modboat.servo]\nstall_current_a = 1e300"), "8: [modboat.servo] stall_current_a = 1"),
        (boat("[modboat.servo]\nrate_gain = 1e-60"), "8: [modboat.servo] rate_gain = 0 1: must be"),
        (
            boat("[modboat.servo]\ninterval_ms = 0"),
            "8: [modboat.servo] interval_ms = 0 ms: must lie between 0.1 and 100 ms",
        ),
        (boat("[modboat.servo]\nrate_gain = \"much\""), "8: rate_gain = \"much\": invalid type"),
        (
            boat("[modboat.limits]\namplitude_min_rad = 3"),
            "8: [modboat.limits] amplitude_min_rad = 3 rad: must not exceed amplitude_max_rad = 2.6 rad",
        ),
        (
            boat("[modboat.limits]\nperiod_min_s = 11"),
            "8: [modboat.limits] period_min_s = 11 s: must not exceed period_max_s = 10 s",
        ),
        (
            boat("[modboat.limits]\nperiod_max_s = 5000"),
            "8: [modboat.limits] period_max_s = 5000 s: must lie between",
        ),
        (
            boat("zero_counts = 65536"),
            "7: [modboat.encoder] zero_counts = 65536: must be a whole number from 0 to 65535",
        ),
        (network("4800", "-1"), "6: [modboat.encoder] counts_per_turn = -1: must be a whole"),
        (network("4800", "100_000_000"), "6: [modboat.encoder] counts_per_turn = 100000000: must be a whole"),
        (network("4800", "1.5"), "6: counts_per_turn = 1.5: invalid type"),
        (network("counts_per_turn = 4800", ""), "5: [modboat.encoder] counts_per_turn is missing: write"),
        (boat("homing_speed_rad_s = inf"), "7: [modboat.encoder] homing_speed_rad_s = inf rad/s"),
        (boat("[supply]\nlow_v = 7"), "8: [supply] low_v = 7 V: must not exceed recover_v = 6.8 V"),
        (boat("[supply]\nvolts_per_volt = -3"), "8: [supply] volts_per_volt = -3 V/V"),
        (boat("[report]\nevery_ms = 0.5"), "8: [report] every_ms = 0.5 ms: must lie between 1 and 60000 ms"),
        (boat("[rov]"), "7: [rov] stands beside [modboat]: a module is one of them"),
        ("[network]\nhost = \"10.0.0.1:1\"\n".to_owned(), "1: says neither [modboat] nor [rov]"),
        (network("host = \"192.168.4.1:4870\"\n", ""), "1: [network] host is missing: write host = "),
        (
            network("192.168.4.1:4870", "tank.local"),
            "4: [network] host = \"tank.local\": it takes ADDRESS:PORT",
        ),
        (network(":4870", ":0"), "4: [network] host = \"192.168.4.1:0\": port 0"),
        (
            network("192.168.4.1:", "127.0.0.1:"),
            "4: [network] host = \"127.0.0.1:4870\": to the module that is itself",
        ),
        (
            network("192.168.4.1:", "224.0.0.1:"),
            "4: [network] host = \"224.0.0.1:4870\": 224.0.0.1 is nobody's",
        ),
        (network("tank", &"t".repeat(33)), "2: [network] ssid = \"ttt"),
        (network("ssid = \"tank\"\n", ""), "1: [network] has a passphrase, and no ssid"),
        (
            address("address = \"192.168.4.3\""),
            "2: [network] address = \"192.168.4.3\": it takes ADDRESS/BITS",
        ),
        (address("address = \"192.168.4.3/31\""), "2: [network] address = \"192.168.4.3/31\": 31 bits"),
        (
            address("address = \"192.168.4.1/24\""),
            "2: [network] address = \"192.168.4.1/24\": 192.168.4.1 is the host's",
        ),
        (
            address("address = \"192.168.4.255/24\""),
            "2: [network] address = \"192.168.4.255/24\": 192.168.4.255 is the network",
        ),
        (
            address("address = \"10.0.0.3/24\""),
            "2: [network] address = \"10.0.0.3/24\": the host, 192.168.4.1, is outside",
        ),
        (
            address("address = \"10.0.0.3/24\"\ngateway = \"10.0.1.1\""),
            "3: [network] gateway = \"10.0.1.1\": is not in",
        ),
        (address("gateway = \"10.0.0.1\""), "2: [network] gateway = \"10.0.0.1\": without an address"),
        (
            rov("output = 0", "output = 8"),
            "7: [[rov.thruster]] 2: output = 8: must be a whole number from 0 to 7",
        ),
        (
            rov("output = 0", "output = 1"),
            "7: [[rov.thruster]] 2: output = 1: [[rov.thruster]] 1 has it already",
        ),
        (
            rov("[rov]", "[rov]\nframe_rate_hz = 500"),
            "4: [rov] frame_rate_hz = 500 Hz: must lie between 50 and 400 Hz",
        ),
        (rov("[rov]", "[rov]\nslew_n_s = 0"), "4: [rov] slew_n_s = 0 N/s"),
        (
            rov("[rov]", "[rov]\nlease_max_s = -1"),
            "4: [rov] lease_max_s = -1 s: must lie between 0.001 and 60 s",
        ),
        ("[network]\nhost = \"10.0.0.1:1\"\n[rov]\n".to_owned(), "3: [rov] has 0 thrusters: write 1 to 8"),
        ("= 3".to_owned(), "1: "),
        ("\n\n[network".to_owned(), "3: "),
    ];
    let folder = with(MODBOAT);
    for (text, expected) in cases {
        fs::write(folder.path().join("m.toml"), &text).expect("a file");
        let said = refused(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
        assert!(said.starts_with(&format!("m.toml:{expected}")), "{said}\nexpected {expected} of\n{text}");
        assert!(!said.contains("horse"), "{said}");
        assert_eq!(left(folder.path()), [""; 0]);
    }
}

/// However the passphrase is written wrongly, nothing of it is quoted.
#[test]
fn no_passphrase_is_quoted() {
    let folder = with(MODBOAT);
    let written = format!("\"{PASSPHRASE}\"");
    for (wrong, expected) in [
        (
            "\"horse\"",
            "m.toml:3: [network] passphrase: 8 to 63 characters of ASCII make a passphrase, not these 5",
        ),
        ("\"correct hörse\"", "m.toml:3: [network] passphrase: 8 to 63 characters of ASCII"),
        ("[\"horse\"]", "m.toml:3: passphrase, or what stands beside it"),
        ("\"\"\"correct\n horse\"\"\"\nssid = 3", "m.toml:5: "),
        ("correct", "m.toml:3: "),
        ("\"\\horse\"", "m.toml:3: "),
        ("\"horse", "m.toml:3: "),
        (
            "\"correct horse\"\npassphrase_file = \"wifi.txt\"",
            "m.toml:4: [network] passphrase_file: there is a",
        ),
    ] {
        fs::write(folder.path().join("m.toml"), MODBOAT.replace(&written, wrong)).expect("a file");
        let said = refused(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
        assert!(said.starts_with(expected), "{said}\nexpected {expected}");
        assert!(!said.contains("horse") && !said.contains("correct"), "{said}");
    }
    let inline = "network = { ssid = 3, passphrase = \"correct horse\" }\nmodboat = {}\n";
    fs::write(folder.path().join("m.toml"), inline).expect("a file");
    let said = refused(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
    assert!(said.starts_with("m.toml:1: ") && !said.contains("horse"), "{said}");
    // A file of its own is as private as a key.
    fs::write(folder.path().join("wifi.txt"), "short\n").expect("a file");
    let own = MODBOAT.replace("passphrase = \"correct horse battery\"", "passphrase_file = \"wifi.txt\"");
    fs::write(folder.path().join("m.toml"), own).expect("a file");
    for (mode, expected) in [
        (0o644, "wifi.txt: mode 0644 lets others"),
        (0o600, "m.toml:3: [network] passphrase_file = \"wifi.txt\": 8 to 63"),
    ] {
        fs::set_permissions(folder.path().join("wifi.txt"), Permissions::from_mode(mode))
            .expect("its owner may");
        let said = refused(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
        assert!(said.starts_with(expected) && !said.contains("short"), "{said}");
    }
}

#[test]
fn bad_usage_is_refused() {
    let folder = with(MODBOAT);
    let from = ["--from", "m.toml"];
    for (arguments, expected) in [
        (
            &["--id", "3", "--from", "none.toml"][..],
            "none.toml: no such file (the ones that come with the program are",
        ),
        (&["--id", "3", "--from", "m.toml", "--host", "x"], "--host x: it takes ADDRESS:PORT"),
        (&["--id", "3", "--from", "m.toml", "--passphrase-file", "none"], "none: no such file"),
        (&["--id", "3", "--from", "m.toml", "--out", "a.hex"], "--out a.hex: must end with .uf2 or .bin"),
        (&["--id", "3", "--from", "m.toml", "--out", "a.uf2", "--bin"], "--out a.uf2: --bin makes"),
        (&["--id", "1-3", "--from", "m.toml", "--out", "a.uf2"], "--out a.uf2: 3 modules need a folder"),
        (&["--id", "3", "--from", "m.toml", "--out", "m.toml/a.uf2"], "cannot write m.toml/a.uf2: "),
    ] {
        let said = refused(&provision(folder.path(), arguments));
        assert!(said.starts_with(expected), "{said}\nexpected {expected}");
    }
    for ids in ["0", "1025", "-1", "three", "", "3-1", "1,,2", "1-2-3", "1-"] {
        let output = provision(folder.path(), &[&["--id", ids][..], &from].concat());
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{ids}: {output:?}");
    }
    for arguments in [&["--id", "3"][..], &from, &[], &["--show", "m.toml", "--id", "3"]] {
        let output = provision(folder.path(), arguments);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{output:?}");
    }
    let fixed = MODBOAT.replace("ssid", "address = \"192.168.4.13/24\"\nssid");
    fs::write(folder.path().join("m.toml"), fixed).expect("a file");
    let said = refused(&provision(folder.path(), &["--id", "1-3", "--from", "m.toml"]));
    assert_eq!(
        said,
        "m.toml:2: [network] address = \"192.168.4.13/24\": 3 modules cannot all have it: write {id} where their number goes"
    );
    assert_eq!(left(folder.path()), [""; 0]);
}

#[test]
fn what_an_image_holds_is_shown_without_its_secrets() {
    let folder = with(MODBOAT);
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml", "--bin"]));
    let made = configuration(&folder.path().join("module-3.uf2"));
    for (name, place) in [("module-3.uf2", "UF2 for 0x101ff000"), ("module-3.bin", "a bare image")] {
        let output = provision(folder.path(), &["--show", name]);
        let said = done(&output);
        let head = format!(
            "# {name}: {place}\n# module 3 of fleet {}, a Modboat\n# key: there, not shown\n# passphrase: there, not shown\n\n\
             [network]\nssid = \"tank\"\nhost = \"192.168.4.1:4870\"\n",
            made.fleet
        );
        assert!(said.starts_with(&head), "{said}");
        assert!(
            said.contains("\n[modboat.servo]\n") && said.contains("\namplitude_max_rad = 2.6\n"),
            "{said}"
        );
        assert_silent(&output, &made);
    }
}

#[test]
fn every_fault_of_an_image_is_named() {
    let folder = with(MODBOAT);
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml", "--out", "a.bin"]));
    let good = fs::read(folder.path().join("a.bin")).expect("a file");
    let made = Configuration::read(&good).expect("valid");
    let checked = |mut image: Vec<u8>| {
        let end = image.len() - 4;
        let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&image[..end]);
        image[end..].copy_from_slice(&checksum.to_le_bytes());
        image
    };
    let with = |at: usize, byte: u8| {
        let mut image = good.clone();
        image[at] = byte;
        image
    };
    let block = |address: u32, family| uf2::write(family, [(address, &good[..100])]).expect("UF2");
    for (file, expected) in [
        (with(good.len() - 1, !good[good.len() - 1]), "a.bin: wrong checksum: checksum "),
        (with(40, !good[40]), "a.bin: wrong checksum: checksum "),
        (with(4, 9), "a.bin: wrong version: format 9, this build reads 2"),
        // The first field is the module's number.
        (checked(with(8, 0)), "a.bin: id out of range: module 0: numbers go from 1 to 1024"),
        (checked([&good[..8], &[0xFF; 60], &[0; 4]].concat()), "a.bin: cut short: "),
        (with(7, 0xFF), "a.bin: wrong length: "),
        (good[..50].to_vec(), "a.bin: cut short: the block has 50 bytes"),
        (vec![0xFF; 4096], "a.bin: no configuration: begins with [ff, ff, ff, ff]"),
        (Vec::new(), "a.bin: cut short: "),
        (
            block(0x1000_0000, Family::ABSOLUTE),
            "a.bin: block 1 is for 0x10000000: a configuration is in one piece from 0x101ff000 on",
        ),
        (
            block(0x101f_f000, Family::RP2350_ARM_S),
            "a.bin: is for rp2350-arm-s: a configuration is for absolute",
        ),
        (
            block(0x101f_f000, Family::ABSOLUTE)[..511].to_vec(),
            "a.bin: is no UF2 file: 511 bytes are no whole number",
        ),
        (block(0x101f_f000, Family::ABSOLUTE), "a.bin: wrong checksum: "),
    ] {
        fs::write(folder.path().join("a.bin"), file).expect("a file");
        let output = provision(folder.path(), &["--show", "a.bin"]);
        let said = refused(&output);
        assert!(said.starts_with(expected), "{said}\nexpected {expected}");
        assert_silent(&output, &made);
    }
    let said = refused(&provision(folder.path(), &["--show", "none.bin"]));
    assert!(said.starts_with("none.bin: No such file"), "{said}");
}

/// What protocol takes and the firmware does not: an image made by somebody else.
#[test]
fn an_image_that_the_firmware_refuses_is_named() {
    let folder = with(MODBOAT);
    done(&provision(folder.path(), &["--id", "3", "--from", "m.toml", "--out", "a.bin"]));
    let mut made = configuration(&folder.path().join("a.bin"));
    if let Robot::Modboat(tail) = &mut made.robot {
        tail.servo.time_constant_s = -1.0;
    }
    fs::write(folder.path().join("a.bin"), made.write(&mut [0; IMAGE_MAX]).expect("finite")).expect("a file");
    let said = refused(&provision(folder.path(), &["--show", "a.bin"]));
    assert_eq!(
        said,
        "a.bin: configuration: servo.time_constant_s = -1 s: must be a finite number greater than zero"
    );
}
