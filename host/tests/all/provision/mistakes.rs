//! What is refused, with file, line, key, value and unit, and no secret in it.

use super::*;

#[test]
fn mistakes_in_a_module_file_are_named_with_line_value_and_unit() {
    let boat = |more: &str| format!("{MODBOAT}{more}\n");
    let network = |from: &str, to: &str| MODBOAT.replace(from, to);
    let address = |line: &str| MODBOAT.replace("ssid", &format!("{line}\nssid"));
    let rov = |from: &str, to: &str| ROV.replace(from, to);
    let cases: Vec<(String, &str)> = vec![
        (boat("[modboat.servo]\ntime_constant = 1"), "8: [modboat.servo] unknown field `time_constant`"),
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
        (
            boat("[modboat.servo]\nrate_gain = \"much\""),
            "8: [modboat.servo] rate_gain = \"much\": must be a number",
        ),
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
        (network("4800", "1.5"), "6: [modboat.encoder] counts_per_turn = 1.5: must be a whole number"),
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
            "4: [network] host = \"224.0.0.1:4870\": 224.0.0.1 is no host's",
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
    // Neither is one in a table where none is asked for, nor beside a misspelt key.
    for (text, expected) in [
        ("network = [{ passphrase = \"correct horse\" }]\n", "m.toml:1: network: must be a table of keys"),
        ("[network]\npassphrse = \"correct horse\"\n", "m.toml:2: [network] unknown field `passphrse`, "),
    ] {
        fs::write(folder.path().join("m.toml"), text).expect("a file");
        let said = refused(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
        assert!(said.starts_with(expected) && !said.contains("horse"), "{said}");
    }
    let inline = "network = { ssid = 3, passphrase = \"correct horse\" }\nmodboat = {}\n";
    fs::write(folder.path().join("m.toml"), inline).expect("a file");
    let said = refused(&provision(folder.path(), &["--id", "3", "--from", "m.toml"]));
    assert!(said.starts_with("m.toml:1: ") && !said.contains("horse"), "{said}");
    // A file of its own is as private as a key.
    fs::write(folder.path().join("wifi.txt"), "\u{feff}short\n").expect("a file");
    let own = MODBOAT.replace("passphrase = \"correct horse battery\"", "passphrase_file = \"wifi.txt\"");
    fs::write(folder.path().join("m.toml"), own).expect("a file");
    for (mode, expected) in [
        (0o644, "wifi.txt: mode 0644 lets others"),
        (
            0o600,
            "m.toml:3: [network] passphrase_file = \"wifi.txt\": 8 to 63 characters of ASCII make a passphrase, not these 5",
        ),
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
            "none.toml: no such file, and no built-in module of that name (there are modboat, rov",
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
