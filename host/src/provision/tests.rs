use std::path::Path;

use link::key_file::ModuleCredentials;
use protocol::configuration::{IMAGE_MAX, Own, Robot};
use protocol::{Configuration, FleetKey, ModuleId};

use super::*;

fn credentials(id: u16) -> ModuleCredentials {
    ModuleCredentials::derive(&FleetKey::new([0x42; 32]), ModuleId(id))
}

fn with_host() -> NetworkOptions {
    NetworkOptions { host: Some("192.168.4.1:4870".to_owned()), ..NetworkOptions::default() }
}

fn of(text: &str) -> Result<Configuration, ProvisionError> {
    ModuleFile::parse("t.toml", Path::new(""), text.to_owned())?.configuration(&credentials(3), &with_host())
}

fn image(configuration: &Configuration) -> Vec<u8> {
    configuration.write(&mut [0; IMAGE_MAX]).unwrap().to_vec()
}

/// A file as it ships with everything in it that stands behind a `#`.
fn uncommented(text: &str) -> String {
    let is_key = |line: &str| line.split_once('=').is_some_and(|(key, _)| !key.trim().contains(' '));
    let lines = text.lines().map(|line| match line.strip_prefix("# ") {
        Some(line) if is_key(line) => line,
        _ => line,
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn what_ships_says_the_firmwares_defaults() {
    for (name, text) in BUILT_IN {
        let defaults = ModuleFile::open(name).unwrap().configuration(&credentials(3), &with_host()).unwrap();
        // Of its own it has the wiring, which has no default.
        let wired = ["ssid", "passphrase_file", "address", "gateway", "volts_per_volt"];
        let mut written = uncommented(text);
        let shown = shown::shown(&defaults).unwrap();
        for (key, _) in shown.lines().filter_map(|line| line.split_once(" = ")) {
            let thruster = name == "rov" && key == "reversed";
            assert!(written.contains(&format!("\n{key} = ")) || thruster, "{name} does not say {key}");
        }
        for key in wired {
            written = written.replace(&format!("\n{key} = "), &format!("\n# {key} = "));
        }
        assert!(written.contains("\nhost = ") && written.contains("\nevery_ms = 20"), "{written}");
        let stated = of(&written).unwrap();
        assert_eq!(image(&stated), image(&defaults), "{name}");
        // And the wiring can be written as it stands there, but for the file that is the user's.
        let wired = uncommented(text).replace("\npassphrase_file", "\n# passphrase_file");
        let wired = of(&wired.replace("\ngateway", "\n# gateway")).unwrap();
        let own = Own::Static { address: [192, 168, 4, 3], prefix: 24, gateway: None };
        assert_eq!(wired.network.own, own);
        assert!(wired.supply.volts_per_volt > 1.0);
    }
}

/// Every key that a file can have is shown, and says the same when read again.
#[test]
fn what_is_shown_makes_the_same_image() {
    let modboat = "[network]\nssid = \"tank\"\nhost = \"10.0.0.9:5000\"\naddress = \"192.168.4.{id}/24\"\ngateway = \"192.168.4.254\"\n\
                   [report]\nevery_ms = 12.5\nsure_within_ms = 1.5\n[supply]\nvolts_per_volt = 3.1\namperes_per_volt = 0.7\n\
                   low_v = 6.1\nrecover_v = 6.3\nhold_off_s = 1.5\n[modboat.limits]\namplitude_min_rad = 0.8\n\
                   amplitude_max_rad = 2.1\ncenterline_max_rad = 900\nrotation_max_rad = 6.3\nspeed_max_rad_s = 11.1\n\
                   period_min_s = 0.7\nperiod_max_s = 5\ntransition_max_s = 3.3\n[modboat.servo]\nno_load_speed_rad_s = 17.3\n\
                   time_constant_s = 0.03\nposition_gain_per_s = 50.1\nrate_gain = 1.1\nspeed_max_rad_s = 14.3\n\
                   stall_current_a = 2.1\ncurrent_max_a = 1.3\nfollowing_error_max_rad = 0.04\nfollowing_error_time_ms = 35\ninterval_ms = 0.5\n\
                   [modboat.encoder]\ncounts_per_turn = 1633\nzero_counts = 65535\nreversed = true\nhoming_speed_rad_s = 0.6\n\
                   homing_after_s = 5.5\n";
    let rov = "[rov]\nthrust_max_n = 50.3\nlease_max_s = 0.6\nframe_rate_hz = 200.5\narming_s = 4.5\nslew_n_s = 150.1\n\
               reversal_delay_ms = 33\n[[rov.thruster]]\noutput = 7\nreversed = true\n[[rov.thruster]]\noutput = 0\n";
    for text in [modboat, rov] {
        let module = ModuleFile::parse("t.toml", Path::new(""), text.to_owned()).unwrap();
        let options = if text == rov { with_host() } else { NetworkOptions::default() };
        let configuration = module.configuration(&credentials(3), &options).unwrap();
        let shown = shown::shown(&configuration).unwrap();
        for line in text.lines().filter(|line| !line.starts_with("address")) {
            let value = line.strip_suffix(".0").unwrap_or(line);
            assert!(shown.contains(value), "{value}\n{shown}");
        }
        let again = ModuleFile::parse("shown", Path::new(""), shown.clone()).unwrap();
        let again = again.configuration(&credentials(3), &NetworkOptions::default()).unwrap();
        assert_eq!(image(&again), image(&configuration), "{shown}");
    }
}

#[test]
fn a_file_is_what_it_is_in_either_format() {
    let configuration = of("[modboat.encoder]\ncounts_per_turn = 4800\n").unwrap();
    let bare = image::encode(&configuration, image::Format::Bin).unwrap();
    assert_eq!(*bare, image(&configuration));
    let uf2 = image::encode(&configuration, image::Format::Uf2).unwrap();
    assert_eq!(uf2.len(), bare.len().div_ceil(256) * 512);
    for (file, expected) in [(&bare, image::Format::Bin), (&uf2, image::Format::Uf2)] {
        let (read, format) = image::decode(file).unwrap();
        assert_eq!((image(&read), format), (bare.to_vec(), expected));
    }
    assert!(matches!(configuration.robot, Robot::Modboat(_)));
}
