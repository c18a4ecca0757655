//! Poses from topics of ROS: a driver in `rclpy` over a simulated motion capture, a probe and a run.

use std::path::Path;

use crate::environment::{FLOTILLA, Program, domain, folder, port};

const SCENARIO: &str = "name = \"short\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 20\nvelocity_m_s = [0.04, 0]\n\
                        heading_rad = 1.5\n[pose]\nup = \"z\"\n";

/// A tank, whose modules wait for `host`, and a driver over its motion capture.
struct Laboratory {
    tank: Program,
    _driver: Program,
    domain: String,
    host: String,
}

impl Laboratory {
    fn open(kind: &str, folder: &Path) -> Self {
        let domain = domain();
        std::fs::write(folder.join("short.toml"), SCENARIO).expect("a file");
        let (status, said) =
            Program::start(FLOTILLA, &["keygen", "--out", "fleet.key"], folder, &domain).finish();
        assert!(status.success(), "{said}");
        let (capture, host) = (port(), format!("127.0.0.1:{}", port()));
        let listen = format!("127.0.0.1:{capture}");
        let arguments = [
            "tank",
            "short.toml",
            "--key",
            "fleet.key",
            "--host",
            &host,
            "--mocap",
            "vrpn",
            "--listen",
            &listen,
            "--duration",
            "3600",
            "--noise",
            "0.0005",
        ];
        let tank = Program::start(FLOTILLA, &arguments, folder, &domain);
        let driver = Program::script("drive_poses.py", &[kind, &capture.to_string()], &domain);
        Self { tank, _driver: driver, domain, host }
    }
}

#[test]
fn each_kind_of_message_is_read() {
    for (kind, source) in [
        ("pose", "ros2:/module_1/pose,/module_2/pose,/module_3/pose"),
        ("odom", "ros2:blue=/module_1/odom,/module_2/odom@lab"),
        ("tf", "ros2:/tf@lab"),
    ] {
        let folder = folder(&format!("probe-{kind}"));
        let laboratory = Laboratory::open(kind, &folder);
        // The driver and DDS take their time to begin, a slow machine more.
        let arguments = ["probe", source, "--up", "z", "--duration", "20", "--json"];
        let probed = (0..15).find_map(|_| {
            let (status, said) = Program::start(FLOTILLA, &arguments, &folder, &laboratory.domain).finish();
            let json = said.lines().skip_while(|line| *line != "{").collect::<Vec<_>>().join("\n");
            let findings: serde_json::Value = serde_json::from_str(&json).unwrap_or_default();
            let bodies = findings["bodies"].as_array().map_or(0, Vec::len);
            (status.success() && bodies >= source.matches("/module").count().max(2)).then_some(findings)
        });
        let findings = probed.unwrap_or_else(|| panic!("{source}: no frames"));
        let names: Vec<&str> = findings["bodies"]
            .as_array()
            .expect("bodies")
            .iter()
            .filter_map(|body| body["body"].as_str())
            .collect();
        let expected = match kind {
            "odom" => &["\"blue\"", "\"module-2\""][..],
            _ => &["\"module-1\"", "\"module-2\"", "\"module-3\""],
        };
        assert!(
            expected.iter().all(|name| names.iter().any(|n| n.contains(name.trim_matches('"')))),
            "{names:?}"
        );
        assert!(!names.iter().any(|name| name.contains("camera")), "{names:?}");
        // Modules stand side by side, 0.15 m apart.
        let place = |name: &str| -> Vec<f64> {
            let body = findings["bodies"]
                .as_array()
                .into_iter()
                .flatten()
                .find(|body| body["body"].as_str().is_some_and(|b| b.contains(name)));
            let place = body.unwrap_or_else(|| panic!("{name}"))["world_m"].as_array().expect("a place");
            place.iter().filter_map(serde_json::Value::as_f64).collect()
        };
        let (one, two) = (place(if kind == "odom" { "blue" } else { "module-1" }), place("module-2"));
        let apart_m = (one[0] - two[0]).hypot(one[1] - two[1]);
        assert!((apart_m - 0.15).abs() < 0.02, "{apart_m}");
        laboratory.tank.interrupt();
    }
}

#[test]
fn a_run_swims_by_poses_of_a_driver() {
    let folder = folder("run");
    let laboratory = Laboratory::open("pose", &folder);
    let source = "ros2:/module_1/pose,/module_2/pose,/module_3/pose";
    let arguments = [
        "run",
        "short.toml",
        "--radio",
        "udp",
        "--key",
        "fleet.key",
        "--listen",
        &laboratory.host,
        "--pose",
        source,
        "--json",
        "--out",
        "out",
    ];
    let (status, said) = Program::start(FLOTILLA, &arguments, &folder, &laboratory.domain).finish();
    let summary = std::fs::read_to_string(folder.join("out/summary.json"))
        .unwrap_or_else(|error| panic!("{error}: {said}"));
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["poses"]["source"], source);
    // A slow machine may make the fleet hold for want of poses, and the run end with that: it has swum by those that came.
    println!("{status}: {}, {}", summary["poses"], summary["cycles"]);
    assert!(summary["poses"]["frames"]["accepted"].as_u64() > Some(100), "{summary:#}");
    assert!(summary["cycles"]["planned"].as_u64() > Some(0), "{summary:#}");
    assert_eq!(summary["contacts"], serde_json::json!([]));
    laboratory.tank.interrupt();
}
