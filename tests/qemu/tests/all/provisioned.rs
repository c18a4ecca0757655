//! The whole way of a user, by the program alone: a fleet's key, an image for each module, and a run over UDP.
//!
//! The program and the emulators keep the time of this machine, so only that is asked which holds however busy it is; what a
//! module does when is asked in lock step elsewhere.

use std::path::Path;
use std::process::{Command, Stdio};

use protocol::Configuration;
use qemu::emulator::{Emulator, Setup, free_port};
use serde_json::Value;

/// Cycles are sent a second ahead, so that an emulator that waits for its turn on the processor still hears of them in time.
const SCENARIO: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 10.0\nvelocity_m_s = [0.04, 0.0]\n\
                        heading_rad = 1.5707963\n[timing]\nlead_s = 1.0\njoin_s = 600\n";

/// What the program prints, if it ends with this status.
fn flotilla(folder: &Path, arguments: &[&str], status: impl Fn(&str) -> i32) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_flotilla-under-test"))
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("the program");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(status(&out)), "{arguments:?}: {out}\n{err}");
    out.into_owned()
}

#[test]
fn keygen_provision_and_run_make_emulated_modules_swim() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let port = free_port();
    let host = format!("10.0.2.2:{port}");
    let well = |_: &str| 0;
    flotilla(folder.path(), &["keygen", "--out", "fleet.key"], well);
    // The usual module, which finds its zero by itself.
    let usual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host/data/modules/modboat.toml");
    let text = std::fs::read_to_string(usual).expect("a module's file");
    let homes = text.replace("# homing_speed_rad_s = 0", "homing_speed_rad_s = 0.9");
    // An emulator that waits for its processor in mid-swing lags behind its cycle, and is not to stop for it.
    let lags = homes
        .replace("# following_error_max_rad = 0.020", "following_error_max_rad = 0.15")
        .replace("# following_error_time_ms = 50", "following_error_time_ms = 350");
    assert!(
        homes != text
            && lags.contains("\nfollowing_error_max_rad = 0.15")
            && lags.contains("\nfollowing_error_time_ms = 350")
    );
    std::fs::write(at("module.toml"), lags).expect("a file");
    let provision =
        ["provision", "--id", "1-3", "--from", "module.toml", "--host", &host, "--key", "fleet.key", "--bin"];
    print!("{}", flotilla(folder.path(), &[&provision[..], &["--out", "images"]].concat(), well));
    let modules: Vec<Emulator> = (1..=3)
        .map(|id| {
            let image = std::fs::read(at(&format!("images/module-{id}.bin"))).expect("an image");
            let configuration = Configuration::read(&image).expect("a configuration");
            assert_eq!(configuration.module.0, id);
            let forward = Some((free_port(), port));
            Emulator::start(&Setup { image: "qemu.elf", configuration: &image, forward, ..Setup::default() })
        })
        .collect();
    std::fs::write(at("t.toml"), SCENARIO).expect("a file");
    let listen = format!("127.0.0.1:{port}");
    let run = [
        "run",
        "t.toml",
        "--radio",
        "udp",
        "--listen",
        &listen,
        "--key",
        "fleet.key",
        "--out",
        "results",
        "--json",
    ];
    let summary_of = |out: &str| -> Value { serde_json::from_str(out).expect("a summary") };
    let contacts = |summary: &Value| summary["contacts"].as_array().expect("a list").len();
    // A tail that waits for its processor in mid-swing may be touched: that is told, and fails the run.
    // So is a fleet that had to hold for its module.
    let out = flotilla(folder.path(), &run, |out| i32::from(!summary_of(out)["failure"].is_null()));
    let summary = summary_of(&out);
    assert_eq!(summary["complete"], true, "{summary}");
    for (index, link) in summary["link"].as_array().expect("a list").iter().enumerate() {
        assert_eq!(link["module"], index + 1);
        let sum = |names: &[&str]| names.iter().map(|&name| link[name].as_u64().expect(name)).sum::<u64>();
        let (cycles, told) = (sum(&["cycles"]), sum(&["acknowledged", "late", "refused", "unanswered"]));
        assert!(told <= cycles && cycles - told <= 1, "one cycle may be open: {link}");
        assert!(sum(&["acknowledged"]) >= 1 && link["boots"] == 1, "{link}");
        println!(
            "module {}: {} of {cycles} cycles acknowledged, faults {}",
            link["module"], link["acknowledged"], link["faults"]
        );
    }
    println!("{} contacts with {} modules", contacts(&summary), modules.len());
}
