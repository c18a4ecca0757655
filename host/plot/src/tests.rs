//! What must hold for every picture, whatever the run was.

use record::{LegRecord, PoseSample, RunRecord};

use super::*;

const SOUTH_EAST: [[f64; 2]; 2] = [[0.04, 0.0], [0.0, -0.04]];

fn pictures(record: &RunRecord) -> [(&'static str, String); 4] {
    let draw = |picture: Result<String, picture::DrawError>| picture.expect("a picture");
    [
        ("trajectory", draw(trajectory::svg(record))),
        ("wrench", draw(wrench::svg(record))),
        ("tails", draw(tails::svg(record))),
        ("phase space", draw(phase_space::svg(record, &neighbour_kinds(record)))),
    ]
}

/// Checks that elements nest, attributes are quoted, only the five entities occur, and numbers are numbers.
pub(super) fn assert_sound(name: &str, svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = svg;
    while let Some(at) = rest.find('<') {
        assert_text(name, &rest[..at]);
        let end = rest[at..].find('>').unwrap_or_else(|| panic!("{name}: a tag does not end")) + at;
        let tag = &rest[at + 1..end];
        rest = &rest[end + 1..];
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "{name}: elements do not nest");
            continue;
        }
        let (tag, is_empty) = tag.strip_suffix('/').map_or((tag, false), |t| (t, true));
        let (element, attributes) = tag.split_once(' ').unwrap_or((tag, ""));
        let mut parts = attributes.split('"');
        while let (Some(key), Some(value)) = (parts.next(), parts.next()) {
            assert_text(name, value);
            let key = key.trim().strip_suffix('=').unwrap_or_else(|| panic!("{name}: attribute {key}"));
            if matches!(
                key,
                "x" | "y"
                    | "x1"
                    | "x2"
                    | "y1"
                    | "y2"
                    | "cx"
                    | "cy"
                    | "r"
                    | "points"
                    | "opacity"
                    | "width"
                    | "height"
            ) {
                for number in value.split([' ', ',']).filter(|n| !n.is_empty()) {
                    let parsed: f64 = number.parse().unwrap_or_else(|_| panic!("{name}: {key}={value}"));
                    assert!(parsed.is_finite() && parsed.abs() < 1e6, "{name}: {key}={value}");
                }
            }
        }
        if !is_empty {
            open.push(element);
        }
    }
    assert!(open.is_empty(), "{name}: {open:?} left open");
    assert!(rest.trim().is_empty());
}

fn assert_text(name: &str, text: &str) {
    for (at, _) in text.match_indices('&') {
        let known = ["&lt;", "&gt;", "&amp;", "&quot;", "&apos;"].iter().any(|e| text[at..].starts_with(e));
        assert!(known, "{name}: a bare & in {text:?}");
    }
    assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{name}: control character in {text:?}");
    for word in ["NaN", "inf\n"] {
        assert!(!text.contains(word), "{name}: {text:?}");
    }
}

#[test]
fn every_picture_carries_its_labels() {
    let mut record = sample::run(3, 1, 60.0, SOUTH_EAST);
    record.name = "tank <2> & \u{7}co".to_owned();
    let labels: [&[&str]; 4] = [
        &["East, m", "North, m", "Velocity east, m/s", "Heading Θ, degrees", "Time, s", "demand ± 5 %"],
        &["Sway force Fx, mN", "Surge force Fy, mN", "Yaw torque τ, mN·m", "leg 2", "law (7)", "Time, s"],
        &["Module 1, rad", "Module 3, rad", "centerline φ₀", "transition", "Whole run", "π"],
        &["φ₁ of the left module, rad", "φ₂ of the right module, rad", "collision", "−2π", "Side by side"],
    ];
    for ((name, svg), labels) in pictures(&record).into_iter().zip(labels) {
        assert_sound(name, &svg);
        for label in labels {
            assert!(svg.contains(label), "{name} lacks {label:?}");
        }
        assert!(svg.contains("<title>tank &lt;2&gt; &amp;  co"), "{name}");
        assert!(svg.contains(&record.description), "{name}");
        assert!(svg.len() < 250_000, "{name} has {} bytes", svg.len());
    }
}

#[test]
fn the_map_has_equal_axes() {
    for courses in [SOUTH_EAST, [[0.04, 0.0]; 2], [[0.0, 0.04]; 2]] {
        // The sample starts at a heading of exactly 90°: the first module drawn is an upright square.
        let svg = trajectory::svg(&sample::run(3, 1, 60.0, courses)).expect("a picture");
        let points =
            svg.split("<polygon").nth(1).and_then(|p| p.split("points=\"").nth(1)).expect("a module");
        let corners: Vec<(i64, i64)> = points[..points.find('"').expect("the end")]
            .split_whitespace()
            .map(|p| p.split_once(',').expect("x,y"))
            .map(|(x, y)| (x.parse().expect("x"), y.parse().expect("y")))
            .collect();
        let spread = |pick: fn(&(i64, i64)) -> i64| {
            corners.iter().map(pick).max().unwrap_or(0) - corners.iter().map(pick).min().unwrap_or(0)
        };
        let (wide, high) = (spread(|p| p.0), spread(|p| p.1));
        assert!(wide > 20 && (wide - high).abs() <= 2, "{courses:?}: {wide} × {high}");
    }
}

