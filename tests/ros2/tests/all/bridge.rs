//! A run that is looked at and steered by `rclpy` over Fast DDS, and looked at by Cyclone DDS.

use runlog::flotilla::Order;
use runlog::reader::{self, LogError};

use crate::environment::{Bridged, Program, found};

/// What was ordered, and whether it was followed, by the log.
fn orders(log: &std::path::Path) -> Vec<(String, bool)> {
    let mut orders = Vec::new();
    let file = std::fs::File::open(log).expect("a log");
    let read = reader::read(std::io::BufReader::new(file), |entry, _| {
        if entry.topic == "/order" {
            let order: Order = entry.read()?;
            orders.push((order.what, order.followed));
        }
        Ok::<(), LogError>(())
    });
    read.expect("a log");
    orders
}

#[test]
fn a_node_of_rclpy_looks_at_a_fleet_and_steers_it() {
    let bridged = Bridged::start("steer", "--interactive");
    let found = found(Program::script("steer.py", &[], &bridged.domain));
    let log = bridged.folder.join("log.mcap");
    bridged.end();

    let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("{key}: {found}"));
    // As the log has them: 10 Hz and 20 Hz.
    assert!((number("odometry_s") - 0.1).abs() < 0.011, "{found}");
    assert!((number("tf_s") - 0.05).abs() < 0.006, "{found}");
    // Stamps are of this machine's clock: not of the run's, which begins at 0.
    assert!(number("age_s").abs() < 120.0, "{found}");
    let frames = [
        "flotilla/base_link>flotilla/structure",
        "flotilla/structure>flotilla/module_1",
        "flotilla/structure>flotilla/module_2",
        "flotilla/structure>flotilla/module_3",
    ];
    assert_eq!(found["frames"], serde_json::json!(frames));
    assert_eq!(found["joints"].as_array().map(Vec::len), Some(3), "{found}");
    assert!(number("battery_v") > 5.0, "{found}");
    assert_eq!(found["diagnosed"][0], "flotilla: module 1");
    // Each side is swum until it is swum along itself alone: what of the side before is still under way goes across it.
    assert_eq!(found["corners"].as_array().map(Vec::len), Some(4), "{found}");
    assert!(number("closed_m") < 0.4, "{found}");
    assert!(number("station_m") < 0.03, "{found}");

    let orders = orders(&log);
    println!("{orders:?}");
    for what in ["velocity", "station", "stop", "release", "hold"] {
        assert!(
            orders.iter().any(|(order, followed)| order.contains(what) && *followed),
            "{what}: {orders:?}"
        );
    }
}

#[test]
fn cyclone_dds_reads_odometry_and_transforms() {
    let bridged = Bridged::start("cyclone", "holonomic-1");
    let domain = bridged.domain.clone();
    let found = found(Program::script("listen_by_cyclone.py", &[&domain], &domain));
    bridged.end();
    assert_eq!(found["child"], "flotilla/estimate");
    assert_eq!(found["fixed"].as_array().map(Vec::len), Some(4), "{found}");
}
