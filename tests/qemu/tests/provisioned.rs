//! The whole way of a user, by the program alone: a fleet's key, an image for each module, and a run over UDP.

use std::path::Path;
use std::process::{Command, Stdio};

use protocol::Configuration;
use qemu::emulator::{Emulator, Setup, free_port};
use serde_json::Value;

const SCENARIO: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 10.0\nvelocity_m_s = [0.04, 0.0]\nheading_rad = 1.5707963\n";

/// What the program prints, if it does what it is asked.
fn flotilla(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_flotilla-under-test"))
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("the program");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{arguments:?}: {}\n{out}\n{err}", output.status);
    out.into_owned()
}

#[test]
fn keygen_provision_and_run_make_emulated_modules_swim() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let port = free_port();
    let host = format!("10.0.2.2:{port}");
    flotilla(folder.path(), &["keygen", "--out", "fleet.key"]);
    let provision =
        ["provision", "--id", "1-3", "--from", "modboat", "--host", &host, "--key", "fleet.key", "--bin"];
    print!("{}", flotilla(folder.path(), &[&provision[..], &["--out", "images"]].concat()));
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
    let summary: Value = serde_json::from_str(&flotilla(folder.path(), &run)).expect("a summary");
    assert_eq!(
        (&summary["complete"], &summary["contacts"]),
        (&Value::Bool(true), &Value::Array(vec![])),
        "{summary}"
    );
    for (index, link) in summary["link"].as_array().expect("a list").iter().enumerate() {
        assert_eq!(link["module"], index + 1);
        assert!(link["acknowledged"].as_u64() >= Some(5) && link["acknowledged"] == link["cycles"], "{link}");
        assert_eq!((&link["boots"], &link["faults"]), (&Value::from(1), &Value::Array(vec![])), "{link}");
    }
    println!("{} cycles of each of {} modules", summary["link"][0]["cycles"], modules.len());
}
