//! Orders and targets by the page, and by Foxglove's protocol: what becomes of the fleet, and what the log says.

use std::fs::File;
use std::path::Path;

use runlog::flotilla::Order;
use runlog::reader::{LogError, read};
use serde_json::{Value, json};
use tempfile::tempdir;
use tungstenite::Message;

use super::client::{Page, open_as, token_of};
use super::{executing, served};
use crate::interrupt::end;

/// Every order in the log of a run that wrote to `results`.
fn ordered(folder: &Path) -> Vec<Order> {
    let mut orders = Vec::new();
    let log = File::open(folder.join("results/log.mcap")).expect("a log");
    let extent = read(log, |entry, _| {
        if entry.topic == "/order" {
            orders.push(entry.read()?);
        }
        Ok::<(), LogError>(())
    });
    assert!(extent.expect("a log").whole);
    orders
}

fn all(snapshot: &Value, state: &str) -> bool {
    let modules = snapshot["modules"].as_array().expect("modules");
    modules.iter().all(|module| module["state"] == state)
}

#[test]
fn a_run_is_stopped_released_held_and_resumed_and_the_log_has_it() {
    let folder = tempdir().expect("a folder");
    let arguments = ["run", "--serve", "127.0.0.1:0", "--out", "results"];
    let (run, url) = served(folder.path(), &arguments);
    let mut page = Page::trusted(&url);
    page.until(executing);
    page.order(r#""do":"stop""#);
    let stopped = page.until(|snapshot| all(snapshot, "Stopped"));
    assert_eq!(stopped["order"], Value::from("stop"), "{stopped}");
    let refused = page.ask(r#"{"id":7,"do":"resume"}"#);
    assert_eq!(refused["ok"], Value::from(false), "{refused}");
    page.order(r#""do":"release""#);
    page.until(executing);
    page.order(r#""do":"hold""#);
    let held = page.until(|snapshot| all(snapshot, "Holding"));
    assert_eq!(held["order"], Value::from("hold"), "{held}");
    let refused = page.ask(r#"{"id":8,"do":"velocity","velocity_m_s":[0.04,0]}"#);
    assert_eq!(refused["ok"], Value::from(false), "{refused}");
    page.order(r#""do":"resume""#);
    page.until(executing);
    page.order(r#""do":"end""#);
    assert_eq!(run.finish().code, Some(1), "a run that ends early");
    let said: Vec<(String, bool)> =
        ordered(folder.path()).into_iter().map(|order| (order.what, order.followed)).collect();
    let followed = |what: &str| (what.to_owned(), true);
    let expected = [
        followed("stop"),
        followed("release"),
        followed("hold"),
        ("velocity [0.0400, 0.0000] m/s".to_owned(), false),
        followed("release"),
        followed("end"),
    ];
    assert_eq!(said, expected);
    let shown = page.events.iter().any(|event| event["sort"] == "order");
    assert!(shown, "{:?}", page.events);
}

/// One run, so that there is one to wait for.
#[test]
fn a_run_without_legs_waits_for_targets_and_ends_a_velocity_with_its_page() {
    let folder = tempdir().expect("a folder");
    let arguments = ["run", "--interactive", "--serve", "127.0.0.1:0", "--out", "results"];
    let (run, url) = served(folder.path(), &arguments);
    let mut looks = Page::open(&url);
    assert_eq!(looks.scene()["interactive"], Value::from(true));
    let waits = looks.until(|snapshot| all(snapshot, "Ready") && snapshot["estimate"].is_object());
    assert_eq!((&waits["target"]["kind"], &waits["t_s"]), (&Value::from("none"), &Value::Null), "{waits}");

    // A station is swum to.
    let mut page = Page::trusted(&url);
    for wrong in [
        r#"{"id":5,"do":"velocity","velocity_m_s":[0.5,0]}"#,
        r#"{"id":6,"do":"legs"}"#,
        r#"{"id":7,"do":"heading","heading_rad":1e9}"#,
    ] {
        let refused = page.ask(wrong);
        assert_eq!(refused["ok"], Value::from(false), "{refused}");
    }
    page.order(r#""do":"station","position_m":[0.1,0.05]"#);
    let near = |snapshot: &Value| {
        let at = |k: usize| snapshot["truth"]["position_m"][k].as_f64();
        at(0).zip(at(1)).is_some_and(|(x, y)| (x - 0.1).hypot(y - 0.05) < 0.03)
    };
    let there = page.until(near);
    assert_eq!(there["target"]["kind"], Value::from("station"), "{there}");

    // A velocity lasts while it is asked for.
    let refresh = r#"{"id":9,"do":"velocity","velocity_m_s":[0.0,0.05]}"#;
    let speed = |page: &mut Page, most_m_s: f64| {
        page.until(|snapshot| snapshot["truth"]["velocity_m_s"][1].as_f64() > Some(most_m_s))
    };
    for _ in 0..200 {
        page.say(refresh);
        let snapshot = page.until(|_| true);
        if snapshot["truth"]["velocity_m_s"][1].as_f64() > Some(0.02) {
            break;
        }
    }
    speed(&mut page, 0.01);
    // The page goes, without a word.
    drop(page);
    let held = looks.until(|snapshot| snapshot["deadman"].is_string());
    assert!(matches!(held["deadman"].as_str(), Some("the page is gone" | "not refreshed")), "{held}");
    looks.until(|snapshot| all(snapshot, "Holding"));

    // One that is not refreshed ends though its page is there.
    let mut page = Page::trusted(&url);
    page.order(r#""do":"velocity","velocity_m_s":[0.0,0.05]"#);
    page.until(|snapshot| snapshot["deadman"] == "not refreshed");
    // So does one that is let go of.
    page.order(r#""do":"velocity","velocity_m_s":[0.0,0.05]"#);
    page.order(r#""do":"let-go""#);
    page.until(|snapshot| matches!(snapshot["deadman"].as_str(), Some("let go" | "not refreshed")));
    page.order(r#""do":"waypoints","positions_m":[[0.5,0.1],[0.6,0.1]]"#);
    // Far off, so that a page that looks seldom still sees both.
    let swims = page.until(executing);
    assert_eq!(swims["target"]["waypoints_m"].as_array().map(Vec::len), Some(2), "{swims}");

    end(&run, "INT");
    let finished = run.finish();
    assert_eq!(finished.code, Some(0), "a run without legs ends when it is ended: {finished:?}");
    let orders = ordered(folder.path());
    let has =
        |what: &str| orders.iter().filter(|order| order.followed && order.what.starts_with(what)).count();
    assert_eq!((has("station"), has("waypoints"), has("end")), (1, 1, 1), "{orders:?}");
    assert!(has("velocity") >= 3 && has("no target") >= 3, "{orders:?}");
    // From the last time that the page asked, at most half a second of the fleet's time passes; it asked once a snapshot.
    let by = |order: &&Order| order.by == "deadman" || order.by.starts_with("page at 127.0.0.1:");
    assert_eq!(orders.iter().filter(by).count() + 1, orders.len(), "{orders:?}");
    let replayed = crate::common::Process::start(folder.path(), &["replay", "results/log.mcap"]).finish();
    assert_eq!(replayed.code, Some(0), "{replayed:?}");
}

#[test]
fn foxgloves_protocol_has_the_topics_and_stops_the_fleet_with_the_token() {
    let folder = tempdir().expect("a folder");
    let arguments = ["run", "--serve", "127.0.0.1:0", "--out", "results"];
    let (_run, url) = served(folder.path(), &arguments);
    let mut page = Page::open(&url);
    // Odometry is told from the first cycle on.
    page.until(|snapshot| snapshot["t_s"].as_f64() > Some(0.5));
    for (query, trusted) in [(String::new(), false), (format!("?token={}", token_of(&url)), true)] {
        let mut socket = open_as(&url, "foxglove.sdk.v1", None, &query).expect("a stream");
        let mut text = |op: &str| loop {
            if let Message::Text(text) = socket.read().expect("a message") {
                let value: Value = serde_json::from_str(&text).expect("JSON");
                if value["op"] == op {
                    break value;
                }
            }
        };
        assert_eq!(
            text("serverInfo")["capabilities"],
            json!(["parameters", "parametersSubscribe", "services"])
        );
        let services = text("advertiseServices");
        assert_eq!(services["services"][0]["name"], Value::from("/flotilla/stop"), "{services}");
        let channels = text("advertise")["channels"].as_array().expect("channels").clone();
        let odometry = channels.iter().find(|channel| channel["topic"] == "/odom").expect("odometry");
        assert_eq!(odometry["schemaName"], Value::from("nav_msgs/msg/Odometry"));
        let id = odometry["id"].as_u64().expect("a number");
        let subscribe = json!({ "op": "subscribe", "subscriptions": [{ "id": 42, "channelId": id }] });
        socket.send(Message::text(subscribe.to_string())).expect("room");
        let bytes = loop {
            if let Message::Binary(bytes) = socket.read().expect("a message") {
                break bytes;
            }
        };
        assert_eq!((bytes[0], &bytes[1..5]), (1, &[42, 0, 0, 0][..]));
        let message =
            <runlog::ros::Odometry as runlog::message::Message>::read(&bytes[13..]).expect("odometry");
        assert_eq!(message.header.frame_id, "world");
        let call = [&[2, 1, 0, 0, 0, 5, 0, 0, 0, 4, 0, 0, 0][..], b"json{}"].concat();
        socket.send(Message::binary(call)).expect("room");
        let answered = loop {
            match socket.read().expect("a message") {
                Message::Text(text) if text.contains("serviceCallFailure") => break false,
                Message::Binary(bytes) if bytes[0] == 3 => break true,
                _ => {}
            }
        };
        assert_eq!(answered, trusted);
    }
    page.until(|snapshot| all(snapshot, "Stopped"));
}
