//! A log on the page.

use serde_json::Value;
use tempfile::tempdir;

use super::client::Page;
use super::served;
use crate::common::Process;

#[test]
fn a_log_is_played_paused_and_scrubbed() {
    let folder = tempdir().expect("a folder");
    let finished = Process::start(folder.path(), &["run", "six", "--out", "results"]).finish();
    assert!(folder.path().join("results/log.mcap").exists(), "{finished:?}");
    let (_server, url) = served(folder.path(), &["serve", "results/log.mcap", "--at", "127.0.0.1:0"]);
    let mut looks = Page::open(&url);
    let refused = looks.ask(r#"{"id":1,"do":"pause"}"#);
    assert_eq!(refused["ok"], Value::from(false), "{refused}");
    let mut page = Page::trusted(&url);
    let scene = page.scene();
    assert_eq!((&scene["source"], &scene["can"]["play"]), (&Value::from("log"), &Value::from(true)));
    let refused = page.ask(r#"{"id":2,"do":"stop"}"#);
    assert_eq!(refused["ok"], Value::from(false), "{refused}");
    page.order(r#""do":"pause""#);
    page.order(r#""do":"seek","at_s":40.0"#);
    // It comes before the answer.
    let history = page.history.clone();
    assert!(history["trail"].as_array().map_or(0, Vec::len) > 60, "{history}");
    assert!(history["decisions"].as_array().map_or(0, Vec::len) > 10);
    let at = page.until(|snapshot| snapshot["play"]["at_s"] == 40.0 && snapshot["play"]["playing"] == false);
    assert!((at["fleet_s"].as_f64().expect("a time") - 40.0).abs() < 0.1, "{at}");
    assert!(at["truth"].is_object() && at["modules"][5]["tail_rad"].is_number(), "{at}");
    // What is before is told as it was then: the trail is shorter.
    page.order(r#""do":"seek","at_s":10.0"#);
    let earlier = page.history.clone();
    assert!(earlier["trail"].as_array().map(Vec::len) < history["trail"].as_array().map(Vec::len));
    page.order(r#""do":"speed","factor":100.0"#);
    page.order(r#""do":"play""#);
    let ended = page.until(|snapshot| snapshot["ended"].is_string());
    assert_eq!(ended["play"]["cut"], Value::from(false), "{ended}");
}