#[test]
fn odd_runs_still_give_pictures() {
    let whole = sample::run(3, 1, 20.0, SOUTH_EAST);
    let mut empty = whole.clone();
    (empty.poses, empty.tails, empty.cycles) = (Vec::new(), Vec::new(), Vec::new());
    let mut nothing = empty.clone();
    (nothing.legs, nothing.cells, nothing.positions_m) = (Vec::new(), Vec::new(), Vec::new());
    nothing.description = String::new();
    let mut single = empty.clone();
    single.poses = whole.poses[..1].to_vec();
    single.tails = whole.tails[..1].to_vec();
    single.cycles = whole.cycles[..1].to_vec();
    let mut constant = whole.clone();
    for pose in &mut constant.poses {
        *pose = PoseSample { t_s: pose.t_s, ..PoseSample::default() };
    }
    for cycle in &mut constant.cycles {
        (cycle.demand, cycle.commanded, cycle.achieved) = Default::default();
        cycle.swings.fill(Default::default());
        cycle.transition_s = 0.0;
        cycle.outcome = "held";
    }
    for sample in &mut constant.tails {
        sample.actual_rad.fill(0.0);
    }
    constant.legs = vec![LegRecord {
        start_s: 0.0,
        end_s: 40.0,
        velocity_m_s: [0.0; 2],
        station_m: None,
        heading_rad: 0.0,
    }];
    let mut broken = whole.clone();
    broken.poses[3].position_m[0] = f64::NAN;
    broken.poses[9].velocity_m_s[1] = f64::INFINITY;
    broken.tails[5].actual_rad[1] = f64::NAN;
    broken.tails[6].actual_rad.truncate(1);
    broken.cycles[2].achieved.as_mut().expect("a wrench").fx_n = f64::NAN;
    broken.cycles[3].swings[0].centerline_rad = f64::NAN;
    broken.cycles[4].swings.truncate(1);
    broken.cycles[4].turns.clear();
    broken.cycles[5].start_s = f64::NAN;
    broken.legs[1].end_s = f64::INFINITY;
    let mut escaped = whole;
    escaped.poses[7].position_m = [1e300, -1e300];
    escaped.poses[8].velocity_m_s = [1e300, 0.0];
    escaped.name = "a name that goes on and on ".repeat(20);
    let runs = [
        ("empty", empty),
        ("nothing", nothing),
        ("single", single),
        ("constant", constant),
        ("broken", broken),
        ("escaped", escaped),
    ];
    for (case, record) in &runs {
        for (name, svg) in pictures(record) {
            assert_sound(&format!("{case}, {name}"), &svg);
        }
    }
}

#[test]
fn long_runs_of_many_modules_stay_small() {
    let record = sample::run(5, 5, 500.0, [[0.03, 0.01]; 2]);
    let pictures = pictures(&record);
    for (name, svg) in &pictures {
        assert_sound(name, svg);
        assert!(svg.len() < 400_000, "{name} has {} bytes", svg.len());
    }
    assert!(pictures[2].1.contains("9 of 25 modules"));
    assert!(pictures[3].1.contains("One behind the other"));
}

#[test]
fn files_are_written_and_a_missing_folder_is_named() {
    let record = sample::run(3, 1, 10.0, SOUTH_EAST);
    let folder = tempfile::tempdir().expect("a folder");
    let files = write_all(&record, folder.path()).into_iter();
    let files: Vec<_> = files.collect::<Result<_, _>>().expect("four pictures");
    let names: Vec<_> = files.iter().filter_map(|f| f.file_name()?.to_str()).collect();
    assert_eq!(names, ["trajectory.svg", "wrench.svg", "tails.svg", "phase-space.svg"]);
    for file in &files {
        assert!(std::fs::read_to_string(file).expect("a text").starts_with("<svg xmlns="));
    }
    let missing = folder.path().join("not/there");
    let errors: Vec<_> =
        write_all(&record, &missing).into_iter().map(|file| file.expect_err("no such folder")).collect();
    assert_eq!(errors.len(), files.len(), "each is named");
    let error = errors[0].to_string();
    assert!(error.contains("not/there") && error.contains("trajectory.svg"), "{error}");
    // One that cannot be written does not keep the others from being so.
    let obstacle = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(obstacle.path().join("wrench.svg")).expect("a folder");
    let outcomes: Vec<bool> = write_all(&record, obstacle.path()).iter().map(Result::is_ok).collect();
    assert_eq!(outcomes, [true, false, true, true]);
}
