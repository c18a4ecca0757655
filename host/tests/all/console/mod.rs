//! The console as a browser and other makers' tools meet it: `flotilla run --serve`, `--interactive`, `serve LOG`, over real sockets. What
//! became of it is judged by what the page is told and by the log; nothing is asked of how fast the machine is.

mod client;
mod orders;
mod playing;
mod storm;

use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;

use crate::common::{PATIENCE, Process};
use client::{Page, fetch, host_of, open_as, refusal};

/// Starts `flotilla` with a page at a port of the system's choice; the process, and the page's address.
fn served(folder: &Path, arguments: &[&str]) -> (Process, String) {
    let process = Process::reachable(folder, arguments);
    loop {
        let line = process.err.recv_timeout(PATIENCE).expect("a line about the page");
        if let Some(url) = line.strip_prefix("the page: ") {
            return (process, url.to_owned());
        }
    }
}

#[test]
fn a_page_shows_three_modules_that_move() {
    let folder = tempdir().expect("a folder");
    let arguments = ["run", "--serve", "127.0.0.1:0", "--out", "results"];
    let (_run, url) = served(folder.path(), &arguments);
    let page = fetch(&url, "/", &[]);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("main.js"), "{page}");
    assert!(page.contains("Content-Security-Policy: default-src 'self'"), "{page}");
    for (path, fields, expected) in [
        ("/main.js", &[][..], "200"),
        ("/layout.json", &[], "200"),
        ("/nothing", &[], "404"),
        ("/", &["Host: evil.example"], "403"),
    ] {
        let reply = fetch(&url, path, fields);
        assert!(reply.starts_with(&format!("HTTP/1.1 {expected}")), "{path}: {reply}");
    }

    let mut page = Page::open(&url);
    let scene = page.scene();
    assert_eq!((&scene["fleet"], &scene["name"]), (&Value::from("modboats"), &Value::from("holonomic-1")));
    assert_eq!(scene["boats"]["cells"].as_array().map(Vec::len), Some(3), "{scene}");
    assert_eq!(scene["can"], serde_json::json!({ "order": true, "steer": true, "play": false }));
    let x = |snapshot: &Value| snapshot["truth"]["position_m"][0].as_f64();
    let first = page.until(|snapshot| x(snapshot).is_some() && executing(snapshot));
    let later = page.until(|snapshot| x(snapshot) > x(&first).map(|x| x + 0.02));
    assert_eq!(later["target"]["kind"], Value::from("velocity"), "{later}");
    assert!(later["wrench"]["demanded"].is_array() && later["n"].as_u64() > first["n"].as_u64());
    // Every snapshot of the server has come, or is counted.
    let count = |key: &str| later[key].as_u64().unwrap_or(0) - first[key].as_u64().unwrap_or(0);
    assert_eq!(count("n"), count("dropped") + page.snapshots_since(&first), "{first}\n{later}");
    for module in later["modules"].as_array().expect("modules") {
        let error_rad = module["tail_error_rad"].as_f64().expect("a tail that swims");
        assert!(error_rad.abs() < 0.2, "{module}");
    }
}

fn executing(snapshot: &Value) -> bool {
    let modules = snapshot["modules"].as_array().expect("modules");
    !modules.is_empty() && modules.iter().all(|module| module["state"] == "Executing")
}

#[test]
fn who_has_no_token_only_looks_and_a_page_from_elsewhere_gets_no_socket() {
    let folder = tempdir().expect("a folder");
    let arguments = ["run", "--serve", "127.0.0.1:0", "--out", "results"];
    let (_run, url) = served(folder.path(), &arguments);
    let host = host_of(&url);
    for origin in ["http://127.0.0.1:1", "http://evil.example", "null", &format!("https://{host}")] {
        assert_eq!(refusal(open_as(&url, "flotilla.console.v1", Some(origin), "")), 403, "{origin}");
        assert_eq!(refusal(open_as(&url, "foxglove.sdk.v1", Some(origin), "")), 403, "{origin}");
    }
    assert_eq!(refusal(open_as(&url, "chat", None, "")), 400);
    let mut own =
        Page::over(open_as(&url, "flotilla.console.v1", Some(&format!("http://{host}")), "").expect("ours"));
    for order in [r#"{"id":1,"do":"stop"}"#, r#"{"id":2,"do":"station","position_m":[1,0]}"#] {
        let answer = own.ask(order);
        assert_eq!(answer["ok"], Value::from(false), "{answer}");
    }
    let answer = own.ask(r#"{"id":3,"do":"hello","token":"00000000000000000000000000000000"}"#);
    assert_eq!(answer["ok"], Value::from(false), "{answer}");
    let snapshot = own.until(|snapshot| snapshot["n"].as_u64() > Some(40));
    assert_eq!(snapshot["order"], Value::Null, "{snapshot}");
    assert_eq!(snapshot["target"]["from"], Value::from("leg"), "{snapshot}");
}

#[test]
fn another_address_than_loopback_has_to_be_allowed() {
    let folder = tempdir().expect("a folder");
    for (arguments, expected) in [
        (&["run", "--serve", "0.0.0.0:0"][..], "that needs --allow-remote"),
        (&["run", "--allow-remote"], "--allow-remote needs --serve"),
        (&["run", "--serve", "nine"], "wants ADDRESS:PORT"),
        (&["serve", "nothing.mcap"], "nothing.mcap: "),
        (&["reconfigure", "--serve"], "say which, by --criterion"),
    ] {
        let finished = Process::start(folder.path(), arguments).finish();
        assert_eq!(finished.code, Some(2), "{arguments:?}: {finished:?}");
        assert!(finished.err.iter().any(|line| line.contains(expected)), "{arguments:?}: {finished:?}");
    }
}
